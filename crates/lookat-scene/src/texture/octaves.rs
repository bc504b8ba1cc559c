//! Octaves of noise: the common part of `fbm`, `wrinkled` and `marble`.
//!
//! - `octaves`: the number of octaves, default 8
//! - `roughness`: the ratio of amplitudes of successive octaves, default 0.5
//!
//! For 3D textures, pbrt-v3 transforms world positions by the current transformation itself. For spherical and
//! cylindrical mappings it uses the inverse.

use crate::params::Params;
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

/// The largest roughness, which keeps the sum of all octaves finite.
const LARGEST_ROUGHNESS: f64 = 1e4;

pub(super) fn octaves(params: &mut Params, ctm: Transform) -> Octaves {
    let count = params.integer("octaves", 8);
    if count < 0 {
        params.reject("octaves", format!("octaves must be at least 0, not {count}"), None);
    } else if count > MOST {
        let help = "each octave has half the size of the previous one: more than 8 to 12 are rarely visible";
        params.note("octaves", &format!("octaves {count} is limited to {MOST}"), help);
    }
    let roughness = params.float("roughness", 0.5);
    if roughness.abs() > LARGEST_ROUGHNESS {
        let message = format!("the roughness {roughness:e} is above {LARGEST_ROUGHNESS:e}");
        params.reject("roughness", message, Some("the usual range is 0 to 1"));
    }
    Octaves { texture_from_world: ctm, count: count.clamp(0, MOST) as u32, roughness }
}
