//! How fast lookat is on the machine at hand: tracing, reading, rendering, and what each feature costs.
//!
//! Each number is a median of rounds in which all things that are compared are measured in turn, so that what disturbs the
//! machine disturbs them alike.

mod features;
mod meshes;
mod reading;
mod rendering;
mod table;
mod tracing;

pub use table::{Cell, Machine, Row, Table};

/// What can be measured on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Single rays, and building trees.
    Tracing,
    /// Meshes from files.
    Reading,
    /// Whole pictures.
    Rendering,
    /// One picture with one thing more at a time.
    Features,
}

impl Part {
    /// All of them, in order.
    pub const ALL: [Part; 4] = [Part::Tracing, Part::Reading, Part::Rendering, Part::Features];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Part::Tracing => "tracing",
            Part::Reading => "reading",
            Part::Rendering => "rendering",
            Part::Features => "features",
        }
    }

    /// Measures it in so many rounds, at least 1.
    pub fn measure(self, rounds: usize) -> Vec<Table> {
        match self {
            Part::Tracing => tracing::tables(rounds),
            Part::Reading => vec![reading::table(rounds)],
            Part::Rendering => vec![rendering::table(rounds)],
            Part::Features => vec![features::table(rounds)],
        }
    }
}
