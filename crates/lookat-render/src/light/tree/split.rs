//! Builds the light tree: the emission of leaves and groups, and how groups are split.

use std::f64::consts::PI;

use glam::DVec3;

use super::node::{Children, EVERYWHERE, Emission, FAINT, LEAF, LEAST_SPREAD, NONE, Node, SLACK, WIDTH};
use crate::number::V3;

/// Splits are tried between so many slices along an axis.
const BINS: usize = 16;
/// A tree of at least so many leaves is built on all threads.
const PARALLEL: usize = 4096;
/// The relative rounding error of a coordinate as `f32`, with room for sums of three.
const ROUNDING: f64 = 5e-7;
/// The least cosine of a narrow cone that is stored.
const NARROW: f64 = 0.9999;

/// A leaf while the tree is built.
#[derive(Clone, Copy)]
pub(super) struct NumberedEmitter {
    pub number: u32,
    pub emitter: Emitter,
}

/// The nodes of a tree of leaves, the root first.
pub(super) fn nodes(leaves: &mut [NumberedEmitter]) -> Vec<Node> {
    let groups = grouped(leaves);
    let whole = group(leaves);
    let mut rest = leaves;
    let mut slices = Vec::new();
    for count in groups {
        let (own, others) = rest.split_at_mut(count);
        slices.push(own);
        rest = others;
    }
    let mut node = Node::new(&whole, &slices);
    let below = |slice: &mut &mut [NumberedEmitter]| if slice.len() > 1 { nodes(slice) } else { Vec::new() };
    let parts: Vec<Vec<Node>> = if slices.iter().map(|slice| slice.len()).sum::<usize>() >= PARALLEL {
        use rayon::prelude::*;
        slices.par_iter_mut().map(below).collect()
    } else {
        slices.iter_mut().map(below).collect()
    };
    let mut all = Vec::with_capacity(1 + parts.iter().map(Vec::len).sum::<usize>());
    all.push(node);
    for (slot, part) in parts.into_iter().enumerate().filter(|(_, part)| !part.is_empty()) {
        let first = all.len() as u32;
        node = all[0];
        node.children.child[slot] = first;
        all[0] = node;
        all.extend(part.into_iter().map(|node| node.moved(first, slot as u32)));
    }
    all
}

/// The leaves of a node, in up to [`WIDTH`] groups: how many are in each.
fn grouped(leaves: &mut [NumberedEmitter]) -> Vec<usize> {
    let mut groups = vec![(leaves.len(), cost(leaves))];
    if leaves.len() <= WIDTH {
        return vec![1; leaves.len()];
    }
    while groups.len() < WIDTH {
        let widest = (0..groups.len())
            .filter(|at| groups[*at].0 > WIDTH)
            .max_by(|a, b| groups[*a].1.total_cmp(&groups[*b].1));
        let Some(at) = widest else { break };
        let first: usize = groups[..at].iter().map(|(count, _)| count).sum();
        let own = &mut leaves[first..first + groups[at].0];
        let left = split(own);
        let (a, b) = own.split_at(left);
        groups.splice(at..=at, [(left, cost(a)), (own.len() - left, cost(b))]);
    }
    groups.into_iter().map(|(count, _)| count).collect()
}

/// Brings the leaves of two parts together, and returns how many are in the first.
fn split(leaves: &mut [NumberedEmitter]) -> usize {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for leaf in leaves.iter() {
        low = low.min(leaf.emitter.center);
        high = high.max(leaf.emitter.center);
    }
    let half = leaves.len() / 2;
    let mut best = (f64::INFINITY, None);
    for axis in 0..3 {
        let scale = BINS as f64 / (high[axis] - low[axis]);
        if !scale.is_finite() {
            continue;
        }
        let bin = |leaf: &NumberedEmitter| {
            (((leaf.emitter.center[axis] - low[axis]) * scale) as usize).min(BINS - 1)
        };
        let mut bins = [Bin::NONE; BINS];
        for leaf in leaves.iter() {
            bins[bin(leaf)].add(&Bin::new(&leaf.emitter));
        }
        let mut right = [Bin::NONE; BINS];
        let mut sum = Bin::NONE;
        for at in (1..BINS).rev() {
            sum.add(&bins[at]);
            right[at] = sum;
        }
        let mut left = Bin::NONE;
        for at in 1..BINS {
            left.add(&bins[at - 1]);
            let cost = left.cost() + right[at].cost();
            if left.count > 0 && right[at].count > 0 && cost < best.0 {
                best = (cost, Some((axis, at, scale)));
            }
        }
    }
    let Some((axis, at, scale)) = best.1 else { return half };
    let bin =
        |leaf: &NumberedEmitter| (((leaf.emitter.center[axis] - low[axis]) * scale) as usize).min(BINS - 1);
    partition(leaves, |leaf| bin(leaf) < at)
}

/// Moves the leaves that satisfy `is_first` to the front and returns their number, like [`Iterator::partition_in_place`].
fn partition(leaves: &mut [NumberedEmitter], is_first: impl Fn(&NumberedEmitter) -> bool) -> usize {
    let mut first = 0;
    for at in 0..leaves.len() {
        if is_first(&leaves[at]) {
            leaves.swap(first, at);
            first += 1;
        }
    }
    first
}

fn cost(leaves: &[NumberedEmitter]) -> f64 {
    let mut sum = Bin::NONE;
    for leaf in leaves {
        sum.add(&Bin::new(&leaf.emitter));
    }
    sum.cost()
}

/// The sums over a part of the leaves.
#[derive(Clone, Copy)]
struct Bin {
    count: usize,
    intensity: f64,
    low: DVec3,
    high: DVec3,
    /// Over the lights with an axis: the sum of the axes, each times what the light emits along it, and the sum of what they emit so.
    moment: DVec3,
    along: f64,
}

impl Bin {
    const NONE: Bin = Bin {
        count: 0,
        intensity: 0.0,
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
        moment: DVec3::ZERO,
        along: 0.0,
    };

    fn new(emitter: &Emitter) -> Self {
        let along = if emitter.is_two_sided { 0.0 } else { emitter.intensity * emitter.along };
        Bin {
            count: 1,
            intensity: emitter.intensity,
            low: emitter.center - emitter.radius,
            high: emitter.center + emitter.radius,
            moment: emitter.axis * along,
            along,
        }
    }

    fn add(&mut self, other: &Bin) {
        self.count += other.count;
        self.intensity += other.intensity;
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.moment += other.moment;
        self.along += other.along;
    }

    /// The error of choosing by the sum, about: its intensity times the surface of its box, and more where normals differ.
    fn cost(&self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let size = self.high - self.low;
        let surface = size.x * size.y + size.y * size.z + size.z * size.x;
        let turned = if self.along > 0.0 { 1.0 - self.moment.length() / self.along } else { 0.0 };
        self.intensity * surface * (1.0 + 2.0 * turned)
    }
}

fn group(leaves: &[NumberedEmitter]) -> Emitter {
    match leaves {
        [leaf] => leaf.emitter,
        _ => Emitter::group(leaves.iter().map(|leaf| &leaf.emitter)),
    }
}

impl Children {
    fn put(&mut self, slot: usize, offset: DVec3, of: &Emission<f64>) {
        let Children { offset: V3 { x, y, z }, emission: own, .. } = self;
        (x[slot], y[slot], z[slot]) = (offset.x as f32, offset.y as f32, offset.z as f32);
        own.radius[slot] = of.radius as f32;
        own.spread[slot] = of.spread as f32;
        own.intensity[slot] = of.intensity as f32;
        own.base[slot] = of.base as f32;
        own.along[slot] = of.along as f32;
        own.axis.x[slot] = of.axis.x as f32;
        own.axis.y[slot] = of.axis.y as f32;
        own.axis.z[slot] = of.axis.z as f32;
        own.least_cosine[slot] = of.least_cosine as f32;
        own.shift[slot] = of.shift as f32;
    }
}

impl Node {
    fn new(whole: &Emitter, slices: &[&mut [NumberedEmitter]]) -> Self {
        let scale = if whole.radius > 0.0 { whole.radius } else { 1.0 };
        let groups: Vec<Emitter> = slices.iter().map(|slice| group(slice)).collect();
        let brightest = groups.iter().map(|group| group.intensity).fold(0.0, f64::max);
        let mut children = Children::NONE;
        for (slot, (group, slice)) in groups.iter().zip(slices).enumerate() {
            let offset = (group.center - whole.center) / scale;
            let error = ROUNDING * offset.length();
            let mut narrowed = *group;
            narrowed.least_cosine = group.least_cosine.min(NARROW);
            let shift = |leaf: &NumberedEmitter| leaf.emitter.shift_in(&narrowed);
            let is_everywhere = group.least_cosine <= EVERYWHERE + SLACK;
            let sin = ((1.0 - narrowed.least_cosine) * (1.0 + narrowed.least_cosine)).max(0.0).sqrt();
            let is_bounded = !is_everywhere && sin >= 0.01;
            let shift = is_bounded.then(|| slice.iter().map(shift).fold(0.0, f64::max) / scale + error / sin);
            let least = shift.map_or(EVERYWHERE, |_| narrowed.least_cosine - SLACK);
            let axis = V3 { x: group.axis.x, y: group.axis.y, z: group.axis.z };
            let emission = Emission {
                radius: group.radius / scale * (1.0 + ROUNDING) + error,
                // No estimate is surer than the place.
                spread: (group.spread / scale / scale).max(error * error).max(LEAST_SPREAD),
                intensity: (group.intensity / brightest).max(FAINT),
                base: group.base,
                along: if group.is_two_sided { -group.along } else { group.along },
                axis,
                least_cosine: least * least.abs(),
                shift: shift.unwrap_or(0.0),
            };
            children.put(slot, offset, &emission);
            if let [leaf] = &**slice {
                children.child[slot] = LEAF | leaf.number;
            }
        }
        let strength = brightest / (scale * scale);
        Node { center: whole.center, inverse_scale: 1.0 / scale, strength, parent: NONE, children }
    }

    /// Shifts the indices of the node for a longer list, in which its subtree starts at `first`. The root of the subtree is
    /// the child `slot` of the root.
    fn moved(mut self, first: u32, slot: u32) -> Self {
        self.parent = if self.parent == NONE { slot } else { self.parent + first * WIDTH as u32 };
        for child in self.children.child.iter_mut().filter(|child| **child & LEAF == 0) {
            *child += first;
        }
        self
    }
}

/// The emission of a light, a triangle or a group of these, as far as choosing one needs it.
#[derive(Debug, Clone, Copy)]
pub(in crate::light) struct Emitter {
    pub center: DVec3,
    /// All of it is at most this far from `center`.
    pub radius: f64,
    /// A term added to the squared distance in estimates of irradiance. It keeps them finite nearby.
    pub spread: f64,
    /// The irradiance at distance 1, at right angles.
    pub intensity: f64,
    /// The share of `intensity` that leaves in all directions.
    pub base: f64,
    /// The share that leaves by the cosine to `axis`.
    pub along: f64,
    /// True if it also leaves by the cosine to the opposite direction.
    pub is_two_sided: bool,
    /// A unit vector.
    pub axis: DVec3,
    /// Light leaves only in directions whose cosine to `axis` is at least this. [`EVERYWHERE`]: in all directions.
    pub least_cosine: f64,
    /// True if all of it lies in one plane across `axis`.
    pub is_flat: bool,
}

/// A closed convex shape shows a quarter of its area.
const CONVEX: f64 = 0.25;

impl Emitter {
    /// A point that shines alike in all directions.
    pub fn point(position: DVec3, intensity: f64) -> Self {
        Emitter {
            center: position,
            radius: 0.0,
            spread: 0.0,
            intensity,
            base: 1.0,
            along: 0.0,
            is_two_sided: false,
            axis: DVec3::Z,
            least_cosine: EVERYWHERE,
            is_flat: false,
        }
    }

    /// A point that shines around an axis, up to an angle with this cosine.
    pub fn cone(position: DVec3, intensity: f64, axis: DVec3, least_cosine: f64) -> Self {
        let base = (1.0 - least_cosine) * 0.5;
        Emitter { base, along: 1.0 - base, axis, least_cosine, ..Emitter::point(position, intensity) }
    }

    /// A surface within `radius` of `center`, with the mean of its unit normals on the side that emits.
    pub fn surface(
        (center, radius): (DVec3, f64),
        (radiance, area): (f64, f64),
        mean_normal: DVec3,
        (is_flat, is_two_sided): (bool, bool),
    ) -> Self {
        let length = mean_normal.length();
        let is_one_sided = is_flat && !is_two_sided;
        Emitter {
            radius,
            // The irradiance from a disk, at any distance; from a ball, from outside of it about that.
            spread: area / if is_flat { PI } else { 4.0 * PI },
            base: if is_flat { 0.0 } else { CONVEX * (1.0 - length * length).max(0.0) },
            along: length.min(1.0),
            is_two_sided,
            axis: mean_normal.normalize_or(DVec3::Z),
            least_cosine: if is_one_sided { 0.0 } else { EVERYWHERE },
            is_flat,
            ..Emitter::point(center, radiance * area)
        }
    }

    /// A group.
    pub fn group<'e>(all: impl Iterator<Item = &'e Emitter> + Clone) -> Self {
        let intensity: f64 = all.clone().map(|emitter| emitter.intensity).sum();
        let weighted = || all.clone().map(|emitter| (emitter, emitter.intensity / intensity));
        let center = weighted().fold(DVec3::ZERO, |sum, (emitter, share)| sum + emitter.center * share);
        // Of lights spread evenly in a ball, seen from its middle, the mean of 1 / r^2 is about 1 over half the mean of r^2.
        let square = |(emitter, share): (&Emitter, f64)| {
            share * (0.5 * emitter.center.distance_squared(center) + emitter.spread)
        };
        let reach = |emitter: &Emitter| emitter.center.distance(center) + emitter.radius;
        let (mut base, mut along, mut moment) = (0.0, 0.0, DVec3::ZERO);
        for (emitter, share) in weighted() {
            if emitter.is_two_sided {
                base += share * (emitter.base + 0.5 * emitter.along);
            } else {
                base += share * emitter.base;
                along += share * emitter.along;
                moment += emitter.axis * (share * emitter.along);
            }
        }
        let length = moment.length();
        if along > 0.0 {
            base += CONVEX * (along - length * length / along).max(0.0);
        }
        let axis = moment.normalize_or(DVec3::Z);
        Emitter {
            radius: all.clone().map(reach).fold(0.0, f64::max),
            spread: weighted().map(square).sum(),
            base,
            along: length,
            axis,
            least_cosine: all.clone().map(|emitter| emitter.least_cosine_to(axis)).fold(1.0, f64::min),
            ..Emitter::point(center, intensity)
        }
    }

    /// The cosine of the angle to `axis` up to which it shines.
    fn least_cosine_to(&self, axis: DVec3) -> f64 {
        if self.least_cosine <= -1.0 {
            return EVERYWHERE;
        }
        let (a, b) = (self.least_cosine, self.axis.dot(axis).clamp(-1.0, 1.0));
        let [sin_a, sin_b] = [a, b].map(|cos| ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt());
        // From a sum of half a turn on, it is everywhere.
        if sin_a * b + a * sin_b <= 0.0 && b < 1.0 - 1e-12 { EVERYWHERE } else { a * b - sin_a * sin_b }
    }

    /// The distance behind `center` at which a cone around the axis of `group`, with its angle, must begin to contain all
    /// light of this emitter.
    pub fn shift_in(&self, group: &Emitter) -> f64 {
        let cos = group.least_cosine;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        if cos <= -1.0 {
            return 0.0;
        }
        let offset = self.center - group.center;
        let height = offset.dot(group.axis);
        let beside = (offset - group.axis * height).length();
        let slope = cos.abs() / sin;
        let of_ball = slope * beside - height + self.radius / sin;
        if !self.is_flat {
            return of_ball;
        }
        // Of a disk across its own axis.
        let tilt = self.axis.cross(group.axis).length();
        of_ball.min(slope * (beside + self.radius) - height + self.radius * tilt)
    }
}
