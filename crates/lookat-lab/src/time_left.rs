//! How often the time left is in the interval that is shown.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::Instant;

use clap::Args;
use lookat_render::{Settings, Stop, TargetError, TimeLeft, render};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// The scenes
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// The target errors; 0 for none
    #[arg(long, value_delimiter = ',', default_value = "0.05")]
    target_error: Vec<f64>,
}

/// What is said at some time.
struct Said {
    seconds: f64,
    done: u64,
    samples: [u64; 2],
    left: [f64; 2],
}

/// Prints a row for each rendering, and their sum. An interval is looked at after 1, 1.4, 2, 2.8, ... seconds.
pub fn run(options: &Options) {
    println!(
        "| scene | target | seconds | intervals | samples left inside | time left inside | upper over lower end, first and last |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut totals = [0; 3];
    for scene in &options.scenes {
        for target in &options.target_error {
            let counts = row(scene, *target);
            totals = [0, 1, 2].map(|i| totals[i] + counts[i]);
        }
    }
    let [said, samples, times] = totals;
    println!("{said} intervals, {samples} with the samples left, {times} with the time left");
}

fn row(path: &std::path::Path, relative: f64) -> [usize; 3] {
    let scene =
        lookat_scene::load(path, &|path| std::fs::read(path), &Default::default()).scene.expect("a scene");
    let target = TargetError { relative, confidence: 0.95 };
    let (max_samples, limit) = (Stop::MOST_WITH_ERROR, None);
    let stop = match relative > 0.0 {
        true => Stop::Error { target, max_samples, limit, error_layers: false },
        false => Stop::default(),
    };
    let settings = Settings { stop, ..Settings::default() };
    let state = Mutex::new((None::<Instant>, TimeLeft::new(), 1.0, Vec::new()));
    let rendered = render(&scene, &settings, &|progress| {
        let mut state = state.lock().expect("a lock");
        let (started, left, next, said) = &mut *state;
        let seconds = started.get_or_insert_with(Instant::now).elapsed().as_secs_f64();
        if let (Some(left), Some(samples)) = (left.update(&progress), progress.left)
            && seconds >= *next
        {
            *next = seconds * std::f64::consts::SQRT_2;
            said.push(Said { seconds, done: progress.done, samples, left });
        }
        ControlFlow::Continue(())
    });
    let (started, _, _, said) = state.into_inner().expect("a lock");
    let seconds = started.map_or(0.0, |started| started.elapsed().as_secs_f64());
    let samples = rendered.statistics.samples;
    let is_right = |said: &&Said| (said.samples[0]..=said.samples[1]).contains(&(samples - said.done));
    let is_in_time = |said: &&Said| (said.left[0]..=said.left[1]).contains(&(seconds - said.seconds));
    let counts = [said.len(), said.iter().filter(is_right).count(), said.iter().filter(is_in_time).count()];
    let ratio = |said: Option<&Said>| said.map_or(f64::NAN, |said| said.left[1] / said.left[0]);
    println!(
        "| {} | {relative} | {seconds:.1} | {} | {} | {} | {:.1}, {:.1} |",
        path.display(),
        counts[0],
        counts[1],
        counts[2],
        ratio(said.first()),
        ratio(said.last())
    );
    counts
}
