//! How a picture looks on a display: the values it gets, how bright it is, and the exposure that suits it.

use std::array::from_fn;
use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::metrics::{nearest_rank, ranked};
use crate::{Image, ToneMapping, linear_from_srgb, luminance};

/// Pixels that a thread takes at a time.
const GRAIN: usize = 1 << 14;
/// A picture with fewer visible pixels than this share is nearly black.
const VISIBLE: f64 = 0.01;
/// The byte of 8-bit sRGB from which a pixel counts as visible.
const DARK_BYTE: f32 = 13.0;
/// A picture is bright enough, and not too bright, if this percentile of the largest channels of its lit pixels is in this
/// range, and it is not overexposed. Visible lamps may be above it, and clip.
const BRIGHT: f64 = 0.95;
const FINE: RangeInclusive<f64> = 0.2..=2.0;
/// A picture is overexposed if more than this share of the lit pixels clips.
const MOSTLY: f64 = 0.3;
/// The percentile of other pictures after the suitable exposure.
const AIM: f64 = 0.8;

/// A picture as an 8-bit file would hold it, but not rounded. PSNR and SSIM work on such values.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    /// The red, green and blue of each pixel, 0..1, on the sRGB curve.
    pub pixels: Vec<[f32; 3]>,
}

impl Encoded {
    /// Clips linear values to 0..1 and encodes them with the sRGB curve of IEC 61966-2-1. NaN becomes 0.
    pub fn from_linear(pixels: &[[f32; 3]]) -> Self {
        let mut encoded = vec![[0.0; 3]; pixels.len()];
        encoded.par_chunks_mut(GRAIN).zip(pixels.par_chunks(GRAIN)).for_each(|(encoded, pixels)| {
            for (encoded, &linear) in encoded.as_flattened_mut().iter_mut().zip(pixels.as_flattened()) {
                *encoded = encode(linear);
            }
        });
        Encoded { pixels: encoded }
    }
}

fn encode(linear: f32) -> f32 {
    let linear = clip(linear);
    // The power 1 / 2.4 = 1 / 3 + 1 / 12 is a cube root and its fourth root.
    let root = cube_root(linear.max(0.003));
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * root * root.sqrt().sqrt() - 0.055 }
}

/// The nearest value in 0..1; 0 for NaN.
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
pub(super) fn clip(value: f32) -> f32 {
    value.max(0.0).min(1.0)
}

/// The cube root of a number above 1e-30, to an ulp or two. Unlike [`f32::cbrt`] it is a few operations
/// without a branch, so that a loop over pixels is vectorized.
pub(super) fn cube_root(value: f32) -> f32 {
    // A third of the exponent, within four percent; each step of Halley's method cubes the error.
    let guess = f32::from_bits(value.to_bits() / 3 + 0x2a51_4067);
    let step = |root: f32| {
        let cube = root * root * root;
        root + root * (value - cube) / (2.0 * cube + value)
    };
    step(step(guess))
}

/// The brightness of a picture, by its finite pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// The median luminance, without exposure and tone curve.
    pub median: f32,
    /// The largest luminance, without exposure and tone curve.
    pub largest: f32,
    /// The share of pixels whose channels are all 0.
    pub black: f64,
    /// The share of pixels that clip in 8 bits: with a channel above 1 after exposure and tone curve.
    pub clipped: f64,
    /// The number of pixels that are not finite.
    pub not_finite: u64,
    /// The exposure in stops that suits the picture, if it is nearly black or overexposed and this exposure helps.
    pub advised_exposure: Option<f64>,
}

impl Light {
    /// Measures what a format without channel names shows. `None` if the picture has several channels but no colors.
    pub fn of(image: &Image, mapping: ToneMapping) -> Option<Light> {
        let planes = image.visible_planes().ok()?;
        let (count, pixel) = (planes[0].len(), pixel(&planes));
        let (function, dark) = (mapping.function(), linear_from_srgb(DARK_BYTE / 255.0));
        let brightest = |pixel| function(pixel).into_iter().fold(0.0, f32::max);
        let finite = || (0..count).into_par_iter().with_min_len(GRAIN).map(&pixel).filter(is_finite);
        let not_finite = count - finite().count();
        let black = finite().filter(|pixel| *pixel == [0.0; 3]).count();
        let visible = finite().filter(|pixel| brightest(*pixel) >= dark).count();
        let clipped = finite().filter(|pixel| brightest(*pixel) > 1.0).count();
        let largest = finite().map(luminance).reduce(|| 0.0, f32::max);
        // NaN ranks above all others.
        let luminances = (0..count)
            .into_par_iter()
            .map(|i| Some(pixel(i)).filter(is_finite).map_or(f32::NAN, |pixel| luminance(pixel).max(0.0)));
        let median = ranked(luminances, nearest_rank(0.5, count - not_finite));
        // If all are not finite, the median is one of them.
        let median = if median.is_finite() { median } else { 0.0 };
        let [black_share, visible, clipped_share] =
            [black, visible, clipped].map(|part| part as f64 / count as f64);
        let suitable = || suitable(count, &pixel);
        let advised_exposure = if visible < VISIBLE {
            Some(suitable()).filter(|stops| *stops > mapping.exposure)
        } else if clipped as f64 > MOSTLY * (count - black) as f64 {
            Some(suitable()).filter(|stops| *stops < mapping.exposure)
        } else {
            None
        };
        let not_finite = not_finite as u64;
        Some(Light {
            median,
            largest,
            black: black_share,
            clipped: clipped_share,
            not_finite,
            advised_exposure,
        })
    }
}

impl Image {
    /// The whole number of stops that suits the picture, usually 0. It is 0 for a black picture and for one without colors.
    pub fn suitable_exposure(&self) -> f64 {
        self.visible_planes().map_or(0.0, |planes| suitable(planes[0].len(), pixel(&planes)))
    }
}

/// The pixel at an index: a gray one has three equal channels.
fn pixel<'a>(planes: &'a [&[f32]]) -> impl Fn(usize) -> [f32; 3] + Sync + 'a {
    |i| from_fn(|c| planes[c % planes.len()][i])
}

/// True if all channels are finite.
pub(super) fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

/// The exposure that suits a linear picture: a whole number of stops, 0 as a rule and for a black one. Pixels
/// that are black or not finite, or have the depth 1e10 of no surface, do not count.
pub fn suitable_exposure(pixels: &[[f32; 3]]) -> f64 {
    suitable(pixels.len(), |i| pixels[i])
}

/// The depth of a pixel without a surface, in files of Blender and lookat.
const NO_SURFACE: f32 = 1e10;

fn suitable(count: usize, pixel: impl Fn(usize) -> [f32; 3] + Sync) -> f64 {
    // NaN ranks above all others.
    let brightness = |i| {
        let counts = |pixel: &[f32; 3]| is_finite(pixel) && *pixel != [NO_SURFACE; 3];
        Some(pixel(i)).filter(counts).map_or(f32::NAN, |pixel| pixel.into_iter().fold(0.0, f32::max))
    };
    let all = || (0..count).into_par_iter().map(brightness);
    let count_if = |test: fn(&f32) -> bool| all().filter(test).count();
    let (black, lit, clipped) =
        (count_if(|value| *value == 0.0), count_if(|value| *value > 0.0), count_if(|value| *value > 1.0));
    if lit == 0 {
        return 0.0;
    }
    let bright = f64::from(ranked(all(), black + nearest_rank(BRIGHT, lit)));
    let is_mostly_clipped = clipped as f64 > MOSTLY * lit as f64;
    if FINE.contains(&bright) && !is_mostly_clipped { 0.0 } else { (AIM / bright).log2().round() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ToneCurve, Window};

    fn light(values: &[f32], exposure: f64, curve: ToneCurve) -> Light {
        let window = Window { x: 0, y: 0, width: values.len() as u32, height: 1 };
        let pixels: Vec<_> = values.iter().map(|value| [*value; 3]).collect();
        Light::of(&Image::from_rgb(window, window, &pixels), ToneMapping { exposure, curve }).unwrap()
    }

    #[track_caller]
    fn check_advice(values: &[f32], exposure: f64, expected: Option<f64>) {
        assert_eq!(light(values, exposure, ToneCurve::None).advised_exposure, expected, "{values:?}");
    }

    #[test]
    fn numbers_are_of_all_finite_pixels() {
        let values = [0.0, 0.5, 3.0, 0.25, f32::NAN, 0.0, f32::INFINITY, -1.0];
        let found = light(&values, 1.0, ToneCurve::None);
        assert_eq!((found.median, found.largest), (0.0, 3.0));
        // Twice 0.5 is no more than 1.
        assert_eq!((found.black, found.clipped, found.not_finite), (0.25, 0.125, 2));
        assert_eq!(light(&values, 1.0, ToneCurve::Neutral).clipped, 0.0);
        assert_eq!(light(&[0.5, 0.125, 0.25, 1.0], 0.0, ToneCurve::None).median, 0.25);
        let broken = light(&[f32::NAN; 3], 0.0, ToneCurve::None);
        assert_eq!((broken.median, broken.largest, broken.not_finite), (0.0, 0.0, 3));
    }

    #[test]
    fn dark_and_clipped_pictures_get_an_exposure() {
        check_advice(&[8.6e-7; 100], 0.0, Some(20.0));
        check_advice(&[8.6e-7; 100], 19.0, None);
        check_advice(&[50.0; 100], 0.0, Some(-6.0));
        check_advice(&[0.5; 100], 8.0, Some(0.0));
        check_advice(&[0.5; 100], -9.0, Some(0.0));
        let half = |bright: f32| [[0.1_f32; 50], [bright; 50]].concat();
        check_advice(&half(30.0), 0.0, Some(-5.0));
        check_advice(&half(1.5), 0.0, Some(-1.0));
        // Black surroundings do not count.
        check_advice(&[vec![0.0; 10_000], vec![1e-3; 50]].concat(), 0.0, Some(10.0));
        check_advice(&[vec![0.0; 10_000], vec![9.0; 50]].concat(), 0.0, None);
    }

    #[test]
    fn other_pictures_get_none() {
        check_advice(&[0.0; 100], 0.0, None);
        check_advice(&[0.1; 100], 0.0, None);
        check_advice(&[[0.2; 80], [7.0; 80]].concat()[..100], 0.0, None);
        // Little is lit, and that well: an exposure does not help.
        check_advice(&[vec![0.0; 10_000], vec![0.5; 50]].concat(), 0.0, None);
    }

    #[test]
    fn gray_is_light_and_several_unknown_channels_are_not() {
        let window = Window { x: 0, y: 0, width: 2, height: 1 };
        let mut image = Image::from_rgb(window, window, &[[0.25; 3], [5.0; 3]]);
        image.channels[0].name = "Z".into();
        assert_eq!((Light::of(&image, ToneMapping::default()), image.suitable_exposure()), (None, 0.0));
        image.channels.truncate(1);
        assert_eq!(Light::of(&image, ToneMapping::default()).unwrap().largest, 5.0);
        assert_eq!(image.suitable_exposure(), -3.0);
        image.channels[0].samples.fill(1e10);
        image.channels[0].samples[0] = 8.0;
        assert_eq!(image.suitable_exposure(), -3.0);
    }

    #[test]
    fn pictures_come_to_a_fine_brightness() {
        let check = |value: f32, expected| {
            assert_eq!(suitable_exposure(&[[0.0, value, 0.0]; 50]), expected, "{value}")
        };
        check(0.2, 0.0);
        check(1.0, 0.0);
        check(1.1, 0.0);
        // All of it clips.
        check(2.0, -1.0);
        check(0.19, 2.0);
        check(2.1, -1.0);
        check(1000.0, -10.0);
        check(1e-5, 16.0);
        check(1e-45, 149.0);
        check(f32::MAX, -128.0);
        check(0.0, 0.0);
        check(-5.0, 0.0);
        check(f32::NAN, 0.0);
    }

    #[test]
    fn lamps_in_range_stay_as_they_are() {
        let mut pixels = vec![[0.1; 3]; 100];
        pixels[..20].fill([2.0; 3]);
        assert_eq!(suitable_exposure(&pixels), 0.0);
        // Black surroundings do not count.
        pixels.extend([[0.0; 3]; 1000]);
        assert_eq!(suitable_exposure(&pixels), 0.0);
        pixels[..20].fill([0.1; 3]);
        assert_eq!(suitable_exposure(&pixels), 3.0);
    }

    #[test]
    fn lamps_and_pixels_that_are_not_finite_do_not_count() {
        let mut pixels = vec![[0.1; 3]; 100];
        pixels[..5].fill([1000.0; 3]);
        pixels.extend([[f32::NAN; 3], [f32::INFINITY; 3]].repeat(100));
        assert_eq!(suitable_exposure(&pixels), 3.0);
    }

    #[test]
    fn cube_roots_are_right() {
        for i in 0..=10_000 {
            let value = 1e-4 + i as f32 / 8000.0;
            let expected = f64::from(value).cbrt();
            assert!((f64::from(cube_root(value)) / expected - 1.0).abs() < 2e-7, "{value}");
        }
    }

    #[test]
    fn follows_the_srgb_curve() {
        for i in 0..=10_000 {
            let linear = i as f32 / 10_000.0;
            let exact = f64::from(linear);
            let expected =
                if linear <= 0.003_130_8 { 12.92 * exact } else { 1.055 * exact.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(encode(linear)) - expected).abs() < 3e-7, "{linear}");
        }
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(encode);
        assert_eq!((odd[0], odd[2]), (0.0, 0.0));
        assert!((odd[1] - 1.0).abs() < 1e-6);
    }
}
