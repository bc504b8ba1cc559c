//! The film: sums of samples, pixel by pixel.

use std::ops::AddAssign;

use glam::{DVec3, Vec3};
use lookat_image::{Image, PixelError, Window};
use lookat_scene::{Film, PixelBounds};

use crate::color::luminance;

/// The samples of one pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pixel {
    /// Sum of the samples.
    sum: DVec3,
    /// Sum of the samples, those where the filter is negative subtracted.
    signed: DVec3,
    count: u32,
    negative: u32,
}

/// Replicates of each pixel when its error is asked for: with 16 of them intervals by Student's t hold what they promise,
/// with 4 and 8 they do not.
pub const REPLICATES: u32 = 16;

impl Pixel {
    /// Samples.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The variance of the samples, added up over the channels; `squares` is the sum of their squared lengths. 0 where there
    /// are less than two.
    pub fn variance(&self, squares: f64) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        let count = f64::from(self.count);
        // Rounding may leave less than nothing.
        ((squares - self.sum.length_squared() / count) / (count - 1.0)).max(0.0)
    }

    /// Adds a sample.
    pub fn add(&mut self, radiance: Vec3, negative: bool) {
        let radiance = radiance.as_dvec3();
        self.sum += radiance;
        self.signed += if negative { -radiance } else { radiance };
        self.count += 1;
        self.negative += u32::from(negative);
    }

    /// The filtered value. `weight` is the integral of the filter's absolute value over its integral.
    ///
    /// The plain estimate is `weight * signed / count`. For a filter that is partly negative it is noisy even where the
    /// picture is flat; so the noise of the weights alone, which is known, is taken out of it, scaled by the mean. Where
    /// the filter is nowhere negative the mean is left.
    pub fn value(&self, weight: f64) -> DVec3 {
        if self.count == 0 {
            return DVec3::ZERO;
        }
        let count = f64::from(self.count);
        let mean_weight = weight * (count - 2.0 * f64::from(self.negative)) / count;
        self.signed * (weight / count) - self.sum / count * (mean_weight - 1.0)
    }
}

/// Sums over the samples of a replicate, in single precision, as there are many: [`Pixel`] where the filter is nowhere
/// negative.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum(Vec3);

/// What a [`Sum`] needs beside it where the filter has negative lobes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SignedSum {
    signed: Vec3,
    negative: u32,
}

impl Sum {
    /// Adds samples.
    pub fn add(&mut self, samples: &Pixel) {
        self.0 += samples.sum.as_vec3();
    }

    /// As a pixel of so many samples.
    pub fn pixel(self, count: u32, signed: Option<&SignedSum>) -> Pixel {
        let sum = self.0.as_dvec3();
        let (signed, negative) =
            signed.map_or((sum, 0), |signed| (signed.signed.as_dvec3(), signed.negative));
        Pixel { sum, signed, count, negative }
    }
}

impl SignedSum {
    /// Adds samples.
    pub fn add(&mut self, samples: &Pixel) {
        self.signed += samples.signed.as_vec3();
        self.negative += samples.negative;
    }
}

impl AddAssign for Pixel {
    fn add_assign(&mut self, other: Self) {
        self.sum += other.sum;
        self.signed += other.signed;
        self.count += other.count;
        self.negative += other.negative;
    }
}

/// How far the replicates of a pixel lie apart: independent estimates of its value, of nearly equal numbers of samples.
/// Single precision serves, as there may be many pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spread {
    count: u32,
    /// Means over the replicates: of the samples, of the signed samples, and of the signs.
    plain: Vec3,
    signed: Vec3,
    sign: f32,
    /// Sums of the products of the distances from these means.
    plain_plain: Vec3,
    plain_signed: Vec3,
    plain_sign: Vec3,
    signed_signed: Vec3,
    signed_sign: Vec3,
    sign_sign: f32,
}

impl Spread {
    /// Adds a replicate (Welford, "Note on a Method for Calculating Corrected Sums of Squares and Products", 1962).
    pub fn add(&mut self, replicate: &Pixel) {
        let samples = f64::from(replicate.count);
        let plain = (replicate.sum / samples).as_vec3();
        let signed = (replicate.signed / samples).as_vec3();
        let sign = 1.0 - 2.0 * replicate.negative as f32 / replicate.count as f32;
        self.count += 1;
        let share = 1.0 / self.count as f32;
        let (plain_step, signed_step, sign_step) =
            (plain - self.plain, signed - self.signed, sign - self.sign);
        self.plain += plain_step * share;
        self.signed += signed_step * share;
        self.sign += sign_step * share;
        let (signed_left, sign_left) = (signed - self.signed, sign - self.sign);
        self.plain_plain += plain_step * (plain - self.plain);
        self.plain_signed += plain_step * signed_left;
        self.plain_sign += plain_step * sign_left;
        self.signed_signed += signed_step * signed_left;
        self.signed_sign += signed_step * sign_left;
        self.sign_sign += sign_step * sign_left;
    }

    /// The standard error of [`Pixel::value`] of all replicates together; infinite for less than two.
    ///
    /// That value is not linear in the replicates where the filter is partly negative; this is the error of its tangent at
    /// their means (the delta method).
    pub fn standard_error(&self, weight: f64) -> Vec3 {
        if self.count < 2 {
            return Vec3::INFINITY;
        }
        let weight = weight as f32;
        let (by_signed, by_plain, by_sign) = (weight, 1.0 - weight * self.sign, -weight * self.plain);
        let squares = self.signed_signed * by_signed.powi(2)
            + self.plain_plain * by_plain.powi(2)
            + self.sign_sign * by_sign * by_sign
            + 2.0 * self.plain_signed * (by_plain * by_signed)
            + 2.0 * self.plain_sign * by_plain * by_sign
            + 2.0 * self.signed_sign * by_signed * by_sign;
        let count = self.count as f32;
        let variance = squares / (count * (count - 1.0));
        // What is too large for a number is not known; rounding may leave less than nothing.
        Vec3::select(variance.is_finite_mask(), variance.max(Vec3::ZERO), Vec3::INFINITY).map(f32::sqrt)
    }

    /// The same with the counts, for a pixel that is the sum of the replicates.
    pub fn error(&self, pixel: &Pixel, weight: f64) -> PixelError {
        let standard_error = self.standard_error(weight).to_array();
        PixelError { standard_error, samples: pixel.count, replicates: self.count }
    }
}

/// A sample no brighter than the film allows.
pub(crate) fn limited(radiance: Vec3, film: &Film) -> Vec3 {
    let brightness = luminance(radiance);
    if brightness <= film.max_sample_luminance {
        return radiance;
    }
    radiance * (film.max_sample_luminance / brightness) as f32
}

/// A rectangle of the picture that one thread renders at a time.
#[derive(Debug)]
pub(crate) struct Tile {
    pub bounds: PixelBounds,
    /// Row by row.
    pub pixels: Vec<Pixel>,
    /// As many while the error is being found out by replicates, or none.
    pub spreads: Vec<Spread>,
    /// As many, or none where the error is not asked for.
    pub errors: Vec<PixelError>,
}

impl Tile {
    /// Makes errors of the spreads, with the weight of [`Pixel::value`].
    pub fn settle(&mut self, weight: f64) {
        let spreads = std::mem::take(&mut self.spreads);
        self.errors
            .extend(spreads.iter().zip(&self.pixels).map(|(spread, pixel)| spread.error(pixel, weight)));
    }
}

/// Pixels on a side of the tiles of a crop window: fewer where it is small, so that all threads have some.
pub(crate) fn tile_side(crop: PixelBounds) -> u32 {
    const FEWEST: u64 = 64;
    [16, 8, 4, 2].into_iter().find(|side| crop.area() >= FEWEST * side * side).unwrap_or(1) as u32
}

/// Cuts the crop window into tiles, row by row, with spreads or without.
pub(crate) fn tiles(crop: PixelBounds, with_spreads: bool) -> Vec<Tile> {
    let side = tile_side(crop);
    let starts = |from: u32, to: u32| (from..to).step_by(side as usize);
    starts(crop.y0, crop.y1)
        .flat_map(|y0| starts(crop.x0, crop.x1).map(move |x0| (x0, y0)))
        .map(|(x0, y0)| {
            let bounds = PixelBounds { x0, y0, x1: (x0 + side).min(crop.x1), y1: (y0 + side).min(crop.y1) };
            let area = bounds.area() as usize;
            let spreads = if with_spreads { vec![Spread::default(); area] } else { Vec::new() };
            Tile { bounds, pixels: vec![Pixel::default(); area], spreads, errors: Vec::new() }
        })
        .collect()
}

/// The picture that the tiles make, with the layers of its error if they have it.
pub(crate) fn develop(tiles: &[Tile], film: &Film, weight: f64) -> Image {
    let crop = film.crop;
    let area = crop.area() as usize;
    let mut planes = [(); 3].map(|()| vec![0.0; area]);
    let mut errors = Vec::new();
    for tile in tiles {
        for (at, pixel) in indices(tile.bounds, crop).zip(&tile.pixels) {
            // pbrt-v3 writes nothing below black, which filters with negative lobes give.
            let value = (pixel.value(weight).max(DVec3::ZERO) * film.scale).as_vec3().to_array();
            planes.iter_mut().zip(value).for_each(|(plane, value)| plane[at] = value);
        }
        if !tile.errors.is_empty() {
            errors.resize(area, PixelError::default());
        }
        for (at, error) in indices(tile.bounds, crop).zip(&tile.errors) {
            let standard_error = error.standard_error.map(|error| error * film.scale.abs() as f32);
            errors[at] = PixelError { standard_error, ..*error };
        }
    }
    let window = |x: u32, y: u32, width, height| Window { x: x as i32, y: y as i32, width, height };
    let data = window(crop.x0, crop.y0, crop.width(), crop.height());
    let display = window(0, 0, film.resolution[0], film.resolution[1]);
    let mut image = Image::from_planes(data, display, planes);
    if !errors.is_empty() {
        image.add_errors(&errors);
    }
    image
}

/// Pixels, row by row.
pub(crate) fn places(bounds: PixelBounds) -> impl Iterator<Item = [u32; 2]> {
    let PixelBounds { x0, y0, x1, y1 } = bounds;
    (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]))
}

/// Where these pixels are among those of a picture, row by row.
pub(crate) fn indices(bounds: PixelBounds, picture: PixelBounds) -> impl Iterator<Item = usize> {
    let across = picture.width() as usize;
    places(bounds).map(move |[x, y]| (y - picture.y0) as usize * across + (x - picture.x0) as usize)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn a_flat_picture_is_flat_under_any_filter() {
        let mut pixel = Pixel::default();
        for negative in [false, true, false, true, false, false, true, false] {
            pixel.add(Vec3::splat(0.75), negative);
        }
        assert!((pixel.value(1.3) - DVec3::splat(0.75)).length() < 1e-12);
    }

    #[test]
    fn the_spread_is_that_of_the_replicates() {
        let mut spread = Spread::default();
        let mut add = |values: &[Vec3]| {
            let mut pixel = Pixel::default();
            values.iter().for_each(|value| pixel.add(*value, false));
            spread.add(&pixel);
            spread.standard_error(1.0)
        };
        assert_eq!(add(&[Vec3::new(1.0, 5.0, 0.0)]), Vec3::INFINITY);
        add(&[Vec3::new(1.0, 5.0, 0.0), Vec3::new(3.0, 5.0, 0.0)]);
        // The variance of 1, 2 and 6 is 7.
        let error = add(&[Vec3::new(6.0, 5.0, 0.0)]);
        assert!((error - Vec3::new((7.0_f32 / 3.0).sqrt(), 0.0, 0.0)).length() < 1e-6);
        assert_eq!(add(&[Vec3::splat(1e30)]), Vec3::INFINITY);
    }

    /// Under a filter with negative lobes: over many pixels of random samples, the mean squared error of the values is the
    /// mean of the squared standard errors.
    #[test]
    fn the_spread_tells_the_error_under_negative_lobes() {
        // A fifth of the samples is negative.
        let weight = 1.0 / (0.8 - 0.2);
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut sums = [0.0; 2];
        for _ in 0..20_000 {
            let (mut pixel, mut spread) = (Pixel::default(), Spread::default());
            for _ in 0..16 {
                let mut replicate = Pixel::default();
                for _ in 0..4 {
                    let (negative, value) = (random.random::<f64>() < 0.2, random.random::<f32>());
                    replicate.add(Vec3::splat(3.0 + if negative { 2.0 * value } else { value }), negative);
                }
                spread.add(&replicate);
                pixel += replicate;
            }
            // The mean is 3.5 times 0.8 minus 4 times 0.2, over 0.6.
            sums[0] += (pixel.value(weight).x - 2.0 / 0.6).powi(2);
            sums[1] += f64::from(spread.standard_error(weight).x).powi(2);
        }
        let ratio = sums[0] / sums[1];
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }

    /// Sums of replicates are those of their samples, in steps, under negative lobes too.
    #[test]
    fn sums_are_pixels_again() {
        let mut pixel = Pixel::default();
        let (mut sum, mut signed) = (Sum::default(), SignedSum::default());
        for values in [[0.5, 2.0], [1.5, 0.25]] {
            let mut samples = Pixel::default();
            values.iter().for_each(|value| samples.add(Vec3::splat(*value), *value < 1.0));
            sum.add(&samples);
            signed.add(&samples);
            pixel += samples;
        }
        assert_eq!(sum.pixel(4, Some(&signed)).value(1.7), pixel.value(1.7));
        assert_eq!(sum.pixel(4, None).value(1.0), DVec3::splat(4.25 / 4.0));
    }

    #[test]
    fn tiles_cover_the_crop_window_once() {
        for (x1, y1, side) in [(70, 24, 4), (6, 8, 1), (6, 2000, 4), (133, 135, 16), (5, 7, 1)] {
            let crop = PixelBounds { x0: 5, y0: 7, x1, y1 };
            let area: u64 = tiles(crop, false).iter().map(|tile| tile.bounds.area()).sum();
            assert_eq!((area, tile_side(crop)), (crop.area(), side));
        }
    }
}
