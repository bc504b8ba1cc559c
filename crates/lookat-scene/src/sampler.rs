//! `Sampler`: the sample pattern and the number of samples.

use lookat_syntax::Diagnostic;

use crate::params::Params;
use crate::schema::{Effect, Key, Keys, Kind, Range};

/// The most samples per pixel of one picture: sums of more could overflow.
pub const MAX_SAMPLES: u32 = 1 << 30;

/// The sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampler {
    /// The pattern.
    pub kind: SamplerKind,
    /// Samples per pixel, from 1 to [`MAX_SAMPLES`] (`pixelsamples`; `xsamples` times `ysamples` for the stratified sampler).
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
    /// The Sobol' sequence, Owen-scrambled; also for `halton`, the default of pbrt-v3. Default 16 samples.
    Sobol {
        /// If true, all camera rays pass through the pixel center (`samplepixelcenter` of `halton`). Default false.
        pixel_center: bool,
    },
}

impl SamplerKind {
    /// The Sobol' sequence everywhere in the pixel.
    pub const SOBOL: SamplerKind = SamplerKind::Sobol { pixel_center: false };
}

impl Sampler {
    /// The sampler of pbrt-v3 without a Sampler directive.
    pub(crate) const PBRT_DEFAULT: Sampler = Sampler { kind: SamplerKind::SOBOL, samples_per_pixel: 16 };

    /// This sampler with jitter.
    pub fn jittered(self) -> Sampler {
        let kind = match self.kind {
            SamplerKind::Stratified { cells, .. } => SamplerKind::Stratified { cells, jitter: true },
            other => other,
        };
        Sampler { kind, ..self }
    }

    /// This sampler with another number of samples, from 1 to [`MAX_SAMPLES`]; more counts as that many. A stratified sampler uses the grid of that size
    /// nearest to a square. If that grid is more than twice as wide as high, a jittered sampler uses a slightly
    /// larger one.
    pub fn with_samples(self, samples_per_pixel: u32) -> Sampler {
        let samples_per_pixel = samples_per_pixel.min(MAX_SAMPLES);
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

const fn samples(name: &'static str, default: i32, meaning: &'static str) -> Key<i32> {
    Key::integer(name, default, meaning).within(Range::from_to(1.0, MAX_SAMPLES as f64))
}

const PIXEL_SAMPLES: Key<i32> = samples("pixelsamples", 16, "the number of samples in each pixel");
const FEW_PIXEL_SAMPLES: Key<i32> = Key { default: 4, ..PIXEL_SAMPLES };
const PIXEL_CENTER: Key<bool> =
    Key::bool("samplepixelcenter", false, "true sends all camera rays through the pixel center");
const JITTER: Key<bool> =
    Key::bool("jitter", true, "true takes a random point of each cell, false its center");
const X_SAMPLES: Key<i32> = samples("xsamples", 4, "the number of cells along x in each pixel");
const Y_SAMPLES: Key<i32> = samples("ysamples", 4, "the number of cells along y in each pixel");
/// Here all dimensions are stratified.
const DIMENSIONS: Key<i32> =
    Key::integer("dimensions", 4, "the number of stratified dimensions").effect(Effect::NoEffect);

const SUBSTITUTED: Keys = &[&PIXEL_SAMPLES, &DIMENSIONS];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("halton", "a Halton sequence; lookat uses sobol instead", &[&[&PIXEL_SAMPLES, &PIXEL_CENTER]])
        .by_default(),
    Kind::new("sobol", "the Sobol' sequence, scrambled", &[&[&PIXEL_SAMPLES]]),
    Kind::new("random", "independent samples", &[&[&FEW_PIXEL_SAMPLES]]),
    Kind::new(
        "stratified",
        "one sample in each cell of a grid",
        &[&[&X_SAMPLES, &Y_SAMPLES, &JITTER, &DIMENSIONS]],
    ),
    Kind::new("02sequence", "a (0, 2)-sequence", &[SUBSTITUTED]).instead("sobol"),
    Kind::new("lowdiscrepancy", "another name of 02sequence", &[SUBSTITUTED]).instead("sobol"),
    Kind::new("maxmindist", "points with a maximized minimum distance", &[SUBSTITUTED]).instead("sobol"),
];

pub(crate) fn sampler(params: &mut Params) -> Option<Sampler> {
    let (kind, samples) = match params.kind() {
        "random" => (SamplerKind::Random, params.take(&FEW_PIXEL_SAMPLES)),
        "halton" => {
            let pixel_center = params.take(&PIXEL_CENTER);
            (SamplerKind::Sobol { pixel_center }, params.take(&PIXEL_SAMPLES))
        }
        "sobol" => (SamplerKind::SOBOL, params.take(&PIXEL_SAMPLES)),
        "02sequence" | "lowdiscrepancy" | "maxmindist" => {
            let message = format!("lookat renders Sampler \"{}\" with \"sobol\"", params.kind());
            let help = "the picture is the same apart from its noise";
            params.push(Diagnostic::note_at(params.kind_text().span, message).help(help));
            params.take(&DIMENSIONS);
            (SamplerKind::SOBOL, params.take(&PIXEL_SAMPLES))
        }
        "stratified" => stratified(params),
        _ => return params.reject_unknown_type(KINDS),
    };
    params.finish().then_some(Sampler { kind, samples_per_pixel: samples as u32 })
}

fn stratified(params: &mut Params) -> (SamplerKind, i32) {
    let jitter = params.take(&JITTER);
    let [across, down] = [&X_SAMPLES, &Y_SAMPLES].map(|key| params.take(key));
    params.take(&DIMENSIONS);
    let samples = across.checked_mul(down).filter(|samples| *samples as u32 <= MAX_SAMPLES);
    if samples.is_none() {
        let message = format!("xsamples times ysamples must be at most {MAX_SAMPLES}");
        params.reject("xsamples", message, None);
    }
    (SamplerKind::Stratified { cells: [across as u32, down as u32], jitter }, samples.unwrap_or(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_a_limit() {
        assert_eq!(Sampler::PBRT_DEFAULT.with_samples(u32::MAX).samples_per_pixel, MAX_SAMPLES);
        let is_read = |sampler: &str| {
            crate::load_str(&format!("Sampler {sampler} WorldBegin Shape \"sphere\" WorldEnd"))
                .scene
                .is_some()
        };
        assert!(is_read("\"halton\" \"integer pixelsamples\" 1073741824"));
        assert!(!is_read("\"halton\" \"integer pixelsamples\" 1073741825"));
        assert!(is_read("\"stratified\" \"integer xsamples\" 32768 \"integer ysamples\" 32768"));
        assert!(!is_read("\"stratified\" \"integer xsamples\" 32769 \"integer ysamples\" 32768"));
    }

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
        for samples in (1..1000).chain([MAX_SAMPLES, MAX_SAMPLES - 1]) {
            let [across, down] = cells(samples, true);
            assert!(
                across * down >= samples && across <= 2 * down && across * down - samples <= across,
                "{samples}"
            );
        }
    }
}
