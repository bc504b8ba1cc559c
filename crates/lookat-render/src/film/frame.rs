//! The sums of samples that one thread takes together.

use glam::{DVec2, DVec4};

use super::{Area, Film};
use crate::filter::PixelFilter;

/// Pixels on a side of a block. Blocks are aligned to the full picture, and the samples of a block are added up in the order of their
/// sources: so the bits of a sum depend on no tile and no crop window.
pub(super) const BLOCK: i32 = 4;

/// The samples of an area, added up by the pixels around that they count for: block by block, in double precision.
#[derive(Debug, Clone, Default)]
pub(crate) struct Frame {
    /// The sources.
    pub area: Area,
    reach: [u32; 2],
    /// Row by row, and of each block its pixels and those around it that the filter reaches, row by row: sums of weighted radiance, and
    /// in `w` of weights.
    sums: Vec<DVec4>,
    /// The samples taken in each source, row by row.
    pub counts: Vec<u32>,
    /// And the sums of samples taken in each source, without the filter, if the film asks for their errors.
    pub unfiltered: Vec<DVec4>,
    /// Room for the weights of a sample, across and down.
    weights: [Vec<f64>; 2],
}

impl Frame {
    /// Makes a frame for an area, without samples.
    pub fn restart(&mut self, film: &Film, area: Area) {
        self.area = area;
        self.reach = film.filter.reach();
        self.counts.clear();
        self.counts.resize(area.size(), 0);
        self.unfiltered.clear();
        self.unfiltered.resize(if film.has_unfiltered { area.size() } else { 0 }, DVec4::ZERO);
        self.sums.clear();
        self.sums.resize(self.blocks().count() * self.block_size(), DVec4::ZERO);
    }

    /// Adds a sample of a source, which lies at `square` in its unit square: red, green, blue, and in `w` its weight.
    #[inline(always)]
    pub fn add(&mut self, filter: &PixelFilter, source: [i32; 2], square: DVec2, sample: DVec4) {
        let at = self.area.index(source);
        self.counts[at] += 1;
        self.unfiltered.get_mut(at).into_iter().for_each(|sum| *sum += sample);
        let [x, y] = source;
        let block = self.area.square_of(BLOCK, source);
        let width = BLOCK as usize + 2 * self.reach[0] as usize;
        // The first pixel that the sample counts for.
        let first =
            block * self.block_size() + y.rem_euclid(BLOCK) as usize * width + x.rem_euclid(BLOCK) as usize;
        let sums = &mut self.sums[first..];
        if self.reach == [0, 0] {
            sums[0] += sample * filter.own(square);
            return;
        }
        filter.weigh(square, &mut self.weights);
        let [across, down] = &self.weights;
        // A sample seldom reaches the pixels on both edges.
        for (row, down) in sums.chunks_mut(width).zip(down).filter(|(_, down)| **down != 0.0) {
            let sample = sample * *down;
            row.iter_mut().zip(across).for_each(|(sum, across)| *sum += sample * *across);
        }
    }

    /// The pixels of a block and around it.
    fn block_size(&self) -> usize {
        self.reach.iter().map(|reach| BLOCK as usize + 2 * *reach as usize).product()
    }

    /// The blocks, each with the pixels that it has sums of.
    fn blocks(&self) -> impl Iterator<Item = Area> + use<> {
        let reach = self.reach;
        self.area.squares(BLOCK).map(move |block| block.grown(reach))
    }

    /// The sums of each block, with its pixels.
    pub fn sums(&self) -> impl Iterator<Item = (Area, &[DVec4])> {
        self.blocks().zip(self.sums.chunks(self.block_size()))
    }
}
