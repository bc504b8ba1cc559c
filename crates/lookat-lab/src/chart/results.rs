//! What follows from the measurements.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use lookat_image::{Means, means};
use serde::Serialize;
use serde_json::{Value, json};

use super::measure::{End, Measured, Picture, Point};
use super::method::Method;
use super::reference::{Fitted, Origin, Reference, is_clear};
use crate::estimate::Slope;

/// The fewest standard errors of a bias.
const SIGNIFICANT: f64 = 4.0;
/// The most columns of a table.
const COLUMNS: usize = 6;

/// Seconds and error, by rising samples.
type Curve = Vec<(f64, f64)>;

/// The results, as in `chart.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Chart {
    /// The name and version of this program.
    pub program: &'static str,
    /// The version of this program.
    pub version: &'static str,
    /// The scene, and how it was rendered.
    #[serde(flatten)]
    pub setup: ChartSetup,
    /// The picture that errors are relative to.
    pub reference: Value,
    /// The noise of the reference: the root of its mean squared standard error, if known. It adds to all errors.
    #[serde(skip)]
    pub noise: Option<f64>,
    /// True if all planned points are there.
    pub complete: bool,
    /// True if a signal ended the measurement.
    pub interrupted: bool,
    /// The methods.
    pub methods: Vec<MethodResult>,
    /// Other renderers.
    #[serde(rename = "points")]
    pub others: Vec<OtherResult>,
    /// The Pareto front: the points that no other point beats in both time and error, by rising time.
    pub front: Vec<FrontPoint>,
    /// The error of each method after equal times.
    pub equal_time: EqualTable,
    /// The time of each method to equal errors.
    pub equal_error: EqualTable,
}

/// The scene of a chart, and how it was rendered.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ChartSetup {
    /// The scene file.
    pub scene: String,
    /// Width and height of the rendered part in pixels.
    pub size: [u32; 2],
    /// Number of threads.
    pub threads: usize,
    /// The seed of the first picture.
    pub seed: u64,
    /// Pictures per point.
    pub seeds_per_point: u32,
    /// Wall time of reading the scene in seconds.
    pub parse_seconds: f64,
    /// Wall time of preparing the scene in seconds.
    pub preparation_seconds: f64,
}

/// The results of a method.
#[derive(Debug, Clone, Serialize)]
pub struct MethodResult {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub about: &'static str,
    /// Its points, by rising samples.
    pub points: Vec<Point>,
    /// The slope of its error over the points that are clear of its bias and of the noise of the reference. `None` for fewer
    /// than three.
    pub slope: Option<Slope>,
    /// Its bias, if significant. Without a known noise of the reference: bias or that noise.
    pub levels_off_at: Option<f64>,
}

/// The result of another renderer.
#[derive(Debug, Clone, Serialize)]
pub struct OtherResult {
    /// Its name.
    pub name: String,
    /// Its wall time in seconds.
    pub seconds: f64,
    /// Root mean squared error.
    pub rmse: f64,
    /// Relative mean squared error.
    pub relative_mse: f64,
    /// Mean signed error.
    pub mean_error: f64,
    /// True for 8 or 16 bits per channel: rounded, and clipped at white.
    pub stored_as_integers: bool,
    /// The seconds of each method to the same error; `None` if its points do not span the error.
    pub lookat_seconds_to_same_rmse: BTreeMap<&'static str, Option<f64>>,
}

/// A point of the Pareto front.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrontPoint {
    /// The method or the other renderer.
    pub name: String,
    /// Its time.
    pub seconds: f64,
    /// Its root mean squared error.
    pub rmse: f64,
}

/// What each method has at a few places: errors at times, or times at errors.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct EqualTable {
    /// The places.
    pub at: Vec<f64>,
    /// The values of each method; `None` if its points do not span the place.
    pub values: BTreeMap<&'static str, Vec<Option<f64>>>,
}

impl Chart {
    /// The results of a measurement.
    pub fn new(
        setup: ChartSetup,
        methods: &[&'static Method],
        measured: &Measured,
        reference: &Reference,
    ) -> Chart {
        let of_method =
            |(method, points): (&&'static Method, &Vec<Point>)| of_method(method, points, reference);
        let methods: Vec<MethodResult> = methods.iter().zip(&measured.points).map(of_method).collect();
        let curves: Vec<Curve> = methods.iter().map(MethodResult::curve).collect();
        let inverse = |curve: &Curve| curve.iter().map(|(seconds, error)| (*error, *seconds)).collect();
        let by_error: Vec<Curve> = curves.iter().map(inverse).collect();
        let mut chart = Chart {
            program: "lookat",
            version: env!("CARGO_PKG_VERSION"),
            setup,
            reference: of_reference(reference),
            noise: reference.noise,
            complete: measured.end == End::Complete,
            interrupted: measured.end == End::Interrupted,
            front: Vec::new(),
            equal_time: equal(&methods, &curves, |_| ()),
            equal_error: equal(&methods, &by_error, |errors| errors.reverse()),
            methods,
            others: Vec::new(),
        };
        chart.front = chart.pareto();
        chart
    }

    /// Adds the picture of another renderer.
    pub fn add(&mut self, name: &str, seconds: f64, picture: &Fitted, reference: &Reference) {
        let Means { rmse, relative_mse, error, .. } = means(&picture.pixels, &reference.pixels);
        let to_same = |method: &MethodResult| (method.name, method.seconds_to(rmse));
        self.others.push(OtherResult {
            name: name.into(),
            seconds,
            rmse,
            relative_mse,
            mean_error: error,
            stored_as_integers: picture.rounded,
            lookat_seconds_to_same_rmse: self.methods.iter().map(to_same).collect(),
        });
        self.front = self.pareto();
    }

    /// True if the noise of the reference is less than 5 % of an error, or unknown.
    pub fn is_clear(&self, rmse: f64) -> bool {
        is_clear(rmse * rmse, self.noise.unwrap_or(0.0).powi(2))
    }

    fn pareto(&self) -> Vec<FrontPoint> {
        let point = |name: &str, (seconds, rmse)| FrontPoint { name: name.into(), seconds, rmse };
        let own = self
            .methods
            .iter()
            .flat_map(|method| method.curve().into_iter().map(move |place| point(method.name, place)));
        let others = self.others.iter().map(|other| point(&other.name, (other.seconds, other.rmse)));
        let mut all: Vec<FrontPoint> = own.chain(others).filter(|point| point.rmse > 0.0).collect();
        all.sort_by(|a, b| {
            (a.seconds, a.rmse).partial_cmp(&(b.seconds, b.rmse)).unwrap_or(a.rmse.total_cmp(&b.rmse))
        });
        let mut least = f64::INFINITY;
        all.retain(|point| {
            let is_better = point.rmse < least;
            least = least.min(point.rmse);
            is_better
        });
        all
    }
}

impl MethodResult {
    /// Seconds and error of the points that logarithmic axes can show.
    pub fn curve(&self) -> Curve {
        let places = self.points.iter().map(|point| (point.seconds.value, point.rmse.value));
        places.filter(|(seconds, error)| *seconds > 0.0 && *error > 0.0 && error.is_finite()).collect()
    }

    /// The seconds until the error is this small for the first time. `None` outside the points.
    pub fn seconds_to(&self, rmse: f64) -> Option<f64> {
        interpolated(&self.curve().into_iter().map(|(seconds, error)| (error, seconds)).collect(), rmse)
    }
}

fn of_method(method: &Method, points: &[Point], reference: &Reference) -> MethodResult {
    let noise_square = reference.noise_square();
    // What all pictures share is the noise of the reference, or more than that.
    let bias = points.last().map(|last| last.common_square_error).and_then(|common| {
        let rest = common.value - noise_square;
        (rest > noise_square && rest > SIGNIFICANT * common.standard_error).then_some(rest)
    });
    let floor = noise_square + bias.unwrap_or(0.0);
    // The last point of an interrupted measurement may have fewer pictures.
    let is_clear =
        |point: &&Point| point.pictures == points[0].pictures && is_clear(point.rmse.value.powi(2), floor);
    let clear = points.iter().take_while(is_clear);
    let clear: Vec<_> = clear.map(|point| (point.samples_taken, &point.squares[..])).collect();
    MethodResult {
        name: method.name,
        about: method.about,
        points: points.to_vec(),
        slope: Slope::new(&clear),
        levels_off_at: bias.map(f64::sqrt),
    }
}

fn of_reference(reference: &Reference) -> Value {
    let mut value = match &reference.origin {
        Origin::Rendered { samples, seed, seconds } => {
            json!({"samples_per_pixel": samples, "sampler": "sobol", "seed": seed, "seconds": seconds})
        }
        Origin::File { path, rounded } => json!({"file": path, "stored_as_integers": rounded}),
    };
    value["rms_standard_error"] = reference.noise.into();
    value
}

/// The second coordinate where a line through points, straight on logarithmic axes, first comes to a first coordinate.
fn interpolated(points: &Curve, at: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        if !(a.0.min(b.0)..=a.0.max(b.0)).contains(&at) {
            return None;
        }
        let share = if a.0 == b.0 { 0.0 } else { (at / a.0).ln() / (b.0 / a.0).ln() };
        Some((a.1.ln() + share * (b.1 / a.1).ln()).exp())
    })
}

/// The values of all curves at round numbers in the range of the first one, in the order that `arrange` gives them.
fn equal(methods: &[MethodResult], curves: &[Curve], arrange: fn(&mut Vec<f64>)) -> EqualTable {
    let first = || curves.iter().take(1).flatten().map(|point| point.0);
    let range = first().fold(f64::INFINITY, f64::min)..=first().fold(0.0, f64::max);
    let mut at = if range.is_empty() { Vec::new() } else { round_numbers(&range, COLUMNS) };
    arrange(&mut at);
    let values = |(method, curve): (&MethodResult, &Curve)| {
        (method.name, at.iter().map(|at| interpolated(curve, *at)).collect())
    };
    EqualTable { values: methods.iter().zip(curves).map(values).collect(), at }
}

/// Numbers 1, 2, 5, 10, ... within a positive range; with fewer than three also 1.5, 3 and 7. Leaves some out if there are more
/// than `most`.
pub(super) fn round_numbers(range: &RangeInclusive<f64>, most: usize) -> Vec<f64> {
    let multiples = |numbers: &[&str]| -> Vec<f64> {
        let decades = range.start().log10().floor() as i32..=range.end().log10().floor() as i32;
        // Parsed, a number has no rounding error in its last digit.
        let all =
            decades.flat_map(|decade| numbers.iter().map(move |number| format!("{number}e{decade}").parse()));
        all.filter_map(Result::ok).filter(|number| range.contains(number)).collect()
    };
    let coarse = multiples(&["1", "2", "5"]);
    let all = if coarse.len() < 3 { multiples(&["1", "1.5", "2", "3", "5", "7"]) } else { coarse };
    let step = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(step).collect()
}

/// A line for each picture, after a line of names. Only the times differ from run to run.
pub fn as_csv(chart: &Chart, pictures: &[Picture]) -> String {
    let mut text =
        String::from("method,samples_per_pixel,seed,samples_taken,seconds,rmse,relative_mse,mean_error\n");
    for Picture { method, samples_per_pixel, samples_taken, seed, seconds, means } in pictures {
        let (name, Means { rmse, relative_mse, error, .. }) = (chart.methods[*method].name, means);
        text += &format!(
            "{name},{samples_per_pixel},{seed},{samples_taken},{seconds:e},{rmse:e},{relative_mse:e},{error:e}\n"
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::measure::CommonSquare;
    use super::super::method::METHODS;
    use super::*;
    use crate::estimate::Estimate;

    /// Points of variance 1 / samples and a bias, without scatter; a sample takes a second.
    fn points(bias: f64) -> Vec<Point> {
        let exact = |value: f64| Estimate { value, interval: [value; 2] };
        let square = |samples: u32| 1.0 / f64::from(samples) + bias * bias;
        let point = |samples: u32| Point {
            samples_per_pixel: samples,
            samples_taken: samples.into(),
            pictures: 8,
            seconds: exact(samples.into()),
            rmse: exact(square(samples).sqrt()),
            relative_mse: exact(0.0),
            mean_error: exact(0.0),
            common_square_error: CommonSquare { value: bias * bias, standard_error: 1e-6 },
            above_reference_noise: true,
            squares: vec![square(samples); 8],
        };
        (0..10).map(|i| point(1 << i)).collect()
    }

    fn chart(noise: Option<f64>) -> Chart {
        let points = vec![points(noise.unwrap_or(0.0)), points(0.1)];
        let measured = Measured { points, ..Measured::default() };
        let origin = Origin::Rendered { samples: 1, seed: 0, seconds: 0.0 };
        let reference = Reference { pixels: vec![[0.0; 3]], noise, origin };
        let mut chart = Chart::new(ChartSetup::default(), &[&METHODS[0], &METHODS[4]], &measured, &reference);
        for (name, seconds, rmse) in [("slow", 100.0, 0.5), ("fast", 0.5, 0.9)] {
            let picture = Fitted { pixels: vec![[rmse; 3]], noise: None, rounded: false };
            chart.add(name, seconds, &picture, &reference);
        }
        chart
    }

    #[test]
    fn a_slope_leaves_out_points_near_the_bias() {
        let found = chart(Some(0.0));
        let [plain, biased] = &found.methods[..] else { panic!() };
        assert_eq!(plain.levels_off_at, None);
        assert!((biased.levels_off_at.unwrap() - 0.1).abs() < 1e-9);
        assert!((plain.slope.unwrap().slope + 0.5).abs() < 1e-9);
        // 1 / n + 0.01 is at least 11 times 0.01 up to 8 samples.
        let slope = biased.slope.unwrap();
        assert!(slope.points == 4 && (-0.5..-0.48).contains(&slope.slope), "{slope:?}");
    }

    #[test]
    fn noise_of_the_reference_is_no_bias() {
        let found = chart(Some(0.05));
        assert_eq!(found.methods[0].levels_off_at, None);
        // Up to 32 samples.
        assert_eq!(found.methods[0].slope.unwrap().points, 6);
        assert!(found.is_clear(0.2) && !found.is_clear(0.1));
    }

    #[test]
    fn the_front_has_the_points_that_none_beats() {
        let front = chart(Some(0.0)).front;
        assert_eq!((front[0].name.as_str(), front.len()), ("fast", 10));
        assert!(front[1..].iter().all(|point| point.name == "random"), "{front:?}");
        // 1 sample is later and less exact than fast.
        assert_eq!(front[1].seconds, 2.0);
    }

    #[test]
    fn values_between_points_are_straight_on_logarithmic_axes() {
        let found = chart(Some(0.0));
        let power = &found.methods[0];
        assert!((power.seconds_to(0.1).unwrap() - 100.0).abs() < 1e-9);
        assert_eq!([power.seconds_to(1.1), power.seconds_to(0.01)], [None, None]);
        assert_eq!(found.equal_time.at, [1.0, 5.0, 20.0, 100.0, 500.0]);
        let at_20 = found.equal_time.values["random"][2].unwrap();
        assert!((at_20 - 20.0_f64.sqrt().recip()).abs() < 1e-12);
        assert_eq!(found.equal_error.at, [1.0, 0.5, 0.2, 0.1, 0.05]);
        assert!((found.equal_error.values["random"][3].unwrap() - 100.0).abs() < 1e-9);
        assert_eq!(found.equal_error.values["direct-all"][3..], [None, None]);
    }

    #[test]
    fn round_numbers_are_few() {
        assert_eq!(round_numbers(&(0.9..=5.0), 6), [1.0, 2.0, 5.0]);
        assert_eq!(round_numbers(&(3e-4..=1.0), 6).len(), 6);
        assert_eq!(round_numbers(&(1.1..=5.1), 6), [1.5, 2.0, 3.0, 5.0]);
        assert!(round_numbers(&(1.1..=1.4), 6).is_empty());
    }
}
