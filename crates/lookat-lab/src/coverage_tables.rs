//! How often pixels are as exact as a target error says.

use clap::Args;
use lookat_lab::coverage::{
    Judged, Known, RULES, STRATA, Stratum, Target, edges, fireflies, judge, lens, plain, rule_pixels, tinted,
    wall,
};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// The target error
    #[arg(long, default_value_t = 0.05)]
    target_error: f64,
    /// Its probability
    #[arg(long, default_value_t = 0.95)]
    confidence: f64,
    /// The most samples of a pixel
    #[arg(long, default_value_t = 65_536)]
    spp: u32,
    /// Pixels on a side
    #[arg(long, default_value_t = 100)]
    side: u32,
    /// Pictures of each scene
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// Leave out the rules of others
    #[arg(long)]
    own: bool,
}

/// Prints the tables.
pub fn run(options: &Options) {
    let target =
        Target { relative: options.target_error, confidence: options.confidence, max_samples: options.spp };
    println!(
        "Target error {}, confidence {}, at most {} samples, {} pictures of {} x {} pixels",
        target.relative, target.confidence, target.max_samples, options.seeds, options.side, options.side
    );
    println!(
        "| scene | pixels | at the cap | within | lower 99 % bound | bias / target | samples | independent |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for make in [edges, tinted, lens, wall, plain, fireflies] {
        let known = make(options.side);
        let (mut pixels, mut outliers) = (Vec::new(), 0);
        for seed in 0..options.seeds {
            let (judged, reached) = judge(&known, &target, seed);
            outliers += reached.outliers;
            pixels.extend(judged);
        }
        rows(&known, known.name, &pixels, target.max_samples);
        if outliers > 0 {
            println!("| {}: {outliers} pixels with outliers | | | | | | | |", known.name);
        }
    }
    if !options.own {
        others(options, &target);
    }
}

/// A line for each stratum that has pixels.
fn rows(known: &Known, name: &str, pixels: &[Judged], cap: u32) {
    if known.deviations.iter().all(|deviation| *deviation == known.deviations[0]) {
        return row(name, &Stratum::count(pixels, cap, |_| true));
    }
    for [from, to] in STRATA {
        let cut = Stratum::count(pixels, cap, |pixel| pixel.value > from && pixel.value < to);
        if cut.pixels > 0 {
            row(&format!("{name}, {from} to {to}"), &cut);
        }
    }
    row(
        &format!("{name}, not cut"),
        &Stratum::count(pixels, cap, |pixel| pixel.value <= 0.0 || pixel.value >= 1.0),
    );
}

fn row(name: &str, stratum: &Stratum) {
    let [share, low] = stratum.coverage();
    let independent =
        if stratum.independent > 1.0 { format!("{:.0}", stratum.independent) } else { "-".into() };
    println!(
        "| {name} | {} | {:.2} % | {share:.4} | {low:.4} | {:+.3} | {:.0} | {independent} |",
        stratum.pixels,
        100.0 * stratum.at_cap as f64 / stratum.pixels.max(1) as f64,
        stratum.bias,
        stratum.samples,
    );
}

/// What rules of others make of edges, with independent samples.
fn others(options: &Options, target: &Target) {
    for known in [edges(options.side), lens(options.side)] {
        for rule in RULES {
            let name = format!("{}: {}", known.name, rule.name);
            rows(&known, &name, &rule_pixels(&rule, &known, target), target.max_samples);
        }
    }
}
