//! Lenses: C5, C10, C12 and C13.

use glam::{DVec2, DVec3};
use lookat_render::Probe;
use lookat_scene::Scene;
use twofloat::TwoFloat;

use super::exact::{Pinhole, View, angle, length, tan_half};
use super::messages::{Trouble, expect};
use super::perspective::far_look_at;
use super::{anywhere, case, film, look_at, square, text};
use crate::stability::case::{Axis, Case, Effort, Found, LOOKAT};
use crate::stability::methods::{Vector, camera as by, double, single};
use crate::stability::tally::{Tally, tally};
use crate::stability::truth::Wide;
use crate::stability::truth::quotient;
use crate::text_scene::scene;

pub(super) fn cases() -> Vec<Case> {
    vec![
        Case {
            axis: Axis::Of("distance of the eye from the origin"),
            error: "blur in the plane of focus, in lens radii",
            limit: 1e-6,
            ..case(
                "C5",
                "lens-collapse",
                "all rays of a lens meet in the focus, at any place of the camera",
                collapse,
            )
        },
        Case {
            axis: Axis::Of("focal distance"),
            error: "direction, rad",
            limit: 1e-15,
            ..case("C10", "focal-distance", "a lens can be focused at any distance", focal_distance)
        },
        Case {
            axis: Axis::Of("lens radius"),
            error: "direction, rad",
            limit: 1e-15,
            ..case(
                "C12",
                "lens-radius",
                "a lens can have any radius; a negative one gives a warning",
                lens_radius,
            )
        },
        Case {
            axis: Axis::Of("depth / focal distance"),
            error: "mean place of a pixel's rays, pixels",
            limit: 1e-9,
            ..case(
                "C13",
                "telecentric",
                "a lens does not change the width of an orthographic view at any depth",
                telecentric,
            )
        },
    ]
}

const RESOLUTION: [u32; 2] = [640, 480];

fn collapse(effort: &Effort) -> Found {
    const METHODS: [&str; 3] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64"];
    let mut found = Found::default();
    for exponent in 3..9 {
        let distance = 10_f64.powi(exponent);
        let points @ [eye, look, up] = far_look_at(distance);
        let camera =
            "Camera \"perspective\" \"float fov\" 45 \"float lensradius\" .05 \"float focaldistance\" 10";
        let scene = scene(&text(&format!("{}\n{camera}\n{}", look_at(points), film(RESOLUTION))));
        let probe = Probe::new(&scene);
        let view = View::new(eye, look, up).expect("this view has a side");
        let exact = Pinhole { view, tan: tan_half(45.0), resolution: RESOLUTION };
        let wide = by::look_at(eye.to_array(), look.to_array(), up.to_array()).expect("this view has a side");
        let narrow = by::look_at(single(eye), single(look), single(up));
        let tallies = tally(effort.rays, 5000 + exponent as u64, |random, tallies: &mut [Tally; 3]| {
            let film = anywhere(random, RESOLUTION);
            let ray = probe.camera_ray(film, square(random));
            let [x, y] = exact.slope(film).map(|slope| slope * 10.0);
            let focus = view.world(x, y, TwoFloat::from(10.0));
            tallies[0].error(blur(focus, ray.o, ray.d));
            // The same point of the lens for the others.
            let axes = [view.right, view.up].map(|axis| f64::from(Wide::new(ray.o).dot(axis)));
            let slope = exact.slope(film).map(f64::from);
            let d = by::normalize([slope[0], slope[1], 1.0]);
            tallies[2].error(world_blur(&wide, d, axes));
            let error = narrow.map(|world| world_blur(&world, d.map(|x| x as f32), axes.map(|x| x as f32)));
            tallies[1].error(error.unwrap_or(f64::NAN));
        });
        found.add(Some(distance), &METHODS, &tallies);
    }
    found
}

/// How far from a point a ray passes, in radii of the lens.
fn blur(focus: Wide, o: DVec3, d: DVec3) -> f64 {
    let d = Wide::new(d);
    f64::from(quotient(length(focus.minus(Wide::new(o)).cross(d)), length(d))) / 0.05
}

/// The blur of a ray that leaves the lens in world space, around the point where the camera that these numbers mean has
/// its focus: where that camera looks is another question.
fn world_blur<T: num_traits::Float>(world: &by::Matrix<T>, d: Vector<T>, lens: [T; 2]) -> f64 {
    let precise = |x: T| x.to_f64().expect("a float is a float");
    let ten = T::from(10.0).expect("every precision holds 10");
    let o = by::point(world, [lens[0], lens[1], T::zero()]).map(precise);
    let through = by::vector(world, by::thin_lens(d, lens, ten)).map(precise);
    let d = d.map(precise);
    let at = d.map(|x| TwoFloat::from(x) * 10.0 / d[2]);
    let row = |i: usize| {
        let m = world[i].map(precise);
        at[0] * m[0] + at[1] * m[1] + at[2] * m[2] + m[3]
    };
    let focus = Wide([row(0), row(1), row(2)]);
    let relative = focus.minus(Wide::new(o.into()));
    blur(relative, DVec3::ZERO, through.into())
}

fn focal_distance(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in [-30, -12, -3, 0, 3, 12, 19, 20, 30, 300] {
        let focal_distance = 10_f64.powi(exponent);
        let seed = 10_000 + exponent.unsigned_abs() as u64 * 2 + u64::from(exponent < 0);
        lens_rows(&mut found, effort.rays, seed, focal_distance, [1.0, focal_distance]);
    }
    found
}

fn lens_radius(effort: &Effort) -> Found {
    let mut found = Found::default();
    expect(
        &mut found,
        &Trouble::warning("Camera \"perspective\" \"float lensradius\" -1", "lensradius", "-1"),
    );
    let scene = scene(&lens_text(-1.0, 10.0));
    let probe = Probe::new(&scene);
    let o = probe.camera_ray(DVec2::new(3.0, 5.0), DVec2::new(0.9, 0.1)).o;
    found.check(o == DVec3::ZERO, || format!("a lens of radius -1 is no pinhole: its ray starts at {o}"));
    for (seed, radius) in (12_000..).zip([1e-6, 1.0, 1e6]) {
        lens_rows(&mut found, effort.rays, seed, radius, [radius, 10.0]);
    }
    found
}

fn lens_text(radius: f64, focal_distance: f64) -> String {
    text(&format!(
        "Camera \"perspective\" \"float lensradius\" {radius} \"float focaldistance\" {focal_distance}\n{}",
        film(RESOLUTION)
    ))
}

/// Directions from points of the lens, given the points: a lens in camera space.
fn lens_rows(found: &mut Found, rays: u64, seed: u64, at: f64, [radius, focal_distance]: [f64; 2]) {
    const METHODS: [&str; 5] = [LOOKAT, "pbrt-v3", "pbrt-v3 in f64", "scaled f32", "scaled f64"];
    let scene: Scene = scene(&lens_text(radius, focal_distance));
    let probe = Probe::new(&scene);
    let exact = Pinhole { view: View::CAMERA_SPACE, tan: tan_half(90.0), resolution: RESOLUTION };
    let tallies = tally(rays, seed, |random, tallies: &mut [Tally; 5]| {
        let film = anywhere(random, RESOLUTION);
        let ray = probe.camera_ray(film, square(random));
        let [x, y] = exact.slope(film);
        let truth = refracted([x, y, TwoFloat::from(1.0)], [ray.o.x, ray.o.y], focal_distance);
        // It must be on the lens, too.
        let is_on_lens = ray.o.z == 0.0 && ray.o.length() <= radius * (1.0 + 1e-15);
        tallies[0].error(if is_on_lens { angle(ray.d, truth) } else { f64::NAN });
        let (d, lens) = (by::normalize([f64::from(x), f64::from(y), 1.0]), [ray.o.x, ray.o.y]);
        let truth = refracted(d.map(TwoFloat::from), lens, focal_distance);
        tallies[2].error(angle(by::thin_lens(d, lens, focal_distance).into(), truth));
        tallies[4].error(angle(by::scaled_lens(d, lens, focal_distance).into(), truth));
        // The truth for what single precision holds, except that 1e300 becomes infinite.
        let (d, lens) = (d.map(|x| x as f32), lens.map(|x| x as f32));
        let rounded = focal_distance as f32;
        let at = if rounded.is_finite() { f64::from(rounded) } else { focal_distance };
        let truth = refracted(d.map(|x| f64::from(x).into()), lens.map(f64::from), at);
        tallies[1].error(angle(double(by::thin_lens(d, lens, rounded)), truth));
        tallies[3].error(angle(double(by::scaled_lens(d, lens, rounded)), truth));
    });
    found.add(Some(at), &METHODS, &tallies);
}

/// Where a ray through the middle of a lens goes from a point of the lens.
fn refracted(d: [TwoFloat; 3], lens: [f64; 2], focal_distance: f64) -> Wide {
    let one = TwoFloat::from(1.0);
    let [x, y] = [quotient(d[0], d[2]), quotient(d[1], d[2])];
    if focal_distance < 1.0 {
        return Wide([x * focal_distance - lens[0], y * focal_distance - lens[1], one * focal_distance]);
    }
    // Beyond this the lens is a point, to 40 digits.
    let scale = if focal_distance > 1e50 { TwoFloat::from(0.0) } else { one / focal_distance };
    Wide([x - scale * lens[0], y - scale * lens[1], one])
}

fn telecentric(effort: &Effort) -> Found {
    const METHODS: [&str; 3] = [LOOKAT, "pbrt-v3", "telecentric f32"];
    let camera = "Camera \"orthographic\" \"float focaldistance\" 2 \"float lensradius\" .1";
    let mut found = Found::default();
    // Without the parameter it is as in pbrt-v3, which nobody can want.
    expect(&mut found, &Trouble::warning(camera, "perspective view in pbrt-v3", ".1"));
    let scene = scene(&text(&format!("{camera} \"bool telecentric\" \"true\"\n{}", film(RESOLUTION))));
    let probe = Probe::new(&scene);
    for (seed, depth) in (13_000..).zip([0.1, 0.5, 1.0, 2.0, 10.0, 100.0]) {
        let tallies = tally(effort.rays, seed, |random, tallies: &mut [Tally; 3]| {
            let film = anywhere(random, RESOLUTION);
            let pixel = on_window(film);
            // Points of the lens that lie opposite.
            let u = square(random);
            let rays = [u, DVec2::ONE - u].map(|u| probe.camera_ray(film, u));
            let eye = probe.origin();
            tallies[0].error(off_center(rays.map(|ray| (ray.o + eye, ray.d)), pixel, depth));
            let lens = [rays[0], rays[1]].map(|ray| (ray.o + eye).truncate() - pixel);
            tallies[1].error(off_center(lens.map(|lens| single_ray(DVec2::ZERO, pixel, lens)), pixel, depth));
            tallies[2].error(off_center(lens.map(|lens| single_ray(pixel, pixel, lens)), pixel, depth));
        });
        found.add(Some(depth), &METHODS, &tallies);
    }
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

/// A ray from the lens around `center` to where the pixel is in focus: around 0 it is pbrt's (PBR 6.2.3), in single
/// precision.
fn single_ray(center: DVec2, pixel: DVec2, lens: DVec2) -> (DVec3, DVec3) {
    let o = (center.as_vec2() + lens.as_vec2()).extend(0.0);
    let d = (pixel.as_vec2().extend(2.0) - o).normalize();
    (o.as_dvec3(), d.as_dvec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_of_the_lens_is_that_of_the_book() {
        let d = by::normalize([0.4, -0.3, 1.0]);
        for focal_distance in [0.25, 4.0] {
            let truth = refracted(d.map(TwoFloat::from), [0.6, 0.1], focal_distance);
            assert!(angle(by::thin_lens(d, [0.6, 0.1], focal_distance).into(), truth) < 1e-15);
        }
    }

    #[test]
    fn a_camera_near_the_origin_is_sharp_in_any_precision() {
        let world = by::look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]).unwrap();
        let d = by::normalize([0.1, 0.2, 1.0]);
        assert!(world_blur(&world, d, [0.03, -0.04]) < 1e-13);
        let world = by::look_at([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]).unwrap();
        assert!(world_blur(&world, by::normalize([0.1_f32, 0.2, 1.0]), [0.03, -0.04]) < 1e-4);
        // Ten from the lens, a direction that is off by 1e-3 misses by 0.01: a fifth of the radius of 0.05.
        let focus = View::CAMERA_SPACE.world(0.0.into(), 0.0.into(), 10.0.into());
        assert!((blur(focus, DVec3::ZERO, DVec3::new(1e-3, 0.0, 1.0)) - 0.2).abs() < 1e-6);
    }

    #[test]
    fn pbrt_widens_the_view_with_its_depth() {
        let (pixel, lens) = (DVec2::new(0.5, 0.25), DVec2::new(0.03, 0.01));
        let rays = |center| [lens, -lens].map(|lens| single_ray(center, pixel, lens));
        // At twice the depth the place is doubled: off by as much as it is from the middle.
        let off = pixel.length() * 240.0;
        assert!((off_center(rays(DVec2::ZERO), pixel, 2.0) - off).abs() < 1e-3);
        assert!(off_center(rays(DVec2::ZERO), pixel, 1.0) < 1e-3);
        assert!(off_center(rays(pixel), pixel, 2.0) < 1e-3);
    }
}
