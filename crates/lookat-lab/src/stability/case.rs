//! A case and its results.

use super::tally::Tally;

/// One question with a known answer.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// A letter and a number: C for cameras, S for spheres and quadrics, T for triangles, P for eyes and lights in a plane, V for
    /// BVHs, secondary rays, samples and pictures, B for BSDFs.
    pub id: &'static str,
    /// A word or two, with hyphens.
    pub name: &'static str,
    /// What must hold, in one line.
    pub claim: &'static str,
    /// The quantity and unit of [`Row::at`], empty if rows have no place.
    pub axis: &'static str,
    /// The quantity and unit of [`Row::worst`], empty if the case measures no error.
    pub error: &'static str,
    /// The largest error that lookat may make. Infinite in a measurement without a limit.
    pub limit: f64,
    pub(super) measure: Measure,
}

/// Measures lookat.
pub(super) type Measure = fn(&Effort) -> Found;

/// The work of a case.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Random rays for each row, above 0. Cases that ask a fixed number of questions ignore it.
    pub rays: u64,
}

/// The name of the tested method: the renderer's own code.
pub const LOOKAT: &str = "lookat";

/// The answers of one method at one place of the axis.
#[derive(Debug, Clone)]
pub struct Row {
    /// [`LOOKAT`], a part of it, or another method.
    pub method: &'static str,
    /// The place on the axis.
    pub at: Option<f64>,
    /// The number of answers.
    pub tried: u64,
    /// The number of wrong answers.
    pub failed: u64,
    /// The largest error of the other answers; `None` if none was measured.
    pub worst: Option<f64>,
}

/// The results of a case.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// One for each method and place.
    pub rows: Vec<Row>,
    /// Failures and details in words.
    pub remarks: Vec<String>,
}

impl Found {
    /// Lookat's answers at one place.
    pub(super) fn own(at: Option<f64>, tally: Tally) -> Found {
        let mut found = Found::default();
        found.add(LOOKAT, at, tally);
        found
    }

    /// Lookat's answers at several places. `measure` gets a seed, which counts up from `seed`, and the place.
    pub(super) fn sweep(
        seed: u64,
        places: impl IntoIterator<Item = f64>,
        measure: impl Fn(u64, f64) -> Tally,
    ) -> Found {
        let mut found = Found::default();
        for (seed, at) in (seed..).zip(places) {
            found.add(LOOKAT, Some(at), measure(seed, at));
        }
        found
    }

    pub(super) fn add(&mut self, method: &'static str, at: Option<f64>, tally: Tally) {
        let Tally { tried, failed, worst } = tally;
        self.rows.push(Row { method, at, tried, failed, worst });
    }

    /// Asks lookat one question.
    pub(super) fn check(&mut self, holds: bool, otherwise: impl FnOnce() -> String) {
        if self.rows.is_empty() {
            self.add(LOOKAT, None, Tally::default());
        }
        self.rows[0].tried += 1;
        if !holds {
            self.rows[0].failed += 1;
            self.remarks.push(otherwise());
        }
    }

    /// All methods, in the order of their first rows.
    pub fn methods(&self) -> Vec<&'static str> {
        distinct(self.rows.iter().map(|row| row.method))
    }

    /// All places, in the order of their first rows. `None` stands for rows without a place.
    pub fn places(&self) -> Vec<Option<f64>> {
        distinct(self.rows.iter().map(|row| row.at))
    }

    /// True if lookat is right each time, and as exact as `case` demands.
    pub fn passes(&self, case: &Case) -> bool {
        let mut own = self.rows.iter().filter(|row| row.method == LOOKAT).peekable();
        own.peek().is_some()
            && own.all(|row| {
                row.tried > 0 && row.failed == 0 && row.worst.is_none_or(|worst| worst <= case.limit)
            })
    }
}

fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for item in items {
        if !distinct.contains(&item) {
            distinct.push(item);
        }
    }
    distinct
}
