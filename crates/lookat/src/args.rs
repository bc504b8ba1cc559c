//! The command line.

mod charting;
mod numbers;
mod options;
mod rendering;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use lookat_image::{Limit, Metric};
use lookat_render::{Layers, Part, StopOptions};
use lookat_scene::MAX_SAMPLES;

pub use crate::args::charting::{Chart, Other};
use crate::args::numbers::{named, number_in, resolution, stops, whole};
pub use crate::args::options::{Memory, Tone, ViewOverride, Writing, raise_limit, way_out};
use crate::args::rendering::focus_place;
pub use crate::args::rendering::{Animation, FocusPlace, Frames, LiveView, Parameter, Protocol};
use crate::failure::Failure;

/// The parsed command line.
#[derive(Debug, Parser)]
#[command(name = "lookat", version = env!("LOOKAT_VERSION"))]
#[command(
    about = "Renders pbrt-v3 scene files and reports their problems",
    after_help = "Exit status: 0 success, or a result despite errors with --keep-going; 1 a scene has errors; 2 wrong usage or another failure; 130 interrupted"
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a picture
    Render(Box<Render>),
    /// Show a scene in the browser, interactively, while you edit its file
    View(View),
    /// Report the errors and warnings of scene files, without rendering
    Check(Check),
    /// Measure the difference between two pictures
    Compare(Compare),
    /// Go on with a rendering that was broken off, from its checkpoint
    Resume(Resume),
    /// Add up the parts of a rendering
    Merge(Merge),
    /// Print a script that renders a scene in parts on many machines, and merges them
    Farm(Farm),
    /// Write a picture in another format, with exposure, tone curve, crop window or layer
    Convert(Convert),
    /// Render the scenes of a folder and compare them with their reference pictures
    Verify(Verify),
    /// Chart error against render time for several methods
    Chart(Chart),
    /// Run numerical stability cases in which common ray tracing methods fail
    Stability(Stability),
    /// Show the size, features and cost of a scene
    Inspect(Inspect),
    /// Explain a directive, a type or a parameter of the format
    Explain(Explain),
}

impl Command {
    /// The number of threads in the command line, if given.
    pub fn threads(&self) -> Option<u16> {
        match self {
            Command::Render(render) => render.threads,
            Command::Resume(resume) => resume.threads,
            Command::View(View { threads, .. })
            | Command::Verify(Verify { threads, .. })
            | Command::Chart(Chart { threads, .. }) => *threads,
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Args)]
pub struct Render {
    /// Scene files; - is standard input
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// The picture file: .exr, .png, .pfm or .tga; with several scenes, a folder [default: the filename of Film; before its extension, --quick adds .quick, and --part adds .part-I-of-N]
    #[arg(short, long, visible_alias = "outfile", value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Samples per pixel, instead of the number in Sampler. With --target-error or --time, the maximum; with
    /// --adaptive, the mean
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(1, MAX_SAMPLES))]
    pub spp: Option<u32>,
    /// Sample each pixel until its error is at most this fraction of its brightness, such as 0.05, with at most
    /// --spp samples (65536 without --spp)
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = number_in(StopOptions::TARGET_ERROR, "a number from 0.000001 to 1, as in 0.05 for 5 %"))]
    pub target_error: Option<f64>,
    /// Confidence level of --target-error for each pixel [default: 0.95]
    #[arg(long, value_name = "SHARE", requires = "target_error", conflicts_with = "adaptive", allow_negative_numbers = true, value_parser = number_in(StopOptions::CONFIDENCE, "a number from 0.5 to 0.999999, as in 0.95 for 95 %"))]
    pub confidence: Option<f64>,
    /// Add samples to the whole picture for this long, or until it reaches --target-error or --spp
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub time: Option<Duration>,
    /// Take more samples in noisy pixels and fewer in others; the average stays about the same
    #[arg(long, conflicts_with_all = ["target_error", "error_layers"])]
    pub adaptive: bool,
    /// Take only the I-th of N equal parts of the samples, counted from 0. `lookat merge` adds parts up to the picture of one rendering
    #[arg(long, value_name = "I/N", allow_hyphen_values = true, conflicts_with_all = ["target_error", "time", "adaptive", "watch"], value_parser = part)]
    pub part: Option<Part>,
    /// Keep the exact sums of the samples in the .exr file, so that --more can add samples. The patterns of pixels and the filtering of textures then
    /// do not depend on --spp
    #[arg(long, conflicts_with_all = ["time", "part", "turntable", "animate"])]
    pub keep_sums: bool,
    /// Add so many samples per pixel to the picture, which --keep-sums or --more has written before: 64 and then 64 more are the bits of 128. With
    /// --target-error, raise the maximum by so many
    #[arg(long, value_name = "N", conflicts_with_all = ["spp", "quick", "time", "part", "turntable", "animate", "watch"], allow_negative_numbers = true, value_parser = whole(1, MAX_SAMPLES))]
    pub more: Option<u32>,
    /// Also write the samples so far to this .exr file every now and then, and when interrupted. `lookat resume` goes on from there
    #[arg(long, value_name = "FILE", conflicts_with_all = ["time", "turntable", "animate", "watch"])]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between two checkpoints [default: 60]
    #[arg(long, value_name = "SECONDS", requires = "checkpoint", allow_negative_numbers = true, value_parser = seconds)]
    pub every: Option<Duration>,
    /// Size of the full picture, instead of the size in Film
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = resolution)]
    pub resolution: Option<[u32; 2]>,
    /// The part to render, in fractions from 0 to 1, instead of the cropwindow of Film
    #[arg(long, visible_alias = "cropwindow", num_args = 4, allow_negative_numbers = true, value_names = ["X0", "X1", "Y0", "Y1"], value_parser = number_in(0.0..=1.0, "a number from 0 to 1"))]
    pub crop: Option<Vec<f64>>,
    /// Number of threads [default: one per processor]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    /// Seed of the random numbers: the same seed gives the same picture
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole(0, u64::MAX))]
    pub seed: u64,
    /// Render a draft: a quarter of the width and height unless --resolution is given, one sample per pixel unless --spp is given. Without -o, the name
    /// of the picture gets .quick before its extension, so that the draft does not replace a finished picture
    #[arg(long, conflicts_with_all = ["target_error", "confidence", "time", "adaptive"])]
    pub quick: bool,
    /// Also write the standard error and the number of samples of each pixel, as layers of the EXR file. This makes
    /// the picture slightly noisier; use at least 16 samples per pixel
    #[arg(long)]
    pub error_layers: bool,
    /// Also write layers into the EXR file: depth, position, normal, shading-normal, uv, albedo, shape, material or
    /// samples; or denoise, the layers for Open Image Denoise
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = layers)]
    pub layers: Vec<Layers>,
    #[command(flatten)]
    pub tone: Tone,
    /// Replace a picture that is larger, has more samples, or comes from another program
    #[arg(long)]
    pub force: bool,
    /// Focus the lens on what a pixel shows: its position, as in 120,80, or fractions of the picture's size, as in 0.5,0.5
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, conflicts_with = "focal_distance", value_parser = focus_place)]
    pub focus: Option<FocusPlace>,
    #[command(flatten)]
    pub view: ViewOverride,
    #[command(flatten)]
    pub frames: Frames,
    #[command(flatten)]
    pub live: LiveView,
    /// Print only errors and interruptions
    #[arg(short, long)]
    pub quiet: bool,
    /// Skip directives with errors and continue
    #[arg(long)]
    pub keep_going: bool,
    #[command(flatten)]
    pub memory: Memory,
    #[command(flatten)]
    pub report: Report,
}

impl Render {
    /// True if samples may be added to the picture later.
    pub fn is_extendable(&self) -> bool {
        self.keep_sums || self.more.is_some()
    }

    /// The view of the first picture. An animated radius is at its largest here, because a pinhole has no focal distance.
    pub fn first_view(&self) -> ViewOverride {
        let mut view = self.view;
        if let Some(Animation { parameter, from, to }) = self.frames.animate {
            let value = if parameter == Parameter::LensRadius { from.max(to) } else { from };
            parameter.set(value, &mut view);
        }
        view
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Without arguments, it lists all directives and types. Other words are looked up in all directives: a type, a parameter, or a name from another renderer or from photography, as in `lookat explain depth of field`."
)]
pub struct Explain {
    /// A directive, such as Camera, or any other word of the format
    pub directive: Option<String>,
    /// One of its types, such as perspective
    #[arg(value_name = "TYPE")]
    pub kind: Option<String>,
    /// One of the parameters, such as fov
    pub parameter: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct Inspect {
    /// The scene file; - is standard input
    pub scene: PathBuf,
    #[command(flatten)]
    pub view: ViewOverride,
    /// Draw the lenses of a realistic camera, with rays, pupil and principal planes, into this SVG file
    #[arg(long, value_name = "FILE")]
    pub lens: Option<PathBuf>,
    /// Skip directives with errors and continue
    #[arg(long)]
    pub keep_going: bool,
    #[command(flatten)]
    pub memory: Memory,
    #[command(flatten)]
    pub report: Report,
}

#[derive(Debug, Args)]
#[command(after_help = "Exit status: 0 all cases pass; 1 a case fails; 2 wrong usage or another failure")]
pub struct Stability {
    /// Run only these cases: a name such as S1 or far-sphere, or the letter of a family. Families: C (camera), S (spheres and quadrics), T (triangles), P (coplanar eyes and lights), V (traversal and pictures) or B (scattering and lights)
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub case: Vec<String>,
    /// Random rays per row of a case, at least 1000
    #[arg(long, value_name = "N", default_value_t = 100_000, allow_negative_numbers = true, value_parser = rays)]
    pub rays: u64,
    /// Write the results to this folder: stability.csv, stability.json
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print one JSON array
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct Check {
    /// Scene files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Show errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Read only the headers of meshes, and no pictures
    #[arg(long)]
    pub fast: bool,
    /// Also warn about what the picture shows: a camera inside a shape, nothing in view, nothing sharp, lights without effect
    #[arg(long, conflicts_with = "fast")]
    pub view: bool,
    #[command(flatten)]
    pub camera: ViewOverride,
    #[command(flatten)]
    pub memory: Memory,
    #[command(flatten)]
    pub report: Report,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Exit status: 0 within all limits; 1 a limit is exceeded or a pixel is not finite; 2 the pictures cannot be compared, or noise-p is undecided"
)]
pub struct Compare {
    /// The picture to test: .exr, .pfm, .png, .tga, .jpg or .hdr
    pub actual: PathBuf,
    /// The reference picture
    pub expected: PathBuf,
    /// Limit of a metric, such as rmse=0.01: a maximum, or a minimum for psnr, ssim and noise-p
    #[arg(long, value_name = "METRIC=VALUE", value_parser = limit)]
    pub max: Vec<Limit>,
    /// Compare this layer, part or channel of the EXR files, by its name there or in render --layers; of uv, choose uv.U or uv.V
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Compute only these metrics, such as rmse or flip; an unknown name lists all
    #[arg(long, value_name = "METRIC", value_delimiter = ',', value_parser = metric)]
    pub only: Vec<Metric>,
    /// Also write a .png file with both pictures and their difference in false color
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// Exposure of --picture in stops [default: chosen from the expected picture]
    #[arg(long, value_name = "STOPS", requires = "picture", allow_negative_numbers = true, value_parser = stops)]
    pub exposure: Option<f64>,
    /// The smallest channel difference that share-above counts
    #[arg(long, value_name = "VALUE", default_value_t = lookat_image::THRESHOLD, allow_negative_numbers = true, value_parser = number_in(0.0..=f32::MAX, "a number that is not negative"))]
    pub threshold: f32,
    #[command(flatten)]
    pub memory: Memory,
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct Convert {
    /// The picture to read: .exr, .pfm, .png, .tga, .jpg or .hdr
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// The picture to write: .exr, .png, .pfm or .tga
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// The part to write, in fractions of the full picture from 0 to 1
    #[arg(long, num_args = 4, allow_negative_numbers = true, value_names = ["X0", "X1", "Y0", "Y1"], value_parser = number_in(0.0..=1.0, "a number from 0 to 1"))]
    pub crop: Option<Vec<f64>>,
    /// Convert this layer, part or channel of an EXR file, by its name there or in render --layers; of uv, choose uv.U or uv.V, or write an .exr file
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten)]
    pub writing: Writing,
}

#[derive(Debug, Args)]
#[command(
    after_help = "It repeats the command that was broken off, in the folder where it was started, or here if the scene is not there. The picture has the bits of a rendering without a break.\n\nExit status: 66 there is no checkpoint, or none that is whole; otherwise as lookat render"
)]
pub struct Resume {
    /// The checkpoint, from `lookat render --checkpoint`
    pub file: PathBuf,
    /// The picture file [default: that of the command]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Number of threads [default: that of the command]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    /// Replace a picture that is larger, has more samples, or comes from another program
    #[arg(long)]
    pub force: bool,
    /// Print only errors and interruptions
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
#[command(
    after_help = "All parts of a rendering, in any order, give the file that `lookat render` writes without --part, to the bit."
)]
pub struct Merge {
    /// The parts, from `lookat render --part`, or from --partial
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// The picture to write: .exr, .png, .pfm or .tga; with --partial, .exr
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Add up what there is, though parts are missing. The result is a part: it can be merged with the others
    #[arg(long)]
    pub partial: bool,
    #[command(flatten)]
    pub writing: Writing,
}

#[derive(Debug, Args)]
#[command(
    after_help = "Send the script to a shell where the engine's programs are:\n\n    lookat farm slurm scene.pbrt --parts 16 -o scene.exr -- --spp 4096 | sh"
)]
pub struct Farm {
    /// The engine that runs the jobs
    pub engine: Engine,
    /// The scene file, in a folder that all machines see
    pub scene: PathBuf,
    /// Number of parts of the picture. Pictures of lookat render --turntable or --animate are shared out one by one instead
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(1, MOST_PARTS))]
    pub parts: Option<u32>,
    /// The picture file, in a folder that all machines see; the parts go to a folder beside it
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Options of lookat render
    #[arg(last = true, value_name = "OPTION")]
    pub options: Vec<String>,
}

/// An engine that runs jobs.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Engine {
    /// Slurm: a job array, and a job that waits for it
    Slurm,
}

#[derive(Debug, Args)]
#[command(
    after_help = "A scene agrees if it is within all limits of --max. Without --max, it agrees if noise explains every difference from its reference. The column \"detectable\" shows the smallest bias of the mean that this test detects.\n\nExit status: 0 all agree; 1 one differs, or a reference was written; 2 a scene or reference cannot be read or compared, or a scene is undecided"
)]
pub struct Verify {
    /// The folder with the scenes. The reference of a.pbrt is a.exr, .pfm, .hdr, .png, .tga or .jpg
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Limit of a metric, such as rmse=0.01: a maximum, or a minimum for psnr, ssim and noise-p
    #[arg(long, value_name = "METRIC=VALUE", value_parser = limit)]
    pub max: Vec<Limit>,
    /// Samples per pixel, instead of the numbers in the scenes
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(1, MAX_SAMPLES))]
    pub spp: Option<u32>,
    /// Number of threads [default: one per processor]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = whole(0, u64::MAX))]
    pub seed: u64,
    /// Also write an .html file with results and pictures
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Write the new render over each reference that differs, and write missing references
    #[arg(long)]
    pub update: bool,
    #[command(flatten)]
    pub memory: Memory,
    /// Print the results as JSON, one line per scene
    #[arg(long)]
    pub json: bool,
}

fn metric(text: &str) -> Result<Metric, Failure> {
    named(Metric::from_name(text), "metrics", Metric::names())
}

/// The most parts of a rendering.
pub const MOST_PARTS: u32 = 1_000_000;

fn part(text: &str) -> Result<Part, Failure> {
    let numbers = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
    match numbers {
        Some((index, of)) if index < of && of <= MOST_PARTS => Ok(Part { index, of }),
        Some((index, of)) if index == of && (1..=MOST_PARTS).contains(&of) => {
            Err(format!("parts are counted from 0: of {of}, the last one is {}/{of}", of - 1).into())
        }
        _ => Err(format!("expected I/N with I from 0 to N-1, and N at most {MOST_PARTS}, as in 0/4").into()),
    }
}

fn layers(text: &str) -> Result<Layers, Failure> {
    named(Layers::named(text), "layers", Layers::names())
}

fn limit(text: &str) -> Result<Limit, Failure> {
    let (name, value) = text.split_once('=').ok_or("expected METRIC=VALUE, as in rmse=0.01")?;
    let value: f64 = value.parse().map_err(|_| format!("`{value}` is not a number"))?;
    if value.is_nan() {
        bail!("the limit must be a number");
    }
    let metric = metric(name)?;
    if metric == Metric::NoiseP && !(value > 0.0 && value < 1.0) {
        bail!("noise-p is a probability: use a limit above 0 and below 1");
    }
    if value < 0.0 && !metric.is_likeness() {
        bail!("the limit of {name} must be at least 0");
    }
    Ok(Limit { metric, value })
}

/// The reporting options for problems in scene files.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Report {
    /// Treat warnings as errors
    #[arg(long)]
    pub strict: bool,
    /// Print problems and results as JSON to standard output, one line per scene
    #[arg(long)]
    pub json: bool,
}

fn seconds(text: &str) -> Result<Duration, Failure> {
    number_in(StopOptions::SECONDS, "seconds, from 0.001 to 1e8")(text).map(Duration::from_secs_f64)
}

fn rays(text: &str) -> Result<u64, Failure> {
    // With fewer rays, a case may miss its limit by chance.
    let count = text.parse().ok().filter(|count: &f64| (1e3..=1e9).contains(count) && count.fract() == 0.0);
    count.map(|count| count as u64).ok_or("expected a whole number from 1000 to 1e9".into())
}

/// The edges of `--crop`: left, right, top and bottom.
pub fn crop_edges(crop: Option<&[f64]>) -> Result<Option<[f64; 4]>, Failure> {
    let edges = crop.and_then(|edges| <[f64; 4]>::try_from(edges).ok());
    match edges {
        Some([x0, x1, y0, y1]) if x0 >= x1 || y0 >= y1 => {
            Err("--crop takes the left, right, top and bottom edge, with left < right and top < bottom"
                .into())
        }
        edges => Ok(edges),
    }
}

#[derive(Debug, Args)]
#[command(
    after_help = "Only this computer can open the page, and only with the address that the command prints. Ctrl-C ends it."
)]
pub struct View {
    /// The scene file
    pub scene: PathBuf,
    /// Compare with this picture: .exr, .pfm, .png, .tga, .jpg or .hdr
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Port of the page at 127.0.0.1; 0 picks a free one
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the browser
    #[arg(long)]
    pub open: bool,
    /// Editor command for the page's links; {file}, {line} and {column} stand for the place [default: VISUAL or
    /// EDITOR, else a link to VS Code]
    #[arg(long, value_name = "COMMAND")]
    pub editor: Option<String>,
    /// Number of threads [default: one per processor]
    #[arg(long, visible_alias = "nthreads", value_name = "N", allow_negative_numbers = true, value_parser = whole(1_u16, 1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub memory: Memory,
}
