//! Renders a scene.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use lookat_render::{Layers, Part, Rendered, Settings, Statistics, Stop, TargetError};
use pyo3::prelude::*;
use serde_json::json;

use crate::picture::Picture;
use crate::scene::Scene;
use crate::{run_detached, value_error};

/// The settings of a rendering, from the arguments.
fn settings(
    seed: u64,
    threads: usize,
    spp: Option<u32>,
    (target_error, confidence): (Option<f64>, f64),
    time: Option<f64>,
    adaptive: bool,
    error_layers: bool,
    layers: &[String],
    part: Option<[u32; 2]>,
) -> PyResult<Settings> {
    let limit = time.map(|seconds| Duration::try_from_secs_f64(seconds).map_err(value_error)).transpose()?;
    if let Some(error) = target_error.filter(|error| !(1e-6..=1.0).contains(error)) {
        return Err(value_error(format!("target_error must be from 0.000001 to 1, not {error}")));
    }
    if !(0.5..=0.999_999).contains(&confidence) {
        return Err(value_error("confidence must be from 0.5 to 0.999999"));
    }
    let stop = match (target_error, limit) {
        (Some(_), _) if adaptive => return Err(value_error("adaptive and target_error exclude each other")),
        (Some(_), _) if spp.is_some_and(|most| most < 64) => {
            return Err(value_error("target_error needs an spp of at least 64"));
        }
        (None, _) if error_layers && (adaptive || limit.is_some()) => {
            return Err(value_error("error_layers need a fixed spp or a target_error"));
        }
        (Some(relative), limit) => Stop::TargetError {
            target: TargetError { relative, confidence },
            max_samples: spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TARGET),
            limit,
            error_layers: true,
        },
        (None, Some(limit)) => {
            Stop::Time { limit, max_samples: spp.unwrap_or(Stop::DEFAULT_MAX_SAMPLES_OF_TIME), adaptive }
        }
        (None, None) if adaptive => Stop::Adaptive,
        (None, None) => Stop::Samples { error_layers },
    };
    let part = match part {
        None => None,
        Some([index, of]) if index < of && stop == Stop::default() => Some(Part { index, of }),
        Some(_) => {
            return Err(value_error(
                "part is (i, n) with i from 0 to n - 1, for a fixed spp without error layers",
            ));
        }
    };
    let mut chosen = Layers::default();
    for name in layers {
        let named = Layers::named(name).ok_or_else(|| {
            value_error(format!(
                "unknown layer {name:?}; the layers are {}",
                Layers::names().collect::<Vec<_>>().join(", ")
            ))
        })?;
        chosen = chosen.union(named);
    }
    Ok(Settings { seed, threads, stop, layers: chosen, part, ..Settings::default() })
}

/// Renders a scene. `progress` is called with the samples done and the samples in all. Ctrl-C raises `KeyboardInterrupt`.
#[pyfunction]
#[pyo3(signature = (
    scene, *, spp = None, seed = 0, threads = 0, target_error = None, confidence = 0.95, time = None, adaptive = false,
    error_layers = false, layers = Vec::new(), part = None, progress = None
))]
pub fn render(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    spp: Option<u32>,
    seed: u64,
    threads: usize,
    target_error: Option<f64>,
    confidence: f64,
    time: Option<f64>,
    adaptive: bool,
    error_layers: bool,
    layers: Vec<String>,
    part: Option<[u32; 2]>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Picture> {
    if let Some(samples) = spp.filter(|samples| !(1..=lookat_scene::MAX_SAMPLES).contains(samples)) {
        return Err(value_error(format!(
            "spp must be from 1 to {}, not {samples}",
            lookat_scene::MAX_SAMPLES
        )));
    }
    let target = (target_error, confidence);
    let settings = settings(seed, threads, spp, target, time, adaptive, error_layers, &layers, part)?;
    let mut scene = scene.borrow_mut();
    let mut view = scene.scene.view.clone();
    if let Some(samples) = spp.filter(|_| matches!(settings.stop, Stop::Samples { .. } | Stop::Adaptive)) {
        view.sampler = view.sampler.with_samples(samples);
    }
    let samples = view.sampler.samples_per_pixel;
    if part.is_some_and(|[_, of]| of > samples) || error_layers && samples < 2 {
        return Err(value_error("there are too few samples per pixel: increase spp"));
    }
    let own = &mut *scene;
    let prepared = py.detach(|| own.prepare());
    drop(scene);
    let (stop, [done, total]) = (AtomicBool::new(false), [const { AtomicU64::new(0) }; 2]);
    let note = |progress: lookat_render::Progress<'_>| {
        done.store(progress.done, Ordering::Relaxed);
        total.store(progress.total, Ordering::Relaxed);
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let tell = |py: Python<'_>| match &progress {
        Some(progress) => {
            let [done, total] = [&done, &total].map(|count| count.load(Ordering::Relaxed));
            progress.call1(py, (done, total)).map(drop)
        }
        None => Ok(()),
    };
    let started = Instant::now();
    let rendered = run_detached(py, || prepared.render(&view, &settings, &note), &stop, tell)?;
    let seconds = started.elapsed().as_secs_f64();
    if progress.is_some() {
        // The last one is complete.
        done.store(total.load(Ordering::Relaxed), Ordering::Relaxed);
        tell(py)?;
    }
    let Rendered { image, statistics, complete, .. } = rendered;
    let Statistics { samples_in_picture, rays, rejected, clamped, least, most, target, .. } = statistics;
    let statistics = json!({
        "samples_per_pixel": samples_in_picture as f64 / image.data_window.area() as f64,
        "least_samples": least,
        "most_samples": most,
        "seconds": seconds,
        "rays": rays,
        "rejected_samples": rejected,
        "clamped_samples": clamped,
        "complete": complete,
        "target": target,
    });
    Ok(Picture::new(image, statistics))
}
