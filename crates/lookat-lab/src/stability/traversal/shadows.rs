//! Shadow rays to what is close to a light: V7.

use std::f64::consts::PI;

use crate::stability::prelude::*;

/// How far the light is from the floor.
const DISTANCE: f64 = 10.0;

/// Pixels on a side of the pictures.
const SIDE: u32 = 16;

pub(super) fn close_to_light(_: &Effort) -> Found {
    let mut found = Found::sweep(0, [1e-2, 1e-3, 2e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9], |_, gap| {
        hidden_lights(gap).iter().map(|light| lit_pixels(&light.concat())).fold(Tally::default(), Tally::join)
    });
    let open = [in_the_open(false), in_the_open(true)];
    found
        .remarks
        .push(format!("square light alone: relative error {:.1e}; in a wall: {:.1e}", open[0], open[1]));
    let mut lit = Tally::default();
    open.into_iter().for_each(|error| lit.error(error));
    found.add(LOOKAT, None, lit);
    found
}

/// Lights, each with what hides it from the floor at that share of the distance before it.
fn hidden_lights(gap: f64) -> [[String; 2]; 3] {
    let below = DISTANCE * (1.0 - gap);
    let sphere = |options: &str, radius: f64| {
        format!(
            "AttributeBegin Translate 0 {DISTANCE} 0 {options} Shape \"sphere\" \"float radius\" {radius} AttributeEnd\n"
        )
    };
    [
        [square_light(), flat_square(below, 1.5)],
        [sphere("AreaLightSource \"diffuse\"", 1.0), sphere("", 1.0 + DISTANCE * gap)],
        [format!("LightSource \"point\" \"point from\" [0 {DISTANCE} 0]\n"), flat_square(below, 1.0)],
    ]
}

/// A square in the plane of that height.
fn flat_square(height: f64, half: f64) -> String {
    quads(&square(DVec3::Y * height, DVec3::X * half, DVec3::Z * half))
}

/// A square of half a side of one, that shines down.
fn square_light() -> String {
    format!("AttributeBegin AreaLightSource \"diffuse\" {} AttributeEnd\n", flat_square(DISTANCE, 1.0))
}

/// The floor, seen from below the light.
fn text(world: &str, half_width: f64, samples: u32) -> String {
    let camera =
        format!("LookAt 0 5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" {}", 2.0 * half_width);
    let floor = flat_square(0.0, 4.0);
    let world = format!("{world} Material \"matte\" \"rgb Kd\" [0.5 0.5 0.5] {floor}");
    pictured(&camera, SIDE, samples, "directlighting", &world)
}

/// Pixels of the floor that light reaches.
fn lit_pixels(world: &str) -> Tally {
    let mut tally = Tally::default();
    render(&scene(&text(world, 10.0, 16)), 0).iter().for_each(|pixel| tally.answer(*pixel == [0.0; 3]));
    tally
}

/// The relative error of the light that the square casts on the point below it; alone, or in a wall in its plane.
fn in_the_open(in_wall: bool) -> f64 {
    let wall = if in_wall { flat_square(DISTANCE, 3.0) } else { String::new() };
    // So narrow that all pixels see one point. The camera looks from below the wall.
    let pixels = render(&scene(&text(&format!("{}{wall}", square_light()), 1e-6, 1024)), 0);
    let mean = pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / pixels.len() as f64;
    (mean / (0.5 * form_factor()) - 1.0).abs()
}

/// From a point to the square above it: four times that to a quarter, seen below a corner of it (Howell, "A Catalog of
/// Radiation Heat Transfer Configuration Factors", B-3).
fn form_factor() -> f64 {
    let a = 1.0 / DISTANCE;
    let root = (1.0 + a * a).sqrt();
    4.0 * (2.0 * a / root * (a / root).atan()) / (2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum over small squares.
    #[test]
    fn form_factor_is_that_of_the_sum() {
        let n = 400;
        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let part = |x: f64, y: f64| {
            let squared = x * x + y * y + DISTANCE * DISTANCE;
            DISTANCE * DISTANCE / (PI * squared * squared) * (2.0 / f64::from(n)).powi(2)
        };
        let sum: f64 = (0..n * n).map(|i| part(at(i % n), at(i / n))).sum();
        assert!((form_factor() / sum - 1.0).abs() < 1e-5);
    }

    /// Without the blockers every pixel is lit, so that dark pixels mean something.
    #[test]
    fn lights_reach_the_floor_unless_blocked() {
        for [light, _] in hidden_lights(0.5) {
            let pixels = render(&scene(&text(&light, 10.0, 16)), 1);
            assert!(!pixels.is_empty() && pixels.iter().all(|pixel| pixel[0] > 0.0));
        }
    }
}
