//! T1 and T2: rays at edges and vertices of a closed mesh.

use super::mesh::Icosphere;
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
        let scenes = ball.scenes();
        let shoot = |seed, scene, stretch: DMat3| {
            let probe = Probe::new(scene);
            tally(effort.rays, seed, |random, tally| {
                let (o, d) = ball.shot(random);
                let ray = Ray::new(probe.eye() + stretch * o, (stretch * d).normalize());
                tally.answer(probe.nearest(&ray).is_some());
            })
        };
        let plain = shoot(seed, &scenes[0], DMat3::IDENTITY);
        let instance = shoot(seed + 1, &scenes[1], stretch());
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
    fn scenes(&self) -> [Scene; 2] {
        let around = |center: DVec3| {
            let positions: Vec<DVec3> =
                self.sphere.positions.iter().map(|p| center + *p * self.radius).collect();
            mesh(&positions, &self.sphere.faces)
        };
        let instance = format!(
            "ObjectBegin \"o\"\n{}\nObjectEnd\nTranslate {} Rotate 40 1 2 3 Scale 2 0.5 1.25\n\
             ObjectInstance \"o\"",
            around(DVec3::ZERO),
            xyz(self.center)
        );
        [around(self.center), instance].map(|world| scene(&seen_from(self.center, &world)))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays that miss all edges by far hit in the mesh and in its instance.
    #[test]
    fn rays_at_the_middle_of_faces_hit() {
        let ball = Ball::new(DVec3::new(1.0, 2.0, 3.0), 0.5);
        let scenes = ball.scenes();
        let [plain, instance] = scenes.each_ref().map(Probe::new);
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
}
