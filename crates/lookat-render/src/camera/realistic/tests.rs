use std::sync::Arc;

use fearless_simd::f64x8;
use glam::{DVec2, DVec3};
use lookat_scene::{Camera, Film, Lens, LensElement, MILLIMETER, Projection, ThickLens, Transform};

use super::*;
use crate::camera::{CameraRays, Focus};
use crate::number::baseline;
use crate::testing::noise;

/// Radius, distance, index and opening of each surface in millimeters, as in `pbrt-scenes/cameras/double-gauss.dat`.
const DOUBLE_GAUSS: [[f64; 4]; 11] = [
    [29.475, 3.76, 1.67, 25.2],
    [84.83, 0.12, 1.0, 25.2],
    [19.275, 4.025, 1.67, 23.0],
    [40.77, 3.275, 1.699, 23.0],
    [12.75, 5.705, 1.0, 18.0],
    [0.0, 4.5, 1.0, 17.1],
    [-14.495, 1.18, 1.603, 17.0],
    [40.77, 6.065, 1.658, 20.0],
    [-20.385, 0.19, 1.0, 20.0],
    [437.065, 3.22, 1.717, 20.0],
    [-39.73, 0.0, 1.0, 20.0],
];
/// A thick lens with the stop behind it.
const SINGLE: [[f64; 4]; 3] = [[80.0, 9.0, 1.5, 40.0], [-120.0, 10.0, 1.0, 40.0], [0.0, 0.0, 1.0, 6.0]];

const CORNER: f64 = 0.02165;

fn lenses(rows: &[[f64; 4]], stop: f64, weighting: Weighting) -> LensSystem {
    let element = |row: &[f64; 4]| {
        let [radius, distance, eta, opening] = *row;
        LensElement {
            curvature_radius: radius * MILLIMETER,
            thickness: distance * MILLIMETER,
            eta,
            aperture_radius: if radius == 0.0 { stop } else { opening } * MILLIMETER / 2.0,
        }
    };
    LensSystem { elements: rows.iter().map(element).collect(), weighting }
}

fn double_gauss(stop: f64) -> LensSystem {
    lenses(&DOUBLE_GAUSS, stop, Weighting::Simple)
}

/// Origin, direction and weight of a ray from a place of the film.
fn ray(lens: &RealisticLens, film: DVec2, u: DVec2) -> (DVec3, DVec3, f64) {
    baseline!(simd => {
        let [film, u] = [film, u].map(|at| at.to_array().map(|x| x.simd_into(simd)));
        let rays = lens.rays(simd, film, u);
        (rays.o.lane(0), rays.d.lane(0), rays.weights[0])
    })
}

/// Whether a ray from the film to the rear plane gets through.
fn passes(lens: &RealisticLens, film: DVec2, rear: DVec2) -> bool {
    baseline!(simd => {
        let number = |x: f64| -> f64x8<_> { x.simd_into(simd) };
        let o = V3 { x: number(film.x), y: number(film.y), z: number(0.0) };
        let d = V3 { x: number(rear.x - film.x), y: number(rear.y - film.y), z: number(lens.surfaces.rear) };
        lens.surfaces.trace(simd, o, d.normalize()).clearance[0] >= 0.0
    })
}

/// The mean of the weights at a place of the film: a white sky.
fn white(lens: &RealisticLens, film: DVec2) -> f64 {
    const SIDE: usize = 512;
    let share = |i: usize| (i as f64 + 0.5) / SIDE as f64;
    let mut sum = 0.0;
    baseline!(simd => {
        let film = film.to_array().map(|x| -> f64x8<_> { x.simd_into(simd) });
        for i in 0..SIDE {
            for j in (0..SIDE).step_by(8) {
                let v: [f64; 8] = std::array::from_fn(|lane| share(j + lane));
                let rays = lens.rays(simd, film, [share(i).simd_into(simd), v.simd_into(simd)]);
                for lane in 0..8 {
                    sum += rays.weights[lane];
                }
            }
        }
    });
    sum / (SIDE * SIDE) as f64
}

/// 1/f = (n - 1) (1/R1 - 1/R2 + (n - 1) t / (n R1 R2)), and where the principal planes are.
#[test]
fn a_thick_lens_has_the_focal_length_of_the_lens_makers_equation() {
    for [r1, r2, t, n] in [[80.0, -120.0, 9.0, 1.5], [50.0, 300.0, 20.0, 1.7], [1e9, -35.0, 3.0, 1.6]] {
        let rows = [[r1, t, n, 10.0], [r2, 0.0, 1.0, 10.0]];
        let ThickLens { focal_length, rear_plane, front_plane } =
            lenses(&rows, 1.0, Weighting::Simple).thick_lens().unwrap();
        let power = (n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * t / (n * r1 * r2));
        let f = MILLIMETER / power;
        // Toward the film, from the front and from the rear vertex.
        let (h1, h2) = (-f * (n - 1.0) * t / (n * r2), -f * (n - 1.0) * t / (n * r1));
        assert!((focal_length / f - 1.0).abs() < 1e-12, "{focal_length} {f}");
        assert!((front_plane - (t * MILLIMETER - h1)).abs() < 1e-12 * (1.0 + h1.abs()), "{front_plane}");
        assert!((rear_plane + h2).abs() < 1e-12 * (1.0 + h2.abs()), "{rear_plane} {h2}");
    }
    let one = lenses(&[[-80.0, 9.0, 1.5, 40.0], [120.0, 0.0, 1.0, 40.0]], 1.0, Weighting::Simple);
    assert_eq!((one.thick_lens(), one.film_distance(1.0)), (None, None));
}

/// Rays obey Snell's law at each surface, in the plane of the normal, and stay on the surfaces.
#[test]
fn every_surface_refracts_by_snells_law() {
    let lenses = double_gauss(17.1);
    let lens = RealisticLens::new(&lenses, 2.0, CORNER);
    let mut checked = 0;
    for i in 0..200 {
        let film = DVec2::new(noise(i, 1.3), noise(i, 2.7)) * CORNER / 2.0_f64.sqrt();
        let aim = DVec2::new(noise(i, 3.9), noise(i, 5.1)) * 0.012;
        let start = (aim - film).extend(lens.surfaces.rear).normalize();
        let mut met = vec![(film.extend(0.0), start)];
        let clearance = baseline!(simd => {
            let traced = Traced { o: V3::splat(simd, met[0].0), d: V3::splat(simd, start), clearance: 1.0.simd_into(simd) };
            lens.surfaces.trace_along(simd, traced, |rays| met.push((rays.o.lane(0), rays.d.lane(0)))).clearance[0]
        });
        if clearance < 0.0 {
            continue;
        }
        checked += 1;
        for ((surface, element), step) in
            lens.surfaces.surfaces.iter().zip(lenses.elements.iter().rev()).zip(met.windows(2))
        {
            let [(from, before), (p, after)] = step[..] else { unreachable!() };
            assert!((p - from).normalize().dot(before) > 1.0 - 1e-12);
            if element.is_stop() {
                assert!((after - before).length() < 1e-12 && (p.z - surface.z).abs() < 1e-15);
                continue;
            }
            let center = DVec3::new(0.0, 0.0, surface.z - element.curvature_radius);
            let radius = element.curvature_radius.abs();
            assert!(((p - center).length() / radius - 1.0).abs() < 1e-12);
            let n = (p - center) / radius;
            // The sines with their planes: n1 (n x d1) = n2 (n x d2).
            let difference = n.cross(before) * surface.eta - n.cross(after);
            assert!(difference.length() < 1e-12 && (after.length() - 1.0).abs() < 1e-12, "{difference}");
            assert!(after.z > 0.0 && p.truncate().length() <= element.aperture_radius);
        }
    }
    assert!(checked > 50, "{checked}");
}

/// Rays near the axis from the middle of the film meet at the distance in focus.
#[test]
fn what_is_at_the_focus_distance_is_sharp() {
    for rows in [&DOUBLE_GAUSS[..], &SINGLE] {
        for focus in [0.5, 2.0, 50.0] {
            let lens = RealisticLens::new(&lenses(rows, 0.1, Weighting::Simple), focus, CORNER);
            let mut seen = 0;
            for i in 0..64 {
                let u = DVec2::new(0.5 + 0.5 * noise(i, 1.1), 0.5 + 0.5 * noise(i, 7.3));
                let (o, d, weight) = ray(&lens, DVec2::ZERO, u);
                if weight > 0.0 {
                    let off = (o + d * ((focus - o.z) / d.z)).truncate().length();
                    let unfocused = (o + d * ((0.5 * focus - o.z) / d.z)).truncate().length();
                    assert!(off < 2e-3 * unfocused + 1e-9, "{focus} {off} {unfocused}");
                    seen += 1;
                }
            }
            assert!(seen > 32);
        }
    }
    let lenses = double_gauss(5.0);
    let nearest = lenses.nearest_focus().unwrap();
    assert!(
        lenses.film_distance(nearest * 1.0001).is_some() && lenses.film_distance(nearest * 0.9999).is_none()
    );
    // At infinity, the film is in the focal plane.
    let thick = lenses.thick_lens().unwrap();
    assert!((lenses.film_distance(1e12).unwrap() - (thick.focal_length - thick.rear_plane)).abs() < 1e-12);
}

/// No ray that gets through is outside of the ellipses between which is interpolated.
#[test]
fn the_exit_pupil_is_inside_of_its_bounds() {
    for (rows, stop) in [
        (&DOUBLE_GAUSS[..], 17.1),
        (&DOUBLE_GAUSS, 6.0),
        (&DOUBLE_GAUSS, 0.05),
        (&SINGLE, 6.0),
        (&SINGLE, 40.0),
    ] {
        let lenses = lenses(rows, stop, Weighting::Simple);
        let lens = RealisticLens::new(&lenses, 1.0, 1.3 * CORNER);
        let (mut inside, mut through) = (0, 0);
        for i in 0..60_000 {
            let r = (0.5 + 0.5 * noise(i, 1.7)) * 1.3 * CORNER;
            let ellipse = lens.pupil.ellipse(r);
            // Up to a tenth beyond the edge, and everywhere.
            let wide = if i % 2 == 0 { 1.1 } else { 2.0 * lens.surfaces.rear_radius / ellipse.half_x };
            let at = DVec2::new(noise(i, 3.1), noise(i, 4.7)) * wide;
            let rear = DVec2::new(ellipse.center + at.x * ellipse.half_x, at.y * ellipse.half_y);
            if rear.abs().max_element() <= 1.5 * lens.surfaces.rear_radius
                && passes(&lens, DVec2::new(r, 0.0), rear)
            {
                through += 1;
                inside += usize::from(at.length() <= 1.0);
            }
        }
        assert!(through > 500 && inside == through, "{stop}: {inside} of {through}");
    }
}

/// A stop behind the lens is the exit pupil, so the exposure is its area times cos^4 over its squared distance.
#[test]
fn exposure_falls_off_with_the_fourth_power_of_the_cosine() {
    let lenses = lenses(&SINGLE, 3.0, Weighting::Exposure { time: 0.5 });
    let lens = RealisticLens::new(&lenses, 1.5, CORNER);
    let rear = lens.surfaces.rear;
    let at_axis = 0.5 * std::f64::consts::PI * (1.5 * MILLIMETER / rear).powi(2);
    for share in [0.0, 0.2, 0.45, 0.7, 1.0] {
        let film = DVec2::new(0.6, -0.8) * share * CORNER;
        let cos2 = rear * rear / (rear * rear + film.length_squared());
        let found = white(&lens, film) / (at_axis * cos2 * cos2);
        assert!((found - 1.0).abs() < 2e-3, "{share}: {found}");
    }
}

/// Brightness has no steps where pbrt-v3 has its rings, and is the integral over the pupil at any place.
#[test]
fn a_white_sky_is_smooth_from_the_middle_to_the_corners() {
    let lens = RealisticLens::new(&double_gauss(17.1), 2.0, CORNER);
    let at = |r: f64| white(&lens, DVec2::new(r, 0.0));
    let radii: Vec<f64> = (0..=72).map(|i| f64::from(i) / 72.0 * CORNER).collect();
    let values: Vec<f64> = radii.iter().map(|r| at(*r)).collect();
    for (r, value) in radii.windows(4).zip(values.windows(4)) {
        // The third difference of what is smooth is tiny. Edges of surfaces bend it, and the sum of samples is good to a thousandth.
        let third = value[3] - 3.0 * value[2] + 3.0 * value[1] - value[0];
        assert!(third.abs() < 4e-3 * values[0], "{r:?}: {third}");
    }
    // The same from a grid over the whole rear plane.
    for r in [0.0, 0.31 * CORNER, 0.77 * CORNER] {
        let (side, reach) = (800_i32, 1.5 * lens.surfaces.rear_radius);
        let step = 2.0 * reach / f64::from(side);
        let place = |i: i32| (f64::from(i) + 0.5) * step - reach;
        let film = DVec2::new(r, 0.0);
        let mut sum = 0.0;
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let rear = DVec2::new(place(i), place(j));
            if passes(&lens, film, rear) {
                let cos2 = lens.surfaces.rear.powi(2)
                    / (lens.surfaces.rear.powi(2) + (rear - film).length_squared());
                sum += cos2 * cos2;
            }
        }
        let whole = sum * step * step * lens.weight;
        assert!((at(r) / whole - 1.0).abs() < 3e-3, "{r}: {} {whole}", at(r));
    }
}

/// The ellipses are not much larger than the pupil: most rays get through.
#[test]
fn few_rays_are_blocked_where_the_pupil_is_round() {
    for stop in [17.1, 6.0, 0.05] {
        let lens = RealisticLens::new(&double_gauss(stop), 2.0, CORNER);
        let through = |film: DVec2| {
            let u = |i, k| 0.5 + 0.5 * noise(i, k);
            (0..1000).filter(|i| ray(&lens, film, DVec2::new(u(*i, 1.3), u(*i, 4.1))).2 > 0.0).count()
        };
        let counts = [through(DVec2::ZERO), through(DVec2::new(0.2, 0.1) * CORNER)];
        assert!(counts.iter().all(|count| *count > 800), "{stop}: {counts:?}");
    }
}

/// Rays from the edges of the pupil through the middle of the film, where they meet a plane, and how many pixels that is.
#[test]
fn blur_is_the_spread_of_rays_near_the_axis() {
    let film = Film::new([300, 200]);
    for (rows, focus_distance) in [(&DOUBLE_GAUSS[..], 2.0), (&DOUBLE_GAUSS, 0.7), (&SINGLE, 1.0)] {
        let lenses = lenses(rows, 2.0, Weighting::Simple);
        let lens = Lens { radius: lenses.entrance_pupil().radius, focal_distance: focus_distance };
        let projection = Projection::Realistic(Arc::new(lenses));
        let camera = Camera { lens: Some(lens), ..Camera::new(Transform::IDENTITY, projection, &film) };
        let focus = Focus::new(&camera, &film).unwrap();
        let rays = CameraRays::new(&camera, &film, DVec3::ZERO);
        for depth in [0.4, 0.6, 3.0, 50.0] {
            let at = |film: f64, u: f64| {
                let (film, u) = (DVec2::new(film, 100.0), DVec2::new(u, 0.5));
                let ray = rays.ray(film, u);
                let x = ray.at((depth - ray.o.z) / ray.d.z).x;
                let weight = baseline!(simd => {
                    let [film, u] = [film, u].map(|at| at.to_array().map(|x| x.simd_into(simd)));
                    rays.weighted_rays(simd, film, Some(u), 0.0.simd_into(simd)).1.unwrap()[0]
                });
                (x, weight > 0.0)
            };
            // The outermost rays that get through.
            let through = (0..=4000).map(|i| at(150.0, f64::from(i) / 4000.0)).filter(|(_, passes)| *passes);
            let places: Vec<f64> = through.map(|(x, _)| x).collect();
            let most = |of: fn(f64, f64) -> f64| places.iter().copied().reduce(of).unwrap();
            let (spread, pixel) = (most(f64::max) - most(f64::min), at(151.0, 0.5).0 - at(150.0, 0.5).0);
            let (blur, found) = (focus.blur(depth), spread / pixel);
            assert!((blur - found).abs() < 0.01 * blur + 0.02, "{focus_distance} {depth}: {blur} {found}");
        }
        for depth in focus.sharp().into_iter().filter(|depth| depth.is_finite()) {
            assert!((focus.blur(depth) - 1.0).abs() < 1e-9, "{depth}");
        }
        // Focused there, infinity is blurred by a pixel.
        let hyperfocal = focus.hyperfocal().unwrap();
        let lens = Lens { focal_distance: hyperfocal, ..lens };
        let far = Focus::new(&Camera { lens: Some(lens), ..camera.clone() }, &film).unwrap();
        assert!((far.blur(1e15) - 1.0).abs() < 1e-6, "{}", far.blur(1e15));
    }
}
