//! Exact sums of samples: in fixed point, so that partial sums give the same bits in any order.

use std::array::from_fn;
use std::ops::AddAssign;

use glam::{DVec3, Vec3};

/// The unit of fixed-point sums. A sample is exact if it is brighter than 2^-28 of the scene's brightness, and counts as at
/// most 2^31 times as bright as that. 2^30 such samples are no overflow.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// A power of two.
    brightness: f64,
    /// The brightest sample.
    most: f64,
    /// High units in a radiance of 1.
    high: f64,
}

/// Bits after the point of a high unit, in units of the brightness: what the 31 bits of a sample before the point, 30 for the
/// count and a sign leave.
const FRACTION: i32 = 1;
/// A high unit is 2^51 low units. [`rounded`] is exact up to that size.
const LOW: i32 = 51;
const LOW_UNITS: f64 = (1_u64 << LOW) as f64;
/// The brightest sample, in units of the brightness.
const MOST: f64 = (1_u64 << 31) as f64;
/// Samples until low units are carried over.
const CARRY: u32 = 1 << 12;
/// Bits after the point of a square. A sum of squares from 2^63 on is not known.
const SQUARE_FRACTION: i32 = 64;

/// Added to a number below 2^51, it leaves the nearest integer in the lowest bits.
const MAGIC: f64 = 1.5 * (1_u64 << 52) as f64;

/// The nearest integer, as a float and as itself. Faster than `as`, which looks for what no `i64` holds.
#[inline(always)]
fn rounded(x: f64) -> (f64, i64) {
    let sum = x + MAGIC;
    (sum - MAGIC, sum.to_bits().wrapping_sub(MAGIC.to_bits()) as i64)
}

impl Scale {
    /// That of a brightness of 1.
    pub const ONE: Scale = Scale { brightness: 1.0, most: MOST, high: (1_u64 << FRACTION) as f64 };

    /// For samples of about this brightness: more than 0 and finite.
    pub fn new(brightness: f64) -> Scale {
        // Powers of two between which no product below leaves `f64`.
        let brightness = libm::exp2(libm::log2(brightness).round().clamp(-400.0, 400.0));
        Scale { brightness, most: MOST * brightness, high: 2_f64.powi(FRACTION) / brightness }
    }

    /// Whether a sample is too bright for its sum.
    #[inline(always)]
    pub fn clamps(self, radiance: Vec3) -> bool {
        f64::from(radiance.abs().max_element()) > self.most
    }

    /// High and low units.
    #[inline(always)]
    fn fixed(self, x: f32) -> [i64; 2] {
        let units = f64::from(x).clamp(-self.most, self.most) * self.high;
        let (whole, high) = rounded(units);
        [high, rounded((units - whole) * LOW_UNITS).1]
    }

    fn value(self, [high, low]: [i64; 2]) -> f64 {
        let fixed = (i128::from(high) << LOW) + i128::from(low);
        fixed as f64 / LOW_UNITS / self.high
    }

    /// A product of two radiances.
    fn fixed_square(self, x: f64) -> i128 {
        (x / self.brightness / self.brightness * 2_f64.powi(SQUARE_FRACTION)) as i128
    }

    /// Infinite for a sum that has left the range.
    fn square(self, fixed: i128) -> f64 {
        if fixed == i128::MAX {
            return f64::INFINITY;
        }
        fixed as f64 * 2_f64.powi(-SQUARE_FRACTION) * self.brightness * self.brightness
    }
}

/// The sum of samples, and their number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Sum {
    /// Of each channel: units of [`Scale`].
    high: [i64; 3],
    low: [i64; 3],
    pub count: u32,
}

impl Sum {
    /// Adds a sample.
    #[inline(always)]
    pub fn add(&mut self, radiance: Vec3, scale: Scale) {
        for (channel, x) in radiance.to_array().into_iter().enumerate() {
            let [high, low] = scale.fixed(x);
            self.high[channel] += high;
            self.low[channel] += low;
        }
        self.count += 1;
        if self.count.is_multiple_of(CARRY) {
            self.carry();
        }
    }

    /// Makes high units of low ones. Equal sums then have equal bits.
    fn carry(&mut self) {
        for (high, low) in self.high.iter_mut().zip(&mut self.low) {
            *high += *low >> LOW;
            *low &= (1 << LOW) - 1;
        }
    }

    pub fn radiance(&self, scale: Scale) -> DVec3 {
        from_fn(|channel| scale.value([self.high[channel], self.low[channel]])).into()
    }
}

impl AddAssign for Sum {
    fn add_assign(&mut self, mut other: Self) {
        other.carry();
        for channel in 0..3 {
            self.high[channel] += other.high[channel];
            self.low[channel] += other.low[channel];
        }
        self.count += other.count;
        self.carry();
    }
}

/// The samples of a pixel: all, and those where the filter is negative among them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Pixel {
    pub all: Sum,
    pub negative: Sum,
}

impl Pixel {
    /// Adds a sample.
    #[inline(always)]
    pub fn add(&mut self, radiance: Vec3, is_negative: bool, scale: Scale) {
        self.all.add(radiance, scale);
        if is_negative {
            self.negative.add(radiance, scale);
        }
    }

    /// The sum of the samples, those where the filter is negative subtracted.
    pub fn signed(&self, scale: Scale) -> DVec3 {
        self.all.radiance(scale) - 2.0 * self.negative.radiance(scale)
    }

    /// The number of samples, likewise.
    pub fn signs(&self) -> f64 {
        f64::from(self.all.count) - 2.0 * f64::from(self.negative.count)
    }

    /// The filtered value. `weight` is the integral of the filter's absolute value over its integral.
    ///
    /// The plain estimate is `weight * signed / count`. For a filter that is partly negative it is noisy even where the
    /// picture is flat; so the noise of the weights alone, which is known, is taken out of it, scaled by the mean. Where
    /// the filter is nowhere negative the mean is left.
    pub fn value(&self, weight: f64, scale: Scale) -> DVec3 {
        if self.all.count == 0 {
            return DVec3::ZERO;
        }
        let count = f64::from(self.all.count);
        let mean_weight = weight * self.signs() / count;
        self.signed(scale) * (weight / count) - self.all.radiance(scale) / count * (mean_weight - 1.0)
    }

    /// The variance of the samples, added up over the channels; `squares` is the sum of their squared lengths. 0 where there
    /// are less than two.
    pub fn variance(&self, squares: f64, scale: Scale) -> f64 {
        if self.all.count < 2 {
            return 0.0;
        }
        let count = f64::from(self.all.count);
        // Rounding may leave less than nothing.
        ((squares - self.all.radiance(scale).length_squared() / count) / (count - 1.0)).max(0.0)
    }
}

impl AddAssign for Pixel {
    fn add_assign(&mut self, other: Self) {
        self.all += other.all;
        self.negative += other.negative;
    }
}

/// How far the replicates of a pixel lie apart: independent estimates of its value, of nearly equal numbers of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Spread {
    /// The sum over replicates of S S / n, of the signed sum S and the count n of their samples.
    squares: [i128; 3],
    pub replicates: u32,
}

/// What a [`Spread`] needs beside it where the filter has negative lobes, or where replicates are rounded: the sums of S Z / n and
/// Z Z / n, with the signed count Z. Elsewhere they are the sum and the count of all samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Products {
    products: [i128; 3],
    signs: i128,
}

/// Bits after the point of a sum of signs: at most 2^30 before it.
const SIGN_FRACTION: i32 = 64;

fn add(sums: &mut [i128; 3], more: [i128; 3]) {
    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum = sum.saturating_add(more));
}

impl Spread {
    /// Adds a replicate of `count` samples, with their signed sum.
    pub fn add(&mut self, signed: DVec3, count: u32, scale: Scale) {
        let square = |x: f64| scale.fixed_square(x * x / f64::from(count));
        add(&mut self.squares, signed.to_array().map(square));
        self.replicates += 1;
    }

    /// The standard error of [`Pixel::value`] of all replicates together; infinite for less than two.
    ///
    /// That value is not linear in the replicates where the filter is partly negative. This is the error of its tangent where
    /// the mean of the weights is 1, as it is expected to be (the delta method): S - M Z times the weight, with the mean M of
    /// all samples.
    pub fn standard_error(
        &self,
        products: Option<&Products>,
        pixel: &Pixel,
        weight: f64,
        scale: Scale,
    ) -> Vec3 {
        if self.replicates < 2 {
            return Vec3::INFINITY;
        }
        let count = f64::from(pixel.all.count);
        let (mean, signed) = (pixel.all.radiance(scale) / count, pixel.signed(scale));
        let (products, signs) = products.map_or((signed, count), |sums| {
            let products = sums.products.map(|sum| scale.square(sum) / scale.brightness);
            (products.into(), sums.signs as f64 * 2_f64.powi(-SIGN_FRACTION))
        });
        // A unit for each square that was rounded. Black has none.
        let rounding = scale.square(self.replicates.into());
        let error = |channel: usize| {
            let mean = mean[channel];
            let rounding = if mean == 0.0 { 0.0 } else { rounding };
            let squares =
                scale.square(self.squares[channel]) - 2.0 * mean * products[channel] + mean * mean * signs;
            let left = signed[channel] - mean * pixel.signs();
            let variance = (squares - left * left / count) / (f64::from(self.replicates - 1) * count);
            // Rounding may leave less than nothing. `max` would make 0 of what is not known.
            let variance = if variance < 0.0 { 0.0 } else { variance };
            (weight * (variance + rounding / (f64::from(self.replicates - 1) * count)).sqrt()) as f32
        };
        let errors = Vec3::from_array(from_fn(error));
        // What is too large for a number is not known.
        Vec3::select(errors.is_finite_mask(), errors, Vec3::INFINITY)
    }
}

impl AddAssign for Spread {
    fn add_assign(&mut self, other: Self) {
        add(&mut self.squares, other.squares);
        self.replicates += other.replicates;
    }
}

impl AddAssign for Products {
    fn add_assign(&mut self, other: Self) {
        add(&mut self.products, other.products);
        self.signs += other.signs;
    }
}

impl Products {
    /// Adds a replicate of `count` samples, with their signed sum and their signed count.
    pub fn add(&mut self, signed: DVec3, signs: f64, count: u32, scale: Scale) {
        let count = f64::from(count);
        let product = |x: f64| scale.fixed_square(x * scale.brightness * signs / count);
        add(&mut self.products, signed.to_array().map(product));
        self.signs += ((signs * signs / count) * 2_f64.powi(SIGN_FRACTION)) as i128;
    }
}

#[cfg(test)]
mod tests {
    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    const SCALE: fn() -> Scale = || Scale::new(1.0);

    #[test]
    fn sums_are_exact() {
        for brightness in [1e-30, 1.0, 3e20] {
            let scale = Scale::new(brightness);
            let unit = scale.brightness as f32;
            let mut sum = Sum::default();
            // Of these, `f64` loses the small ones.
            let samples = [1e-8, 1.0, 1e9, -1.0, -1e9].map(|x| x * unit);
            samples.iter().for_each(|x| sum.add(Vec3::splat(*x), scale));
            assert_eq!(sum.radiance(scale), DVec3::splat(f64::from(samples[0])), "{brightness}");
        }
    }

    #[test]
    fn the_brightest_samples_do_not_overflow() {
        let scale = Scale::new(1.0);
        assert!(scale.fixed(f32::MAX)[0].checked_mul(1 << 30).is_some());
        for sample in [f32::MAX, 0.7, 1e-3] {
            let mut sum = Sum::default();
            (0..3 * CARRY + 5).for_each(|_| sum.add(Vec3::splat(sample), scale));
            let expected = f64::from(sample).min(MOST) * f64::from(3 * CARRY + 5);
            assert_eq!(sum.radiance(scale), DVec3::splat(expected), "{sample}");
        }
    }

    fn pixels(random: &mut Pcg64Mcg, count: usize) -> Vec<Pixel> {
        let mut pixel = || {
            let mut pixel = Pixel::default();
            for _ in 0..4 {
                // Over 12 powers of ten, as fireflies and shadows are.
                let radiance = Vec3::splat(10_f32.powf(random.random::<f32>() * 12.0 - 6.0));
                pixel.add(radiance, random.random::<f64>() < 0.2, SCALE());
            }
            pixel
        };
        (0..count).map(|_| pixel()).collect()
    }

    /// Samples, and replicates with their spread: any split, merged in any order, gives the same bits.
    #[test]
    fn partial_sums_merge_in_any_order() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..200 {
            let mut replicates = pixels(&mut random, 16);
            let total = |parts: &[Pixel]| {
                let (mut pixel, mut spreads) = (Pixel::default(), (Spread::default(), Products::default()));
                for part in parts {
                    pixel += *part;
                    let (signed, count) = (part.signed(SCALE()), part.all.count);
                    spreads.0.add(signed, count, SCALE());
                    spreads.1.add(signed, part.signs(), count, SCALE());
                }
                (pixel, spreads)
            };
            let expected = total(&replicates);
            replicates.shuffle(&mut random);
            let split = random.random_range(0..=16);
            let (mut pixel, mut spreads) = total(&replicates[split..]);
            let (first, others) = total(&replicates[..split]);
            pixel += first;
            spreads.0 += others.0;
            spreads.1 += others.1;
            assert_eq!((pixel, spreads), expected);
        }
    }

    #[test]
    fn a_flat_picture_is_flat_under_any_filter() {
        let mut pixel = Pixel::default();
        for negative in [false, true, false, true, false, false, true, false] {
            pixel.add(Vec3::splat(0.75), negative, SCALE());
        }
        assert!((pixel.value(1.3, SCALE()) - DVec3::splat(0.75)).length() < 1e-12);
    }

    #[test]
    fn the_spread_is_that_of_the_replicates() {
        let error = |values: &[Vec3]| {
            let (mut pixel, mut spread) = (Pixel::default(), Spread::default());
            for value in values {
                pixel.add(*value, false, SCALE());
                spread.add(value.as_dvec3(), 1, SCALE());
            }
            spread.standard_error(None, &pixel, 1.0, SCALE())
        };
        assert_eq!(error(&[Vec3::new(1.0, 5.0, 0.0)]), Vec3::INFINITY);
        // The variance of 1, 2 and 6 is 7.
        let found = error(&[Vec3::new(1.0, 5.0, 0.0), Vec3::new(2.0, 5.0, 0.0), Vec3::new(6.0, 5.0, 0.0)]);
        assert!((found - Vec3::new((7.0_f32 / 3.0).sqrt(), 0.0, 0.0)).length() < 1e-6);
    }

    /// Sums that have left their range make an error that is not known, and none of 0.
    #[test]
    fn errors_of_bright_pixels_are_not_lost() {
        for (mean, is_known) in [(1e3_f32, true), (1e6, true), (1e9, false)] {
            let (mut pixel, mut spread) = (Pixel::default(), Spread::default());
            for replicate in 0..16 {
                let mut samples = Pixel::default();
                let value = Vec3::splat(if replicate % 2 == 0 { 0.9 * mean } else { 1.1 * mean });
                (0..4096).for_each(|_| samples.add(value, false, SCALE()));
                spread.add(samples.signed(SCALE()), 4096, SCALE());
                pixel += samples;
            }
            let error = spread.standard_error(None, &pixel, 1.0, SCALE()).x / mean;
            let expected = if is_known { 0.1 / 15_f32.sqrt() } else { f32::INFINITY };
            assert!(error == expected || (error / expected - 1.0).abs() < 1e-4, "{mean}: {error} {expected}");
        }
    }

    /// Squares far below the unit give an error that is too large. Only black has an error of 0.
    #[test]
    fn errors_of_dark_pixels_are_not_lost() {
        for mean in [1e-4_f32, 1e-8, 1e-10, 1e-12, 0.0] {
            let (mut pixel, mut spread) = (Pixel::default(), Spread::default());
            for replicate in 0..16 {
                let mut samples = Pixel::default();
                let value = Vec3::splat(if replicate % 2 == 0 { 0.9 * mean } else { 1.1 * mean });
                samples.add(value, false, SCALE());
                spread.add(samples.signed(SCALE()), 1, SCALE());
                pixel += samples;
            }
            let error = spread.standard_error(None, &pixel, 1.0, SCALE()).x;
            let expected = 0.1 * mean / 15_f32.sqrt();
            let excess = if mean == 0.0 { 0.0 } else { 1e-10 };
            assert!((0.9999 * expected..=1.0001 * expected + excess).contains(&error), "{mean}: {error}");
        }
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
            let mut pixel = Pixel::default();
            let (mut spread, mut lobes) = (Spread::default(), Products::default());
            for _ in 0..16 {
                let mut replicate = Pixel::default();
                for _ in 0..4 {
                    let (negative, value) = (random.random::<f64>() < 0.2, random.random::<f32>());
                    let value = Vec3::splat(3.0 + if negative { 2.0 * value } else { value });
                    replicate.add(value, negative, SCALE());
                }
                spread.add(replicate.signed(SCALE()), 4, SCALE());
                lobes.add(replicate.signed(SCALE()), replicate.signs(), 4, SCALE());
                pixel += replicate;
            }
            // The mean is 3.5 times 0.8 minus 4 times 0.2, over 0.6.
            sums[0] += (pixel.value(weight, SCALE()).x - 2.0 / 0.6).powi(2);
            sums[1] += f64::from(spread.standard_error(Some(&lobes), &pixel, weight, SCALE()).x).powi(2);
        }
        let ratio = sums[0] / sums[1];
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }
}
