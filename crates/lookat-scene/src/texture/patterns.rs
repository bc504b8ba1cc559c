//! Textures that are computed: products and blends, corners, checkerboards, dots and noise.

use crate::params::Params;
use crate::params::value::{Color, ColorTexture, FloatTexture};
use crate::schema::{Key, Keys, Range};
use crate::texture::mapping::{Mapping, idle, mapping, no_mapping, number};
use crate::texture::{Parameter, Texture, Value, Varying};
use crate::transform::Transform;

const FIRST_FACTOR: Key<ColorTexture> =
    Key::color_texture("tex1", 1.0, "a factor; a number or float texture in a float texture");
const SECOND_FACTOR: Key<ColorTexture> = Key { name: "tex2", ..FIRST_FACTOR };

pub(super) const SCALE_KEYS: Keys = &[&FIRST_FACTOR, &SECOND_FACTOR];

pub(super) fn scale<T: Parameter>(params: &mut Params) -> Texture<T> {
    Texture::product([&FIRST_FACTOR, &SECOND_FACTOR].map(|key| T::texture(params, key)))
}

const MIX_TEX1: Key<ColorTexture> = Key::color_texture(
    "tex1",
    0.0,
    "the value where amount is 0; a number or float texture in a float texture",
);
const MIX_TEX2: Key<ColorTexture> = Key::color_texture(
    "tex2",
    1.0,
    "the value where amount is 1; a number or float texture in a float texture",
);
const AMOUNT: Key<FloatTexture> = Key::float_texture("amount", 0.5, "the share of tex2");

pub(super) const MIX_KEYS: Keys = &[&MIX_TEX1, &MIX_TEX2, &AMOUNT];

pub(super) fn mix<T: Parameter>(params: &mut Params) -> Texture<T> {
    let textures = [&MIX_TEX1, &MIX_TEX2].map(|key| T::texture(params, key));
    let amount = params.take(&AMOUNT);
    match (&textures, &amount) {
        ([Texture::Constant(a), Texture::Constant(b)], Texture::Constant(amount)) => {
            Texture::Constant(T::mix(*a, *b, *amount))
        }
        _ => Texture::varying(Varying::Mix { textures, amount }),
    }
}

/// The values at four corners. They are extrapolated outside the square.
#[derive(Debug, Clone)]
pub struct Bilerp<T> {
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The values at s = 0 for t = 0 and 1, then at s = 1.
    pub corners: [[T; 2]; 2],
}

const V00: Key<Color> = Key::color("v00", 0.0, "the value at s = 0, t = 0; a number in a float texture");
const V01: Key<Color> = Key::color("v01", 1.0, "the value at s = 0, t = 1; a number in a float texture");
const V10: Key<Color> = Key::color("v10", 0.0, "the value at s = 1, t = 0; a number in a float texture");
const V11: Key<Color> = Key::color("v11", 1.0, "the value at s = 1, t = 1; a number in a float texture");

pub(super) const BILERP_KEYS: Keys = &[&V00, &V01, &V10, &V11];

pub(super) fn bilerp<T: Parameter>(params: &mut Params, world_from_texture: Transform) -> Texture<T> {
    let corners = [[&V00, &V01], [&V10, &V11]].map(|keys| keys.map(|key| T::value(params, key)));
    let mapping = mapping(params, world_from_texture);
    let [[first, a], [b, c]] = corners;
    if [a, b, c] == [first; 3] {
        return Texture::Constant(first);
    }
    Texture::varying(Varying::Bilerp(Bilerp { mapping, corners }))
}

/// Two alternating textures.
#[derive(Debug, Clone)]
pub struct Checkerboard<T: Value> {
    /// The textures of even and odd cells (`tex1`, `tex2`).
    pub textures: [Texture<T>; 2],
    /// The cells.
    pub cells: Cells,
}

/// The unit cells of a checkerboard.
#[derive(Debug, Clone)]
pub enum Cells {
    /// Squares.
    Plane {
        /// The texture coordinate mapping.
        mapping: Mapping,
        /// True to average over the texture footprint (`aamode`).
        filtered: bool,
    },
    /// Cubes.
    Space {
        /// The transformation of world positions.
        texture_from_world: Transform,
    },
}

const DIMENSION: Key<i32> =
    Key::integer("dimension", 2, "2 for squares of the texture coordinates, 3 for cubes in space")
        .within(Range::from_to(2.0, 3.0));
const CHECKERBOARD_TEX1: Key<ColorTexture> = Key::color_texture(
    "tex1",
    1.0,
    "the value of cells with an even sum of coordinates; a number or float texture in a float texture",
);
const CHECKERBOARD_TEX2: Key<ColorTexture> = Key::color_texture(
    "tex2",
    0.0,
    "the value of cells with an odd sum of coordinates; a number or float texture in a float texture",
);
const AA_MODE: Key<&[&str]> = Key::choice(
    "aamode",
    &["closedform", "none"],
    "for dimension 2, whether squares are averaged over the texture footprint",
);

pub(super) const CHECKERBOARD_KEYS: Keys = &[&DIMENSION, &CHECKERBOARD_TEX1, &CHECKERBOARD_TEX2, &AA_MODE];

pub(super) fn checkerboard<T: Parameter>(params: &mut Params, ctm: Transform) -> Texture<T> {
    let dimension = params.take(&DIMENSION);
    let textures = [&CHECKERBOARD_TEX1, &CHECKERBOARD_TEX2].map(|key| T::texture(params, key));
    let cells = match dimension {
        3 => {
            idle(params, &[&AA_MODE], "dimension 3", "cubes are not averaged over the texture footprint");
            no_mapping(params, "dimension 3");
            Cells::Space { texture_from_world: ctm }
        }
        _ => {
            let filtered = params.take(&AA_MODE) == "closedform";
            Cells::Plane { mapping: mapping(params, ctm), filtered }
        }
    };
    match textures {
        [Texture::Constant(a), Texture::Constant(b)] if a == b => Texture::Constant(a),
        _ => Texture::varying(Varying::Checkerboard(Checkerboard { textures, cells })),
    }
}

// `Texture "dots"`: round dots in about two of five unit squares.
//
// pbrt-v3 swaps the names `inside` and `outside`, and lookat follows pbrt-v3.

/// Dots at random places.
#[derive(Debug, Clone)]
pub struct Dots<T: Value> {
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The texture of the dots (`outside`).
    pub dots: Texture<T>,
    /// The texture around the dots (`inside`).
    pub around: Texture<T>,
}

const INSIDE: Key<ColorTexture> = Key::color_texture(
    "inside",
    1.0,
    "the value around the dots, as in pbrt-v3; a number or float texture in a float texture",
);
const OUTSIDE: Key<ColorTexture> = Key::color_texture(
    "outside",
    0.0,
    "the value of the dots, as in pbrt-v3; a number or float texture in a float texture",
);

pub(super) const DOTS_KEYS: Keys = &[&INSIDE, &OUTSIDE];

pub(super) fn dots<T: Parameter>(params: &mut Params, ctm: Transform) -> Texture<T> {
    let around = T::texture(params, &INSIDE);
    let dots = T::texture(params, &OUTSIDE);
    let mapping = mapping(params, ctm);
    match (&dots, &around) {
        (Texture::Constant(a), Texture::Constant(b)) if a == b => Texture::Constant(*a),
        _ => Texture::varying(Varying::Dots(Dots { mapping, dots, around })),
    }
}

// Sums of noise in space: `Texture "fbm"`, `"wrinkled"`, `"marble"` and `"windy"`.
//
// For 3D textures, pbrt-v3 transforms world positions by the current transformation itself. For spherical and
// cylindrical mappings it uses the inverse.

/// A sum of noise in space.
#[derive(Debug, Clone, Copy)]
pub struct Octaves {
    /// The transformation of world positions.
    pub texture_from_world: Transform,
    /// The most octaves, 0 to 64. Octaves finer than the texture footprint are skipped.
    pub count: u32,
    /// The ratio of amplitudes of successive octaves, from -1e4 to 1e4.
    pub roughness: f64,
}

/// Layers of marble.
#[derive(Debug, Clone, Copy)]
pub struct Marble {
    /// The noise.
    pub octaves: Octaves,
    /// The factor on the position.
    pub scale: f64,
    /// The factor on the noise.
    pub variation: f64,
}

impl Octaves {
    /// The most octaves. Each has about twice the frequency of the previous one, so the last is far below the precision
    /// of any position.
    pub(crate) const MOST: u32 = 64;
    /// The largest roughness keeps the sum of all octaves finite.
    pub(crate) const ROUGHNESS_RANGE: Range = Range::from_to(-1e4, 1e4);
}

const OCTAVES: Key<i32> =
    Key::integer("octaves", 8, "the largest number of octaves of noise; over 64 counts as 64")
        .within(Range::at_least(0.0));
const ROUGHNESS: Key<f64> =
    Key::float("roughness", 0.5, "the ratio of amplitudes of successive octaves, usually from 0 to 1")
        .within(Octaves::ROUGHNESS_RANGE);

const SCALE: Key<f64> = Key::float("scale", 1.0, "the factor of the position");
const VARIATION: Key<f64> = Key::float("variation", 0.2, "the factor of the noise that moves the layers");

pub(super) const OCTAVES_KEYS: Keys = &[&OCTAVES, &ROUGHNESS];
pub(super) const MARBLE_KEYS: Keys = &[&SCALE, &VARIATION];

fn octaves(params: &mut Params, ctm: Transform) -> Octaves {
    let (count, most) = (params.take(&OCTAVES), Octaves::MOST);
    if count as u32 > most {
        let help = "each octave has half the size of the previous one: more than 8 to 12 are rarely visible";
        params.note("octaves", &format!("octaves {count} is limited to {most}"), help);
    }
    let roughness = params.take(&ROUGHNESS);
    Octaves { texture_from_world: ctm, count: most.min(count as u32), roughness }
}

/// A sum of noise, like clouds, about -1..1 (fractional Brownian motion).
pub(super) fn fbm<T: Value>(params: &mut Params, ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Fbm(octaves(params, ctm)))
}

/// Turbulence: a sum of absolute noise values with creases at 0.
pub(super) fn wrinkled<T: Value>(params: &mut Params, ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Wrinkled(octaves(params, ctm)))
}

/// Marble layers along y, perturbed by noise. They have color values only.
pub(super) fn marble<T: Value>(params: &mut Params, ctm: Transform) -> Varying<T> {
    let octaves = octaves(params, ctm);
    let [scale, variation] = [&SCALE, &VARIATION].map(|key| number(params, key));
    Varying::Marble(Marble { octaves, scale, variation })
}

/// The height of waves under varying wind. It has no parameters.
pub(super) fn windy<T: Value>(ctm: Transform) -> Texture<T> {
    Texture::varying(Varying::Windy { texture_from_world: ctm })
}
