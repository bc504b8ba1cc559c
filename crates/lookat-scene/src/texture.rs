//! `Texture`: named values that vary over surfaces.

mod imagemap;
mod mapping;
mod mix;
mod scale;

use std::sync::Arc;

use glam::Vec3;
use lookat_image::Texel;

use crate::Transform;
use crate::params::Params;
use crate::picture::{Cache, FromColor, Pictures};

pub use imagemap::{ImageFilter, ImageMap};
pub use mapping::Mapping;

/// A value for each point of a surface: a number (`f64`) or a color (`Vec3`, linear RGB).
#[derive(Debug, Clone)]
pub enum Texture<T: Value> {
    /// Everywhere the same (`constant`: `value`, default 1).
    Constant(T),
    /// Different from point to point.
    Varying(Arc<Varying<T>>),
}

/// A texture that is not everywhere the same.
#[derive(Debug, Clone)]
pub enum Varying<T: Value> {
    /// The product of two textures (`scale`).
    Scale([Texture<T>; 2]),
    /// The first texture where `amount` is 0, the second where it is 1 (`mix`).
    Mix {
        /// What is mixed (`tex1`, default 0, and `tex2`, default 1).
        textures: [Texture<T>; 2],
        /// The share of the second (`amount`, default 0.5).
        amount: Texture<f64>,
    },
    /// A picture (`imagemap`).
    ImageMap(Box<ImageMap<T>>),
}

impl<T: Value> Texture<T> {
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
                Varying::ImageMap(_) => true,
            },
        }
    }

    fn varying(texture: Varying<T>) -> Self {
        Texture::Varying(Arc::new(texture))
    }
}

/// What textures give: numbers and colors.
pub trait Value: Copy + std::fmt::Debug + Send + Sync + std::ops::Mul<Output = Self> + 'static {
    /// Of a picture.
    type Texel: Texel;

    /// The value of a picture.
    fn from_texel(texel: Self::Texel) -> Self;

    /// The value with all channels alike.
    fn gray(value: f64) -> Self;

    /// `a` where `amount` is 0, `b` where it is 1.
    fn mix(a: Self, b: Self, amount: f64) -> Self;
}

impl Value for f64 {
    type Texel = f32;

    fn from_texel(texel: f32) -> f64 {
        texel.into()
    }

    fn gray(value: f64) -> f64 {
        value
    }

    fn mix(a: f64, b: f64, amount: f64) -> f64 {
        a * (1.0 - amount) + b * amount
    }
}

impl Value for Vec3 {
    type Texel = Vec3;

    fn from_texel(texel: Vec3) -> Vec3 {
        texel
    }

    fn gray(value: f64) -> Vec3 {
        Vec3::splat(value as f32)
    }

    fn mix(a: Vec3, b: Vec3, amount: f64) -> Vec3 {
        a * (1.0 - amount) as f32 + b * amount as f32
    }
}

/// A value that parameters can name a texture for.
pub(crate) trait Parameter: Value<Texel: FromColor> {
    /// The parameter as a texture; where it is missing, the default.
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<Self>;

    /// The parameter as a value: no texture.
    fn value(params: &mut Params, name: &'static str, default: f64) -> Self;

    /// The pictures of such values.
    fn cache(pictures: &mut Pictures) -> &mut Cache<Self::Texel>;
}

impl Parameter for f64 {
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<f64> {
        params.float_texture(name, default)
    }

    fn value(params: &mut Params, name: &'static str, default: f64) -> f64 {
        params.float(name, default)
    }

    fn cache(pictures: &mut Pictures) -> &mut Cache<f32> {
        &mut pictures.numbers
    }
}

impl Parameter for Vec3 {
    fn texture(params: &mut Params, name: &'static str, default: f64) -> Texture<Vec3> {
        params.spectrum_texture(name, Vec3::gray(default))
    }

    fn value(params: &mut Params, name: &'static str, default: f64) -> Vec3 {
        params.spectrum(name, Vec3::gray(default))
    }

    fn cache(pictures: &mut Pictures) -> &mut Cache<Vec3> {
        &mut pictures.colors
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
pub(crate) fn texture<T: Parameter>(
    params: &mut Params,
    world_from_texture: Transform,
    pictures: &mut Pictures,
) -> Option<Texture<T>> {
    let texture = match params.kind() {
        "constant" => Texture::Constant(T::value(params, "value", 1.0)),
        "scale" => scale::scale(params),
        "mix" => mix::mix(params),
        "imagemap" => imagemap::imagemap(params, world_from_texture, pictures)?,
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
