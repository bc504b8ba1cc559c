//! Eyes and lights in the plane of a triangle, or on a curved shape: P1 to P6.

mod eyes;
mod lights;
mod quadrics;

use glam::{DMat3, DVec3};

use super::case::{Axis, Case, Effort, Family, Found};

#[rustfmt::skip]
pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, run: fn(&Effort) -> Found| {
        Case { id, name, family: Family::Coplanar, claim, axis, error: "", limit: 0.0, run }
    };
    vec![
        case("P1", "eye-in-plane", "an eye, a lens or a film in the plane of a triangle sees nothing of the triangle",
            Axis::None, eyes::in_plane),
        case("P2", "eye-in-plane-of-any-size", "nor does it in scenes of any size",
            Axis::Of("size"), eyes::of_any_size),
        case("P3", "far-eye-in-plane", "nor far from the origin, in a plane along two axes",
            Axis::Of("distance from the origin"), eyes::far),
        case("P4", "eye-in-slanted-plane", "in any other plane, an eye sees nothing of the triangle, or one side of it",
            Axis::Of("distance from the origin"), eyes::slanted),
        case("P5", "light-in-plane", "a floor does not hide a light in its plane",
            Axis::Of("distance of the light / radius of the lit sphere"), lights::in_plane),
        case("P6", "eye-on-quadric", "an eye on a curved shape does not see the point it is at",
            Axis::None, quadrics::eye_on_shape),
    ]
}

/// A coordinate system for the objects of a scene. The tested plane is y = 0 in its coordinates.
#[derive(Debug, Clone, Copy)]
struct Place {
    origin: DVec3,
    axes: DMat3,
    size: f64,
}

impl Place {
    /// Three coordinate systems, one for each plane along two axes of the world.
    fn straight(origin: DVec3, size: f64) -> [Place; 3] {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
        [[x, y, z], [y, z, x], [z, x, y]].map(|[x, y, z]| Place {
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
        super::triangle::mesh_text(&points, faces)
    }
}
