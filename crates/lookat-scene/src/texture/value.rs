//! The values of textures: numbers and colors.

use std::fmt::Debug;
use std::ops::Mul;

use glam::Vec3;
use lookat_image::Texel;

use super::{Texture, TextureParams};
use crate::params::Params;
use crate::picture::{Cache, FromColor, Pictures};
use crate::schema::{Color, ColorTexture, Key};

/// A number or a color.
pub trait Value: Copy + Debug + PartialEq + Send + Sync + Mul<Output = Self> + 'static {
    /// The texel type of pictures.
    type Texel: Texel;

    /// Converts a texel.
    fn from_texel(texel: Self::Texel) -> Self;

    /// True if no number of the value is infinite or NaN.
    fn is_finite(self) -> bool;

    /// Linear interpolation: `a` for an `amount` of 0, `b` for 1.
    fn mix(a: Self, b: Self, amount: f64) -> Self;
}

impl Value for f64 {
    type Texel = f32;

    fn from_texel(texel: f32) -> f64 {
        texel.into()
    }

    fn is_finite(self) -> bool {
        f64::is_finite(self)
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

    fn is_finite(self) -> bool {
        Vec3::is_finite(self)
    }

    fn mix(a: Vec3, b: Vec3, amount: f64) -> Vec3 {
        a * (1.0 - amount) as f32 + b * amount as f32
    }
}

/// A value that a parameter can give directly or by a texture name.
pub(crate) trait Parameter: Value<Texel: FromColor> {
    /// The value type in Texture directives.
    const TYPE: &'static str;

    /// Takes a color. A float texture takes a number.
    fn value(params: &mut Params, key: &Key<Color>) -> Self;

    /// Takes a color or a texture. A float texture takes a number or a float texture.
    fn texture(params: &mut TextureParams, key: &Key<ColorTexture>) -> Texture<Self>;

    /// The pictures with these values.
    fn pictures(pictures: &Pictures) -> &Cache<Self::Texel>;

    /// The same, to add to them.
    fn pictures_mut(pictures: &mut Pictures) -> &mut Cache<Self::Texel>;
}

impl Parameter for f64 {
    const TYPE: &'static str = "float";

    fn value(params: &mut Params, key: &Key<Color>) -> f64 {
        params.take(&Key::float(key.name, key.default.0.into(), key.meaning))
    }

    fn texture(params: &mut TextureParams, key: &Key<ColorTexture>) -> Texture<f64> {
        params.float_texture(key.name, key.default.0.x.into())
    }

    fn pictures(pictures: &Pictures) -> &Cache<f32> {
        &pictures.numbers
    }

    fn pictures_mut(pictures: &mut Pictures) -> &mut Cache<f32> {
        &mut pictures.numbers
    }
}

impl Parameter for Vec3 {
    const TYPE: &'static str = "spectrum";

    fn value(params: &mut Params, key: &Key<Color>) -> Vec3 {
        params.take(key)
    }

    fn texture(params: &mut TextureParams, key: &Key<ColorTexture>) -> Texture<Vec3> {
        params.take_texture(key)
    }

    fn pictures(pictures: &Pictures) -> &Cache<Vec3> {
        &pictures.colors
    }

    fn pictures_mut(pictures: &mut Pictures) -> &mut Cache<Vec3> {
        &mut pictures.colors
    }
}
