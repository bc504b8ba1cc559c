//! Plans the points of a chart, renders their pictures, and measures time and error.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use lookat_image::{Means, means};
use lookat_render::{Prepared, Progress, REPLICATES, Rendered, Settings};
use lookat_scene::{Sampler, Scene, View};
use serde::Serialize;

use super::method::{Method, REFERENCE};
use super::reference::{Origin, Reference, is_clear, noise};
use crate::estimate::{Estimate, mean, mean_and_error};
use crate::timed;

/// The fewest pictures of a point.
pub const FEWEST_SEEDS: u32 = 8;
/// The most points of a method: 1 to 65,536 samples per pixel, the length of Sobol's sequence.
pub const MOST_POINTS: u32 = 17;
/// The fewest points of a method: a slope needs as many.
const FEWEST_POINTS: u32 = 3;
/// Samples of a rendered reference over those of the largest point. Each of its replicates has the samples of that point, so
/// its variance is a sixteenth of that point's.
const REFERENCE_FACTOR: u32 = REPLICATES;
/// The time that a run may take, relative to its budget.
const LATE: f64 = 1.15;

/// Called from any thread with the finished share of the work, from 0 to 1. Ends the work with `Break`.
pub type Watch<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// Renders views of one scene, which it prepares once.
pub struct Renderer {
    prepared: Prepared,
    view: View,
    /// Wall time of preparing the scene in seconds.
    pub preparation: f64,
}

impl Renderer {
    /// Prepares a scene.
    pub fn new(scene: &Scene) -> Renderer {
        let (preparation, prepared) = timed(|| Prepared::new(scene));
        Renderer { prepared, view: scene.view.clone(), preparation }
    }

    /// The picture of a method, and its wall time in seconds. `None` if `watch` breaks.
    fn render(&self, method: &Method, samples: u32, seed: u64, watch: Watch) -> Option<(Rendered, f64)> {
        let mut view = self.view.clone();
        (method.change)(&mut view);
        view.sampler = Sampler { samples_per_pixel: 1, ..view.sampler }.with_samples(samples);
        let settings = Settings { seed, stop: (method.stop)(samples), ..Settings::default() };
        let watch_share = |progress: Progress| watch(progress.done as f64 / progress.total.max(1) as f64);
        let (seconds, rendered) = timed(|| self.prepared.render(&view, &settings, &watch_share));
        // A break may come after the last tile.
        (rendered.complete && watch(1.0).is_continue()).then_some((rendered, seconds))
    }

    /// A picture to measure errors with, by the scene's integrator. `None` if `watch` breaks.
    pub fn reference(&self, samples: u32, seed: u64, watch: Watch) -> Option<Reference> {
        let (rendered, seconds) = self.render(&REFERENCE, samples, seed, watch)?;
        let noise = noise(&rendered.image.errors()?);
        let origin = Origin::Rendered { samples, seed, seconds };
        Some(Reference { pixels: rendered.image.rgb()?, noise, origin })
    }

    /// The seconds per sample of each pixel. Doubles the samples until a picture takes at least `seconds`; the last one may
    /// take twice as long. `None` if `watch` breaks.
    pub fn seconds_per_sample(&self, method: &Method, seconds: f64, watch: Watch) -> Option<f64> {
        // The first picture is slower than others.
        self.render(method, method.first, 0, watch)?;
        let mut samples = method.first;
        loop {
            // Of two, in case other work slows one down.
            let [one, other] =
                [self.render(method, samples, 0, watch)?.1, self.render(method, samples, 0, watch)?.1];
            let faster = one.min(other);
            if faster >= seconds || samples >= 1 << (MOST_POINTS - 1) {
                return Some(faster / f64::from(samples));
            }
            samples *= 2;
        }
    }
}

/// The points of a chart: each method goes from its first samples per pixel to the largest, by doubling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The largest samples per pixel, a power of two. A method whose first point has more than a quarter of that has three
    /// points all the same.
    pub largest: u32,
    /// The pictures of each point, which differ in their seeds.
    pub seeds: u32,
    /// Whether the reference must be rendered.
    pub renders_reference: bool,
}

impl Plan {
    /// The largest plan that takes at most so many seconds. `costs` are seconds per sample: of the methods, then of the reference
    /// unless it is given.
    ///
    /// # Errors
    ///
    /// The seconds of the smallest plan, if that is more than 1.15 times as long.
    pub fn within(seconds: f64, methods: &[&Method], costs: &[f64], seeds: u32) -> Result<(Plan, f64), f64> {
        let renders_reference = costs.len() > methods.len();
        let plan = |largest| Plan { largest, seeds, renders_reference };
        let time = |plan: Plan| -> f64 {
            plan.samples(methods).iter().zip(costs).map(|(samples, cost)| samples * cost).sum()
        };
        let smallest = plan(1 << (FEWEST_POINTS - 1));
        if time(smallest) > LATE * seconds {
            return Err(time(smallest));
        }
        let larger = (FEWEST_POINTS..MOST_POINTS).map(|power| plan(1 << power));
        let plan = larger.take_while(|plan| time(*plan) <= seconds).last().unwrap_or(smallest);
        Ok((plan, time(plan)))
    }

    /// The number of points of a method.
    pub fn points(&self, method: &Method) -> u32 {
        (self.largest / method.first).checked_ilog2().map_or(0, |power| power + 1).max(FEWEST_POINTS)
    }

    /// The samples per pixel of the last point of a method.
    pub fn last(&self, method: &Method) -> u32 {
        method.first << (self.points(method) - 1)
    }

    /// Samples per pixel of the reference.
    pub fn reference_samples(&self, methods: &[&Method]) -> u32 {
        REFERENCE_FACTOR * methods.iter().map(|method| self.last(method)).max().unwrap_or(1)
    }

    /// Samples per pixel of all pictures: of each method, then of a rendered reference.
    pub fn samples(&self, methods: &[&Method]) -> Vec<f64> {
        let all = |method: &&Method| f64::from(self.seeds) * f64::from(2 * self.last(method) - method.first);
        let reference = self.renders_reference.then(|| f64::from(self.reference_samples(methods)));
        methods.iter().map(all).chain(reference).collect()
    }

    /// The seed of a picture. Points have seeds of their own, so that their errors are independent.
    fn seed(&self, first: u64, point: u32, index: u32) -> u64 {
        first.wrapping_add(u64::from(point) * u64::from(self.seeds) + u64::from(index))
    }

    /// The seed of the reference, beyond those of all pictures.
    pub fn reference_seed(&self, first: u64) -> u64 {
        self.seed(first, MOST_POINTS, 0)
    }
}

/// One picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picture {
    /// The index of its method.
    pub method: usize,
    /// Requested samples per pixel.
    pub samples_per_pixel: u32,
    /// Samples per pixel that were taken.
    pub samples_taken: f64,
    /// The seed.
    pub seed: u64,
    /// Wall time of rendering in seconds.
    pub seconds: f64,
    /// Its errors.
    pub means: Means,
}

/// The pictures of one method with the same samples per pixel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Requested samples per pixel.
    pub samples_per_pixel: u32,
    /// Samples per pixel that were taken, a mean.
    pub samples_taken: f64,
    /// The number of pictures.
    pub pictures: usize,
    /// Seconds of a picture, the median.
    pub seconds: Estimate,
    /// Root mean squared error.
    pub rmse: Estimate,
    /// Relative mean squared error.
    pub relative_mse: Estimate,
    /// Mean signed error.
    pub mean_error: Estimate,
    /// The squared error that all pictures share: bias and the noise of the reference.
    pub common_square_error: CommonSquare,
    /// True if the noise of the reference is less than 5 % of the error, or unknown.
    pub above_reference_noise: bool,
    /// The squared error of each picture.
    #[serde(skip)]
    pub squares: Vec<f64>,
}

/// An estimate of the squared error that all pictures share. It may be negative.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CommonSquare {
    /// The estimate.
    pub value: f64,
    /// Its standard error, from the scatter over pixels.
    pub standard_error: f64,
}

/// The pictures of a point so far, with sums of the errors of each channel of each pixel and of their squares.
#[derive(Default)]
struct Pictures {
    all: Vec<Picture>,
    sums: Vec<[f64; 2]>,
}

impl Pictures {
    fn add(&mut self, picture: Picture, actual: &[[f32; 3]], expected: &[[f32; 3]]) {
        self.all.push(picture);
        let (actual, expected) = (actual.as_flattened(), expected.as_flattened());
        self.sums.resize(actual.len(), [0.0; 2]);
        for (sum, (actual, expected)) in self.sums.iter_mut().zip(actual.iter().zip(expected)) {
            let error = f64::from(*actual) - f64::from(*expected);
            *sum = [sum[0] + error, sum[1] + error * error];
        }
    }

    /// From the mean product of the errors of two pictures. At least two pictures.
    fn common_square(&self) -> CommonSquare {
        let count = self.all.len() as f64;
        let product = |[sum, squares]: &[f64; 2]| (sum * sum - squares) / (count * (count - 1.0));
        let of_pixel = |channels: &[[f64; 2]]| channels.iter().map(product).sum::<f64>() / 3.0;
        let (value, standard_error) = mean_and_error(&self.sums.chunks(3).map(of_pixel).collect::<Vec<_>>());
        CommonSquare { value, standard_error }
    }

    fn point(&self, reference: &Reference) -> Point {
        let all = |value: fn(&Picture) -> f64| self.all.iter().map(value).collect::<Vec<f64>>();
        let squares = all(|picture| picture.means.rmse.powi(2));
        let square = Estimate::mean(&squares);
        Point {
            samples_per_pixel: self.all[0].samples_per_pixel,
            samples_taken: mean(&all(|picture| picture.samples_taken)),
            pictures: self.all.len(),
            seconds: Estimate::median(&all(|picture| picture.seconds)),
            rmse: square.root(),
            relative_mse: Estimate::mean(&all(|picture| picture.means.relative_mse)),
            mean_error: Estimate::mean(&all(|picture| picture.means.error)),
            common_square_error: self.common_square(),
            above_reference_noise: is_clear(square.value, reference.noise_square()),
            squares,
        }
    }
}

/// How a measurement ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum End {
    /// With all points.
    #[default]
    Complete,
    /// Without the last points, for lack of time.
    Late,
    /// Without the last points, because `watch` broke.
    Interrupted,
}

/// What was measured.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    /// All pictures, by point and method.
    pub pictures: Vec<Picture>,
    /// The points of each method, by rising samples.
    pub points: Vec<Vec<Point>>,
    /// How it ended.
    pub end: End,
}

/// What to measure.
#[derive(Debug, Clone, Copy)]
pub struct Measurement<'a> {
    /// The methods.
    pub methods: &'a [&'static Method],
    /// Their points.
    pub plan: Plan,
    /// The seed of the first picture.
    pub seed: u64,
    /// The picture that errors are relative to.
    pub reference: &'a Reference,
    /// The start and the length in seconds of a run that must end; `None` for as long as it takes.
    pub budget: Option<(Instant, f64)>,
}

impl Measurement<'_> {
    /// Renders the points, all methods with few samples before any with more. The methods take turns after each picture, so that
    /// a machine that slows down favors none. If `watch` breaks, and after 1.15 times the budget with at least three points of
    /// each method, drops the unfinished picture and ends.
    pub fn run(&self, renderer: &mut Renderer, watch: Watch) -> Measured {
        let mut measured = Measured { points: vec![Vec::new(); self.methods.len()], ..Measured::default() };
        let all: f64 = self.plan.samples(self.methods)[..self.methods.len()].iter().sum();
        let mut done = 0.0;
        for point in 0..MOST_POINTS {
            let is_late = || {
                point >= FEWEST_POINTS
                    && self.budget.is_some_and(|(started, seconds)| {
                        started.elapsed() > Duration::from_secs_f64(LATE * seconds)
                    })
            };
            let mut pictures: Vec<Pictures> = self.methods.iter().map(|_| Pictures::default()).collect();
            let is_whole = self.turns(point).into_iter().all(|(method, seed)| {
                let samples = self.methods[method].first << point;
                let watch_picture = |share: f64| {
                    let share = (done + share * f64::from(samples)) / all;
                    if is_late() { ControlFlow::Break(()) } else { watch(share) }
                };
                let rendered = renderer.render(self.methods[method], samples, seed, &watch_picture);
                let Some((rendered, seconds)) = rendered else { return false };
                done += f64::from(samples);
                let pixels = rendered.image.rgb().unwrap_or_default();
                let picture = Picture {
                    method,
                    samples_per_pixel: samples,
                    samples_taken: rendered.statistics.samples as f64 / pixels.len() as f64,
                    seed,
                    seconds,
                    means: means(&pixels, &self.reference.pixels),
                };
                pictures[method].add(picture, &pixels, &self.reference.pixels);
                true
            });
            for (pictures, points) in pictures.iter().zip(&mut measured.points) {
                measured.pictures.extend(&pictures.all);
                if pictures.all.len() >= self.plan.seeds.min(FEWEST_SEEDS) as usize {
                    points.push(pictures.point(self.reference));
                }
            }
            if !is_whole {
                measured.end = if watch(1.0).is_break() { End::Interrupted } else { End::Late };
                break;
            }
        }
        measured
    }

    /// The method and the seed of each picture of a point, in the order of rendering.
    fn turns(&self, point: u32) -> Vec<(usize, u64)> {
        let active: Vec<usize> =
            (0..self.methods.len()).filter(|i| self.plan.points(self.methods[*i]) > point).collect();
        let turn = |(index, turn): (u32, usize)| {
            (active[(turn + index as usize) % active.len()], self.plan.seed(self.seed, point, index))
        };
        let seeds = (0..self.plan.seeds).flat_map(|index| (0..active.len()).map(move |turn| (index, turn)));
        seeds.map(turn).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::super::method::{METHODS, named};
    use super::*;
    use crate::text_scene::scene;

    #[test]
    fn plans_keep_to_the_budget() {
        let methods = [named("random").unwrap(), named("sobol").unwrap()];
        // 8 seeds of 1 to 128 samples at 1 ms are 8 * 0.255 s, twice that, and 2048 samples of the reference.
        let (plan, seconds) = Plan::within(7.0, &methods, &[1e-3; 3], 8).unwrap();
        assert_eq!((plan.largest, plan.reference_samples(&methods)), (128, 2048));
        assert!((seconds - (2.0 * 8.0 * 0.255 + 2.048)).abs() < 1e-9, "{seconds}");
        // Without a reference there is time for more.
        assert_eq!(Plan::within(8.5, &methods, &[1e-3; 2], 8).unwrap().0.largest, 256);
        let smallest = Plan::within(0.01, &methods, &[1e-3; 2], 8).unwrap_err();
        assert!((smallest - 2.0 * 8.0 * 7e-3).abs() < 1e-12, "{smallest}");
        assert_eq!(Plan::within(1.0, &methods, &[0.0; 2], 8).unwrap().0.largest, 1 << 16);
        // At least three points.
        let target = named("target-error").unwrap();
        let plan = Plan { largest: 4, seeds: 8, renders_reference: true };
        assert_eq!((plan.points(target), plan.last(target)), (3, 256));
        assert_eq!(plan.samples(&[target]), [8.0 * 448.0, 16.0 * 256.0]);
        assert!(METHODS.iter().all(|method| plan.last(method) <= 1 << 16));
    }

    const POINTS: u32 = 5;

    /// What two methods measure of a small scene with ten pictures per point. `watch` breaks after so many calls, which the
    /// second value counts.
    fn measured(calls: u32, budget: Option<f64>) -> (Measured, u32) {
        let scene = scene(
            r#"Camera "perspective" Film "image" "integer xresolution" 8 "integer yresolution" 6
            WorldBegin LightSource "point" Translate 0 0 4 Shape "sphere" WorldEnd"#,
        );
        let mut renderer = Renderer::new(&scene);
        let reference = renderer.reference(64, 1000, &|_| ControlFlow::Continue(())).unwrap();
        let measurement = Measurement {
            methods: &[named("random").unwrap(), named("sobol").unwrap()],
            plan: Plan { largest: 1 << (POINTS - 1), seeds: 10, renders_reference: false },
            seed: 1,
            reference: &reference,
            budget: budget.map(|seconds| (Instant::now(), seconds)),
        };
        let asked = AtomicU32::new(0);
        let watch = |_| {
            let stops = asked.fetch_add(1, Ordering::Relaxed) >= calls;
            if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        (measurement.run(&mut renderer, &watch), asked.load(Ordering::Relaxed))
    }

    /// All but the times.
    fn errors(measured: &Measured, method: usize) -> Vec<(u32, u64, f64)> {
        let pictures = measured.pictures.iter().filter(|picture| picture.method == method);
        pictures.map(|picture| (picture.samples_per_pixel, picture.seed, picture.means.rmse)).collect()
    }

    #[test]
    fn an_interrupt_keeps_earlier_pictures() {
        let (whole, asked) = measured(u32::MAX, None);
        assert_eq!((whole.end, whole.pictures.len()), (End::Complete, 2 * 10 * POINTS as usize));
        let mut lengths = Vec::new();
        // At the start, in the first point, in the last one before and after it has eight pictures.
        for stop in [0, asked / 40, asked * 17 / 20, asked * 79 / 80] {
            let (part, _) = measured(stop, None);
            assert_eq!(part.end, End::Interrupted);
            for method in 0..2 {
                let (part_of, whole_of) = (errors(&part, method), errors(&whole, method));
                assert_eq!(part_of[..], whole_of[..part_of.len()]);
                assert_eq!(part.points[method].len(), (part_of.len() + 2) / 10);
            }
            lengths.push(part.pictures.len());
        }
        assert!(lengths[0] == 0 && lengths[1] < 20 && lengths[2] > 80 && lengths.is_sorted(), "{lengths:?}");
        assert!((96..100).contains(&lengths[3]), "{lengths:?}");
    }

    #[test]
    fn a_spent_budget_leaves_three_points() {
        let (found, _) = measured(u32::MAX, Some(0.0));
        assert_eq!(found.end, End::Late);
        assert!(found.points.iter().all(|points| points.len() == FEWEST_POINTS as usize));
        assert_eq!(found.pictures.len(), 2 * 10 * FEWEST_POINTS as usize);
    }

    /// Eight pictures of uniform noise, with a bias of alternating sign.
    #[test]
    fn pictures_share_their_bias_but_no_noise() {
        let pixels = 10_000;
        for bias in [0.0, 0.05] {
            let mut random = Pcg64Mcg::seed_from_u64(3);
            let mut pictures = Pictures::default();
            let expected = vec![[0.0; 3]; pixels];
            for _ in 0..8 {
                let mut pixel = |i: usize| {
                    let sign = if i.is_multiple_of(2) { bias } else { -bias };
                    [0; 3].map(|_| sign + random.random::<f32>() - 0.5)
                };
                let actual: Vec<[f32; 3]> = (0..pixels).map(&mut pixel).collect();
                let picture = Picture {
                    method: 0,
                    samples_per_pixel: 1,
                    samples_taken: 1.0,
                    seed: 0,
                    seconds: 1.0,
                    means: means(&actual, &expected),
                };
                pictures.add(picture, &actual, &expected);
            }
            // Noise has a mean square of 1/12; the estimate scatters by 1/12 sqrt(2 / (8 * 7 * 30000)).
            let CommonSquare { value: square, standard_error: error } = pictures.common_square();
            let expected_error = (2.0_f64 / (56.0 * 30_000.0)).sqrt() / 12.0;
            assert!(bias > 0.0 || (error / expected_error - 1.0).abs() < 0.05, "{error}");
            assert!((square - f64::from(bias * bias)).abs() < 4.0 * error, "{square} ± {error}");
        }
    }
}
