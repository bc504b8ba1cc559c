//! Whole pictures: V8 to V15.

use lookat_render::TargetError;
use lookat_scene::{Sampler, SamplerKind};

use super::*;
use crate::coverage::{Known, STRATA, Stratum, edges, fireflies, judge, lens, plain};
use crate::estimate::mean;
use crate::text_scene::green;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("V8", |_| slopes()),
    ("V9", |_| thousand()),
    ("V10", |_| neighbors()),
    ("V11", |_| strata(edges)),
    ("V12", |_| strata(lens)),
    ("V13", |_| rare_light()),
    ("V14", |_| edge_pictures()),
    ("V15", |_| threads()),
];

/// The samplers, with the number of scrambles of a picture. With these, the slope of the first is exact to about 0.006. The first
/// is judged by its slope, all by the correlation of their errors.
const SAMPLERS: [(&str, SamplerKind, u64); 3] = [
    ("lookat sobol", SamplerKind::SOBOL, 8),
    ("lookat stratified", SamplerKind::Stratified { cells: [1, 1], jitter: true }, FEW_SEEDS),
    ("lookat random", SamplerKind::Random, FEW_SEEDS),
];

const FEW_SEEDS: u64 = 2;

/// A part for each sampler, by its number of scrambles. `judged` computes the error of all from those of the samplers.
fn by_sampler(judged: fn([f64; 3]) -> f64, measure: impl Fn(SamplerKind, u64) -> Tally) -> Tally {
    let measured = SAMPLERS.map(|(_, kind, seeds)| measure(kind, seeds));
    let error = judged(measured.each_ref().map(|tally| tally.worst.unwrap_or(f64::NAN)));
    let mut all = Tally::measured(measured[0].tried, error);
    for ((name, ..), tally) in SAMPLERS.iter().zip(&measured) {
        all = all.part(name, tally);
        all.remarks.extend(tally.remarks.iter().map(|remark| format!("{name}: {remark}")));
    }
    all
}

/// The root of the mean square.
fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    mean(&errors.map(|error| error * error).collect::<Vec<_>>()).sqrt()
}

/// The scene with another sampler.
fn sampled(scene: &Scene, kind: SamplerKind, samples: u32) -> Scene {
    let mut scene = scene.clone();
    scene.view.sampler = Sampler { kind, samples_per_pixel: 1 }.with_samples(samples);
    scene
}

/// Pixels on a side of the edge out of focus.
const SIDE: u32 = 16;

/// The pixels of a picture that are neither wholly bright nor wholly dark, with their values.
fn mixed(known: &Known) -> Vec<(usize, f64)> {
    let pixels = known.values.iter().map(|value| value[1]).enumerate();
    pixels.filter(|(_, share)| (0.02..0.98).contains(share)).collect()
}

/// The error of the mixed pixels of the edge, over all scrambles.
fn edge_error(edge: &Known, kind: SamplerKind, samples: u32, seeds: u64) -> f64 {
    let scene = sampled(&edge.scene, kind, samples);
    rms((0..seeds).flat_map(|seed| {
        let pixels = green(&scene, seed);
        mixed(edge).into_iter().map(move |(at, share)| pixels[at] - share)
    }))
}

const COUNTS: [u32; 9] = [16, 32, 64, 128, 256, 512, 1024, 2048, 4096];

fn slopes() -> Tally {
    let edge = lens(SIDE);
    by_sampler(
        |slopes| slopes[0],
        |kind, seeds| {
            let errors = COUNTS.map(|samples| edge_error(&edge, kind, samples, seeds));
            let tried = mixed(&edge).len() as u64 * seeds * COUNTS.len() as u64;
            let remark = format!("RMSE {:.2e} at 16 samples, {:.2e} at 4096", errors[0], errors[8]);
            Tally::measured(tried, slope(&errors)).remark(remark)
        },
    )
}

/// The slope of the line through the logarithms, by least squares. The logarithms of the counts are evenly spaced.
fn slope(errors: &[f64; 9]) -> f64 {
    let from_middle = [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0];
    let product: f64 = from_middle.iter().zip(errors).map(|(x, error)| x * error.log2()).sum();
    product / from_middle.iter().map(|x| x * x).sum::<f64>()
}

fn thousand() -> Tally {
    let edge = lens(SIDE);
    by_sampler(
        |ratios| ratios[0],
        |kind, _| {
            let edges = [1000, 1024].map(|samples| edge_error(&edge, kind, samples, FEW_SEEDS));
            let smooth = [1000, 1024].map(|samples| {
                let pixels = green(&sampled(&plain(WIDE).scene, kind, samples), 0);
                rms(pixels.into_iter().map(|x| x - 0.25))
            });
            let [edges, smooth] = [edges, smooth].map(|[of_1000, of_1024]| of_1000 / of_1024);
            let tried = mixed(&edge).len() as u64 * FEW_SEEDS + u64::from(WIDE * WIDE);
            let remark = format!("{edges:.2} at an edge, {smooth:.2} under a smooth light");
            Tally::measured(tried, edges.max(smooth)).remark(remark)
        },
    )
}

/// Pixels on a side of the pictures that show one point.
const WIDE: u32 = 24;

/// Samples of the pictures whose errors are compared.
const FEW: u32 = 16;

/// Pictures whose errors are compared: chance alone gives correlations of about 0.007.
const PICTURES: u64 = 32;

fn neighbors() -> Tally {
    by_sampler(
        |correlations| correlations.into_iter().fold(f64::NEG_INFINITY, f64::max),
        |kind, _| {
            let scene = sampled(&plain(WIDE).scene, kind, FEW);
            let pictures: Vec<Vec<f64>> = (0..PICTURES).map(|seed| green(&scene, seed)).collect();
            let error = correlation(&pictures, 1).max(correlation(&pictures, WIDE as usize));
            Tally::measured(u64::from(WIDE * WIDE) * 2 * PICTURES, error)
        },
    )
}

/// The correlation of the errors of pixels with those `step` further on. Errors that cancel have one below 0.
fn correlation(pictures: &[Vec<f64>], step: usize) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    for pixels in pictures {
        let mean = mean(pixels);
        let error = |at: usize| pixels[at] - mean;
        for at in (0..pixels.len() - step).filter(|at| step > 1 || (at + 1) % WIDE as usize != 0) {
            products += error(at) * error(at + step);
            squares += 0.5 * (error(at).powi(2) + error(at + step).powi(2));
        }
    }
    products / squares
}

/// The target error. Ten thousand pixels take some seconds.
const TARGET: TargetError = TargetError { relative: 0.1, confidence: 0.95 };

/// The pixels that reach the target, by strata of their value.
fn strata(known: fn(u32) -> Known) -> Tally {
    let (pixels, _) = judge(&known(100), TARGET, 0);
    // The pixels that an edge cuts.
    let strata = STRATA.map(|[from, to]| Stratum::count(&pixels, |p| p.value > from && p.value < to));
    let strata = || strata.iter().filter(|stratum| stratum.promised() > 0);
    let worst = strata().map(|stratum| 1.0 - stratum.coverage()[1]).fold(0.0, f64::max);
    let shares: Vec<String> = strata().map(|stratum| format!("{:.3}", stratum.coverage()[0])).collect();
    let samples = mean(&pixels.iter().map(|pixel| f64::from(pixel.samples)).collect::<Vec<_>>());
    let capped = strata().map(|stratum| stratum.at_cap).sum::<u64>();
    let remark = format!(
        "lookat: shares within the target, from dark to bright, {}; {capped} pixels at the cap; {samples:.0} samples on average",
        shares.join(", ")
    );
    Tally::measured(strata().map(Stratum::promised).sum(), worst).remark(remark)
}

fn rare_light() -> Tally {
    let mut tally = Tally::default();
    // So small that a pixel that missed the bright samples exceeds it.
    let target = TargetError { relative: 0.05, ..TARGET };
    let (pixels, reached) = judge(&fireflies(40), target, 0);
    tally.check(reached.outliers > 0, || "a thousandth of very bright samples is not reported".into());
    let stratum = Stratum::count(&pixels, |_| true);
    tally.remarks.push(format!(
        "{:.3} of the pixels are within the target, which is not promised: {} of {} have outliers",
        stratum.coverage()[0],
        reached.outliers,
        stratum.pixels
    ));
    let (_, reached) = judge(&edges(40), TARGET, 0);
    tally.check(reached.outliers == 0, || format!("{} pixels at edges count as outliers", reached.outliers));
    tally
}

/// The text of a scene by its film and sampler.
fn text(film: &str, sampler: &str, integrator: &str, world: &str) -> String {
    let camera = "LookAt -3 1.5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 60";
    let film = format!("Film \"image\" {film} Sampler {sampler} Integrator {integrator}");
    format!("{camera} {film} WorldBegin {world} WorldEnd")
}

const BALLS: &str = include_str!("scenes/balls.pbrt");

const INTEGRATORS: [&str; 3] = [r#""path""#, r#""directlighting""#, r#""ambientocclusion""#];

/// Films, the samples of each pixel, and the pixels of the picture.
const FILMS: [(&str, u32, usize); 6] = [
    (r#""integer xresolution" 8 "integer yresolution" 8"#, 1, 64),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 1, 1),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 7, 1),
    (r#""integer xresolution" 65536 "integer yresolution" 1"#, 1, 65536),
    (r#""integer xresolution" 1 "integer yresolution" 65536"#, 1, 65536),
    (r#""integer xresolution" 8 "integer yresolution" 8 "float cropwindow" [0.5 0.625 0 0.125]"#, 1, 1),
];

fn edge_pictures() -> Tally {
    let mut tally = Tally::default();
    for (film, samples, pixels) in FILMS {
        for (sampler, integrator) in ["sobol", "halton", "random"].iter().zip(INTEGRATORS) {
            let sampler = format!("\"{sampler}\" \"integer pixelsamples\" {samples}");
            let rgb = render(&scene(&text(film, &sampler, integrator, BALLS)), 0);
            let right = rgb.len() == pixels && rgb.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
            tally.check(right, || format!("{film}, {sampler}: {} pixels, or not finite", rgb.len()));
        }
    }
    tally
}

const BOX: &str = include_str!("scenes/box.pbrt");

const COPIES: &str = include_str!("scenes/copies.pbrt");

fn threads() -> Tally {
    // Neither side is a multiple of the tiles.
    let film = r#""integer xresolution" 50 "integer yresolution" 37"#;
    let scenes = [
        ("path, light in a box", text(film, r#""sobol" "integer pixelsamples" 16"#, INTEGRATORS[0], BOX)),
        ("direct light, copies", text(film, r#""halton" "integer pixelsamples" 16"#, INTEGRATORS[1], COPIES)),
        ("occlusion", text(film, r#""stratified""#, INTEGRATORS[2], BALLS)),
        (
            "lens, wide filter",
            text(film, r#""random" "integer pixelsamples" 9"#, INTEGRATORS[0], BALLS)
                .replace("\"float fov\"", "\"float lensradius\" 0.3 \"float focaldistance\" 3 \"float fov\"")
                .replace("Integrator", "PixelFilter \"mitchell\" Integrator"),
        ),
    ];
    scenes.iter().map(|(name, text)| same_on_threads(name, &scene(text))).collect()
}

/// Checks that a picture is not black, and has the same bits on any number of threads.
pub(super) fn same_on_threads(name: &str, scene: &Scene) -> Tally {
    let mut tally = Tally::default();
    let bits = |threads| render(scene, threads).into_iter().flatten().map(f32::to_bits).collect::<Vec<u32>>();
    let one = bits(1);
    tally.check(one.iter().any(|bits| *bits != 0), || format!("{name}: black"));
    for threads in [2, 7] {
        tally.check(bits(threads) == one, || format!("{name}: {threads} threads give other bits than 1"));
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_of_a_power_is_its_exponent() {
        let errors = COUNTS.map(|count| 3.0 * f64::from(count).powf(-0.75));
        assert!((slope(&errors) + 0.75).abs() < 1e-12);
    }

    #[test]
    fn correlation_tells_copies_from_noise() {
        let mut random = Pcg64Mcg::seed_from_u64(8);
        let side = WIDE as usize;
        let noise: Vec<f64> = (0..side * side).map(|_| between(&mut random, -1.0, 1.0)).collect();
        assert!(
            [1, side].into_iter().all(|step| correlation(std::slice::from_ref(&noise), step).abs() < 0.08)
        );
        let mut last = 0.0;
        let pairs: Vec<f64> = (0..side * side)
            .map(|_| {
                last = if chance(&mut random, 0.5) { between(&mut random, -1.0, 1.0) } else { last };
                last
            })
            .collect();
        assert!((correlation(&[pairs], 1) - 0.5).abs() < 0.08);
    }

    /// The picture of many samples is the closed form.
    #[test]
    fn pictures_are_those_of_the_closed_forms() {
        let edge = lens(SIDE);
        assert!(mixed(&edge).len() > 50);
        assert!(edge_error(&edge, SamplerKind::SOBOL, 256, 1) < 0.02);
    }
}
