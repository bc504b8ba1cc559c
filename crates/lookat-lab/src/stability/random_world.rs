//! Random scenes, and rays at their vertices, edges and silhouettes.

use lookat_scene::{Primitive, Shape};

use super::*;
use crate::text_scene::{block, cube, grid};

/// A random scene.
pub(super) struct RandomWorld {
    pub scene: Scene,
    size: f64,
    eye: DVec3,
    /// Edges of triangles.
    edges: Vec<[DVec3; 2]>,
    /// Transformations from the unit sphere to the world.
    spheres: Vec<DMat4>,
}

impl RandomWorld {
    pub fn new(random: &mut Pcg64Mcg) -> RandomWorld {
        let size = magnitude(random, -6.0, 6.0);
        let eye = if chance(random, 0.5) {
            DVec3::ZERO
        } else {
            direction(random) * size * magnitude(random, 0.0, 4.0)
        };
        let mut text = String::new();
        for number in 0..1 + below(random, 5) {
            let shapes: String = (0..1 + below(random, 3)).map(|_| body(random)).collect();
            if chance(random, 0.4) {
                text += &format!("ObjectBegin \"{number}\" {shapes} ObjectEnd\n");
                for _ in 0..1 + below(random, 5) {
                    text += &within(&place(random, size), &format!("ObjectInstance \"{number}\""));
                }
            } else {
                text += &within(&place(random, size), &shapes);
            }
        }
        let scene = scene(&seen_from(eye, &text));
        let shared = scene.world.clone();
        let mut world = RandomWorld { scene, size, eye, edges: Vec::new(), spheres: Vec::new() };
        world.add(&shared.primitives, DMat4::IDENTITY);
        for instance in &shared.instances {
            world.add(&instance.object.primitives, instance.world_from_object.matrix());
        }
        world
    }

    fn add(&mut self, primitives: &[Primitive], place: DMat4) {
        for primitive in primitives {
            match &primitive.shape {
                Shape::Quadric(sphere) => self.spheres.push(place * sphere.world_from_object.matrix()),
                Shape::TriangleMesh(mesh) => {
                    let corner = |i| place.transform_point3(DVec3::from(mesh.positions()[i as usize]));
                    for corners in mesh.indices().as_chunks().0 {
                        let [a, b, c] = corners.map(corner);
                        self.edges.extend([[a, b], [b, c], [c, a]]);
                    }
                }
                Shape::Curve(_) => {}
            }
        }
    }

    /// A ray, relative to `origin`, toward a vertex, an edge, a silhouette or any point.
    pub fn aimed(&self, random: &mut Pcg64Mcg, origin: DVec3) -> Ray {
        let start = match below(random, 3) {
            0 => self.eye,
            _ => in_cube(random) * self.size * magnitude(random, -0.5, 1.0),
        };
        let target = self.target(random, start);
        let (mut o, mut d) = (start - origin, (target - start).normalize_or(DVec3::Z));
        if chance(random, 0.2) {
            // Along an axis.
            let axis = below(random, 3);
            d = DVec3::AXES[axis] * if chance(random, 0.5) { 1.0 } else { -1.0 };
            o = target - origin - d * self.size * magnitude(random, -1.0, 1.0);
        }
        let t_max =
            if chance(random, 0.1) { self.size * magnitude(random, -2.0, 2.0) } else { f64::INFINITY };
        Ray { t_max, ..Ray::new(o, d) }
    }

    fn target(&self, random: &mut Pcg64Mcg, from: DVec3) -> DVec3 {
        let kind = below(random, 10);
        if kind < 6 && !self.edges.is_empty() {
            let [a, b] = self.edges[below(random, self.edges.len())];
            return if kind < 3 { a } else { a + (b - a) * between(random, 0.0, 1.0) };
        }
        if kind < 9 && !self.spheres.is_empty() {
            let sphere = self.spheres[below(random, self.spheres.len())];
            return silhouette(random, &sphere, from);
        }
        in_cube(random) * self.size
    }
}

/// A point of the ellipsoid where a ray from `from` touches it.
fn silhouette(random: &mut Pcg64Mcg, sphere: &DMat4, from: DVec3) -> DVec3 {
    let o = sphere.inverse().transform_point3(from);
    let distance = o.length();
    let on_unit = if distance > 1.0 {
        let axis = o / distance;
        let across = direction(random).cross(axis).normalize_or(axis.any_orthonormal_vector());
        let (cos, sin) = (1.0 / distance, (1.0 - distance.powi(-2)).sqrt());
        axis * cos + across * sin
    } else {
        direction(random)
    };
    sphere.transform_point3(on_unit)
}

/// A random transformation of a body of about size 1: moved, rotated, scaled, maybe sheared, mirrored or nearly flat.
fn place(random: &mut Pcg64Mcg, size: f64) -> DMat4 {
    let scale = size * magnitude(random, -3.0, 0.0);
    let at = DMat4::from_translation(in_cube(random) * size);
    let turn = |random: &mut Pcg64Mcg| DMat4::from_axis_angle(direction(random), between(random, 0.0, 7.0));
    let uniform = DMat4::from_scale(DVec3::splat(scale));
    let stretch = DVec3::from_array(std::array::from_fn(|_| magnitude(random, -4.0, 0.0)));
    match below(random, 5) {
        0 | 1 => at * uniform,
        2 => at * turn(random) * uniform,
        3 => at * uniform * DMat4::from_scale(stretch),
        _ => {
            let mirrored = DVec3::new(-1.0, 1.0, 1.0) * stretch;
            at * turn(random) * uniform * DMat4::from_scale(mirrored) * turn(random)
        }
    }
}

/// Directives under a transformation.
fn within(place: &DMat4, text: &str) -> String {
    block(&format!("{} {text}", transform(place)))
}

/// A body of about size 1.
fn body(random: &mut Pcg64Mcg) -> String {
    match below(random, 6) {
        0 => sphere(random, DMat4::IDENTITY),
        1 => {
            // Small spheres next to each other.
            let count = 2 + below(random, 20);
            let one = |_| {
                let small = DVec3::splat(magnitude(random, -2.0, -0.5));
                let place = DMat4::from_translation(in_cube(random)) * DMat4::from_scale(small);
                sphere(random, place)
            };
            (0..count).map(one).collect()
        }
        2 => {
            let corners: Vec<DVec3> = (0..3 * (1 + below(random, 40))).map(|_| in_cube(random)).collect();
            triangles(&corners)
        }
        3 => bumpy(random, 0.0),
        4 => bumpy(random, 0.2),
        _ => cube([-1.0; 3], [1.0; 3]),
    }
}

/// A whole or a cut sphere.
fn sphere(random: &mut Pcg64Mcg, place: DMat4) -> String {
    let mut shape = String::from("Shape \"sphere\"");
    if chance(random, 0.3) {
        let (low, high) = (between(random, -1.0, 0.0), between(random, 0.0, 1.0));
        let sweep = between(random, 30.0, 360.0);
        shape += &format!(" \"float zmin\" {low} \"float zmax\" {high} \"float phimax\" {sweep}");
    }
    within(&place, &shape)
}

/// A square grid of triangles with random heights.
fn bumpy(random: &mut Pcg64Mcg, height: f64) -> String {
    let side = 2 + below(random, 7);
    let along = |i: usize| -1.0 + 2.0 * (i as f64) / side as f64;
    grid(side, |x, y| DVec3::new(along(x), along(y), height * between(random, -1.0, 1.0)))
}
