use super::*;
use crate::{PixelError, Precision};

const WIDTH: u32 = 36;
const HEIGHT: u32 = 30;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

fn pixels<T>(of: impl Fn(usize, usize) -> T) -> Vec<[T; 3]> {
    (0..PIXELS).map(|i| std::array::from_fn(|channel| of(i, channel))).collect()
}

fn values(step: usize) -> Vec<[f32; 3]> {
    pixels(|i, c| (1.0 + c as f64 + 0.01 * (((i * (7 + step) + 3 * c) % 23) as f64 - 11.0)) as f32)
}

fn errors(step: usize, factor: f32, samples: u32) -> Vec<PixelError> {
    let errors = pixels(|i, c| (0.05 + 0.01 * ((i * (5 + step) + c) % 7) as f64) as f32 * factor);
    errors
        .into_iter()
        .map(|standard_error| PixelError { standard_error, samples, replicates: 16, ..PixelError::default() })
        .collect()
}

/// Two pictures of noise, of 64 and 128 samples; the first one is brighter in the green of the first tile.
fn sample() -> Aligned {
    let mut actual = values(0);
    for (i, pixel) in actual.iter_mut().enumerate() {
        if i % WIDTH as usize / 16 + i / WIDTH as usize / 16 == 0 {
            pixel[1] = (f64::from(pixel[1]) + 0.03) as f32;
        }
    }
    Aligned {
        window: Window { x: 100, y: 50, width: WIDTH, height: HEIGHT },
        actual,
        expected: values(4),
        actual_errors: Some(errors(0, 1.0, 64)),
        expected_errors: Some(errors(6, 0.5, 128)),
        precision: Precision::Single,
        left_out: 0,
        is_placed: [false; 2],
    }
}

fn close(actual: f64, expected: f64) {
    assert!((actual - expected).abs() <= 1e-6 * expected.abs(), "{actual}, not {expected}");
}

#[test]
fn agrees_with_scipy() {
    // SciPy 1.17, from the formulas.
    let found = agreement(&sample()).unwrap();
    let check = |test: &Test, [difference, standard_error, p]: [f64; 3]| {
        close(test.difference, difference);
        close(test.standard_error, standard_error);
        close(test.p, p);
    };
    check(&found.means[0], [-3.703700171576606e-05, 0.002837891407815281, 0.9895873252702669]);
    check(&found.means[1], [0.007074067327711317, 0.002848934968524814, 0.013034205709591417]);
    check(&found.tiles[6], [0.029296846129000187, 0.005861490845223758, 5.996799818199712e-07]);
    check(&found.tiles[17], [0.0001785712582724435, 0.012727521625628803, 0.988808418187675]);
    check(&found.paired[0], [-3.703700171576606e-05, 0.002791204575930368, 0.9894154881293725]);
    check(&found.paired[1], [0.007074067327711317, 0.0031581159851912345, 0.02529622457774048]);
    for (test, [ratio, p]) in found.pixels.iter().zip([
        [1.0838526160002524, 0.03580853738139882],
        [1.3010367387281763, 5.046367353416635e-11],
        [0.9984669365359957, 0.5131080176476336],
    ]) {
        close(test.ratio, ratio);
        close(test.p, p);
        assert_eq!(test.pixels, PIXELS);
    }
    close(found.p, 9.083461236149943e-10);
    close(found.visible_in_mean(0.01), 0.014770663316607043);
    assert_eq!([0.01, 1e-10].map(|level| found.holds(level)), [Some(false), Some(true)]);
    let tiles = found.differing_tiles(0.01);
    assert_eq!(tiles, [found.tiles[6]]);
    assert_eq!(tiles[0].window, Window { x: 100, y: 50, width: 16, height: 16 });
}

#[test]
fn without_errors_nothing_is_told() {
    let refuses = |pair: &Aligned, expected| assert_eq!(agreement(pair), Err(expected));
    refuses(&Aligned { actual_errors: None, ..sample() }, Untestable::NoErrors);
    refuses(&Aligned { precision: Precision::Integer, ..sample() }, Untestable::Rounded);
    // One pixel is enough.
    let unknown =
        PixelError { standard_error: [f32::INFINITY; 3], samples: 1, replicates: 1, ..PixelError::default() };
    let mut pair = sample();
    pair.expected_errors.as_mut().unwrap()[7] = unknown;
    refuses(&pair, Untestable::Expected { pixels: 1 });
    pair.actual_errors.as_mut().unwrap()[8] = unknown;
    refuses(&pair, Untestable::Actual { pixels: 1, needed: 2 });
}

/// Noise of the expected picture that is not known shows in how the differences scatter; the mean of a tile does not.
#[test]
fn unknown_noise_is_seen_in_the_scatter() {
    let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16, ..PixelError::default() };
    let mut pair = Aligned { actual_errors: Some(vec![still; PIXELS]), expected_errors: None, ..sample() };
    pair.actual = vec![[1.0, 2.0, 3.0]; PIXELS];
    let found = agreement(&pair).unwrap();
    assert!(
        !found.expected_is_known && found.pixels.is_empty() && found.holds(0.01) == Some(true),
        "{}",
        found.p
    );
    pair.actual.iter_mut().for_each(|pixel| pixel[2] += 0.1);
    assert!(agreement(&pair).unwrap().holds(1e-6) == Some(false));
}

/// A reference that says nothing of its noise may be the noisier one: all differences together tell by how much.
#[test]
fn the_noise_of_the_reference_is_guessed() {
    let mut pair = Aligned { expected_errors: None, ..sample() };
    pair.actual.clone_from(&pair.expected);
    for pixel in &mut pair.actual[..16] {
        pixel[0] += 0.5;
    }
    let before = agreement(&pair).unwrap();
    assert!(before.holds(0.01) == Some(false));
    // Far from there, in other tiles.
    for pixel in pair.expected.iter_mut().skip(PIXELS / 2).step_by(9) {
        pixel[0] += 3.0;
    }
    let after = agreement(&pair).unwrap();
    assert!(after.tiles[0].standard_error > 3.0 * before.tiles[0].standard_error && after.tiles[0].p > 0.1);
    // One pixel is no noise of all others.
    let mut pair = Aligned { expected_errors: None, ..sample() };
    pair.actual.clone_from(&pair.expected);
    pair.actual.iter_mut().for_each(|pixel| pixel[2] += 0.05);
    pair.expected[40] = [1e4; 3];
    assert!(agreement(&pair).unwrap().holds(1e-6) == Some(false));
    // Too few tell nothing.
    pair.window = Window { width: 9, height: 9, ..pair.window };
    pair.actual.truncate(81);
    pair.expected.truncate(81);
    pair.actual_errors.as_mut().unwrap().truncate(81);
    assert_eq!(agreement(&pair), Err(Untestable::Small { needed: 100 }));
}

/// Few samples say nothing of skewed noise: neither where only they are known, nor against many.
#[test]
fn few_samples_are_not_believed() {
    let mut pair = sample();
    pair.expected_errors = None;
    assert!(agreement(&pair).is_ok());
    pair.actual_errors.as_mut().unwrap().iter_mut().for_each(|error| error.samples = 31);
    assert_eq!(agreement(&pair), Err(Untestable::Actual { pixels: PIXELS, needed: 32 }));
    pair.expected_errors = Some(errors(6, 0.5, 1024));
    let found = agreement(&pair).unwrap();
    assert!(found.pixels.is_empty() && found.paired.is_empty());
}

/// A render may miss light that a reference has in one pixel, but not in a dozen of one tile.
#[test]
fn rare_events_of_a_reference_without_errors_are_no_difference() {
    let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16, ..PixelError::default() };
    let mut pair = Aligned { actual_errors: Some(vec![still; PIXELS]), expected_errors: None, ..sample() };
    pair.actual = vec![[0.0; 3]; PIXELS];
    pair.expected.clone_from(&pair.actual);
    pair.expected[7] = [1e-3; 3];
    assert!(agreement(&pair).unwrap().holds(0.1) == Some(true));
    // A dozen are suspicious, but may be rare light.
    pair.expected
        .chunks_mut(2 * WIDTH as usize)
        .take(4)
        .flat_map(|rows| rows[..9].iter_mut().step_by(3))
        .for_each(|it| *it = [1e-3; 3]);
    let found = agreement(&pair).unwrap();
    assert!(found.p < 1e-5 && found.holds(0.01).is_none() && found.tail_index(0.01) < 1.0, "{found:?}");
    // Not if the expected picture misses them: the other one knows how rare they are.
    std::mem::swap(&mut pair.actual, &mut pair.expected);
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(false));
    // A feature of some size is no rare light.
    std::mem::swap(&mut pair.actual, &mut pair.expected);
    pair.expected.chunks_mut(WIDTH as usize).take(8).for_each(|row| row[..8].fill([1e-3; 3]));
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(false));
}

/// A feature that the actual picture lacks, in pixels that know no light: no number of samples would ever decide.
#[test]
fn a_feature_is_no_rare_light() {
    let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16, ..PixelError::default() };
    let black = vec![[0.0; 3]; PIXELS];
    let holds = |value: &dyn Fn(f64, f64) -> f32| {
        let expected = (0..PIXELS)
            .map(|i| [value((i % WIDTH as usize) as f64, (i / WIDTH as usize) as f64); 3])
            .collect();
        let actual_errors = Some(vec![still; PIXELS]);
        let pair =
            Aligned { actual: black.clone(), expected, actual_errors, expected_errors: None, ..sample() };
        agreement(&pair).unwrap().holds(0.01)
    };
    let block = |at: [f64; 2], size: [f64; 2]| {
        move |x: f64, y: f64| {
            let is_inside = |at: f64, size: f64, x: f64| x >= at && x < at + size;
            f32::from(u8::from(is_inside(at[0], size[0], x) && is_inside(at[1], size[1], y)))
        }
    };
    for size in [[4.0, 3.0], [3.0, 4.0], [12.0, 1.0], [1.0, 12.0], [2.0, 6.0], [5.0, 5.0]] {
        assert_eq!(holds(&block([2.0, 1.0], size)), Some(false), "{size:?}");
    }
    // A disk of radius 2.1 between pixels, through the default Gaussian.
    #[rustfmt::skip]
    let disk = [
        [0.00, 0.00, 0.05, 0.09, 0.05, 0.02, 0.00],
        [0.00, 0.14, 0.56, 0.76, 0.54, 0.14, 0.00],
        [0.05, 0.47, 0.94, 0.97, 0.92, 0.37, 0.02],
        [0.03, 0.54, 0.95, 0.97, 0.92, 0.38, 0.02],
        [0.00, 0.30, 0.76, 0.88, 0.66, 0.16, 0.00],
        [0.00, 0.03, 0.18, 0.26, 0.13, 0.01, 0.00],
    ];
    let lamp =
        |x: f64, y: f64| disk.get(y as usize).and_then(|row| row.get(x as usize)).copied().unwrap_or(0.0);
    assert_eq!(holds(&lamp), Some(false));
    // One hit of light that a filter spreads: a triangle of radius 2, and a Gaussian of radius 3.
    let triangle =
        |x: f64, y: f64| ((2.0 - (x - 5.5).abs()).max(0.0) * (2.0 - (y - 6.5).abs()).max(0.0)) as f32;
    let gaussian = |x: f64, y: f64| {
        let one = |x: f64| ((-x * x).exp() - (-9.0_f64).exp()).max(0.0);
        (one(x - 5.5) * one(y - 6.5)) as f32
    };
    assert_ne!(holds(&triangle), Some(false));
    assert_ne!(holds(&gaussian), Some(false));
    // Hits by the number, in every second pixel, of very different light.
    let hits = |x: f64, y: f64| match (x * 7.0 + y * 13.0) % 16.0 {
        hit if x < 6.0 && y < 6.0 && hit < 8.0 => (4.0_f64).powf(hit) as f32,
        _ => 0.0,
    };
    assert_eq!(holds(&hits), None);
}

/// Rare light hides no bias of all pixels.
#[test]
fn a_bias_is_found_among_rare_events() {
    let mut pair = Aligned { expected_errors: None, ..sample() };
    pair.actual.clone_from(&pair.expected);
    pair.expected.iter_mut().step_by(50).for_each(|pixel| *pixel = [3.0; 3]);
    let found = agreement(&pair).unwrap();
    assert!(found.means[0].tail_index < 1.0 && found.holds(0.01) != Some(false), "{found:?}");
    pair.actual.iter_mut().for_each(|pixel| pixel[2] *= 0.95);
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(false));
}

/// The film of another renderer sums XYZ: a dark channel is rounded as the brightest one.
#[test]
fn rounding_is_that_of_the_brightest_channel() {
    let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16, ..PixelError::default() };
    let errors = Some(vec![still; PIXELS]);
    let mut pair = Aligned { actual_errors: errors.clone(), expected_errors: None, ..sample() };
    pair.actual.fill([0.0, 0.9, 0.0]);
    pair.expected.fill([3.5e-7, 0.9, 2.4e-7]);
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(true));
    pair.expected.fill([3.5e-4, 0.9, 0.0]);
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(false));
    // This renderer sums red, green and blue.
    pair.expected.fill([3.5e-7, 0.9, 0.0]);
    pair.expected_errors = errors;
    assert_eq!(agreement(&pair).unwrap().holds(0.01), Some(false));
}

/// Pictures with the same noise tell small errors by it.
#[test]
fn noise_in_common_cancels() {
    let mut pair = sample();
    pair.expected_errors.clone_from(&pair.actual_errors);
    pair.actual.clone_from(&pair.expected);
    assert_eq!(agreement(&pair).unwrap().p, 1.0);
    pair.actual.iter_mut().for_each(|pixel| pixel[0] *= 1.002);
    let found = agreement(&pair).unwrap();
    assert!(found.means[0].p > 0.5 && found.holds(1e-6) == Some(false), "{found:?}");
}

/// Values without noise may differ by rounding, and by no more.
#[test]
fn rounding_is_no_difference() {
    let still = PixelError { standard_error: [0.0; 3], samples: 64, replicates: 16, ..PixelError::default() };
    let errors = Some(vec![still; PIXELS]);
    let pair = |factor: f32, expected_errors: &Option<Vec<PixelError>>| {
        let mut pair = sample();
        pair.actual.clone_from(&pair.expected);
        pair.actual.as_flattened_mut().iter_mut().for_each(|value| *value *= factor);
        agreement(&Aligned {
            actual_errors: errors.clone(),
            expected_errors: expected_errors.clone(),
            ..pair
        })
    };
    assert_eq!(pair(1.0, &errors).unwrap().p, 1.0);
    assert!(pair(1.000_001, &errors).unwrap().holds(0.01) == Some(true));
    assert!(pair(1.000_01, &errors).unwrap().holds(0.01) == Some(false));
    // Sums of another renderer may be in single precision.
    assert!(pair(1.000_1, &None).unwrap().holds(0.01) == Some(true));
    assert!(pair(1.001, &None).unwrap().holds(0.01) == Some(false));
}

/// One pixel without the rare light of the other picture is no difference.
#[test]
fn rare_events_that_few_samples_miss_are_no_difference() {
    let mut pair = sample();
    let (actual, expected) = (pair.actual_errors.as_mut().unwrap(), pair.expected_errors.as_mut().unwrap());
    pair.expected[7] = [40.0; 3];
    (actual[7].standard_error, expected[7].standard_error) = ([0.01; 3], [20.0; 3]);
    assert!(agreement(&pair).unwrap().tiles[0].p > 0.01);
}

#[test]
fn the_index_of_a_power_is_found() {
    for (index, within) in [(0.5, 0.1), (1.5, 0.3), (3.0, 0.6)] {
        let quantile = |i: u32| (-1_f64).powi(i as i32) * ((f64::from(i) + 0.5) / 1e4).powf(-1.0 / index);
        let found = tail_index((0..10_000).map(quantile));
        assert!((found - index).abs() < within, "{found}, not {index}");
    }
    assert_eq!(tail_index(std::iter::repeat_n(-0.5, 256)), f64::INFINITY);
    assert_eq!(tail_index(std::iter::repeat_n(0.0, 256)), f64::INFINITY);
    assert_eq!(tail_index((0..256).map(|i| if i < 10 { 1.0 } else { 0.0 })), 0.0);
    assert_eq!(tail_index([1.0].into_iter()), f64::INFINITY);
}
