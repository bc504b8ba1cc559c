//! `lookat-lab bench`: how fast lookat is on this machine.
//!
//! Each number is a median of rounds in which all compared things are measured in turn, so that other work on the machine
//! disturbs them equally.

mod bench_table;
mod features;
mod latency;
mod meshes;
mod profile;
mod reading;
mod rendering;
mod tracing;

use std::error::Error;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::print;
use bench_table::{BenchTable, Machine};

/// The arguments of `lookat-lab bench`.
#[derive(Debug, Args)]
#[command(after_help = "Takes about a minute and a half. Other running programs disturb the measurement.")]
pub struct Bench {
    /// Measure only these parts
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<Suite>,
    /// Measure `lookat view` of these scenes instead, with copies beside them
    #[arg(long, value_name = "SCENE", num_args = 1.., conflicts_with_all = ["only", "rounds"])]
    view: Vec<PathBuf>,
    /// lookat's program for --view [default: the one beside this program]
    #[arg(long, value_name = "PATH", requires = "view")]
    lookat: Option<PathBuf>,
    /// Number of measurements; the output shows medians
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    rounds: u16,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A part of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Suite {
    /// Single rays, and building BVHs
    Tracing,
    /// Meshes from files
    Reading,
    /// Whole pictures
    Rendering,
    /// One picture with one more feature at a time
    Features,
    /// The stages of a rendering
    Profile,
}

/// All measurements.
#[derive(Serialize)]
struct Report {
    version: &'static str,
    #[serde(flatten)]
    machine: Machine,
    rounds: u16,
    tables: Vec<BenchTable>,
}

/// With fewer rounds, a measurement that other work disturbs may be the median.
const FEWEST_ROUNDS: u16 = 3;

impl Bench {
    /// Measures and prints. Fails with the reason.
    pub fn run(&self) -> Result<(), Box<dyn Error>> {
        let rounds = if self.view.is_empty() { self.rounds } else { 1 };
        let version = env!("CARGO_PKG_VERSION");
        let mut report = Report { version, machine: Machine::here(), rounds, tables: Vec::new() };
        let mut add = |tables: Vec<BenchTable>| {
            if !self.json {
                tables.iter().try_for_each(|table| print(&table.to_string()))?;
            }
            report.tables.extend(tables);
            Ok::<_, String>(())
        };
        if self.view.is_empty() {
            if !self.json {
                print(&report.machine.head(version, rounds))?;
            }
            if rounds < FEWEST_ROUNDS {
                eprintln!("ratios are noisy with fewer than {FEWEST_ROUNDS} rounds: increase --rounds");
            }
            let is_chosen = |suite: &&Suite| self.only.is_empty() || self.only.contains(suite);
            for suite in Suite::value_variants().iter().filter(is_chosen) {
                let name = suite.to_possible_value().map_or(String::new(), |value| value.get_name().into());
                eprintln!("measuring {name} ...");
                add(suite.measure(rounds.into()))?;
            }
        } else {
            add(vec![latency::latency(&crate::lookat_program(self.lookat.as_deref())?, &self.view)?])?;
        }
        if self.json {
            print(&(serde_json::to_string(&report)? + "\n"))?;
        }
        Ok(())
    }
}

impl Suite {
    /// The tables of this part, over at least one round.
    fn measure(self, rounds: usize) -> Vec<BenchTable> {
        match self {
            Suite::Tracing => tracing::tables(rounds),
            Suite::Reading => vec![reading::table(rounds)],
            Suite::Rendering => vec![rendering::table(rounds)],
            Suite::Features => vec![features::table(rounds)],
            Suite::Profile => profile::tables(rounds),
        }
    }
}
