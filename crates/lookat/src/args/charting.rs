//! The arguments of `lookat chart`.

use std::path::PathBuf;

use clap::Args;
use lookat_lab::chart::FEWEST_SEEDS;

use crate::args::numbers::{number_in, resolution, whole};
use crate::args::options::Memory;
use crate::failure::Failure;

#[derive(Debug, Args)]
#[command(
    after_help = after_help()
)]
pub struct Chart {
    /// The scene file; - is standard input
    pub scene: PathBuf,
    /// The reference picture: .exr, .pfm or .hdr, or an unclipped .png, .tga or .jpg [default: a render with 16 times
    /// the samples of the last point]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Methods from the list below, or all; the first one is the baseline
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = lookat_lab::chart::DEFAULT)]
    pub methods: Vec<String>,
    /// Wall time of the whole command; it determines the numbers of samples
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, allow_negative_numbers = true, value_parser = seconds)]
    pub budget: f64,
    /// Largest number of samples per pixel, instead of a budget: a power of two from 4 to 65536
    #[arg(long, value_name = "N", conflicts_with = "budget", allow_negative_numbers = true, value_parser = power_of_two)]
    pub spp: Option<u32>,
    /// The result of another renderer: its name, wall time and picture of the scene; repeatable
    #[arg(long, value_name = "NAME=SECONDS,IMAGE", value_parser = other)]
    pub point: Vec<Other>,
    /// Size of the full picture, instead of the size in Film
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = resolution)]
    pub resolution: Option<[u32; 2]>,
    /// Pictures per point, each with another seed; at least 8
    #[arg(long, value_name = "N", default_value_t = 8, allow_negative_numbers = true, value_parser = whole(FEWEST_SEEDS, 1000))]
    pub seeds: u32,
    /// Seed of the first picture; the other pictures use the following seeds
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole(0, u64::MAX))]
    pub seed: u64,
    /// Number of threads [default: one per processor]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    /// The output folder, created if missing [default: SCENE-chart in the working folder]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub memory: Memory,
}

/// The result of another renderer, from `--point`.
#[derive(Debug, Clone)]
pub struct Other {
    /// The name of the renderer.
    pub name: String,
    /// The wall time in seconds.
    pub seconds: f64,
    /// The file of its picture.
    pub image: PathBuf,
}

/// The methods and the output files, for the help.
fn after_help() -> String {
    let methods = lookat_lab::chart::METHODS.iter();
    let list: String = methods.map(|method| format!("  {:13} {}\n", method.name, method.about)).collect();
    format!(
        "Methods:\n{list}\nEach method renders the scene several times with 1, 2, 4, ... samples per pixel; adaptive begins with 8; \
         target-error begins with 64, and its target error is 12.5 % at the first point and 1.4 times smaller at each further point. adaptive and target-error have at least three points, \
         even with a small --spp. \
         The results are written to DIR: chart.svg, chart.png, chart.csv, chart.json.\n\n\
         Exit status: 0 success; 1 the scene has errors; 2 wrong usage or another failure; 130 interrupted, with a chart of the measurements so far"
    )
}

fn seconds(text: &str) -> Result<f64, Failure> {
    number_in(1e-9..=1e7, "a number of seconds, from 1e-9 to 1e7")(text)
}

fn power_of_two(text: &str) -> Result<u32, Failure> {
    let is_allowed = |count: &u32| count.is_power_of_two() && (4..=1 << 16).contains(count);
    text.parse().ok().filter(is_allowed).ok_or("expected a power of two from 4 to 65536".into())
}

/// The longest name that fits beside the chart.
const LONGEST_NAME: usize = 40;

fn other(text: &str) -> Result<Other, Failure> {
    const EXPECTED: &str = "expected NAME=SECONDS,IMAGE, as in pbrt=3.8,pbrt.exr";
    let (name, rest) = text.split_once('=').ok_or(EXPECTED)?;
    let (time, image) = rest.split_once(',').ok_or(EXPECTED)?;
    if name.is_empty() || image.is_empty() || name.chars().any(char::is_control) {
        bail!("{EXPECTED}");
    }
    if name.chars().count() > LONGEST_NAME {
        bail!("the name of a point must have at most {LONGEST_NAME} letters");
    }
    let seconds =
        seconds(time).map_err(|error| format!("`{time}`, between the first = and a comma: {error}"))?;
    Ok(Other { name: name.into(), seconds, image: image.into() })
}
