//! A tree of lights (Conty Estevez and Kulla 2018; PBR 4th ed. 12.6.3) with eight children at each node. Its leaves are lights, and the
//! triangles of mesh lights.

mod node;
mod split;
#[cfg(test)]
mod tests;

use std::iter::{empty, once};

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;

use super::{Receivers, SceneLight};
pub(super) use crate::light::tree::split::Emitter;
use crate::number::{Vec3x8, prefetch, splat_f32, to_f64};
pub(super) use node::Receiver;
use node::{Emission, FAINT, FAR, LEAF, LEAST_SPREAD, NONE, Node, WIDTH};
use split::NumberedEmitter;

/// No sum of estimates is larger.
const MOST: f64 = 1e250;
/// The most nodes and leaves that are estimated side by side.
const MOST_ENTRIES: usize = 40;

/// The leaves are numbered from 0.
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// The position of each leaf: the number of its node times [`WIDTH`], plus its index there. [`NONE`] for leaves without
    /// light.
    places: Vec<u32>,
    /// Nodes and leaves that hold all leaves: the children of the nodes in `opened`, without the nodes that are opened themselves.
    cut: Vec<Entry>,
    opened: Vec<u32>,
    /// The inverse scale and the strength of the root.
    inverse_scale: f64,
    strength: f64,
}

/// A node or leaf of the cut, as among the children of a node, in units of the root.
struct Entry {
    center: DVec3,
    emission: Emission<f32>,
    /// The index of the entry, and the child there.
    place: u32,
    child: u32,
}

/// A step on the way down to a leaf.
#[derive(Clone, Copy)]
pub(super) struct Step {
    child: u32,
    /// The number from 0 to 1 that chooses on.
    u: f64,
    pub probability: f64,
}

impl Step {
    /// To nowhere.
    pub const NONE: Step = Step { child: NONE, u: 0.0, probability: 0.0 };

    /// True at a leaf, or nowhere.
    #[inline(always)]
    pub fn is_done(&self) -> bool {
        self.child & LEAF != 0
    }

    /// The leaf, at the end.
    pub fn leaf(&self) -> Option<usize> {
        (self.child & LEAF != 0 && self.child != NONE).then_some((self.child & !LEAF) as usize)
    }
}

impl LightTree {
    /// The tree of so many leaves. Leaves without light are not in it.
    pub fn new(count: usize, emitters: impl Iterator<Item = Option<Emitter>>) -> Self {
        let lit = emitters.enumerate().filter_map(|(number, emitter)| {
            let emitter = emitter.filter(|emitter| emitter.intensity > 0.0)?;
            Some(NumberedEmitter { number: number as u32, emitter })
        });
        let mut leaves: Vec<NumberedEmitter> = Vec::with_capacity(count);
        leaves.extend(lit);
        let mut places = vec![NONE; count];
        let nodes = if leaves.is_empty() { Vec::new() } else { split::nodes(&mut leaves) };
        for (number, node) in nodes.iter().enumerate() {
            for (slot, child) in node.children.child.iter().enumerate() {
                if *child & LEAF != 0 && *child != NONE {
                    places[(child & !LEAF) as usize] = (number * WIDTH + slot) as u32;
                }
            }
        }
        let (inverse_scale, strength) =
            nodes.first().map_or((1.0, 1.0), |root| (root.inverse_scale, root.strength));
        let mut tree =
            LightTree { nodes, places, cut: Vec::new(), opened: Vec::new(), inverse_scale, strength };
        tree.open();
        tree
    }

    /// Finds the cut: opens nodes from the root on, the largest and brightest first.
    fn open(&mut self) {
        let mut next = (!self.nodes.is_empty()).then_some(0);
        while let Some(node) = next {
            self.opened.push(node as u32);
            self.cut.extend(self.children(node));
            let error = |entry: &Entry| {
                let Emission { intensity, radius, .. } = &entry.emission;
                if entry.child & LEAF == 0 { intensity * radius.powi(2) } else { -1.0 }
            };
            let fits = |entry: &Entry| {
                entry.child & LEAF == 0
                    && self.cut.len() - 1 + self.nodes[entry.child as usize].count() <= MOST_ENTRIES
            };
            let open = (0..self.cut.len()).filter(|at| fits(&self.cut[*at]));
            let worst = open.max_by(|a, b| error(&self.cut[*a]).total_cmp(&error(&self.cut[*b])));
            next = worst.map(|at| self.cut.swap_remove(at).child as usize);
        }
    }

    /// The children of a node, for the cut.
    fn children(&self, number: usize) -> Vec<Entry> {
        let node = &self.nodes[number];
        let children = &node.children;
        let scale = self.inverse_scale / node.inverse_scale;
        let entry = |slot: usize| {
            let offset = DVec3::from(
                [children.offset.x, children.offset.y, children.offset.z].map(|x| f64::from(x[slot])),
            );
            let own = children.emission.map(|of| f64::from(of[slot]));
            let emission = Emission {
                radius: own.radius * scale,
                spread: (own.spread * scale * scale).max(LEAST_SPREAD),
                intensity: (own.intensity * (node.strength / self.strength) * scale * scale).max(FAINT),
                shift: own.shift * scale,
                ..own
            };
            Entry {
                center: node.center + offset / node.inverse_scale,
                emission: emission.map(|x| x as f32),
                place: (number * WIDTH + slot) as u32,
                child: children.child[slot],
            }
        };
        (0..node.count()).map(entry).collect()
    }

    /// The approximate unoccluded irradiance from each entry of the cut at some points.
    #[inline(always)]
    pub fn estimates<S: Simd>(&self, simd: S, at: &Receivers<S>, mut add: impl FnMut(f64x8<S>)) {
        let scale: f64x8<S> = self.inverse_scale.simd_into(simd);
        for entry in &self.cut {
            let mut to = (Vec3x8::splat(simd, entry.center) - at.surfaces.p) * scale;
            let distance = to.magnitude();
            if distance.simd_gt(FAR).any_true() {
                to = to * (FAR / distance).min(1.0);
            }
            let emission = entry.emission.map(
                #[inline(always)]
                |x| splat_f32(simd, x),
            );
            add((to_f64(emission.estimate(to.narrow(), &at.domain)) * self.strength).min(MOST));
        }
    }

    /// Begins to choose a leaf below an entry of the cut by a number from 0 to 1.
    #[inline(always)]
    pub fn begin(&self, entry: usize, u: f64) -> Step {
        self.step(self.cut[entry].child, u, 1.0)
    }

    #[inline(always)]
    fn step(&self, child: u32, u: f64, probability: f64) -> Step {
        if child & LEAF == 0 {
            prefetch(&self.nodes[child as usize], 0..size_of::<Node>().div_ceil(64));
        }
        Step { child, u, probability }
    }

    /// Descends to a child. Does nothing at leaves.
    #[inline(always)]
    pub fn descend<S: Simd>(&self, simd: S, at: &Receiver, step: &mut Step) {
        if step.child & LEAF == 0 {
            let node = &self.nodes[step.child as usize];
            let (slot, u, probability) = pick(&node.weights(simd, at), step.u);
            *step = self.step(node.children.child[slot], u, step.probability * probability);
        }
    }

    /// The entry of the cut that holds a leaf, and the probability with which this leaf is chosen below it.
    #[inline(always)]
    pub fn find<S: Simd>(&self, simd: S, at: &Receiver, leaf: usize) -> Option<(usize, f64)> {
        let mut place = self.places[leaf];
        let mut probability = 1.0;
        if place == NONE {
            return None;
        }
        loop {
            let (node, slot) = (place / WIDTH as u32, place as usize % WIDTH);
            if self.opened.contains(&node) {
                return Some((self.cut.iter().position(|entry| entry.place == place)?, probability));
            }
            let weights = self.nodes[node as usize].weights(simd, at);
            probability *= weights[slot] / weights.iter().sum::<f64>();
            place = self.nodes[node as usize].parent;
        }
    }
}

/// The number of the amount with which the sum of all passes the share `u` of the total, what is left of `u`, from 0 to 1 again, and the
/// share of the amount.
#[inline(always)]
fn pick(amounts: &[f64; WIDTH], u: f64) -> (usize, f64, f64) {
    let mut ends = [0.0; WIDTH];
    let mut end = 0.0;
    for (own, amount) in ends.iter_mut().zip(amounts) {
        end += amount;
        *own = end;
    }
    let mark = u * end;
    let mut at: usize = ends.iter().map(|end| usize::from(*end <= mark)).sum();
    if at == WIDTH {
        // Rounding: the last with an amount.
        at = amounts.iter().rposition(|amount| *amount > 0.0).unwrap_or(0);
    }
    let before = if at == 0 { 0.0 } else { ends[at - 1] };
    (at, ((mark - before) / amounts[at]).clamp(0.0, 1.0), amounts[at] / end)
}

/// The leaves of the tree of lights.
pub(super) struct Leaves {
    pub tree: LightTree,
    /// The number of the first leaf of each light, and at last how many leaves there are.
    first: Vec<u32>,
}

/// A light, or a triangle of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Leaf {
    pub light: usize,
    /// The number of the triangle, or 0 of lights that are one leaf.
    pub triangle: usize,
}

impl Leaves {
    /// The leaves of the lights for which `is_held` is true.
    pub fn new(lights: &[SceneLight], is_held: impl Fn(usize) -> bool) -> Self {
        let mut first = vec![0];
        let mut count = 0;
        for (number, light) in lights.iter().enumerate() {
            count += if is_held(number) { light.leaves() as u32 } else { 0 };
            first.push(count);
        }
        let held = lights.iter().enumerate().filter(|(number, _)| is_held(*number));
        Leaves { tree: LightTree::new(count as usize, held.flat_map(|(_, light)| light.emitters())), first }
    }

    /// The light and triangle of a leaf.
    pub fn of(&self, leaf: usize) -> Leaf {
        let light = self.first.partition_point(|first| *first as usize <= leaf) - 1;
        Leaf { light, triangle: leaf - self.first[light] as usize }
    }

    /// The leaf that a light or one of its triangles is, if it is in the tree.
    pub fn find(&self, light: usize, triangle: usize) -> Option<usize> {
        let [first, end] = [self.first[light] as usize, self.first[light + 1] as usize];
        (first < end).then(|| (first + triangle).min(end - 1))
    }
}

impl SceneLight {
    /// The number of leaves of the light in the light tree. 0 for lights without a position.
    pub(super) fn leaves(&self) -> usize {
        match self {
            SceneLight::Point(_) => 1,
            SceneLight::Surface(surface) => surface.leaves(),
            SceneLight::Distant { .. } | SceneLight::Infinite { .. } | SceneLight::Environment(_) => 0,
        }
    }

    /// The emission of each leaf.
    fn emitters(&self) -> Box<dyn Iterator<Item = Option<Emitter>> + '_> {
        match self {
            SceneLight::Point(light) => Box::new(once(Some(light.emitter()))),
            SceneLight::Surface(surface) => surface.emitters(),
            SceneLight::Distant { .. } | SceneLight::Infinite { .. } | SceneLight::Environment(_) => {
                Box::new(empty())
            }
        }
    }
}
