//! `Sampler`: how samples are placed, and how many.

use crate::overrides::Overrides;
use crate::params::Params;

/// The sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampler {
    /// The pattern.
    pub kind: SamplerKind,
    /// Samples per pixel, at least 1 (`pixelsamples`; `xsamples` times `ysamples` for the stratified sampler).
    pub samples_per_pixel: u32,
}

/// Patterns of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplerKind {
    /// Independent. Default 4 samples.
    Random,
    /// One in each cell of a grid over each pair of dimensions. Default 4 x 4.
    Stratified {
        /// Cells across and down, at least 1.
        cells: [u32; 2],
        /// At random in the cell, else at its centre. Default true.
        jitter: bool,
    },
    /// Halton's sequence, Owen-scrambled by pixel. pbrt-v3's default sampler, 16 samples.
    Halton {
        /// All camera rays pass through the centre of the pixel. Default false.
        pixel_center: bool,
    },
    /// Sobol's sequence, Owen-scrambled by pixel. Default 16 samples.
    Sobol,
}

impl Sampler {
    /// What pbrt-v3 uses where there is no Sampler.
    pub(crate) const PBRT_DEFAULT: Sampler =
        Sampler { kind: SamplerKind::Halton { pixel_center: false }, samples_per_pixel: 16 };

    /// The same sampler with what it leaves to chance: a stratified one jitters.
    pub fn jittered(self) -> Sampler {
        let kind = match self.kind {
            SamplerKind::Stratified { cells, .. } => SamplerKind::Stratified { cells, jitter: true },
            other => other,
        };
        Sampler { kind, ..self }
    }

    /// The same sampler with another number of samples, at least 1. The cells of a stratified one become the grid nearest
    /// to a square that has as many.
    pub fn with_samples(self, samples_per_pixel: u32) -> Sampler {
        let across =
            || (1..=samples_per_pixel.isqrt()).rev().find(|side| samples_per_pixel.is_multiple_of(*side));
        let kind = match self.kind {
            SamplerKind::Stratified { jitter, .. } => {
                let across = across().unwrap_or(1);
                SamplerKind::Stratified { cells: [samples_per_pixel / across, across], jitter }
            }
            other => other,
        };
        Sampler { kind, samples_per_pixel }
    }
}

pub(crate) const NAMES: &[&str] =
    &["halton", "sobol", "random", "stratified", "02sequence", "lowdiscrepancy", "maxmindist"];

pub(crate) fn sampler(params: &mut Params, overrides: &Overrides) -> Option<Sampler> {
    let (kind, samples) = match params.kind() {
        "random" => (SamplerKind::Random, pixel_samples(params, 4)),
        "halton" => {
            let pixel_center = params.bool("samplepixelcenter", false);
            (SamplerKind::Halton { pixel_center }, pixel_samples(params, 16))
        }
        "sobol" => (SamplerKind::Sobol, pixel_samples(params, 16)),
        "02sequence" | "lowdiscrepancy" | "maxmindist" => {
            let message = format!("Sampler \"{}\" is rendered with \"sobol\"", params.kind());
            params.unsupported(message);
            // How many dimensions are not left to chance: all of them here.
            params.integer("dimensions", 4);
            (SamplerKind::Sobol, pixel_samples(params, 16))
        }
        "stratified" => stratified(params),
        _ => return params.unknown_kind(NAMES),
    };
    params.finish().then(|| overridden(Sampler { kind, samples_per_pixel: samples }, overrides))
}

fn pixel_samples(params: &mut Params, default: i32) -> u32 {
    positive(params, "pixelsamples", default)
}

fn positive(params: &mut Params, name: &'static str, default: i32) -> u32 {
    let count = params.integer(name, default);
    if count < 1 {
        params.reject(name, format!("{name} must be at least 1"), None);
    }
    count.max(1) as u32
}

fn stratified(params: &mut Params) -> (SamplerKind, u32) {
    let jitter = params.bool("jitter", true);
    let cells = [positive(params, "xsamples", 4), positive(params, "ysamples", 4)];
    params.integer("dimensions", 4);
    let samples = cells[0].checked_mul(cells[1]).filter(|samples| *samples <= i32::MAX as u32);
    if samples.is_none() {
        params.reject("xsamples", "xsamples times ysamples is at most 2147483647", None);
    }
    (SamplerKind::Stratified { cells, jitter }, samples.unwrap_or(1))
}

/// The sampler with the number of samples that the command line asks for.
fn overridden(sampler: Sampler, overrides: &Overrides) -> Sampler {
    let samples = overrides.samples_per_pixel.or(overrides.quick.then_some(1));
    samples.map_or(sampler, |samples| sampler.with_samples(samples))
}
