//! Counting elements in bins along the axes, to find the cheapest plane between them.

use glam::Vec3A;

use super::Reference;
use crate::bounds::Bounds;

const BINS: usize = 16;

/// Which bins the middles of elements fall into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binning {
    /// Half of the least middle: differences of halves are finite.
    half_low: Vec3A,
    scale: Vec3A,
    count: usize,
    /// Axes along which the middles differ.
    is_wide: [bool; 3],
}

impl Binning {
    /// For so many elements, whose middles lie in a box.
    pub fn new(centers: &Bounds, elements: usize) -> Self {
        // Few elements need few bins.
        let count = (4 + elements / 8).min(BINS);
        let extent = centers.max * 0.5 - centers.min * 0.5;
        // Just less than the number of bins, so that the greatest falls into the last.
        let scale = Vec3A::splat(count as f32 * 0.999_999) / extent;
        let is_wide = [0, 1, 2].map(|axis| extent[axis] > 0.0 && scale[axis].is_finite());
        Binning { half_low: centers.min * 0.5, scale, count, is_wide }
    }

    #[inline(always)]
    pub fn bin(&self, reference: &Reference) -> [usize; 3] {
        let place = (reference.bounds().center() * 0.5 - self.half_low) * self.scale - 0.5;
        // Sums with 2^23 are rounded to whole numbers, which then stand in the last bits. Casts take longer.
        let whole =
            place.max(Vec3A::ZERO).min(Vec3A::splat((self.count - 1) as f32)) + Vec3A::splat(8_388_608.0);
        whole.to_array().map(|whole| whole.to_bits() as usize % BINS)
    }
}

/// What lies in the bins along each axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bins([[Bin; BINS]; 3]);

#[derive(Debug, Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: u32,
}

impl Bin {
    const EMPTY: Bin = Bin { bounds: Bounds::EMPTY, count: 0 };

    fn join(self, other: Bin) -> Bin {
        Bin { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    fn cost(&self) -> f64 {
        self.bounds.half_area() * f64::from(self.count)
    }
}

/// Between two bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Split {
    pub axis: usize,
    /// The last bin of the first part.
    pub bin: usize,
    pub bounds: [Bounds; 2],
    /// Half the surface of both parts.
    pub area: f64,
}

impl Bins {
    pub const EMPTY: Bins = Bins([[Bin::EMPTY; BINS]; 3]);

    #[inline(always)]
    pub fn add(&mut self, binning: &Binning, reference: &Reference) {
        let own = reference.bounds();
        for (axis, bin) in binning.bin(reference).into_iter().enumerate() {
            let bin = &mut self.0[axis][bin];
            bin.bounds = bin.bounds.union(own);
            bin.count += 1;
        }
    }

    pub fn join(&mut self, other: &Bins) {
        for (own, other) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *own = own.join(*other);
        }
    }

    /// The plane of least cost. `None` where no two elements can be told apart.
    pub fn best_split(&self, binning: &Binning) -> Option<Split> {
        let mut best: Option<(f64, Split)> = None;
        for axis in (0..3).filter(|axis| binning.is_wide[*axis]) {
            let bins = &self.0[axis][..binning.count];
            let mut right = [Bin::EMPTY; BINS];
            let mut sum = Bin::EMPTY;
            for at in (1..bins.len()).rev() {
                sum = sum.join(bins[at]);
                right[at - 1] = sum;
            }
            let mut left = Bin::EMPTY;
            for (bin, own) in bins[..bins.len() - 1].iter().enumerate() {
                left = left.join(*own);
                let right = right[bin];
                let cost = left.cost() + right.cost();
                let is_better = best.as_ref().is_none_or(|(least, _)| cost < *least);
                if left.count > 0 && right.count > 0 && cost.is_finite() && is_better {
                    let bounds = [left.bounds, right.bounds];
                    let area = bounds[0].half_area() + bounds[1].half_area();
                    best = Some((cost, Split { axis, bin, bounds, area }));
                }
            }
        }
        best.map(|(_, split)| split)
    }
}
