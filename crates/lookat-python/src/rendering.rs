//! Renders a scene.

use std::ops::{ControlFlow, RangeInclusive};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use lookat_render::{
    Layers, Prepared, Rendered, Settings, Statistics, Stop, StopOptions, film_bytes, preparation_bytes,
};
use lookat_sight::{Metadata, Numbered};
use pyo3::prelude::*;
use serde_json::json;

use crate::picture::Picture;
use crate::scene::Scene;
use crate::{reserve, run_detached, start_threads, value_error};

/// The most threads of a rendering.
const MOST_THREADS: usize = 1024;

/// The settings of a rendering, from the arguments.
fn settings(
    seed: u64,
    threads: usize,
    (mut options, seconds): (StopOptions, Option<f64>),
    layers: &[String],
) -> PyResult<Settings> {
    if threads > MOST_THREADS {
        return Err(value_error(format!("threads must be at most {MOST_THREADS}")));
    }
    let check = |name: &str, value: Option<f64>, range: RangeInclusive<f64>| match value {
        Some(value) if !range.contains(&value) => {
            let (least, most) = range.into_inner();
            Err(value_error(format!("{name} must be from {least} to {most}, not {value}")))
        }
        _ => Ok(()),
    };
    check("target_error", options.target_error, StopOptions::TARGET_ERROR)?;
    check("confidence", options.confidence, StopOptions::CONFIDENCE)?;
    check("time", seconds, StopOptions::SECONDS)?;
    options.time = seconds.map(Duration::from_secs_f64);
    options.error_layers |= options.target_error.is_some();
    let stop = options.stop().map_err(value_error)?;
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
    scene, *, spp = None, seed = 0, threads = 0, target_error = None, confidence = None, time = None, adaptive = false,
    error_layers = false, layers = Vec::new(), progress = None
))]
pub fn render(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    spp: Option<u32>,
    seed: u64,
    threads: usize,
    target_error: Option<f64>,
    confidence: Option<f64>,
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
    let options = StopOptions { spp, target_error, confidence, time: None, adaptive, error_layers };
    let settings = settings(seed, threads, (options, time), &layers)?;
    start_threads()?;
    let (mut own, prepared, memory, sources) = {
        let scene = scene.borrow();
        (scene.scene(), scene.prepared(), scene.memory.clone(), scene.sources.clone())
    };
    if let Some(samples) = spp.filter(|_| matches!(settings.stop, Stop::Samples { .. } | Stop::Adaptive)) {
        own.view.sampler = own.view.sampler.with_samples(samples);
    }
    if error_layers && own.view.sampler.samples_per_pixel < 2 {
        return Err(value_error("error layers need at least 2 samples per pixel: increase spp"));
    }
    let needed = film_bytes(&own.view, &settings).saturating_add(preparation_bytes(&own.world));
    let _charge = reserve(&memory, needed)?;
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
    scene.borrow_mut().keep(prepared.clone());
    let seconds = started.elapsed().as_secs_f64();
    if progress.is_some() {
        // The last one is complete.
        done.store(total.load(Ordering::Relaxed), Ordering::Relaxed);
        tell(py)?;
    }
    let Rendered { mut image, statistics, complete, .. } = rendered;
    let Statistics { samples_in_picture, rays, rejected, clamped, least, most, target, .. } = statistics;
    let samples_per_pixel = samples_in_picture as f64 / image.data_window.area() as f64;
    let numbered = Numbered::new(&image, &prepared, &sources);
    let metadata = Metadata::new(&sources.files[0].path, &own.view.camera, seed, samples_per_pixel);
    image.metadata = metadata.with_settings(&settings, complete, numbered).as_json();
    let statistics = json!({
        "samples_per_pixel": samples_per_pixel,
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
