//! `lookat chart`: error against render time.

mod text;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use lookat_image::{Image, MemoryBudget, write_file};
use lookat_lab::chart::{
    Budget, Climb, Cost, End, FEWEST_SEEDS, Fitted, Header, METHODS, MOST_RUNGS, Marker, Measured, Method,
    Origin, Plan, Reference, Results, Runner, as_csv, as_json, draw, fitted, named, plan,
};
use lookat_lab::plot::significant;
use lookat_render::{Settings, Stop};
use lookat_scene::syntax::nearest;
use lookat_scene::{FilmOverride, LoadOptions, Scene, kinds};

use crate::Failure;
use crate::args::{Chart, Other, Report, way_out};
use crate::output::{Destination, check_folder, check_inputs, check_new_folder, make_folder};
use crate::render::{charge_memory, progress_bar};
use crate::source::{load_scene, read_image};
use crate::standard_error::{self, Bar};
use crate::visible::escaped;
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
pub fn chart(arguments: &Chart) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// Measures and writes the results. Returns the exit status.
fn run(arguments: &Chart) -> Result<u8, Failure> {
    let started = Instant::now();
    let methods = chosen(&arguments.methods)?;
    let options = LoadOptions {
        film: FilmOverride { resolution: arguments.resolution, ..FilmOverride::default() },
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    };
    let how = Report { strict: false, json: false };
    let loaded = load_scene(&arguments.scene, &options, how);
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
    let others = arguments.point.iter().map(|other| Ok((other, read(&other.image, &scene, memory)?)));
    let others = others.collect::<Result<Vec<_>, String>>()?;
    check_names(&arguments.point)?;
    let folder = arguments.output.clone().unwrap_or_else(|| folder_of(&arguments.scene));
    check_new_folder(&folder)?;
    let inputs = loaded.inputs.iter().chain(&arguments.reference);
    let inputs: Vec<&PathBuf> = inputs.chain(arguments.point.iter().map(|other| &other.image)).collect();
    for file in FILE_NAMES.map(|name| folder.join(name)).iter().filter(|_| folder.exists()) {
        check_folder(file)?;
        check_inputs(file, inputs.iter().copied())?;
    }

    let mut header = header(arguments, &scene, parse);
    let runner = Runner::new(scene, 0);
    let budget = Budget { started, seconds: arguments.budget };
    standard_error::detach();
    let bench = Bench { arguments, methods, budget, bar: progress_bar() };
    interrupt::stop_in_order(Some("stopping; interrupt again to quit without a chart"), || true);
    let found = bench.measure(&runner, reference)?;
    bench.bar.clear();
    let Some((plan, reference, measured)) = found else {
        crate::say("interrupted before the first point; nothing was written");
        return Ok(interrupt::STATUS);
    };
    let status = if measured.end == End::Interrupted { interrupt::STATUS } else { 0 };
    header.preparation = measured.preparation();
    let marker =
        |(other, found): &(&Other, Fitted)| Marker::new(&other.name, other.seconds, found, &reference);
    let markers = others.iter().map(marker).collect();
    let results = Results::new(measured, markers, &reference);
    let files = files(&header, &plan, &reference, &results)?;
    // If this fails, `Destination` writes the files to another folder.
    let _ = make_folder(&folder);
    let mut destination = Destination::new(&folder);
    for (name, bytes) in FILE_NAMES.iter().zip(files) {
        destination.write(name.as_ref(), |path| write_file(path, &bytes[..]))?;
    }
    let printed = crate::print(&text::results(&header, &reference, &results));
    let (folder, seconds) = (destination.folder().display(), started.elapsed().as_secs_f64());
    crate::say(&format!("{folder}: {}; {seconds:.1} s in all", FILE_NAMES.join(", ")));
    Ok(printed.and(destination.result()).map(|()| status)?)
}

/// The facts known before measuring.
fn header(arguments: &Chart, scene: &Scene, parse: f64) -> Header {
    let name = if arguments.scene == Path::new("-") { Path::new("standard input") } else { &arguments.scene };
    Header {
        scene: name.display().to_string(),
        size: [scene.view.film.crop.width(), scene.view.film.crop.height()],
        threads: lookat_render::threads(),
        seed: arguments.seed,
        parse,
        preparation: 0.0,
    }
}

/// The inputs of the measurement.
struct Bench<'a> {
    arguments: &'a Chart,
    methods: Vec<&'static Method>,
    budget: Budget,
    bar: Bar,
}

impl Bench<'_> {
    /// Plans, renders a reference if none is given, and measures points with growing samples. `None` if interrupted
    /// before the first point.
    fn measure(
        &self,
        runner: &Runner,
        given: Option<Reference>,
    ) -> Result<Option<(Plan, Reference, Measured)>, String> {
        let Some(costs) = self.costs(runner, given.is_none()) else { return Ok(None) };
        let plan = self.plan(costs, given.is_some())?;
        crate::say(&text::plan(&plan, &self.methods, self.arguments.spp.is_some()));
        let farthest = AtomicU64::new(0);
        // The reference takes its share of the samples on the progress bar.
        let share = plan.reference_share();
        let watch = |from: f64, to: f64| {
            let farthest = &farthest;
            move |done: f64| {
                // After a new plan, the computed position may be lower: the bar waits.
                let at = (1000.0 * (from + done * (to - from))) as u64;
                self.bar.set(at.max(farthest.fetch_max(at, Ordering::Relaxed)), String::new());
                interrupt::flow()
            }
        };
        let first = self.arguments.seed;
        let reference = match given {
            Some(given) => Some(given),
            None => runner.reference(plan.reference, plan.reference_seed(first), &watch(0.0, share)),
        };
        let Some(reference) = reference else { return Ok(None) };
        let budget = self.arguments.spp.is_none().then_some(self.budget);
        let climb =
            Climb { methods: &self.methods, plan: &plan, first_seed: first, reference: &reference, budget };
        let measured = climb.run(runner, &watch(share, 1.0));
        Ok(measured.has_points().then_some((plan, reference, measured)))
    }

    /// The costs of the methods, then of the reference if it must be rendered. `None` if interrupted.
    fn costs(&self, runner: &Runner, with_reference: bool) -> Option<Vec<Cost>> {
        // The reference uses this method.
        let reference = with_reference.then(|| named("sobol")).flatten();
        let methods = self.methods.iter().copied().chain(reference);
        // With a fixed plan, the pilot is only a warm-up.
        let seconds =
            if self.arguments.spp.is_some() { 0.0 } else { PILOT.1.min(PILOT.0 * self.arguments.budget) };
        methods.map(|method| Cost::pilot(runner, method, seconds, &|_| interrupt::flow())).collect()
    }

    fn plan(&self, mut costs: Vec<Cost>, has_reference: bool) -> Result<Plan, String> {
        let reference = if has_reference { None } else { costs.pop() };
        let seeds = self.arguments.seeds;
        if let Some(samples) = self.arguments.spp {
            return Ok(Plan::fixed(costs, reference, seeds, samples.ilog2() + 1));
        }
        plan(&costs, reference, seeds, self.budget.left()).map_err(|needed| {
            let needed = needed + self.budget.started.elapsed().as_secs_f64();
            let costly = (0..costs.len()).max_by(|a, b| costs[*a].of(1).total_cmp(&costs[*b].of(1)));
            let methods = match &self.methods[..] {
                [only] => format!("a chart of {}", only.name),
                several => format!("the smallest chart of {} methods", several.len()),
            };
            let costly = costly
                .filter(|_| costs.len() > 1)
                .map_or(String::new(), |costly| format!(", most of all for {}", self.methods[costly].name));
            format!(
                "{methods} takes about {} s{costly}; the budget is {} s: raise --budget, name fewer \
                 --methods, or lower --resolution{}",
                significant(needed, 2),
                self.arguments.budget,
                if seeds > FEWEST_SEEDS { " or --seeds" } else { "" }
            )
        })
    }
}

/// The methods with these names.
fn chosen(names: &[String]) -> Result<Vec<&'static Method>, String> {
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
            return Err(format!("unknown method `{name}`; {hint}the methods are {all}, or all"));
        };
        if methods.iter().any(|other| other.name == method.name) {
            return Err(format!("--methods names {name} twice"));
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
fn check_names(points: &[Other]) -> Result<(), String> {
    for (i, point) in points.iter().enumerate() {
        let name = &point.name;
        if named(name).is_some() {
            return Err(format!("--point {name}: this is the name of a method; choose another name"));
        }
        if points[..i].iter().any(|other| other.name == *name) {
            return Err(format!("--point {name} is given twice; choose different names"));
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

/// Reads a picture of the scene.
fn read(file: &Path, scene: &Scene, memory: &MemoryBudget) -> Result<Fitted, String> {
    fit(file, &read_image(file, memory)?, scene)
}

fn fit(file: &Path, image: &Image, scene: &Scene) -> Result<Fitted, String> {
    fitted(image, &scene.view.film).map_err(|fault| format!("{}: the picture {fault}", file.display()))
}

fn read_reference(
    file: &Path,
    scene: &Scene,
    arguments: &Chart,
    memory: &MemoryBudget,
) -> Result<Reference, String> {
    let image = read_image(file, memory)?;
    let found = fit(file, &image, scene)?;
    if found.rounded && may_be_clipped(file, &found) {
        return Err(format!(
            "{}: pixels at the largest value may be clipped, so errors measured against them are unreliable; give an .exr or .pfm as \
             --reference",
            file.display()
        ));
    }
    let last = arguments.seed.saturating_add(u64::from(MOST_RUNGS * arguments.seeds) - 1);
    if let Some(seed) = seed(&image).filter(|seed| (arguments.seed..=last).contains(seed)) {
        crate::say(&format!(
            "warning: {} has the seed {seed}, which a measured picture may have too: their errors would not be \
             independent; --seed {} avoids that",
            file.display(),
            last.saturating_add(1)
        ));
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
fn files(
    header: &Header,
    plan: &Plan,
    reference: &Reference,
    results: &Results,
) -> Result<[Vec<u8>; FILE_NAMES.len()], String> {
    let cannot = |error| format!("cannot draw the chart: {error}");
    let Some(plot) = draw(results, &text::title(header)).map_err(cannot)? else {
        return Err("there is nothing to chart: every picture equals the reference".into());
    };
    let png = plot.png().map_err(cannot)?;
    let json = escaped(&format!("{:#}\n", as_json(header, plan, reference, results)));
    Ok([plot.svg.into_bytes(), png, as_csv(results).into_bytes(), json.into_bytes()])
}
