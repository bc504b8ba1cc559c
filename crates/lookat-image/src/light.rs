//! How bright a picture is, and the exposure that suits it.

use std::array::from_fn;

use rayon::prelude::*;

use crate::panel::{MOSTLY, suitable};
use crate::rank::{nearest_rank, ranked};
use crate::tone::{ToneMapping, luminance};
use crate::{Image, linear_from_srgb};

/// A picture with fewer visible pixels than this share is nearly black.
const VISIBLE: f64 = 0.01;
/// The byte of 8-bit sRGB from which a pixel counts as visible.
const DARK_BYTE: f32 = 13.0;
/// Pixels that a thread takes at a time.
const GRAIN: usize = 1 << 14;

/// How bright a picture is. Of pixels that are not finite only the number is known.
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

/// Numbers of pixels, and the largest luminance.
#[derive(Default)]
struct Counts {
    black: u64,
    visible: u64,
    clipped: u64,
    not_finite: u64,
    largest: f32,
}

impl Image {
    /// The whole number of stops that suits the picture, usually 0. It is 0 for a black picture and for one without colors.
    pub fn suitable_exposure(&self) -> f64 {
        self.visible_planes().map_or(0.0, |planes| suitable(planes[0].len(), pixel(&planes)))
    }
}

/// A pixel by its number: a gray one has three equal channels.
fn pixel<'a>(planes: &'a [&[f32]]) -> impl Fn(usize) -> [f32; 3] + Sync + 'a {
    |i| from_fn(|c| planes[c % planes.len()][i])
}

impl Light {
    /// Measures what a format without channel names shows. `None` if the picture has several channels but no colors.
    pub fn of(image: &Image, mapping: ToneMapping) -> Option<Light> {
        let planes = image.visible_planes().ok()?;
        let (count, pixel) = (planes[0].len(), pixel(&planes));
        let Counts { black, visible, clipped, not_finite, largest } = Counts::of(count, &pixel, mapping);
        let median_rank = nearest_rank(0.5, count - not_finite as usize);
        // NaN ranks above all others.
        let rank_luminance = |i| match pixel(i) {
            pixel if pixel.iter().all(|value| value.is_finite()) => [luminance(pixel).max(0.0)],
            _ => [f32::NAN],
        };
        let median = ranked(count, rank_luminance, median_rank);
        let share = |part: u64| part as f64 / count as f64;
        let is_nearly_black = share(visible) < VISIBLE;
        let is_mostly_clipped = clipped as f64 > MOSTLY * (count as u64 - black) as f64;
        let suitable = || suitable(count, &pixel);
        let advised_exposure = match (is_nearly_black, is_mostly_clipped) {
            (true, _) => Some(suitable()).filter(|stops| *stops > mapping.exposure),
            (_, true) => Some(suitable()).filter(|stops| *stops < mapping.exposure),
            _ => None,
        };
        // If all are not finite, the median is one of them.
        let median = if median.is_finite() { median } else { 0.0 };
        let [black, clipped] = [black, clipped].map(share);
        Some(Light { median, largest, black, clipped, not_finite, advised_exposure })
    }
}

impl Counts {
    fn of(count: usize, pixel: &(impl Fn(usize) -> [f32; 3] + Sync), mapping: ToneMapping) -> Counts {
        let (function, dark) = (mapping.function(), linear_from_srgb(DARK_BYTE / 255.0));
        let add = |sum: Counts, i: usize| {
            let pixel = pixel(i);
            if !pixel.iter().all(|value| value.is_finite()) {
                return Counts { not_finite: sum.not_finite + 1, ..sum };
            }
            let brightest = function(pixel).into_iter().fold(0.0, f32::max);
            Counts {
                black: sum.black + u64::from(pixel.iter().all(|value| *value == 0.0)),
                visible: sum.visible + u64::from(brightest >= dark),
                clipped: sum.clipped + u64::from(brightest > 1.0),
                not_finite: sum.not_finite,
                largest: sum.largest.max(luminance(pixel)),
            }
        };
        let merge = |a: Counts, b: Counts| Counts {
            black: a.black + b.black,
            visible: a.visible + b.visible,
            clipped: a.clipped + b.clipped,
            not_finite: a.not_finite + b.not_finite,
            largest: a.largest.max(b.largest),
        };
        let counts = (0..count).into_par_iter().with_min_len(GRAIN).fold(Counts::default, add);
        counts.reduce(Counts::default, merge)
    }
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
    }
}
