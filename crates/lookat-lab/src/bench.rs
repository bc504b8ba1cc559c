//! How fast lookat is on the machine at hand: tracing, reading, rendering, and what each feature and each stage costs.
//!
//! Each number is a median of rounds in which all things that are compared are measured in turn, so that what disturbs the
//! machine disturbs them alike.

mod features;
mod meshes;
mod profile;
mod reading;
mod rendering;
mod table;
mod tracing;

pub use table::{BenchRow, BenchTable, Cell, Machine};

/// What can be measured on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Suite {
    /// Single rays, and building trees.
    Tracing,
    /// Meshes from files.
    Reading,
    /// Whole pictures.
    Rendering,
    /// One picture with one thing more at a time.
    Features,
    /// The stages of a rendering.
    Profile,
}

impl Suite {
    /// All of them, in order.
    pub const ALL: [Suite; 5] =
        [Suite::Tracing, Suite::Reading, Suite::Rendering, Suite::Features, Suite::Profile];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Suite::Tracing => "tracing",
            Suite::Reading => "reading",
            Suite::Rendering => "rendering",
            Suite::Features => "features",
            Suite::Profile => "profile",
        }
    }

    /// Measures it in so many rounds, at least 1.
    pub fn measure(self, rounds: usize) -> Vec<BenchTable> {
        match self {
            Suite::Tracing => tracing::tables(rounds),
            Suite::Reading => vec![reading::table(rounds)],
            Suite::Rendering => vec![rendering::table(rounds)],
            Suite::Features => vec![features::table(rounds)],
            Suite::Profile => profile::tables(rounds),
        }
    }
}
