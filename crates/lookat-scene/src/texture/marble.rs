//! `Texture "marble"`: marble layers along y, perturbed by noise. It has color values only.
//!
//! - `octaves`, default 8, and `roughness`, default 0.5: see [`Octaves`]
//! - `scale`: factor on the position, default 1
//! - `variation`: factor on the noise that moves the layers, default 0.2

use super::octaves::{Octaves, octaves};
use super::{Value, Varying};
use crate::params::Params;
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

pub(super) fn marble<T: Value>(params: &mut Params, ctm: Transform) -> Varying<T> {
    let octaves = octaves(params, ctm);
    let [scale, variation] = [("scale", 1.0), ("variation", 0.2)].map(|(name, default)| {
        let value = params.float(name, default);
        params.check_range(name, &[value]);
        value
    });
    Varying::Marble(Marble { octaves, scale, variation })
}
