//! Where a part of the elements is split in two.

use glam::Vec3A;
use rayon::prelude::*;

use super::Reference;
use super::bins::{Binning, Bins};
use crate::bounds::Bounds;
use crate::bvh::WIDTH;

/// A box, for quick unions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aabb {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Aabb {
    pub const EMPTY: Aabb = Aabb { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    #[inline(always)]
    pub fn of(reference: &Reference) -> Self {
        Aabb { min: Vec3A::from_array(reference.min), max: Vec3A::from_array(reference.max) }
    }

    pub fn around(references: &[Reference]) -> Self {
        references.iter().fold(Aabb::EMPTY, |all, reference| all.union(Aabb::of(reference)))
    }

    #[inline(always)]
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface; 0 for an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f64 {
        let side = (self.max.min(Vec3A::MAX) - self.min.max(Vec3A::MIN)).as_dvec3();
        if side.x < 0.0 { 0.0 } else { side.x * side.y + side.y * side.z + side.z * side.x }
    }

    /// The middle, within the finite numbers.
    #[inline(always)]
    pub fn center(&self) -> Vec3A {
        self.min.max(Vec3A::MIN) * 0.5 + self.max.min(Vec3A::MAX) * 0.5
    }

    #[inline(always)]
    pub fn add_center(&mut self, reference: &Reference) {
        let center = Aabb::of(reference).center();
        *self = self.union(Aabb { min: center, max: center });
    }
}

impl From<Aabb> for Bounds {
    fn from(aabb: Aabb) -> Bounds {
        Bounds { min: aabb.min.to_array(), max: aabb.max.to_array() }
    }
}

/// Below so many splits elements are halved, whatever it costs, so that the tree stays shallow.
const HALVING_DEPTH: usize = 48;
/// From so many elements on, one split is made by all threads.
const PARALLEL_SPLIT: usize = 1 << 15;

/// Sorts references into two parts: the length of the first, and the boxes of both. `None` where they are a leaf.
pub(super) fn split(references: &mut [Reference], bounds: &Aabb, depth: usize) -> Option<(usize, [Aabb; 2])> {
    if references.len() <= 1 {
        return None;
    }
    let may_be_leaf = fits_block(references);
    let centers = fold(references, Aabb::EMPTY, Aabb::add_center, |all, other| *all = all.union(*other));
    let binning = Binning::new(&centers, references.len());
    let bins = fold(references, Bins::default(), |bins, reference| bins.add(&binning, reference), Bins::join);
    let best = if depth < HALVING_DEPTH { bins.best_split(&binning) } else { None };
    match best {
        // A block costs the same, however many triangles are in it.
        Some(split) if may_be_leaf && split.area >= 0.8 * bounds.half_area() => None,
        Some(split) => {
            let middle = partition(references, |reference| binning.bin(reference)[split.axis] <= split.bin);
            Some((middle, split.bounds))
        }
        None if may_be_leaf => None,
        None => {
            let middle = references.len() / 2;
            let (left, right) = references.split_at(middle);
            Some((middle, [Aabb::around(left), Aabb::around(right)]))
        }
    }
}

/// Whether these are triangles, and few enough for one block.
pub(super) fn fits_block(references: &[Reference]) -> bool {
    references.len() <= WIDTH && references.iter().all(|reference| reference.is_triangle)
}

/// Adds up references: in parts side by side, where there are many.
fn fold<T: Clone + Send + Sync>(
    references: &[Reference],
    empty: T,
    add: impl Fn(&mut T, &Reference) + Sync,
    join: impl Fn(&mut T, &T) + Sync,
) -> T {
    let sum = |references: &[Reference]| {
        let mut sum = empty.clone();
        references.iter().for_each(|reference| add(&mut sum, reference));
        sum
    };
    if references.len() < PARALLEL_SPLIT {
        return sum(references);
    }
    let sums: Vec<T> = references.par_chunks(PARALLEL_SPLIT / 2).map(sum).collect();
    let mut all = empty.clone();
    sums.iter().for_each(|sum| join(&mut all, sum));
    all
}

/// Brings the references that satisfy `first` to the front, in place; gives their number.
fn partition(references: &mut [Reference], first: impl Fn(&Reference) -> bool) -> usize {
    let (mut low, mut high) = (0, references.len());
    loop {
        while low < high && first(&references[low]) {
            low += 1;
        }
        while low < high && !first(&references[high - 1]) {
            high -= 1;
        }
        if low >= high {
            return low;
        }
        references.swap(low, high - 1);
    }
}
