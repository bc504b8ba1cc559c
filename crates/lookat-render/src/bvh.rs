//! A bounding volume hierarchy: which elements a ray may meet.

use std::ops::{Mul, Sub};

use glam::DVec3;

use crate::bounds::Bounds;
use crate::ray::Ray;

/// A binary tree of boxes over elements that the owner keeps, sorted by [`Bvh::build`].
#[derive(Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// Of a leaf, its first element; else its right child. The left child follows its parent.
    next: u32,
    /// Elements of a leaf; 0 for an inner node.
    count: u32,
    /// The axis that the children are split along.
    axis: u32,
}

const BINS: usize = 16;
const MAX_LEAF: usize = 4;
/// Deeper than any tree that halves its elements in the end; see `split`.
const MAX_DEPTH: usize = 128;
/// Below this depth elements are split in halves, whatever it costs, so that depth stays bounded.
const HALVING_DEPTH: usize = 64;

impl Bvh {
    /// Builds the tree over elements with the given bounds. Gives the order that the elements are to be brought into:
    /// element `i` of leaves is the one that was at `order[i]`.
    ///
    /// Binned surface area heuristic (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).
    pub fn build(bounds: &[Bounds]) -> (Bvh, Vec<u32>) {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut nodes = Vec::with_capacity(bounds.len().max(1));
        if !bounds.is_empty() {
            build_node(bounds, &mut order, 0, 0, &mut nodes);
        }
        (Bvh { nodes }, order)
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |node| node.bounds)
    }

    /// Calls `visit` with the range of elements of each leaf that the ray may meet within its `t_max`, about from near to
    /// far. `visit` gives the new limit, or `None` to stop.
    #[inline]
    pub fn traverse(&self, ray: &Ray, mut visit: impl FnMut(std::ops::Range<usize>) -> Option<f64>) {
        if self.nodes.is_empty() {
            return;
        }
        let slabs = Slabs::new(ray);
        let mut t_max = ray.t_max;
        let mut stack = [0_u32; MAX_DEPTH];
        let mut depth = 0;
        let mut at = 0_u32;
        loop {
            let node = &self.nodes[at as usize];
            if slabs.meet(&node.bounds, t_max) {
                if node.count > 0 {
                    let first = node.next as usize;
                    match visit(first..first + node.count as usize) {
                        Some(limit) => t_max = limit,
                        None => return,
                    }
                } else {
                    let (left, right) = (at + 1, node.next);
                    let (near, far) =
                        if slabs.negative[node.axis as usize] { (right, left) } else { (left, right) };
                    stack[depth] = far;
                    depth += 1;
                    at = near;
                    continue;
                }
            }
            if depth == 0 {
                return;
            }
            depth -= 1;
            at = stack[depth];
        }
    }
}

/// What the slab test computes with.
#[cfg(not(feature = "plain-f32"))]
type Real = f64;
#[cfg(feature = "plain-f32")]
type Real = f32;

/// What the slab test needs of a ray.
struct Slabs {
    o: [Real; 3],
    inverse: [Real; 3],
    negative: [bool; 3],
}

/// Covers the rounding of both ends of the test (Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013).
const PAD: Real = 1.0 + 4.0 * Real::EPSILON;

// A cast in one of the two builds only.
#[allow(clippy::unnecessary_cast)]
fn real(x: f64) -> Real {
    x as Real
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        let inverse = ray.d.recip().to_array().map(real);
        let o = ray.o.to_array().map(real);
        Slabs { o, inverse, negative: inverse.map(|x| x.is_sign_negative()) }
    }

    /// Whether the ray may meet the box before `t_max`: never no where it does.
    ///
    /// Near and far are told by the sign of the direction, before anything is compared; then a NaN, which a ray in the
    /// plane of a side gives, drops out, because it compares as false.
    #[inline]
    fn meet(&self, bounds: &Bounds, t_max: f64) -> bool {
        let (mut near, mut far): (Real, Real) = (0.0, real(t_max) * PAD);
        for axis in 0..3 {
            let (low, high) = (Real::from(bounds.min[axis]), Real::from(bounds.max[axis]));
            let (enter, leave) =
                slab([low, high], self.o[axis], self.inverse[axis], self.negative[axis], PAD);
            near = if enter > near { enter } else { near };
            far = if leave < far { leave } else { far };
        }
        near <= far
    }
}

/// Where a ray enters and leaves what lies between two planes.
#[inline]
fn slab<T: Copy + Sub<Output = T> + Mul<Output = T>>(
    [low, high]: [T; 2],
    o: T,
    inverse: T,
    negative: bool,
    pad: T,
) -> (T, T) {
    let (first, last) = if negative { (high, low) } else { (low, high) };
    ((first - o) * inverse, (last - o) * inverse * pad)
}

/// The distance of a hit of what lies between two corners, brought between those at which the ray enters and leaves their
/// box. It then agrees, to the bit, with the test of every box around that box: no tree skips what is hit. `None` where the
/// ray passes the box. `inverse` is one over the direction.
#[inline]
pub(crate) fn within_box(o: DVec3, inverse: DVec3, low: DVec3, high: DVec3, t: f64) -> Option<f64> {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let negative = inverse[axis].is_sign_negative();
        let (enter, leave) =
            slab([low[axis], high[axis]], o[axis], inverse[axis], negative, 1.0 + 4.0 * f64::EPSILON);
        near = if enter > near { enter } else { near };
        far = if leave < far { leave } else { far };
    }
    (near <= far).then(|| t.clamp(near, far))
}

/// Subtrees of at least so many elements are built side by side.
const PARALLEL: usize = 1 << 14;

/// Appends the tree over `order`, whose first element is number `first` of all.
fn build_node(bounds: &[Bounds], order: &mut [u32], first: usize, depth: usize, nodes: &mut Vec<Node>) {
    let all = order.iter().fold(Bounds::EMPTY, |all, i| all.union(bounds[*i as usize]));
    let at = nodes.len();
    nodes.push(Node { bounds: all, next: first as u32, count: order.len() as u32, axis: 0 });
    let Some((axis, middle)) = split(bounds, order, all, depth) else { return };
    nodes[at].count = 0;
    nodes[at].axis = axis as u32;
    let (left, right) = order.split_at_mut(middle);
    if left.len() + right.len() < PARALLEL {
        build_node(bounds, left, first, depth + 1, nodes);
        nodes[at].next = nodes.len() as u32;
        build_node(bounds, right, first + middle, depth + 1, nodes);
        return;
    }
    let subtree = |order: &mut [u32], first| {
        let mut nodes = Vec::with_capacity(order.len());
        build_node(bounds, order, first, depth + 1, &mut nodes);
        nodes
    };
    let (left, right) = rayon::join(|| subtree(left, first), || subtree(right, first + middle));
    append(nodes, left);
    nodes[at].next = nodes.len() as u32;
    append(nodes, right);
}

/// Appends a tree that was built on its own: its inner nodes count their children from its start.
fn append(nodes: &mut Vec<Node>, subtree: Vec<Node>) {
    let base = nodes.len() as u32;
    nodes.extend(subtree.into_iter().map(|node| match node.count {
        0 => Node { next: node.next + base, ..node },
        _ => node,
    }));
}

/// Sorts `order` into two parts; gives the axis and where the second begins. `None` where a leaf is best.
fn split(bounds: &[Bounds], order: &mut [u32], all: Bounds, depth: usize) -> Option<(usize, usize)> {
    if order.len() <= 1 {
        return None;
    }
    let centers = |axis: usize| order.iter().map(move |i| bounds[*i as usize].center2(axis));
    let range = [0, 1, 2].map(|axis| {
        centers(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)))
    });
    let best = if depth < HALVING_DEPTH { best_plane(bounds, order, &range) } else { None };
    let leaf_cost = order.len() as f64 * all.half_area();
    match best {
        Some((cost, axis, bin)) if order.len() > MAX_LEAF || cost + all.half_area() < leaf_cost => {
            let goes_left = |i: &u32| bin_of(bounds[*i as usize].center2(axis), range[axis]) <= bin;
            let middle = partition(order, goes_left);
            Some((axis, middle))
        }
        Some(_) => None,
        None if order.len() <= MAX_LEAF => None,
        // All centres are equal, or the tree is deep already: halves bound the depth.
        None => Some((0, order.len() / 2)),
    }
}

/// The plane between bins of least cost: cost, axis, and the last bin on the left.
fn best_plane(bounds: &[Bounds], order: &[u32], range: &[(f64, f64); 3]) -> Option<(f64, usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for (axis, range) in range.iter().enumerate().filter(|(_, range)| range.1 > range.0) {
        let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
        for i in order {
            let bounds = bounds[*i as usize];
            let bin = &mut bins[bin_of(bounds.center2(axis), *range)];
            *bin = (bin.0.union(bounds), bin.1 + 1);
        }
        let cost = |(bounds, count): (Bounds, usize)| bounds.half_area() * count as f64;
        let join = |a: (Bounds, usize), b: (Bounds, usize)| (a.0.union(b.0), a.1 + b.1);
        let mut right = [0.0; BINS];
        let mut sum = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            sum = join(sum, bins[bin]);
            right[bin - 1] = cost(sum);
        }
        sum = (Bounds::EMPTY, 0);
        for bin in 0..BINS - 1 {
            sum = join(sum, bins[bin]);
            if sum.1 == 0 || sum.1 == order.len() {
                continue;
            }
            let total = cost(sum) + right[bin];
            if best.is_none_or(|(least, ..)| total < least) {
                best = Some((total, axis, bin));
            }
        }
    }
    best
}

fn bin_of(center: f64, (low, high): (f64, f64)) -> usize {
    (((center - low) / (high - low) * BINS as f64) as usize).min(BINS - 1)
}

/// Brings the elements that satisfy `first` to the front, keeping the order within both parts.
fn partition(order: &mut [u32], first: impl Fn(&u32) -> bool) -> usize {
    let (front, back): (Vec<u32>, Vec<u32>) = order.iter().partition(|i| first(i));
    order[..front.len()].copy_from_slice(&front);
    order[front.len()..].copy_from_slice(&back);
    front.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_in_the_plane_of_a_side_meets_the_box() {
        let bounds = Bounds { min: [0.0; 3], max: [1.0; 3] };
        for x in [0.0, 1.0] {
            for zero in [0.0, -0.0] {
                let ray = Ray::new(DVec3::new(x, 0.5, -1.0), DVec3::new(zero, 0.0, 1.0));
                assert!(Slabs::new(&ray).meet(&bounds, f64::INFINITY), "{x} {zero}");
            }
        }
        let outside = Ray::new(DVec3::new(2.0, 0.5, -1.0), DVec3::Z);
        assert!(!Slabs::new(&outside).meet(&bounds, f64::INFINITY));
    }

    /// Also in a tree large enough to be built by several threads.
    #[test]
    fn every_box_that_a_ray_meets_is_visited() {
        let spread = |i: usize, k: f64| ((i as f64 * k).sin() * 1e4).fract() * 10.0;
        let bounds: Vec<Bounds> = (0..PARALLEL + 1000)
            .map(|i| DVec3::new(spread(i, 1.1), spread(i, 2.3), spread(i, 3.7)))
            .map(|low| Bounds::new(low, low + 0.5))
            .collect();
        let (bvh, order) = Bvh::build(&bounds);
        for (o, d) in [(DVec3::splat(-20.0), DVec3::ONE), (DVec3::new(3.0, 2.0, 30.0), DVec3::NEG_Z)] {
            let ray = Ray::new(o, d.normalize());
            let slabs = Slabs::new(&ray);
            let mut visited = vec![false; bounds.len()];
            bvh.traverse(&ray, |range| {
                order[range].iter().for_each(|i| visited[*i as usize] = true);
                Some(f64::INFINITY)
            });
            let met = |i: &usize| slabs.meet(&bounds[*i], f64::INFINITY);
            assert!((0..bounds.len()).filter(met).all(|i| visited[i]));
            assert!((0..bounds.len()).filter(met).count() > 0);
        }
    }

    #[test]
    fn elements_that_cannot_be_told_apart_make_a_shallow_tree() {
        for same in
            [Bounds { min: [1.0; 3], max: [2.0; 3] }, Bounds::new(DVec3::splat(-1e300), DVec3::splat(1e300))]
        {
            let (bvh, order) = Bvh::build(&vec![same; 100_000]);
            assert_eq!(order.len(), 100_000);
            let mut seen = 0;
            bvh.traverse(&Ray::new(DVec3::splat(1.5), DVec3::X), |range| {
                seen += range.len();
                Some(f64::INFINITY)
            });
            assert_eq!(seen, 100_000);
        }
    }
}
