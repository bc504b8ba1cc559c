//! Nodes of the tree of lights, and what their children are estimated to bring.

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::{DVec3, Vec3};

use crate::bsdf::Domain;
use crate::light::LEAST_COSINE;
use crate::number::{V3, Vec3fx8, splat_f32, to_f64};

/// The least cosine of lights that shine in all directions.
pub(super) const EVERYWHERE: f64 = -2.0;
/// The most children of a node.
pub(super) const WIDTH: usize = 8;
/// The number of a child that is a leaf has this bit.
pub(super) const LEAF: u32 = 1 << 31;
/// No node, or no child.
pub(super) const NONE: u32 = u32::MAX;
/// A place is at most so far from a node, in units of its size: beyond, its light comes from one direction.
pub(super) const FAR: f64 = 1e7;
/// The share of a group's size over its distance that is added to cosines. Measured.
const RIM: f32 = 0.25;
/// No intensity is stored as less than this share of the largest, nor a spread in units of a node as less than this.
pub(super) const FAINT: f64 = 1e-20;
pub(super) const LEAST_SPREAD: f64 = 1e-24;
/// Cosines are as `f32`, and off by less than this.
pub(super) const SLACK: f64 = 1e-5;

/// The emission of a node or leaf: see [`super::Emitter`].
#[derive(Clone, Copy)]
pub(super) struct Emission<T> {
    pub radius: T,
    pub spread: T,
    pub intensity: T,
    pub base: T,
    /// Negative if it shines to both sides.
    pub along: T,
    pub axis: V3<T>,
    /// The square of the least cosine, with its sign.
    pub least_cosine: T,
    /// The distance behind the center at which the cone of its light begins.
    pub shift: T,
}

impl<T> Emission<T> {
    /// Each of the numbers, changed.
    #[inline(always)]
    pub fn map<U>(self, mut of: impl FnMut(T) -> U) -> Emission<U> {
        let V3 { x, y, z } = self.axis;
        Emission {
            radius: of(self.radius),
            spread: of(self.spread),
            intensity: of(self.intensity),
            base: of(self.base),
            along: of(self.along),
            axis: V3 { x: of(x), y: of(y), z: of(z) },
            least_cosine: of(self.least_cosine),
            shift: of(self.shift),
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Node {
    pub center: DVec3,
    /// 1 over the radius.
    pub inverse_scale: f64,
    /// The factor for the intensities of the children.
    pub strength: f64,
    /// The position of the node in its parent, encoded like that of leaves.
    pub parent: u32,
    pub children: Children,
}

/// The children of a node side by side, in units of the node.
#[derive(Clone, Copy)]
pub(super) struct Children {
    pub offset: V3<[f32; WIDTH]>,
    pub emission: Emission<[f32; WIDTH]>,
    /// The numbers of the children. Leaves have the bit [`LEAF`].
    pub child: [u32; WIDTH],
}

impl Children {
    pub const NONE: Children = {
        let none = [0.0; WIDTH];
        let nowhere = V3 { x: none, y: none, z: none };
        let emission = Emission {
            radius: none,
            spread: [1.0; WIDTH],
            intensity: none,
            base: none,
            along: none,
            axis: nowhere,
            least_cosine: [EVERYWHERE as f32; WIDTH],
            shift: none,
        };
        Children { offset: nowhere, emission, child: [NONE; WIDTH] }
    };
}

/// A point that samples lights.
#[derive(Debug, Clone, Copy)]
pub(in crate::light) struct Receiver {
    pub p: DVec3,
    pub n: Vec3,
    pub ns: Vec3,
    pub is_two_sided: bool,
    pub is_diffuse: bool,
}

impl Receiver {
    /// The same in all lanes.
    #[inline(always)]
    pub fn domain<S: Simd>(&self, simd: S) -> Domain<S> {
        Domain {
            n: Vec3fx8::splat(simd, self.n),
            ns: Vec3fx8::splat(simd, self.ns),
            is_two_sided: mask32x8::splat(simd, self.is_two_sided),
            is_diffuse: mask32x8::splat(simd, self.is_diffuse),
        }
    }
}

impl Node {
    /// The number of children. They come first.
    pub fn count(&self) -> usize {
        self.children.child.iter().position(|child| *child == NONE).unwrap_or(WIDTH)
    }

    /// The weights by which children are chosen: about their unoccluded irradiance at a point, or their intensities if the
    /// irradiance of all is 0.
    #[inline(always)]
    pub fn weights<S: Simd>(&self, simd: S, at: &Receiver) -> [f64; WIDTH] {
        let of = |numbers: [f32; WIDTH]| -> f32x8<S> { numbers.simd_into(simd) };
        let mut to = (self.center - at.p) * self.inverse_scale;
        let distance = to.abs().max_element();
        if distance > FAR {
            to *= FAR / distance;
        }
        let V3 { x, y, z } = self.children.offset;
        let to = V3 { x: of(x), y: of(y), z: of(z) } + Vec3fx8::splat(simd, to.as_vec3());
        let estimates = self.children.emission.map(of).estimate(to, &at.domain(simd));
        if !estimates.simd_gt(0.0).any_true() {
            return self.children.emission.intensity.map(f64::from);
        }
        to_f64(estimates).into()
    }
}

impl<S: Simd> Emission<f32x8<S>> {
    /// About the irradiance, were nothing in the way. `to`: from where light is looked for to the centers.
    #[inline(always)]
    pub fn estimate(&self, to: Vec3fx8<S>, at: &Domain<S>) -> f32x8<S> {
        let none: f32x8<S> = splat_f32(to.x.token(), 0.0);
        let squared = to.length_squared();
        let inverse = 1.0 / squared.max(1e-30).sqrt();
        let size = self.radius * inverse;
        // Whether the point lies in the cone of the light.
        let height = -to.dot(self.axis);
        let shifted = height + self.shift;
        let beside = (squared - height * height).max(0.0);
        let is_lit = (shifted * shifted.abs()).simd_ge(self.least_cosine * (shifted * shifted + beside));
        // About the share of it that shines there, foreshortened; parts are seen less aslant than the center.
        let along = self.along.abs();
        let foreshortened = height * inverse * along;
        let opposite = self.along.simd_lt(0.0).select(-foreshortened, none);
        let rim = (size * along).min(1.0) * RIM;
        let share = (self.base + foreshortened.max(opposite) + rim).max(LEAST_COSINE).min(1.0);
        // The cosine at the surface.
        let is_seen = is_lit & (at.is_two_sided | (to.dot(at.n) * inverse).simd_gt(-size - SLACK as f32));
        let cosine = (to.dot(at.ns) * inverse + size * RIM).max(LEAST_COSINE).min(1.0);
        let cosine = at.is_diffuse.select(cosine, splat_f32(none.token(), 1.0));
        is_seen.select(self.intensity * share * cosine / (squared + self.spread), none)
    }
}
