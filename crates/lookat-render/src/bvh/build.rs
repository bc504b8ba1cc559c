//! Builds the hierarchy by the binned surface area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
//! 2007), straight into nodes with eight children, on all threads.

use std::ops::Range;

use arrayvec::ArrayVec;
use glam::Vec3A;
use rayon::prelude::*;

use super::{Bvh, Child, Leaf, Node, WIDTH};
use crate::frame::Bounds;

/// An element to be sorted into a tree: its box, and which it is.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct Reference {
    min: [f32; 3],
    /// Among the triangles, or among the others.
    pub number: u32,
    max: [f32; 3],
    pub is_triangle: bool,
}

impl Reference {
    pub fn triangle(bounds: Bounds, number: u32) -> Self {
        Reference { min: bounds.min.into(), max: bounds.max.into(), number, is_triangle: true }
    }

    /// A reference to a non-triangle.
    pub fn non_triangle(bounds: Bounds, number: u32) -> Self {
        Reference { is_triangle: false, ..Reference::triangle(bounds, number) }
    }

    #[inline(always)]
    fn bounds(&self) -> Bounds {
        Bounds { min: self.min.into(), max: self.max.into() }
    }
}

/// The box around elements.
pub(crate) fn around(references: &[Reference]) -> Bounds {
    references.iter().fold(Bounds::EMPTY, |all, reference| all.union(reference.bounds()))
}

/// The result of [`build`].
pub(crate) struct Tree {
    pub bvh: Bvh,
    /// The number of triangles of each block. Blocks take triangles in the order of the sorted references.
    pub blocks: Vec<u8>,
}

/// Builds the tree over some elements. Sorts them so that the elements of a block are neighbors.
pub(crate) fn build(references: &mut [Reference]) -> Tree {
    // That many take more than a hundred gigabytes.
    assert!(references.len() < Child::MOST, "more than {} triangles and shapes", Child::MOST);
    let Some(whole) = ChildRange::whole(references) else {
        let bvh = Bvh { nodes: Vec::new(), root: Child::EMPTY, bounds: Bounds::EMPTY };
        return Tree { bvh, blocks: Vec::new() };
    };
    let bounds = whole.bounds;
    let (mut nodes, mut lengths) = (Vec::new(), vec![0; references.len()]);
    // Above few elements too, whose boxes keep most rays from them.
    let mut root = build_part(Elements { references, lengths: &mut lengths, first: 0 }, whole, &mut nodes);
    let mut number_at = vec![0; lengths.len()];
    let starts = lengths.iter().zip(&mut number_at).filter(|(length, _)| **length > 0);
    for ((_, number), block) in starts.zip(0..) {
        *number = block;
    }
    for child in nodes.iter_mut().flat_map(|node: &mut Node| &mut node.children).chain([&mut root]) {
        if *child != Child::EMPTY
            && child.as_inner().is_none()
            && let Leaf::Block(first) = child.as_leaf()
        {
            *child = Child::leaf(Leaf::Block(number_at[first]));
        }
    }
    lengths.retain(|length| *length > 0);
    Tree { bvh: Bvh { nodes, root, bounds }, blocks: lengths }
}

/// The elements of a part while it is built. Until all blocks are known, the number of a block is that of its first triangle.
struct Elements<'e> {
    references: &'e mut [Reference],
    /// The number of triangles of the block that starts at each element. 0 at other elements.
    lengths: &'e mut [u8],
    /// The number of the first element among all.
    first: usize,
}

impl<'e> Elements<'e> {
    fn split_at(self, at: usize) -> [Elements<'e>; 2] {
        let (references, other_references) = self.references.split_at_mut(at);
        let (lengths, other_lengths) = self.lengths.split_at_mut(at);
        let other = Elements { references: other_references, lengths: other_lengths, first: self.first + at };
        [Elements { references, lengths, first: self.first }, other]
    }
}

/// References that become one child.
#[derive(Debug, Clone)]
struct ChildRange {
    range: Range<usize>,
    bounds: Bounds,
    /// Splits on the way to it.
    depth: usize,
    is_final: bool,
}

impl ChildRange {
    fn whole(references: &[Reference]) -> Option<ChildRange> {
        let range = 0..references.len();
        let bounds = around(references);
        (!references.is_empty()).then_some(ChildRange { range, bounds, depth: 0, is_final: false })
    }
}

/// Parts of at least so many elements are built side by side.
const PARALLEL_PART: usize = 1 << 12;

/// Builds a part, and appends its nodes.
fn build_part(elements: Elements, part: ChildRange, nodes: &mut Vec<Node>) -> Child {
    let parts = split_into_children(elements.references, part);
    if parts.len() == 1 {
        return leaf(elements);
    }
    let at = nodes.len();
    let bounds = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| parts.get(i).map_or(Bounds::EMPTY, |part| part.bounds));
    let planes = |axis: usize| [bounds.map(|bounds| bounds.min[axis]), bounds.map(|bounds| bounds.max[axis])];
    nodes.push(Node { planes: [planes(0), planes(1), planes(2)], children: [Child::EMPTY; WIDTH] });
    let count = elements.references.len();
    let mut jobs = ArrayVec::<_, WIDTH>::new();
    let mut rest = elements;
    for (lane, part) in parts.into_iter().enumerate() {
        let [own, after] = rest.split_at(part.range.len());
        jobs.push((lane, own, ChildRange { range: 0..part.range.len(), ..part }));
        rest = after;
    }
    if count < PARALLEL_PART {
        for (lane, own, part) in jobs {
            nodes[at].children[lane] = build_child(own, part, nodes);
        }
        return Child::inner(at);
    }
    let subtrees: Vec<_> = jobs
        .into_iter()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(lane, own, part)| {
            let mut nodes = Vec::new();
            (lane, build_child(own, part, &mut nodes), nodes)
        })
        .collect();
    for (lane, root, subtree) in subtrees {
        let base = nodes.len();
        nodes[at].children[lane] = moved(root, base);
        // Its nodes count their children from its start.
        nodes.extend(
            subtree
                .into_iter()
                .map(|node| Node { children: node.children.map(|child| moved(child, base)), ..node }),
        );
    }
    Child::inner(at)
}

fn build_child(elements: Elements, part: ChildRange, nodes: &mut Vec<Node>) -> Child {
    // A node above what fits into a block would be one thing more to visit.
    if part.is_final || fits_block(elements.references) {
        leaf(elements)
    } else {
        build_part(elements, part, nodes)
    }
}

fn leaf(Elements { references, lengths, first }: Elements) -> Child {
    match references {
        [other] if !other.is_triangle => Child::leaf(Leaf::NonTriangle(other.number as usize)),
        _ => {
            lengths[0] = references.len() as u8;
            Child::leaf(Leaf::Block(first))
        }
    }
}

/// Splits the part with the largest surface until there are eight, or all are leaves; in the order of their ranges.
fn split_into_children(references: &mut [Reference], whole: ChildRange) -> ArrayVec<ChildRange, WIDTH> {
    let mut parts = ArrayVec::<ChildRange, WIDTH>::new();
    parts.push(whole);
    while parts.len() < WIDTH {
        let open = parts.iter().enumerate().filter(|(_, part)| !part.is_final);
        let largest = open.max_by(|(_, a), (_, b)| a.bounds.half_area().total_cmp(&b.bounds.half_area()));
        let Some(at) = largest.map(|(at, _)| at) else { break };
        let ChildRange { range, bounds, depth, .. } = parts[at].clone();
        match split(&mut references[range.clone()], &bounds, depth) {
            None => parts[at].is_final = true,
            Some((left, bounds)) => {
                let middle = range.start + left;
                let part = |range, bounds| ChildRange { range, bounds, depth: depth + 1, is_final: false };
                parts[at] = part(range.start..middle, bounds[0]);
                parts.insert(at + 1, part(middle..range.end, bounds[1]));
            }
        }
    }
    parts
}

fn moved(child: Child, base: usize) -> Child {
    child.as_inner().map_or(child, |node| Child::inner(node + base))
}

const BINS: usize = 16;

/// The mapping from the middles of elements to bins.
#[derive(Debug, Clone, Copy)]
struct Binning {
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

/// The bins along each axis.
#[derive(Debug, Clone, Copy)]
struct Bins([[Bin; BINS]; 3]);

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
struct Split {
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

/// Below so many splits elements are halved, whatever it costs, so that the tree stays shallow.
const HALVING_DEPTH: usize = 48;
/// From so many elements on, one split is made by all threads.
const PARALLEL_SPLIT: usize = 1 << 15;

/// Sorts references into two parts: the length of the first, and the boxes of both. `None` where they are a leaf.
fn split(references: &mut [Reference], bounds: &Bounds, depth: usize) -> Option<(usize, [Bounds; 2])> {
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

/// True if these are triangles, and few enough for one block.
fn fits_block(references: &[Reference]) -> bool {
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
        for reference in references {
            add(&mut sum, reference);
        }
        sum
    };
    if references.len() < PARALLEL_SPLIT {
        return sum(references);
    }
    let sums: Vec<T> = references.par_chunks(PARALLEL_SPLIT / 2).map(sum).collect();
    let mut all = empty.clone();
    for sum in &sums {
        join(&mut all, sum);
    }
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
