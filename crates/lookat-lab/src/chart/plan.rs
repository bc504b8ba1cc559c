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

    /// Renders a few pictures; the first, which is slower than others, does not count. They get so many seconds, or
    /// little more. `None` if `watch` breaks.
    pub fn pilot(runner: &mut Runner, method: &Method, seconds: f64, watch: Watch) -> Option<Cost> {
        let first = method.first;
        runner.render(method, first, 0, watch)?;
        let mut timed = |samples: u32| {
            let started = Instant::now();
            let rendering = runner.render(method, first * samples, 0, watch)?;
            let pixels = &rendering.pixels;
            std::hint::black_box(means(pixels, pixels));
            Some(started.elapsed().as_secs_f64())
        };
        let once = timed(1)?;
        let (mut samples, mut last) = (1, once);
        while last < seconds && first * samples < PILOT_SAMPLES {
            samples *= 2;
            last = timed(samples)?;
        }
        if samples == 1 {
            return Some(Cost { fixed: 0.0, per_sample: once, first });
        }
        let per_sample = ((last - once) / f64::from(samples - 1)).max(0.0);
        Some(Cost { fixed: (once - per_sample).max(0.0), per_sample, first })
    }
}

impl Plan {
    /// All methods up to `2^(rungs - 1)` samples, or three rungs where they begin with more, whatever that takes. The reference counts if one is to be rendered.
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

    fn new(costs: &[Cost], reference: Option<Cost>, seeds: u32, rungs: Vec<u32>) -> Plan {
        let highest = |(cost, rungs): (&Cost, &u32)| cost.first << (rungs - 1);
        let most = costs.iter().zip(&rungs).map(highest).max().unwrap_or(1);
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
        let mut order: Vec<usize> =
            (0..costs.len()).filter(|i| costs[*i].first << best.rungs[*i] < 1 << MOST_RUNGS).collect();
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
}
