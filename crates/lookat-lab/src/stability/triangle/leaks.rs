//! T1 and T2: rays at edges and vertices of a closed mesh.

use std::collections::BTreeMap;

use crate::stability::prelude::*;

/// A mesh far from the origin of the world, and rays from its middle, where the eye is.
pub(super) fn far_from_origin(effort: &Effort) -> Found {
    let middle = DVec3::new(0.6, 0.5, 0.62).normalize();
    let distances = [1.0, 1e2, 1e4, 1e6, 1e8];
    run(effort, 3100, distances.map(|distance| (distance, Ball::new(middle * distance, 1.0))))
}

pub(super) fn of_any_size(effort: &Effort) -> Found {
    let radii = [1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e30];
    run(effort, 3200, radii.map(|radius| (radius, Ball::new(DVec3::ZERO, radius))))
}

/// Rays at meshes and at stretched copies of them, each at its place on the axis.
fn run<const N: usize>(effort: &Effort, seed: u64, balls: [(f64, Ball); N]) -> Found {
    let mut found = Found::default();
    for (seed, (at, ball)) in (seed..).step_by(2).zip(balls) {
        let [plain, instance] = ball.probes();
        let shoot = |seed, probe: &Probe, stretch: DMat3| {
            tally(effort.rays, seed, |random, tally| {
                let (o, d) = ball.shot(random);
                let ray = Ray::new(probe.eye() + stretch * o, (stretch * d).normalize());
                tally.answer(probe.nearest(&ray).is_some());
            })
        };
        let plain = shoot(seed, &plain, DMat3::IDENTITY);
        let instance = shoot(seed + 1, &instance, stretch());
        found.add(LOOKAT, Some(at), plain.join(instance));
        found.add("lookat, instances", Some(at), instance);
    }
    found
}

/// What the instance does to the mesh: a rotation of a stretched copy.
fn stretch() -> DMat3 {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    DMat3::from_axis_angle(axis, 40_f64.to_radians()) * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.25))
}

/// A closed mesh around a point.
struct Ball {
    center: DVec3,
    radius: f64,
    sphere: Icosphere,
}

impl Ball {
    fn new(center: DVec3, radius: f64) -> Ball {
        Ball { center, radius, sphere: Icosphere::new(2) }
    }

    /// The mesh, and a turned and stretched instance of it, with the eye in the middle.
    fn probes(&self) -> [Probe; 2] {
        let around = |center: DVec3| {
            let positions: Vec<DVec3> =
                self.sphere.positions.iter().map(|p| center + *p * self.radius).collect();
            mesh(&positions, &self.sphere.faces)
        };
        let place = transform(&(DMat4::from_translation(self.center) * DMat4::from_mat3(stretch())));
        let object = format!("ObjectBegin \"o\" {} ObjectEnd", around(DVec3::ZERO));
        let instance = format!("{object} {place} ObjectInstance \"o\"");
        [around(self.center), instance].map(|world| probe(&seen_from(self.center, &world)))
    }

    /// The corners of a face in the world, relative to the middle.
    fn face(&self, face: usize) -> [DVec3; 3] {
        self.sphere.faces[face].map(|i| self.center + self.sphere.positions[i] * self.radius - self.center)
    }

    /// A ray at an edge, or every other time at a vertex, from somewhere inside, relative to the middle. Its origin in the
    /// world is not rounded.
    fn shot(&self, random: &mut Pcg64Mcg) -> (DVec3, DVec3) {
        let from = direction(random) * (0.5 * random.random::<f64>());
        let face = self.face(random.random_range(0..self.sphere.faces.len()));
        let corner = random.random_range(0..3);
        let along = if random.random() { random.random() } else { 0.0 };
        let o = self.center + from * self.radius - self.center;
        let (p, q) = (face[corner], face[(corner + 1) % 3]);
        (o, (p + (q - p) * along - o).normalize())
    }
}

/// A sphere of triangles around the origin, of radius one.
struct Icosphere {
    positions: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
}

impl Icosphere {
    /// Each triangle of the icosahedron is split in four, so many times.
    fn new(levels: u32) -> Icosphere {
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

    /// Rays that miss all edges by far hit in the mesh and in its instance.
    #[test]
    fn rays_at_the_middle_of_faces_hit() {
        let ball = Ball::new(DVec3::new(1.0, 2.0, 3.0), 0.5);
        let [plain, instance] = ball.probes();
        for face in 0..ball.sphere.faces.len() {
            let [a, b, c] = ball.face(face);
            let o = DVec3::new(0.05, -0.1, 0.02);
            let away = (a + b + c) / 3.0 - o;
            let hit = plain.nearest(&Ray::new(plain.eye() + o, away.normalize())).unwrap();
            assert!((hit.t - away.length()).abs() < 1e-14);
            let stretched = stretch() * away;
            let hit =
                instance.nearest(&Ray::new(instance.eye() + stretch() * o, stretched.normalize())).unwrap();
            assert!((hit.t - stretched.length()).abs() < 1e-14);
        }
    }

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
