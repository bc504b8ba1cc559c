//! Which way a shape that emits is turned.

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;

use super::receiver::LEAST_COSINE;
use super::tree::Emitter;
use crate::number::Vec3x8;

/// A patch of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub p: DVec3,
    /// The unit normal on the side that emits; 0 where that is not the same all over the patch.
    pub emitting: DVec3,
    pub area: f64,
}

/// The direction in which most of a shape emits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// Of length one where all normals are the same, 0 where they go everywhere alike.
    mean_normal: DVec3,
    /// Whether all lies in one plane.
    is_flat: bool,
    /// How many sides emit.
    pub sides: f64,
}

/// What may be off by rounding, relative to the size of a shape.
const ROUNDING: f64 = 1e-6;
/// A cosine that rounding may make of 0. Light at less is left to samples of the BSDF.
const GRAZING: f64 = 1e-6;

impl Facing {
    /// That of a shape with these patches around a center.
    pub fn new(patches: impl Iterator<Item = Patch> + Clone, center: DVec3, two_sided: bool) -> Self {
        let patches = patches.filter(|patch| patch.area > 0.0);
        let (area, moment) = patches.clone().fold((0.0, DVec3::ZERO), |(area, moment), patch| {
            (area + patch.area, moment + patch.emitting * patch.area)
        });
        let mean_normal = moment / area;
        let mut same = patches.map(|patch| {
            let height = (patch.p - center).dot(mean_normal).abs();
            height <= ROUNDING * area.sqrt() && patch.emitting.dot(mean_normal) > 1.0 - ROUNDING
        });
        Facing { mean_normal, is_flat: same.all(|is_same| is_same), sides: if two_sided { 2.0 } else { 1.0 } }
    }

    /// That of a triangle, from its normal on the side that emits; 0 where that is not the same all over it.
    pub fn of_flat(emitting: DVec3, two_sided: bool) -> Self {
        let sides = if two_sided { 2.0 } else { 1.0 };
        Facing { mean_normal: emitting, is_flat: emitting != DVec3::ZERO, sides }
    }

    /// The emission of a shape within a radius of a center, with this radiance and area.
    pub fn emitter(&self, ball: (DVec3, f64), radiance_area: (f64, f64)) -> Emitter {
        Emitter::surface(ball, radiance_area, self.mean_normal, (self.is_flat, self.sides > 1.0))
    }

    /// About the share of the area that shines in direction `d` from the center, foreshortened; 0 on the dark side of what is
    /// flat. `spread`: how large the shape is, over the distance that it is seen from.
    #[inline(always)]
    pub fn share<S: Simd>(&self, simd: S, d: Vec3x8<S>, spread: f64x8<S>) -> f64x8<S> {
        let along = Vec3x8::splat(simd, self.mean_normal).dot(d);
        let along = if self.sides > 1.0 { along.abs() } else { along };
        match self.is_flat {
            true => {
                // Parts of it are seen less aslant than the center.
                let share = (along + spread * 0.5).max(LEAST_COSINE).min(1.0);
                along.simd_gt(GRAZING).select(share, 0.0.simd_into(simd))
            }
            // A closed convex shape shows a quarter.
            false => along.max(0.25),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;

    fn share(facing: &Facing, d: DVec3, spread: f64) -> f64 {
        baseline!(simd => facing.share(simd, Vec3x8::splat(simd, d), spread.simd_into(simd))[0])
    }

    fn patch(p: DVec3, emitting: DVec3) -> Patch {
        Patch { p, emitting, area: 1.0 }
    }

    #[test]
    fn flat_shapes_have_a_dark_side() {
        let (middle, slanted) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
        let flat = [patch(middle + DVec3::X, DVec3::Z), patch(middle - DVec3::X, DVec3::Z)];
        let shares = |two_sided| {
            let facing = Facing::new(flat.into_iter(), middle, two_sided);
            [DVec3::Z, slanted, DVec3::X, -DVec3::Z].map(|d| share(&facing, d, 0.0))
        };
        assert_eq!(shares(false), [1.0, 0.8, 0.0, 0.0]);
        assert_eq!(shares(true), [1.0, 0.8, 0.0, 1.0]);
        // Steps are seen from between them.
        let steps = [patch(middle + slanted, DVec3::Z), patch(middle - slanted, DVec3::Z)];
        assert_eq!(share(&Facing::new(steps.into_iter(), middle, false), -DVec3::Z, 0.0), 0.25);
        // All around.
        let cube = DVec3::AXES.map(|axis| [axis, -axis]).concat();
        let cube = cube.iter().map(|n| patch(middle + n, *n));
        assert_eq!(share(&Facing::new(cube, middle, false), slanted, 0.0), 0.25);
        // From nearby, more of a large shape is seen than of its middle; from its plane nothing.
        let facing = Facing::new(flat.into_iter(), middle, false);
        let lifted = DVec3::new(1.0, 0.0, 1e-7);
        assert_eq!([slanted, DVec3::X, lifted].map(|d| share(&facing, d, 0.2)), [0.9, 0.0, 0.0]);
    }
}
