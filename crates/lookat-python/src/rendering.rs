//! Renders a scene.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use lookat_render::{
    Layers, Prepared, Rendered, Settings, Statistics, Stop, TargetError, film_bytes, preparation_bytes,
};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use serde_json::json;

use crate::picture::Picture;
use crate::scene::Scene;
use crate::{run_detached, start_threads, value_error};

/// The most threads of a rendering.
const MOST_THREADS: usize = 1024;

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
) -> PyResult<Settings> {
    if threads > MOST_THREADS {
        return Err(value_error(format!("threads must be at most {MOST_THREADS}")));
    }
    if time.is_some_and(|seconds| !(0.001..=1e8).contains(&seconds)) {
        return Err(value_error("time must be from 0.001 to 1e8 seconds"));
    }
    let limit = time.map(|seconds| Duration::try_from_secs_f64(seconds).map_err(value_error)).transpose()?;
    if let Some(error) = target_error.filter(|error| !(1e-6..=1.0).contains(error)) {
        return Err(value_error(format!("target_error must be from 0.000001 to 1, not {error:e}")));
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
    Ok(Settings { seed, threads, stop, layers: chosen, ..Settings::default() })
}

/// Renders a scene. `progress` is called with the samples done and the samples in all. Ctrl-C raises `KeyboardInterrupt`.
#[pyfunction]
#[pyo3(signature = (
    scene, *, spp = None, seed = 0, threads = 0, target_error = None, confidence = 0.95, time = None, adaptive = false,
    error_layers = false, layers = Vec::new(), progress = None
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
    progress: Option<Py<PyAny>>,
) -> PyResult<Picture> {
    if let Some(samples) = spp.filter(|samples| !(1..=lookat_scene::MAX_SAMPLES).contains(samples)) {
        return Err(value_error(format!(
            "spp must be from 1 to {}, not {samples}",
            lookat_scene::MAX_SAMPLES
        )));
    }
    let target = (target_error, confidence);
    let settings = settings(seed, threads, spp, target, time, adaptive, error_layers, &layers)?;
    start_threads()?;
    let (mut own, prepared, memory) = {
        let scene = scene.borrow();
        (scene.scene.clone(), scene.prepared(), scene.memory.clone())
    };
    if let Some(samples) = spp.filter(|_| matches!(settings.stop, Stop::Samples { .. } | Stop::Adaptive)) {
        own.view.sampler = own.view.sampler.with_samples(samples);
    }
    if error_layers && own.view.sampler.samples_per_pixel < 2 {
        return Err(value_error("error layers need at least 2 samples per pixel: increase spp"));
    }
    let needed = film_bytes(&own.view, &settings).saturating_add(preparation_bytes(&own.world));
    let _charge = memory.reserve(needed).map_err(|shortage| PyMemoryError::new_err(shortage.to_string()))?;
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
    let work = || {
        let prepared = prepared.unwrap_or_else(|| Arc::new(Prepared::new(&own)));
        let rendered = prepared.render(&own.view, &settings, &note);
        (prepared, rendered)
    };
    let (prepared, rendered) = run_detached(py, work, &stop, tell)?;
    scene.borrow_mut().keep(prepared);
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
