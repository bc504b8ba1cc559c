//! Scattering, which is computed in `f32`, and light of lamps: B1 to B7.
//!
//! A picture shows one point of a surface from one direction, so its mean is known.

use std::f64::consts::{FRAC_PI_4, PI, TAU};
use std::sync::Arc;

use lookat_scene::Light;

use super::*;
use crate::estimate::mean;
use crate::text_scene::{at, emitting, green, matte, quad, sphere, two_sided};

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("B1", |trial| error(metal_under_sky(trial.at, FRAC_PI_4), albedo(trial.at, FRAC_PI_4))),
    ("B2", |trial| error(metal_under_sky(0.1, trial.at.acos()), albedo(0.1, trial.at.acos()))),
    ("B3", distant),
    ("B4", furnace),
    ("B5", at_edge),
    ("B6", sizes),
    ("B7", equal_lights),
];

/// Pixels on a side of the pictures.
const SIDE: u32 = 16;

/// One reflection, and no choice of lights.
const PATH: &str = "path\" \"integer maxdepth\" [1] \"string lightsamplestrategy\" \"uniform";

/// The mean of a picture of the points of the plane y = 0 up to a distance from the origin, seen at an angle to the normal.
fn mean_within(reach: f64, angle: f64, world: &str) -> f64 {
    mean_of(&one_point(reach, angle, 4096, PATH, world))
}

/// The text of a picture of the points of the plane y = 0 up to a distance from the origin.
fn one_point(reach: f64, angle: f64, samples: u32, integrator: &str, world: &str) -> String {
    let eye = DVec3::new(angle.sin(), angle.cos(), 0.0);
    let camera = format!(
        "LookAt {}  0 0 0  0 0 1 Camera \"orthographic\" \"float screenwindow\" [-{reach:e} {reach:e} -{reach:e} {reach:e}]",
        xyz(eye)
    );
    pictured(&camera, SIDE, samples, integrator, world)
}

/// The mean of the green channel of a picture.
fn mean_of(text: &str) -> f64 {
    mean(&green(&scene(text), 0))
}

fn floor(material: &str) -> String {
    format!("{material} {}", quad(DVec3::ZERO, DVec3::X * 9.0, DVec3::NEG_Z * 9.0))
}

fn gray_floor() -> String {
    floor(&matte(0.5))
}

/// The light of a white sky that a metal without absorption reflects, with a width `alpha` of the distribution of facets and
/// seen at `angle` to the normal.
fn metal_under_sky(alpha: f64, angle: f64) -> f64 {
    let metal = format!(
        "Material \"metal\" \"rgb eta\" [1 1 1] \"rgb k\" [10000 10000 10000] \"float roughness\" {alpha:?} \"bool remaproughness\" \"false\""
    );
    let world = format!("LightSource \"infinite\" {}", floor(&metal));
    mean_within(1e-6, angle, &world)
}

/// The same light in `f64`: the mean over visible normals of the share of reflected light that no other facet
/// blocks (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018, equations 2, 3 and 19).
fn albedo(alpha: f64, angle: f64) -> f64 {
    const GRID: u32 = 1024;
    let wo = DVec3::new(angle.sin(), 0.0, angle.cos());
    let lambda = |w: DVec3| {
        let slope = alpha * w.truncate().length() / w.z;
        ((1.0 + slope * slope).sqrt() - 1.0) / 2.0
    };
    let up = DVec3::new(alpha * wo.x, 0.0, wo.z).normalize();
    let across = DVec3::Y;
    let reflected = |i: u32| {
        let [t, v] = [i % GRID, i / GRID].map(|k| (f64::from(k) + 0.5) / f64::from(GRID));
        // Denser toward the steepest facets.
        let (u, density) = (1.0 - (1.0 - t).powi(4), 4.0 * (1.0 - t).powi(3));
        let (x, y) = (u.sqrt() * (TAU * v).cos(), u.sqrt() * (TAU * v).sin());
        let s = 0.5 * (1.0 + up.z);
        let y = (1.0 - s) * (1.0 - x * x).sqrt() + s * y;
        let n = across * x + up.cross(across) * y + up * (1.0 - x * x - y * y).max(0.0).sqrt();
        let facet = DVec3::new(alpha * n.x, alpha * n.y, n.z.max(0.0)).normalize();
        let wi = facet * (2.0 * wo.dot(facet)) - wo;
        if wi.z > 0.0 { density * (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(wi)) } else { 0.0 }
    };
    (0..GRID * GRID).map(reflected).sum::<f64>() / f64::from(GRID * GRID)
}

/// The light of a floor at a place, under whatever is above it and a sun straight above, seen from close by.
pub(super) fn floor_under_sun(place: DVec3, above: &str) -> f64 {
    const VOLPATH: &str = "volpath\" \"integer maxdepth\" [1] \"string lightsamplestrategy\" \"uniform";
    let sun = "LightSource \"distant\" \"point from\" [0 1 0] \"point to\" [0 0 0] ";
    let world = format!("{sun} {above} {}", at(place, &gray_floor()));
    let camera = format!(" Translate {} Camera", xyz(-place));
    mean_of(&one_point(1e-6, FRAC_PI_4, 16, VOLPATH, &world).replacen(" Camera", &camera, 1))
}

/// The relative error of a number.
pub(super) fn error(found: f64, truth: f64) -> Tally {
    Tally::measured(1, (found / truth - 1.0).abs())
}

/// A sphere light above a floor, as bright from there at any distance, up to the largest color of a scene file.
fn distant(trial: &Trial) -> Tally {
    let lamp = emitting([trial.at * trial.at; 3], &at(DVec3::Y * trial.at, &sphere(1.0)));
    // The irradiance over pi is the radiance times the squared sine of half of the angle at which the light is seen.
    error(mean_within(1e-6, FRAC_PI_4, &(lamp + &gray_floor())), 0.5)
}

/// In a sphere that emits and reflects evenly, light is a geometric series of a hundred reflections.
fn furnace(trial: &Trial) -> Tally {
    const BOUNCES: i32 = 100;
    let reflectance = trial.at;
    let world =
        format!("AreaLightSource \"diffuse\" {} ReverseOrientation Shape \"sphere\"", matte(reflectance));
    let camera = "LookAt .1 .2 .3  1 1 1  0 0 1 Camera \"perspective\" \"float fov\" 90";
    let integrator = PATH.replace("[1]", &format!("[{BOUNCES}] \"float rrthreshold\" [0]"));
    let mean = mean_of(&pictured(camera, SIDE, 64, &integrator, &world));
    error(mean, (1.0 - reflectance.powi(BOUNCES + 1)) / (1.0 - reflectance))
}

/// A polygon that emits evenly on both sides.
fn lamp(radiance: f64, corners: &[DVec3; 4]) -> String {
    two_sided([radiance; 3], &quads(corners))
}

/// The irradiance at the origin of a floor from a polygon with radiance 1, relative to a sky with radiance 1 (Lambert 1760).
fn share_of_sky(corners: &[DVec3; 4]) -> f64 {
    let side = |at: usize| {
        let (from, to) = (corners[at], corners[(at + 1) % 4]);
        from.angle_between(to) * from.cross(to).normalize_or_zero().y
    };
    ((0..4).map(side).sum::<f64>() / TAU).abs()
}

/// A floor beside the edge of a lamp that stands on it. The nearest part of the lamp is the brightest.
fn at_edge(trial: &Trial) -> Tally {
    /// A distance from the edge that counts as none.
    const ON_EDGE: f64 = 1e-12;
    let gap = trial.at;
    // Seen along the lamp. On the edge itself, points are off to either side by less than the offset of rays.
    let reach = if gap > ON_EDGE { 1e-6 * gap } else { ON_EDGE };
    let [low, high] = [-0.4, 0.7].map(|x| DVec3::new(x, 0.0, -gap));
    let corners = [low, high, high + DVec3::Y, low + DVec3::Y];
    let world = lamp(1.0, &corners) + &gray_floor();
    error(mean_within(reach, FRAC_PI_4, &world), 0.5 * share_of_sky(&corners))
}

/// A small lamp before one of 1e9, which it hides in part.
fn sizes(trial: &Trial) -> Tally {
    let size = trial.at;
    let ceiling = |height: f64, half: f64| square(DVec3::Y * height, DVec3::X * half, DVec3::Z * half);
    let (small, large) = (ceiling(2.0 * size, size), ceiling(2e9, 4e9));
    let world = lamp(3.0, &small) + &lamp(1.0, &large) + &gray_floor();
    let expected = 0.5 * (share_of_sky(&large) + 2.0 * share_of_sky(&small));
    error(mean_within(1e-6 * size, FRAC_PI_4, &world), expected)
}

/// Equal point lights on a grid, -1 to 1 along x and z: the mean at one point of a floor below, by each choice of lights, and
/// the mean of a floor close below.
fn equal_lights(trial: &Trial) -> Tally {
    let side = trial.at.sqrt() as u32;
    let place = |i: u32| f64::from(2 * i + 1) / f64::from(side) - 1.0;
    let spacing = 2.0 / f64::from(side);
    let lights = |height: f64| {
        let intensity = glam::Vec3::splat(1.0 / (side * side) as f32);
        let position = |i: u32| DVec3::new(place(i % side), height, place(i / side));
        (0..side * side).map(|i| Light::Point { position: position(i), intensity }).collect::<Vec<_>>()
    };
    let rendered = |text: &str, lights: Vec<Light>| {
        let mut scene = scene(text);
        Arc::make_mut(&mut scene.world).lights = lights;
        mean(&green(&scene, 0))
    };
    let world = format!("LightSource \"point\" {}", gray_floor());

    let square = |i: u32| place(i % side).powi(2) + place(i / side).powi(2);
    let sum: f64 = (0..side * side).map(|i| (1.0 + square(i)).powf(-1.5)).sum();
    let expected = 0.5 / PI * sum / f64::from(side * side);
    let mut all = Tally::default();
    for choice in ["uniform", "power", "spatial"] {
        let text = one_point(1e-6, FRAC_PI_4, 1024, &PATH.replace("uniform", choice), &world);
        all = all.join(error(rendered(&text, lights(1.0)), expected));
    }

    // Close below the grid, where a few lights give most of the light. All of the light that goes down arrives: 0.25. Single pixels have
    // rare bright samples, so the mean of all is checked.
    const PIXELS: u32 = 8;
    let reach = 0.5 * spacing * f64::from(PIXELS);
    let camera = format!(
        "LookAt 0 1 0  0 0 0  0 0 1 Camera \"orthographic\" \"float screenwindow\" [-{reach:?} {reach:?} -{reach:?} {reach:?}]"
    );
    let text = pictured(&camera, PIXELS, 1 << 14, &PATH.replace("uniform", "spatial"), &world);
    let mean = rendered(&text, lights(0.5 * spacing));
    all.check((mean / 0.25 - 1.0).abs() < 0.03, || {
        format!("the mean close below the lights is {mean}, not 0.25")
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nearly flat facets reflect everything. At normal incidence the mean over facets is an integral over their angle to the normal
    /// alone, since each reflects light at twice that angle.
    #[test]
    fn flat_metal_reflects_all_and_rough_metal_less() {
        assert!((albedo(0.001, FRAC_PI_4) - 1.0).abs() < 1e-5);
        const STEPS: u32 = 100_000;
        for alpha in [0.3, 1.0_f64] {
            let share = |i: u32| {
                let angle = FRAC_PI_4 * (f64::from(i) + 0.5) / f64::from(STEPS);
                let (squared, tan) = (alpha * alpha, angle.tan());
                let density = squared / (angle.cos().powi(4) * (squared + tan * tan).powi(2));
                let seen = 2.0 / (1.0 + (1.0 + (alpha * (2.0 * angle).tan()).powi(2)).sqrt());
                2.0 * density * angle.cos() * angle.sin() * seen
            };
            let expected = (0..STEPS).map(share).sum::<f64>() * FRAC_PI_4 / f64::from(STEPS);
            assert!((albedo(alpha, 0.0) / expected - 1.0).abs() < 1e-4, "{alpha} {expected}");
        }
    }
}
