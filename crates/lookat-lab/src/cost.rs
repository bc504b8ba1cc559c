//! What exactness costs: this build against one with textbook intersections in single precision, in turn.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use clap::Args;
use lookat_scene::Overrides;

use crate::pictures::{names, render_plainly, scene};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// The other build of this program: by
    /// `cargo build --release -p lookat-lab --features plain-f32 --target-dir target/plain`
    #[arg(long, value_name = "PROGRAM", default_value = "target/plain/release/lookat-lab")]
    against: PathBuf,
    /// Renders of each scene by each build, of which the fastest counts
    #[arg(long, default_value_t = 5)]
    rounds: u32,
    /// Samples per pixel
    #[arg(long, default_value_t = 256)]
    spp: u32,
    /// Render one scene once, and print the seconds
    #[arg(long, hide = true)]
    once: Option<String>,
}

/// Prints the table.
pub fn run(options: &Options) {
    if let Some(name) = &options.once {
        println!("{}", seconds(name, options.spp));
        return;
    }
    let own = std::env::current_exe().expect("this program is somewhere");
    println!(
        "Time to render with one thread at {} samples per pixel, fastest of {}",
        options.spp, options.rounds
    );
    println!("| scene | lookat | in f32, by textbook | ratio |");
    println!("|---|---|---|---|");
    let mut logarithms = Vec::new();
    for name in names() {
        let mut best = [f64::INFINITY; 2];
        for _ in 0..options.rounds {
            for (best, program) in best.iter_mut().zip([&own, &options.against]) {
                *best = best.min(ask(program, &name, options.spp));
            }
        }
        let [own, other] = best;
        println!("| {name} | {own:.3} s | {other:.3} s | {:.3} |", own / other);
        logarithms.push((own / other).ln());
    }
    let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
    println!("| geometric mean | | | {mean:.3} |");
}

/// What a build of this program takes for a scene.
fn ask(program: &Path, name: &str, spp: u32) -> f64 {
    let output = Command::new(program).args(["cost", "--once", name, "--spp", &spp.to_string()]).output();
    let output = output.unwrap_or_else(|error| panic!("cannot run {}: {error}", program.display()));
    let text = String::from_utf8_lossy(&output.stdout);
    text.trim().parse().unwrap_or_else(|_| panic!("{} cost --once {name}: {text}", program.display()))
}

fn seconds(name: &str, spp: u32) -> f64 {
    let overrides = Overrides { samples_per_pixel: Some(spp), ..Overrides::default() };
    let scene = scene(name, &overrides, &|text| text);
    let started = Instant::now();
    render_plainly(&scene, 0, 1);
    started.elapsed().as_secs_f64()
}
