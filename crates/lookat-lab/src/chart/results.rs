//! What was measured, and what follows from it.

use std::iter::repeat;

use super::equal::{Curve, EqualValues, equal_errors, equal_times};
use super::estimate::{Estimate, median};
use super::fit::{Fit, RungErrors, fit};
use super::front::{Entry, Reign, front};
use super::method::Method;
use super::point::{Marker, Picture, Point};
use super::reference::Reference;

/// A point tells its method's error if its square is so many times that of the reference's noise or of the level: that is
/// then less than 5 % of the error.
const CLEAR: f64 = 11.0;

/// All pictures.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    /// The methods, in the order in which they are shown.
    pub methods: Vec<&'static Method>,
    /// Each picture, by rung and method.
    pub rows: Vec<Picture>,
    /// For each method its points, from few to many samples.
    pub points: Vec<Vec<Point>>,
    /// How far it came.
    pub end: End,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum End {
    /// With all that was planned.
    #[default]
    Whole,
    /// Without the highest points of the plan, for want of time.
    Late,
    /// When it was told to stop.
    Interrupted,
}

impl Measured {
    /// Whether there is anything to conclude from.
    pub fn has_points(&self) -> bool {
        self.points.iter().any(|points| !points.is_empty())
    }

    /// The median over all pictures of the seconds before the first sample; there must be one.
    pub fn preparation(&self) -> f64 {
        let all: Vec<f64> = self.rows.iter().map(|row| row.preparation).collect();
        median(&all).value
    }
}

/// What follows.
#[derive(Debug, Clone)]
pub struct Results {
    /// What was measured.
    pub measured: Measured,
    /// Other renderers.
    pub markers: Vec<Marker>,
    /// For each method the slope of its error over samples, from the first point to the last above its level and above the
    /// noise of the reference. `None` where these are less than three.
    pub fits: Vec<Option<Fit>>,
    /// For each method the error that it comes down to, if that is more than noise: its bias, where the noise of the
    /// reference is known; else bias or noise of the reference.
    pub levels: Vec<Option<f64>>,
    /// For each method its points, without those that have no error at all.
    pub curves: Vec<Curve>,
    /// The front, of methods and other renderers: who counts on from the methods to the markers.
    pub front: Vec<Reign>,
    /// Errors at equal times.
    pub equal_times: EqualValues,
    /// Times to equal errors, in seconds.
    pub equal_errors: EqualValues,
    /// The mean square of the noise of the reference, if it is known.
    noise_square: Option<f64>,
}

impl Results {
    /// Draws the conclusions.
    pub fn new(measured: Measured, markers: Vec<Marker>, reference: &Reference) -> Results {
        let noise_square = reference.noise.map(|noise| noise * noise);
        let noise = noise_square.unwrap_or(0.0);
        let levels: Vec<Option<f64>> =
            measured.points.iter().map(|points| level_square(points, noise)).collect();
        // Below this, errors are those of the reference, or of the method's own mean.
        let floor = |level: &Option<f64>| noise + level.unwrap_or(0.0);
        let fits = measured.points.iter().zip(&levels).map(|(points, level)| fit_above(points, floor(level)));
        let places = |point: &Point| (point.seconds.value, point.rmse.value);
        let curves: Vec<Curve> =
            measured.points.iter().map(|points| clear_curve(points.iter().map(places))).collect();
        let others = markers.iter().map(|marker| clear_curve([(marker.seconds, marker.means.rmse)]));
        let others: Vec<Curve> = others.collect();
        let uncertainty = |points: &Vec<Point>| {
            (half_interval(points, |point| point.rmse), half_interval(points, |point| point.seconds))
        };
        let uncertainties = measured.points.iter().map(uncertainty).chain(repeat((0.0, 0.0)));
        let entries = curves.iter().chain(&others).zip(uncertainties);
        let entry = |(curve, (of_errors, of_times))| Entry { curve, of_errors, of_times };
        let entries: Vec<Entry> = entries.map(entry).collect();
        Results {
            fits: fits.collect(),
            levels: levels.iter().map(|level| level.map(f64::sqrt)).collect(),
            front: front(&entries),
            equal_times: equal_times(&curves),
            equal_errors: equal_errors(&curves),
            curves,
            noise_square,
            measured,
            markers,
        }
    }

    /// The name of a method or, after those, of another renderer.
    pub fn name(&self, who: usize) -> &str {
        match self.measured.methods.get(who) {
            Some(method) => method.name,
            None => self.markers.get(who - self.measured.methods.len()).map_or("", |marker| &marker.name),
        }
    }

    /// The root mean squared noise of the reference, if it is known.
    pub fn noise(&self) -> Option<f64> {
        self.noise_square.map(f64::sqrt)
    }

    /// Whether the noise of the reference is less than 5 % of a point's error, or unknown.
    pub fn is_clear(&self, rmse: f64) -> bool {
        is_clear(rmse * rmse, self.noise_square.unwrap_or(0.0))
    }
}

fn is_clear(square: f64, floor: f64) -> bool {
    square >= CLEAR * floor
}

/// The mean square of the bias that a method comes down to. A bias that has halved, or more, with the last four times as many
/// samples is still on its way: textures are filtered for the distance of samples.
fn level_square(points: &[Point], noise_square: f64) -> Option<f64> {
    let last = points.last()?;
    let bias = last.level.bias_square(noise_square)?;
    let before = points.iter().rev().find(|point| point.samples <= 0.26 * last.samples);
    let before = before.and_then(|point| point.level.bias_square(noise_square));
    before.is_none_or(|before| bias > 0.5 * before).then_some(bias)
}

/// The slope over the points before the first that is close to the floor, which is a mean square. The last point of a run that
/// is broken off may have fewer pictures than the others; it does not count.
fn fit_above(points: &[Point], floor: f64) -> Option<Fit> {
    let is_whole = |point: &&Point| point.squares.len() == points[0].squares.len();
    let clear = points.iter().take_while(is_whole).take_while(|point| is_clear(point.square(), floor));
    let rungs: Vec<RungErrors> =
        clear.map(|point| RungErrors { samples: point.samples, squares: &point.squares }).collect();
    fit(&rungs)
}

/// The points that logarithmic axes can show.
fn clear_curve(points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    let shown = |point: &(f64, f64)| point.0 > 0.0 && point.1 > 0.0 && point.1.is_finite();
    Curve(points.into_iter().filter(shown).collect())
}

/// Half an interval on a logarithmic scale: the median over the points of a method.
fn half_interval(points: &[Point], of: fn(&Point) -> Estimate) -> f64 {
    let halves = points.iter().map(of).map(|estimate| 0.5 * (estimate.high / estimate.low).ln());
    let halves: Vec<f64> = halves.filter(|half| half.is_finite()).collect();
    if halves.is_empty() { 0.0 } else { median(&halves).value }
}

#[cfg(test)]
mod tests {
    use lookat_image::{Means, means};

    use super::super::level::Level;
    use super::super::method::METHODS;
    use super::super::reference::Origin;
    use super::*;

    /// A point of variance 1 / samples and a bias, without scatter.
    fn point(samples: u32, bias: f64) -> Point {
        let square = 1.0 / f64::from(samples) + bias * bias;
        let exact = |value: f64| Estimate { value, low: value, high: value };
        Point {
            rung: samples,
            samples: f64::from(samples),
            seconds: exact(f64::from(samples)),
            rmse: exact(square.sqrt()),
            relative_mse: exact(square),
            error: exact(0.0),
            level: Level { square: bias * bias, standard_error: 1e-6, mean: 0.0, mean_standard_error: 1e-3 },
            squares: vec![square; 8],
        }
    }

    fn results(noise: Option<f64>) -> Results {
        let ladder = |bias| (0..10).map(|i| point(1 << i, bias)).collect();
        let measured = Measured {
            methods: vec![&METHODS[0], &METHODS[4]],
            points: vec![ladder(noise.unwrap_or(0.0)), ladder(0.1)],
            ..Measured::default()
        };
        let origin = Origin::Rendered { samples: 1, seed: 0, seconds: 0.0 };
        let marker = |name: &str, seconds, rmse| Marker {
            name: name.into(),
            seconds,
            means: Means { rmse, ..means(&[[0.0; 3]], &[[0.0; 3]]) },
            rounded: false,
        };
        let markers = vec![marker("slow", 100.0, 0.5), marker("fast", 0.5, 0.9)];
        Results::new(measured, markers, &Reference { pixels: Vec::new(), noise, origin })
    }

    #[test]
    fn bias_is_named_and_kept_out_of_the_slope() {
        let found = results(Some(0.0));
        assert_eq!(found.levels[0], None);
        assert!((found.levels[1].unwrap() - 0.1).abs() < 1e-9);
        assert!((found.fits[0].unwrap().slope + 0.5).abs() < 1e-9);
        // 1 / n + 0.01 is at least 11 times 0.01 up to 8 samples.
        let biased = found.fits[1].unwrap();
        assert!(biased.rungs == 4 && (-0.5..-0.48).contains(&biased.slope), "{biased:?}");
    }

    #[test]
    fn a_bias_that_falls_is_no_level() {
        let falling = |power: f64| -> Vec<Point> {
            (0..8).map(|i| point(1 << i, 0.2 * f64::from(1 << i).powf(power))).collect()
        };
        assert_eq!(level_square(&falling(-0.5), 0.0), None);
        assert!((level_square(&falling(0.0), 0.0).unwrap() - 0.04).abs() < 1e-9);
        // Too few to tell.
        assert!(level_square(&falling(-0.5)[..2], 0.0).is_some());
    }

    #[test]
    fn noise_of_the_reference_is_no_bias() {
        let found = results(Some(0.05));
        assert_eq!(found.levels[0], None);
        // Up to 32 samples.
        assert_eq!(found.fits[0].unwrap().rungs, 6);
        assert!(found.is_clear(0.2) && !found.is_clear(0.1));
    }

    #[test]
    fn a_point_of_fewer_pictures_is_no_part_of_the_slope() {
        let mut points: Vec<Point> = (0..5).map(|i| point(1 << i, 0.0)).collect();
        points[4].squares.truncate(6);
        let found = fit_above(&points, 0.0).unwrap();
        assert!(found.rungs == 4 && (found.slope + 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn others_are_on_the_front_if_nothing_beats_them() {
        let found = results(Some(0.0));
        let names: Vec<&str> = found.front.iter().map(|reign| found.name(reign.who)).collect();
        assert_eq!(names, ["fast", "random"]);
    }
}
