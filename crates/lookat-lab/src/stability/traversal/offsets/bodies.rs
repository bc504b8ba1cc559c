//! Convex closed bodies of about radius one.

use crate::stability::prelude::*;

/// A convex body.
pub(super) struct Convex {
    /// Whether it is the unit sphere, moved and scaled.
    pub is_ball: bool,
    shape: fn() -> String,
    /// Whether it is turned and stretched.
    turned: bool,
    /// Whether it is a copy of an object.
    is_object: bool,
}

pub(super) const ALL: [Convex; 5] = [
    Convex { is_ball: true, shape: sphere, turned: false, is_object: false },
    Convex { is_ball: false, shape: sphere, turned: true, is_object: false },
    Convex { is_ball: false, shape: sphere, turned: true, is_object: true },
    Convex { is_ball: false, shape: polyhedron, turned: false, is_object: false },
    Convex { is_ball: false, shape: polyhedron, turned: true, is_object: true },
];

impl Convex {
    /// A scene of the body alone, under a camera at `eye`.
    pub fn text(&self, eye: DVec3, center: DVec3, size: f64) -> String {
        let shape = (self.shape)();
        let (before, what) = if self.is_object {
            (format!("ObjectBegin \"body\" {shape} ObjectEnd"), String::from("ObjectInstance \"body\""))
        } else {
            (String::new(), shape)
        };
        let turn = if self.turned { "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2" } else { "" };
        let world = format!("{before} Translate {} Scale {size} {size} {size} {turn} {what}", xyz(center));
        seen_from(eye, &world)
    }
}

fn sphere() -> String {
    "Shape \"sphere\"".into()
}

/// An octahedron, each face of which is four: corners and middles of edges on the unit sphere.
fn polyhedron() -> String {
    let mut points = Vec::new();
    for octant in 0..8 {
        let sign = |bit: usize| if octant >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let middles = [0, 1, 2].map(|i| (corners[i] + corners[(i + 1) % 3]).normalize());
        points.extend((0..3).flat_map(|i| [corners[i], middles[i], middles[(i + 2) % 3]]));
        points.extend(middles);
    }
    triangles(&points)
}
