//! Experiments that measure lookat: `cargo run --release -p lookat-lab -- --help`. Their results stand in docs/.

mod contact_sheet;
mod cost;
mod coverage_tables;
mod false_alarms;
mod gallery;
mod pictures;
mod power;
mod references;
mod time_left;

use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(name = "lookat-lab", about = "Experiments that measure lookat")]
struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// How often pictures of one scene, with different seeds, are said to differ
    FalseAlarms(false_alarms::Options),
    /// How often an error of 1 % in one material is found
    Power(power::Options),
    /// How often pixels are as exact as `--target-error` says
    Coverage(coverage_tables::Options),
    /// How much longer rendering takes than with textbook intersections in single precision
    Cost(cost::Options),
    /// All scenes of pbrt-scenes in one picture: docs/scenes.png, with docs/scenes.md
    ContactSheet(contact_sheet::Options),
    /// The pictures of docs/gallery.md, and that page
    Gallery(gallery::Options),
    /// How far the scenes of pbrt-scenes are from their references
    References(references::Options),
    /// How often the time left with `--target-error` is in the interval that is shown
    TimeLeft(time_left::Options),
}

fn main() {
    match Arguments::parse().experiment {
        Experiment::FalseAlarms(options) => false_alarms::run(&options),
        Experiment::Power(options) => power::run(&options),
        Experiment::Coverage(options) => coverage_tables::run(&options),
        Experiment::Cost(options) => cost::run(&options),
        Experiment::ContactSheet(options) => contact_sheet::run(&options),
        Experiment::Gallery(options) => gallery::run(&options),
        Experiment::References(options) => references::run(&options),
        Experiment::TimeLeft(options) => time_left::run(&options),
    }
}
