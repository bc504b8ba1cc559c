//! T1 and T2: rays at edges and vertices of a closed mesh.

use glam::{DMat3, DVec3};
use lookat_render::{Probe, Ray};
use lookat_scene::Scene;
use num_traits::Float;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::mesh::Icosphere;
use super::{COUNT, direction, mesh_text, names, text};
use crate::stability::case::{Effort, Found};
use crate::stability::methods::triangle::{DOUBLE, Formula, SINGLE, Triangle};
use crate::stability::methods::{Vector, double, single};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

/// The formulas get world coordinates, as their renderers do; lookat makes them relative to the eye. At 1e8 the vertices
/// of single precision are 8 apart: there it is the rounding of the mesh that fails, not the formula.
pub(super) fn far_from_origin(effort: &Effort) -> Found {
    let places = [1.0, 1e2, 1e4, 1e6, 1e8];
    let middle = |distance: f64| DVec3::new(0.6, 0.5, 0.62).normalize() * distance;
    run(effort, 3100, &places.map(|distance| Place { at: distance, center: middle(distance), radius: 1.0 }))
}

pub(super) fn of_any_size(effort: &Effort) -> Found {
    let radii = [1e-30, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e30];
    run(effort, 3200, &radii.map(|radius| Place { at: radius, center: DVec3::ZERO, radius }))
}

struct Place {
    at: f64,
    center: DVec3,
    radius: f64,
}

fn run(effort: &Effort, seed: u64, places: &[Place]) -> Found {
    let mut found = Found::default();
    let mut names = names();
    names.push("lookat, instances");
    for (number, place) in places.iter().enumerate() {
        let mesh = Placed::new(place);
        let scenes = [mesh.scene(place), mesh.instance(place)];
        let [plain, instance] = scenes.each_ref().map(Probe::new);
        let stretch = stretch();
        let attempt = |random: &mut Pcg64Mcg, tallies: &mut [Tally; COUNT + 1]| {
            let shot = Shot::new(random, mesh.faces.len());
            let (o, d) = shot.ray(place, mesh.around_center(shot.face, place.center));
            let hit = plain.nearest(&Ray::new(plain.eye() + o, d)).is_some();
            // The rays of the same shot at the stretched copy.
            let d = (stretch * d).normalize();
            let hit_of_instance = instance.nearest(&Ray::new(instance.eye() + stretch * o, d)).is_some();
            tallies[0].answer(hit);
            tallies[0].answer(hit_of_instance);
            tallies[COUNT].answer(hit_of_instance);
            mesh.formulas(&shot, place, &mut tallies[1..COUNT]);
        };
        found.add(Some(place.at), &names, &tally(effort.rays, seed + number as u64, attempt));
    }
    found
}

/// What the instance does to the mesh: a rotation of a stretched copy.
fn stretch() -> DMat3 {
    let axis = DVec3::new(1.0, 2.0, 3.0).normalize();
    DMat3::from_axis_angle(axis, 40_f64.to_radians()) * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.25))
}

/// A mesh in the world, as each precision holds it.
struct Placed {
    sphere: Icosphere,
    positions: Vec<DVec3>,
    faces: Vec<[DVec3; 3]>,
    double: Vec<Triangle<f64>>,
    single: Vec<Triangle<f32>>,
    near: Vec<Vec<usize>>,
}

impl Placed {
    fn new(place: &Place) -> Placed {
        let sphere = Icosphere::new(2);
        let positions: Vec<DVec3> =
            sphere.positions.iter().map(|p| place.center + *p * place.radius).collect();
        let faces: Vec<[DVec3; 3]> = sphere.faces.iter().map(|face| face.map(|i| positions[i])).collect();
        Placed {
            near: sphere.neighbors(),
            double: faces.iter().map(|face| face.map(|p| p.to_array())).collect(),
            single: faces.iter().map(|face| face.map(single)).collect(),
            sphere,
            positions,
            faces,
        }
    }

    /// The mesh, with the eye in its middle.
    fn scene(&self, place: &Place) -> Scene {
        scene(&text(place.center, &mesh_text(&self.positions, &self.sphere.faces)))
    }

    /// A turned and stretched instance of the mesh there.
    fn instance(&self, place: &Place) -> Scene {
        let positions: Vec<DVec3> = self.sphere.positions.iter().map(|p| *p * place.radius).collect();
        let mesh = mesh_text(&positions, &self.sphere.faces);
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

    fn formulas(&self, shot: &Shot, place: &Place, tallies: &mut [Tally]) {
        let (of_single, of_double) = tallies.split_at_mut(SINGLE.len());
        let (o, d) = shot.ray(place, self.around_center(shot.face, place.center));
        let ray = [(place.center + o).to_array(), d.to_array()];
        for (tally, (_, formula)) in of_double.iter_mut().zip(DOUBLE) {
            tally.answer(self.meets(formula, ray, &self.double, shot.face));
        }
        // Aimed at what single precision makes of the mesh.
        let o = double(single(place.center + o));
        let target = shot.target(self.single[shot.face].map(double));
        let ray = [single(o), single((target - o).normalize_or(DVec3::Z))];
        for (tally, (_, formula)) in of_single.iter_mut().zip(SINGLE) {
            tally.answer(self.meets(formula, ray, &self.single, shot.face));
        }
    }

    /// Whether the ray meets a face around its target. A hit of any other would be no better than a miss.
    fn meets<T: Float>(
        &self,
        formula: Formula<T>,
        [o, d]: [Vector<T>; 2],
        faces: &[Triangle<T>],
        target: usize,
    ) -> bool {
        self.near[target].iter().any(|face| formula(o, d, &faces[*face]).is_some())
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

    fn target(&self, face: [DVec3; 3]) -> DVec3 {
        let (p, q) = (face[self.corner], face[(self.corner + 1) % 3]);
        p + (q - p) * self.along
    }

    /// The ray, relative to the middle of the mesh. Its origin in the world is not rounded.
    fn ray(&self, place: &Place, face: [DVec3; 3]) -> (DVec3, DVec3) {
        let o = place.center + self.from * place.radius - place.center;
        (o, (self.target(face) - o).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays that miss all edges by far hit by all formulas, and by lookat, in the mesh and in its instance.
    #[test]
    fn rays_at_the_middle_of_faces_hit() {
        let place = Place { at: 0.0, center: DVec3::new(1.0, 2.0, 3.0), radius: 0.5 };
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
            let ray = [(place.center + o).to_array(), away.to_array()];
            for (name, formula) in DOUBLE {
                assert!(mesh.meets(formula, ray, &mesh.double, face), "{name} {face}");
            }
            let ray = [single(place.center + o), single(away)];
            for (name, formula) in SINGLE {
                assert!(mesh.meets(formula, ray, &mesh.single, face), "{name} {face}");
            }
        }
    }
}
