//! Elements that cannot be told apart by place, and one that is much larger than the rest: V3 and V4.

use super::brute_force::disagreement;
use crate::stability::prelude::*;

/// Elements of each crowd.
const CROWD: usize = 100_000;

/// Rays for each crowd: each of them asks all elements.
const RAYS: usize = 100;

pub(super) fn one_place(_: &Effort) -> Found {
    let crowds = [
        ("equal triangles", mesh((0..CROWD).map(|_| [[-1.0, -1.0, 5.0], [1.0, -1.0, 5.0], [0.0, 1.0, 5.0]]))),
        ("triangles in equal boxes", mesh((0..CROWD).map(in_equal_box))),
        ("triangles around one point", mesh((0..CROWD).map(|i| around_point(1.0 + i as f64 / CROWD as f64)))),
        ("equal spheres", spheres((0..CROWD).map(|_| 1.0))),
        ("concentric spheres", spheres((0..CROWD).map(|i| 1.0 + i as f64 / CROWD as f64))),
        ("equal instances", instances()),
    ];
    let mut found = Found::default();
    for (name, world) in crowds {
        let probe = probe(&around_eye(&world));
        let mut random = Pcg64Mcg::seed_from_u64(2100);
        let mut hits = 0;
        for _ in 0..RAYS {
            let o = DVec3::new(0.0, 0.0, 5.0) + direction(&mut random) * 6.0;
            let target = DVec3::new(0.0, 0.0, 5.0) + in_cube(&mut random) * 0.9;
            let ray = Ray::new(o, (target - o).normalize());
            hits += usize::from(probe.nearest(&ray).is_some());
            let problem = disagreement(&probe, &ray);
            found.check(problem.is_none(), || format!("{name}: {}", problem.unwrap_or_default()));
        }
        found.check(hits > RAYS / 4, || format!("{name}: {hits} hits of {RAYS}"));
    }
    found
}

fn mesh(corners: impl Iterator<Item = [[f64; 3]; 3]>) -> String {
    triangles(&corners.flatten().map(DVec3::from).collect::<Vec<_>>())
}

/// A triangle whose box is that of all others.
fn in_equal_box(i: usize) -> [[f64; 3]; 3] {
    let y = -1.0 + 2.0 * (i as f64 / CROWD as f64);
    [[-1.0, -1.0, 4.0], [1.0, y, 6.0], [-y, 1.0, 4.5]]
}

fn around_point(size: f64) -> [[f64; 3]; 3] {
    [[-size, -size, 5.0 - size], [size, -size, 5.0 + size], [0.0, size, 5.0]]
}

fn spheres(radii: impl Iterator<Item = f64>) -> String {
    let shapes: String =
        radii.map(|radius| format!("Shape \"sphere\" \"float radius\" {radius}\n")).collect();
    format!("Translate 0 0 5 {shapes}")
}

fn instances() -> String {
    let object = "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd Translate 0 0 5 ";
    format!("{object}{}", "ObjectInstance \"o\"\n".repeat(CROWD))
}

/// A grid of small spheres inside a sphere, and in front of a triangle, of that size.
pub(super) fn giant(_: &Effort) -> Found {
    let mut found = Found::default();
    for size in [1e10, 1e20, 1e30] {
        let grid: String = (0..1000).map(|i| small(i).1).collect();
        let triangle = mesh([[[-size, -size, 40.0], [size, -size, 40.0], [0.0, size, 40.0]]].into_iter());
        let sphere = format!("Shape \"sphere\" \"float radius\" {size:e}");
        let probe = probe(&around_eye(&(grid + &triangle + &sphere)));
        // From between the rows of spheres, where nothing is in the way.
        let mut rays: Vec<(DVec3, DVec3, u32, f64, f64)> =
            (0..1000).map(|i| (small(i).0 - DVec3::Z * 0.5, DVec3::Z, i as u32, 0.4, 2.5e-12)).collect();
        // Beside the spheres, to the triangle, and the other way, to the large sphere.
        rays.extend([
            (DVec3::splat(0.5), DVec3::Z, 1000, 39.5, 1e-9),
            (DVec3::splat(0.5), DVec3::NEG_Z, 1001, size, 1e-9),
        ]);
        for (o, d, primitive, t, tolerance) in rays {
            let hit = probe.nearest(&Ray::new(o, d));
            let right = hit
                .is_some_and(|hit| hit.element.primitive == primitive && (hit.t / t - 1.0).abs() < tolerance);
            found.check(right, || format!("{size:e}: from {o} toward {d}: {hit:?}"));
        }
    }
    found
}

/// A sphere of radius 0.1 of a grid from -5 to 4, in text.
fn small(i: usize) -> (DVec3, String) {
    let center = DVec3::new((i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64) - 5.0;
    let at = xyz(center);
    let text = format!("AttributeBegin Translate {at} Shape \"sphere\" \"float radius\" 0.1 AttributeEnd\n");
    (center, text)
}
