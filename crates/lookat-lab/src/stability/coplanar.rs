//! Eyes and lights in the plane of a triangle, or on a curved shape: P1 to P6.
//!
//! A scene is made in coordinates of its own, in which the tested plane is y = 0. A matrix, its frame, puts it into the world.

mod eyes;
mod lights;
mod quadrics;

use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("P1", eyes::in_plane),
    ("P2", eyes::of_any_size),
    ("P3", eyes::far),
    ("P4", eyes::slanted),
    ("P5", lights::in_plane),
    ("P6", quadrics::eye_on_shape),
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
