//! The samples of one thread, before it adds them to the film.

use glam::{DVec2, DVec4};

use super::Film;
use super::area::Area;
use super::sum::{ShortSum, Sum};
use crate::filter::PixelFilter;

/// The samples of an area, added up by the pixels around that they count for. Exact, as the sums of the film are: so the bits of a picture
/// depend on no tile, no crop window, and no order.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImageBlock {
    /// The sources.
    pub area: Area,
    /// The area and the pixels around that the filter reaches.
    pub reached: Area,
    /// The sums of the last samples for each of these pixels, row by row.
    sums: Vec<ShortSum>,
    /// The sums of the samples before those.
    pub carried: Vec<Sum>,
    /// The number of samples in them.
    waiting: u32,
    /// The samples taken in each source, row by row.
    pub counts: Vec<u32>,
    /// The sums of samples in each source, without the filter. Empty unless the film keeps errors.
    unfiltered: Vec<ShortSum>,
    pub unfiltered_carried: Vec<Sum>,
    /// Room for the weights of a sample, across and down.
    weights: [Vec<f64>; 2],
}

impl ImageBlock {
    /// Empties the block, and gives it an area.
    pub fn restart(&mut self, film: &Film, area: Area) {
        fn clear<T: Clone + Default>(all: &mut Vec<T>, size: usize) {
            all.clear();
            all.resize(size, T::default());
        }
        self.area = area;
        self.reached = area.grown(film.filter.reach());
        self.waiting = 0;
        let unfiltered = if film.has_unfiltered() { area.size() } else { 0 };
        clear(&mut self.counts, area.size());
        clear(&mut self.sums, self.reached.size());
        clear(&mut self.carried, self.reached.size());
        clear(&mut self.unfiltered, unfiltered);
        clear(&mut self.unfiltered_carried, unfiltered);
    }

    /// Adds a sample of a source, which lies at `square` in its unit square: red, green, blue, and in `w` its weight, in the units of
    /// [`Scale::units`](crate::film::Scale::units).
    #[inline(always)]
    pub fn add(&mut self, filter: &PixelFilter, source: [i32; 2], square: DVec2, units: DVec4) {
        if self.waiting == ShortSum::MOST {
            self.carry();
        }
        self.waiting += 1;
        let at = self.area.index(source);
        self.counts[at] += 1;
        if let Some(sum) = self.unfiltered.get_mut(at) {
            *sum += units;
        }
        let width = self.reached.width();
        // The first pixel that the sample counts for is as far from the corner as the source.
        let [x, y] = [source[0] - self.area.x0, source[1] - self.area.y0];
        let sums = &mut self.sums[y as usize * width + x as usize..];
        if self.reached == self.area {
            sums[0] += units * filter.own(square);
            return;
        }
        filter.weigh(square, &mut self.weights);
        let [across, down] = &self.weights;
        // A sample seldom reaches the pixels on both edges.
        for (row, down) in sums.chunks_mut(width).zip(down).filter(|(_, down)| **down != 0.0) {
            let units = units * *down;
            row.iter_mut().zip(across).for_each(|(sum, across)| *sum += units * *across);
        }
    }

    /// Makes room for more samples.
    #[inline(never)]
    pub fn carry(&mut self) {
        let kinds =
            [(&mut self.sums, &mut self.carried), (&mut self.unfiltered, &mut self.unfiltered_carried)];
        for (sums, carried) in kinds {
            for (sum, carried) in sums.iter_mut().zip(carried) {
                std::mem::take(sum).add_to(carried);
            }
        }
        self.waiting = 0;
    }
}
