//! Lenses: C5, C10, C12 and C13.

use twofloat::TwoFloat;

use super::exact::{CameraAxes, Pinhole, angle, length, tan_half};
use super::perspective::{far_look_at, pinhole};
use super::{anywhere, look_at, square, text};
use crate::stability::prelude::*;
use crate::stability::truth::{Wide, quotient};

const RESOLUTION: [u32; 2] = [640, 480];

pub(super) fn collapse(effort: &Effort) -> Found {
    Found::sweep(5000, decades(3..9), |seed, distance| {
        let points = far_look_at(distance);
        let camera =
            "Camera \"perspective\" \"float fov\" 45 \"float lensradius\" .05 \"float focaldistance\" 10";
        let probe = probe(&text(&format!("{} {camera}", look_at(points)), RESOLUTION));
        let exact = pinhole(points, 45.0, RESOLUTION);
        tally(effort.rays, seed, |random, tally| {
            let film = anywhere(random, RESOLUTION);
            let ray = probe.camera_ray(film, square(random));
            let [x, y] = exact.slope(film).map(|slope| slope * 10.0);
            tally.error(blur(exact.view.world(x, y, TwoFloat::from(10.0)), ray.o, ray.d));
        })
    })
}

/// How far from a point a ray passes, in radii of the lens.
fn blur(focus: Wide, o: DVec3, d: DVec3) -> f64 {
    let d = Wide::new(d);
    f64::from(quotient(length(focus.minus(Wide::new(o)).cross(d)), length(d))) / 0.05
}

pub(super) fn focal_distance(effort: &Effort) -> Found {
    Found::sweep(10_000, decades([-30, -12, -3, 0, 3, 12, 19, 20, 30, 300]), |seed, focal_distance| {
        through_lens(effort, seed, 1.0, focal_distance)
    })
}

pub(super) fn lens_radius(effort: &Effort) -> Found {
    let mut found = refused("C12");
    let probe = probe(&lens_text(-1.0, 10.0));
    let o = probe.camera_ray(DVec2::new(3.0, 5.0), DVec2::new(0.9, 0.1)).o;
    found.check(o == DVec3::ZERO, || format!("a lens of radius -1 is no pinhole: its ray starts at {o}"));
    let radii =
        Found::sweep(12_000, [1e-6, 1.0, 1e6], |seed, radius| through_lens(effort, seed, radius, 10.0));
    found.rows.extend(radii.rows);
    found
}

fn lens_text(radius: f64, focal_distance: f64) -> String {
    let lens = format!("\"float lensradius\" {radius} \"float focaldistance\" {focal_distance}");
    text(&format!("Camera \"perspective\" {lens}"), RESOLUTION)
}

/// Directions from points of the lens, given the points: a lens in camera space.
fn through_lens(effort: &Effort, seed: u64, radius: f64, focal_distance: f64) -> Tally {
    let probe = probe(&lens_text(radius, focal_distance));
    let exact = Pinhole { view: CameraAxes::CAMERA_SPACE, tan: tan_half(90.0), resolution: RESOLUTION };
    tally(effort.rays, seed, |random, tally| {
        let film = anywhere(random, RESOLUTION);
        let ray = probe.camera_ray(film, square(random));
        let truth = refracted(exact.slope(film), [ray.o.x, ray.o.y], focal_distance);
        // It must be on the lens, too.
        let is_on_lens = ray.o.z == 0.0 && ray.o.length() <= radius * (1.0 + 1e-15);
        tally.error(if is_on_lens { angle(ray.d, truth) } else { f64::NAN });
    })
}

/// The direction of a ray from a point of a lens. `[x, y]` is the slope of the ray through the middle of the lens that meets it in
/// the plane of focus.
fn refracted([x, y]: [TwoFloat; 2], lens: [f64; 2], focal_distance: f64) -> Wide {
    let one = TwoFloat::from(1.0);
    if focal_distance < 1.0 {
        return Wide([x * focal_distance - lens[0], y * focal_distance - lens[1], one * focal_distance]);
    }
    // Beyond this the lens is a point, to 40 digits.
    let scale = if focal_distance > 1e50 { TwoFloat::from(0.0) } else { one / focal_distance };
    Wide([x - scale * lens[0], y - scale * lens[1], one])
}

pub(super) fn telecentric(effort: &Effort) -> Found {
    let camera = "Camera \"orthographic\" \"float focaldistance\" 2 \"float lensradius\" .1";
    // Without the parameter it is as in pbrt-v3, which nobody can want.
    let mut found = refused("C13");
    let probe = probe(&text(&format!("{camera} \"bool telecentric\" \"true\""), RESOLUTION));
    let depths = Found::sweep(13_000, [0.1, 0.5, 1.0, 2.0, 10.0, 100.0], |seed, depth| {
        tally(effort.rays, seed, |random, tally| {
            let film = anywhere(random, RESOLUTION);
            // Points of the lens that lie opposite.
            let u = square(random);
            let rays = [u, DVec2::ONE - u].map(|u| probe.camera_ray(film, u));
            let eye = probe.origin();
            tally.error(off_center(rays.map(|ray| (ray.o + eye, ray.d)), on_window(film), depth));
        })
    });
    found.rows.extend(depths.rows);
    found
}

/// The default window of a landscape film, orthographic: the place of a pixel at all depths.
///
/// In `f64`, which is right to 1e-12 pixels: far below the limit.
fn on_window(film: DVec2) -> DVec2 {
    let [width, height] = RESOLUTION.map(f64::from);
    DVec2::new(2.0 * film.x - width, height - 2.0 * film.y) / height
}

/// How far the mean of two rays is from a pixel, at a depth in focal distances of 2.
fn off_center(rays: [(DVec3, DVec3); 2], pixel: DVec2, depth: f64) -> f64 {
    let at = |(o, d): (DVec3, DVec3)| o.truncate() + d.truncate() * ((2.0 * depth - o.z) / d.z);
    let mean = (at(rays[0]) + at(rays[1])) / 2.0;
    (mean - pixel).length() * f64::from(RESOLUTION[1]) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From a point of the lens to where the ray through its middle meets the plane of focus.
    #[test]
    fn the_truth_of_the_lens_is_that_of_the_book() {
        let (slope, lens) = (DVec2::new(0.4, -0.3), DVec2::new(0.6, 0.1));
        for focal_distance in [0.25, 4.0] {
            let d = (slope * focal_distance - lens).extend(focal_distance);
            let truth = refracted(slope.to_array().map(TwoFloat::from), lens.to_array(), focal_distance);
            assert!(angle(d, truth) < 1e-15);
        }
    }

    #[test]
    fn errors_are_those_of_known_rays() {
        // Ten from the lens, a direction that is off by 1e-3 misses by 0.01: a fifth of the radius of 0.05.
        let focus = CameraAxes::CAMERA_SPACE.world(0.0.into(), 0.0.into(), 10.0.into());
        assert!((blur(focus, DVec3::ZERO, DVec3::new(1e-3, 0.0, 1.0)) - 0.2).abs() < 1e-6);
        // A view that widens with depth is off by the distance from its middle at twice the focal distance.
        let (pixel, lens) = (DVec2::new(0.5, 0.25), DVec2::new(0.03, 0.01));
        let rays = [lens, -lens].map(|lens| (lens.extend(0.0), (pixel - lens).extend(2.0)));
        assert!((off_center(rays, pixel, 2.0) - pixel.length() * 240.0).abs() < 1e-9);
        assert!(off_center(rays, pixel, 1.0) < 1e-9);
    }
}
