//! `lookat render`: renders scene files to pictures.

mod batch;
mod checkpoint;
mod fireflies;
mod frames;
pub mod job;
mod progress;
pub mod settings;
pub mod summary;
mod written;

use std::process::ExitCode;

use lookat_render::StopOptionsError;
use lookat_scene::MAX_PIXELS;

use crate::args::{Animation, Parameter, Render, crop_edges};
use crate::failure::Failure;
use crate::live::Live;
use crate::render::batch::{jobs, render_again, render_each};
pub use crate::render::checkpoint::{Resumed, linked};
use crate::render::job::{fail, finish};
pub use crate::render::progress::progress_bar;
use crate::scene_result::SceneResult;
use crate::standard_error;

/// Runs the command, or goes on with it.
pub fn render(arguments: &Render, resumed: Option<Resumed>) -> ExitCode {
    let prepared = check_arguments(arguments).and_then(|()| {
        let mut jobs = jobs(arguments)?;
        jobs[0].resumed = resumed;
        standard_error::detach();
        Ok((jobs, Live::new(&arguments.live, arguments.tone)?))
    });
    ExitCode::from(match prepared {
        Ok((mut jobs, live)) => match &live.watch {
            Some(watch) => render_again(jobs.remove(0), &live, watch),
            None => render_each(&jobs, &live),
        },
        Err(message) => {
            let mut result = SceneResult::without_scene(&arguments.scenes[0]);
            let status = fail(&message, &mut result);
            finish(arguments, &result, status)
        }
    })
}

/// Checks the arguments together, before loading the scene.
fn check_arguments(arguments: &Render) -> Result<(), Failure> {
    crop_edges(arguments.crop.as_deref())?;
    if let (Some([width, height]), None) = (arguments.resolution, &arguments.crop)
        && u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        bail!("--resolution has more than 100 million pixels; render parts with --crop");
    }
    settings::stop(arguments).map_err(|error| match error {
        StopOptionsError::FewSamples => format!("{error}; increase --spp"),
        StopOptionsError::NoReplicates => format!("{error}: add --target-error, or remove --time"),
        StopOptionsError::TwoRules => error.to_string(),
    })?;
    if let Some(only) = arguments.frames.only {
        let count = arguments.frames.count();
        if !arguments.frames.is_used() {
            bail!("--only chooses a picture of --turntable or --animate; add one of them");
        }
        if only > count {
            bail!("--only {only} is beyond the last of {count} pictures");
        }
    }
    if let Some(Animation { parameter, .. }) = arguments.frames.animate {
        let name = parameter.name();
        if parameter.is_set(&arguments.view) {
            bail!("--animate {name} and --{name} contradict each other; remove one of them");
        }
        if parameter == Parameter::FocalDistance && arguments.focus.is_some() {
            bail!("--animate {name} and --focus contradict each other; remove one of them");
        }
    }
    Ok(())
}
