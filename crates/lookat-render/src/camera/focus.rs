//! What a thin lens blurs (PBR 6.2.3).

use lookat_scene::{Camera, Film, Lens, Projection};

use super::CameraRays;

/// The focus of a thin lens. Distances are along z in camera space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Focus {
    projection: Projection,
    lens: Lens,
    /// The diameter of the lens in pixels, seen at distance 1.
    aperture: f64,
}

impl Focus {
    /// That of a camera with a lens.
    pub fn new(camera: &Camera, film: &Film) -> Option<Focus> {
        let lens = camera.lens?;
        let step = CameraRays::new(camera, film, glam::DVec3::ZERO).step.abs();
        let aperture = 2.0 * lens.radius / (step.x * step.y).sqrt();
        Some(Focus { projection: camera.projection, lens, aperture })
    }

    /// The diameter of the circle of confusion of a point at a depth, in pixels. 0 at the focal distance.
    pub fn blur(&self, depth: f64) -> f64 {
        let (focal, depth) = (self.lens.focal_distance, depth.max(f64::MIN_POSITIVE));
        self.aperture
            * match self.projection {
                Projection::Perspective { .. } => (1.0 / focal - 1.0 / depth).abs(),
                Projection::Orthographic { telecentric: true } => (1.0 - depth / focal).abs(),
                Projection::Orthographic { telecentric: false } => (focal / depth - 1.0).abs(),
                Projection::Environment => 0.0,
            }
    }

    /// The depths between which points are blurred by one pixel at most; the last may be infinite.
    pub fn sharp(&self) -> [f64; 2] {
        let (focal, share) = (self.lens.focal_distance, 1.0 / self.aperture);
        match self.projection {
            Projection::Perspective { .. } => {
                let far = 1.0 / focal - share;
                [1.0 / (1.0 / focal + share), if far > 0.0 { 1.0 / far } else { f64::INFINITY }]
            }
            Projection::Orthographic { telecentric: true } => {
                [(focal * (1.0 - share)).max(0.0), focal * (1.0 + share)]
            }
            Projection::Orthographic { telecentric: false } => {
                [focal / (1.0 + share), if share < 1.0 { focal / (1.0 - share) } else { f64::INFINITY }]
            }
            Projection::Environment => [0.0, f64::INFINITY],
        }
    }

    /// The hyperfocal distance: focused there, a perspective camera blurs nothing behind by more than a pixel. `None` of others.
    pub fn hyperfocal(&self) -> Option<f64> {
        matches!(self.projection, Projection::Perspective { .. }).then_some(self.aperture)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use lookat_scene::{ScreenWindow, Transform};

    use super::*;

    /// Rays from the edges of the lens through the middle of the film, where they meet a plane, and how many pixels that is.
    #[test]
    fn blur_is_the_spread_of_camera_rays() {
        let film = Film::new([300, 200]);
        let screen = ScreenWindow { min: DVec2::new(-1.5, -1.0), max: DVec2::new(1.5, 1.0) };
        for projection in [
            Projection::Perspective { fov: 40.0 },
            Projection::Orthographic { telecentric: true },
            Projection::Orthographic { telecentric: false },
        ] {
            let lens = Lens { radius: 0.2, focal_distance: 3.0 };
            let camera =
                Camera { world_from_camera: Transform::IDENTITY, projection, screen, lens: Some(lens) };
            let focus = Focus::new(&camera, &film).unwrap();
            let rays = CameraRays::new(&camera, &film, DVec3::ZERO);
            for depth in [0.5, 1.0, 2.5, 3.0, 3.5, 10.0, 1e3] {
                let at = |film: f64, u: f64| {
                    let ray = rays.ray(DVec2::new(film, 100.0), DVec2::new(u, 0.5));
                    ray.at((depth - ray.o.z) / ray.d.z).x
                };
                let spread = (at(150.0, 1.0 - 1e-12) - at(150.0, 0.0)).abs();
                let pixel = at(151.0, 0.5) - at(150.0, 0.5);
                let blur = focus.blur(depth);
                assert!((blur - spread / pixel).abs() < 1e-6 * (1.0 + blur), "{projection:?} {depth} {blur}");
            }
            for depth in focus.sharp().into_iter().filter(|depth| depth.is_finite()) {
                assert!((focus.blur(depth) - 1.0).abs() < 1e-9, "{projection:?} {depth}");
            }
            if let Some(hyperfocal) = focus.hyperfocal() {
                let lens = Lens { focal_distance: hyperfocal, ..lens };
                let focus = Focus::new(&Camera { lens: Some(lens), ..camera }, &film).unwrap();
                let [near, far] = focus.sharp();
                assert!((near / hyperfocal - 0.5).abs() < 1e-9 && far > 1e6 * hyperfocal, "{near} {far}");
            }
        }
    }
}
