//! Numerical test cases with a known truth.
//!
//! Each case feeds hard inputs to the renderer's own code and counts wrong answers. The truth is exact, or computed with at
//! least twice the digits. The table `cases.tsv` holds the words, limits, seeds and places of the cases; a few checks per family
//! measure them. `docs/stability.md` has the answers of other methods.

mod camera;
mod case;
mod coplanar;
mod double_double;
mod exact_camera;
mod icosphere;
mod media;
mod messages;
mod offsets;
mod pictures;
mod quadric;
mod quadric_truth;
pub(crate) mod random;
mod random_world;
mod scattering;
mod tally;
mod traversal;
mod triangle;

pub use case::{ALL, Case, CaseResult, Row, as_csv};

// What most families of cases use.
use glam::{DMat3, DMat4, DVec2, DVec3};
use lookat_render::{Prepared, Ray};
use lookat_scene::Scene;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::text_scene::{
    PreparedScene, around_eye, load, mesh, pictured, prepared, quads, render, scene, seen_from, square,
    transform, triangles, xyz,
};
use random::{below, between, chance, direction, in_cube, in_triangle, leaving, magnitude};
use tally::{Measure, Tally, Trial, tally};

const CASES: &str = include_str!("stability/cases.tsv");

/// All cases, by family and number.
///
/// # Panics
///
/// If the table and the code disagree; a test rules that out.
pub fn cases() -> Vec<Case> {
    let measures = [
        camera::MEASURES,
        quadric::MEASURES,
        triangle::MEASURES,
        coplanar::MEASURES,
        traversal::MEASURES,
        offsets::MEASURES,
        pictures::MEASURES,
        scattering::MEASURES,
        media::MEASURES,
    ]
    .concat();
    // Some cases consist of messages alone.
    let none: Measure = |_| Tally::default();
    let of = |id: &str| measures.iter().find(|(of, _)| *of == id).map_or(none, |(_, measure)| *measure);
    CASES.lines().filter(|line| !line.starts_with('#')).map(|line| Case::parse(line, of)).collect()
}
