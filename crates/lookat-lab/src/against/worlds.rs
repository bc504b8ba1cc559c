//! What the scenes of the rows consist of, as text.

use glam::DVec3;

use crate::text_scene::{at, cube, emitting, grid, quad, quads, rgb, sphere, square};

pub(super) const MATTE: &str = "Material \"matte\" \"rgb Kd\" [.6 .6 .6]\n";

/// Place `i` of a sequence that fills a square of half size 5 evenly, at this height.
fn place(i: usize, height: f64) -> DVec3 {
    let fraction = |step: f64| 10.0 * (i as f64 * step).fract() - 5.0;
    DVec3::new(fraction(0.754_877_666), height, fraction(0.569_840_291))
}

pub(super) fn floor(material: &str) -> String {
    format!("{material}{}", quad(DVec3::ZERO, DVec3::X * 20.0, DVec3::Z * 20.0))
}

/// 30 spheres on the floor.
pub(super) fn spheres() -> String {
    (0..30).map(|i| at(place(i, 0.4), &sphere(0.4))).collect()
}

/// A room without front wall, with a sphere inside.
pub(super) fn room(walls: &str, ball: &str) -> String {
    let sides = [
        [DVec3::NEG_Y, DVec3::X, DVec3::Z],
        [DVec3::Y, DVec3::X, DVec3::Z],
        [DVec3::Z, DVec3::X, DVec3::Y],
        [DVec3::NEG_X, DVec3::Y, DVec3::Z],
        [DVec3::X, DVec3::Y, DVec3::Z],
    ];
    let sides = sides.map(|[middle, across, up]| quad(middle, across, up)).concat();
    format!("{walls}{sides}{}", at(DVec3::new(-0.4, -0.65, 0.3), &format!("{ball}{}", sphere(0.35))))
}

/// A horizontal rectangle that emits downward, by half its sizes along x and z.
pub(super) fn lamp(middle: DVec3, half: [f64; 2], radiance: [u32; 3]) -> String {
    emitting(radiance.map(f64::from), &quad(middle, DVec3::X * half[0], DVec3::Z * half[1]))
}

/// A disk that emits downward.
pub(super) fn disk(height: f64) -> String {
    let shape = "Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 0.3\n";
    emitting([14.0, 12.0, 9.0], &at(DVec3::Y * height, shape))
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
    let mut world = MATTE.to_string() + &cube([-2.0, 0.0, 0.0], [2.0, 2.5, length]);
    for room in 0..ROOMS {
        let start = 4.0 * f64::from(room);
        if room > 0 {
            let [left, right] = if room % 2 == 0 { [-2.0, 1.0] } else { [-1.0, 2.0] };
            world += &cube([left, 0.0, start - 0.1], [right, 2.5, start + 0.1]);
        }
        for x in [-1.5, 0.0, 1.5] {
            world += &lamp(DVec3::new(x, 2.4, start + 2.0), [0.15, 0.15], [12; 3]);
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
