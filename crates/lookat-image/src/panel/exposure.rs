//! How bright a picture is shown.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::parts::is_finite;
use crate::rank::{nearest_rank, ranked};

/// A picture is bright enough, and not too bright, if this percentile of the largest channels of its pixels with light is in
/// this range, and it is not overexposed. Lamps that are seen may be the rest, and are cut off.
const BRIGHT: f64 = 0.95;
const FINE: RangeInclusive<f64> = 0.2..=2.0;
/// A picture is overexposed if more than this share of the pixels with light clips.
pub(crate) const MOSTLY: f64 = 0.3;
/// Where the percentile of other pictures is brought.
const AIM: f64 = 0.8;

/// The exposure that suits a linear picture: a whole number of stops, 0 as a rule and for a black one. Pixels
/// that are black or not finite do not count.
pub fn suitable_exposure(pixels: &[[f32; 3]]) -> f64 {
    suitable(pixels.len(), |i| pixels[i])
}

/// The same for pixels by their numbers.
pub(crate) fn suitable(count: usize, pixel: impl Fn(usize) -> [f32; 3] + Sync) -> f64 {
    // NaN ranks above all others.
    let brightness = |i| {
        let pixel = pixel(i);
        if is_finite(&pixel) { pixel.into_iter().fold(0.0, f32::max) } else { f32::NAN }
    };
    let count_if =
        |test: fn(f32) -> bool| (0..count).into_par_iter().filter(|i| test(brightness(*i))).count();
    let (black, lit, clipped) =
        (count_if(|value| value == 0.0), count_if(|value| value > 0.0), count_if(|value| value > 1.0));
    if lit == 0 {
        return 0.0;
    }
    let bright = f64::from(ranked(count, |i| [brightness(i)], black + nearest_rank(BRIGHT, lit)));
    let is_mostly_clipped = clipped as f64 > MOSTLY * lit as f64;
    if FINE.contains(&bright) && !is_mostly_clipped {
        return 0.0;
    }
    (AIM / bright).log2().round()
}

/// In words.
pub(super) fn caption(stops: f64) -> String {
    match stops {
        0.0 => "exposure 0".into(),
        stops if stops.abs() == 1.0 => format!("exposure {stops:+} stop"),
        stops => format!("exposure {stops:+} stops"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn captions_count_stops() {
        let captions = [0.0, 3.0, -1.0, 0.5].map(caption);
        assert_eq!(captions, ["exposure 0", "exposure +3 stops", "exposure -1 stop", "exposure +0.5 stops"]);
    }
}
