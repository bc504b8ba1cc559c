//! A closed mesh of triangles.

use std::collections::BTreeMap;

use glam::DVec3;

/// A sphere of triangles.
pub(super) struct Icosphere {
    pub center: DVec3,
    pub radius: f64,
    /// The vertices on the unit sphere.
    pub directions: Vec<DVec3>,
    pub faces: Vec<[usize; 3]>,
}

impl Icosphere {
    /// Splits each triangle of an icosahedron in four, so many times.
    pub fn new(levels: u32, center: DVec3, radius: f64) -> Icosphere {
        let (mut directions, mut faces) = icosahedron();
        for _ in 0..levels {
            // An edge has one middle, whichever face asks.
            let mut middles = BTreeMap::new();
            let mut middle = |p: usize, q: usize| {
                *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    directions.push((directions[p] + directions[q]).normalize());
                    directions.len() - 1
                })
            };
            let split = |[a, b, c]: [usize; 3]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(split).collect();
        }
        Icosphere { center, radius, directions, faces }
    }

    /// The corners of a face in the world, relative to the center.
    pub fn face(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|i| self.center + self.directions[i] * self.radius - self.center)
    }
}

fn icosahedron() -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (one, long) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        let p = DVec3::new(one, long, 0.0).normalize();
        positions.extend([p, DVec3::new(p.z, p.x, p.y), DVec3::new(p.y, p.z, p.x)]);
    }
    // Faces are the triples of nearest vertices.
    let side = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |a: usize, b: usize| (positions[a].distance(positions[b]) - side).abs() < 1e-9;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            faces.extend((b + 1..12).filter(|c| near(a, b) && near(b, *c) && near(a, *c)).map(|c| [a, b, c]));
        }
    }
    (positions, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_is_closed() {
        let sphere = Icosphere::new(2, DVec3::ZERO, 1.0);
        assert_eq!((sphere.directions.len(), sphere.faces.len()), (162, 320));
        let mut edges = BTreeMap::new();
        for face in &sphere.faces {
            for i in 0..3 {
                let (p, q) = (face[i], face[(i + 1) % 3]);
                *edges.entry([p.min(q), p.max(q)]).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|faces| *faces == 2));
    }
}
