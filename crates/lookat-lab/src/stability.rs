//! Numerical test cases with a known truth: where ray tracing methods fail, by how much, and whether lookat does.
//!
//! Each case feeds hard inputs to the renderer's own code and counts wrong answers. The truth is exact, or computed with at
//! least twice the digits. The answers of other methods are a table of numbers.

mod camera;
mod case;
mod chart;
mod coplanar;
mod others;
mod prelude;
mod quadric;
pub(crate) mod random;
mod refused;
mod scattering;
mod sphere;
mod table;
mod tally;
mod traversal;
mod triangle;
mod truth;

pub use case::{Case, Effort, Found, LOOKAT, Row};
pub use chart::draw;
pub use table::{as_csv, as_json};

/// The words and limits of the cases, in order: id, name, claim, axis, error, limit.
const CASES: &str = include_str!("stability/cases.tsv");

/// All cases, by family and number.
///
/// # Panics
///
/// If the table and the code disagree; a test rules that out.
pub fn cases() -> Vec<Case> {
    let measures = [
        camera::MEASURES,
        sphere::MEASURES,
        quadric::MEASURES,
        triangle::MEASURES,
        coplanar::MEASURES,
        traversal::MEASURES,
        scattering::MEASURES,
    ]
    .concat();
    let lines = CASES.lines().filter(|line| !line.starts_with('#'));
    let case = |line: &'static str| {
        let fields: Vec<&str> = line.split('\t').collect();
        let [id, name, claim, axis, error, limit] = fields[..] else { panic!("not six fields: {line}") };
        let limit = limit.parse().expect("a limit is a number");
        let (_, measure) = *measures.iter().find(|(of, _)| *of == id).expect("each case is measured");
        Case { id, name, claim, axis, error, limit, measure }
    };
    lines.map(case).collect()
}

impl Case {
    /// Measures lookat, and adds the numbers of the other methods.
    pub fn run(&self, effort: &Effort) -> Found {
        others::added(self.id, (self.measure)(effort))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_measure_has_its_line() {
        let count = [camera::MEASURES, sphere::MEASURES, quadric::MEASURES, triangle::MEASURES]
            .iter()
            .chain(&[coplanar::MEASURES, traversal::MEASURES, scattering::MEASURES])
            .map(|measures| measures.len());
        assert_eq!(cases().len(), count.sum::<usize>());
    }
}
