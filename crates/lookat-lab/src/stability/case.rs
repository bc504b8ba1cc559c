//! What a case is, and what it finds.

use super::tally::Tally;

/// One question with a known answer.
#[derive(Debug, Clone)]
pub struct Case {
    /// A letter and a number: C for cameras, S for spheres, T for triangles, P for eyes and lights in a plane, V for all else.
    pub id: &'static str,
    /// A word or two, with hyphens.
    pub name: &'static str,
    /// Which chapter it belongs to.
    pub family: Family,
    /// What must hold, in one line.
    pub claim: &'static str,
    /// What the rows go along.
    pub axis: Axis,
    /// What [`Row::worst`] is, with its unit; empty where nothing is measured.
    pub error: &'static str,
    /// The most that it may be for lookat; infinite where it is only measured, not judged.
    pub limit: f64,
    /// Runs it.
    pub run: fn(&Effort) -> Found,
}

/// The chapters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Camera rays.
    Camera,
    /// Rays against spheres and other curved shapes.
    Sphere,
    /// Rays against triangles.
    Triangle,
    /// Eyes and lights in the plane of a triangle, or on a curved shape.
    Coplanar,
    /// Trees, secondary rays, samples, whole pictures.
    Traversal,
}

/// What [`Row::at`] means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Rows have no place.
    None,
    /// A quantity with its unit; its chart is logarithmic.
    Of(&'static str),
}

impl Axis {
    /// The quantity; nothing where there is none.
    pub fn name(self) -> &'static str {
        match self {
            Axis::None => "",
            Axis::Of(name) => name,
        }
    }
}

/// How much work a case may be.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Random rays for each row. Cases that ask a fixed number of questions take no notice.
    pub rays: u64,
}

/// The name of the method in use: the renderer's own code.
pub const LOOKAT: &str = "lookat";

/// What one method did at one place of the axis.
#[derive(Debug, Clone)]
pub struct Row {
    /// [`LOOKAT`], or a formula that it is compared with.
    pub method: &'static str,
    /// The place on the axis.
    pub at: Option<f64>,
    /// How many times it was tried.
    pub tried: u64,
    /// How many times the answer was wrong.
    pub failed: u64,
    /// The largest error of answers that were not wrong; `None` where none was measured.
    pub worst: Option<f64>,
}

/// What a case has found.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// One for each method and place.
    pub rows: Vec<Row>,
    /// What went wrong, in words, for those that do not count in numbers.
    pub remarks: Vec<String>,
}

impl Found {
    /// Adds the rows of all methods at a place.
    pub(super) fn add(&mut self, at: Option<f64>, methods: &[&'static str], tallies: &[Tally]) {
        self.rows.extend(methods.iter().zip(tallies).map(|(method, tally)| Row {
            method,
            at,
            tried: tally.tried,
            failed: tally.failed,
            worst: tally.worst,
        }));
    }

    /// Asks the renderer one question.
    pub(super) fn check(&mut self, holds: bool, otherwise: impl FnOnce() -> String) {
        if self.rows.is_empty() {
            self.rows.push(Row { method: LOOKAT, at: None, tried: 0, failed: 0, worst: None });
        }
        self.rows[0].tried += 1;
        if !holds {
            self.rows[0].failed += 1;
            self.remarks.push(otherwise());
        }
    }

    /// All methods, in the order of their first rows.
    pub fn methods(&self) -> Vec<&'static str> {
        let mut methods = Vec::new();
        for row in &self.rows {
            if !methods.contains(&row.method) {
                methods.push(row.method);
            }
        }
        methods
    }

    /// Whether lookat was right each time, and as exact as `case` asks.
    pub fn passes(&self, case: &Case) -> bool {
        let mut own = self.rows.iter().filter(|row| row.method == LOOKAT).peekable();
        own.peek().is_some()
            && own.all(|row| {
                row.tried > 0 && row.failed == 0 && row.worst.is_none_or(|worst| worst <= case.limit)
            })
    }
}
