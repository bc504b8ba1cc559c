//! Rays that leave a surface, and shadow rays: V5 to V7.

use std::f64::consts::PI;

use super::*;
use crate::estimate::mean;
use crate::text_scene::{at, emitting, green, matte, quad, sphere};

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("V5", |trial| bodies(trial, trial.at, 0.0)),
    ("V5b", |trial| bodies(trial, 1.0, trial.at)),
    ("V6", thin),
    ("V7", |trial| if trial.at.is_nan() { in_the_open() } else { blocked(trial.at) }),
];

/// All bodies of a size, at a distance of so many sizes from the origin of the world.
///
/// The limit is 8 times 2^-40 of the largest coordinate that the point was computed with. This is the corner of a box or a
/// triangle, up to twice the size from the point, and the rotation of an instance adds up three axes: 8 covers both.
fn bodies(trial: &Trial, size: f64, distance: f64) -> Tally {
    let center = DVec3::new(0.6, -0.5, 0.62).normalize() * distance * size;
    // The eye is near the body, and at the origin of the world or far away.
    let far = if distance == 0.0 { DVec3::new(-3e3, 2e3, 5e3) * size } else { DVec3::ZERO };
    let eyes = [center + DVec3::new(3.0, -2.0, 4.0) * size, far];
    let count = trial.rays.div_ceil(2 * BODIES.len() as u64);
    let each = BODIES.iter().flat_map(|body| eyes.map(|eye| (*body, eye)));
    let one = |((body, eye), seed)| {
        let prepared = prepared(&body_text(body, eye, center, size));
        tally(count, seed, |random, tally| {
            if let Some(offset) =
                offset(random, &prepared, center - prepared.world.origin(), size, body == BALL)
            {
                tally.error(offset);
            }
        })
    };
    each.zip(20 * trial.seed..).map(one).collect()
}

const BALL: &str = "Shape \"sphere\"";

/// Convex closed bodies of about radius 1. Some are rotated and stretched, some are instances.
const BODIES: [&str; 5] = [
    BALL,
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 Shape \"sphere\"",
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 ObjectInstance \"sphere\"",
    "#polyhedron",
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 ObjectInstance \"polyhedron\"",
];

/// A scene of a body alone, under a camera at `eye`.
fn body_text(body: &str, eye: DVec3, center: DVec3, size: f64) -> String {
    let polyhedron = polyhedron();
    let objects =
        format!("ObjectBegin \"sphere\" {BALL} ObjectEnd ObjectBegin \"polyhedron\" {polyhedron} ObjectEnd");
    let body = body.replace("#polyhedron", &polyhedron);
    seen_from(eye, &format!("{objects} Translate {} Scale {size} {size} {size} {body}", xyz(center)))
}

/// An octahedron with four triangles per face. Corners and middles of edges are on the unit sphere.
fn polyhedron() -> String {
    let mut points = Vec::new();
    for octant in 0..8 {
        let sign = |bit: usize| if octant >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
        let middles = [0, 1, 2].map(|i| (corners[i] + corners[(i + 1) % 3]).normalize());
        points.extend((0..3).flat_map(|i| [corners[i], middles[i], middles[(i + 2) % 3]]));
        points.extend(middles);
    }
    triangles(&points)
}

/// The offset of the origin of a ray that leaves a body from its hit point. NaN if the ray hits the wrong surface. `None` if the
/// body is missed.
fn offset(
    random: &mut Pcg64Mcg,
    prepared: &PreparedScene,
    center: DVec3,
    size: f64,
    is_ball: bool,
) -> Option<f64> {
    let start = center + direction(random) * size * between(random, 2.0, 10.0);
    let target = center + in_cube(random) * 0.5 * size;
    let ray = Ray::new(start, (target - start).normalize());
    let hit = prepared.world.nearest(&ray)?;
    let point = prepared.world.surface(&ray, &hit);
    let n = if point.n.dot(point.p - center) > 0.0 { point.n } else { -point.n };
    let outward = chance(random, 0.5);
    let d = if outward { leaving(random, n, [-6.0, -3.0]) } else { -leaving(random, n, [-3.0, 0.0]) };
    let ray = prepared.world.surface(&ray, &hit).spawn_ray(d);
    let next = prepared.world.nearest(&ray);
    let chord = 2.0 * size * d.dot(n).abs();
    let right = match next {
        None => outward,
        // The far side of a ball is known. The ray leaves another body through a face with an outward normal along the ray.
        Some(next) if is_ball => !outward && next.t > 0.5 * chord,
        Some(next) => {
            let exit = prepared.world.surface(&ray, &next);
            !outward && exit.n.dot(exit.p - center) * exit.n.dot(d) > 0.0
        }
    };
    let is_right = right && prepared.world.occluded(&ray) == next.is_some();
    let offset = (ray.o - point.p).length() / point.p.abs().max_element().max(size);
    Some(if is_right { offset } else { f64::NAN })
}

/// Two parallel quads, the first at a distance of 1 from the eye, and two concentric spheres around the eye.
fn thin(trial: &Trial) -> Tally {
    let frame = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let gap = trial.at;
    let wall = |z: f64| quad(frame.z_axis * z, frame.x_axis, frame.y_axis);
    let spheres = sphere(1.0) + &sphere(1.0 + gap);
    let worlds = [wall(1.0) + &wall(1.0 + gap), format!("Translate 0.2 -0.3 0.1 {spheres}")];
    let one = |(world, seed): (&String, u64)| {
        let prepared = prepared(&around_eye(world));
        tally(trial.rays.div_ceil(2), seed, |random, tally| cross(random, &prepared, frame, tally))
    };
    worlds.iter().zip([trial.seed, trial.seed + 10]).map(one).collect()
}

/// Goes from the eye through the first surface: the ray must hit the second.
fn cross(random: &mut Pcg64Mcg, prepared: &PreparedScene, frame: DMat3, tally: &mut Tally) {
    let toward = DVec3::new(between(random, -0.5, 0.5), between(random, -0.5, 0.5), 1.0);
    let ray = Ray::new(DVec3::ZERO, (frame * toward).normalize());
    let first = prepared.world.nearest(&ray).filter(|hit| hit.element.primitive == 0);
    let Some(first) = first else { return tally.answer(false) };
    let n = prepared.world.surface(&ray, &first).n;
    let n = if n.dot(ray.d) < 0.0 { -n } else { n };
    let d = steep(random, n);
    let on = prepared.world.surface(&ray, &first).spawn_ray(d);
    let second = prepared.world.nearest(&on);
    tally.answer(second.is_some_and(|hit| hit.element.primitive == 1) && prepared.world.occluded(&on));
}

/// A direction whose cosine with `n` is more than 0.3.
fn steep(random: &mut Pcg64Mcg, n: DVec3) -> DVec3 {
    loop {
        let d = direction(random);
        if d.dot(n) > 0.3 {
            return d;
        }
    }
}

/// The distance of the light from the floor.
const DISTANCE: f64 = 10.0;

/// Pixels on a side of the pictures.
const SIDE: u32 = 16;

/// The pixels of the floor that a blocked light reaches.
fn blocked(gap: f64) -> Tally {
    let mut tally = Tally::default();
    for light in hidden_lights(gap) {
        for pixel in render(&scene(&floor_text(&light.concat(), 10.0, 16)), 0) {
            tally.answer(pixel == [0.0; 3]);
        }
    }
    tally
}

/// Lights, each with a blocker at this share of the distance before it.
fn hidden_lights(gap: f64) -> [[String; 2]; 3] {
    let below = DISTANCE * (1.0 - gap);
    let around = |radius: f64| at(DVec3::Y * DISTANCE, &sphere(radius));
    [
        [square_light(), flat_square(below, 1.5)],
        [emitting([1.0; 3], &around(1.0)), around(1.0 + DISTANCE * gap)],
        [format!("LightSource \"point\" \"point from\" [0 {DISTANCE} 0]\n"), flat_square(below, 1.0)],
    ]
}

/// A horizontal square.
fn flat_square(height: f64, half: f64) -> String {
    quad(DVec3::Y * height, DVec3::X * half, DVec3::Z * half)
}

/// A square light of half size 1.
fn square_light() -> String {
    emitting([1.0; 3], &flat_square(DISTANCE, 1.0))
}

/// The text of a floor, seen from below the light.
fn floor_text(world: &str, half_width: f64, samples: u32) -> String {
    let camera =
        format!("LookAt 0 5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" {}", 2.0 * half_width);
    let world = format!("{world} {}{}", matte(0.5), flat_square(0.0, 4.0));
    pictured(&camera, SIDE, samples, "directlighting", &world)
}

/// The relative error of the light that the square casts on the point below it: alone, and in a wall in its plane.
fn in_the_open() -> Tally {
    let errors = [String::new(), flat_square(DISTANCE, 3.0)].map(|wall| {
        // So narrow that all pixels see one point. The camera looks from below the wall.
        let pixels = green(&scene(&floor_text(&(square_light() + &wall), 1e-6, 1024)), 0);
        (mean(&pixels) / (0.5 * form_factor()) - 1.0).abs()
    });
    let [alone, in_wall] = errors;
    let remark = format!("square light alone: relative error {alone:.1e}; in a wall: {in_wall:.1e}");
    errors.map(|error| Tally::measured(1, error)).into_iter().collect::<Tally>().remark(remark)
}

/// The form factor from a point to the square above it: four times that of a quarter above its corner (Howell, "A Catalog of
/// Radiation Heat Transfer Configuration Factors", B-3).
fn form_factor() -> f64 {
    let a = 1.0 / DISTANCE;
    let root = (1.0 + a * a).sqrt();
    4.0 * (2.0 * a / root * (a / root).atan()) / (2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_convex_and_around_their_center() {
        for body in BODIES {
            let (eye, center) = (DVec3::new(1.0, 2.0, 30.0), DVec3::new(5.0, 6.0, 7.0));
            let prepared = prepared(&body_text(body, eye, center, 2.0));
            assert_eq!(prepared.world.origin() + prepared.camera.eye, eye);
            let mut random = Pcg64Mcg::seed_from_u64(4);
            for _ in 0..1000 {
                // From inside there is one hit, and nothing beyond it.
                let o = center - prepared.world.origin() + in_cube(&mut random) * 0.2;
                let ray = Ray::new(o, direction(&mut random));
                let hit = prepared.world.nearest(&ray).expect("a closed body");
                let p = ray.at(hit.t * 1.000_001);
                assert!((0.5..2.1).contains(&(p + prepared.world.origin() - center).length()), "{body}");
                assert!(prepared.world.nearest(&Ray::new(p, ray.d)).is_none(), "{body}");
            }
        }
    }

    /// Against the sum over small squares.
    #[test]
    fn form_factor_is_that_of_the_sum() {
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let part = |x: f64, y: f64| {
            let squared = x * x + y * y + DISTANCE * DISTANCE;
            DISTANCE * DISTANCE / (PI * squared * squared) * (2.0 / f64::from(n)).powi(2)
        };
        let sum: f64 = (0..n * n).map(|i| part(at(i % n), at(i / n))).sum();
        assert!((form_factor() / sum - 1.0).abs() < 1e-5);
    }

    /// Without the blockers every pixel is lit, so dark pixels are a real result.
    #[test]
    fn lights_reach_the_floor_unless_blocked() {
        for [light, _] in hidden_lights(0.5) {
            let pixels = render(&scene(&floor_text(&light, 10.0, 16)), 1);
            assert!(!pixels.is_empty() && pixels.iter().all(|pixel| pixel[0] > 0.0));
        }
    }
}
