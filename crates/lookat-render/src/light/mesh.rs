//! Light from meshes.

use glam::DVec3;
use lookat_scene::Mesh;

use crate::triangle::corners;

/// The area of the triangle with these corners.
pub(super) fn area_of([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// The areas of the triangles of a mesh, summed up.
pub(super) struct MeshAreas {
    /// The area of the triangles up to each.
    pub sums: Vec<f64>,
}

impl MeshAreas {
    /// The areas, and the center of gravity of the mesh.
    pub fn new(mesh: &Mesh, origin: DVec3) -> (Self, DVec3) {
        let (mut total, mut moment) = (0.0, DVec3::ZERO);
        let sums = (0..mesh.triangles()).map(|index| {
            let [a, b, c] = corners(mesh, index, origin);
            let area = area_of([a, b, c]);
            total += area;
            moment += (a + b + c) / 3.0 * area;
            total
        });
        let areas = MeshAreas { sums: sums.collect() };
        (areas, moment / total)
    }

    pub fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }
}
