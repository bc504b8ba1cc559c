//! Improves a binary tree: takes out large subtrees one by one, and puts each where the surfaces of all nodes sum up to the least (Meister and
//! Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018).

use super::{BinaryNode, Size};
use crate::bvh::{Child, MAX_DEPTH};
use crate::frame::Bounds;

/// The share of subtrees that are tried, the largest ones, and how many at most: small ones gain little.
const SHARE: usize = 20;
const MOST: usize = 4096;
/// How often all that is done.
const PASSES: usize = 2;

/// A better tree.
pub(super) fn optimized(binary: Vec<BinaryNode>) -> Vec<BinaryNode> {
    let count = (binary.len() / SHARE).min(MOST);
    if count == 0 {
        return binary;
    }
    let mut links = Links::new(&binary);
    let mut has_moved = false;
    for _ in 0..PASSES {
        let nodes = (1..).zip(&links.nodes[1..]);
        let mut largest: Vec<(f32, u32)> = nodes.map(|(at, node)| (node.area, at)).collect();
        let is_larger = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        largest.select_nth_unstable_by(count, is_larger);
        largest.truncate(count);
        largest.sort_unstable_by(is_larger);
        for (_, at) in largest {
            has_moved |= links.reinsert(at);
        }
    }
    has_moved.then(|| links.list()).flatten().unwrap_or(binary)
}

/// No node.
const NONE: u32 = u32::MAX;

/// A node of a tree that changes.
#[derive(Debug, Clone, Copy)]
struct Linked {
    bounds: Bounds,
    /// Half the surface.
    area: f32,
    parent: u32,
    /// The children, or [`NONE`].
    children: [u32; 2],
    /// A leaf, if it has no children.
    leaf: Child,
}

struct Links {
    /// The root first.
    nodes: Vec<Linked>,
    size: Size,
    /// Subtrees that wait for a search, and what is gained above them.
    waiting: Vec<(f32, u32)>,
}

impl Links {
    fn new(binary: &[BinaryNode]) -> Self {
        let size = Size::of(&binary[0].bounds);
        let node = |BinaryNode { bounds, child }: &BinaryNode| Linked {
            bounds: *bounds,
            area: size.area(*bounds),
            parent: NONE,
            children: [NONE; 2],
            leaf: *child,
        };
        let mut nodes: Vec<Linked> = binary.iter().map(node).collect();
        for at in 0..nodes.len() {
            if let Some(second) = binary[at].child.as_inner() {
                let children = [at + 1, at + second];
                nodes[at].children = children.map(|child| child as u32);
                for child in children {
                    nodes[child].parent = at as u32;
                }
            }
        }
        Links { nodes, size, waiting: Vec::new() }
    }

    #[inline(always)]
    fn node(&self, at: u32) -> &Linked {
        &self.nodes[at as usize]
    }

    /// The other child of a node.
    fn sibling(&self, parent: u32, child: u32) -> u32 {
        let [first, second] = self.node(parent).children;
        if first == child { second } else { first }
    }

    /// Puts a subtree where it fits best. True if that is another place.
    fn reinsert(&mut self, subtree: u32) -> bool {
        let parent = self.node(subtree).parent;
        if parent == 0 {
            return false;
        }
        let Some(place) = self.best_place(subtree, parent) else { return false };
        // The parent goes along, and becomes that of the place.
        let (sibling, above) = (self.sibling(parent, subtree), self.node(parent).parent);
        self.replace(above, parent, sibling);
        self.fit(above);
        self.replace(self.node(place).parent, place, parent);
        self.nodes[parent as usize].children = [place, subtree];
        self.nodes[place as usize].parent = parent;
        self.fit(parent);
        true
    }

    /// The node that a subtree is to be the sibling of. `None` if that is its sibling.
    fn best_place(&mut self, subtree: u32, parent: u32) -> Option<u32> {
        let (own, sibling) = (*self.node(subtree), self.sibling(parent, subtree));
        let (mut best, mut place) = (0.0, None);
        // Going up: what is gained where the subtree is taken out, and what is left there.
        let (mut gained, mut left) = (self.node(parent).area, self.node(sibling).bounds);
        let (mut top, mut beside) = (parent, sibling);
        loop {
            self.waiting.push((gained, beside));
            while let Some((above, at)) = self.waiting.pop() {
                // No node around the subtree is smaller than it.
                if above - own.area <= best {
                    continue;
                }
                let node = self.node(at);
                let gain = above - self.size.area(node.bounds.union(own.bounds));
                if gain > best && at != sibling {
                    (best, place) = (gain, Some(at));
                }
                let (below, children) = (gain + node.area, node.children);
                if children[0] != NONE && below - own.area > best {
                    self.waiting.extend(children.map(|child| (below, child)));
                }
            }
            if top != parent {
                left = left.union(self.node(beside).bounds);
                gained += self.node(top).area - self.size.area(left);
            }
            let above = self.node(top).parent;
            if above == NONE {
                return place;
            }
            (top, beside) = (above, self.sibling(above, top));
        }
    }

    /// Replaces a child.
    fn replace(&mut self, parent: u32, before: u32, after: u32) {
        let children = self.node(parent).children;
        self.nodes[parent as usize].children =
            children.map(|child| if child == before { after } else { child });
        self.nodes[after as usize].parent = parent;
    }

    /// Brings the boxes of a node and of all above it up to date.
    fn fit(&mut self, mut at: u32) {
        while at != NONE {
            let [first, second] = self.node(at).children;
            let bounds = self.node(first).bounds.union(self.node(second).bounds);
            let (area, node) = (self.size.area(bounds), &mut self.nodes[at as usize]);
            (node.bounds, node.area) = (bounds, area);
            at = node.parent;
        }
    }

    /// The tree as a list. `None` if it is too deep.
    fn list(&self) -> Option<Vec<BinaryNode>> {
        let mut list = Vec::with_capacity(self.nodes.len());
        self.append(0, 0, &mut list).then_some(list)
    }

    /// Appends a subtree. False if it is too deep.
    fn append(&self, at: u32, depth: usize, list: &mut Vec<BinaryNode>) -> bool {
        let (node, own) = (self.node(at), list.len());
        list.push(BinaryNode { bounds: node.bounds, child: node.leaf });
        let [first, second] = node.children;
        if first == NONE {
            return true;
        }
        if depth == MAX_DEPTH || !self.append(first, depth + 1, list) {
            return false;
        }
        list[own].child = Child::inner(list.len() - own);
        self.append(second, depth + 1, list)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::bvh::build::{Reference, binary};
    use crate::testing::noise;

    /// The sum of the surfaces of all nodes, once each node is found to be around its children, and the leaves, sorted.
    fn cost(binary: &[BinaryNode]) -> (f64, Vec<u32>) {
        let (mut sum, mut leaves) = (0.0, Vec::new());
        for (at, node) in binary.iter().enumerate() {
            match node.child.as_inner() {
                Some(second) => {
                    assert_eq!(node.bounds, binary[at + 1].bounds.union(binary[at + second].bounds));
                    sum += node.bounds.half_area();
                }
                None => leaves.push(node.child.0),
            }
        }
        leaves.sort_unstable();
        (sum, leaves)
    }

    #[test]
    fn walls_do_not_stretch_the_nodes_of_small_things() {
        let small = (0..4000).map(|i| {
            let low = DVec3::new(noise(i, 1.1), noise(i, 2.3) * 0.1, noise(i, 3.7)) * 10.0;
            Bounds::new(low, low + 0.05)
        });
        let beams = (0..40).map(|i| {
            let low = DVec3::new(noise(i, 4.1) * 10.0, 0.0, -1.0);
            Bounds::new(low, low + DVec3::new(0.1, 2.0, 9.0))
        });
        let mut references: Vec<Reference> =
            small.chain(beams).zip(0..).map(|(bounds, i)| Reference::non_triangle(bounds, i)).collect();
        let mut lengths = vec![0; references.len()];
        let before = binary::build(&mut references, &mut lengths);
        let ((cost_before, leaves_before), (cost, leaves)) = (cost(&before), cost(&optimized(before)));
        assert_eq!(leaves, leaves_before);
        assert!(cost < 0.98 * cost_before, "{cost} {cost_before}");
    }

    #[test]
    fn trees_that_are_too_deep_are_told() {
        let leaf = BinaryNode { bounds: Bounds::EMPTY, child: Child(Child::LEAF) };
        let chain = |depth: usize| {
            let node = [BinaryNode { child: Child::inner(2), ..leaf }, leaf];
            let list: Vec<BinaryNode> = node.into_iter().cycle().take(2 * depth).chain([leaf]).collect();
            Links::new(&list).list().is_some()
        };
        assert!(chain(MAX_DEPTH) && !chain(MAX_DEPTH + 1));
    }
}
