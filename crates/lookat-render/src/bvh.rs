//! A bounding volume hierarchy: which elements a ray may meet.

mod build;
mod slabs;

use arrayvec::ArrayVec;

use crate::bounds::Bounds;
use crate::prefetch::prefetch;
pub(crate) use build::{Reference, around, build};
pub(crate) use slabs::exact::{BoxRays, within_box};
pub(crate) use slabs::{SlabRays, Slabs};

/// Children of a node, and triangles of a block: what one instruction computes.
pub(crate) const WIDTH: usize = 8;

/// Boxes of up to eight children, plane by plane, so that one instruction tests all.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// The planes of least and of greatest x, of y and of z.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    pub children: [Child; WIDTH],
}

/// An inner node, a leaf or nothing, as one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Child(u32);

/// What a leaf holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Leaf {
    /// The number of a block of triangles.
    Block(usize),
    /// The number of something else.
    Other(usize),
}

impl Child {
    const LEAF: u32 = 1 << 31;
    const OTHER: u32 = 1 << 30;
    const EMPTY: Child = Child(u32::MAX);
    /// Fewer elements than that can be numbered, and in as many blocks the places of triangles (`triangle::block::place`).
    const MOST: usize = u32::MAX as usize / WIDTH;

    fn inner(node: usize) -> Self {
        Child(node as u32)
    }

    fn leaf(leaf: Leaf) -> Self {
        match leaf {
            Leaf::Block(number) => Child(number as u32 | Child::LEAF),
            Leaf::Other(number) => Child(number as u32 | Child::LEAF | Child::OTHER),
        }
    }

    #[inline(always)]
    fn as_inner(self) -> Option<usize> {
        (self.0 & Child::LEAF == 0).then_some(self.0 as usize)
    }

    #[inline(always)]
    fn as_leaf(self) -> Leaf {
        let number = (self.0 & (Child::OTHER - 1)) as usize;
        if self.0 & Child::OTHER == 0 { Leaf::Block(number) } else { Leaf::Other(number) }
    }
}

/// A tree of boxes over elements that the owner keeps.
#[derive(Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    root: Child,
    pub bounds: Bounds,
}

/// A tree is never deeper than this; see `build`.
const MAX_DEPTH: usize = 88;
/// All children but one of each node on the way down may wait.
const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

impl Bvh {
    /// How many nodes there are; none where one leaf holds all.
    pub fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// The most nodes on a way from the root to a leaf.
    pub fn depth(&self) -> usize {
        let (mut depth, mut level) = (0, vec![self.root]);
        loop {
            let nodes = level.iter().filter_map(|child| child.as_inner());
            level = nodes.flat_map(|node| self.nodes[node].children).collect();
            if level.is_empty() {
                return depth;
            }
            depth += 1;
        }
    }

    /// Calls `visit` with each leaf that a ray may meet before `t_max`: about from near to far or, where `ANY` hit will do, in
    /// any order. `visit` gives the new limit, or `None` to stop. `boxes` tests the children of a node: which may be met
    /// before a limit, as bits, and from which distance on, not negative. Blocks have an array of their own; blocks that will be
    /// needed a little later are asked for.
    ///
    /// Wald, Benthin and Boulos, "Getting Rid of Packets", 2008.
    #[inline(always)]
    pub fn traverse<const ANY: bool, B>(
        &self,
        blocks: &[B],
        t_max: f64,
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        mut visit: impl FnMut(Leaf) -> Option<f64>,
    ) {
        // All but one of the children that are met wait. Without branches: which child is a leaf cannot be foretold.
        let ask = |child: Child| {
            let (number, nodes) = (child.0 as usize % Child::OTHER as usize, self.nodes.as_ptr());
            let (node, block) = (nodes.wrapping_add(number), blocks.as_ptr().wrapping_add(number));
            prefetch(if child.as_inner().is_some() { node.cast() } else { block.cast::<u8>() }, 0..4);
        };
        let mut limit = not_less(t_max);
        let mut stack = Stack::new();
        let mut at = self.root;
        loop {
            if let Some(inner) = at.as_inner() {
                let node = &self.nodes[inner];
                let (hits, near) = boxes(node, limit);
                if let Some(next) = descend::<ANY>(node, hits, &near, &mut stack, ask) {
                    at = next;
                    continue;
                }
            } else if at != Child::EMPTY {
                match visit(at.as_leaf()) {
                    Some(t_max) => limit = not_less(t_max),
                    None => return,
                }
            }
            let Some(next) = pop(&mut stack, limit) else { return };
            at = next;
        }
    }
}

/// Children that wait, the nearest on top: the distance in the upper half, for distances that are not negative are sorted
/// as their bits are.
type Stack = ArrayVec<u64, STACK>;

/// The nearest of the children that are hit; the others wait, the nearest on top. Where `ANY` hit will do, the farthest, and
/// the others wait in any order: what is around the surface that a ray leaves is seldom in its way.
#[inline(always)]
fn descend<const ANY: bool>(
    node: &Node,
    mut hits: u32,
    near: &[f32; WIDTH],
    stack: &mut Stack,
    waits: impl Fn(Child),
) -> Option<Child> {
    let key = |lane: usize| u64::from(near[lane].to_bits()) << 32 | u64::from(node.children[lane].0);
    let first = next_lane(&mut hits)?;
    // Mostly there are one or two, which need no sorting.
    let Some(second) = next_lane(&mut hits) else { return Some(node.children[first]) };
    let bottom = stack.len();
    let mut best = key(first);
    let mut next = Some(second);
    while let Some(lane) = next {
        let (less, more) = (best.min(key(lane)), best.max(key(lane)));
        let waiting = if ANY { less } else { more };
        best = if ANY { more } else { less };
        waits(Child(waiting as u32));
        stack.push(waiting);
        next = next_lane(&mut hits);
    }
    if !ANY && stack.len() > bottom + 1 {
        sort_descending(&mut stack[bottom..]);
    }
    Some(Child(best as u32))
}

/// The nearest child that waits, if it is not beyond the limit.
#[inline(always)]
fn pop(stack: &mut Stack, limit: f32) -> Option<Child> {
    while let Some(key) = stack.pop() {
        if (key >> 32) as u32 <= limit.to_bits() {
            return Some(Child(key as u32));
        }
    }
    None
}

/// The place of the lowest bit, which is cleared.
#[inline(always)]
fn next_lane(hits: &mut u32) -> Option<usize> {
    let lane = (*hits != 0).then(|| hits.trailing_zeros() as usize % WIDTH);
    *hits &= hits.wrapping_sub(1);
    lane
}

/// A distance in `f32` that is not less.
#[inline(always)]
pub(crate) fn not_less(t: f64) -> f32 {
    t as f32 * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE
}

/// Insertion sort: there are seven at most, mostly one or two.
#[inline(always)]
fn sort_descending(keys: &mut [u64]) {
    for end in 1..keys.len() {
        let key = keys[end];
        let mut at = end;
        while at > 0 && keys[at - 1] < key {
            keys[at] = keys[at - 1];
            at -= 1;
        }
        keys[at] = key;
    }
}

#[cfg(test)]
mod tests;
