//! Collapses a binary tree into nodes with eight children, so that the sum of the surfaces of these nodes is as small as can be (Ylitie, Karras
//! and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).

use arrayvec::ArrayVec;

use super::{BinaryNode, Size};
use crate::bvh::{Child, Node, WIDTH};
use crate::frame::Bounds;

/// The nodes, and the root.
pub(super) fn collapse(binary: &[BinaryNode]) -> (Vec<Node>, Child) {
    let mut collapse = Collapse { binary, forests: forests(binary), nodes: Vec::new() };
    let root = collapse.child(0);
    (collapse.nodes, root)
}

/// What lies below a node, as up to so many subtrees (one in the first place).
#[derive(Debug, Clone, Copy, Default)]
struct Forest {
    /// The sum of the surfaces of all nodes.
    cost: [f32; WIDTH],
    /// How many of the subtrees are below the first child, or 0 where the node itself is the only one.
    first: [u8; WIDTH],
}

/// The best for each node.
fn forests(binary: &[BinaryNode]) -> Vec<Forest> {
    let mut forests = vec![Forest::default(); binary.len()];
    let size = Size::of(&binary[0].bounds);
    // Children come after their nodes.
    for at in (0..binary.len()).rev() {
        let Some(second) = binary[at].child.as_inner() else { continue };
        let [a, b] = [forests[at + 1].cost, forests[at + second].cost];
        let mut own = Forest::default();
        for count in 2..=WIDTH {
            let (mut best, mut first) = (a[0] + b[count - 2], 1);
            for left in 2..count {
                let cost = a[left - 1] + b[count - left - 1];
                if cost < best {
                    (best, first) = (cost, left as u8);
                }
            }
            (own.cost[count - 1], own.first[count - 1]) = (best, first);
        }
        own.cost[0] = own.cost[WIDTH - 1] + size.area(binary[at].bounds);
        for count in 2..WIDTH {
            if own.cost[0] <= own.cost[count - 1] {
                (own.cost[count - 1], own.first[count - 1]) = (own.cost[0], 0);
            }
        }
        forests[at] = own;
    }
    forests
}

struct Collapse<'b> {
    binary: &'b [BinaryNode],
    forests: Vec<Forest>,
    nodes: Vec<Node>,
}

impl Collapse<'_> {
    /// A subtree as a child. Appends its nodes.
    fn child(&mut self, at: usize) -> Child {
        if self.binary[at].child.as_inner().is_none() {
            return self.binary[at].child;
        }
        let mut subtrees = ArrayVec::<usize, WIDTH>::new();
        self.subtrees(at, WIDTH, &mut subtrees);
        let bounds = [0, 1, 2, 3, 4, 5, 6, 7]
            .map(|i| subtrees.get(i).map_or(Bounds::EMPTY, |i| self.binary[*i].bounds));
        let planes =
            |axis: usize| [bounds.map(|bounds| bounds.min[axis]), bounds.map(|bounds| bounds.max[axis])];
        let own = self.nodes.len();
        self.nodes.push(Node { planes: [planes(0), planes(1), planes(2)], children: [Child::EMPTY; WIDTH] });
        for (lane, at) in subtrees.into_iter().enumerate() {
            self.nodes[own].children[lane] = self.child(at);
        }
        Child::inner(own)
    }

    /// The subtrees that become the children of a node, out of those below a node.
    fn subtrees(&self, at: usize, count: usize, all: &mut ArrayVec<usize, WIDTH>) {
        match (usize::from(self.forests[at].first[count - 1]), self.binary[at].child.as_inner()) {
            (first @ 1.., Some(second)) => {
                self.subtrees(at + 1, first, all);
                self.subtrees(at + second, count - first, all);
            }
            _ => all.push(at),
        }
    }
}
