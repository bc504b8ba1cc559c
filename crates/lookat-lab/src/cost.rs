//! What exactness costs: rendering by `f32` and `f64` together, against either alone, in turn.

use std::time::Instant;

use clap::Args;
use lookat_render::{Precision, Settings};
use lookat_scene::{Overrides, Scene};

use crate::pictures::{names, scene};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// Renders of each scene by each precision, of which the fastest counts
    #[arg(long, default_value_t = 5)]
    rounds: u32,
    /// Samples per pixel
    #[arg(long, default_value_t = 256)]
    spp: u32,
}

const PRECISIONS: [Precision; 3] = [Precision::Mixed, Precision::Single, Precision::Double];

/// Prints the table.
pub fn run(options: &Options) {
    let Options { spp, rounds } = options;
    println!("Time to render with one thread at {spp} samples per pixel, fastest of {rounds}");
    println!("| scene | lookat | in f32, by textbook | ratio | in f64 | ratio |");
    println!("|---|---|---|---|---|---|");
    let mut logarithms = [0.0; 3];
    let names = names();
    for name in &names {
        let overrides = Overrides { samples_per_pixel: Some(*spp), ..Overrides::default() };
        let scene = scene(name, &overrides, &|text| text);
        let mut best = [f64::INFINITY; 3];
        for _ in 0..*rounds {
            for (best, precision) in best.iter_mut().zip(PRECISIONS) {
                *best = best.min(seconds(&scene, precision));
            }
        }
        let ratios = best.map(|other| best[0] / other);
        let [own, single, double] = best;
        println!(
            "| {name} | {own:.3} s | {single:.3} s | {:.3} | {double:.3} s | {:.3} |",
            ratios[1], ratios[2]
        );
        for (sum, ratio) in logarithms.iter_mut().zip(ratios) {
            *sum += ratio.ln();
        }
    }
    let [_, single, double] = logarithms.map(|sum| (sum / names.len() as f64).exp());
    println!("| geometric mean | | | {single:.3} | | {double:.3} |");
}

fn seconds(scene: &Scene, precision: Precision) -> f64 {
    let settings = Settings { threads: 1, precision, ..Settings::default() };
    let started = Instant::now();
    lookat_render::render(scene, &settings, &|_| std::ops::ControlFlow::Continue(()));
    started.elapsed().as_secs_f64()
}
