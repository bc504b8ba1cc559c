//! `Sampler`: the sample pattern and the number of samples.

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

/// The sample pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplerKind {
    /// Independent uniform samples. Default 4 samples.
    Random,
    /// One sample in each cell of a grid over each pair of dimensions. Default 4 x 4.
    Stratified {
        /// The cells along x and y, at least 1.
        cells: [u32; 2],
        /// If true, a random point in the cell; if false, its center. Default true.
        jitter: bool,
    },
    /// The Halton sequence, Owen-scrambled per pixel. The default sampler of pbrt-v3, with 16 samples.
    Halton {
        /// If true, all camera rays pass through the pixel center. Default false.
        pixel_center: bool,
    },
    /// The Sobol' sequence, Owen-scrambled per pixel. Default 16 samples.
    Sobol,
}

impl Sampler {
    /// The sampler of pbrt-v3 without a Sampler directive.
    pub(crate) const PBRT_DEFAULT: Sampler =
        Sampler { kind: SamplerKind::Halton { pixel_center: false }, samples_per_pixel: 16 };

    /// The same sampler with jitter.
    pub fn jittered(self) -> Sampler {
        let kind = match self.kind {
            SamplerKind::Stratified { cells, .. } => SamplerKind::Stratified { cells, jitter: true },
            other => other,
        };
        Sampler { kind, ..self }
    }

    /// The same sampler with another number of samples, at least 1. A stratified sampler uses the grid of that size
    /// nearest to a square. If that grid is more than twice as wide as high, a jittered sampler uses a slightly
    /// larger one.
    pub fn with_samples(self, samples_per_pixel: u32) -> Sampler {
        let kind = match self.kind {
            SamplerKind::Stratified { jitter, .. } => {
                SamplerKind::Stratified { cells: grid(samples_per_pixel, jitter), jitter }
            }
            other => other,
        };
        Sampler { kind, samples_per_pixel }
    }
}

/// The cells along x and y for a number of samples. Without jitter every cell is needed, because a missing one would
/// be missing in every pixel.
fn grid(samples: u32, jitter: bool) -> [u32; 2] {
    let root = samples.isqrt();
    let down = (1..=root).rev().find(|down| samples.is_multiple_of(*down)).unwrap_or(1);
    let across = samples / down;
    if across <= 2 * down || !jitter {
        return [across, down];
    }
    let across = root + u32::from(root * root < samples);
    [across, samples.div_ceil(across)]
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
            let message = format!("lookat renders Sampler \"{}\" with \"sobol\"", params.kind());
            params.replaced(message, "the picture is the same apart from its noise");
            // The number of stratified dimensions in pbrt-v3. lookat stratifies all dimensions.
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
        params.reject("xsamples", "xsamples times ysamples must be at most 2147483647", None);
    }
    (SamplerKind::Stratified { cells, jitter }, samples.unwrap_or(1))
}

/// The sampler with the caller's number of samples.
fn overridden(sampler: Sampler, overrides: &Overrides) -> Sampler {
    let samples = overrides.samples_per_pixel.or(overrides.quick.then_some(1));
    samples.map_or(sampler, |samples| sampler.with_samples(samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_near_squares() {
        let cells = |samples, jitter| {
            let sampler =
                Sampler { kind: SamplerKind::Stratified { cells: [4, 4], jitter }, samples_per_pixel: 16 };
            match sampler.with_samples(samples).kind {
                SamplerKind::Stratified { cells, .. } => cells,
                _ => [0, 0],
            }
        };
        let expected = [(1, [1, 1]), (2, [2, 1]), (3, [2, 2]), (5, [3, 2]), (7, [3, 3]), (8, [4, 2])];
        for (samples, grid) in expected.into_iter().chain([(13, [4, 4]), (14, [4, 4]), (15, [5, 3])]) {
            assert_eq!(cells(samples, true), grid, "{samples}");
        }
        assert_eq!((cells(13, false), cells(12, false)), ([13, 1], [4, 3]));
        for samples in (1..1000).chain([u32::MAX / 2, u32::MAX / 2 - 1]) {
            let [across, down] = cells(samples, true);
            assert!(
                across * down >= samples && across <= 2 * down && across * down - samples <= across,
                "{samples}"
            );
        }
    }
}
