//! Sums of noise, ever finer: what `fbm`, `wrinkled` and `marble` have in common.
//!
//! - `octaves`: how many, default 8
//! - `roughness`: the factor from the height of one to that of the next, default 0.5
//!
//! To positions in the world pbrt-v3 applies the current transformation itself, in all textures in space: not its
//! inverse, as it does where a texture is laid around a sphere or cylinder.

use crate::params::Params;
use crate::transform::Transform;

/// A sum of noise in space.
#[derive(Debug, Clone, Copy)]
pub struct Octaves {
    /// What is applied to positions in the world.
    pub texture_from_world: Transform,
    /// How many at most, 0..=64; those that are finer than the distance of samples are left out.
    pub count: u32,
    /// The factor from one octave to the next.
    pub roughness: f64,
}

/// Each is about twice as fine as the one before: the last is far below the digits of any position.
const MOST: i32 = 64;

/// So that the sum of all octaves is finite.
const LARGEST_ROUGHNESS: f64 = 1e4;

pub(super) fn octaves(params: &mut Params, ctm: Transform) -> Octaves {
    let count = params.integer("octaves", 8);
    if count < 0 {
        params.reject("octaves", format!("{count} octaves: there are at least 0"), None);
    } else if count > MOST {
        let help = "each is half as large as the one before: more than 8 to 12 are seldom seen";
        params.note("octaves", &format!("{count} octaves; lookat adds up {MOST}"), help);
    }
    let roughness = params.float("roughness", 0.5);
    if roughness.abs() > LARGEST_ROUGHNESS {
        let message = format!("a roughness of {roughness:e} is beyond {LARGEST_ROUGHNESS:e}");
        params.reject("roughness", message, Some("it is mostly between 0 and 1"));
    }
    Octaves { texture_from_world: ctm, count: count.clamp(0, MOST) as u32, roughness }
}
