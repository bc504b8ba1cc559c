//! The metadata of a picture: of which view it is, and what the numbers in its layers stand for.

use std::collections::BTreeSet;
use std::path::Path;

use lookat_render::image::Image;
use lookat_render::{Layer, Prepared, Settings, Stop};
use lookat_scene::syntax::Span;
use lookat_scene::{Camera, Place, Sources};
use serde::Serialize;

/// The metadata of a picture. It must be the same for each run.
#[derive(Default, Serialize)]
pub struct Metadata {
    program: &'static str,
    version: &'static str,
    scene: String,
    camera: JsonCamera,
    seed: u64,
    samples_per_pixel: f64,
    complete: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    adaptive: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    target_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<f64>,
    #[serde(flatten)]
    numbered: Numbered,
}

/// The camera of a picture, with the names of the scene file.
#[derive(Default, Serialize)]
struct JsonCamera {
    /// Row by row.
    world_from_camera: [f64; 16],
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f64>,
    screenwindow: [f64; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    lensradius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    focaldistance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    focusdistance: Option<f64>,
}

impl JsonCamera {
    fn new(camera: &Camera) -> JsonCamera {
        let thin = camera.lens.filter(|_| camera.lens_system().is_none());
        JsonCamera {
            world_from_camera: camera.world_from_camera.matrix().transpose().to_cols_array(),
            fov: camera.fov(),
            screenwindow: camera.screen.edges(),
            lensradius: thin.map(|lens| lens.radius),
            focaldistance: thin.map(|lens| lens.focal_distance),
            focusdistance: camera.lens.xor(thin).map(|lens| lens.focal_distance),
        }
    }
}

impl Metadata {
    /// The metadata of a complete picture.
    pub fn new(scene: &Path, camera: &Camera, seed: u64, samples_per_pixel: f64) -> Metadata {
        Metadata {
            program: "lookat",
            version: env!("CARGO_PKG_VERSION"),
            scene: scene.display().to_string(),
            camera: JsonCamera::new(camera),
            seed,
            samples_per_pixel,
            complete: true,
            ..Metadata::default()
        }
    }

    /// Adds the settings that determine the samples of each pixel, and what the numbers of the layers stand for.
    pub fn with_settings(self, settings: &Settings, complete: bool, numbered: Numbered) -> Metadata {
        let target = settings.target_error();
        let adaptive = matches!(settings.stop, Stop::Adaptive | Stop::Time { adaptive: true, .. });
        let (target_error, confidence) =
            (target.map(|target| target.relative), target.map(|target| target.confidence));
        Metadata { complete, adaptive, target_error, confidence, numbered, ..self }
    }

    /// As JSON. `None` if its numbers are none.
    pub fn as_json(&self) -> Option<String> {
        serde_json::to_string(self).ok()
    }
}

/// The shapes and the materials whose numbers are in the layers of a picture. Each list is empty without its layer.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Numbered {
    /// With `--layers shape`: each shape in the picture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    shapes: Vec<Entry>,
    /// With `--layers material`: each material in the picture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<Entry>,
}

#[derive(Debug, Clone, Serialize)]
struct Entry {
    /// The number in the layer.
    number: u32,
    /// The type.
    #[serde(rename = "type")]
    kind: String,
    /// The name in `MakeNamedMaterial`.
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    /// The place in the text. A default has none.
    #[serde(flatten)]
    place: Option<Place>,
}

impl Numbered {
    /// Those in the layers of a picture.
    pub fn new(image: &Image, prepared: &Prepared, sources: &Sources) -> Numbered {
        let shapes = numbers(image, Layer::Shape);
        let materials = numbers(image, Layer::Material);
        let shape = |(number, span): (u32, Option<Span>)| entry(number, "shape", None, span, sources);
        let all = prepared.shapes().map(|shape| shape.span);
        let shapes = (1..).zip(all).filter(|(number, _)| shapes.contains(number)).map(shape).collect();
        let all = if materials.is_empty() { Vec::new() } else { prepared.materials() };
        let found = (1..).zip(all).filter(|(number, _)| materials.contains(number));
        let materials = found.map(|(number, material)| {
            entry(number, material.kind().name(), material.name.clone(), material.span, sources)
        });
        Numbered { shapes, materials: materials.collect() }
    }
}

/// The numbers in a layer; 0 stands for nothing.
fn numbers(image: &Image, layer: Layer) -> BTreeSet<u32> {
    let samples = image.channel(layer.channels()[0]).unwrap_or_default();
    samples.iter().map(|number| *number as u32).filter(|number| *number > 0).collect()
}

/// `kind`: the type of what has no place in the text.
fn entry(number: u32, kind: &str, name: Option<String>, span: Option<Span>, sources: &Sources) -> Entry {
    let place = span.map(|span| Place::new(span, sources));
    let kind = span.map_or_else(|| kind.into(), |span| sources.word(span));
    Entry { number, kind, name, place }
}
