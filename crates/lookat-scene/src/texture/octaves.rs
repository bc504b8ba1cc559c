//! Octaves of noise: the common part of `fbm`, `wrinkled` and `marble`.
//!
//! For 3D textures, pbrt-v3 transforms world positions by the current transformation itself. For spherical and
//! cylindrical mappings it uses the inverse.

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
    /// The ratio of amplitudes of successive octaves.
    pub roughness: f64,
}

/// The most octaves. Each has about twice the frequency of the previous one, so the last is far below the precision
/// of any position.
const MOST: i32 = 64;

const OCTAVES: Key<i32> = Key::integer("octaves", 8, "the most octaves of noise; over 64 counts as 64")
    .within(Range::at_least(0.0));
/// The largest roughness keeps the sum of all octaves finite.
const ROUGHNESS: Key<f64> =
    Key::float("roughness", 0.5, "the ratio of amplitudes of successive octaves, usually from 0 to 1")
        .within(Range::from_to(-1e4, 1e4));

pub(super) const KEYS: Keys = &[&OCTAVES, &ROUGHNESS];

pub(super) fn octaves(params: &mut Params, ctm: Transform) -> Octaves {
    let count = params.take(&OCTAVES);
    if count > MOST {
        let help = "each octave has half the size of the previous one: more than 8 to 12 are rarely visible";
        params.note("octaves", &format!("octaves {count} is limited to {MOST}"), help);
    }
    let roughness = params.take(&ROUGHNESS);
    Octaves { texture_from_world: ctm, count: count.min(MOST) as u32, roughness }
}
