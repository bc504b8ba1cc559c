//! Improves a binary tree: takes out large subtrees one by one, and puts each where the surfaces of all nodes sum up to the least (Meister and
//! Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018).

use super::{BinaryNode, NONE, Size};

/// The share of subtrees that are tried, the largest ones, and how many at most: small ones gain little.
const SHARE: usize = 20;
const MOST: usize = 4096;
/// How often all that is done.
const PASSES: usize = 2;

/// Makes a tree better.
pub(super) fn optimize(nodes: &mut [BinaryNode]) {
    let (count, size) = ((nodes.len() / SHARE).min(MOST), Size::of(&nodes[0].bounds()));
    if count == 0 {
        return;
    }
    let mut links = Links { nodes, size, waiting: Vec::new() };
    for _ in 0..PASSES {
        let mut largest: Vec<(f32, u32)> =
            (1..links.nodes.len() as u32).map(|at| (links.area(at), at)).collect();
        let is_larger = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        largest.select_nth_unstable_by(count, is_larger);
        largest.truncate(count);
        largest.sort_unstable_by(is_larger);
        for (_, at) in largest {
            links.reinsert(at);
        }
    }
}

/// A tree that changes.
struct Links<'b> {
    /// The root first.
    nodes: &'b mut [BinaryNode],
    size: Size,
    /// Subtrees that wait for a search, and what is gained above them.
    waiting: Vec<(f32, u32)>,
}

impl Links<'_> {
    #[inline(always)]
    fn node(&self, at: u32) -> &BinaryNode {
        &self.nodes[at as usize]
    }

    /// Half the surface of a node.
    #[inline(always)]
    fn area(&self, at: u32) -> f32 {
        self.size.area(self.node(at).bounds())
    }

    /// The other child of a node.
    fn sibling(&self, parent: u32, child: u32) -> u32 {
        let [first, second] = self.node(parent).children;
        if first == child { second } else { first }
    }

    /// Puts a subtree where it fits best.
    fn reinsert(&mut self, subtree: u32) {
        let parent = self.node(subtree).parent;
        let Some(place) = self.best_place(subtree, parent).filter(|_| parent != 0) else { return };
        // The parent goes along, and becomes that of the place.
        let (sibling, above) = (self.sibling(parent, subtree), self.node(parent).parent);
        self.replace(above, parent, sibling);
        self.fit(above);
        self.replace(self.node(place).parent, place, parent);
        self.nodes[parent as usize].children = [place, subtree];
        self.nodes[place as usize].parent = parent;
        self.fit(parent);
    }

    /// The node that a subtree is to be the sibling of. `None` if that is its sibling.
    fn best_place(&mut self, subtree: u32, parent: u32) -> Option<u32> {
        let (own, sibling) = (self.node(subtree).bounds(), self.sibling(parent, subtree));
        let own_area = self.size.area(own);
        let (mut best, mut place) = (0.0, None);
        // Going up: what is gained where the subtree is taken out, and what is left there.
        let (mut gained, mut left) = (self.area(parent), self.node(sibling).bounds());
        let (mut top, mut beside) = (parent, sibling);
        loop {
            self.waiting.push((gained, beside));
            while let Some((above, at)) = self.waiting.pop() {
                // No node around the subtree is smaller than it.
                if above - own_area <= best {
                    continue;
                }
                let node = self.node(at);
                let gain = above - self.size.area(node.bounds().union(own));
                if gain > best && at != sibling {
                    (best, place) = (gain, Some(at));
                }
                let below = gain + self.area(at);
                if node.leaf().is_none() && below - own_area > best {
                    let children = node.children.map(|child| (below, child));
                    self.waiting.extend(children);
                }
            }
            if top != parent {
                left = left.union(self.node(beside).bounds());
                gained += self.area(top) - self.size.area(left);
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
            let bounds = self.node(first).bounds().union(self.node(second).bounds());
            self.nodes[at as usize].set_bounds(bounds);
            at = self.node(at).parent;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::bvh::build::{Reference, binary};
    use crate::frame::Bounds;
    use crate::testing::noise;

    /// The sum of the surfaces of all nodes below one, once each is found to be around its children, and the leaves.
    fn cost(binary: &[BinaryNode], at: u32) -> (f32, Vec<u32>) {
        let node = &binary[at as usize];
        if let Some(leaf) = node.leaf() {
            return (0.0, vec![leaf.0]);
        }
        let [first, second] = node.children.map(|child| &binary[child as usize]);
        assert_eq!(node.bounds(), first.bounds().union(second.bounds()));
        assert_eq!([first.parent, second.parent], [at; 2]);
        let [(first, mut leaves), (second, others)] = node.children.map(|child| cost(binary, child));
        leaves.extend(others);
        (Size(1.0).area(node.bounds()) + first + second, leaves)
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
        let (mut binary, _) = binary::build(&mut references);
        let (cost_before, mut leaves_before) = cost(&binary, 0);
        optimize(&mut binary);
        let (cost, mut leaves) = cost(&binary, 0);
        leaves_before.sort_unstable();
        leaves.sort_unstable();
        assert_eq!(leaves, leaves_before);
        assert!(cost < 0.98 * cost_before, "{cost} {cost_before}");
    }
}
