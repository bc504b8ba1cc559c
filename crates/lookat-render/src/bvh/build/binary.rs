//! The binary tree, by binned splits (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).

use glam::Vec3A;
use rayon::prelude::*;

use super::{BinaryNode, NONE, Reference, Size};
use crate::bvh::{Child, Leaf, WIDTH};
use crate::frame::Bounds;

/// Sorts elements into a tree. Returns the nodes, the root first, and the number of triangles of each block.
pub(super) fn build(references: &mut [Reference]) -> (Vec<BinaryNode>, Vec<u8>) {
    let (extent, mut lengths, mut nodes) = (Extent::of(references), vec![0; references.len()], Vec::new());
    let part = Part { references, lengths: &mut lengths, first: 0, extent, depth: 0 };
    part.build(&mut nodes, &mut Bins::empty());
    lengths.retain(|length| *length > 0);
    link(&mut nodes);
    (nodes, lengths)
}

/// Numbers the blocks, in the order of their elements, and links nodes, whose second children are given by their distance.
fn link(nodes: &mut [BinaryNode]) {
    let mut blocks = 0;
    for at in 0..nodes.len() {
        match nodes[at].leaf().map(Child::as_leaf) {
            None => {
                let children = [at + 1, at + nodes[at].children[1] as usize];
                nodes[at].children = children.map(|child| child as u32);
                for child in children {
                    nodes[child].parent = at as u32;
                }
            }
            Some(Leaf::Block(_)) => {
                nodes[at].children[1] = Child::leaf(Leaf::Block(blocks)).0;
                blocks += 1;
            }
            Some(Leaf::NonTriangle(_)) => {}
        }
    }
}

/// The elements below a node.
struct Part<'e> {
    references: &'e mut [Reference],
    /// The number of triangles of the block that starts at each element.
    lengths: &'e mut [u8],
    /// The number of the first element among all, which stands for the number of its block.
    first: usize,
    extent: Extent,
    /// Splits on the way to it.
    depth: usize,
}

/// Parts of at least so many elements are built side by side.
const PARALLEL_PART: usize = 1 << 12;

impl Part<'_> {
    /// Appends its nodes, each followed by its first child.
    fn build(self, nodes: &mut Vec<BinaryNode>, bins: &mut Bins) {
        let at = nodes.len();
        let Bounds { min, max } = self.extent.bounds;
        nodes.push(BinaryNode { min: min.into(), max: max.into(), children: [NONE; 2], parent: NONE });
        let Some((middle, extents)) = split(self.references, &self.extent, self.depth, bins) else {
            nodes[at].children[1] = self.leaf().0;
            return;
        };
        let count = self.references.len();
        let [first, second] = self.split_at(middle, extents);
        let mut others = Vec::new();
        if count < PARALLEL_PART {
            first.build(nodes, bins);
            nodes[at].children = [0, (nodes.len() - at) as u32];
            second.build(nodes, bins);
        } else {
            rayon::join(|| first.build(nodes, bins), || second.build(&mut others, &mut Bins::empty()));
            nodes[at].children = [0, (nodes.len() - at) as u32];
            nodes.append(&mut others);
        }
    }

    fn leaf(self) -> Child {
        match self.references {
            [other] if !other.is_triangle() => Child::leaf(Leaf::NonTriangle(other.number() as usize)),
            _ => {
                self.lengths[0] = self.references.len() as u8;
                Child::leaf(Leaf::Block(self.first))
            }
        }
    }

    fn split_at(self, middle: usize, [extent, other_extent]: [Extent; 2]) -> [Self; 2] {
        let (references, other_references) = self.references.split_at_mut(middle);
        let (lengths, other_lengths) = self.lengths.split_at_mut(middle);
        let (first, depth) = (self.first, self.depth + 1);
        let other = Part {
            references: other_references,
            lengths: other_lengths,
            first: first + middle,
            extent: other_extent,
            depth,
        };
        [Part { references, lengths, first, extent, depth }, other]
    }
}

/// The box around elements, and the box around their middles.
#[derive(Debug, Clone, Copy)]
struct Extent {
    bounds: Bounds,
    centers: Bounds,
}

impl Extent {
    const EMPTY: Extent = Extent { bounds: Bounds::EMPTY, centers: Bounds::EMPTY };

    fn of(references: &[Reference]) -> Self {
        let of = |references: &[Reference]| {
            let add = |all: Extent, reference: &Reference| {
                let (bounds, center) = (reference.bounds(), reference.bounds().center());
                all.union(Extent { bounds, centers: Bounds { min: center, max: center } })
            };
            references.iter().fold(Extent::EMPTY, add)
        };
        references.par_chunks(PARALLEL_SPLIT).map(of).reduce(|| Extent::EMPTY, Extent::union)
    }

    fn union(self, other: Extent) -> Self {
        Extent { bounds: self.bounds.union(other.bounds), centers: self.centers.union(other.centers) }
    }
}

const BINS: usize = 16;

/// The mapping from the middles of elements to bins.
#[derive(Debug, Clone, Copy)]
struct Binning {
    /// Half of the least middle: differences of halves are finite.
    half_low: Vec3A,
    scale: Vec3A,
    count: usize,
    /// Axes along which the middles differ, which are tried.
    is_wide: [bool; 3],
}

/// Sums with 2^23 are rounded to whole numbers, which then stand in the last bits. Casts take longer.
const WHOLE: f32 = 8_388_608.0;

impl Binning {
    /// For so many elements, whose middles lie in a box.
    fn new(centers: &Bounds, elements: usize) -> Self {
        // Few elements need few bins.
        let count = (4 + elements / 8).min(BINS);
        let extent = centers.max * 0.5 - centers.min * 0.5;
        // Just less than the number of bins, so that the greatest falls into the last.
        let scale = Vec3A::splat(count as f32 * 0.999_999) / extent;
        // For what nearly always is one block, one axis is enough.
        let least = if elements > WIDTH { f32::MIN_POSITIVE } else { extent.max_element() };
        let is_wide = [0, 1, 2].map(|axis| extent[axis] >= least && scale[axis].is_finite());
        // Along the other axes all are in one bin: products with infinity would be no numbers, whose maxima differ between processors.
        let scale = Vec3A::select(is_wide.into(), scale, Vec3A::ZERO);
        Binning { half_low: centers.min * 0.5, scale, count, is_wide }
    }

    /// The bins of an element of a middle, along each axis, plus [`WHOLE`].
    #[inline(always)]
    fn bins(&self, center: Vec3A) -> Vec3A {
        let place = (center * 0.5 - self.half_low) * self.scale - 0.5;
        place.max(Vec3A::ZERO).min(Vec3A::splat((self.count - 1) as f32)) + WHOLE
    }
}

/// What is in each bin along each axis.
#[derive(Debug, Clone)]
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    /// Triangles, and for each other element as many as a block has.
    counts: [[u32; BINS]; 3],
}

/// Between two bins.
#[derive(Debug, Clone, Copy)]
struct Split {
    axis: usize,
    /// The last bin of the first part.
    bin: usize,
    bounds: [Bounds; 2],
}

/// From so many elements on, one split is made by all threads.
const PARALLEL_SPLIT: usize = 1 << 15;

impl Bins {
    fn empty() -> Self {
        Bins { bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] }
    }

    /// Fills them anew.
    fn fill(&mut self, references: &[Reference], binning: &Binning) {
        for axis in 0..3 {
            self.bounds[axis][..binning.count].fill(Bounds::EMPTY);
            self.counts[axis][..binning.count].fill(0);
        }
        if references.len() < PARALLEL_SPLIT {
            for reference in references {
                let own = reference.bounds();
                let count = if reference.is_triangle() { 1 } else { WIDTH as u32 };
                for (axis, bin) in binning.bins(own.center()).to_array().into_iter().enumerate() {
                    let bin = bin.to_bits() as usize % BINS;
                    let bounds = &mut self.bounds[axis][bin];
                    *bounds = bounds.union(own);
                    self.counts[axis][bin] += count;
                }
            }
            return;
        }
        let parts: Vec<Bins> = references
            .par_chunks(PARALLEL_SPLIT / 2)
            .map(|part| {
                let mut bins = Bins::empty();
                bins.fill(part, binning);
                bins
            })
            .collect();
        for part in &parts {
            let bounds = self.bounds.iter_mut().flatten().zip(part.bounds.iter().flatten());
            bounds.for_each(|(own, other)| *own = own.union(*other));
            let counts = self.counts.iter_mut().flatten().zip(part.counts.iter().flatten());
            counts.for_each(|(own, other)| *own += other);
        }
    }

    /// The plane of least cost. `None` where no two elements can be told apart.
    fn best_split(&self, binning: &Binning, size: Size) -> Option<Split> {
        // What is without elements is no number, and is never less.
        let cost = |bounds: Bounds, count: u32| size.area(bounds) * count.div_ceil(WIDTH as u32) as f32;
        let mut best = (f32::INFINITY, None);
        for axis in (0..3).filter(|axis| binning.is_wide[*axis]) {
            let bins = || self.bounds[axis][..binning.count].iter().zip(&self.counts[axis]).enumerate();
            let mut after = [0.0; BINS];
            let (mut sum, mut count) = (Bounds::EMPTY, 0);
            for (bin, (bounds, own)) in bins().skip(1).rev() {
                (sum, count) = (sum.union(*bounds), count + own);
                after[bin - 1] = cost(sum, count);
            }
            (sum, count) = (Bounds::EMPTY, 0);
            for (bin, (bounds, own)) in bins().take(binning.count - 1) {
                (sum, count) = (sum.union(*bounds), count + own);
                let both = cost(sum, count) + after[bin];
                if both < best.0 {
                    best = (both, Some((axis, bin)));
                }
            }
        }
        let (axis, bin) = best.1?;
        let (first, second) = self.bounds[axis][..binning.count].split_at(bin + 1);
        let around = |bins: &[Bounds]| bins.iter().fold(Bounds::EMPTY, |all, own| all.union(*own));
        Some(Split { axis, bin, bounds: [around(first), around(second)] })
    }
}

/// Below so many splits elements are halved, whatever it costs, so that the tree stays shallow.
const HALVING_DEPTH: usize = 48;
/// Splits of few triangles pay only where the surface of both parts together is this share of that of the whole, or less.
const LEAF_SHARE: f32 = 0.8;

/// Sorts references into two parts: the length of the first, and the extents of both. `None` where they are a leaf.
fn split(
    references: &mut [Reference],
    extent: &Extent,
    depth: usize,
    bins: &mut Bins,
) -> Option<(usize, [Extent; 2])> {
    if references.len() <= 1 {
        return None;
    }
    let (binning, size) = (Binning::new(&extent.centers, references.len()), Size::of(&extent.bounds));
    bins.fill(references, &binning);
    let best = if depth < HALVING_DEPTH { bins.best_split(&binning, size) } else { None };
    // A block costs the same, however many triangles are in it.
    if fits_block(references) {
        let area = |split: &Split| split.bounds.iter().map(|bounds| size.area(*bounds)).sum::<f32>();
        best.filter(|split| area(split) < LEAF_SHARE * size.area(extent.bounds))?;
    }
    let Some(Split { axis, bin, bounds }) = best else {
        let middle = references.len() / 2;
        let (first, second) = references.split_at(middle);
        return Some((middle, [Extent::of(first), Extent::of(second)]));
    };
    let (middle, centers) = partition(references, &binning, axis, bin);
    let part = |at: usize| Extent { bounds: bounds[at], centers: centers[at] };
    Some((middle, [part(0), part(1)]))
}

/// True if these are triangles, and few enough for one block.
fn fits_block(references: &[Reference]) -> bool {
    references.len() <= WIDTH && references.iter().all(Reference::is_triangle)
}

/// Brings the references in bins up to `bin` to the front. Gives their number, and the boxes around the middles of these and of the others.
/// Without branches: which are first cannot be foretold.
fn partition(
    references: &mut [Reference],
    binning: &Binning,
    axis: usize,
    bin: usize,
) -> (usize, [Bounds; 2]) {
    let mut last = Vec3A::INFINITY;
    last[axis] = bin as f32 + WHOLE;
    let (mut middle, mut centers) = (0, [Bounds::EMPTY; 2]);
    for at in 0..references.len() {
        let center = references[at].bounds().center();
        let is_first = binning.bins(center).cmple(last).all();
        references.swap(at, middle);
        middle += usize::from(is_first);
        // What leaves a box as it is where the other box gets the middle.
        let (out, own) = (Vec3A::splat(if is_first { f32::NEG_INFINITY } else { f32::INFINITY }), center);
        centers[0] = centers[0].union(Bounds { min: own.max(out), max: own.min(-out) });
        centers[1] = centers[1].union(Bounds { min: own.max(-out), max: own.min(out) });
    }
    (middle, centers)
}
