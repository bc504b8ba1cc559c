//! `Texture`: named values that vary over surfaces.

mod mix;
mod scale;

use std::sync::Arc;

use glam::Vec3;

use crate::params::Params;

/// A value for each point of a surface: a number (`f64`) or a color (`Vec3`, linear RGB).
#[derive(Debug, Clone)]
pub enum Texture<T> {
    /// Everywhere the same (`constant`: `value`, default 1).
    Constant(T),
    /// Different from point to point.
    Varying(Arc<Varying<T>>),
}

/// A texture that is not everywhere the same.
#[derive(Debug, Clone)]
pub enum Varying<T> {
    /// The product of two textures (`scale`).
    Scale([Texture<T>; 2]),
    /// The first texture where `amount` is 0, the second where it is 1 (`mix`).
    Mix {
        /// What is mixed (`tex1`, default 0, and `tex2`, default 1).
        textures: [Texture<T>; 2],
        /// The share of the second (`amount`, default 0.5).
        amount: Texture<f64>,
    },
}

impl<T: Copy> Texture<T> {
    /// The value, where it is the same everywhere.
    pub fn constant(&self) -> Option<T> {
        match self {
            Texture::Constant(value) => Some(*value),
            Texture::Varying(_) => None,
        }
    }

    /// Whether the distance to neighbouring rays changes its value.
    pub fn is_filtered(&self) -> bool {
        match self {
            Texture::Constant(_) => false,
            Texture::Varying(varying) => match &**varying {
                Varying::Scale([a, b]) => a.is_filtered() || b.is_filtered(),
                Varying::Mix { textures: [a, b], amount } => {
                    a.is_filtered() || b.is_filtered() || amount.is_filtered()
                }
            },
        }
    }

    fn varying(texture: Varying<T>) -> Self {
        Texture::Varying(Arc::new(texture))
    }
}

/// What textures give: numbers and colors.
pub trait Value: Copy + std::fmt::Debug + Send + Sync + std::ops::Mul<Output = Self> + 'static {
    /// The value with all channels alike.
    fn gray(value: f64) -> Self;

    /// `a` where `amount` is 0, `b` where it is 1.
    fn mix(a: Self, b: Self, amount: f64) -> Self;
}

impl Value for f64 {
    fn gray(value: f64) -> f64 {
        value
    }

    fn mix(a: f64, b: f64, amount: f64) -> f64 {
        a * (1.0 - amount) + b * amount
    }
}

impl Value for Vec3 {
    fn gray(value: f64) -> Vec3 {
        Vec3::splat(value as f32)
    }

    fn mix(a: Vec3, b: Vec3, amount: f64) -> Vec3 {
        a * (1.0 - amount) as f32 + b * amount as f32
    }
}

/// A value that parameters can name a texture for.
pub(crate) trait Parameter: Value {
    /// The parameter as a texture; where it is missing, the default.
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<Self>;

    /// The parameter as a value: no texture.
    fn value(params: &mut Params, name: &'static str, default: f64) -> Self;
}

impl Parameter for f64 {
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<f64> {
        params.float_texture(name, default)
    }

    fn value(params: &mut Params, name: &'static str, default: f64) -> f64 {
        params.float(name, default)
    }
}

impl Parameter for Vec3 {
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<Vec3> {
        params.spectrum_texture(name, Vec3::gray(default))
    }

    fn value(params: &mut Params, name: &'static str, default: f64) -> Vec3 {
        params.spectrum(name, Vec3::gray(default))
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

/// pbrt-v3's MakeFloatTexture and MakeSpectrumTexture. `None` for what is not rendered, or in error.
pub(crate) fn texture<T: Parameter>(params: &mut Params) -> Option<Texture<T>> {
    let texture = match params.kind() {
        "constant" => Texture::Constant(T::value(params, "value", 1.0)),
        "scale" => scale::scale(params),
        "mix" => mix::mix(params),
        _ => return not_rendered(params),
    };
    params.finish().then_some(texture)
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
