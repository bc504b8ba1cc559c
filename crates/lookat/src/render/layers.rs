//! What the numbers of the layers `shape` and `material` stand for.

use std::collections::BTreeSet;

use lookat_image::Image;
use lookat_render::{Layer, Prepared};
use lookat_scene::Sources;
use lookat_scene::syntax::Span;
use serde::Serialize;

use crate::report::{self, Place};

/// The shapes and the materials whose numbers are in the layers of a picture. Each list is empty without its layer.
#[derive(Debug, Clone, Default, Serialize)]
pub(super) struct Numbered {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    shapes: Vec<Entry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    materials: Vec<Entry>,
}

#[derive(Debug, Clone, Serialize)]
struct Entry {
    number: u32,
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
    pub fn new(image: &Image, prepared: &Prepared, sources: &Sources) -> Numbered {
        let shapes = numbers(image, Layer::Shape);
        let materials = numbers(image, Layer::Material);
        let shape = |(number, span): (u32, Option<Span>)| entry(number, ("shape", None), span, sources);
        let all = prepared.shapes().map(|shape| shape.span);
        let shapes = (1..).zip(all).filter(|(number, _)| shapes.contains(number)).map(shape).collect();
        let all = if materials.is_empty() { Vec::new() } else { prepared.materials() };
        let found = (1..).zip(all).filter(|(number, _)| materials.contains(number));
        let materials = found.map(|(number, material)| {
            entry(number, (material.kind().name(), material.name.clone()), material.span, sources)
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
fn entry(number: u32, (kind, name): (&str, Option<String>), span: Option<Span>, sources: &Sources) -> Entry {
    let place = span.map(|span| Place::new(span, sources));
    let kind = span.map_or_else(|| kind.into(), |span| report::word(span, sources));
    Entry { number, kind, name, place }
}
