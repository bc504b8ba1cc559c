//! Looking closely: layers, the error map, and a reference.

use lookat_render::Layer;
use serde::{Deserialize, Serialize};

/// The layers that a page can ask for, by their numbers in this list.
pub const LAYERS: [(&str, Layer); 8] = [
    ("depth", Layer::Depth),
    ("position", Layer::Position),
    ("normal", Layer::Normal),
    ("shading-normal", Layer::ShadingNormal),
    ("uv", Layer::Uv),
    ("albedo", Layer::Albedo),
    ("shape", Layer::Shape),
    ("material", Layer::Material),
];

/// Asks for a layer, as the view shows it now.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GetLayer {
    /// Its number in [`LAYERS`].
    pub layer: u8,
}

/// Asks for the values of all layers at a place.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GetValues {
    pub by: u32,
    pub number: u32,
    /// In pixels from the top left corner of the full picture.
    pub at: [f64; 2],
}

/// Renders with or without error layers.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SetErrors {
    pub is_on: bool,
}

/// Sets the reference.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetReference {
    pub from: ReferenceFrom,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum ReferenceFrom {
    /// The picture that is there now.
    Picture,
    /// The file that the command names, or else the one beside the scene.
    File,
    Nothing,
}

/// How the pages look.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Looking<'a> {
    /// Whether pictures have error layers.
    pub has_errors: bool,
    /// Why they do not have them.
    pub errors_refused: Option<&'a str>,
    /// The name of the reference.
    pub reference: Option<&'a str>,
    /// Whether its pixels follow.
    pub is_shown: bool,
    /// Why there is none, why it does not fit, or why it is not the newest one.
    pub reference_refused: Option<&'a str>,
    /// The file that can be the reference.
    pub file: Option<String>,
}

/// The finished picture and the reference.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Compared {
    /// Of the view.
    pub generation: u32,
    /// What `lookat compare` prints, or why there is nothing to compare.
    pub text: String,
    /// Whether noise explains the differences. `None` if nobody can tell.
    pub agrees: Option<bool>,
}

/// The values of all layers at a place, in the order of [`LAYERS`]. Empty outside the picture.
#[derive(Debug, Serialize)]
pub struct LayerValues {
    pub by: u32,
    pub number: u32,
    pub at: [f64; 2],
    pub values: Vec<Vec<f32>>,
}
