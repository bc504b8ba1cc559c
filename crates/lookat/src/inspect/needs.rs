//! What a scene needs: the JSON of `lookat inspect`, from which its text is made.

use std::collections::HashMap;

use lookat_render::{
    Choice, Elements, Inspection, MediumCost, SampleDimensions, Settings, Surfaces, film_bytes,
    preparation_bytes,
};
use lookat_scene::syntax::number_bytes;
use lookat_scene::{FilterKind, Integrator, Lens, LightChoice, Loaded, Scene};
use serde::Serialize;

use crate::failure::Failure;
use crate::inspect::shown::View;
use lookat_sight::ViewFacts;

/// What a scene needs. The text output is made from it.
#[derive(Serialize)]
pub struct Needs {
    /// The picture and its samples.
    pub film: Film,
    /// The camera.
    pub camera: Camera,
    /// Its `name`, and `depth`: the most surfaces of a path.
    pub integrator: Named,
    /// Sample dimensions.
    pub numbers: Numbers,
    /// Contents of the world.
    pub world: Elements,
    /// Contents of each instanced object.
    pub objects: Vec<Elements>,
    /// True if a mesh may have holes.
    pub has_cutouts: bool,
    /// False if the world has too few shapes for a BVH.
    pub asks_tree: bool,
    /// The materials, or null if the integrator ignores them.
    pub surfaces: Option<Surfaces>,
    /// What media cost the rays that go through them. Lengths are in units of the world.
    pub media: Vec<MediumCost>,
    /// The kinds of all lights.
    pub lights: Vec<&'static str>,
    /// Infinite lights of constant radiance.
    pub constant_skies: usize,
    /// How a surface chooses lights.
    pub light_choice: &'static str,
    /// Memory in bytes.
    pub memory: Memory,
    /// What the picture shows.
    pub view: View,
    /// The SIMD instructions in use: AVX-512, AVX2, SSE2 or NEON.
    pub simd: &'static str,
    /// Unused features, in words.
    #[serde(rename = "not_paid_for")]
    pub unused: Vec<&'static str>,
}

#[derive(Serialize)]
pub struct Film {
    /// Width and height of the full picture.
    pub resolution: [u32; 2],
    /// Width and height of the rendered part.
    pub crop: [u32; 2],
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Samples in total.
    pub samples: u64,
    /// Name of the filter.
    pub filter: &'static str,
    /// True if a sample counts for several pixels.
    pub shares_samples: bool,
}

#[derive(Serialize)]
pub struct Camera {
    /// `perspective`, `orthographic`, `environment` or `realistic`.
    pub projection: &'static str,
    /// True if rays start on a lens.
    pub has_lens: bool,
    /// The `radius` and `focal_distance` of the lens, or null.
    pub lens: Option<Lens>,
    /// The lens system of a realistic camera, or null.
    pub lens_system: Option<LensSystem>,
}

#[derive(Serialize)]
pub struct LensSystem {
    /// The number of surfaces, with the aperture stop.
    pub surfaces: usize,
    /// Effective focal length, in units of camera space.
    pub focal_length: f64,
    /// Focal length divided by the diameter of the entrance pupil.
    pub f_number: f64,
    /// Distance from the film to the rear surface.
    pub film_distance: f64,
}

impl LensSystem {
    fn new(camera: &lookat_scene::Camera) -> Option<LensSystem> {
        let lenses = camera.lens_system()?;
        Some(LensSystem {
            surfaces: lenses.elements.len(),
            focal_length: lenses.thick_lens()?.focal_length,
            f_number: lenses.f_number()?,
            film_distance: lenses.film_distance(camera.lens?.focal_distance)?,
        })
    }
}

#[derive(Serialize)]
pub struct Named {
    pub name: &'static str,
    pub depth: u32,
}

#[derive(Serialize)]
pub struct Numbers {
    /// Dimensions of the film.
    pub film: u32,
    /// Dimensions of the lens.
    pub lens: u32,
    /// Dimensions of the instant, in a scene that moves.
    pub time: u32,
    /// At each surface: what the dimensions are `of`, how many `numbers`, and at which surfaces, `from` (included) `to` (excluded).
    pub surface: Vec<AtSurface>,
    /// The most dimensions of a sample.
    pub most: u64,
}

#[derive(Serialize)]
pub struct AtSurface {
    pub of: &'static str,
    pub numbers: u32,
    pub from: u32,
    pub to: u32,
}

#[derive(Serialize)]
pub struct Memory {
    /// The film, without error layers.
    pub film: u64,
    /// Shapes, without their meshes.
    pub shapes: usize,
    /// Object instances.
    pub instances: usize,
    /// Meshes.
    pub meshes: usize,
    /// BVHs.
    pub trees: u64,
    /// The number of pictures.
    pub pictures: usize,
    /// Pictures.
    pub picture_bytes: usize,
    /// Media.
    pub media: usize,
    /// Tables of materials.
    pub tables: usize,
    /// The scene's text. A file included twice counts once.
    pub text: u64,
    /// The smallest `--max-memory` for `render` without options.
    pub render: u64,
}

impl Needs {
    pub fn new(scene: &Scene, loaded: &Loaded) -> Result<Needs, Failure> {
        let render = render_bytes(loaded, scene);
        let prepared = crate::source::prepare(loaded, scene)?;
        let it = lookat_render::inspect(&prepared, &scene.view);
        let unused = unused_features(scene, &it);
        let sight = lookat_sight::look(loaded, scene, ViewFacts::new(&prepared, &scene.view));
        let view = View::new(&sight, &loaded.sources);
        // A file that is included again is in memory once.
        let files = loaded.sources.files.iter();
        let texts: HashMap<_, _> = files.map(|file| (&file.path, file.text.len() as u64)).collect();
        let trees = std::iter::once(&it.world).chain(&it.objects).map(|tree| tree.bytes as u64).sum();
        let memory = scene.world.memory();
        let (film, camera) = (&scene.view.film, &scene.view.camera);
        let samples_per_pixel = scene.view.sampler.samples_per_pixel;
        let lens = if it.has_lens { 2 } else { 0 };
        let time = u32::from(scene.has_motion());
        let all = |used: &SampleDimensions| u64::from(used.count) * used.surfaces.len() as u64;
        let at_surface = |SampleDimensions { purpose, count, surfaces }: &SampleDimensions| AtSurface {
            of: purpose,
            numbers: *count,
            from: surfaces.start,
            to: surfaces.end,
        };
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
                projection: camera.projection.name(),
                has_lens: it.has_lens,
                lens: camera.lens,
                lens_system: LensSystem::new(camera),
            },
            integrator: Named { name: integrator_name(scene), depth: it.depth },
            numbers: Numbers {
                film: 2,
                lens,
                time,
                most: 2 + u64::from(lens) + u64::from(time) + it.dimensions.iter().map(all).sum::<u64>(),
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
                media: memory.media,
                tables: memory.tables,
                text: texts.values().sum(),
                render,
            },
            world: it.world,
            objects: it.objects,
            has_cutouts: it.has_cutouts,
            asks_tree: it.uses_bvh,
            surfaces: it.surfaces,
            media: it.media,
            lights: it.lights,
            constant_skies: it.constant_skies,
            light_choice: light_choice(it.choice),
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
        (!scene.has_motion(), "motion"),
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

fn integrator_name(scene: &Scene) -> &'static str {
    match scene.view.integrator {
        Integrator::DirectLighting { .. } => "directlighting",
        Integrator::Path { .. } if !scene.world.media.is_empty() => "volpath",
        Integrator::Path { .. } => "path",
        Integrator::AmbientOcclusion { .. } => "ambientocclusion",
    }
}

/// The name of how lights are chosen.
fn light_choice(choice: Choice) -> &'static str {
    match choice {
        Choice::Unused => "unused",
        Choice::Nothing => "none",
        Choice::All => "all",
        Choice::One(LightChoice::Uniform) => "uniform",
        Choice::One(LightChoice::Power) => "power",
        Choice::One(LightChoice::Spatial) => "spatial",
    }
}
