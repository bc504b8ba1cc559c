//! `AreaLightSource`: the emission of the following shapes.

use glam::Vec3;
use lookat_syntax::Span;

use super::{N_SAMPLES, RADIANCE, SAMPLES, SCALE, samples, scaled};
use crate::params::Params;
use crate::schema::{Key, Keys, Kind, names};

/// The emission of an area light: `AreaLightSource "diffuse"`, with equal radiance in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Emitted radiance, linear RGB, each component at most 1e18 (parameters `L` times `scale`).
    pub radiance: Vec3,
    /// True if both sides emit. Default: only the side of the normal emits.
    pub two_sided: bool,
    /// Light samples per camera sample in the direct lighting integrator, from 1 to 65,536. Default 1.
    pub samples: u32,
    /// The AreaLightSource directive. `None` for an emission made in code.
    pub span: Option<Span>,
}

impl Emission {
    /// That of a radiance, on the side of the normal.
    pub fn new(radiance: Vec3) -> Emission {
        Emission { radiance, two_sided: false, samples: 1, span: None }
    }

    /// True if the radiance is zero.
    pub fn is_black(&self) -> bool {
        self.radiance == Vec3::ZERO
    }
}

const TWO_SIDED: Key<bool> =
    Key::bool("twosided", false, "true emits on both sides of the surface, false on the side of the normal");

const KEYS: Keys = &[&RADIANCE, &SCALE, &TWO_SIDED, &N_SAMPLES, &SAMPLES];

pub(crate) const AREA_KINDS: &[Kind] = &[
    Kind::new(
        "AreaLightSource",
        "diffuse",
        "equal radiance in all directions of each surface point",
        &[KEYS],
    ),
    Kind::new("AreaLightSource", "area", "an old name of diffuse", &[KEYS]),
];

/// pbrt-v3's CreateDiffuseAreaLight.
pub(crate) fn emission(params: &mut Params) -> Option<Emission> {
    // As in pbrt-v3, an empty type ends the emission of the following shapes.
    if params.kind().is_empty() {
        return None;
    }
    let names = names(AREA_KINDS);
    if !names.contains(&params.kind()) {
        return params.unknown_kind(&names);
    }
    let radiance = scaled(params, &RADIANCE);
    let two_sided = params.take(&TWO_SIDED);
    let samples = samples(params);
    params.finish().then_some(Emission { radiance, two_sided, samples, span: None })
}
