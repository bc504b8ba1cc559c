//! BVHs: V1 to V4.

use lookat_render::Hit;
use rayon::prelude::*;

use super::random_world::RandomWorld;
use super::*;
use crate::text_scene::{at, corner, cube, sphere};

pub(super) const MEASURES: &[(&str, Measure)] =
    &[("V1", box_faces), ("V2", random_worlds), ("V3", |_| one_place()), ("V4", |_| giant())];

/// How the BVH and a test of all elements differ for a ray.
fn disagreement(prepared: &Prepared, ray: &Ray) -> Option<String> {
    let (bvh, all) = (prepared.nearest(ray), prepared.nearest_by_all(ray));
    let name = |hit: &Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits));
    if bvh.as_ref().map(name) != all.as_ref().map(name) {
        return Some(format!("nearest: BVH {bvh:?}, all {all:?}"));
    }
    let ends_at = |t_max: f64| prepared.occluded(&Ray { t_max, ..*ray });
    if prepared.occluded(ray) != all.is_some() {
        return Some(format!("occluded: all {all:?}"));
    }
    let all = all?;
    match (ends_at(all.t), ends_at(all.t.next_down())) {
        (false, _) => Some(format!("not occluded to the hit itself: {all:?}")),
        (_, true) => Some(format!("occluded before the hit: {all:?}")),
        _ => None,
    }
}

/// The corners of a box, exact in single precision.
type Box = [DVec3; 2];

/// The BVH finds the hits of single shapes, and rays through a cube hit it.
fn box_faces(trial: &Trial) -> Tally {
    let (text, boxes) = blocks();
    let prepared = prepared(&text).world;
    tally(trial.rays, trial.seed, |random, tally| {
        let ray = in_face(random, &boxes);
        let pierces_cube = || boxes.iter().skip(1).step_by(3).any(|cube| pierces(ray.o, ray.d, *cube));
        let hits = prepared.nearest(&ray).is_some();
        let wrong = disagreement(&prepared, &ray).is_some() || !hits && pierces_cube();
        if hits || wrong {
            tally.answer(!wrong);
        }
    })
}

/// Whether a ray passes through a box, a hundred thousand times farther inside than rounding errors.
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
                text += &at(DVec3::from(low) + radius, &sphere(radius));
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

/// A ray in the plane of a side of a box, toward that box. Half of the rays are along an axis, some of these along an edge.
fn in_face(random: &mut Pcg64Mcg, boxes: &[Box]) -> Ray {
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
    // Exact in single precision, so that filters in single precision see the same ray.
    Ray::new(o.as_vec3().as_dvec3(), d.as_vec3().as_dvec3())
}

fn random_worlds(trial: &Trial) -> Tally {
    /// Rays per scene.
    const BATCH: u64 = 1000;
    let scenes = trial.rays.div_ceil(BATCH);
    let one = |number: u64| one_world(trial.seed << 32 | number, BATCH.min(trial.rays - number * BATCH));
    let mut tally = (0..scenes).into_par_iter().map(one).reduce(Tally::default, Tally::join);
    tally.remarks.truncate(10);
    tally
}

/// Rays in a random scene, and the first that went wrong.
fn one_world(seed: u64, rays: u64) -> Tally {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let world = RandomWorld::new(&mut random);
    let prepared = Prepared::new(&world.scene);
    let mut tally = Tally::default();
    while tally.tried < rays {
        let mut ray = world.aimed(&mut random, prepared.origin());
        for _ in 0..3 {
            let problem = disagreement(&prepared, &ray);
            tally.answer(problem.is_none());
            let remark = problem.map(|what| format!("scene {seed}, o {}, d {}: {what}", ray.o, ray.d));
            tally.remarks.extend(remark.filter(|_| tally.failed == 1));
            // The next ray leaves from the hit.
            match prepared.nearest_by_all(&ray) {
                Some(hit) if chance(&mut random, 0.3) => {
                    ray = prepared.surface(&ray, &hit).spawn_ray(direction(&mut random))
                }
                _ => break,
            }
        }
    }
    tally
}

/// Elements of a crowd.
const CROWD: usize = 100_000;

fn one_place() -> Tally {
    /// Rays per crowd. Each ray tests all elements.
    const RAYS: usize = 100;
    let crowds = [
        ("equal triangles", meshed(|_| [[-1.0, -1.0, 5.0], [1.0, -1.0, 5.0], [0.0, 1.0, 5.0]])),
        ("triangles in equal boxes", meshed(in_equal_box)),
        ("triangles around one point", meshed(|share| around_point(1.0 + share))),
        ("equal spheres", spheres(|_| 1.0)),
        ("concentric spheres", spheres(|share| 1.0 + share)),
        ("equal instances", instances()),
    ];
    let mut tally = Tally::default();
    for (name, world) in crowds {
        let prepared = prepared(&around_eye(&world)).world;
        let mut random = Pcg64Mcg::seed_from_u64(2100);
        let mut hits = 0;
        for _ in 0..RAYS {
            let o = DVec3::new(0.0, 0.0, 5.0) + direction(&mut random) * 6.0;
            let target = DVec3::new(0.0, 0.0, 5.0) + in_cube(&mut random) * 0.9;
            let ray = Ray::new(o, (target - o).normalize());
            hits += usize::from(prepared.nearest(&ray).is_some());
            let problem = disagreement(&prepared, &ray);
            tally.check(problem.is_none(), || format!("{name}: {}", problem.unwrap_or_default()));
        }
        tally.check(hits > RAYS / 4, || format!("{name}: {hits} hits of {RAYS}"));
    }
    tally
}

/// The share of the crowd before each of its elements.
fn shares() -> impl Iterator<Item = f64> {
    (0..CROWD).map(|i| i as f64 / CROWD as f64)
}

fn meshed(corners: impl Fn(f64) -> [[f64; 3]; 3]) -> String {
    triangles(&shares().flat_map(corners).map(DVec3::from).collect::<Vec<_>>())
}

/// Triangles with the same box.
fn in_equal_box(share: f64) -> [[f64; 3]; 3] {
    let y = -1.0 + 2.0 * share;
    [[-1.0, -1.0, 4.0], [1.0, y, 6.0], [-y, 1.0, 4.5]]
}

fn around_point(size: f64) -> [[f64; 3]; 3] {
    [[-size, -size, 5.0 - size], [size, -size, 5.0 + size], [0.0, size, 5.0]]
}

fn spheres(radius: impl Fn(f64) -> f64) -> String {
    format!("Translate 0 0 5 {}", shares().map(|share| sphere(radius(share))).collect::<String>())
}

fn instances() -> String {
    let object = "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd Translate 0 0 5 ";
    format!("{object}{}", "ObjectInstance \"o\"\n".repeat(CROWD))
}

/// A grid of small spheres inside a sphere, and in front of a triangle, of that size.
fn giant() -> Tally {
    let mut tally = Tally::default();
    for size in [1e10, 1e20, 1e30] {
        let grid: String = (0..1000).map(|i| small(i).1).collect();
        let corners = [[-size, -size, 40.0], [size, -size, 40.0], [0.0, size, 40.0]];
        let triangle = triangles(&corners.map(DVec3::from));
        let prepared = prepared(&around_eye(&(grid + &triangle + &sphere(size)))).world;
        // From between the rows of spheres.
        let mut rays: Vec<(DVec3, DVec3, u32, f64, f64)> =
            (0..1000).map(|i| (small(i).0 - DVec3::Z * 0.5, DVec3::Z, i as u32, 0.4, 2.5e-12)).collect();
        // Beside the spheres: to the triangle, and back to the large sphere.
        rays.extend([
            (DVec3::splat(0.5), DVec3::Z, 1000, 39.5, 1e-9),
            (DVec3::splat(0.5), DVec3::NEG_Z, 1001, size, 1e-9),
        ]);
        for (o, d, primitive, t, tolerance) in rays {
            let hit = prepared.nearest(&Ray::new(o, d));
            let right = hit
                .is_some_and(|hit| hit.element.primitive == primitive && (hit.t / t - 1.0).abs() < tolerance);
            tally.check(right, || format!("{size:e}: from {o} toward {d}: {hit:?}"));
        }
    }
    tally
}

/// A sphere of radius 0.1 in a grid from -5 to 4: its center and its directives.
fn small(i: usize) -> (DVec3, String) {
    let center = DVec3::new((i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64) - 5.0;
    (center, at(center, &sphere(0.1)))
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
        let prepared = Prepared::new(&scene);
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut hits = 0;
        for _ in 0..1000 {
            let ray = in_face(&mut random, &boxes);
            let Some(hit) = prepared.nearest_by_all(&ray) else { continue };
            let (p, bounds) = (ray.at(hit.t), boxes[hit.element.primitive as usize]);
            assert!((p - p.clamp(bounds[0], bounds[1])).length() < 1e-5);
            hits += 1;
        }
        assert!(hits > 500, "{hits}");
    }

    /// Most aimed rays hit something, so the comparison is meaningful.
    #[test]
    fn rays_hit() {
        let (mut hits, mut tried) = (0, 0);
        for seed in 0..20 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let world = RandomWorld::new(&mut random);
            let prepared = Prepared::new(&world.scene);
            for _ in 0..100 {
                hits += usize::from(
                    prepared.nearest_by_all(&world.aimed(&mut random, prepared.origin())).is_some(),
                );
                tried += 1;
            }
        }
        assert!(hits * 2 > tried, "{hits} of {tried}");
    }
}
