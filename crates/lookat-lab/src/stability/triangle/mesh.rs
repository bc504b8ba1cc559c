//! A closed mesh.

use std::collections::BTreeMap;

use crate::stability::prelude::*;

/// A sphere of triangles around the origin, of radius one.
pub(super) struct Icosphere {
    pub positions: Vec<DVec3>,
    pub faces: Vec<[usize; 3]>,
}

impl Icosphere {
    /// Each triangle of the icosahedron is split in four, so many times.
    pub fn new(levels: u32) -> Icosphere {
        let mut sphere = icosahedron();
        for _ in 0..levels {
            let faces = std::mem::take(&mut sphere.faces);
            let mut middles = BTreeMap::new();
            for [a, b, c] in faces {
                let mut middle = |p: usize, q: usize| sphere.middle(&mut middles, p, q);
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                sphere.faces.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
            }
        }
        sphere
    }

    /// The vertex between two others. An edge has one, whichever face asks.
    fn middle(&mut self, known: &mut BTreeMap<[usize; 2], usize>, p: usize, q: usize) -> usize {
        *known.entry([p.min(q), p.max(q)]).or_insert_with(|| {
            self.positions.push((self.positions[p] + self.positions[q]).normalize());
            self.positions.len() - 1
        })
    }
}

fn icosahedron() -> Icosphere {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (one, long) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        let p = DVec3::new(one, long, 0.0).normalize();
        positions.extend([p, DVec3::new(p.z, p.x, p.y), DVec3::new(p.y, p.z, p.x)]);
    }
    // Faces are the triples of vertices that are as near to each other as any two.
    let side = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |a: usize, b: usize| (positions[a].distance(positions[b]) - side).abs() < 1e-9;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            faces.extend((b + 1..12).filter(|c| near(a, b) && near(b, *c) && near(a, *c)).map(|c| [a, b, c]));
        }
    }
    Icosphere { positions, faces }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_is_closed() {
        let sphere = Icosphere::new(2);
        assert_eq!((sphere.positions.len(), sphere.faces.len()), (162, 320));
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
