//! Where methods fail, by how much, and whether lookat does: cases with a known truth.
//!
//! Each case feeds the renderer's own code, and formulas in use elsewhere, with inputs that are hard for them, and counts
//! what comes out wrong. Truth is exact, or computed with at least twice the digits.

mod camera;
mod case;
mod chart;
mod coplanar;
mod methods;
mod quadric;
pub(crate) mod random;
mod sphere;
mod table;
mod tally;
mod traversal;
mod triangle;
mod truth;

pub use case::{Axis, Case, Effort, Family, Found, LOOKAT, Row};
pub use chart::draw;
pub use table::{as_csv, as_json};

/// All cases, in the order of their names.
pub fn cases() -> Vec<Case> {
    let mut cases = [
        camera::cases(),
        sphere::cases(),
        quadric::cases(),
        triangle::cases(),
        coplanar::cases(),
        traversal::cases(),
    ]
    .concat();
    let number = |case: &Case| case.id.trim_matches(char::is_alphabetic).parse::<u32>().unwrap_or_default();
    cases.sort_by_key(|case| (case.family, number(case), case.id));
    cases
}
