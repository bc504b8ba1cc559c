//! Renders of a scene with one material 1 % too bright, against the right one: how often is it found?

use clap::Args;
use lookat_image::{Image, agreement, align, mean};
use lookat_scene::Overrides;

use crate::pictures::{render, scene};
use lookat_lab::interval::interval;

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// Pairs of pictures for each material
    #[arg(long, default_value_t = 20)]
    pairs: u64,
    /// Samples per pixel of both
    #[arg(long, default_value_t = 256)]
    spp: u32,
}

/// The materials of cornell-matte: what its file says, and the same 1 % brighter.
const CHANGES: [(&str, &str, &str); 4] = [
    ("none", "", ""),
    ("white", "[0.7 0.7 0.7]\n", "[0.707 0.707 0.707]\n"),
    ("red", "[0.63 0.06 0.05]", "[0.6363 0.0606 0.0505]"),
    ("green", "[0.14 0.45 0.09]", "[0.1414 0.4545 0.0909]"),
];
const SCENE: &str = "cornell-matte";
const SIGNIFICANCE: f64 = 0.01;

/// Prints the table.
pub fn run(options: &Options) {
    let overrides = Overrides { samples_per_pixel: Some(options.spp), ..Overrides::default() };
    let right = scene(SCENE, &overrides, &|text| text);
    let references: Vec<Image> = (0..options.pairs).map(|seed| render(&right, seed)).collect();
    println!("{SCENE} with one material 1 % brighter, {} samples per pixel, significance 0.01", options.spp);
    println!("| material | mean of the picture | found | 95 % interval | median p |");
    println!("|---|---|---|---|---|");
    for (material, from, to) in CHANGES {
        let changed = scene(SCENE, &overrides, &|text| {
            assert!(text.contains(from), "{SCENE} has changed");
            if from.is_empty() { text } else { text.replace(from, to) }
        });
        let (mut values, mut change) = (Vec::new(), 0.0);
        for (seed, reference) in references.iter().enumerate() {
            let Ok(pair) = align(&render(&changed, 1_000_000 + seed as u64), reference) else { continue };
            change += lookat_image::means(&pair.actual, &pair.expected).error / mean(&pair.expected);
            values.extend(agreement(&pair).map(|found| found.p));
        }
        values.sort_by(f64::total_cmp);
        let pairs = values.len() as u64;
        let found = values.iter().filter(|p| **p < SIGNIFICANCE).count() as u64;
        let [low, high] = interval(found, pairs).map(|share| 100.0 * share);
        let change = 100.0 * change / pairs as f64;
        let median = values[values.len() / 2];
        println!(
            "| {material} | {change:+.2} % | {found} of {pairs} | {low:.0} to {high:.0} % | {median:.1e} |"
        );
    }
}
