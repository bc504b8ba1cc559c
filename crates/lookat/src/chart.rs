//! `lookat chart`: error against render time.

mod text;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use lookat_image::{Image, MemoryBudget, write_file};
use lookat_lab::chart::{
    Chart, ChartSetup, End, FEWEST_SEEDS, Fitted, METHODS, MOST_POINTS, Measured, Measurement, Method,
    Origin, Plan, Reference, Renderer, as_csv, draw, fitted, named,
};
use lookat_lab::table::significant;
use lookat_render::{Settings, Stop};
use lookat_scene::syntax::nearest;
use lookat_scene::{FilmOverride, LoadOptions, Scene, kinds};

use crate::Failure;
use crate::args::{self, Other, Report, way_out};
use crate::output::{Destination, check_folder, check_inputs, check_new_folder, make_folder};
use crate::readable::escaped;
use crate::render::progress_bar;
use crate::render::settings::charge_memory;
use crate::source::{load_scene, read_image};
use crate::standard_error::{self, Bar};
use crate::{interrupt, report};

/// The output files.
const FILE_NAMES: [&str; 4] = ["chart.svg", "chart.png", "chart.csv", "chart.json"];

/// The shortest time of a pilot picture: a fraction of the budget, and an upper bound in seconds.
const PILOT: (f64, f64) = (0.0025, 0.1);

/// Bytes for each pixel of the reference and of a measured picture.
const PICTURE_BYTES: u64 = 24;
/// Bytes for each pixel of the sums of a method's errors.
const METHOD_BYTES: u64 = 48;

/// Runs the command.
pub fn chart(arguments: &args::Chart) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// Measures and writes the results. Returns the exit status.
fn run(arguments: &args::Chart) -> Result<u8, Failure> {
    let started = Instant::now();
    let methods = chosen(&arguments.methods)?;
    let options = LoadOptions {
        film: FilmOverride { resolution: arguments.resolution, ..FilmOverride::default() },
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    };
    let loaded = load_scene(&arguments.scene, &options, Report::default());
    let parse = started.elapsed().as_secs_f64();
    report::print(&loaded, false);
    let Some(scene) = loaded.scene else { return Ok(report::failure(&loaded)) };
    // Check before minutes of rendering, not after.
    let memory = &loaded.memory;
    let errors = scene.view.film.crop.area() * (PICTURE_BYTES + METHOD_BYTES * methods.len() as u64);
    let refused = |shortage| format!("measuring errors: {}", way_out(shortage));
    memory.reserve(errors).map_err(refused)?.keep();
    drop(charge_memory(
        &scene,
        &Settings { stop: Stop::Samples { error_layers: true }, ..Settings::default() },
        memory,
    )?);
    let reference = arguments.reference.as_deref();
    let reference = reference.map(|file| read_reference(file, &scene, arguments, memory)).transpose()?;
    let others = arguments.point.iter().map(|other| {
        let image = read_image(&other.image, memory)?;
        Ok((other, fit(&other.image, &image, &scene)?))
    });
    let others = others.collect::<Result<Vec<_>, Failure>>()?;
    check_names(&arguments.point)?;
    let folder = arguments.output.clone().unwrap_or_else(|| folder_of(&arguments.scene));
    check_new_folder(&folder)?;
    let inputs = loaded.inputs.iter().chain(&arguments.reference);
    let inputs: Vec<&PathBuf> = inputs.chain(arguments.point.iter().map(|other| &other.image)).collect();
    for file in FILE_NAMES.map(|name| folder.join(name)).iter().filter(|_| folder.exists()) {
        check_folder(file)?;
        check_inputs(file, inputs.iter().copied())?;
    }

    let mut renderer = Renderer::new(&scene);
    standard_error::detach();
    let run = Run { arguments, methods, started, bar: progress_bar() };
    interrupt::stop_in_order(Some("stopping; interrupt again to quit without a chart"), || true);
    let found = run.measure(&mut renderer, reference)?;
    run.bar.clear();
    let Some((reference, measured)) = found else {
        say!("interrupted before the first point; nothing was written");
        return Ok(interrupt::STATUS);
    };
    let status = if measured.end == End::Interrupted { interrupt::STATUS } else { 0 };
    let name = if arguments.scene == Path::new("-") { Path::new("standard input") } else { &arguments.scene };
    let setup = ChartSetup {
        scene: name.display().to_string(),
        size: [scene.view.film.crop.width(), scene.view.film.crop.height()],
        threads: lookat_render::threads(),
        seed: arguments.seed,
        seeds_per_point: arguments.seeds,
        parse_seconds: parse,
        preparation_seconds: renderer.preparation,
    };
    let mut chart = Chart::new(setup, &run.methods, &measured, &reference);
    for (other, picture) in &others {
        chart.add(&other.name, other.seconds, picture, &reference);
    }
    let files = files(&chart, &measured)?;
    // If this fails, `Destination` writes the files to another folder.
    let _ = make_folder(&folder);
    let mut destination = Destination::new(&folder);
    for (name, bytes) in FILE_NAMES.iter().zip(files) {
        destination.write(name.as_ref(), |path| write_file(path, &bytes[..]))?;
    }
    let printed = crate::print(&text::results(&chart, &reference));
    let (folder, seconds) = (destination.folder().display(), started.elapsed().as_secs_f64());
    say!("{folder}: {}; {seconds:.1} s in all", FILE_NAMES.join(", "));
    printed.and(destination.result()).map(|()| status)
}

/// The inputs of a measurement.
struct Run<'a> {
    arguments: &'a args::Chart,
    methods: Vec<&'static Method>,
    started: Instant,
    bar: Bar,
}

impl Run<'_> {
    /// Plans, renders a reference if none is given, and measures the points. `None` if interrupted before the first point.
    fn measure(
        &self,
        renderer: &mut Renderer,
        given: Option<Reference>,
    ) -> Result<Option<(Reference, Measured)>, Failure> {
        let Some((plan, seconds)) = self.plan(renderer, given.is_none())? else { return Ok(None) };
        crate::say(&text::plan(&plan, seconds, &self.methods));
        let samples = plan.samples(&self.methods);
        // The reference takes its share of the samples on the progress bar.
        let share =
            if given.is_none() { samples[self.methods.len()] / samples.iter().sum::<f64>() } else { 0.0 };
        let watch = |from: f64, to: f64| {
            move |done: f64| {
                self.bar.set((1000.0 * (from + done * (to - from))) as u64, String::new());
                interrupt::flow()
            }
        };
        let seed = self.arguments.seed;
        let reference = match given {
            Some(given) => Some(given),
            None => {
                let samples = plan.reference_samples(&self.methods);
                renderer.reference(samples, plan.reference_seed(seed), &watch(0.0, share))
            }
        };
        let Some(reference) = reference else { return Ok(None) };
        let budget = self.arguments.spp.is_none().then_some((self.started, self.arguments.budget));
        let measurement = Measurement { methods: &self.methods, plan, seed, reference: &reference, budget };
        let measured = measurement.run(renderer, &watch(share, 1.0));
        let has_points = measured.points.iter().any(|points| !points.is_empty());
        Ok(has_points.then_some((reference, measured)))
    }

    /// The points, and the seconds that they take if a budget decides. `None` if interrupted.
    fn plan(
        &self,
        renderer: &mut Renderer,
        renders_reference: bool,
    ) -> Result<Option<(Plan, Option<f64>)>, Failure> {
        let args::Chart { seeds, budget, .. } = *self.arguments;
        if let Some(largest) = self.arguments.spp {
            return Ok(Some((Plan { largest, seeds, renders_reference }, None)));
        }
        // The reference uses this method.
        let reference = renders_reference.then(|| named("sobol")).flatten();
        let pilot = PILOT.1.min(PILOT.0 * budget);
        let cost = |method| renderer.seconds_per_sample(method, pilot, &|_| interrupt::flow());
        let costs: Option<Vec<f64>> = self.methods.iter().copied().chain(reference).map(cost).collect();
        let Some(costs) = costs else { return Ok(None) };
        let spent = self.started.elapsed().as_secs_f64();
        let planned = Plan::within((budget - spent).max(0.0), &self.methods, &costs, seeds);
        let (plan, seconds) = planned.map_err(|needed| {
            let methods = match &self.methods[..] {
                [only] => format!("a chart of {}", only.name),
                several => format!("the smallest chart of {} methods", several.len()),
            };
            format!(
                "{methods} takes about {} s; the budget is {budget} s: raise --budget, name fewer --methods, or lower \
                 --resolution{}",
                significant(needed + spent, 2),
                if seeds > FEWEST_SEEDS { " or --seeds" } else { "" }
            )
        })?;
        Ok(Some((plan, Some(seconds))))
    }
}

/// The methods with these names.
fn chosen(names: &[String]) -> Result<Vec<&'static Method>, Failure> {
    if names.iter().any(|name| name.trim() == "all") {
        return Ok(METHODS.iter().collect());
    }
    let known = || METHODS.iter().map(|method| method.name);
    let mut methods: Vec<&'static Method> = Vec::new();
    for name in names.iter().map(|name| name.trim()) {
        let Some(method) = named(name) else {
            let hint = match (stand_in(name), nearest(name, known())) {
                (Some(other), _) => format!("lookat renders it as `{other}`; "),
                (None, Some(near)) => format!("did you mean `{near}`? "),
                (None, None) => String::new(),
            };
            let all = known().collect::<Vec<_>>().join(", ");
            bail!("unknown method `{name}`; {hint}the methods are {all}, or all");
        };
        if methods.iter().any(|other| other.name == method.name) {
            bail!("--methods names {name} twice");
        }
        methods.push(method);
    }
    Ok(methods)
}

/// The method that renders a Sampler or Integrator which is no method of its own.
fn stand_in(name: &str) -> Option<&'static str> {
    if name == "halton" {
        return Some("sobol");
    }
    let mut kinds = kinds().filter(|kind| ["Sampler", "Integrator"].contains(&kind.directive));
    Some(kinds.find(|kind| kind.name == name && !kind.instead.is_empty())?.instead)
}

/// Fails if the name of a point is also the name of a method or of another point.
fn check_names(points: &[Other]) -> Result<(), Failure> {
    for (i, point) in points.iter().enumerate() {
        let name = &point.name;
        if named(name).is_some() {
            bail!("--point {name}: this is the name of a method; choose another name");
        }
        if points[..i].iter().any(|other| other.name == *name) {
            bail!("--point {name} is given twice; choose different names");
        }
    }
    Ok(())
}

/// The default output folder.
fn folder_of(scene: &Path) -> PathBuf {
    let name = if scene == Path::new("-") {
        "scene".into()
    } else {
        scene.file_stem().unwrap_or_default().to_owned()
    };
    PathBuf::from(format!("{}-chart", name.display()))
}

/// The pixels of a picture of the scene.
fn fit(file: &Path, image: &Image, scene: &Scene) -> Result<Fitted, Failure> {
    Ok(fitted(image, &scene.view.film).map_err(|fault| format!("{}: the picture {fault}", file.display()))?)
}

fn read_reference(
    file: &Path,
    scene: &Scene,
    arguments: &args::Chart,
    memory: &MemoryBudget,
) -> Result<Reference, Failure> {
    let image = read_image(file, memory)?;
    let found = fit(file, &image, scene)?;
    if found.rounded && may_be_clipped(file, &found) {
        bail!(
            "{}: pixels at the largest value may be clipped, so errors measured against them are unreliable; give an .exr or .pfm as \
             --reference",
            file.display()
        );
    }
    let last = arguments.seed.saturating_add(u64::from(MOST_POINTS * arguments.seeds) - 1);
    if let Some(seed) = seed(&image).filter(|seed| (arguments.seed..=last).contains(seed)) {
        say!(
            "warning: {} has the seed {seed}, which a measured picture may have too: their errors would not be \
             independent; --seed {} avoids that",
            file.display(),
            last.saturating_add(1)
        );
    }
    let origin = Origin::File { path: file.into(), rounded: found.rounded };
    Ok(Reference { pixels: found.pixels, noise: found.noise, origin })
}

/// True if the file format may clip values at 1. Radiance HDR has exponents and does not clip.
fn may_be_clipped(file: &Path, found: &Fitted) -> bool {
    let is_hdr = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("hdr"));
    let brightest = found.pixels.as_flattened().iter().copied().fold(0.0, f32::max);
    !is_hdr && brightest == 1.0
}

/// The seed of a picture by lookat, if a render with the same seed takes the same samples. A picture with error layers
/// has other samples.
fn seed(image: &Image) -> Option<u64> {
    let metadata: serde_json::Value = serde_json::from_str(image.metadata.as_deref()?).ok()?;
    if metadata["program"] == "lookat" && image.errors().is_none() { metadata["seed"].as_u64() } else { None }
}

/// The contents of the output files.
fn files(chart: &Chart, measured: &Measured) -> Result<[Vec<u8>; FILE_NAMES.len()], String> {
    let plot = draw(chart, &text::title(chart)).map_err(|error| format!("cannot draw the chart: {error}"))?;
    let plot = plot.ok_or("there is nothing to chart: every picture equals the reference")?;
    let json = serde_json::to_string_pretty(chart).map_err(|error| error.to_string())?;
    let csv = as_csv(chart, &measured.pictures);
    Ok([plot.svg.into_bytes(), plot.png, csv.into_bytes(), escaped(&(json + "\n")).into_bytes()])
}
