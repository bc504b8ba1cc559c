//! Random scenes, and rays at the places of them that are hard to hit.

use glam::DMat4;

use crate::stability::prelude::*;

/// A scene in words, and places in it.
pub(super) struct World {
    pub text: String,
    size: f64,
    eye: DVec3,
    /// Edges of triangles.
    edges: Vec<[DVec3; 2]>,
    /// From the unit sphere to the world.
    spheres: Vec<DMat4>,
}

/// A body in its own space.
#[derive(Default)]
struct Body {
    text: String,
    edges: Vec<[DVec3; 2]>,
    spheres: Vec<DMat4>,
}

impl World {
    pub fn new(random: &mut Pcg64Mcg) -> World {
        let size = magnitude(random, -6.0, 6.0);
        let eye = if chance(random, 0.5) {
            DVec3::ZERO
        } else {
            direction(random) * size * magnitude(random, 0.0, 4.0)
        };
        let mut world = World { text: String::new(), size, eye, edges: Vec::new(), spheres: Vec::new() };
        let mut text = format!(
            "Translate {} Camera \"perspective\" Integrator \"path\" Sampler \"sobol\" Film \"image\" WorldBegin\n",
            numbers(-eye)
        );
        for number in 0..1 + below(random, 5) {
            let bodies: Vec<Body> = (0..1 + below(random, 3)).map(|_| Body::new(random)).collect();
            let shapes: String = bodies.iter().map(|body| body.text.as_str()).collect();
            let as_object = chance(random, 0.4);
            if as_object {
                text += &format!("ObjectBegin \"{number}\" {shapes} ObjectEnd\n");
            }
            for _ in 0..if as_object { 1 + below(random, 5) } else { 1 } {
                let place = place(random, size);
                let what = if as_object { format!("ObjectInstance \"{number}\"") } else { shapes.clone() };
                text += &within(&place, &what);
                bodies.iter().for_each(|body| world.add(body, &place));
            }
        }
        world.text = text + "WorldEnd";
        world
    }

    fn add(&mut self, body: &Body, place: &DMat4) {
        self.edges.extend(body.edges.iter().map(|edge| edge.map(|p| place.transform_point3(p))));
        self.spheres.extend(body.spheres.iter().map(|sphere| *place * *sphere));
    }

    /// A ray, relative to `origin`, at a vertex, an edge, a silhouette or anything.
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
            d = DVec3::from_array(std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 }));
            d *= if chance(random, 0.5) { 1.0 } else { -1.0 };
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

/// A random place for a body of about size 1: moved, turned, scaled, maybe sheared, mirrored or nearly flat.
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

fn numbers(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

/// Text under a transformation.
fn within(place: &DMat4, text: &str) -> String {
    let numbers: Vec<String> = place.to_cols_array().map(|x| format!("{x:e}")).to_vec();
    format!("AttributeBegin ConcatTransform [{}] {text} AttributeEnd\n", numbers.join(" "))
}

impl Body {
    fn new(random: &mut Pcg64Mcg) -> Body {
        match below(random, 6) {
            0 => Body::sphere(random, DMat4::IDENTITY),
            1 => {
                // Small ones next to each other.
                let place = |random: &mut Pcg64Mcg| {
                    let small = DVec3::splat(magnitude(random, -2.0, -0.5));
                    DMat4::from_translation(in_cube(random)) * DMat4::from_scale(small)
                };
                let mut all = Body::default();
                for _ in 0..2 + below(random, 20) {
                    let place = place(random);
                    let one = Body::sphere(random, place);
                    all.text += &one.text;
                    all.spheres.extend(one.spheres);
                }
                all
            }
            2 => {
                let corners: Vec<DVec3> = (0..3 * (1 + below(random, 40))).map(|_| in_cube(random)).collect();
                let indices: Vec<usize> = (0..corners.len()).collect();
                Body::mesh(&corners, &indices)
            }
            3 => Body::grid(random, 0.0),
            4 => Body::grid(random, 0.2),
            _ => Body::cube(),
        }
    }

    /// Whole or cut.
    fn sphere(random: &mut Pcg64Mcg, place: DMat4) -> Body {
        let cut = if chance(random, 0.3) {
            let (low, high) = (between(random, -1.0, 0.0), between(random, 0.0, 1.0));
            format!(
                "\"float zmin\" {low} \"float zmax\" {high} \"float phimax\" {}",
                between(random, 30.0, 360.0)
            )
        } else {
            String::new()
        };
        let text = within(&place, &format!("Shape \"sphere\" {cut}"));
        Body { text, edges: Vec::new(), spheres: vec![place] }
    }

    fn mesh(corners: &[DVec3], indices: &[usize]) -> Body {
        let faces = indices.as_chunks().0;
        let edge = |t: &[usize; 3], i: usize| [corners[t[i]], corners[t[(i + 1) % 3]]];
        let edges = faces.iter().flat_map(|t| (0..3).map(move |i| edge(t, i))).collect();
        Body { text: mesh(corners, faces), edges, spheres: Vec::new() }
    }

    /// A square grid, up to so far out of its plane.
    fn grid(random: &mut Pcg64Mcg, height: f64) -> Body {
        let side = 2 + below(random, 7);
        let at = |i: usize| -1.0 + 2.0 * i as f64 / side as f64;
        let mut corners = Vec::new();
        for y in 0..=side {
            for x in 0..=side {
                corners.push(DVec3::new(at(x), at(y), height * between(random, -1.0, 1.0)));
            }
        }
        let mut indices = Vec::new();
        for i in (0..side * (side + 1)).filter(|i| i % (side + 1) < side) {
            let (right, up) = (i + 1, i + side + 1);
            indices.extend([i, right, up + 1, i, up + 1, up]);
        }
        Body::mesh(&corners, &indices)
    }

    fn cube() -> Body {
        let sign = |bit: usize| if bit & 1 == 0 { -1.0 } else { 1.0 };
        let corners: Vec<DVec3> = (0..8).map(|i| DVec3::new(sign(i), sign(i >> 1), sign(i >> 2))).collect();
        let indices = [
            0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3,
            7, 1, 7, 5,
        ];
        Body::mesh(&corners, &indices)
    }
}
