//! Samples of meshes bring the light that Lambert's formula gives, with the densities that are said afterwards.

use std::f64::consts::PI;

use fearless_simd::mask32x8;
use glam::DVec2;

use super::*;
use crate::bsdf::Domain;
use crate::light::{LightTable, SceneLight};
use crate::number::{baseline, side_by_side};
use crate::prepare::Prepared;
use crate::testing::{levels, noise, scene, surfaces_at};

/// A flat lamp that emits on both sides: a polygon and its triangles.
struct Lamp {
    corners: Vec<DVec3>,
    indices: Vec<usize>,
}

impl Lamp {
    fn new(corners: &[[f64; 3]], indices: &[usize]) -> Self {
        Lamp { corners: corners.iter().copied().map(DVec3::from).collect(), indices: indices.to_vec() }
    }

    /// The same with another size, turned and moved.
    fn placed(&self, size: f64, turn: f64, offset: DVec3) -> Self {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), turn);
        let corners = self.corners.iter().map(|corner| turn * *corner * size + offset).collect();
        Lamp { corners, indices: self.indices.clone() }
    }

    fn normal(&self) -> DVec3 {
        (self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0]).normalize()
    }

    /// The weighted mean of the corners: the first weighs `first`, and the others share the rest equally.
    fn point(&self, first: f64) -> DVec3 {
        let rest = self.corners[1..].iter().sum::<DVec3>() / (self.corners.len() - 1) as f64;
        self.corners[0] * first + rest * (1.0 - first)
    }

    fn lights(&self) -> LightTable {
        let positions: String =
            self.corners.iter().map(|p| format!(" {:e} {:e} {:e}", p.x, p.y, p.z)).collect();
        let indices: String = self.indices.iter().map(|index| format!(" {index}")).collect();
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" WorldBegin
             AreaLightSource \"diffuse\" \"bool twosided\" \"true\" Shape \"trianglemesh\"
             \"integer indices\" [{indices}] \"point P\" [{positions}] WorldEnd"
        ));
        Prepared::new(&scene).lights
    }

    /// The directions of the corners.
    fn directions(&self, p: DVec3) -> Vec<DVec3> {
        self.corners.iter().map(|corner| (*corner - p).normalize()).collect()
    }

    /// The irradiance of radiance 1 on a surface with normal `n`, which all of it is above (Lambert 1760).
    fn irradiance(&self, p: DVec3, n: DVec3) -> f64 {
        let directions = self.directions(p);
        let side = |at: usize| {
            let (from, to) = (directions[at], directions[(at + 1) % directions.len()]);
            let across = from.cross(to);
            across.length().atan2(from.dot(to)) * across.normalize_or_zero().dot(n)
        };
        ((0..directions.len()).map(side).sum::<f64>() / 2.0).abs()
    }

    /// The solid angle, from the angles between its sides (Girard 1626).
    fn solid_angle(&self, p: DVec3) -> f64 {
        let (directions, count) = (self.directions(p), self.corners.len());
        let angle = |at: usize| {
            let [from, here, to] = [0, 1, 2].map(|step| directions[(at + step) % count]);
            here.cross(from).angle_between(here.cross(to))
        };
        (0..count).map(angle).sum::<f64>() - (count - 2) as f64 * PI
    }
}

/// Lamps of a size of about one: rectangles, a triangle, a trapezoid that is one leaf of the tree of lights, and a polygon of three leaves.
fn lamps() -> [Lamp; 5] {
    let rectangle = |x: f64, y: f64| {
        Lamp::new(&[[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]], &[2, 3, 0, 1, 2, 0])
    };
    let triangle = Lamp::new(&[[-0.7, -0.3, 0.0], [0.6, -0.2, 0.0], [0.1, 0.8, 0.0]], &[0, 1, 2]);
    let trapezoid = [[-0.7, -0.3, 0.0], [0.7, -0.3, 0.0], [0.2, 0.5, 0.0], [-0.2, 0.5, 0.0]];
    let pentagon = [[-0.6, -0.4, 0.0], [0.5, -0.5, 0.0], [0.8, 0.2, 0.0], [0.1, 0.7, 0.0], [-0.7, 0.3, 0.0]];
    [
        rectangle(0.5, 0.4),
        rectangle(1.0, 0.004),
        triangle,
        Lamp::new(&trapezoid, &[0, 1, 2, 0, 2, 3]),
        Lamp::new(&pentagon, &[0, 1, 2, 0, 2, 3, 0, 3, 4]),
    ]
}

/// A sample of the only light: its direction, its density, and that which is said afterwards of the point that it goes to.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drawn {
    d: DVec3,
    p: DVec3,
    triangle: usize,
    pdf: f64,
    afterwards: f64,
}

/// `triangle`: the one that is chosen, if one is.
fn drawn<S: Simd>(
    simd: S,
    table: &LightTable,
    (p, triangle): (DVec3, Option<usize>),
    u: DVec2,
) -> Option<Drawn> {
    let SceneLight::Surface(light) = &table.lights[0] else { unreachable!() };
    let SurfaceForm::Mesh(mesh) = &light.form else { unreachable!() };
    let (all, none) = (bits(simd, 0xff), bits(simd, 0));
    let surfaces = &surfaces_at(simd, p);
    let [is_two_sided, is_diffuse] = [true, false].map(|all| mask32x8::splat(simd, all));
    let domain = Domain { n: surfaces.n, ns: surfaces.n, is_two_sided, is_diffuse };
    let at = Receivers { surfaces: *surfaces, domain, lunes: None };
    let chosen = triangle.map(|triangle| u32x8::splat(simd, triangle as u32));
    let u = [u.x.simd_into(simd), u.y.simd_into(simd)];
    let sample = table.sample(simd, 0, (&at, none), (chosen, u));
    if sample.is_valid.to_bitmask() & 1 == 0 {
        return None;
    }
    let triangle = (sample.shadow.target[0] - light.label) as usize;
    let corners = mesh.corners(triangle);
    let magnitude = mesh.mesh.positions().iter().map(|p| DVec3::from(*p).abs().max_element());
    let magnitude: f64x8<S> = magnitude.fold(0.0, f64::max).simd_into(simd);
    let end = sample.shadow.at(sample.shadow.t_max + surfaces.rounding(magnitude));
    let found = LightHits {
        is_valid: all,
        d: sample.shadow.d,
        p: end,
        n: Vec3x8::splat(simd, (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize()),
        triangle: (triangle as u32).simd_into(simd),
        by_triangle: chosen.is_some(),
    };
    let afterwards = table.surface_pdf(simd, 0, surfaces, &found);
    let [pdf, afterwards] = [sample.pdf, afterwards].map(|pdf| f64::from(pdf[0]));
    Some(Drawn { d: sample.shadow.d.lane(0), p: end.lane(0), triangle, pdf, afterwards })
}

/// Numbers spread evenly.
fn grid(side: u32) -> impl Iterator<Item = DVec2> {
    let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side)))
}

#[test]
fn samples_bring_the_irradiance_of_the_polygon() {
    const SIDE: u32 = 64;
    for (number, lamp) in lamps().into_iter().enumerate() {
        for (case, size) in [1.0, 1e-9, 1e9].into_iter().enumerate() {
            let lamp = lamp.placed(size, 0.7 + case as f64, DVec3::ZERO);
            let (table, n) = (lamp.lights(), lamp.normal());
            for (first, height) in
                [(0.3, 0.05), (0.1, 0.4), (1.0, 0.02), (-3.0, 0.3), (0.5, 2.0), (-20.0, 9.0)]
            {
                let p = lamp.point(first) + n * (height * size);
                let mean: f64 = baseline!(simd => grid(SIDE)
                    .map(|u| drawn(simd, &table, (p, None), u).map_or(0.0, |drawn| drawn.d.dot(n).abs() / drawn.pdf))
                    .sum());
                // Parts that are chosen by their areas are a step for the numbers.
                let tolerance = if number < 3 { 5e-3 } else { 2e-2 };
                let (mean, expected) = (mean / f64::from(SIDE * SIDE), lamp.irradiance(p, n));
                assert!(
                    (mean / expected - 1.0).abs() < tolerance,
                    "{number} {size} {first} {height}: {mean} {expected}"
                );
            }
        }
    }
}

/// From nearby, the density is one over the solid angle of all that is chosen as one.
#[test]
fn the_density_is_one_over_the_solid_angle() {
    for lamp in &lamps()[..3] {
        for (first, height) in [(0.3, 0.05), (0.1, 0.4), (1.0, 0.02), (-3.0, 0.3), (0.5, 2.0)] {
            let p = lamp.point(first) + lamp.normal() * height;
            let drawn =
                baseline!(simd => drawn(simd, &lamp.lights(), (p, None), DVec2::new(0.3, 0.8))).unwrap();
            let product = drawn.pdf * lamp.solid_angle(p);
            assert!((product - 1.0).abs() < f64::from(f32::EPSILON), "{first} {height}: {product}");
        }
    }
}

/// Points anywhere: a corner, an edge, the plane, beside them by little and by much, in any number of sizes.
#[test]
fn densities_said_afterwards_are_those_of_samples() {
    let (mut lit, mut dark) = (0, 0);
    for (number, lamp) in lamps().into_iter().enumerate() {
        for (case, size) in [1.0, 1e-9, 1e9].into_iter().enumerate() {
            let offset = DVec3::new(3.0, -2.0, 1.0) * (size * case as f64);
            let lamp = lamp.placed(size, if case == 0 { 0.0 } else { 1.1 }, offset);
            let (table, n) = (lamp.lights(), lamp.normal());
            let edge = (lamp.corners[0] + lamp.corners[1]) * 0.5;
            let beyond = lamp.corners[0] * 2.0 - lamp.corners[1];
            for base in [lamp.corners[0], lamp.corners[1], edge, lamp.point(0.2), lamp.point(-1.0), beyond] {
                for height in [0.0, 1e-15, 1e-12, 1e-9, 1e-4, -1e-6, 0.1, 3.0, 1e3, -1e9] {
                    for k in 0..12 {
                        let p = base + n * (height * size);
                        let u = DVec2::new(noise(k, 1.3).abs(), noise(k, 2.7).abs());
                        let u =
                            [u, DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON)][k.saturating_sub(9).min(2)];
                        let triangle = (k % 2 == 1).then_some(k % (lamp.indices.len() / 3));
                        let what = format!("{number} {size} {base} {height} {u} {triangle:?}");
                        let all: Vec<_> = levels()
                            .into_iter()
                            .map(|level| side_by_side!(level, simd => drawn(simd, &table, (p, triangle), u)))
                            .collect();
                        assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "{what}");
                        let Some(drawn) = all[0] else {
                            dark += 1;
                            assert!(height.abs() < 1e-8, "{what}");
                            continue;
                        };
                        lit += 1;
                        assert!(height != 0.0 || case > 0, "{what}");
                        // The cosine is rounded.
                        let tolerance = 1e-6 + 1e-14 / drawn.d.dot(n).abs();
                        assert!((drawn.afterwards / drawn.pdf - 1.0).abs() < tolerance, "{what}: {drawn:?}");
                        assert!((drawn.d.length() - 1.0).abs() < 1e-12, "{what}: {drawn:?}");
                        let corners = &lamp.indices[3 * drawn.triangle..3 * drawn.triangle + 3];
                        let inside = (0..3).all(|at| {
                            let [from, to] = [at, (at + 1) % 3].map(|at| lamp.corners[corners[at]]);
                            (to - from).cross(drawn.p - from).dot(n) > -1e-6 * size * (to - from).length()
                        });
                        assert!(inside, "{what}: {drawn:?}");
                    }
                }
            }
        }
    }
    assert!(lit > 5_000 && dark > 500, "{lit} {dark}");
}

fn share(facing: &Facing, d: DVec3, spread: f32) -> f32 {
    baseline!(simd => facing.share(simd, Vec3fx8::splat(simd, d.as_vec3()), splat_f32(simd, spread))[0])
}

fn patch(p: DVec3, emitting: DVec3) -> Patch {
    Patch { p, emitting, area: 1.0 }
}

#[test]
fn flat_shapes_have_a_dark_side() {
    let (middle, slanted) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
    let flat = [patch(middle + DVec3::X, DVec3::Z), patch(middle - DVec3::X, DVec3::Z)];
    let shares = |two_sided| {
        let facing = Facing::new(flat.into_iter(), middle, two_sided);
        [DVec3::Z, slanted, DVec3::X, -DVec3::Z].map(|d| share(&facing, d, 0.0))
    };
    assert_eq!(shares(false), [1.0, 0.8, 0.0, 0.0]);
    assert_eq!(shares(true), [1.0, 0.8, 0.0, 1.0]);
    // Steps are seen from between them.
    let steps = [patch(middle + slanted, DVec3::Z), patch(middle - slanted, DVec3::Z)];
    assert_eq!(share(&Facing::new(steps.into_iter(), middle, false), -DVec3::Z, 0.0), 0.25);
    // All around.
    let cube = DVec3::AXES.map(|axis| [axis, -axis]).concat();
    let cube = cube.iter().map(|n| patch(middle + n, *n));
    assert_eq!(share(&Facing::new(cube, middle, false), slanted, 0.0), 0.25);
    // From nearby, more of a large shape is seen than of its middle; from its plane nothing.
    let facing = Facing::new(flat.into_iter(), middle, false);
    let lifted = DVec3::new(1.0, 0.0, 1e-7);
    assert_eq!([slanted, DVec3::X, lifted].map(|d| share(&facing, d, 0.2)), [0.8 + 0.1, 0.0, 0.0]);
}
