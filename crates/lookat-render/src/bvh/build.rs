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
    let (mut nodes, mut lengths) = (Vec::new(), vec![0; references.len()]);
    // Above few elements too, whose boxes keep most rays from them.
    let mut root = build_part(Elements { references, lengths: &mut lengths, first: 0 }, whole, &mut nodes);
    let mut number_at = vec![0; lengths.len()];
    let starts = lengths.iter().zip(&mut number_at).filter(|(length, _)| **length > 0);
    starts.zip(0..).for_each(|((_, number), block)| *number = block);
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
    /// How many triangles the block has that starts at an element. 0 at other elements.
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

/// Builds a part, and appends its nodes.
fn build_part(elements: Elements, part: Part, nodes: &mut Vec<Node>) -> Child {
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
        jobs.push((lane, own, Part { range: 0..part.range.len(), ..part }));
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

fn build_child(elements: Elements, part: Part, nodes: &mut Vec<Node>) -> Child {
    // A node above what fits into a block would be one thing more to visit.
    match part.is_final || fits_block(elements.references) {
        true => leaf(elements),
        false => build_part(elements, part, nodes),
    }
}

fn leaf(Elements { references, lengths, first }: Elements) -> Child {
    match references {
        [other] if !other.is_triangle => Child::leaf(Leaf::Other(other.number as usize)),
        _ => {
            lengths[0] = references.len() as u8;
            Child::leaf(Leaf::Block(first))
        }
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

fn moved(child: Child, base: usize) -> Child {
    child.as_inner().map_or(child, |node| Child::inner(node + base))
}
