//! Charts of error against render time.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use lookat_lab::chart as lab;
use lookat_lab::chart::{ChartSetup, DEFAULT, METHODS, Measurement, Method, Plan, Reference, Renderer};
use pyo3::prelude::*;

use crate::picture::picture_of;
use crate::scene::Scene;
use crate::{as_python, run_detached, start_threads, value_error};

/// A chart of error against render time.
#[pyclass(module = "lookat", frozen)]
pub struct Chart {
    results: serde_json::Value,
    svg: String,
}

#[pymethods]
impl Chart {
    /// The results, as `lookat chart` writes them to chart.json.
    #[getter]
    fn results<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        as_python(py, &self.results)
    }

    /// The figure.
    #[getter]
    fn svg(&self) -> &str {
        &self.svg
    }

    fn _repr_svg_(&self) -> &str {
        &self.svg
    }
}

/// Renders a scene by several methods with up to `spp` samples per pixel, a power of two, and measures their errors.
#[pyfunction]
#[pyo3(signature = (scene, *, methods = None, spp = 64, seeds = 8, seed = 0, reference = None))]
pub fn chart(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    methods: Option<Vec<String>>,
    spp: u32,
    seeds: u32,
    seed: u64,
    reference: Option<&Bound<'_, PyAny>>,
) -> PyResult<Chart> {
    if !spp.is_power_of_two() || !(1..=65536).contains(&spp) {
        return Err(value_error("spp must be a power of two from 1 to 65536"));
    }
    if seeds < lab::FEWEST_SEEDS {
        return Err(value_error(format!("seeds must be at least {}", lab::FEWEST_SEEDS)));
    }
    let names = methods.unwrap_or_else(|| DEFAULT.split(',').map(|name| name.trim().to_owned()).collect());
    let named = |name: &String| {
        let known = || METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
        lab::named(name)
            .ok_or_else(|| value_error(format!("unknown method {name:?}; the methods are {}", known())))
    };
    let methods = names.iter().map(named).collect::<PyResult<Vec<&'static Method>>>()?;
    start_threads()?;
    let (name, scene) = {
        let scene = scene.borrow();
        let file = scene.sources.files.first();
        (file.map(|file| file.path.display().to_string()), scene.scene())
    };
    let film = &scene.view.film;
    let given = reference.map(|reference| {
        let found = lab::fitted(&*picture_of(reference)?, film).map_err(value_error)?;
        let origin = lab::Origin::File { path: "reference".into(), rounded: found.rounded };
        Ok::<_, PyErr>(Reference { pixels: found.pixels, noise: found.noise, origin })
    });
    let given = given.transpose()?;
    let stop = AtomicBool::new(false);
    let watch = |_: f64| {
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let measure = || {
        let mut renderer = Renderer::new(&scene);
        let plan = Plan { largest: spp, seeds, renders_reference: given.is_none() };
        let reference = match given {
            Some(given) => given,
            None => {
                renderer.reference(plan.reference_samples(&methods), plan.reference_seed(seed), &watch)?
            }
        };
        let measurement = Measurement { methods: &methods, plan, seed, reference: &reference, budget: None };
        let measured = measurement.run(&mut renderer, &watch);
        let setup = ChartSetup {
            scene: name.unwrap_or_default(),
            size: [film.crop.width(), film.crop.height()],
            threads: lookat_render::threads(),
            seed,
            seeds_per_point: seeds,
            parse_seconds: 0.0,
            preparation_seconds: renderer.preparation,
        };
        Some(lab::Chart::new(setup, &methods, &measured, &reference))
    };
    let chart = run_detached(py, measure, &stop, |_| Ok(()))?;
    let chart = chart.ok_or_else(|| value_error("interrupted"))?;
    let plot = lab::draw(&chart, "").map_err(value_error)?;
    let plot =
        plot.ok_or_else(|| value_error("there is nothing to chart: every picture equals the reference"))?;
    let results = serde_json::to_value(&chart).map_err(value_error)?;
    Ok(Chart { results, svg: plot.svg })
}
