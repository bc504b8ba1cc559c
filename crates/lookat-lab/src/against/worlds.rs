//! What the scenes of the rows consist of, as text.

use glam::DVec3;

use crate::text_scene::{at, cube, emitting, grid, quad, quads, rgb, sphere, square};

/// Place `i` of a sequence that fills a square of half size 5 evenly, at this height.
fn place(i: usize, height: f64) -> DVec3 {
    let fraction = |step: f64| 10.0 * (i as f64 * step).fract() - 5.0;
    DVec3::new(fraction(0.754_877_666), height, fraction(0.569_840_291))
}

/// 30 spheres on the floor.
pub(super) fn spheres() -> String {
    (0..30).map(|i| at(place(i, 0.4), &sphere(0.4))).collect()
}

pub(super) fn points(count: usize) -> String {
    let power = 60.0 / count as f64;
    let light = format!("LightSource \"point\" \"rgb I\" {}", rgb([power; 3]));
    (0..count).map(|i| at(place(i, 2.0), &light)).collect()
}

/// Spheres that emit, with the same power for any count and radius.
pub(super) fn sphere_lamps(count: usize, radius: f64) -> String {
    let radiance = 20.0 / (count as f64 * radius * radius);
    let lamp = emitting([radiance; 3], &sphere(radius));
    (0..count).map(|i| at(place(i, 2.0), &lamp)).collect()
}

/// One mesh of separate quads that emit downward, with the same area for any count.
pub(super) fn mesh_light(count: usize) -> String {
    let half = 1.0 / (count as f64).sqrt();
    let corners: Vec<DVec3> =
        (0..count).flat_map(|i| square(place(i, 3.0), DVec3::X * half, DVec3::Z * half)).collect();
    emitting([5.0; 3], &quads(&corners))
}

/// Twenty rooms in a row. Doors are left and right in turn, and each room has three lamps.
pub(super) fn corridor() -> String {
    const ROOMS: u32 = 20;
    let length = 4.0 * f64::from(ROOMS);
    let mut world = cube([-2.0, 0.0, 0.0], [2.0, 2.5, length]);
    for room in 0..ROOMS {
        let start = 4.0 * f64::from(room);
        if room > 0 {
            let [left, right] = if room % 2 == 0 { [-2.0, 1.0] } else { [-1.0, 2.0] };
            world += &cube([left, 0.0, start - 0.1], [right, 2.5, start + 0.1]);
        }
        for x in [-1.5, 0.0, 1.5] {
            let middle = DVec3::new(x, 2.4, start + 2.0);
            world += &emitting([12.0; 3], &quad(middle, DVec3::X * 0.15, DVec3::Z * 0.15));
        }
    }
    world
}

/// A mesh of 64 x 64 quads with waves, just above the floor.
pub(super) fn bumps() -> String {
    const SIDE: usize = 64;
    let along = |i: usize| 8.0 * i as f64 / SIDE as f64 - 4.0;
    let height = |x: f64, z: f64| 0.7 + 0.25 * (2.5 * x).sin() * (2.5 * z).cos();
    grid(SIDE, |x, z| {
        let [x, z] = [x, z].map(along);
        DVec3::new(x, height(x, z), z)
    })
}
