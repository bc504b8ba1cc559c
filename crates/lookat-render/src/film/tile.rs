//! Rectangles of the picture that threads render one at a time.

use serde::{Deserialize, Serialize};

use super::Keeps;
use super::area::Area;
use super::spread::{Spread, Spreads};
use super::sum::{PixelSums, Scale, Sum};
use crate::film::REPLICATES;

/// A rectangle of the picture that one thread renders at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tile {
    /// The pixels: none in tiles beyond the crop window.
    pub bounds: Area,
    /// The pixels in which its samples are taken. At the edges of the crop window, they extend beyond it by the reach of the
    /// filter.
    pub sources: Area,
    /// The samples taken in each source, row by row.
    pub counts: Vec<u32>,
    /// The sums of each pixel, row by row.
    pub sums: Vec<Sum>,
    /// The sums of the pass that is not merged yet. Empty if samples are added to other sums at once.
    pub pass: PixelSums,
    /// The sums of each replicate, empty before its first sample. No replicates if the film does not keep their sums.
    pub replicates: Vec<PixelSums>,
    /// The sums of splats. Empty before the first.
    pub splats: Vec<Sum>,
    /// The spread of the replicates of each pixel, with and without the filter. Empty unless the film keeps them.
    pub spreads: Vec<Spread>,
    pub unfiltered: Vec<Spread>,
    /// What the policy knows about the tile, in a form of its own, for going on after a break.
    pub policy: Vec<u8>,
}

impl Tile {
    pub fn new(bounds: Area, sources: Area, keeps: Keeps, has_unfiltered: bool) -> Tile {
        let of = |is_kept: bool| if is_kept { bounds.size() } else { 0 };
        let replicates = if keeps == Keeps::Replicates { REPLICATES as usize } else { 0 };
        Tile {
            bounds,
            sources,
            counts: vec![0; sources.size()],
            sums: vec![Sum::default(); bounds.size()],
            pass: PixelSums::new(
                of(matches!(keeps, Keeps::Passes | Keeps::Spreads)),
                has_unfiltered && keeps == Keeps::Spreads,
            ),
            replicates: vec![PixelSums::default(); replicates],
            splats: Vec::new(),
            spreads: vec![Spread::default(); of(keeps == Keeps::Spreads)],
            unfiltered: vec![Spread::default(); of(keeps == Keeps::Spreads && has_unfiltered)],
            policy: Vec::new(),
        }
    }

    /// The samples taken in a pixel.
    pub fn count(&self, at: usize) -> u32 {
        self.counts[self.sources.index(self.bounds.pixel(at))]
    }

    /// True if samples count for a pixel.
    pub fn is_reached(&self, at: usize) -> bool {
        self.so_far(at).has_weight()
    }

    /// The sum of a pixel, with the pass that is not merged yet and the replicates.
    pub fn so_far(&self, at: usize) -> Sum {
        let mut sum = self.sums[at];
        let others = std::iter::once(&self.pass).chain(&self.replicates);
        others.filter_map(|other| other.filtered.get(at)).for_each(|other| sum += *other);
        sum
    }

    /// The spreads of the replicates of a pixel so far. `None` if the film has none.
    pub fn spreads(&self, at: usize, scale: Scale) -> Option<Spreads> {
        if !self.replicates.is_empty() {
            return Some(Spreads::of(&self.replicates, at, self.count(at), scale));
        }
        let unfiltered = self.unfiltered.get(at).copied().unwrap_or_default();
        self.spreads.get(at).map(|filtered| Spreads { filtered: *filtered, unfiltered })
    }

    /// Adds the pass to the sums of all, and to the spreads if it is a whole replicate of so many samples.
    pub fn merge_replicate(&mut self, samples: Option<u32>, scale: Scale) {
        let PixelSums { filtered, unfiltered } = &mut self.pass;
        for (spreads, sums) in [(&mut self.spreads, &*filtered), (&mut self.unfiltered, &*unfiltered)] {
            for (spread, sum) in spreads.iter_mut().zip(sums).filter(|_| samples.is_some()) {
                spread.add_sum(sum, scale);
                spread.samples += samples.unwrap_or_default();
            }
        }
        self.sums.iter_mut().zip(&*filtered).for_each(|(all, sum)| *all += *sum);
        self.pass.clear();
    }

    /// True if it is a later state of another tile without samples.
    pub fn continues(&self, empty: &Tile) -> bool {
        let lengths = |tile: &Tile| {
            let [filtered, unfiltered] = tile.pass.kinds().map(Vec::len);
            let [spreads, own_spreads] = [&tile.spreads, &tile.unfiltered].map(Vec::len);
            let [counts, sums] = [tile.counts.len(), tile.sums.len()];
            [counts, sums, filtered, unfiltered, tile.replicates.len(), spreads, own_spreads]
        };
        (self.bounds, self.sources) == (empty.bounds, empty.sources) && lengths(self) == lengths(empty)
    }

    /// True if it can be a tile of a crop window, and its sums can be added up.
    pub fn is_sound(&self, crop: Area) -> bool {
        let all = std::iter::once(&self.pass).chain(&self.replicates).flat_map(PixelSums::kinds);
        self.bounds.intersection(crop) == self.bounds
            && self.sums.len() == self.bounds.size()
            && all.chain([&self.sums, &self.splats]).all(|sums| {
                (sums.is_empty() || sums.len() == self.bounds.size()) && sums.iter().all(Sum::is_carried)
            })
    }

    /// Bytes of its memory, about.
    pub fn bytes(&self) -> usize {
        let sums = std::iter::once(&self.pass).chain(&self.replicates).flat_map(PixelSums::kinds);
        let sums: usize = sums.chain([&self.sums, &self.splats]).map(|sums| size_of_val(&sums[..])).sum();
        let spreads = size_of_val(&self.spreads[..]) + size_of_val(&self.unfiltered[..]);
        sums + spreads + size_of_val(&self.counts[..]) + self.policy.len()
    }
}
