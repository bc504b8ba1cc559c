//! Renders with a target error: samples all unfinished pixels in rounds, until each pixel reaches the target.
//!
//! Each pixel has 16 replicates. Each replicate is an Owen-scrambled Sobol' pattern of its own, whose number of samples
//! doubles in each round. Each pixel is judged after a whole round, by its own samples and by the samples of its
//! neighbors. The picture therefore does not depend on threads or on the order of tiles.

mod forecast;
mod judge;

use std::sync::Mutex;

use glam::Vec3;
use lookat_scene::{PixelBounds, Sampler, SamplerKind};

use super::control::Control;
use super::rounds::Policy;
use super::sample::{Job, Pattern, Seen};
use super::stop::{Brightness, StopRule};
use super::{Reached, TargetError};
use crate::film::{Film, REPLICATES, Tile};
use crate::sampler::replicate_seed;
use forecast::{FirstRound, POWERS, left};
use judge::{count_outliers, judge};

/// Samples per pixel in the first round: 4 in each replicate.
pub(super) const FIRST: u32 = 4 * REPLICATES;

/// Bytes of a pixel beside the film, about, until it is done.
pub(super) const PIXEL_BYTES: usize = 310;

/// What is known of the pixels of a tile.
pub(super) struct Part {
    bounds: PixelBounds,
    /// The bounds of the samples of each pixel.
    seen: Vec<Seen>,
    /// The unfinished pixels. `None` before the first round, because they take much memory.
    active: Option<Vec<Active>>,
}

/// The replicates of an unfinished pixel.
struct Active {
    /// The index of the pixel in its tile.
    at: usize,
    /// Samples in each replicate.
    count: u32,
    replicates: [Replicate; REPLICATES as usize],
    /// The error over the target error, after the last round.
    excess: f64,
}

/// The signed sum and the signed count of the samples of a replicate, see [`crate::film::Pixel`]. Single precision serves, as there may be
/// many.
#[derive(Clone, Copy, Default)]
struct Replicate {
    signed: Vec3,
    signs: i32,
}

/// Which samples are taken next.
#[derive(Clone, Copy, PartialEq)]
enum Round {
    /// None so far.
    Start,
    /// One of each pixel, to have a whole picture soon. The first round replaces these samples.
    Preview,
    /// As many of all unfinished pixels as their replicates lack of this number.
    Replicates(u32),
}

/// Samples until pixels reach the target error, or a limit of samples.
pub(super) struct Target {
    seed: u64,
    /// The most samples of a replicate.
    most: u32,
    /// Whether the time may end before the first round does.
    has_preview: bool,
    first: FirstRound,
    rule: StopRule,
    round: Round,
}

impl Target {
    pub fn new(sampler: Sampler, seed: u64, target: &TargetError, has_limit: bool) -> Target {
        let most = sampler.samples_per_pixel / REPLICATES;
        let rule = StopRule::new(target);
        Target {
            seed,
            most,
            has_preview: has_limit,
            first: FirstRound { rule, most, known: Mutex::default() },
            rule,
            round: Round::Start,
        }
    }

    fn is_first(&self) -> bool {
        self.round == Round::Replicates(FIRST / REPLICATES)
    }

    /// The sample pattern of a replicate of a pixel.
    fn pattern(&self, replicate: u32, count: u32) -> Pattern {
        let sampler = Sampler { kind: SamplerKind::Sobol, samples_per_pixel: count };
        Pattern { sampler, seed: replicate_seed(self.seed, replicate), is_watched: true }
    }

    /// Counts the pixels by whether they reached the target error.
    pub fn reached(&self, film: &Film, parts: &[Part]) -> Reached {
        let active = || parts.iter().flat_map(Part::active);
        let at_cap = active().filter(|active| active.count >= self.most).count() as u64;
        let not_begun = parts.iter().filter(|part| part.active.is_none()).map(|part| part.seen.len() as u64);
        let out_of_time = active().count() as u64 - at_cap + not_begun.sum::<u64>();
        let outliers = count_outliers(film, parts);
        Reached { within: film.of.crop.area() - at_cap - out_of_time, at_cap, out_of_time, outliers }
    }
}

impl Policy for Target {
    type State = Part;

    fn begin(&self, tile: &Tile) -> Part {
        Part { bounds: tile.bounds, seen: vec![Seen::NOTHING; tile.bounds.area() as usize], active: None }
    }

    fn next(&mut self, film: &Film, parts: &mut [Part], control: &Control) -> bool {
        let first = Round::Replicates(FIRST / REPLICATES);
        self.round = match self.round {
            Round::Start => {
                control.expect(film.of.crop.area() * u64::from(FIRST));
                if self.has_preview { Round::Preview } else { first }
            }
            Round::Preview => first,
            Round::Replicates(count) => {
                if self.is_first() {
                    let mut brightness = Brightness::default();
                    film.pixels().for_each(|pixel| brightness.add(film.value(&pixel)));
                    self.rule = self.rule.with_brightness(brightness.get());
                }
                judge(film, parts, &self.rule);
                let active = || parts.iter().flat_map(Part::active);
                control.state().pixels_done = film.of.crop.area() - active().count() as u64;
                if active().next().is_none() || count >= self.most || control.is_stopped() {
                    return false;
                }
                let left =
                    |power| active().map(|active| left(active, active.excess, power, self.most)).sum::<u64>();
                let done = control.state().done;
                let totals = POWERS.map(|power| done + left(power));
                control.expect(totals[0]);
                control.state().bounds = Some(totals);
                // Sobol' patterns are best at powers of two.
                Round::Replicates((2 * count).min(self.most))
            }
        };
        if self.round == first {
            control.state().bounds = None;
        }
        true
    }

    fn is_shuffled(&self) -> bool {
        self.is_first()
    }

    fn jobs(&self, tile: &Tile, part: &mut Part) -> Vec<Job> {
        let bounds = tile.bounds;
        let place =
            |at: usize| [bounds.x0 + at as u32 % bounds.width(), bounds.y0 + at as u32 / bounds.width()];
        let Round::Replicates(count) = self.round else {
            let job = |at| Job::new(self.pattern(0, 1), place(at), 0..1);
            return (0..part.seen.len()).map(job).collect();
        };
        let area = part.seen.len();
        let active = part.active.get_or_insert_with(|| (0..area).map(Active::new).collect());
        let of_pixel = |active: &Active| {
            let (from, place) = (active.count, place(active.at));
            (0..REPLICATES).map(move |r| Job::new(self.pattern(r, count), place, from..count))
        };
        active.iter().flat_map(of_pixel).collect()
    }

    fn add(&self, jobs: &[Job], film: &Film, tile: &mut Tile, part: &mut Part) {
        let Part { seen, active: Some(all_active), .. } = part else {
            return jobs.iter().enumerate().for_each(|(at, job)| tile.add(at, &job.samples.pixel));
        };
        let is_whole = |job: &Job| job.samples.pixel.all.count == job.indices.len() as u32;
        for (active, jobs) in all_active.iter_mut().zip(jobs.chunks(REPLICATES as usize)) {
            // The rendering has been stopped.
            if !jobs.iter().all(is_whole) {
                break;
            }
            if active.count == 0 {
                tile.clear(active.at);
            }
            tile.clear_spread(active.at);
            for (replicate, Job { samples, indices, .. }) in active.replicates.iter_mut().zip(jobs) {
                active.count = indices.end;
                replicate.signed += samples.pixel.signed(film.scale()).as_vec3();
                replicate.signs += samples.pixel.signs() as i32;
                let sums = (replicate.signed.as_dvec3(), f64::from(replicate.signs), active.count);
                tile.spread(active.at, sums, film.scale());
                tile.add(active.at, &samples.pixel);
                seen[active.at] = seen[active.at].union(samples.seen);
            }
        }
    }

    fn finish(&self, film: &Film, tile: &Tile, part: &Part, control: &Control) {
        if self.is_first() {
            self.first.forecast(film, tile, part, control);
        }
    }
}

impl Part {
    /// The unfinished pixels. Empty before the first round.
    fn active(&self) -> &[Active] {
        self.active.as_deref().unwrap_or_default()
    }
}
