//! Light from a point, in each direction as a picture has it.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};
use lookat_image::MipMap;

use super::environment::place;

/// Relative to the origin.
pub(super) struct Goniometric {
    pub position: DVec3,
    pub light_from_world: DMat3,
    pub intensity: Vec3,
    pub map: Arc<MipMap<Vec3>>,
}

impl Goniometric {
    /// The value of the picture in direction `d` from the light. In pbrt-v3 such pictures have y as their axis.
    pub fn factor(&self, d: DVec3) -> Vec3 {
        let d = self.light_from_world * d;
        self.map.bilinear(place(DVec3::new(d.x, d.z, d.y)))
    }

    /// The mean intensity over the picture.
    pub fn mean(&self) -> Vec3 {
        self.intensity * self.map.mean()
    }
}

#[cfg(test)]
mod tests {
    use lookat_image::Wrap;

    use super::*;

    /// The first row is up, by y, and the columns begin at x and go on to z.
    #[test]
    fn where_the_picture_goes() {
        let gray = |i: usize| Vec3::splat(i as f32);
        let map = MipMap::new(4, 4, (0..16).map(gray).collect(), Wrap::Repeat);
        let light = Goniometric {
            position: DVec3::ZERO,
            light_from_world: DMat3::IDENTITY,
            intensity: Vec3::ONE,
            map: Arc::new(map),
        };
        // The center of column 1 in row 1: longitude 135 degrees, 67.5 degrees from +y.
        let (sin, cos) = 67.5_f64.to_radians().sin_cos();
        let half = 0.5_f64.sqrt();
        let d = DVec3::new(-half * sin, cos, half * sin);
        assert!((light.factor(d * 3.0).x - 5.0).abs() < 1e-5);
        assert_eq!(light.mean(), Vec3::splat(7.5));
    }
}
