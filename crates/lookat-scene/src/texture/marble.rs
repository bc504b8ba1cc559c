//! `Texture "marble"`: marble layers along y, perturbed by noise. It has color values only.

use super::mapping::number;
use super::octaves::{Octaves, octaves};
use super::{Value, Varying};
use crate::params::Params;
use crate::schema::{Key, Keys};
use crate::transform::Transform;

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

const SCALE: Key<f64> = Key::float("scale", 1.0, "the factor of the position");
const VARIATION: Key<f64> = Key::float("variation", 0.2, "the factor of the noise that moves the layers");

pub(super) const KEYS: Keys = &[&SCALE, &VARIATION];

pub(super) fn marble<T: Value>(params: &mut Params, ctm: Transform) -> Varying<T> {
    let octaves = octaves(params, ctm);
    let [scale, variation] = [&SCALE, &VARIATION].map(|key| number(params, key));
    Varying::Marble(Marble { octaves, scale, variation })
}
