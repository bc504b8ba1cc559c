//! How far to climb within a budget.

use std::ops::Range;
use std::time::Instant;

use lookat_image::means;
use lookat_render::REPLICATES;

use super::method::Method;
use super::runner::{LATE, Runner, Watch};

/// A line takes as many points.
pub const FEWEST_RUNGS: u32 = 3;
/// Up to 65536 samples, which is as long as Sobol's sequence is.
pub const MOST_RUNGS: u32 = 17;
/// A point takes as many pictures.
pub const FEWEST_SEEDS: u32 = 8;
/// Samples of a reference that is rendered, for each of the highest rung. In its replicates each has as many as that
/// rung, so whatever the slope is, the reference has a 16th of the variance that the same sampler has there.
const REFERENCE_FACTOR: u32 = REPLICATES;
/// Samples per pixel that a method goes up to.
const MOST_SAMPLES: u32 = 1 << (MOST_RUNGS - 1);

/// What a picture costs in seconds that has `n` times the samples of the lowest rung: `fixed + n * per_sample`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Preparing the scene, and measuring the error.
    pub fixed: f64,
    /// Rendering.
    pub per_sample: f64,
    /// The samples per pixel of the lowest rung.
    pub first: u32,
}

/// What is to be rendered. Rung `i` has `2^i` times the samples per pixel of the lowest.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How many rungs each method climbs.
    pub rungs: Vec<u32>,
    /// Pictures of each rung, each with a seed of its own.
    pub seeds: u32,
    /// Samples per pixel of the reference; 0 where one is given.
    pub reference: u32,
    /// How long all that takes by the pilot, in seconds.
    pub seconds: f64,
    /// What it is reckoned from.
    pub costs: Vec<Cost>,
}

impl Cost {
    /// Of a picture of so many times the samples of the lowest rung.
    pub fn of(&self, samples: u32) -> f64 {
        self.fixed + self.per_sample * f64::from(samples)
    }

    /// Corrects it by what a picture took on a rung, in seconds.
    pub(super) fn correct(&mut self, rung: u32, seconds: f64) {
        self.fixed = self.fixed.min(seconds);
        self.per_sample = (seconds - self.fixed) / f64::from(1_u32 << rung);
    }

    /// Renders a few pictures; the first, which is slower than others, does not count. The last takes so many seconds, or
    /// up to twice as many. `None` if `watch` breaks.
    pub fn pilot(runner: &Runner, method: &Method, seconds: f64, watch: Watch) -> Option<Cost> {
        let first = method.first;
        runner.render(method, first, 0, watch)?;
        let timed = |samples: u32| {
            let started = Instant::now();
            let rendering = runner.render(method, first * samples, 0, watch)?;
            let pixels = &rendering.pixels;
            std::hint::black_box(means(pixels, pixels));
            Some(started.elapsed().as_secs_f64())
        };
        // One that was held up must not rule the plan.
        let faster_of_two = |samples: u32| Some(timed(samples)?.min(timed(samples)?));
        let once = faster_of_two(1)?;
        let (mut samples, mut last) = (1, once);
        while last < seconds && first * samples < MOST_SAMPLES {
            samples *= 2;
            last = faster_of_two(samples)?;
        }
        if samples == 1 {
            return Some(Cost { fixed: 0.0, per_sample: once, first });
        }
        let per_sample = ((last - once) / f64::from(samples - 1)).max(0.0);
        Some(Cost { fixed: (once - per_sample).max(0.0), per_sample, first })
    }
}

impl Plan {
    /// All methods up to `2^(rungs - 1)` samples, or three rungs where they begin with more, whatever that takes. The
    /// reference counts if one is to be rendered.
    pub fn fixed(costs: Vec<Cost>, reference: Option<Cost>, seeds: u32, rungs: u32) -> Plan {
        let of = |cost: &Cost| rungs.saturating_sub(cost.first.ilog2()).max(FEWEST_RUNGS);
        let rungs = costs.iter().map(of).collect();
        Plan::new(&costs, reference, seeds, rungs)
    }

    /// The share of the reference in all samples.
    pub fn reference_share(&self) -> f64 {
        let samples = |(rungs, cost): (&u32, &Cost)| f64::from(cost.first) * f64::from((1_u32 << rungs) - 1);
        let others = f64::from(self.seeds) * self.rungs.iter().zip(&self.costs).map(samples).sum::<f64>();
        let own = f64::from(self.reference);
        own / (own + others).max(1.0)
    }

    /// What all methods cost on these rungs, each as far as it goes, in seconds.
    pub(super) fn cost_of(&self, range: Range<u32>) -> f64 {
        (0..self.rungs.len()).map(|i| self.cost_of_one(i, range.start..range.end.min(self.rungs[i]))).sum()
    }

    fn cost_of_one(&self, method: usize, rungs: Range<u32>) -> f64 {
        f64::from(self.seeds) * rungs.map(|rung| self.costs[method].of(1 << rung)).sum::<f64>()
    }

    /// Plans the rest anew where so many rungs are climbed and so many seconds are left. Who has stopped does not go on, and none
    /// goes higher than the reference was made for.
    pub(super) fn replan(&mut self, climbed: u32, seconds: f64) {
        let rungs = self.rungs.iter().map(|rungs| (*rungs).min(climbed.max(FEWEST_RUNGS))).collect();
        let most = if self.reference > 0 { self.reference / REFERENCE_FACTOR } else { MOST_SAMPLES };
        let goes_on = |i: usize, samples: u32| self.rungs[i] >= climbed && samples <= most;
        let fits = |plan: &Plan| plan.cost_of(climbed..MOST_RUNGS) <= seconds;
        *self = Plan { rungs, ..self.clone() }.grown(goes_on, fits);
    }

    fn new(costs: &[Cost], reference: Option<Cost>, seeds: u32, rungs: Vec<u32>) -> Plan {
        let highest = |(cost, rungs): (&Cost, &u32)| cost.first << (rungs - 1);
        let most = costs.iter().zip(&rungs).map(highest).max().unwrap_or(1);
        let samples = if reference.is_some() { REFERENCE_FACTOR * most } else { 0 };
        let mut plan = Plan { rungs, seeds, reference: samples, seconds: 0.0, costs: costs.to_vec() };
        plan.seconds = plan.cost_of(0..MOST_RUNGS) + reference.map_or(0.0, |cost| cost.of(samples));
        plan
    }

    /// Lets the method that has used least go one rung up, as long as that fits. `goes_on` says of each method whether it may
    /// go up to so many samples per pixel.
    fn grown(mut self, goes_on: impl Fn(usize, u32) -> bool, fits: impl Fn(&Plan) -> bool) -> Plan {
        loop {
            let climbs = |i: &usize| goes_on(*i, self.costs[*i].first << self.rungs[*i]);
            let mut order: Vec<usize> = (0..self.costs.len()).filter(climbs).collect();
            let used = |i: usize| self.cost_of_one(i, 0..self.rungs[i]);
            order.sort_by(|a, b| used(*a).total_cmp(&used(*b)));
            let one_up = |i: usize| {
                let mut plan = self.clone();
                plan.rungs[i] += 1;
                plan
            };
            match order.into_iter().map(one_up).find(|plan| fits(plan)) {
                Some(more) => self = more,
                None => return self,
            }
        }
    }
}

/// Rungs that fit in so many seconds, with the reference if one is to be rendered at this cost.
///
/// # Errors
///
/// If even the fewest rungs take more than 1.15 times as long; the seconds that they take.
pub fn plan(costs: &[Cost], reference: Option<Cost>, seeds: u32, seconds: f64) -> Result<Plan, f64> {
    let of = |rungs: Vec<u32>| Plan::new(costs, reference, seeds, rungs);
    let fewest = of(vec![FEWEST_RUNGS; costs.len()]);
    if fewest.seconds > LATE * seconds {
        return Err(fewest.seconds);
    }
    let fits = |plan: &Plan| of(plan.rungs.clone()).seconds <= seconds;
    Ok(of(fewest.grown(|_, samples| samples <= MOST_SAMPLES, fits).rungs))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_keep_to_the_budget_and_share_it() {
        let cost = |per_sample| Cost { fixed: 0.0, per_sample, first: 1 };
        // 8 seeds of 1 to 128 samples at 1 ms are 8 * 0.255 s, twice that, and 2048 samples of the reference.
        let costs = [cost(1e-3), cost(1e-3)];
        let found = plan(&costs, Some(cost(1e-3)), 8, 7.0).unwrap();
        assert_eq!((found.rungs.as_slice(), found.reference), ([8, 8].as_slice(), 2048));
        assert!((found.seconds - (2.0 * 8.0 * 0.255 + 2.048)).abs() < 1e-9, "{found:?}");
        // Without a reference there is time for one more, of one of them.
        let found = plan(&costs, None, 8, 7.0).unwrap();
        assert_eq!((found.rungs.as_slice(), found.reference), ([9, 8].as_slice(), 0));
        // What costs 4 times as much climbs two rungs less.
        let found = plan(&[cost(1e-3), cost(4e-3)], None, 8, 8.5).unwrap();
        assert_eq!(found.rungs, [9, 7]);
        assert_eq!(found.reference, 0);
        // Too little time is refused, and so is no climb without end.
        assert_eq!(plan(&costs, None, 8, 0.01), Err(2.0 * 8.0 * 7e-3));
        assert_eq!(plan(&[cost(0.0)], None, 8, 1.0).unwrap().rungs, [MOST_RUNGS]);
    }

    #[test]
    fn the_rest_is_planned_by_what_was_measured() {
        let cost = |per_sample| Cost { fixed: 0.0, per_sample, first: 1 };
        let planned = plan(&[cost(1e-3), cost(1e-3)], Some(cost(1e-3)), 8, 7.0).unwrap();
        assert_eq!(planned.rungs, [8, 8]);
        let replanned = |pace: [f64; 2], climbed: u32, seconds: f64| {
            let mut plan = planned.clone();
            let costs = plan.costs.iter_mut().zip(pace);
            costs.for_each(|(cost, pace)| {
                cost.correct(climbed - 1, pace * 1e-3 * f64::from(1 << (climbed - 1)))
            });
            plan.replan(climbed, seconds);
            plan.rungs
        };
        // As planned, 8 seeds of 16 to 128 samples at 1 ms are 1.92 s for each; with more time left none goes beyond what the
        // reference is made for.
        assert_eq!(replanned([1.0, 1.0], 4, 3.84 + 1e-9), [8, 8]);
        assert_eq!(replanned([1.0, 1.0], 4, 100.0), [8, 8]);
        // Where the second takes three times as long, 0.896 s are for 16 to 64 of the first, 1.152 s for 16 and 32 of it.
        assert_eq!(replanned([1.0, 3.0], 4, 0.896 + 1.152 + 1e-9), [7, 6]);
        // The fewest rungs are climbed whatever they take, and nothing more.
        assert_eq!(replanned([1.0, 1.0], 2, 0.0), [FEWEST_RUNGS; 2]);
        // Who has stopped does not go on.
        let mut plan = Plan { rungs: vec![5, 8], ..planned.clone() };
        plan.replan(6, 100.0);
        assert_eq!(plan.rungs, [5, 8]);
        // What a picture costs anyway is no cost of samples.
        let mut cost = Cost { fixed: 0.5, per_sample: 1.0, first: 1 };
        cost.correct(3, 4.5);
        assert_eq!((cost.fixed, cost.per_sample), (0.5, 0.5));
        cost.correct(0, 0.25);
        assert_eq!((cost.fixed, cost.per_sample), (0.25, 0.0));
    }
}
