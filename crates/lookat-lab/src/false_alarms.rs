//! Pairs of renders of the same scene with different seeds: how often are they said to differ?

use clap::Args;
use lookat_image::{Aligned, Image, agreement, align};
use lookat_lab::interval::interval;
use lookat_scene::Overrides;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::pictures::{render, scene};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// Pairs of pictures of each scene
    #[arg(long, default_value_t = 200)]
    pairs: u64,
    /// Samples per pixel
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Samples per pixel of the second picture
    #[arg(long, default_value_t = 64)]
    reference_spp: u32,
    /// Take the second picture as one without error layers
    #[arg(long)]
    unknown: bool,
    /// Pixels on the longer side
    #[arg(long, default_value_t = 64)]
    size: u32,
    /// Scenes of pbrt-scenes
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "furnace,seed-perspective,cornell-matte,cornell-specular,filter-mitchell,filter-sinc"
    )]
    scenes: Vec<String>,
}

/// The nominal rate of false alarms.
const SIGNIFICANCE: f64 = 0.01;

/// What is counted.
#[derive(Default)]
struct Alarms {
    pairs: u64,
    by_agreement: u64,
    by_any_pixel: u64,
}

/// Prints the table.
pub fn run(options: &Options) {
    println!("False alarms at 1 %, {} against {} samples per pixel", options.spp, options.reference_spp);
    println!("| scene | pairs | lookat | 95 % interval | z-test of any pixel |");
    println!("|---|---|---|---|---|");
    for name in &options.scenes {
        let alarms = count(name, options);
        let percent = |count: u64| 100.0 * count as f64 / alarms.pairs as f64;
        let [low, high] = interval(alarms.by_agreement, alarms.pairs).map(|share| 100.0 * share);
        println!(
            "| {name} | {} | {:.1} % | {low:.1} to {high:.1} % | {:.1} % |",
            alarms.pairs,
            percent(alarms.by_agreement),
            percent(alarms.by_any_pixel)
        );
    }
}

fn count(name: &str, options: &Options) -> Alarms {
    let overrides = |spp| Overrides {
        samples_per_pixel: Some(spp),
        resolution: Some([options.size, options.size]),
        ..Overrides::default()
    };
    let [first, second] =
        [options.spp, options.reference_spp].map(|spp| scene(name, &overrides(spp), &|text| text));
    let mut alarms = Alarms::default();
    for pair in 0..options.pairs {
        let (actual, mut expected) = (render(&first, 2 * pair), render(&second, 2 * pair + 1));
        if options.unknown {
            expected = without_errors(expected);
        }
        let pair = align(&actual, &expected).expect("they have one size");
        let found = agreement(&pair).expect("there are samples enough");
        alarms.pairs += 1;
        alarms.by_agreement += u64::from(!found.holds(SIGNIFICANCE));
        alarms.by_any_pixel += u64::from(any_pixel_differs(&pair));
    }
    alarms
}

fn without_errors(mut image: Image) -> Image {
    image.channels.truncate(3);
    image
}

/// What is often done: each pixel by a z-test, at a level that is divided by their number.
fn any_pixel_differs(pair: &Aligned) -> bool {
    let Some(actual) = &pair.actual_errors else { return false };
    let expected = pair.expected_errors.as_ref().unwrap_or(actual);
    let tests = 3 * pair.actual.len();
    let limit = -Normal::standard().inverse_cdf(SIGNIFICANCE / (2 * tests) as f64);
    (0..tests).any(|i| {
        let (pixel, channel) = (i / 3, i % 3);
        let variance = |error: f32| f64::from(error).powi(2);
        let noise = variance(actual[pixel].standard_error[channel])
            + variance(expected[pixel].standard_error[channel]);
        let difference = f64::from(pair.actual[pixel][channel]) - f64::from(pair.expected[pixel][channel]);
        difference.abs() > limit * noise.sqrt() && difference.abs() > 1e-6
    })
}
