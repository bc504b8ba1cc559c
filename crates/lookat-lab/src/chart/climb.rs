//! Renders and measures what was planned.

use std::ops::ControlFlow;
use std::time::Instant;

use super::level::Differences;
use super::method::Method;
use super::plan::{FEWEST_RUNGS, MOST_RUNGS, Plan};
use super::point::{Point, Row};
use super::reference::Reference;
use super::results::Measured;
use super::runner::{Runner, Watch};

/// By how much a run may exceed the seconds of its plan.
const LATE: f64 = 1.4;

/// The seed of a picture. Each rung has seeds of its own, so that the errors of rungs are independent.
fn seed_of(first: u64, plan: &Plan, rung: u32, index: u32) -> u64 {
    first.wrapping_add(u64::from(rung) * u64::from(plan.seeds) + u64::from(index))
}

impl Plan {
    /// The seed of the reference, where that of the first picture is `first`: beyond all others, however high they climb.
    pub fn reference_seed(&self, first: u64) -> u64 {
        seed_of(first, self, MOST_RUNGS, 0)
    }
}

/// Climbs rung by rung. On each the methods take turns, seed by seed, so that a machine that slows down is no advantage to
/// any of them. Where all takes much longer than planned, the highest rungs are left out, unless the plan must be kept.
/// `None` if `watch` breaks.
pub fn climb(
    runner: &mut Runner,
    methods: &[&'static Method],
    plan: &Plan,
    first_seed: u64,
    must_keep: bool,
    reference: &Reference,
    watch: Watch,
) -> Option<Measured> {
    let started = Instant::now();
    let mut measured = Measured { methods: methods.to_vec(), ..Measured::default() };
    measured.points.resize(methods.len(), Vec::new());
    let total = cost_to(plan, MOST_RUNGS);
    for rung in 0..plan.rungs.iter().copied().max().unwrap_or(0) {
        let (before, after) = (cost_to(plan, rung), cost_to(plan, rung + 1));
        let spent = started.elapsed().as_secs_f64();
        let pace = if before > 0.0 { (spent / before).max(1.0) } else { 1.0 };
        if !must_keep && rung >= FEWEST_RUNGS && spent + pace * (after - before) > LATE * total {
            measured.is_cut = true;
            break;
        }
        let watch_rung = |share: f64| watch((before + share * (after - before)) / total);
        climb_rung(runner, plan, rung, first_seed, reference, &watch_rung, &mut measured)?;
    }
    Some(measured)
}

/// What all methods cost below a rung, in seconds.
fn cost_to(plan: &Plan, rung: u32) -> f64 {
    let of_method = |(i, rungs): (usize, &u32)| {
        (0..rung.min(*rungs)).map(|rung| plan.costs[i].of(1 << rung)).sum::<f64>()
    };
    f64::from(plan.seeds) * plan.rungs.iter().enumerate().map(of_method).sum::<f64>()
}

fn climb_rung(
    runner: &mut Runner,
    plan: &Plan,
    rung: u32,
    first_seed: u64,
    reference: &Reference,
    watch: Watch,
    measured: &mut Measured,
) -> Option<()> {
    let climbing: Vec<usize> = (0..plan.rungs.len()).filter(|i| plan.rungs[*i] > rung).collect();
    let mut rows = vec![Vec::new(); plan.rungs.len()];
    let mut differences: Vec<Differences> = plan.rungs.iter().map(|_| Differences::default()).collect();
    let pictures = f64::from(plan.seeds) * climbing.len() as f64;
    let mut done = 0.0;
    for index in 0..plan.seeds {
        let seed = seed_of(first_seed, plan, rung, index);
        for turn in 0..climbing.len() {
            // Each is the first in its turn.
            let method = climbing[(turn + index as usize) % climbing.len()];
            let watch_one = |share: f64| -> ControlFlow<()> { watch((done + share) / pictures) };
            let samples = measured.methods[method].first << rung;
            let rendering = runner.render(measured.methods[method], samples, seed, &watch_one)?;
            rows[method].push(Row::new(method, samples, seed, &rendering, &reference.pixels));
            differences[method].add(&rendering.pixels, &reference.pixels);
            done += 1.0;
        }
    }
    for method in climbing {
        measured.points[method].push(Point::new(&rows[method], differences[method].level()));
        measured.rows.extend(&rows[method]);
    }
    Some(())
}
