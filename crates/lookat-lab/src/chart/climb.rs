//! Renders and measures what was planned.

use std::ops::ControlFlow;
use std::time::Instant;

use lookat_image::means;

use super::estimate::median;
use super::level::Differences;
use super::method::Method;
use super::plan::{FEWEST_RUNGS, FEWEST_SEEDS, MOST_RUNGS, Plan};
use super::point::{Picture, Point};
use super::reference::Reference;
use super::results::{End, Measured};
use super::runner::{Budget, Runner, Watch};

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

/// What is climbed.
#[derive(Debug, Clone, Copy)]
pub struct Climb<'a> {
    /// The methods, in the order of the plan.
    pub methods: &'a [&'static Method],
    /// How high.
    pub plan: &'a Plan,
    /// The seed of the first picture.
    pub first_seed: u64,
    /// What errors are measured by.
    pub reference: &'a Reference,
    /// `None` if the plan is to be kept, however long that takes.
    pub budget: Option<Budget>,
}

/// One rung, as far as it has come.
struct Rung {
    index: u32,
    methods: Vec<MethodRung>,
}

/// The pictures of one method on a rung.
#[derive(Default)]
struct MethodRung {
    rows: Vec<Picture>,
    differences: Differences,
    /// The wall time of each picture, with that of measuring it.
    seconds: Vec<f64>,
}

impl Climb<'_> {
    /// Climbs rung by rung. On each the methods take turns, seed by seed, so that a machine that slows down is no advantage
    /// to any of them. With a budget, the rest is planned anew after each rung, from the times that were measured.
    /// Where `watch` breaks, or the budget is exceeded, the picture in hand is left out.
    pub fn run(&self, runner: &Runner, watch: Watch) -> Measured {
        let started = Instant::now();
        let mut plan = self.plan.clone();
        let points = vec![Vec::new(); self.methods.len()];
        let mut measured = Measured { methods: self.methods.to_vec(), points, ..Measured::default() };
        for index in 0..MOST_RUNGS {
            if plan.rungs.iter().all(|rungs| *rungs <= index) {
                break;
            }
            let spent = started.elapsed().as_secs_f64();
            let (next, rest) = (plan.cost_of(index..index + 1), plan.cost_of(index..MOST_RUNGS));
            let watch_rung = |share: f64| watch((spent + share * next) / (spent + rest).max(1e-9));
            let methods = self.methods.iter().map(|_| MethodRung::default()).collect();
            let mut rung = Rung { index, methods };
            let whole = self.climb(&mut rung, &plan, runner, &watch_rung);
            rung.add_to(&mut measured, plan.seeds.min(FEWEST_SEEDS));
            if whole.is_none() {
                measured.end = if watch_rung(1.0).is_break() { End::Interrupted } else { End::Late };
                return measured;
            }
            rung.correct(&mut plan);
            if let Some(budget) = self.budget {
                plan.replan(index + 1, budget.left());
            }
        }
        let is_short = |(points, rungs): (&Vec<Point>, &u32)| points.len() < *rungs as usize;
        if measured.points.iter().zip(&self.plan.rungs).any(is_short) {
            measured.end = End::Late;
        }
        measured
    }

    /// The pictures of a rung. `None` if it is broken off.
    fn climb(&self, rung: &mut Rung, plan: &Plan, runner: &Runner, watch: Watch) -> Option<()> {
        let climbing: Vec<usize> = (0..plan.rungs.len()).filter(|i| plan.rungs[*i] > rung.index).collect();
        let pictures = f64::from(plan.seeds) * climbing.len() as f64;
        let may_be_late = rung.index < FEWEST_RUNGS;
        let is_late = || !may_be_late && self.budget.is_some_and(|budget| budget.is_exceeded());
        let mut done = 0.0;
        for index in 0..plan.seeds {
            let seed = seed_of(self.first_seed, plan, rung.index, index);
            for turn in 0..climbing.len() {
                // Each is the first in its turn.
                let method = climbing[(turn + index as usize) % climbing.len()];
                let watch_one = |share: f64| {
                    if is_late() { ControlFlow::Break(()) } else { watch((done + share) / pictures) }
                };
                let started = Instant::now();
                let samples = self.methods[method].first << rung.index;
                let rendering = runner.render(self.methods[method], samples, seed, &watch_one)?;
                let own = &mut rung.methods[method];
                own.rows.push(Picture {
                    method,
                    rung: samples,
                    samples: rendering.samples,
                    seed,
                    seconds: rendering.seconds,
                    preparation: rendering.preparation,
                    means: means(&rendering.pixels, &self.reference.pixels),
                });
                own.differences.add(&rendering.pixels, &self.reference.pixels);
                own.seconds.push(started.elapsed().as_secs_f64());
                done += 1.0;
            }
        }
        Some(())
    }
}

impl Rung {
    /// Tells a plan what pictures really cost. One that was held up must not rule it.
    fn correct(&self, plan: &mut Plan) {
        for (cost, own) in plan.costs.iter_mut().zip(&self.methods).filter(|(_, own)| !own.seconds.is_empty())
        {
            cost.correct(self.index, median(&own.seconds).value);
        }
    }

    /// Adds all pictures, and points where there are so many.
    fn add_to(&self, measured: &mut Measured, fewest: u32) {
        for (own, points) in self.methods.iter().zip(&mut measured.points) {
            measured.rows.extend(&own.rows);
            if !own.rows.is_empty() && own.rows.len() >= fewest as usize {
                points.push(Point::new(&own.rows, own.differences.level()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::super::method::named;
    use super::super::plan::Cost;
    use super::*;
    use crate::text_scene::scene;

    const RUNGS: u32 = 5;

    /// What is measured of a small scene by two methods of five rungs, if it is told to stop when it has asked so often,
    /// and how often it has asked.
    fn measured(stop: u32, budget: Option<Budget>) -> (Measured, u32) {
        let scene = scene(
            r#"Camera "perspective" Film "image" "integer xresolution" 8 "integer yresolution" 6
            WorldBegin LightSource "point" Translate 0 0 4 Shape "sphere" WorldEnd"#,
        );
        let runner = Runner::new(scene, 1);
        let goes_on = |_| ControlFlow::Continue(());
        let reference = runner.reference(64, 1000, &goes_on).unwrap();
        let cost = Cost { fixed: 0.0, per_sample: 1e-3, first: 1 };
        let plan = Plan::fixed(vec![cost; 2], None, 10, RUNGS);
        let methods = [named("random").unwrap(), named("sobol").unwrap()];
        let climb = Climb { methods: &methods, plan: &plan, first_seed: 1, reference: &reference, budget };
        let asked = AtomicU32::new(0);
        let watch = |_| {
            let stops = asked.fetch_add(1, Ordering::Relaxed) >= stop;
            if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        (climb.run(&runner, &watch), asked.load(Ordering::Relaxed))
    }

    /// All but the times.
    fn errors(measured: &Measured, method: usize) -> Vec<(u32, u64, f64)> {
        let rows = measured.rows.iter().filter(|row| row.method == method);
        rows.map(|row| (row.rung, row.seed, row.means.rmse)).collect()
    }

    #[test]
    fn what_was_measured_before_an_interrupt_is_kept() {
        let (whole, asked) = measured(u32::MAX, None);
        assert_eq!((whole.end, whole.rows.len()), (End::Whole, 2 * 10 * RUNGS as usize));
        let mut lengths = Vec::new();
        // At the start, in the first rung, in the last one before and after it has points.
        for stop in [0, asked / 40, asked * 17 / 20, asked * 79 / 80] {
            let (part, _) = measured(stop, None);
            assert_eq!(part.end, End::Interrupted);
            for method in 0..2 {
                let (part_of, whole_of) = (errors(&part, method), errors(&whole, method));
                assert_eq!(part_of[..], whole_of[..part_of.len()]);
                // Ten pictures for each point, eight for the last one.
                let rungs = (part_of.len() + 2) / 10;
                assert_eq!(part.points[method].len(), rungs);
                let last = part.points[method].last();
                assert!(last.is_none_or(
                    |point| point.squares.len() == part_of.len().min(10 * rungs) - 10 * (rungs - 1)
                ));
            }
            lengths.push(part.rows.len());
        }
        assert!(lengths[0] == 0 && lengths[1] < 20 && lengths[2] > 80 && lengths.is_sorted(), "{lengths:?}");
        assert!((96..100).contains(&lengths[3]), "{lengths:?}");
    }

    #[test]
    fn a_spent_budget_leaves_the_fewest_rungs() {
        let budget = Budget { started: Instant::now(), seconds: 0.0 };
        let (found, _) = measured(u32::MAX, Some(budget));
        assert_eq!(found.end, End::Late);
        assert!(found.points.iter().all(|points| points.len() == FEWEST_RUNGS as usize));
        assert_eq!(found.rows.len(), 2 * 10 * FEWEST_RUNGS as usize);
    }

    #[test]
    fn a_picture_that_was_held_up_does_not_end_a_method() {
        let cost = Cost { fixed: 0.0, per_sample: 1e-3, first: 1 };
        let mut plan = super::super::plan::plan(&[cost, cost], Some(cost), 8, 60.0).unwrap();
        let planned = plan.rungs.clone();
        let own = |held_up: f64| MethodRung {
            seconds: [[4e-3; 5].as_slice(), &[held_up, 4e-3, 4e-3]].concat(),
            ..MethodRung::default()
        };
        let rung = Rung { index: 2, methods: vec![own(10.0), own(4e-3)] };
        rung.correct(&mut plan);
        // What it took is gone, but no more than that.
        plan.replan(3, plan.cost_of(3..MOST_RUNGS));
        assert_eq!(plan.rungs, planned);
    }
}
