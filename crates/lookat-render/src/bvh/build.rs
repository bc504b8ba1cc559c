//! Building the tree: binned surface area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies",
//! 2007), straight into nodes of eight children, on all threads.

mod bins;
mod split;

use std::ops::Range;

use arrayvec::ArrayVec;
use rayon::prelude::*;

use super::{Bvh, Child, Leaf, Node, WIDTH};
use crate::bounds::Bounds;
use split::{fits_block, split};

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

    /// Of what is no triangle.
    pub fn other(bounds: Bounds, number: u32) -> Self {
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

/// What [`build`] gives.
pub(crate) struct Tree {
    pub bvh: Bvh,
    /// How many triangles each block has: of the triangles among the references, which are sorted, the next ones.
    pub blocks: Vec<u8>,
}

/// Builds the tree over some elements. Sorts them so that the elements of a block are neighbors.
pub(crate) fn build(references: &mut [Reference]) -> Tree {
    // That many take more than a hundred gigabytes.
    assert!(references.len() < Child::MOST, "more than {} triangles and shapes", Child::MOST);
    let Some(whole) = Part::whole(references) else {
        let bvh = Bvh { nodes: Vec::new(), root: Child::EMPTY, bounds: Bounds::EMPTY };
        return Tree { bvh, blocks: Vec::new() };
    };
    let bounds = whole.bounds;
    let mut branches = Vec::new();
    // Above few elements too, whose boxes keep most rays from them.
    let root = build_part(references, 0, whole, &mut branches);
    let children = || branches.iter().flat_map(|branch| &branch.children).chain([&root]);
    // Blocks are numbered as their triangles are sorted.
    let mut length_at = vec![0; references.len()];
    children().for_each(|child| {
        if let Built::Block(range) = child {
            length_at[range.start] = range.len() as u8;
        }
    });
    let blocks: Vec<u8> = length_at.iter().copied().filter(|length| *length > 0).collect();
    let mut number_at = vec![0; references.len()];
    let starts = length_at.iter().zip(&mut number_at).filter(|(length, _)| **length > 0);
    starts.zip(0..).for_each(|((_, number), block)| *number = block);
    let numbered = |child: &Built| match child {
        Built::Empty => Child::EMPTY,
        Built::Inner(node) => Child::inner(*node),
        Built::Other(number) => Child::leaf(Leaf::Other(*number)),
        Built::Block(range) => Child::leaf(Leaf::Block(number_at[range.start])),
    };
    let nodes = branches.iter().map(|branch| branch.node(&numbered)).collect();
    Tree { bvh: Bvh { nodes, root: numbered(&root), bounds }, blocks }
}

/// A child whose block has no number yet.
#[derive(Debug, Clone)]
enum Built {
    Empty,
    Inner(usize),
    Block(Range<usize>),
    Other(usize),
}

/// A node while it is built.
#[derive(Debug, Clone)]
struct Branch {
    bounds: [Bounds; WIDTH],
    children: [Built; WIDTH],
}

impl Branch {
    fn node(&self, numbered: &impl Fn(&Built) -> Child) -> Node {
        let planes = |axis: usize| {
            [self.bounds.map(|bounds| bounds.min[axis]), self.bounds.map(|bounds| bounds.max[axis])]
        };
        Node {
            planes: [planes(0), planes(1), planes(2)],
            children: [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| numbered(&self.children[lane])),
        }
    }
}

/// References that become one child.
#[derive(Debug, Clone)]
struct Part {
    range: Range<usize>,
    bounds: Bounds,
    /// Splits on the way to it.
    depth: usize,
    is_final: bool,
}

impl Part {
    fn whole(references: &[Reference]) -> Option<Part> {
        let range = 0..references.len();
        let bounds = around(references);
        (!references.is_empty()).then_some(Part { range, bounds, depth: 0, is_final: false })
    }
}

/// Parts of at least so many elements are built side by side.
const PARALLEL_PART: usize = 1 << 12;

/// Builds a part of `references`, which are numbered from `base` on.
fn build_part(references: &mut [Reference], base: usize, part: Part, branches: &mut Vec<Branch>) -> Built {
    let parts = split_into_children(references, part);
    if parts.len() == 1 {
        return leaf(references, base);
    }
    let at = branches.len();
    let bounds = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| parts.get(i).map_or(Bounds::EMPTY, |part| part.bounds));
    branches.push(Branch { bounds, children: [const { Built::Empty }; WIDTH] });
    let mut jobs = ArrayVec::<_, WIDTH>::new();
    let (mut rest, mut taken) = (references, 0);
    for (lane, part) in parts.into_iter().enumerate() {
        let (own, after) = rest.split_at_mut(part.range.len());
        jobs.push((lane, own, base + taken, Part { range: 0..part.range.len(), ..part }));
        (rest, taken) = (after, part.range.end);
    }
    if taken < PARALLEL_PART {
        for (lane, own, base, part) in jobs {
            branches[at].children[lane] = build_child(own, base, part, branches);
        }
        return Built::Inner(at);
    }
    let subtrees: Vec<_> = jobs
        .into_iter()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|(lane, own, base, part)| {
            let mut branches = Vec::new();
            (lane, build_child(own, base, part, &mut branches), branches)
        })
        .collect();
    for (lane, root, subtree) in subtrees {
        branches[at].children[lane] = moved(root, branches.len());
        append(branches, subtree);
    }
    Built::Inner(at)
}

fn build_child(references: &mut [Reference], base: usize, part: Part, branches: &mut Vec<Branch>) -> Built {
    // A node above what fits into a block would be one thing more to visit.
    match part.is_final || fits_block(references) {
        true => leaf(references, base),
        false => build_part(references, base, part, branches),
    }
}

fn leaf(references: &[Reference], base: usize) -> Built {
    match references {
        [other] if !other.is_triangle => Built::Other(other.number as usize),
        _ => Built::Block(base..base + references.len()),
    }
}

/// Splits the part with the largest surface until there are eight, or all are leaves; in the order of their ranges.
fn split_into_children(references: &mut [Reference], whole: Part) -> ArrayVec<Part, WIDTH> {
    let mut parts = ArrayVec::<Part, WIDTH>::new();
    parts.push(whole);
    while parts.len() < WIDTH {
        let open = parts.iter().enumerate().filter(|(_, part)| !part.is_final);
        let largest = open.max_by(|(_, a), (_, b)| a.bounds.half_area().total_cmp(&b.bounds.half_area()));
        let Some(at) = largest.map(|(at, _)| at) else { break };
        let Part { range, bounds, depth, .. } = parts[at].clone();
        match split(&mut references[range.clone()], &bounds, depth) {
            None => parts[at].is_final = true,
            Some((left, bounds)) => {
                let middle = range.start + left;
                let part = |range, bounds| Part { range, bounds, depth: depth + 1, is_final: false };
                parts[at] = part(range.start..middle, bounds[0]);
                parts.insert(at + 1, part(middle..range.end, bounds[1]));
            }
        }
    }
    parts
}

/// Appends a tree that was built on its own: its nodes count their children from its start.
fn append(branches: &mut Vec<Branch>, subtree: Vec<Branch>) {
    let base = branches.len();
    branches.extend(
        subtree
            .into_iter()
            .map(|branch| Branch { children: branch.children.map(|child| moved(child, base)), ..branch }),
    );
}

fn moved(child: Built, base: usize) -> Built {
    match child {
        Built::Inner(node) => Built::Inner(node + base),
        other => other,
    }
}
