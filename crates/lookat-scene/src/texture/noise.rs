//! Sums of noise in space: `Texture "fbm"`, `"wrinkled"`, `"marble"` and `"windy"`.
//!
//! For 3D textures, pbrt-v3 transforms world positions by the current transformation itself. For spherical and
//! cylindrical mappings it uses the inverse.

use super::mapping::number;
use super::{Texture, Value, Varying};
use crate::params::Params;
use crate::schema::{Key, Keys, Range};
use crate::transform::Transform;

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

const OCTAVES: Key<i32> = Key::integer("octaves", 8, "the most octaves of noise; over 64 counts as 64")
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
