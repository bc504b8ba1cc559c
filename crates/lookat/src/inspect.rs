//! `lookat inspect`: the size, features and cost of a scene.

mod text;
mod view;

use std::collections::HashMap;
use std::process::ExitCode;

use lookat_render::{
    Choice, Elements, Inspection, SampleDimensions, Settings, film_bytes, preparation_bytes,
};
use lookat_scene::syntax::number_bytes;
use lookat_scene::{
    FilterKind, Integrator, LightChoice, LoadOptions, Loaded, Memory, Projection, Scene, Sources,
};
use serde::Serialize;
use serde_json::{Value, json};

use crate::Failure;
use crate::args::Inspect;
use crate::report::{self, JsonDiagnostic};
use crate::sight::Sight;
use crate::source::load_scene;
use crate::visible::visible;

/// The JSON output.
#[derive(Serialize)]
struct JsonResult<'a> {
    scene: String,
    diagnostics: Vec<JsonDiagnostic<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    needs: Option<Value>,
}

/// The facts about a scene.
struct Inspected<'s> {
    scene: &'s Scene,
    inspection: Inspection,
    memory: Memory,
    /// The memory limit that `render` needs, without options.
    render_bytes: u64,
    sight: Sight<'s>,
    sources: &'s Sources,
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
    if let Some(Err(message)) = loaded.scene.as_ref().map(|scene| arguments.view.check_use(scene)) {
        return crate::exit_code(Err(message));
    }
    let name = arguments.scene.display().to_string();
    let found = match loaded.scene.as_ref().map(|scene| Inspected::new(scene, &loaded)).transpose() {
        Ok(found) => found,
        Err(failure) => return crate::exit_code(Err(failure)),
    };
    let printed = if arguments.report.json {
        let needs = found.as_ref().map(Inspected::json);
        crate::print_json(&JsonResult {
            scene: name,
            diagnostics: report::json(&loaded.diagnostics, &loaded.sources),
            needs,
        })
    } else {
        report::print(&loaded, false);
        found.as_ref().map_or(Ok(()), |found| crate::print(&found.text(&visible(&name))))
    };
    ExitCode::from(match (printed, found) {
        (Err(_), _) => crate::lost(),
        (Ok(()), Some(_)) => 0,
        (Ok(()), None) => report::failure(&loaded),
    })
}

impl<'s> Inspected<'s> {
    fn new(scene: &'s Scene, loaded: &'s Loaded) -> Result<Self, Failure> {
        let render_bytes = render_bytes(loaded, scene);
        let prepared = crate::sight::prepare(loaded, scene)?;
        let inspection = lookat_render::inspect(&prepared, &scene.view);
        let sight = crate::sight::look(loaded, scene, prepared.facts(&scene.view));
        Ok(Inspected {
            scene,
            inspection,
            memory: scene.world.memory(),
            render_bytes,
            sight,
            sources: &loaded.sources,
        })
    }

    /// The BVHs of the world and of all objects.
    fn trees(&self) -> impl Iterator<Item = &Elements> {
        std::iter::once(&self.inspection.world).chain(&self.inspection.objects)
    }

    /// The bytes of the text of the scene. A file that is included again is in memory once.
    fn text_bytes(&self) -> u64 {
        let texts: HashMap<_, _> =
            self.sources.files.iter().map(|file| (&file.path, file.text.len() as u64)).collect();
        texts.values().sum()
    }

    /// The most sample dimensions of one camera sample.
    fn most_numbers(&self) -> u64 {
        let all = |draw: &SampleDimensions| u64::from(draw.count) * draw.surfaces.len() as u64;
        2 + u64::from(self.lens_numbers()) + self.inspection.dimensions.iter().map(all).sum::<u64>()
    }

    fn lens_numbers(&self) -> u32 {
        if self.inspection.has_lens { 2 } else { 0 }
    }

    /// The features that the scene does not use.
    fn not_paid_for(&self) -> Vec<&'static str> {
        let it = &self.inspection;
        let is_path = matches!(self.scene.view.integrator, Integrator::Path { .. });
        let has = |draw: &str| it.dimensions.iter().any(|drawn| drawn.purpose == draw);
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

    fn json(&self) -> Value {
        let Inspected { scene, inspection: it, memory, .. } = self;
        let elements = |elements: &Elements| {
            json!({
                "triangles": elements.triangles, "quadrics": elements.quadrics,
                "curve_pieces": elements.curve_pieces, "instances": elements.instances,
                "nodes": elements.nodes, "depth": elements.depth, "bytes": elements.bytes,
            })
        };
        let draws = |draw: &SampleDimensions| json!({ "of": draw.purpose, "numbers": draw.count, "from": draw.surfaces.start, "to": draw.surfaces.end });
        let samples = scene.view.sampler.samples_per_pixel;
        json!({
            "film": {
                "resolution": scene.view.film.resolution,
                "crop": [scene.view.film.crop.width(), scene.view.film.crop.height()],
                "samples_per_pixel": samples,
                "samples": scene.view.film.crop.area() * u64::from(samples),
                "filter": filter_name(scene), "shares_samples": it.shares_samples,
            },
            "camera": {
                "projection": projection_name(scene), "has_lens": it.has_lens,
                "lens": scene.view.camera.lens.map(|lens| json!({
                    "radius": lens.radius, "focal_distance": lens.focal_distance,
                })),
            },
            "integrator": { "name": integrator_name(scene), "depth": it.depth },
            "numbers": {
                "film": 2, "lens": self.lens_numbers(),
                "surface": it.dimensions.iter().map(draws).collect::<Vec<_>>(), "most": self.most_numbers(),
            },
            "world": elements(&it.world),
            "objects": it.objects.iter().map(elements).collect::<Vec<_>>(),
            "has_cutouts": it.has_cutouts,
            "asks_tree": it.uses_bvh,
            "surfaces": it.surfaces.as_ref().map(|surfaces| json!({
                "kinds": surfaces.kinds, "most_lobes": surfaces.most_lobes,
                "specular": surfaces.specular, "coordinates": surfaces.coordinates,
                "footprints": surfaces.footprints, "bumps": surfaces.bumps,
            })),
            "lights": it.lights, "constant_skies": it.constant_skies, "light_choice": choice_name(it.choice),
            "memory": {
                "film": it.film_bytes, "shapes": memory.shapes, "instances": memory.instances, "meshes": memory.meshes, "trees": self.trees().map(|tree| tree.bytes).sum::<usize>(),
                "pictures": memory.pictures, "picture_bytes": memory.picture_bytes,
                "text": self.text_bytes(), "render": self.render_bytes,
            },
            "view": view::json(&self.sight, self.sources),
            "simd": lookat_render::simd(),
            "not_paid_for": self.not_paid_for(),
        })
    }
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

fn projection_name(scene: &Scene) -> &'static str {
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

fn choice_name(choice: Choice) -> &'static str {
    match choice {
        Choice::Unused => "unused",
        Choice::Nothing => "none",
        Choice::All => "all",
        Choice::One(LightChoice::Uniform) => "uniform",
        Choice::One(LightChoice::Power) => "power",
        Choice::One(LightChoice::Spatial) => "spatial",
    }
}
