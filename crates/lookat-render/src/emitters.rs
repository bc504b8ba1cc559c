//! Bounds of the emitters that rays may find.

use fearless_simd::{Simd, mask64x8, prelude::*};

use crate::bvh::BoxRays;
use crate::frame::Bounds;
use crate::number::{Vec3x8, bits};
use crate::trace::rays::Rays;

/// Boxes around all shapes that emit light.
#[derive(Debug)]
pub(crate) struct Emitters(Vec<Bounds>);

/// With more boxes than that, looking at each costs about as much as tracing the ray.
const MOST: usize = 8;

impl Emitters {
    /// The emitters of a scene. Above [`MOST`] shapes, one box bounds them all.
    pub fn new(bounds: Vec<Bounds>) -> Self {
        if bounds.len() <= MOST {
            return Emitters(bounds);
        }
        Emitters(vec![bounds.into_iter().fold(Bounds::EMPTY, Bounds::union)])
    }

    /// True if the scene has no emitters.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The rays that may hit an emitter. Other rays certainly do not.
    #[inline(always)]
    pub fn may_be_hit<S: Simd>(&self, simd: S, rays: &Rays<S>) -> mask64x8<S> {
        let mut may_be = bits(simd, 0);
        if self.is_empty() {
            return may_be;
        }
        let rays = BoxRays::new(rays.o, rays.d);
        for bounds in &self.0 {
            let (low, high) = bounds.corners();
            let (near, far) = rays.ends(simd, [low, high].map(|corner| Vec3x8::splat(simd, corner)));
            may_be |= near.simd_le(far);
        }
        may_be
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::number::{Vec3x8, side_by_side};
    use crate::prepare::Prepared;
    use crate::ray::Ray;
    use crate::testing::{noise, scene};

    /// Shapes of all kinds that glow, at many places; and one that does not, in front of some.
    fn glowing(copies: usize) -> lookat_scene::Scene {
        let shapes = "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .3
            Translate 1 0 0 Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 .5 0 0 0 .5 .2]
            Translate 1 0 0 Shape \"curve\" \"float width\" .2 \"point P\" [0 0 0 .2 .5 0 .4 -.5 0 .6 0 0]
            Translate 1 0 0 ObjectInstance \"lamp\" AttributeEnd Translate 0 2 0 ";
        scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            ObjectBegin \"lamp\" AreaLightSource \"diffuse\" Shape \"disk\" \"float radius\" .3 ObjectEnd
            Translate -1 -2 5 Shape \"sphere\" {} WorldEnd",
            shapes.repeat(copies)
        ))
    }

    #[test]
    fn whatever_glows_may_be_met() {
        for copies in [1, 2, 5] {
            let scene = glowing(copies);
            let traceable = Prepared::new(&scene).traceable;
            let (mut found, mut passed) = (0, 0);
            for i in 0..20_000 {
                let vector = |k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
                let ray = Ray::new(
                    vector(1.1),
                    (vector(2.3) * DVec3::new(2.0, 4.0, 0.0) + DVec3::new(0.5, 1.0, 5.0)).normalize(),
                );
                let may_be_met = side_by_side!(fearless_simd::Level::new(), simd => {
                    let rays = Rays::new(Vec3x8::splat(simd, ray.o), Vec3x8::splat(simd, ray.d));
                    traceable.emitters.may_be_hit(simd, &rays).all_true()
                });
                let is_light = traceable.nearest(&ray).is_some_and(|hit| traceable.emits(&hit));
                assert!(may_be_met || !is_light, "{copies} {ray:?}");
                found += u32::from(is_light);
                passed += u32::from(!may_be_met);
            }
            assert!(found > 100 && passed > 1000, "{copies}: {found} {passed}");
        }
    }
}
