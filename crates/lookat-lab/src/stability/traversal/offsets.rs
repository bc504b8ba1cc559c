//! Rays that leave what they have hit: V5 and V6.

use crate::stability::prelude::*;

/// The limit is 8 times 2^-40 of the largest coordinate that the point was computed with. That is the corner of a box or
/// triangle, up to twice the size away from the point, and turning an instance takes the sum over three axes: 8 covers both.
pub(super) fn by_size(effort: &Effort) -> Found {
    Found::sweep(250, decades(-6..=8), |seed, size| bodies(effort, seed, size, 0.0))
}

pub(super) fn by_distance(effort: &Effort) -> Found {
    Found::sweep(270, decades(0..=5), |seed, distance| bodies(effort, seed, 1.0, distance))
}

/// All bodies of this size, so many sizes from the origin of the world.
fn bodies(effort: &Effort, seed: u64, size: f64, distance: f64) -> Tally {
    let center = DVec3::new(0.6, -0.5, 0.62).normalize() * distance * size;
    // The eye near the body, and at the origin of the world, or as far.
    let far = if distance == 0.0 { DVec3::new(-3e3, 2e3, 5e3) * size } else { DVec3::ZERO };
    let eyes = [center + DVec3::new(3.0, -2.0, 4.0) * size, far];
    let count = effort.rays.div_ceil(2 * BODIES.len() as u64);
    let each = BODIES.iter().flat_map(|body| eyes.map(|eye| (*body, eye)));
    let tallies = each.zip(20 * seed..).map(|((body, eye), seed)| {
        let probe = probe(&text(body, eye, center, size));
        tally(count, seed, |random, tally| {
            let offset = offset(random, &probe, center - probe.origin(), size, body == BALL);
            offset.into_iter().for_each(|offset| tally.error(offset));
        })
    });
    tallies.fold(Tally::default(), Tally::join)
}

const BALL: &str = "Shape \"sphere\"";

/// Convex closed bodies of about radius one: the unit sphere and others. Some are turned and stretched, some are instances.
const BODIES: [&str; 5] = [
    BALL,
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 Shape \"sphere\"",
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 ObjectInstance \"sphere\"",
    "#polyhedron",
    "Rotate 40 1 2 3 Scale 1 0.6 0.8 Rotate 70 3 1 -2 ObjectInstance \"polyhedron\"",
];

/// A scene of a body alone, under a camera at `eye`.
fn text(body: &str, eye: DVec3, center: DVec3, size: f64) -> String {
    let polyhedron = polyhedron();
    let objects =
        format!("ObjectBegin \"sphere\" {BALL} ObjectEnd ObjectBegin \"polyhedron\" {polyhedron} ObjectEnd");
    let body = body.replace("#polyhedron", &polyhedron);
    seen_from(eye, &format!("{objects} Translate {} Scale {size} {size} {size} {body}", xyz(center)))
}

/// An octahedron, each face of which is four: corners and middles of edges on the unit sphere.
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

/// Hits the body, leaves it, and looks what is met. `None` for a miss, no number where something wrong is met.
fn offset(random: &mut Pcg64Mcg, probe: &Probe, center: DVec3, size: f64, is_ball: bool) -> Option<f64> {
    let start = center + direction(random) * size * between(random, 2.0, 10.0);
    let target = center + in_cube(random) * 0.5 * size;
    let ray = Ray::new(start, (target - start).normalize());
    let hit = probe.nearest(&ray)?;
    let point = probe.point(&ray, &hit);
    let n = if point.n.dot(point.p - center) > 0.0 { point.n } else { -point.n };
    let outward = chance(random, 0.5);
    let d = if outward { leaving(random, n, [-6.0, -3.0]) } else { -leaving(random, n, [-3.0, 0.0]) };
    let ray = probe.leave(&ray, &hit, d);
    let met = probe.nearest(&ray);
    let chord = 2.0 * size * d.dot(n).abs();
    let right = match met {
        None => outward,
        // The far side of a ball is known; another body is left through a face that looks along the ray.
        Some(met) if is_ball => !outward && met.t > 0.5 * chord,
        Some(met) => {
            let exit = probe.point(&ray, &met);
            !outward && exit.n.dot(exit.p - center) * exit.n.dot(d) > 0.0
        }
    };
    let is_right = right && probe.occluded(&ray) == met.is_some();
    let offset = (ray.o - point.p).length() / point.p.abs().max_element().max(size);
    Some(if is_right { offset } else { f64::NAN })
}

/// Two parallel quads before the eye, one at a distance of 1, and two spheres around a point near the eye, which is inside.
pub(super) fn thin(effort: &Effort) -> Found {
    let frame = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    Found::sweep(2800, decades((3..=9).map(|exponent| -exponent)), |seed, gap| {
        let quad = |z: f64| quads(&square(frame.z_axis * z, frame.x_axis, frame.y_axis));
        let spheres = format!("Shape \"sphere\" Shape \"sphere\" \"float radius\" {}", 1.0 + gap);
        let worlds = [quad(1.0) + &quad(1.0 + gap), format!("Translate 0.2 -0.3 0.1 {spheres}")];
        let tallies = worlds.iter().zip([seed, seed + 10]).map(|(world, seed)| {
            let probe = probe(&around_eye(world));
            tally(effort.rays.div_ceil(2), seed, |random, tally| cross(random, &probe, frame, tally))
        });
        tallies.fold(Tally::default(), Tally::join)
    })
}

/// From the eye to the first surface, through it, and on: the second must be met.
fn cross(random: &mut Pcg64Mcg, probe: &Probe, frame: DMat3, tally: &mut Tally) {
    let toward = DVec3::new(between(random, -0.5, 0.5), between(random, -0.5, 0.5), 1.0);
    let ray = Ray::new(DVec3::ZERO, (frame * toward).normalize());
    let first = probe.nearest(&ray).filter(|hit| hit.element.primitive == 0);
    let Some(first) = first else { return tally.answer(false) };
    let n = probe.point(&ray, &first).n;
    let n = if n.dot(ray.d) < 0.0 { -n } else { n };
    let d = steep(random, n);
    let on = probe.leave(&ray, &first, d);
    let second = probe.nearest(&on);
    tally.answer(second.is_some_and(|hit| hit.element.primitive == 1) && probe.occluded(&on));
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

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn bodies_are_convex_and_around_their_center() {
        for body in BODIES {
            let (eye, center) = (DVec3::new(1.0, 2.0, 30.0), DVec3::new(5.0, 6.0, 7.0));
            let probe = probe(&text(body, eye, center, 2.0));
            assert_eq!(probe.origin() + probe.eye(), eye);
            let mut random = Pcg64Mcg::seed_from_u64(4);
            for _ in 0..1000 {
                // From inside there is one way out, beyond it nothing.
                let o = center - probe.origin() + in_cube(&mut random) * 0.2;
                let ray = Ray::new(o, direction(&mut random));
                let hit = probe.nearest(&ray).expect("a closed body");
                let p = ray.at(hit.t * 1.000_001);
                assert!((0.5..2.1).contains(&(p + probe.origin() - center).length()), "{body}");
                assert!(probe.nearest(&Ray::new(p, ray.d)).is_none(), "{body}");
            }
        }
    }
}
