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

pub(super) const KEYS: Keys = &[&OCTAVES, &ROUGHNESS];

pub(super) fn octaves(params: &mut Params, ctm: Transform) -> Octaves {
    let (count, most) = (params.take(&OCTAVES), Octaves::MOST);
    if count as u32 > most {
        let help = "each octave has half the size of the previous one: more than 8 to 12 are rarely visible";
        params.note("octaves", &format!("octaves {count} is limited to {most}"), help);
    }
    let roughness = params.take(&ROUGHNESS);
    Octaves { texture_from_world: ctm, count: most.min(count as u32), roughness }
}
