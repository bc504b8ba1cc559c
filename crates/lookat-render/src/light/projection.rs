//! Light from a point, as a projector of slides.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::MipMap;

/// Relative to the origin.
pub(super) struct Projection {
    pub position: DVec3,
    pub light_from_world: DMat3,
    pub intensity: Vec3,
    pub map: Option<Arc<MipMap<Vec3>>>,
    /// Half of the picture at z = 1 in light space.
    pub half_size: DVec2,
}

/// What is lit has at least this z in light space, for directions of length one in the world, as in pbrt-v3.
const NEAR: f64 = 1e-3;

impl Projection {
    /// The value of the picture in direction `d`, of length one, from the light; `None` outside of it.
    pub fn factor(&self, d: DVec3) -> Option<Vec3> {
        let d = self.light_from_world * d;
        let place = d.truncate() / d.z / self.half_size;
        if d.z < NEAR || place.abs().max_element() > 1.0 {
            return None;
        }
        let st = (place + 1.0) * 0.5;
        Some(self.map.as_ref().map_or(Vec3::ONE, |map| map.bilinear(st)))
    }

    /// The mean intensity over the picture.
    pub fn mean(&self) -> Vec3 {
        self.intensity * self.map.as_ref().map_or(Vec3::ONE, |map| map.mean())
    }

    /// That of the cone around the picture, as pbrt-v3 has it.
    pub fn solid_angle(&self) -> f64 {
        TAU * (1.0 - self.half_size.extend(1.0).length().recip())
    }
}

#[cfg(test)]
mod tests {
    use lookat_image::Wrap;

    use super::*;

    #[test]
    fn where_the_picture_goes() {
        let texels = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
        let map = MipMap::new(2, 2, texels, Wrap::Repeat);
        let light = Projection {
            position: DVec3::ZERO,
            light_from_world: DMat3::IDENTITY,
            intensity: Vec3::splat(2.0),
            map: Some(Arc::new(map)),
            half_size: DVec2::new(0.8, 0.4),
        };
        // The first texel is at the left and at the bottom.
        let at = |x, y, z| light.factor(DVec3::new(x, y, z).normalize());
        assert_eq!(at(-0.4, -0.2, 1.0), Some(Vec3::X));
        assert_eq!(at(0.4, -0.2, 1.0), Some(Vec3::Y));
        assert_eq!(at(-0.4, 0.2, 1.0), Some(Vec3::Z));
        assert_eq!([at(0.81, 0.0, 1.0), at(0.0, 0.41, 1.0), at(-0.4, -0.2, -1.0)], [None; 3]);
        assert_eq!(light.mean(), Vec3::ONE);
        assert!((light.solid_angle() - TAU * (1.0 - 1.8_f64.sqrt().recip())).abs() < 1e-12);
    }
}
