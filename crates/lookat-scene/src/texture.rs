//! `Texture`: named values that vary over surfaces. So far only constant ones are rendered.

use std::collections::HashMap;

use glam::Vec3;

use crate::params::Params;

/// The textures in scope. A texture that is not rendered has no value; parameters that name it keep their default.
#[derive(Debug, Clone, Default)]
pub(crate) struct Textures {
    pub float: HashMap<String, Option<f64>>,
    pub spectrum: HashMap<String, Option<Vec3>>,
}

impl Textures {
    /// The names of the textures of one kind of value.
    pub fn names(&self, value: &str) -> Vec<&str> {
        let mut names: Vec<&str> = match value {
            "float" => self.float.keys().map(String::as_str).collect(),
            _ => self.spectrum.keys().map(String::as_str).collect(),
        };
        names.sort_unstable();
        names
    }
}

pub(crate) const NAMES: &[&str] = &[
    "constant",
    "scale",
    "mix",
    "bilerp",
    "imagemap",
    "uv",
    "checkerboard",
    "dots",
    "fbm",
    "wrinkled",
    "marble",
    "windy",
    "ptex",
];

pub(crate) fn float_texture(params: &mut Params) -> Option<f64> {
    if params.kind() != "constant" {
        return not_rendered(params);
    }
    let value = params.float("value", 1.0);
    params.finish().then_some(value)
}

pub(crate) fn spectrum_texture(params: &mut Params) -> Option<Vec3> {
    if params.kind() != "constant" {
        return not_rendered(params);
    }
    let value = params.spectrum("value", Vec3::ONE);
    params.finish().then_some(value)
}

fn not_rendered<T>(params: &mut Params) -> Option<T> {
    if !NAMES.contains(&params.kind()) {
        return params.unknown_kind(NAMES);
    }
    let message = format!(
        "Texture \"{}\" is not rendered yet; parameters that name such a texture keep their default",
        params.kind()
    );
    params.unsupported(message);
    None
}
