//! Scattering, which is computed in `f32`, and light of flat lamps: B1 to B6.
//!
//! A picture shows one point of a surface from one direction, so its mean is known.

use std::f64::consts::{FRAC_PI_4, TAU};

use crate::stability::prelude::*;

pub(super) const MEASURES: &[(&str, Measure)] =
    &[("B1", roughness), ("B2", grazing), ("B3", distant), ("B4", furnace), ("B5", at_edge), ("B6", sizes)];

/// Pixels on a side of the pictures.
const SIDE: u32 = 16;

/// One reflection, and no choice of lights.
const PATH: &str = "path\" \"integer maxdepth\" [1] \"string lightsamplestrategy\" \"uniform";

/// The mean of a picture of `world`, in which a plane across y is seen from an angle to its normal, at one point.
fn mean(angle: f64, world: &str) -> f64 {
    mean_within(1e-6, angle, world)
}

/// The same of all points up to a distance.
fn mean_within(reach: f64, angle: f64, world: &str) -> f64 {
    let eye = DVec3::new(angle.sin(), angle.cos(), 0.0);
    let camera = format!(
        "LookAt {}  0 0 0  0 0 1 Camera \"orthographic\" \"float screenwindow\" [-{reach:e} {reach:e} -{reach:e} {reach:e}]",
        xyz(eye)
    );
    mean_of(&pictured(&camera, SIDE, 4096, PATH, world))
}

/// The mean of a picture, of green.
fn mean_of(text: &str) -> f64 {
    let pixels = render(&scene(text), 0);
    pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / pixels.len() as f64
}

fn floor(material: &str) -> String {
    let corners = square(DVec3::ZERO, DVec3::X * 9.0, DVec3::NEG_Z * 9.0);
    format!("Material {material} {}", mesh(&corners, &[[0, 1, 2], [0, 2, 3]]))
}

/// What a metal that absorbs nothing reflects of a white sky, of the width `alpha` and seen from `angle`.
fn metal_under_sky(alpha: f64, angle: f64) -> f64 {
    let metal = format!(
        "\"metal\" \"rgb eta\" [1 1 1] \"rgb k\" [10000 10000 10000] \"float roughness\" {alpha:?} \"bool remaproughness\" \"false\""
    );
    let world = format!("LightSource \"infinite\" {}", floor(&metal));
    mean(angle, &world)
}

/// The same in `f64`: the mean over the normals of facets that are seen from there of the share of reflected light that no facet
/// stops (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018, equations 2, 3 and 19).
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
        // Most points are where the steepest facets are, which are few.
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

/// The relative error of a number.
fn error(found: f64, truth: f64) -> Tally {
    let mut tally = Tally::default();
    tally.error((found / truth - 1.0).abs());
    tally
}

fn roughness(_: &Effort) -> Found {
    Found::sweep(0, [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0], |_, alpha| {
        error(metal_under_sky(alpha, FRAC_PI_4), albedo(alpha, FRAC_PI_4))
    })
}

fn grazing(_: &Effort) -> Found {
    Found::sweep(0, decades((-5..=0).rev()), |_, cos| {
        error(metal_under_sky(0.1, cos.acos()), albedo(0.1, cos.acos()))
    })
}

/// A sphere that shines down on a floor, as bright from there at any distance, up to the brightest color that a file may have.
fn distant(_: &Effort) -> Found {
    Found::sweep(0, decades(1..=9), |_, distance| {
        let bright = distance * distance;
        let world = format!(
            "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [{bright} {bright} {bright}] Translate 0 {distance:?} 0
             Shape \"sphere\" AttributeEnd {}",
            floor("\"matte\" \"rgb Kd\" [.5 .5 .5]")
        );
        // The irradiance over pi is the radiance times the squared sine of half of the angle at which it is seen.
        error(mean(FRAC_PI_4, &world), 0.5)
    })
}

/// Inside of a sphere that shines and reflects evenly, light is a geometric series of a hundred reflections.
fn furnace(_: &Effort) -> Found {
    const BOUNCES: i32 = 100;
    Found::sweep(0, [0.5, 0.9, 0.99], |_, reflectance| {
        let world = format!(
            "AreaLightSource \"diffuse\" Material \"matte\" \"rgb Kd\" [{reflectance:?} {reflectance:?} {reflectance:?}]
             ReverseOrientation Shape \"sphere\""
        );
        let camera = "LookAt .1 .2 .3  1 1 1  0 0 1 Camera \"perspective\" \"float fov\" 90";
        let integrator = PATH.replace("[1]", &format!("[{BOUNCES}] \"float rrthreshold\" [0]"));
        let mean = mean_of(&pictured(camera, SIDE, 64, &integrator, &world));
        error(mean, (1.0 - reflectance.powi(BOUNCES + 1)) / (1.0 - reflectance))
    })
}

/// A polygon that emits evenly on both sides.
fn lamp(radiance: f64, corners: &[DVec3; 4]) -> String {
    format!(
        "AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" \"true\" \"rgb L\" [{radiance:?} {radiance:?} {radiance:?}]
         {} AttributeEnd ",
        mesh(corners, &[[0, 1, 2], [0, 2, 3]])
    )
}

/// The light that a black body with the radiance 1 over a floor brings to its origin, as a share of what a sky does (Lambert 1760).
fn share_of_sky(corners: &[DVec3; 4]) -> f64 {
    let side = |at: usize| {
        let (from, to) = (corners[at], corners[(at + 1) % 4]);
        from.angle_between(to) * from.cross(to).normalize_or_zero().y
    };
    ((0..4).map(side).sum::<f64>() / TAU).abs()
}

/// A distance from an edge that counts as none.
const ON_EDGE: f64 = 1e-12;

/// A floor beside the edge of a lamp that stands on it: the nearest part of the lamp is the brightest.
fn at_edge(_: &Effort) -> Found {
    Found::sweep(0, std::iter::once(ON_EDGE).chain(decades(-8..=0)), |_, gap| {
        // Seen along the lamp. On the edge itself, points are off to either side, by less than rays are.
        let reach = if gap > ON_EDGE { 1e-6 * gap } else { ON_EDGE };
        let [low, high] = [-0.4, 0.7].map(|x| DVec3::new(x, 0.0, -gap));
        let corners = [low, high, high + DVec3::Y, low + DVec3::Y];
        let world = lamp(1.0, &corners) + &floor("\"matte\" \"rgb Kd\" [.5 .5 .5]");
        error(mean_within(reach, FRAC_PI_4, &world), 0.5 * share_of_sky(&corners))
    })
}

/// A small lamp before one of 1e9, which it hides in part.
fn sizes(_: &Effort) -> Found {
    Found::sweep(0, decades(-9..=0), |_, size| {
        let ceiling = |height: f64, half: f64| square(DVec3::Y * height, DVec3::X * half, DVec3::Z * half);
        let (small, large) = (ceiling(2.0 * size, size), ceiling(2e9, 4e9));
        let world = lamp(3.0, &small) + &lamp(1.0, &large) + &floor("\"matte\" \"rgb Kd\" [.5 .5 .5]");
        let expected = 0.5 * (share_of_sky(&large) + 2.0 * share_of_sky(&small));
        error(mean_within(1e-6 * size, FRAC_PI_4, &world), expected)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of facets that are all but flat everything is reflected. At normal incidence the mean over facets is an integral over their
    /// angle to the normal alone, as each reflects light at twice that angle.
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
