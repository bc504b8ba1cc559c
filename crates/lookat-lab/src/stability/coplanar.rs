//! Eyes and lights in the plane of a triangle, or on a curved shape: P1 to P6.
//!
//! A scene is made in coordinates of its own, in which the tested plane is y = 0. A matrix, its frame, puts it into the world.

mod eyes;
mod lights;

use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("P1", eyes::in_plane),
    ("P2", eyes::of_any_size),
    ("P3", eyes::far),
    ("P4", eyes::slanted),
    ("P5", lights::in_plane),
    ("P6", eye_on_shape),
];

/// Rays for each random scene.
const RAYS: u64 = 100;

fn frame(origin: DVec3, axes: DMat3, size: f64) -> DMat4 {
    DMat4::from_translation(origin) * DMat4::from_mat3(axes * size)
}

/// Three frames, one for each plane along two axes of the world.
fn straight(origin: DVec3, size: f64) -> [DMat4; 3] {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    [[x, y, z], [y, z, x], [z, x, y]].map(|[x, y, z]| frame(origin, DMat3::from_cols(x, y, z), size))
}

/// Axes turned about a random one.
fn turned(random: &mut Pcg64Mcg) -> DMat3 {
    DMat3::from_axis_angle(direction(random), between(random, 0.0, 6.0))
}

/// A `LookAt` from `eye` in the direction `forward`.
fn look_at(frame: &DMat4, eye: DVec3, forward: DVec3, up: DVec3) -> String {
    let [eye, look] = [eye, eye + forward].map(|p| xyz(frame.transform_point3(p)));
    format!("LookAt {eye}  {look}  {}", xyz(frame.transform_vector3(up)))
}

fn placed_mesh(frame: &DMat4, points: &[DVec3], faces: &[[usize; 3]]) -> String {
    let points: Vec<DVec3> = points.iter().map(|p| frame.transform_point3(*p)).collect();
    mesh(&points, faces)
}

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
fn eye_on_shape(effort: &Effort) -> Found {
    let tally = tally(effort.rays.min(100_000) / RAYS, 4800, |random, all| {
        let surface = SURFACE_POINTS[random.random_range(0..SURFACE_POINTS.len())];
        let turn = turned(random);
        let axes = if random.random() { turn } else { DMat3::IDENTITY };
        let size = 10_f64.powi(random.random_range(-6..7));
        let probe = probe(&shape_text(surface, &frame(direction(random) * size, axes, size)));
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

fn shape_text((shape, point, _): SurfacePoint, frame: &DMat4) -> String {
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
            let probe = probe(&shape_text(surface, &DMat4::IDENTITY));
            let n = DVec3::from(surface.2).normalize();
            let hit = probe.nearest(&Ray::new(probe.eye() + n * 0.25, -n)).expect("a hit");
            assert!((hit.t - 0.25).abs() < 1e-12, "{}: {}", surface.0, hit.t);
        }
    }
}
