//! `Texture`: named values that vary over surfaces.

mod imagemap;
mod mapping;
mod patterns;

use std::fmt::Debug;
use std::ops::Mul;
use std::sync::Arc;

use glam::Vec3;
use lookat_image::Texel;

use crate::names::Names;
use crate::params::Params;
use crate::params::value::{Color, ColorTexture};
use crate::picture::{FromColor, Pictures};
use crate::schema::{Key, Kind};
use crate::symbols::SymbolKind;
use crate::transform::Transform;

pub use crate::texture::imagemap::{ImageFilter, ImageMap};
pub use crate::texture::mapping::Mapping;
pub use crate::texture::patterns::{Bilerp, Cells, Checkerboard, Dots, Marble, Octaves};

/// A value for each point of a surface: a number (`f64`) or a color (`Vec3`, linear RGB).
#[derive(Debug, Clone)]
pub enum Texture<T: Value> {
    /// One value everywhere (`constant`: `value`, default 1).
    Constant(T),
    /// A value that varies.
    Varying(Arc<Node<T>>),
}

/// A texture that varies, with properties of it and of the textures below it.
#[derive(Debug, Clone)]
pub struct Node<T: Value> {
    pub(crate) texture: Varying<T>,
    properties: Properties,
}

/// Properties of a texture and of the textures below it. A constant has the default.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Properties {
    /// True if the texture footprint changes the value.
    pub filtered: bool,
    /// The number of textures evaluated for one value; 0 for a constant.
    pub cost: u32,
}

impl<T: Value> Node<T> {
    /// The texture.
    #[inline]
    pub fn texture(&self) -> &Varying<T> {
        &self.texture
    }
}

/// A texture that varies.
#[derive(Debug, Clone)]
pub enum Varying<T: Value> {
    /// The product of two textures (`scale`).
    Scale([Texture<T>; 2]),
    /// The first texture where `amount` is 0, the second where it is 1 (`mix`).
    Mix {
        /// The two textures (`tex1`, default 0, and `tex2`, default 1).
        textures: [Texture<T>; 2],
        /// The weight of the second texture (`amount`, default 0.5).
        amount: Texture<f64>,
    },
    /// A picture.
    ImageMap(Box<ImageMap<T>>),
    /// Bilinear interpolation of four corners.
    Bilerp(Bilerp<T>),
    /// The fractions of the coordinates as red and green.
    Uv(Mapping),
    /// Two alternating textures.
    Checkerboard(Checkerboard<T>),
    /// Round dots.
    Dots(Dots<T>),
    /// A sum of noise.
    Fbm(Octaves),
    /// A sum of absolute values of noise.
    Wrinkled(Octaves),
    /// Waves in the wind.
    Windy {
        /// The transformation of world positions.
        texture_from_world: Transform,
    },
    /// Layers of marble.
    Marble(Marble),
}

impl<T: Value> Varying<T> {
    /// The textures directly below it.
    fn parts(&self) -> Vec<AnyTexture<'_>> {
        match self {
            Varying::Mix { textures: [a, b], amount } => {
                vec![T::any(a), T::any(b), AnyTexture::Numbers(amount)]
            }
            Varying::Scale([a, b])
            | Varying::Checkerboard(Checkerboard { textures: [a, b], .. })
            | Varying::Dots(Dots { dots: a, around: b, .. }) => vec![T::any(a), T::any(b)],
            Varying::ImageMap(_)
            | Varying::Bilerp(_)
            | Varying::Uv(_)
            | Varying::Fbm(_)
            | Varying::Wrinkled(_)
            | Varying::Windy { .. }
            | Varying::Marble(_) => Vec::new(),
        }
    }
}

impl<T: Value> Texture<T> {
    /// The value of a constant texture.
    pub fn constant(&self) -> Option<T> {
        match self {
            Texture::Constant(value) => Some(*value),
            Texture::Varying(_) => None,
        }
    }

    fn properties(&self) -> Properties {
        match self {
            Texture::Constant(_) => Properties::default(),
            Texture::Varying(node) => node.properties,
        }
    }

    /// The product of two textures.
    fn product(factors: [Self; 2]) -> Self {
        match &factors {
            [Texture::Constant(a), Texture::Constant(b)] => Texture::Constant(*a * *b),
            _ => Texture::varying(Varying::Scale(factors)),
        }
    }

    /// A texture that varies. It consists of at most 1,000 textures; one used twice counts twice.
    pub fn varying(texture: Varying<T>) -> Self {
        let is_filtered = match &texture {
            Varying::Checkerboard(board) => matches!(board.cells, Cells::Plane { filtered: true, .. }),
            Varying::Scale(_)
            | Varying::Mix { .. }
            | Varying::Dots(_)
            | Varying::Bilerp(_)
            | Varying::Uv(_) => false,
            Varying::ImageMap(_)
            | Varying::Fbm(_)
            | Varying::Wrinkled(_)
            | Varying::Windy { .. }
            | Varying::Marble(_) => true,
        };
        let mut properties = Properties { filtered: is_filtered, cost: 1 };
        for part in texture.parts().into_iter().map(AnyTexture::properties) {
            properties.filtered |= part.filtered;
            properties.cost = properties.cost.saturating_add(part.cost);
        }
        Texture::Varying(Arc::new(Node { texture, properties }))
    }
}

/// A texture of numbers or of colors.
#[derive(Debug, Clone, Copy)]
pub enum AnyTexture<'t> {
    /// Numbers.
    Numbers(&'t Texture<f64>),
    /// Colors.
    Colors(&'t Texture<Vec3>),
}

impl<'t> AnyTexture<'t> {
    pub(crate) fn properties(self) -> Properties {
        match self {
            AnyTexture::Numbers(texture) => texture.properties(),
            AnyTexture::Colors(texture) => texture.properties(),
        }
    }

    /// True if it consists of more than a thousand textures.
    pub(crate) fn is_too_long(self) -> bool {
        self.properties().cost > MOST_TEXTURES
    }

    /// This texture and all below it.
    pub(crate) fn all(self) -> Vec<AnyTexture<'t>> {
        let mut all = vec![self];
        let mut next = 0;
        while let Some(texture) = all.get(next) {
            match texture {
                AnyTexture::Numbers(Texture::Varying(node)) => all.extend(node.texture.parts()),
                AnyTexture::Colors(Texture::Varying(node)) => all.extend(node.texture.parts()),
                _ => {}
            }
            next += 1;
        }
        all
    }

    /// The address and the bytes of its picture.
    pub(crate) fn picture(self) -> Option<(usize, usize)> {
        fn of<T: Value>(texture: &Texture<T>) -> Option<(usize, usize)> {
            let Texture::Varying(node) = texture else { return None };
            let Varying::ImageMap(image) = &node.texture else { return None };
            Some((Arc::as_ptr(&image.map).addr(), image.map.bytes()))
        }
        match self {
            AnyTexture::Numbers(texture) => of(texture),
            AnyTexture::Colors(texture) => of(texture),
        }
    }
}

const VALUE: Key<Color> = Key::color("value", 1.0, "the value; a number in a float texture");

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("constant", "one value everywhere", &[&[&VALUE]]),
    Kind::new("scale", "the product of two textures", &[patterns::SCALE_KEYS]),
    Kind::new("mix", "a blend of two textures", &[patterns::MIX_KEYS]),
    Kind::new(
        "bilerp",
        "bilinear interpolation between the corners of the unit square",
        &[patterns::BILERP_KEYS, mapping::KEYS],
    ),
    Kind::new("imagemap", "a picture", &[imagemap::KEYS, mapping::KEYS]),
    Kind::new(
        "uv",
        "the fractions of the texture coordinates as red and green, for spectrum textures",
        &[mapping::KEYS],
    ),
    Kind::new(
        "checkerboard",
        "two alternating textures in unit squares or cubes",
        &[patterns::CHECKERBOARD_KEYS, mapping::KEYS],
    ),
    Kind::new("dots", "round dots at random places", &[patterns::DOTS_KEYS, mapping::KEYS]),
    Kind::new("fbm", "a sum of noise, like clouds", &[patterns::OCTAVES_KEYS]),
    Kind::new("wrinkled", "a sum of absolute values of noise, with creases", &[patterns::OCTAVES_KEYS]),
    Kind::new(
        "marble",
        "layers of marble along y, for spectrum textures",
        &[patterns::OCTAVES_KEYS, patterns::MARBLE_KEYS],
    ),
    Kind::new("windy", "the height of waves in the wind", &[]),
    Kind::new("ptex", "a Ptex file", &[])
        .ignoring(&[&[
            &Key::string("filename", "the Ptex file"),
            &Key::float("gamma", 2.2, "the exponent of the values of the file"),
        ]])
        .instead("the default of each parameter that names it"),
];

/// The most nested textures. Each level can double the work, so a short file could take forever.
const MOST_TEXTURES: u32 = 1000;

/// Reports a texture that takes too long to evaluate, and a constant that is not finite. True for any other.
fn check<T: Value>(params: &mut Params, texture: &Texture<T>) -> bool {
    if T::any(texture).is_too_long() {
        let message = format!("this texture consists of more than {MOST_TEXTURES} textures");
        let help = "use fewer textures; a texture named by two parameters counts twice, with all its parts";
        params.reject("", message, Some(help));
        return false;
    }
    let is_finite = texture.constant().is_none_or(T::is_finite);
    if !is_finite {
        let help = "use smaller numbers in the textures that it combines";
        params.reject("", "the value of this texture is too large", Some(help));
    }
    is_finite
}

/// The product of two textures; after an error, the second.
pub(crate) fn product<T: Value>(params: &mut Params, [a, b]: [Texture<T>; 2]) -> Texture<T> {
    let product = Texture::product([a, b.clone()]);
    if check(params, &product) { product } else { b }
}

/// pbrt-v3's MakeFloatTexture and MakeSpectrumTexture. `None` for an unsupported texture and after an error.
pub(crate) fn texture<T: Parameter>(
    params: &mut Params,
    ctm: Transform,
    pictures: &mut Pictures,
) -> Option<Texture<T>> {
    let texture = match params.kind() {
        "constant" => Texture::Constant(T::value(params, &VALUE)),
        "scale" => patterns::scale(params),
        "mix" => patterns::mix(params),
        "imagemap" => imagemap::imagemap(params, ctm, pictures)?,
        "bilerp" => patterns::bilerp(params, ctm),
        "uv" => colors(params, ctm, |params, ctm| Varying::Uv(mapping::mapping(params, ctm))),
        "checkerboard" => patterns::checkerboard(params, ctm),
        "dots" => patterns::dots(params, ctm),
        "fbm" => patterns::fbm(params, ctm),
        "wrinkled" => patterns::wrinkled(params, ctm),
        "marble" => colors(params, ctm, patterns::marble),
        "windy" => patterns::windy(ctm),
        kind if params.is_known_kind(KINDS) => {
            let message = format!(
                "lookat does not support Texture \"{kind}\": parameters that name it keep their default"
            );
            params.unsupported(message);
            return None;
        }
        _ => return params.reject_unknown_type(KINDS),
    };
    check(params, &texture);
    params.finish().then_some(texture)
}

/// A texture that has color values only.
fn colors<T: Parameter>(
    params: &mut Params,
    ctm: Transform,
    make: fn(&mut Params, Transform) -> Varying<T>,
) -> Texture<T> {
    let texture = make(params, ctm);
    if T::TYPE == "float" {
        let message = format!("Texture \"{}\" has color values only", params.kind());
        params.reject("", message, Some("declare it as \"spectrum\", and use it for color parameters"));
    }
    Texture::varying(texture)
}

/// A number or a color.
pub trait Value: Copy + Debug + PartialEq + Send + Sync + Mul<Output = Self> + 'static {
    /// The texel type of pictures.
    type Texel: Texel;

    /// Converts a texel.
    fn from_texel(texel: Self::Texel) -> Self;

    /// True if no number of the value is infinite or NaN.
    fn is_finite(self) -> bool;

    /// The texture, where numbers and colors are treated in the same way.
    fn any(texture: &Texture<Self>) -> AnyTexture<'_>;

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

    fn any(texture: &Texture<f64>) -> AnyTexture<'_> {
        AnyTexture::Numbers(texture)
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

    fn any(texture: &Texture<Vec3>) -> AnyTexture<'_> {
        AnyTexture::Colors(texture)
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
    fn texture(params: &mut Params, key: &Key<ColorTexture>) -> Texture<Self>;
}

impl Parameter for f64 {
    const TYPE: &'static str = "float";

    fn value(params: &mut Params, key: &Key<Color>) -> f64 {
        params.take(&Key::float(key.name, key.default.0.x.into(), key.meaning))
    }

    fn texture(params: &mut Params, key: &Key<ColorTexture>) -> Texture<f64> {
        params.take(&Key::float_texture(key.name, key.default.0.x.into(), key.meaning))
    }
}

impl Parameter for Vec3 {
    const TYPE: &'static str = "spectrum";

    fn value(params: &mut Params, key: &Key<Color>) -> Vec3 {
        params.take(key)
    }

    fn texture(params: &mut Params, key: &Key<ColorTexture>) -> Texture<Vec3> {
        params.take(key)
    }
}

/// The textures in scope. An unsupported texture has no value, and parameters that name it keep their default.
#[derive(Clone)]
pub(crate) struct Textures {
    pub float: Names<Option<Texture<f64>>>,
    pub spectrum: Names<Option<Texture<Vec3>>>,
}

impl Default for Textures {
    fn default() -> Self {
        Textures {
            float: Names::new(SymbolKind::FloatTexture),
            spectrum: Names::new(SymbolKind::SpectrumTexture),
        }
    }
}
