//! Shadow rays to what is close to a light: V7.

use std::f64::consts::PI;

use crate::stability::prelude::*;

/// How far the light is from the floor.
const DISTANCE: f64 = 10.0;

/// Pixels on a side of the pictures.
const SIDE: u32 = 16;

pub(super) fn close_to_light(_: &Effort) -> Found {
    let mut found = Found::sweep(0, [1e-2, 1e-3, 2e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9], |_, gap| {
        HiddenLight::ALL.iter().map(|light| lit_pixels(*light, gap)).fold(Tally::default(), Tally::join)
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

#[derive(Clone, Copy)]
enum HiddenLight {
    Square,
    Sphere,
    Point,
}

impl HiddenLight {
    const ALL: [HiddenLight; 3] = [HiddenLight::Square, HiddenLight::Sphere, HiddenLight::Point];

    /// The light, and what hides it from the floor at that share of the distance before it.
    fn behind(self, gap: f64) -> String {
        let below = DISTANCE * (1.0 - gap);
        match self {
            HiddenLight::Square => format!("{}{}", square_light(), square(below, 1.5)),
            HiddenLight::Sphere => format!(
                "AttributeBegin Translate 0 {DISTANCE} 0 AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd
                 Shape \"sphere\" \"float radius\" {} AttributeEnd\n",
                1.0 + DISTANCE * gap
            ),
            HiddenLight::Point => format!(
                "LightSource \"point\" \"point from\" [0 {DISTANCE} 0]\n{}",
                square(below, 1.0)
            ),
        }
    }
}

/// A square in the plane of that height.
fn square(height: f64, half: f64) -> String {
    quads(
        &[(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, z)| DVec3::new(x, height, z)),
    )
}

/// A square of half a side of one, that shines down.
fn square_light() -> String {
    format!("AttributeBegin AreaLightSource \"diffuse\" {} AttributeEnd\n", square(DISTANCE, 1.0))
}

/// The floor, seen from below the light.
fn text(world: &str, half_width: f64, samples: u32) -> String {
    format!(
        "LookAt 0 5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" {}
         Film \"image\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}
         Sampler \"sobol\" \"integer pixelsamples\" {samples} Integrator \"directlighting\"
         WorldBegin {world} Material \"matte\" \"rgb Kd\" [0.5 0.5 0.5] {} WorldEnd",
        2.0 * half_width,
        square(0.0, 4.0)
    )
}

/// Pixels of the floor that light reaches.
fn lit_pixels(light: HiddenLight, gap: f64) -> Tally {
    let image = render(&scene(&text(&light.behind(gap), 10.0, 16)), 0);
    let mut tally = Tally::default();
    image.rgb().unwrap_or_default().iter().for_each(|pixel| tally.answer(*pixel == [0.0; 3]));
    tally
}

/// The relative error of the light that the square casts on the point below it; alone, or in a wall in its plane.
fn in_the_open(in_wall: bool) -> f64 {
    let wall = if in_wall { square(DISTANCE, 3.0) } else { String::new() };
    // So narrow that all pixels see one point. The camera looks from below the wall.
    let image = render(&scene(&text(&format!("{}{wall}", square_light()), 1e-6, 1024)), 0);
    let pixels = image.rgb().unwrap_or_default();
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
        for light in HiddenLight::ALL {
            let blocked = light.behind(0.5);
            let end = match light {
                HiddenLight::Square => blocked.find("AttributeEnd\n").map(|at| at + 13),
                HiddenLight::Sphere => blocked.rfind("Shape"),
                HiddenLight::Point => blocked.find('\n'),
            };
            let mut open = blocked[..end.expect("a light")].to_owned();
            if matches!(light, HiddenLight::Sphere) {
                open += "AttributeEnd";
            }
            let image = render(&scene(&text(&open, 10.0, 16)), 1);
            assert!(image.rgb().expect("a picture").iter().all(|pixel| pixel[0] > 0.0));
        }
    }
}
