//! How far to climb within a budget.

use std::time::Instant;

use lookat_image::means;

use super::method::Method;
use super::runner::{Runner, Watch};

/// A line takes as many points.
pub const FEWEST_RUNGS: u32 = 3;
/// Up to 65536 samples, which is as long as Sobol's sequence is.
pub const MOST_RUNGS: u32 = 17;
/// Samples of a reference that is rendered, for each of the highest rung. In its 16 replicates each has as many as that
/// rung, so whatever the slope is, the reference has a 16th of the variance that the same sampler has there.
const REFERENCE_FACTOR: u32 = 16;
/// Samples that a pilot goes up to.
const PILOT_SAMPLES: u32 = 1 << 16;

/// What a picture of `n` samples per pixel costs: `fixed + n * per_sample`, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Preparing the scene, and measuring the error.
    pub fixed: f64,
    /// Rendering.
    pub per_sample: f64,
}

/// What is to be rendered. Rung `i` has `2^i` samples per pixel.
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
    /// Of a picture of so many samples.
    pub fn of(&self, samples: u32) -> f64 {
        self.fixed + self.per_sample * f64::from(samples)
    }

    /// Renders a few pictures; the first, which is slower than others, does not count. They get so many seconds, or
    /// little more. `None` if `watch` breaks.
    pub fn pilot(runner: &mut Runner, method: &Method, seconds: f64, watch: Watch) -> Option<Cost> {
        runner.render(method, 1, 0, watch)?;
        let mut timed = |samples| {
            let started = Instant::now();
            let rendering = runner.render(method, samples, 0, watch)?;
            let pixels = &rendering.pixels;
            std::hint::black_box(means(pixels, pixels));
            Some(started.elapsed().as_secs_f64())
        };
        let once = timed(1)?;
        let (mut samples, mut last) = (1, once);
        while last < seconds && samples < PILOT_SAMPLES {
            samples *= 2;
            last = timed(samples)?;
        }
        if samples == 1 {
            return Some(Cost { fixed: 0.0, per_sample: once });
        }
        let per_sample = ((last - once) / f64::from(samples - 1)).max(0.0);
        Some(Cost { fixed: (once - per_sample).max(0.0), per_sample })
    }
}

impl Plan {
    /// All methods up to `2^(rungs - 1)` samples, whatever that takes. The reference counts if one is to be rendered.
    pub fn fixed(costs: Vec<Cost>, reference: Option<Cost>, seeds: u32, rungs: u32) -> Plan {
        Plan::new(&costs, reference, seeds, vec![rungs; costs.len()])
    }

    /// The share of the reference in all samples.
    pub fn reference_share(&self) -> f64 {
        let samples = |rungs: &u32| f64::from((1_u32 << rungs) - 1);
        let others = f64::from(self.seeds) * self.rungs.iter().map(samples).sum::<f64>();
        let own = f64::from(self.reference);
        own / (own + others).max(1.0)
    }

    fn new(costs: &[Cost], reference: Option<Cost>, seeds: u32, rungs: Vec<u32>) -> Plan {
        let most = rungs.iter().max().map_or(1, |rungs| 1 << (rungs - 1));
        let samples = if reference.is_some() { REFERENCE_FACTOR * most } else { 0 };
        let methods: f64 = costs.iter().zip(&rungs).map(|(cost, rungs)| climbing(cost, *rungs, seeds)).sum();
        let seconds = methods + reference.map_or(0.0, |cost| cost.of(samples));
        Plan { rungs, seeds, reference: samples, seconds, costs: costs.to_vec() }
    }
}

/// The time for the rungs of one method.
fn climbing(cost: &Cost, rungs: u32, seeds: u32) -> f64 {
    f64::from(seeds) * (0..rungs).map(|rung| cost.of(1 << rung)).sum::<f64>()
}

/// Rungs that fit in so many seconds, with the reference if one is to be rendered at this cost: the method that has used
/// least goes one up, as long as there is time.
///
/// # Errors
///
/// If not even the fewest rungs fit, by half as much again; the seconds that they take.
pub fn plan(costs: &[Cost], reference: Option<Cost>, seeds: u32, seconds: f64) -> Result<Plan, f64> {
    let mut best = Plan::new(costs, reference, seeds, vec![FEWEST_RUNGS; costs.len()]);
    if best.seconds > 1.5 * seconds {
        return Err(best.seconds);
    }
    loop {
        let mut order: Vec<usize> = (0..costs.len()).filter(|i| best.rungs[*i] < MOST_RUNGS).collect();
        let used = |i: usize| climbing(&costs[i], best.rungs[i], seeds);
        order.sort_by(|a, b| used(*a).total_cmp(&used(*b)));
        let one_up = |i: usize| {
            let mut rungs = best.rungs.clone();
            rungs[i] += 1;
            Plan::new(costs, reference, seeds, rungs)
        };
        match order.into_iter().map(one_up).find(|plan| plan.seconds <= seconds) {
            Some(better) => best = better,
            None => return Ok(best),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_keep_to_the_budget_and_share_it() {
        let cost = |per_sample| Cost { fixed: 0.0, per_sample };
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
}
