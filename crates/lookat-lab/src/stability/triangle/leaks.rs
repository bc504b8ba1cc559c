//! T1 and T2: rays at edges and vertices of a closed mesh.

use glam::DMat3;

use super::mesh::Icosphere;
use super::text;
use crate::stability::prelude::*;

/// A mesh far from the origin of the world, and rays from its middle, where the eye is.
pub(super) fn far_from_origin(effort: &Effort) -> Found {
    let places = [1.0, 1e2, 1e4, 1e6, 1e8];
    let middle = |distance: f64| DVec3::new(0.6, 0.5, 0.62).normalize() * distance;
    run(
        effort,
        3100,
        &places.map(|distance| MeshPose { at: distance, center: middle(distance), radius: 1.0 }),
    )
}

pub(super) fn of_any_size(effort: &Effort) -> Found {
    let radii = [1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e30];
    run(effort, 3200, &radii.map(|radius| MeshPose { at: radius, center: DVec3::ZERO, radius }))
}

struct MeshPose {
    at: f64,
    center: DVec3,
    radius: f64,
}

/// The rays of the same shots at the mesh and at a stretched copy of it.
fn run(effort: &Effort, seed: u64, places: &[MeshPose]) -> Found {
    let mut found = Found::default();
    let stretch = stretch();
    for (seed, place) in (seed..).step_by(2).zip(places) {
        let mesh = Placed::new(place);
        let scenes = [mesh.scene(place), mesh.instance(place)];
        let [plain, instance] = scenes.each_ref().map(Probe::new);
        let shoot = |seed, probe: &Probe, stretch: DMat3| {
            tally(effort.rays, seed, |random, tally| {
                let (o, d) = Shot::new(random, mesh.faces.len()).ray(place, &mesh);
                tally.answer(
                    probe.nearest(&Ray::new(probe.eye() + stretch * o, (stretch * d).normalize())).is_some(),
                );
            })
        };
        let [plain, instance] = [shoot(seed, &plain, DMat3::IDENTITY), shoot(seed + 1, &instance, stretch)];
        found.add(LOOKAT, Some(place.at), plain.join(instance));
        found.add("lookat, instances", Some(place.at), instance);
    }
    found
}

/// What the instance does to the mesh: a rotation of a stretched copy.
fn stretch() -> DMat3 {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    DMat3::from_axis_angle(axis, 40_f64.to_radians()) * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.25))
}

/// A mesh in the world.
struct Placed {
    sphere: Icosphere,
    positions: Vec<DVec3>,
    faces: Vec<[DVec3; 3]>,
}

impl Placed {
    fn new(place: &MeshPose) -> Placed {
        let sphere = Icosphere::new(2);
        let positions: Vec<DVec3> =
            sphere.positions.iter().map(|p| place.center + *p * place.radius).collect();
        let faces: Vec<[DVec3; 3]> = sphere.faces.iter().map(|face| face.map(|i| positions[i])).collect();
        Placed { sphere, positions, faces }
    }

    /// The mesh, with the eye in its middle.
    fn scene(&self, place: &MeshPose) -> Scene {
        scene(&text(place.center, &mesh(&self.positions, &self.sphere.faces)))
    }

    /// A turned and stretched instance of the mesh there.
    fn instance(&self, place: &MeshPose) -> Scene {
        let positions: Vec<DVec3> = self.sphere.positions.iter().map(|p| *p * place.radius).collect();
        let mesh = mesh(&positions, &self.sphere.faces);
        let [x, y, z] = place.center.to_array();
        let world = format!(
            "ObjectBegin \"o\"\n{mesh}\nObjectEnd\nTranslate {x:?} {y:?} {z:?} Rotate 40 1 2 3 Scale 2 0.5 1.25\n\
             ObjectInstance \"o\""
        );
        scene(&text(place.center, &world))
    }

    fn around_center(&self, face: usize, center: DVec3) -> [DVec3; 3] {
        self.faces[face].map(|p| p - center)
    }
}

/// A ray at an edge, or every other time at a vertex, from somewhere inside.
struct Shot {
    /// In radii.
    from: DVec3,
    face: usize,
    corner: usize,
    along: f64,
}

impl Shot {
    fn new(random: &mut Pcg64Mcg, faces: usize) -> Shot {
        Shot {
            from: direction(random) * (0.5 * random.random::<f64>()),
            face: random.random_range(0..faces),
            corner: random.random_range(0..3),
            along: if random.random() { random.random() } else { 0.0 },
        }
    }

    /// The ray, relative to the middle of the mesh. Its origin in the world is not rounded.
    fn ray(&self, place: &MeshPose, mesh: &Placed) -> (DVec3, DVec3) {
        let o = place.center + self.from * place.radius - place.center;
        let face = mesh.around_center(self.face, place.center);
        let (p, q) = (face[self.corner], face[(self.corner + 1) % 3]);
        (o, (p + (q - p) * self.along - o).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays that miss all edges by far hit in the mesh and in its instance.
    #[test]
    fn rays_at_the_middle_of_faces_hit() {
        let place = MeshPose { at: 0.0, center: DVec3::new(1.0, 2.0, 3.0), radius: 0.5 };
        let mesh = Placed::new(&place);
        let scenes = [mesh.scene(&place), mesh.instance(&place)];
        let [plain, instance] = scenes.each_ref().map(Probe::new);
        for face in 0..mesh.faces.len() {
            let [a, b, c] = mesh.around_center(face, place.center);
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
