//! What the scenes of the rows consist of, as text.

use glam::DVec3;

use crate::text_scene::{cube, mesh, quads, square, xyz};

pub(super) const MATTE: &str = "Material \"matte\" \"rgb Kd\" [.6 .6 .6]\n";

/// Place `i` of a sequence that fills a square of half size 5 evenly, at this height.
fn place(i: usize, height: f64) -> DVec3 {
    let fraction = |step: f64| 10.0 * (i as f64 * step).fract() - 5.0;
    DVec3::new(fraction(0.754_877_666), height, fraction(0.569_840_291))
}

/// Directives at a place.
pub(super) fn at(p: DVec3, directives: &str) -> String {
    format!("AttributeBegin Translate {} {directives} AttributeEnd\n", xyz(p))
}

/// A square of half size 1 around a point.
pub(super) fn wall([middle, across, up]: [DVec3; 3]) -> String {
    quads(&square(middle, across, up))
}

pub(super) fn floor(material: &str) -> String {
    format!("{material}{}", wall([DVec3::ZERO, DVec3::X * 20.0, DVec3::Z * 20.0]))
}

/// 30 spheres on the floor.
pub(super) fn spheres() -> String {
    (0..30).map(|i| at(place(i, 0.4), "Shape \"sphere\" \"float radius\" 0.4")).collect()
}

/// A room without front wall, with a sphere inside.
pub(super) fn room(walls: &str, sphere: &str) -> String {
    let sides = [
        [DVec3::NEG_Y, DVec3::X, DVec3::Z],
        [DVec3::Y, DVec3::X, DVec3::Z],
        [DVec3::Z, DVec3::X, DVec3::Y],
        [DVec3::NEG_X, DVec3::Y, DVec3::Z],
        [DVec3::X, DVec3::Y, DVec3::Z],
    ];
    let ball = format!("{sphere}Shape \"sphere\" \"float radius\" 0.35");
    format!("{walls}{}{}", sides.map(wall).concat(), at(DVec3::new(-0.4, -0.65, 0.3), &ball))
}

/// A shape that emits.
fn emitting(radiance: &str, shape: &str) -> String {
    format!("AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [{radiance}] {shape}AttributeEnd\n")
}

/// A horizontal rectangle that emits downward, by half its sizes along x and z.
pub(super) fn lamp(middle: DVec3, half: [f64; 2], radiance: [u32; 3]) -> String {
    emitting(
        &radiance.map(|channel| channel.to_string()).join(" "),
        &wall([middle, DVec3::X * half[0], DVec3::Z * half[1]]),
    )
}

/// A disk that emits downward.
pub(super) fn disk(height: f64) -> String {
    let shape = "Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 0.3\n";
    emitting("14 12 9", &format!("Translate 0 {height} 0 {shape}"))
}

pub(super) fn points(count: usize) -> String {
    let power = 60.0 / count as f64;
    let light = format!("LightSource \"point\" \"rgb I\" [{power} {power} {power}]");
    (0..count).map(|i| at(place(i, 2.0), &light)).collect()
}

/// Spheres that emit, with the same power for any count and radius.
pub(super) fn sphere_lamps(count: usize, radius: f64) -> String {
    let radiance = 20.0 / (count as f64 * radius * radius);
    let shape = format!("Shape \"sphere\" \"float radius\" {radius} ");
    let lamp = emitting(&format!("{radiance} {radiance} {radiance}"), &shape);
    (0..count).map(|i| at(place(i, 2.0), &lamp)).collect()
}

/// One mesh of separate quads that emit downward, with the same area for any count.
pub(super) fn mesh_light(count: usize) -> String {
    let half = 1.0 / (count as f64).sqrt();
    let corners: Vec<DVec3> =
        (0..count).flat_map(|i| square(place(i, 3.0), DVec3::X * half, DVec3::Z * half)).collect();
    emitting("5 5 5", &quads(&corners))
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
    let points: Vec<DVec3> = (0..=SIDE)
        .flat_map(|i| (0..=SIDE).map(move |j| [along(j), along(i)]))
        .map(|[x, z]| DVec3::new(x, height(x, z), z))
        .collect();
    let faces = (0..SIDE * SIDE).flat_map(|i| {
        let corner = i / SIDE * (SIDE + 1) + i % SIDE;
        let above = corner + SIDE + 1;
        [[corner, corner + 1, above + 1], [corner, above + 1, above]]
    });
    mesh(&points, &faces.collect::<Vec<_>>())
}
