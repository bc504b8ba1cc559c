//! Eyes and lights in the plane of a triangle, or on a curved shape: P1 to P6.

mod eyes;
mod lights;
mod quadrics;

use crate::stability::prelude::*;
use glam::DMat3;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("P1", eyes::in_plane),
    ("P2", eyes::of_any_size),
    ("P3", eyes::far),
    ("P4", eyes::slanted),
    ("P5", lights::in_plane),
    ("P6", quadrics::eye_on_shape),
];

/// A coordinate system for the objects of a scene. The tested plane is y = 0 in its coordinates.
#[derive(Debug, Clone, Copy)]
struct LocalFrame {
    origin: DVec3,
    axes: DMat3,
    size: f64,
}

impl LocalFrame {
    /// Three coordinate systems, one for each plane along two axes of the world.
    fn straight(origin: DVec3, size: f64) -> [LocalFrame; 3] {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
        [[x, y, z], [y, z, x], [z, x, y]].map(|[x, y, z]| LocalFrame {
            origin,
            axes: DMat3::from_cols(x, y, z),
            size,
        })
    }

    fn point(&self, [x, y, z]: [f64; 3]) -> DVec3 {
        self.origin + self.axes * DVec3::new(x, y, z) * self.size
    }

    /// A point in world coordinates, as text.
    fn text(&self, p: [f64; 3]) -> String {
        let [x, y, z] = self.point(p).to_array();
        format!("{x:?} {y:?} {z:?}")
    }

    /// A `LookAt` from `eye` in the direction `forward`.
    fn look_at(&self, eye: [f64; 3], forward: [f64; 3], up: [f64; 3]) -> String {
        let [eye, forward] = [eye, forward].map(DVec3::from);
        let up = self.axes * DVec3::from(up);
        format!(
            "LookAt {}  {}  {:?} {:?} {:?}",
            self.text(eye.into()),
            self.text((eye + forward).into()),
            up.x,
            up.y,
            up.z
        )
    }

    fn mesh(&self, points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
        let points: Vec<DVec3> = points.iter().map(|p| self.point(*p)).collect();
        mesh(&points, faces)
    }
}
