//! How many samples a target error takes, from a part of the picture.

use std::sync::Mutex;

use super::{Active, FIRST, Part};
use crate::film::{Film, REPLICATES, Tile, lock};
use crate::render::control::Control;
use crate::render::forecast::Sampled;
use crate::render::stop::{Brightness, StopRule};

/// The fastest and the slowest convergence: the error of a pixel falls with this power of its samples. Independent
/// samples have 1/2, and Sobol' patterns more. The slowest power is below 1/2, because few samples often underestimate
/// the error.
pub(super) const POWERS: [f64; 2] = [0.75, 0.45];

/// The remaining samples of a pixel whose error is `excess` times the target error
/// and falls with `power`. A replicate takes at most `most` samples.
pub(super) fn left(active: &Active, excess: f64, power: f64, most: u32) -> u64 {
    let count = active.count;
    let all = f64::from(count) * libm::pow(excess, power.recip());
    let all = if all < f64::from(most) { (all as u32).next_power_of_two().min(most) } else { most };
    u64::from(all.max(2 * count).min(most) - count) * u64::from(REPLICATES)
}

/// Estimates the total number of samples during the first round. The round renders the tiles in random order.
pub(super) struct FirstRound {
    pub rule: StopRule,
    pub most: u32,
    /// The brightness of the pixels so far, and the remaining samples of each tile at the fastest and at the slowest
    /// convergence.
    pub known: Mutex<(Brightness, [Sampled; 2])>,
}

impl FirstRound {
    /// Adds a tile that has finished the first round, and updates the bounds of the total number of samples.
    pub fn forecast(&self, film: &Film, tile: &Tile, part: &Part, control: &Control) {
        let mut known = lock(&self.known);
        let (brightness, lefts) = &mut *known;
        tile.pixels().for_each(|pixel| brightness.add(film.value(&pixel)));
        let rule = self.rule.with_brightness(brightness.get());
        let (mut fastest, mut slowest) = (0, 0);
        for active in part.active().iter().filter(|active| active.count > 0) {
            let seen = part.seen[active.at];
            let excess = active.excess(film, tile, seen, &rule);
            if excess > 1.0 {
                fastest += left(active, excess, POWERS[0], self.most);
                slowest += left(active, excess, POWERS[1], self.most);
            }
        }
        lefts[0].add(fastest as f64);
        lefts[1].add(slowest as f64);
        let (first, tiles) = (film.of.crop.area() * u64::from(FIRST), film.tiles.len());
        let [least, most] = [lefts[0].sum(tiles, -1.0), lefts[1].sum(tiles, 1.0)];
        // Keep the lock, so that an older forecast never replaces a newer one.
        let bounds = least.zip(most).map(|(least, most)| [first + least as u64, first + most as u64]);
        control.state().bounds = bounds;
    }
}
