//! Rays that leave what they have hit: V5.

use glam::DVec3;
use lookat_render::{Probe, Ray};
use rand_pcg::Pcg64Mcg;

use crate::stability::case::{Effort, Found, LOOKAT};
use crate::stability::methods::offset::{self, Body, HitPoint, normal};
use crate::stability::methods::{double, single};
use crate::stability::random::{between, chance, direction, in_cube, leaving};
use crate::stability::tally::{Tally, tally};
use crate::text_scene::scene;

mod bodies;

/// 2^-40 of the largest coordinate that the point was computed with. That is the corner of a box or triangle, up to twice the
/// size away from the point, and turning an instance takes the sum over three axes: 8 covers both.
pub(super) const LIMIT: f64 = 8.0 / (1_u64 << 40) as f64;

const METHODS: [&str; 5] =
    ["no offset f64", "fixed 1e-4 f32", "pbrt-v3 f32", "Wächter and Binder f32", "Mitsuba f32"];

pub(super) fn by_size(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in -6..=8 {
        let size = 10_f64.powi(exponent);
        let seed = (2500 + 10 * (exponent + 6)) as u64;
        add(&mut found, effort, seed, size, Place { size, distance: 0.0 });
    }
    found
}

pub(super) fn by_distance(effort: &Effort) -> Found {
    let mut found = Found::default();
    for exponent in 0..=5 {
        let distance = 10_f64.powi(exponent);
        add(&mut found, effort, (2700 + 10 * exponent) as u64, distance, Place { size: 1.0, distance });
    }
    found
}

/// How large a body is, and where, in sizes from the origin of the world.
#[derive(Clone, Copy)]
struct Place {
    size: f64,
    distance: f64,
}

fn add(found: &mut Found, effort: &Effort, seed: u64, at: f64, place: Place) {
    let own = bodies::ALL.iter().zip(seed..).map(|(body, seed)| lookat(effort, seed, body, place));
    let own = own.reduce(Tally::join).unwrap_or_default();
    found.add(Some(at), &[LOOKAT], &[own]);
    let others =
        tally(effort.rays, seed + 9, |random, tallies: &mut [Tally; 5]| formulas(random, place, tallies));
    found.add(Some(at), &METHODS, &others);
}

/// The renderer: half of the rays with the eye near the body, half with the eye at the origin of the world, or as far.
fn lookat(effort: &Effort, seed: u64, body: &bodies::Convex, place: Place) -> Tally {
    let Place { size, distance } = place;
    let center = DVec3::new(0.6, -0.5, 0.62).normalize() * distance * size;
    let far = if distance == 0.0 { DVec3::new(-3e3, 2e3, 5e3) * size } else { DVec3::ZERO };
    let rays = effort.rays.div_ceil(2 * bodies::ALL.len() as u64);
    let eyes = [center + DVec3::new(3.0, -2.0, 4.0) * size, far];
    eyes.into_iter()
        .zip([seed << 1, seed << 1 | 1])
        .map(|(eye, seed)| {
            let scene = scene(&body.text(eye, center, size));
            let probe = Probe::new(&scene);
            let [tally] = tally(rays, seed, |random, [tally]| {
                tally_one(random, &probe, center - probe.origin(), size, body.is_ball, tally);
            });
            tally
        })
        .reduce(Tally::join)
        .unwrap_or_default()
}

/// Hits the body, leaves it, and looks what is met.
fn tally_one(
    random: &mut Pcg64Mcg,
    probe: &Probe,
    center: DVec3,
    size: f64,
    is_ball: bool,
    tally: &mut Tally,
) {
    let start = center + direction(random) * size * between(random, 2.0, 10.0);
    let target = center + in_cube(random) * 0.5 * size;
    let ray = Ray::new(start, (target - start).normalize());
    let Some(hit) = probe.nearest(&ray) else { return };
    let point = probe.point(&ray, &hit);
    let n = if point.n.dot(point.p - center) > 0.0 { point.n } else { -point.n };
    let outward = chance(random, 0.5);
    let d = if outward { leaving(random, n, [-6.0, -3.0]) } else { -leaving(random, n, [-3.0, 0.0]) };
    let ray = probe.leave(&ray, &hit, d);
    let met = probe.nearest(&ray);
    let right = match met {
        None => outward,
        // The far side of a ball is known; another body is left through a face that looks along the ray.
        Some(met) if is_ball => !outward && met.t > 0.5 * chord(d, n, size),
        Some(met) => {
            let exit = probe.point(&ray, &met);
            !outward && exit.n.dot(exit.p - center) * exit.n.dot(d) > 0.0
        }
    };
    if right && probe.occluded(&ray) == met.is_some() {
        tally.error((ray.o - point.p).length() / point.p.abs().max_element().max(size));
    } else {
        tally.answer(false);
    }
}

/// How long a ray stays in a ball.
fn chord(d: DVec3, n: DVec3, radius: f64) -> f64 {
    2.0 * radius * d.dot(n).abs()
}

/// The other formulas, on a triangle or a sphere in single precision: a self-hit is a failure.
fn formulas(random: &mut Pcg64Mcg, place: Place, tallies: &mut [Tally; 5]) {
    let Place { size, distance } = place;
    let center = direction(random) * distance * size;
    let body = random_body(random, center, size);
    let start = single(center + direction(random) * 5.0 * size);
    let target = center + in_cube(random) * 0.3 * size;
    let d = single((target - double(start)).normalize());
    let Some((hit, p, n)) = hit_both(&body, start, d) else { return };
    let d = single(leaving(random, n, [-6.0, -3.0]));
    // Rounding may have turned a grazing direction to the other side.
    if double(d).dot(n) < 1e-7 {
        return;
    }
    let again = widened(&body).distance(p.to_array(), double(d).to_array(), 0.0).is_some();
    count(&mut tallies[0], again, 0.0);
    count(&mut tallies[1], body.distance(hit.p, d, 1e-4).is_some(), 1e-4 / size);
    let moved = origins(&hit, n);
    let size = double(hit.p).abs().max_element().max(size);
    for (tally, o) in tallies[2..].iter_mut().zip(moved) {
        count(tally, body.distance(o, d, 0.0).is_some(), (double(o) - double(hit.p)).length() / size);
    }
}

fn count(tally: &mut Tally, hits_itself: bool, offset: f64) {
    if hits_itself { tally.answer(false) } else { tally.error(offset) }
}

/// Origins after pbrt-v3, Wächter and Binder, and Mitsuba.
pub(super) fn origins(hit: &HitPoint<f32>, n: DVec3) -> [[f32; 3]; 3] {
    let n = single(n);
    [offset::pbrt_v3(hit.p, hit.error, n), offset::waechter_binder(hit.p, n), offset::mitsuba(hit.p, n)]
}

fn random_body(random: &mut Pcg64Mcg, center: DVec3, size: f64) -> Body<f32> {
    if chance(random, 0.5) {
        return Body::Sphere(single(center), size as f32);
    }
    Body::Triangle(std::array::from_fn(|_| single(center + direction(random) * size)))
}

/// Where a ray of single precision hits: in single precision, and the same in double; with the normal toward the ray.
fn hit_both(body: &Body<f32>, o: [f32; 3], d: [f32; 3]) -> Option<(HitPoint<f32>, DVec3, DVec3)> {
    let (hit, wide) = (body.hit(o, d)?, widened(body).hit(double(o).to_array(), double(d).to_array())?);
    let p = DVec3::from(wide.p);
    let n = match widened(body) {
        Body::Triangle(corners) => DVec3::from(normal(corners)),
        Body::Sphere(center, _) => (p - DVec3::from(center)).normalize(),
    };
    let n = if n.dot(double(d)) > 0.0 { -n } else { n };
    // Needles, and grazing incidence, are matters of other cases.
    (n.is_finite() && n.dot(double(d)) < -0.01).then_some((hit, p, n))
}

fn widened(body: &Body<f32>) -> Body<f64> {
    let wide = |v: [f32; 3]| v.map(f64::from);
    match *body {
        Body::Triangle(corners) => Body::Triangle(corners.map(wide)),
        Body::Sphere(center, radius) => Body::Sphere(wide(center), f64::from(radius)),
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    /// Far above the surface no formula meets it again.
    #[test]
    fn steep_rays_from_far_origins_miss() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut hits = 0;
        for _ in 0..1000 {
            let body = random_body(&mut random, DVec3::ZERO, 1.0);
            let start = single(direction(&mut random) * 5.0);
            let d = single((in_cube(&mut random) * 0.3 - double(start)).normalize());
            let Some((hit, p, n)) = hit_both(&body, start, d) else { continue };
            hits += 1;
            assert!((double(hit.p) - p).length() < 1e-4);
            assert_eq!(body.distance(single(p + n * 1e-3), single(n), 0.0), None);
            for o in origins(&hit, n) {
                let height = (double(o) - double(hit.p)).dot(n);
                assert!((1e-8..2e-4).contains(&height), "{height}");
            }
        }
        assert!(hits > 200, "{hits}");
    }

    #[test]
    fn bodies_are_convex_and_around_their_center() {
        for (number, body) in bodies::ALL.iter().enumerate() {
            let (eye, center) = (DVec3::new(1.0, 2.0, 30.0), DVec3::new(5.0, 6.0, 7.0));
            let scene = scene(&body.text(eye, center, 2.0));
            let probe = Probe::new(&scene);
            assert_eq!(probe.origin() + probe.eye(), eye);
            let mut random = Pcg64Mcg::seed_from_u64(4);
            for _ in 0..1000 {
                // From inside there is one way out, beyond it nothing.
                let o = center - probe.origin() + in_cube(&mut random) * 0.2;
                let ray = Ray::new(o, direction(&mut random));
                let hit = probe.nearest(&ray).expect("a closed body");
                let p = ray.at(hit.t * 1.000_001);
                assert!((0.5..2.1).contains(&(p + probe.origin() - center).length()), "{number}");
                assert!(probe.nearest(&Ray::new(p, ray.d)).is_none(), "{number}");
            }
        }
    }
}
