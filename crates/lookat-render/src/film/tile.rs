//! Rectangles of the picture that threads render one at a time.

use super::Keeps;
use super::area::{Area, copy};
use super::spread::{Spread, Spreads};
use super::sum::{PixelSums, Scale, Sum};
use crate::film::REPLICATES;

/// A rectangle of the picture that one thread renders at a time, or the whole picture: all that samples have brought to it.
#[derive(Debug, Clone, Default, PartialEq)]
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
                spread.samples = spread.samples.saturating_add(samples.unwrap_or_default());
            }
        }
        self.sums.iter_mut().zip(&*filtered).for_each(|(all, sum)| *all += *sum);
        self.pass.clear();
    }

    /// All sums, in a fixed order.
    pub fn all_sums(&self) -> impl Iterator<Item = &Vec<Sum>> {
        let kinds = std::iter::once(&self.pass).chain(&self.replicates).flat_map(PixelSums::kinds);
        [&self.sums, &self.splats].into_iter().chain(kinds)
    }

    /// As [`Tile::all_sums`].
    pub fn all_sums_mut(&mut self) -> impl Iterator<Item = &mut Vec<Sum>> {
        let kinds =
            std::iter::once(&mut self.pass).chain(&mut self.replicates).flat_map(PixelSums::kinds_mut);
        [&mut self.sums, &mut self.splats].into_iter().chain(kinds)
    }

    /// Takes over what another tile of the same film has of the pixels of both.
    pub fn copy_from(&mut self, other: &Tile) {
        let (areas, sources) = ([self.bounds, other.bounds], [self.sources, other.sources]);
        copy(&other.counts, &mut self.counts, sources);
        self.all_sums_mut().zip(other.all_sums()).for_each(|(own, sums)| copy(sums, own, areas));
        copy(&other.spreads, &mut self.spreads, areas);
        copy(&other.unfiltered, &mut self.unfiltered, areas);
    }

    /// True if both keep the same data. Tiles without pixels keep none.
    pub fn is_like(&self, other: &Tile) -> bool {
        let kept = |tile: &Tile| {
            let spreads = [&tile.spreads, &tile.unfiltered].map(Vec::is_empty);
            (tile.pass.kinds().map(Vec::is_empty), spreads, tile.replicates.len())
        };
        self.bounds.size() == 0 || kept(self) == kept(other)
    }

    /// True if it has as many values as pixels.
    pub fn is_sound(&self) -> bool {
        let size = self.bounds.size();
        let spreads = [&self.spreads, &self.unfiltered].map(Vec::len);
        let mut lengths = self.all_sums().map(Vec::len).chain(spreads);
        self.counts.len() == self.sources.size()
            && self.sums.len() == size
            && lengths.all(|length| [0, size].contains(&length))
    }
}
