//! Rays in the planes of boxes: V1.

use super::brute_force::disagreement;
use crate::stability::prelude::*;
use crate::text_scene::{corner, cube};

/// The corners of a box, which single precision holds.
type Box = [DVec3; 2];

/// What single shapes hit, the BVH of all must hit, and cubes must be hit by what passes through them.
pub(super) fn faces(effort: &Effort) -> Found {
    let (text, boxes) = blocks();
    let probe = probe(&text);
    let tally = tally(effort.rays, 2001, |random, tally| {
        let ray = in_plane(random, &boxes);
        // What passes through the middle of a cube must hit it.
        let pierced = || boxes.iter().skip(1).step_by(3).any(|cube| pierces(ray.o, ray.d, *cube));
        let hits = probe.nearest(&ray).is_some();
        let wrong = disagreement(&probe, &ray).is_some() || !hits && pierced();
        if hits || wrong {
            tally.answer(!wrong);
        }
    });
    Found::own(None, tally)
}

/// Whether a ray passes through a box, a hundred thousand times farther inside than rounding reaches.
fn pierces(o: DVec3, d: DVec3, [low, high]: Box) -> bool {
    let (low, high) = (low + 1e-9, high - 1e-9);
    let (a, b) = ((low - o) / d, (high - o) / d);
    let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    far - near > 1e-9
}

/// A scene of cubes, quads and spheres whose boxes have whole coordinates, and these boxes.
fn blocks() -> (String, Vec<Box>) {
    let mut random = Pcg64Mcg::seed_from_u64(2000);
    let mut text = String::new();
    let mut boxes = Vec::new();
    for kind in 0..90 {
        let low: [f64; 3] = std::array::from_fn(|_| between(&mut random, -16.0, 16.0).round());
        let side = 2.0 * between(&mut random, 0.6, 2.4).round();
        let mut high = low.map(|x| x + side);
        match kind % 3 {
            0 => {
                let radius = side / 2.0;
                let [x, y, z] = low.map(|x| x + radius);
                let sphere = format!("Translate {x} {y} {z} Shape \"sphere\" \"float radius\" {radius}");
                text += &format!("AttributeBegin {sphere} AttributeEnd\n");
            }
            1 => text += &cube(low, high),
            _ => {
                let flat = kind / 3 % 3;
                high[flat] = low[flat];
                text += &quad(low, high, flat);
            }
        }
        boxes.push([low, high].map(DVec3::from));
    }
    (around_eye(&text), boxes)
}

fn quad(low: [f64; 3], high: [f64; 3], flat: usize) -> String {
    let (a, b) = (1 << ((flat + 1) % 3), 1 << ((flat + 2) % 3));
    quads(&[0, a, a | b, b].map(|which| corner(low, high, which)))
}

/// A ray in the plane of a side of one of the boxes, toward that box; half of them along an axis, and some of those along an
/// edge.
fn in_plane(random: &mut Pcg64Mcg, boxes: &[Box]) -> Ray {
    let bounds = boxes[below(random, boxes.len())];
    let normal = below(random, 3);
    let zero = if chance(random, 0.5) { 0.0 } else { -0.0 };
    let place = |axis: usize, random: &mut Pcg64Mcg| match below(random, 3) {
        0 => bounds[0][axis],
        1 => bounds[1][axis],
        _ if axis == normal => bounds[0][axis],
        _ => between(random, bounds[0][axis], bounds[1][axis]),
    };
    let target = DVec3::from_array(std::array::from_fn(|axis| place(axis, random)));
    let mut d = in_cube(random);
    if chance(random, 0.5) {
        d[(normal + 1) % 3] = if chance(random, 0.5) { 0.0 } else { -0.0 };
    }
    d[normal] = zero;
    let d = d.normalize();
    let o = target - d * between(random, 20.0, 60.0);
    // Single precision holds the ray, so that filters in single precision see the same one.
    Ray::new(o.as_vec3().as_dvec3(), d.as_vec3().as_dvec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_pierced_inside() {
        let cube = [DVec3::ZERO, DVec3::splat(2.0)];
        assert!(pierces(DVec3::new(1.0, 1.0, -3.0), DVec3::Z, cube));
        assert!(pierces(DVec3::splat(-3.0), DVec3::ONE.normalize(), cube));
        assert!(!pierces(DVec3::new(1.0, 0.0, -3.0), DVec3::Z, cube));
        assert!(!pierces(DVec3::new(1.0, 1.0, -3.0), DVec3::NEG_Z, cube));
    }

    /// Elements are numbered as the boxes are, and every hit lies in its box.
    #[test]
    fn hits_lie_in_their_boxes() {
        let (text, boxes) = blocks();
        let scene = scene(&text);
        assert_eq!(scene.world.primitives.len(), boxes.len());
        let probe = Probe::new(&scene);
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut hits = 0;
        for _ in 0..1000 {
            let ray = in_plane(&mut random, &boxes);
            let Some(hit) = probe.nearest_by_all(&ray) else { continue };
            let (p, bounds) = (ray.at(hit.t), boxes[hit.element.primitive as usize]);
            assert!((p - p.clamp(bounds[0], bounds[1])).length() < 1e-5);
            hits += 1;
        }
        assert!(hits > 500, "{hits}");
    }
}
