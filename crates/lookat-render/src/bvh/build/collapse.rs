//! Collapses a binary tree into nodes with eight children, so that the sum of the surfaces of these nodes is as small as can be (Ylitie, Karras
//! and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017).

use arrayvec::ArrayVec;

use super::{BinaryNode, Size};
use crate::bvh::{Child, MAX_DEPTH, Node, WIDTH};
use crate::frame::Bounds;

/// The nodes, and the root. `None` if the tree is too deep.
pub(super) fn collapse(binary: &[BinaryNode]) -> Option<(Vec<Node>, Child)> {
    let size = Size::of(&binary[0].bounds());
    let mut collapse = Collapse { binary, size, forests: vec![[0; WIDTH]; binary.len()], nodes: Vec::new() };
    collapse.plan(0, 0)?;
    let root = collapse.child(0);
    Some((collapse.nodes, root))
}

struct Collapse<'b> {
    binary: &'b [BinaryNode],
    size: Size,
    /// For each node, how what lies below it becomes one subtree, up to two, and so on: how many of the subtrees are below the first child,
    /// or 0 where the node itself is the only one.
    forests: Vec<[u8; WIDTH]>,
    nodes: Vec<Node>,
}

impl Collapse<'_> {
    /// Finds the best forests. Returns their costs: the sums of the surfaces of all nodes. `None` if the tree is too deep.
    fn plan(&mut self, at: usize, depth: usize) -> Option<[f32; WIDTH]> {
        let node = &self.binary[at];
        if node.leaf().is_some() {
            return Some([0.0; WIDTH]);
        }
        if depth == MAX_DEPTH {
            return None;
        }
        let [first, second] = node.children;
        let (a, b) = (self.plan(first as usize, depth + 1)?, self.plan(second as usize, depth + 1)?);
        let (mut costs, forest) = ([0.0; WIDTH], &mut self.forests[at]);
        for count in 2..=WIDTH {
            let (mut best, mut first) = (a[0] + b[count - 2], 1);
            for left in 2..count {
                let cost = a[left - 1] + b[count - left - 1];
                if cost < best {
                    (best, first) = (cost, left as u8);
                }
            }
            (costs[count - 1], forest[count - 1]) = (best, first);
        }
        costs[0] = costs[WIDTH - 1] + self.size.area(node.bounds());
        for count in 2..WIDTH {
            if costs[0] <= costs[count - 1] {
                (costs[count - 1], forest[count - 1]) = (costs[0], 0);
            }
        }
        Some(costs)
    }

    /// A subtree as a child. Appends its nodes.
    fn child(&mut self, at: usize) -> Child {
        if let Some(leaf) = self.binary[at].leaf() {
            return leaf;
        }
        let mut subtrees = ArrayVec::<usize, WIDTH>::new();
        self.subtrees(at, WIDTH, &mut subtrees);
        let bounds = [0, 1, 2, 3, 4, 5, 6, 7]
            .map(|i| subtrees.get(i).map_or(Bounds::EMPTY, |subtree| self.binary[*subtree].bounds()));
        let planes =
            |axis: usize| [bounds.map(|bounds| bounds.min[axis]), bounds.map(|bounds| bounds.max[axis])];
        let own = self.nodes.len();
        self.nodes.push(Node { planes: [planes(0), planes(1), planes(2)], children: [Child::EMPTY; WIDTH] });
        for (lane, subtree) in subtrees.into_iter().enumerate() {
            self.nodes[own].children[lane] = self.child(subtree);
        }
        Child::inner(own)
    }

    /// The subtrees that become the children of a node, out of those below a node.
    fn subtrees(&self, at: usize, count: usize, all: &mut ArrayVec<usize, WIDTH>) {
        match usize::from(self.forests[at][count - 1]) {
            0 => all.push(at),
            below_first => {
                let [first, second] = self.binary[at].children;
                self.subtrees(first as usize, below_first, all);
                self.subtrees(second as usize, count - below_first, all);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build::NONE;

    #[test]
    fn trees_that_are_too_deep_are_told() {
        let chain = |depth: u32| {
            let node = |children| BinaryNode { min: [0.0; 3], max: [1.0; 3], children, parent: NONE };
            let of = |at: u32| [node([at + 1, at + 2]), node([NONE, Child::LEAF])];
            let nodes = (0..depth).flat_map(|level| of(2 * level));
            let nodes: Vec<_> = nodes.chain([node([NONE, Child::LEAF])]).collect();
            collapse(&nodes).map(|(nodes, _)| nodes.len())
        };
        let deepest = MAX_DEPTH as u32;
        // Each node has eight children: one is the next.
        assert_eq!(chain(deepest), Some(MAX_DEPTH.div_ceil(WIDTH - 1)));
        assert_eq!(chain(deepest + 1), None);
    }
}
