//! `lookat inspect`: the size, features and cost of a scene.

mod lines;
mod shown;

use std::collections::HashMap;
use std::process::ExitCode;

use lookat_render::{
    Choice, Elements, Inspection, SampleDimensions, Settings, Surfaces, film_bytes, preparation_bytes,
};
use lookat_scene::syntax::number_bytes;
use lookat_scene::{FilterKind, Integrator, LightChoice, LoadOptions, Loaded, Projection, Scene};
use serde::Serialize;

use crate::args::Inspect;
use crate::inspect::shown::View;
use crate::readable::visible;
use crate::report::{self, SceneResult};
use crate::source::load_scene;
use crate::{Failure, sight};

/// What a scene needs. The text output is made from it.
#[derive(Serialize)]
pub struct Needs {
    /// The picture and its samples.
    film: Film,
    /// The camera.
    camera: Camera,
    /// Its `name`, and `depth`: the most surfaces of a path.
    integrator: Named,
    /// Sample dimensions.
    numbers: Numbers,
    /// Contents of the world.
    world: Elements,
    /// Contents of each instanced object.
    objects: Vec<Elements>,
    /// True if a mesh may have holes.
    has_cutouts: bool,
    /// False if the world has too few shapes for a BVH.
    asks_tree: bool,
    /// The materials, or null if the integrator ignores them.
    surfaces: Option<Surfaces>,
    /// The kinds of all lights.
    lights: Vec<&'static str>,
    /// Infinite lights of constant radiance.
    constant_skies: usize,
    /// How a surface chooses lights.
    light_choice: &'static str,
    /// Memory in bytes.
    memory: Memory,
    /// What the picture shows.
    view: View,
    /// The SIMD instructions in use: AVX-512, AVX2, SSE2 or NEON.
    simd: &'static str,
    /// Unused features, in words.
    #[serde(rename = "not_paid_for")]
    unused: Vec<&'static str>,
    #[serde(skip)]
    choice_in_words: &'static str,
}

#[derive(Serialize)]
struct Film {
    /// Width and height of the full picture.
    resolution: [u32; 2],
    /// Width and height of the rendered part.
    crop: [u32; 2],
    /// Samples per pixel.
    samples_per_pixel: u32,
    /// Samples in total.
    samples: u64,
    /// Name of the filter.
    filter: &'static str,
    /// True if a sample counts for several pixels.
    shares_samples: bool,
}

#[derive(Serialize)]
struct Camera {
    /// `perspective`, `orthographic` or `environment`.
    projection: &'static str,
    /// True if rays start on a lens.
    has_lens: bool,
    /// The `radius` and `focal_distance` of the lens, or null.
    lens: Option<Lens>,
}

#[derive(Serialize)]
struct Lens {
    radius: f64,
    focal_distance: f64,
}

#[derive(Serialize)]
struct Named {
    name: &'static str,
    depth: u32,
}

#[derive(Serialize)]
struct Numbers {
    /// Dimensions of the film.
    film: u32,
    /// Dimensions of the lens.
    lens: u32,
    /// At each surface: what the dimensions are `of`, how many `numbers`, and at which surfaces, `from` (included) `to` (excluded).
    surface: Vec<AtSurface>,
    /// The most dimensions of a sample.
    most: u64,
}

#[derive(Serialize)]
struct AtSurface {
    of: &'static str,
    numbers: u32,
    from: u32,
    to: u32,
}

#[derive(Serialize)]
struct Memory {
    /// The film, without error layers.
    film: u64,
    /// Shapes, without their meshes.
    shapes: usize,
    /// Object instances.
    instances: usize,
    /// Meshes.
    meshes: usize,
    /// BVHs.
    trees: u64,
    /// The number of pictures.
    pictures: usize,
    /// Pictures.
    picture_bytes: usize,
    /// The scene's text. A file included twice counts once.
    text: u64,
    /// The smallest `--max-memory` for `render` without options.
    render: u64,
}

/// Runs the command.
pub fn inspect(arguments: &Inspect) -> ExitCode {
    let options = LoadOptions {
        view: arguments.view.options(),
        keep_going: arguments.keep_going,
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    };
    let loaded = load_scene(&arguments.scene, &options, arguments.report);
    let needs = loaded.scene.as_ref().map(|scene| {
        arguments.view.check_use(scene)?;
        Needs::new(scene, &loaded)
    });
    let needs = match needs.transpose() {
        Ok(needs) => needs,
        Err(failure) => return crate::exit_code(Err::<u8, Failure>(failure)),
    };
    let status = if needs.is_some() { 0 } else { report::failure(&loaded) };
    let printed = if arguments.report.json {
        let result = SceneResult { needs, ..SceneResult::new(&arguments.scene, &loaded) };
        crate::print_json(&result)
    } else {
        report::print(&loaded, false);
        let name = visible(&arguments.scene.display().to_string());
        needs.map_or(Ok(()), |needs| crate::print(&needs.text(&name)))
    };
    ExitCode::from(if printed.is_ok() { status } else { crate::lost() })
}

impl Needs {
    fn new(scene: &Scene, loaded: &Loaded) -> Result<Needs, Failure> {
        let render = render_bytes(loaded, scene);
        let prepared = sight::prepare(loaded, scene)?;
        let it = lookat_render::inspect(&prepared, &scene.view);
        let unused = unused_features(scene, &it);
        let sight = sight::look(loaded, scene, prepared.facts(&scene.view));
        let view = View::new(&sight, &loaded.sources);
        // A file that is included again is in memory once.
        let files = loaded.sources.files.iter();
        let texts: HashMap<_, _> = files.map(|file| (&file.path, file.text.len() as u64)).collect();
        let trees = std::iter::once(&it.world).chain(&it.objects).map(|tree| tree.bytes as u64).sum();
        let memory = scene.world.memory();
        let (film, camera) = (&scene.view.film, &scene.view.camera);
        let samples_per_pixel = scene.view.sampler.samples_per_pixel;
        let lens = if it.has_lens { 2 } else { 0 };
        let all = |used: &SampleDimensions| u64::from(used.count) * used.surfaces.len() as u64;
        let at_surface = |SampleDimensions { purpose, count, surfaces }: &SampleDimensions| AtSurface {
            of: purpose,
            numbers: *count,
            from: surfaces.start,
            to: surfaces.end,
        };
        let [light_choice, choice_in_words] = light_choice(it.choice);
        Ok(Needs {
            film: Film {
                resolution: film.resolution,
                crop: [film.crop.width(), film.crop.height()],
                samples_per_pixel,
                samples: film.crop.area() * u64::from(samples_per_pixel),
                filter: filter_name(scene),
                shares_samples: it.shares_samples,
            },
            camera: Camera {
                projection: projection_name(scene),
                has_lens: it.has_lens,
                lens: camera
                    .lens
                    .map(|lens| Lens { radius: lens.radius, focal_distance: lens.focal_distance }),
            },
            integrator: Named { name: integrator_name(scene), depth: it.depth },
            numbers: Numbers {
                film: 2,
                lens,
                most: 2 + u64::from(lens) + it.dimensions.iter().map(all).sum::<u64>(),
                surface: it.dimensions.iter().map(at_surface).collect(),
            },
            memory: Memory {
                film: it.film_bytes,
                shapes: memory.shapes,
                instances: memory.instances,
                meshes: memory.meshes,
                trees,
                pictures: memory.pictures,
                picture_bytes: memory.picture_bytes,
                text: texts.values().sum(),
                render,
            },
            world: it.world,
            objects: it.objects,
            has_cutouts: it.has_cutouts,
            asks_tree: it.uses_bvh,
            surfaces: it.surfaces,
            lights: it.lights,
            constant_skies: it.constant_skies,
            light_choice,
            choice_in_words,
            view,
            simd: lookat_render::simd(),
            unused,
        })
    }
}

/// The features that the scene does not use.
fn unused_features(scene: &Scene, it: &Inspection) -> Vec<&'static str> {
    let is_path = matches!(scene.view.integrator, Integrator::Path { .. });
    let has = |draw: &str| it.dimensions.iter().any(|used| used.purpose == draw);
    let mut absent = vec![
        (!it.has_lens, "lens samples"),
        (!it.shares_samples, "samples of several pixels"),
        (it.world.nodes == 0, "a tree"),
        (it.world.instances == 0, "instances"),
        (!it.has_cutouts, "holes"),
    ];
    match &it.surfaces {
        None => absent.push((true, "materials, textures and lights")),
        Some(surfaces) => absent.extend([
            (surfaces.most_lobes < 2, "lobe selection"),
            (surfaces.coordinates == 0, "texture coordinates"),
            (surfaces.footprints == 0, "texture footprints"),
            (surfaces.bumps == 0, "bumps"),
            (it.lights.is_empty(), "shadow rays"),
            (it.choice == Choice::Nothing, "light selection"),
            (is_path && !has("roulette"), "roulette"),
        ]),
    }
    absent.into_iter().filter(|(is_absent, _)| *is_absent).map(|(_, what)| what).collect()
}

/// The memory limit that rendering a scene needs. Most of it is in use for a short time: while numbers of the text are read, or the BVH
/// is built.
fn render_bytes(loaded: &Loaded, scene: &Scene) -> u64 {
    let numbers = loaded.sources.files.iter().map(|file| number_bytes(&file.text)).max().unwrap_or(0);
    let rendering = film_bytes(&scene.view, &Settings::default()) + preparation_bytes(&scene.world);
    loaded.memory.most_used().max(loaded.memory.used() + numbers.max(rendering))
}

fn filter_name(scene: &Scene) -> &'static str {
    match scene.view.filter.kind {
        FilterKind::Box => "box",
        FilterKind::Triangle => "triangle",
        FilterKind::Gaussian { .. } => "gaussian",
        FilterKind::Mitchell { .. } => "mitchell",
        FilterKind::Sinc { .. } => "sinc",
    }
}

/// The type of the camera in a scene file.
pub fn projection_name(scene: &Scene) -> &'static str {
    match scene.view.camera.projection {
        Projection::Perspective { .. } => "perspective",
        Projection::Orthographic { .. } => "orthographic",
        Projection::Environment => "environment",
    }
}

fn integrator_name(scene: &Scene) -> &'static str {
    match scene.view.integrator {
        Integrator::DirectLighting { .. } => "directlighting",
        Integrator::Path { .. } => "path",
        Integrator::AmbientOcclusion { .. } => "ambientocclusion",
    }
}

/// How lights are chosen: a name, and words that end a list of lights.
fn light_choice(choice: Choice) -> [&'static str; 2] {
    match choice {
        Choice::Unused => ["unused", ""],
        Choice::Nothing => ["none", ""],
        Choice::All => ["all", "; all are sampled at each surface"],
        Choice::One(LightChoice::Uniform) => {
            ["uniform", "; one is chosen at each surface, with equal probabilities"]
        }
        Choice::One(LightChoice::Power) => ["power", "; one is chosen at each surface, by power"],
        Choice::One(LightChoice::Spatial) => {
            ["spatial", "; one is chosen at each surface, by the light it sends there"]
        }
    }
}
