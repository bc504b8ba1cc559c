//! Boundaries of media: M1 to M5.
//!
//! A point of a floor under the sun is seen from below all media, so that only shadow rays cross them: their transmittance has a closed form
//! and no noise. The media absorb and do not scatter.

use super::scattering::{error, floor_under_sun};
use super::*;
use crate::text_scene::{at, block};

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("M1", |trial| {
        absorbed(1.0, &(medium("m", 1.0 / thickness(trial.at)) + &slab("m", "", 5.0, 5.0 + trial.at)))
    }),
    ("M2", touching),
    ("M3", nested),
    ("M4", |trial| {
        let size = trial.at;
        let object = format!("ObjectBegin \"o\" {} ObjectEnd ", slab("m", "", 1.0, 2.0));
        let copy = block(&format!("Translate 0 5 0 Scale 1 {size:e} 1 ObjectInstance \"o\""));
        absorbed(1.0, &(medium("m", 1.0 / size) + &object + &copy))
    }),
    ("M5", |trial| {
        let world = medium("m", 1.0) + &slab("m", "", 5.0, 6.0);
        let place = DVec3::new(trial.at, -trial.at, trial.at);
        let light = floor_under_sun(place, &at(place, &world));
        error(light, floor_under_sun(place, "") * (-1.0_f64).exp())
    }),
];

/// The thickness of a slab from height 5 on, as numbers have it.
fn thickness(of: f64) -> f64 {
    (5.0 + of) - 5.0
}

/// A medium that absorbs.
fn medium(name: &str, absorption: f64) -> String {
    format!(
        "MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [{absorption:e} {absorption:e} {absorption:e}] \"rgb sigma_s\" [0 0 0] "
    )
}

/// The boundaries of a slab between two heights.
fn slab(inside: &str, outside: &str, low: f64, high: f64) -> String {
    let face = |height: f64, up: f64| square(DVec3::Y * height, DVec3::X * 9.0, DVec3::Z * (-9.0 * up));
    let faces = [face(high, 1.0), face(low, -1.0)].concat();
    block(&format!("MediumInterface \"{inside}\" \"{outside}\" Material \"\" {}", quads(&faces)))
}

/// The relative error of the light of the floor under media of an optical depth.
fn absorbed(depth: f64, media: &str) -> Tally {
    error(floor_under_sun(DVec3::ZERO, media), floor_under_sun(DVec3::ZERO, "") * (-depth).exp())
}

/// Slabs that touch, of so many media, named from below or from above.
fn touching(trial: &Trial) -> Tally {
    let count = trial.at as u32;
    let one = |index: u32| {
        let (name, low) = (format!("m{index}"), 5.0 + f64::from(index));
        medium(&name, 1.0 / trial.at) + &slab(&name, "", low, low + 1.0)
    };
    let upward = absorbed(1.0, &(0..count).map(one).collect::<String>());
    upward.join(absorbed(1.0, &(0..count).rev().map(one).collect::<String>()))
}

/// So many slabs, each within the one before, of media that are ever denser.
fn nested(trial: &Trial) -> Tally {
    let (count, step) = (trial.at as u32, 1.0 / trial.at);
    let name = |index: u32| if index == 0 { String::new() } else { format!("m{index}") };
    let (mut media, mut slabs, mut depth) = (String::new(), String::new(), 0.0);
    for index in 1..=count {
        let (absorption, edge) = (0.05 * f64::from(index), f64::from(index) * step);
        media += &medium(&name(index), absorption);
        slabs += &slab(&name(index), &name(index - 1), 5.0 + edge, 9.0 - edge);
        let inner = if index == count { 4.0 - 2.0 * edge } else { 2.0 * step };
        depth += absorption * inner;
    }
    absorbed(depth, &(media + &slabs))
}
