//! Eyes on curved shapes: P6.

use super::{RAYS, frame, look_at, turned};
use crate::stability::prelude::*;

/// A shape, a point on it, and the normal at the point.
type SurfacePoint = (&'static str, [f64; 3], [f64; 3]);

const SURFACE_POINTS: [SurfacePoint; 6] = [
    ("Shape \"disk\"", [0.3, -0.5, 0.0], [0.0, 0.0, 1.0]),
    ("Shape \"sphere\"", [0.48, 0.6, 0.64], [0.48, 0.6, 0.64]),
    ("Shape \"cylinder\"", [0.6, -0.8, 0.1], [0.6, -0.8, 0.0]),
    ("Shape \"cone\"", [0.0, 0.75, 0.25], [0.0, 1.0, 1.0]),
    ("Shape \"paraboloid\"", [0.3, 0.4, 0.25], [0.6, 0.8, -1.0]),
    (
        "Shape \"hyperboloid\" \"point p1\" [1 0 -1] \"point p2\" [1 0.5 1]",
        [1.0, 0.25, 0.0],
        [1.0, 0.25, -0.0625],
    ),
];

/// Outward rays hit nothing, except on a hyperboloid. Inward rays hit the far side or leave through an opening. No ray
/// hits the shape at the eye.
pub(super) fn eye_on_shape(effort: &Effort) -> Found {
    let tally = tally(effort.rays.min(100_000) / RAYS, 4800, |random, all| {
        let surface = SURFACE_POINTS[random.random_range(0..SURFACE_POINTS.len())];
        let turn = turned(random);
        let axes = if random.random() { turn } else { DMat3::IDENTITY };
        let size = 10_f64.powi(random.random_range(-6..7));
        let scene = scene(&text(surface, &frame(direction(random) * size, axes, size)));
        let probe = Probe::new(&scene);
        let outward = axes * DVec3::from(surface.2).normalize();
        for _ in 0..RAYS {
            let film = DVec2::new(random.random(), random.random()) * 16.0;
            let ray = probe.camera_ray(film, DVec2::ZERO);
            let cosine = ray.d.dot(outward);
            // For nearly tangent rays, the far side may be as near as the tolerance.
            if cosine.abs() < 1e-3 {
                continue;
            }
            let hit = probe.nearest(&ray);
            all.answer(
                hit.is_none_or(|hit| hit.t > 1e-6 * size && (cosine < 0.0 || surface.0.contains("hyper"))),
            );
        }
    });
    Found::own(None, tally)
}

fn text((shape, point, _): SurfacePoint, frame: &DMat4) -> String {
    let look_at = look_at(frame, point.into(), DVec3::new(0.3, 0.2, 1.0), DVec3::Y);
    let world = format!("LightSource \"infinite\" {} {shape}", transform(frame));
    pictured(&format!("{look_at} Camera \"environment\""), 16, 1, "path", &world)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each point is on its shape: a ray from outside hits the shape there.
    #[test]
    fn eyes_are_on_shapes() {
        for surface in SURFACE_POINTS {
            let scene = scene(&text(surface, &DMat4::IDENTITY));
            let probe = Probe::new(&scene);
            let n = DVec3::from(surface.2).normalize();
            let hit = probe.nearest(&Ray::new(probe.eye() + n * 0.25, -n)).expect("a hit");
            assert!((hit.t - 0.25).abs() < 1e-12, "{}: {}", surface.0, hit.t);
        }
    }
}
