//! Where a part of the elements is split in two.

use rayon::prelude::*;

use super::bins::{Binning, Bins};
use super::{Reference, around};
use crate::bounds::Bounds;
use crate::bvh::WIDTH;

/// Below so many splits elements are halved, whatever it costs, so that the tree stays shallow.
const HALVING_DEPTH: usize = 48;
/// From so many elements on, one split is made by all threads.
const PARALLEL_SPLIT: usize = 1 << 15;

/// Sorts references into two parts: the length of the first, and the boxes of both. `None` where they are a leaf.
pub(super) fn split(
    references: &mut [Reference],
    bounds: &Bounds,
    depth: usize,
) -> Option<(usize, [Bounds; 2])> {
    if references.len() <= 1 {
        return None;
    }
    let may_be_leaf = fits_block(references);
    let centers = fold(references, Bounds::EMPTY, add_center, |all, other| *all = all.union(*other));
    let binning = Binning::new(&centers, references.len());
    let bins = fold(references, Bins::EMPTY, |bins, reference| bins.add(&binning, reference), Bins::join);
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
            Some((middle, [around(left), around(right)]))
        }
    }
}

fn add_center(all: &mut Bounds, reference: &Reference) {
    let center = reference.bounds().center();
    *all = all.union(Bounds { min: center, max: center });
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
