//! `Texture`: named values that vary over surfaces. So far only constant ones are rendered.

use glam::Vec3;

use crate::params::Params;

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
