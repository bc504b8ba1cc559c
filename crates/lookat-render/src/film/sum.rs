//! Exact sums of weighted samples: in fixed point, so that partial sums give the same bits in any order.

use std::array::from_fn;
use std::ops::AddAssign;

use glam::{DVec3, DVec4, Vec3};
use serde::{Deserialize, Serialize};

/// The unit of fixed-point sums of radiance. A sample is exact if it is brighter than 2^-28 of the scene's brightness, and counts as at
/// most 2^31 times as bright as that.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Scale {
    /// A power of two.
    brightness: f64,
    /// High units in a radiance of 1.
    high: f64,
}

/// High units in a brightness, and in a weight of 1. Of 63 bits, 31 are before the point of the brightest sample and 30 for their number.
const HIGH: f64 = 2.0;
/// A high unit is 2^51 low units: [`rounded`] is exact up to that size.
const LOW: i32 = 51;
const LOW_UNITS: f64 = (1_u64 << LOW) as f64;
/// The brightest sample, in units of the brightness.
const MOST: f64 = (1_u64 << 31) as f64;

/// The nearest integer of a number up to 2^51. Faster than `as`, which looks for what no `i64` holds.
#[inline(always)]
fn rounded(x: f64) -> i64 {
    /// Added to such a number, it leaves the nearest integer in the lowest bits.
    const MAGIC: f64 = 1.5 * (1_u64 << 52) as f64;
    (x + MAGIC).to_bits().wrapping_sub(MAGIC.to_bits()) as i64
}

impl Scale {
    /// The scale for a brightness of 1.
    pub const ONE: Scale = Scale { brightness: 1.0, high: HIGH };

    /// For samples of about this brightness: more than 0 and finite.
    pub fn new(brightness: f64) -> Scale {
        // Powers of two between which no product below leaves `f64`.
        let brightness = libm::exp2(libm::log2(brightness).round().clamp(-400.0, 400.0));
        Scale { brightness, high: HIGH / brightness }
    }

    /// True if [`Scale::new`] can give this scale.
    pub fn is_valid(self) -> bool {
        self.brightness > 0.0 && self.brightness.is_finite() && self == Scale::new(self.brightness)
    }

    /// True if a sample is too bright for its sum.
    #[inline(always)]
    pub fn clamps(self, radiance: Vec3) -> bool {
        f64::from(radiance.abs().max_element()) > MOST * self.brightness
    }

    /// A weighted radiance, and its weight in `w`, in high units.
    #[inline(always)]
    pub fn units(self, weighted: DVec4) -> DVec4 {
        weighted * DVec3::splat(self.high).extend(HIGH)
    }

    /// A sample no brighter than its sum holds.
    #[inline(always)]
    pub fn clamped(self, radiance: Vec3) -> DVec3 {
        let most = DVec3::splat(MOST * self.brightness);
        radiance.as_dvec3().clamp(-most, most)
    }
}

/// A sum of samples times their weights, and of the weights.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Sum {
    /// Red, green, blue in units of [`Scale`], and the weight: high units, and from 0 to 2^51 low ones of 2^51 to a high unit.
    high: [i64; 4],
    low: [i64; 4],
}

impl Sum {
    /// The sum of so many [units](Scale::units).
    #[inline(always)]
    pub fn new(units: DVec4) -> Sum {
        let mut sum = Sum::default();
        for (channel, units) in units.to_array().into_iter().enumerate() {
            let high = units as i64;
            sum.high[channel] = high;
            sum.low[channel] = rounded((units - high as f64) * LOW_UNITS);
        }
        sum.carry();
        sum
    }

    /// The weighted sum of radiance and, in `w`, the sum of weights.
    pub fn weighted(&self, scale: Scale) -> DVec4 {
        let value = |channel: usize| {
            self.low_units(channel) / LOW_UNITS / if channel < 3 { scale.high } else { HIGH }
        };
        DVec4::from(from_fn(value))
    }

    /// The number of low units, rounded once.
    fn low_units(&self, channel: usize) -> f64 {
        const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;
        let (high, low) = (self.high[channel], self.low[channel]);
        match high.unsigned_abs() {
            // Much faster: all but the sum is exact.
            ..EXACT => high as f64 * LOW_UNITS + low as f64,
            _ => self.fixed(channel) as f64,
        }
    }

    /// The number of low units.
    fn fixed(&self, channel: usize) -> i128 {
        (i128::from(self.high[channel]) << LOW) + i128::from(self.low[channel])
    }

    /// True if the sum of weights is not 0.
    pub fn has_weight(&self) -> bool {
        self.high[3] != 0 || self.low[3] != 0
    }

    /// The weighted mean: the filtered value of a pixel. 0 without weight.
    pub fn mean(&self, scale: Scale) -> DVec3 {
        let sum = self.weighted(scale);
        if sum.w == 0.0 { DVec3::ZERO } else { sum.truncate() / sum.w }
    }

    /// The numbers of low units of the colors and the weight, with the sign in the lowest bit: small numbers of both signs have high bits of 0.
    pub fn zigzags(&self) -> [u128; 4] {
        from_fn(|channel| {
            let fixed = self.fixed(channel);
            (fixed << 1 ^ fixed >> 127).cast_unsigned()
        })
    }

    /// The sum with these [numbers](Sum::zigzags). `None` if no sum is that large.
    pub fn from_zigzags(zigzags: [u128; 4]) -> Option<Sum> {
        let mut sum = Sum::default();
        for (channel, zigzag) in zigzags.into_iter().enumerate() {
            let fixed = (zigzag >> 1).cast_signed() ^ -((zigzag & 1).cast_signed());
            sum.high[channel] = i64::try_from(fixed >> LOW).ok()?;
            sum.low[channel] = fixed as i64 & ((1 << LOW) - 1);
        }
        Some(sum)
    }

    /// Makes high units of low ones. Equal sums then have equal bits.
    #[inline(always)]
    fn carry(&mut self) {
        for (high, low) in self.high.iter_mut().zip(&mut self.low) {
            *high = high.saturating_add(*low >> LOW);
            *low &= (1 << LOW) - 1;
        }
    }
}

/// A sum of few samples, in high units. It is as exact as [`Sum`], and faster to add to.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ShortSum {
    /// Multiples of 2^-9 units. A sample has 2^32 units at most, and a weight of 1 at most: 2^53 of these multiples hold 4096.
    high: DVec4,
    /// Multiples of a low unit, 2^-51 units. A sample adds 2^-10 units at most: 2^53 low units hold 4096.
    low: DVec4,
}

impl ShortSum {
    /// The most samples. Half of what there is room for: largest weights are about 1.
    pub const MOST: u32 = 2048;

    /// Adds all to a sum.
    pub fn add_to(self, sum: &mut Sum) {
        *sum += Sum::new(self.high);
        *sum += Sum::new(self.low);
    }
}

impl AddAssign<DVec4> for ShortSum {
    #[inline(always)]
    fn add_assign(&mut self, units: DVec4) {
        // Adding and subtracting such a number leaves the nearest multiple.
        const MULTIPLES: [f64; 2] = [1.5 * (1_u64 << 43) as f64, 3.0];
        let [high, low] = MULTIPLES.map(DVec4::splat);
        let rounded = (units + high) - high;
        self.high += rounded;
        self.low += (units - rounded + low) - low;
    }
}

impl AddAssign for Sum {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for channel in 0..4 {
            self.high[channel] = self.high[channel].saturating_add(other.high[channel]);
            self.low[channel] += other.low[channel];
        }
        self.carry();
    }
}

/// The sums of some samples of each pixel, row by row.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PixelSums {
    pub filtered: Vec<Sum>,
    /// The sums of the samples in each pixel itself, without the filter. Empty if the filter makes no difference.
    pub unfiltered: Vec<Sum>,
}

impl PixelSums {
    pub fn new(size: usize, has_unfiltered: bool) -> PixelSums {
        let unfiltered = if has_unfiltered { size } else { 0 };
        PixelSums { filtered: vec![Sum::default(); size], unfiltered: vec![Sum::default(); unfiltered] }
    }

    /// Both kinds of sums.
    pub fn kinds(&self) -> [&Vec<Sum>; 2] {
        [&self.filtered, &self.unfiltered]
    }

    pub fn kinds_mut(&mut self) -> [&mut Vec<Sum>; 2] {
        [&mut self.filtered, &mut self.unfiltered]
    }

    /// Sets all sums to 0.
    pub fn clear(&mut self) {
        self.kinds_mut().into_iter().for_each(|sums| sums.fill(Sum::default()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_pcg::Pcg64Mcg;

    /// A sample of this value.
    fn sum(value: f64, weight: f64, scale: Scale) -> Sum {
        Sum::new(scale.units((DVec3::splat(value) * weight).extend(weight)))
    }

    #[test]
    fn sums_are_exact() {
        for brightness in [1e-30, 1.0, 3e20] {
            let scale = Scale::new(brightness);
            let unit = scale.brightness;
            let mut all = Sum::default();
            // Of these, `f64` loses the small ones.
            for x in [1e-8_f32, 1.0, 1e9, -1.0, -1e9].map(|x| f64::from(x) * unit) {
                all += sum(x, 1.0, scale);
            }
            let expected = f64::from(1e-8_f32) * unit;
            assert!((all.weighted(scale).x / expected - 1.0).abs() < 1e-6, "{brightness}");
        }
    }

    #[test]
    fn zigzags_are_those_of_the_sum() {
        for high in [i64::MIN, i64::MIN + 1, -1, 0, 1, 4000, i64::MAX] {
            for low in [0, 1, 1 << 31, (1 << LOW) - 1] {
                let sum = Sum { high: [high, 0, -high.max(-i64::MAX), 7], low: [low; 4] };
                assert_eq!(Sum::from_zigzags(sum.zigzags()), Some(sum));
            }
        }
        for value in [-900.0, 900.0] {
            assert!(sum(value, 1.0, Scale::ONE).zigzags().iter().all(|zigzag| *zigzag < 1 << 64));
        }
        assert_eq!(Sum::from_zigzags([u128::MAX; 4]), None);
    }

    #[test]
    fn values_are_rounded_once() {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        for bits in 0..64 {
            for _ in 0..100 {
                let high = random.random::<i64>() >> bits;
                let low = random.random::<i64>() & ((1 << LOW) - 1);
                let sum = Sum { high: [high; 4], low: [low; 4] };
                assert_eq!(sum.low_units(0).to_bits(), (sum.fixed(0) as f64).to_bits(), "{high} {low}");
            }
        }
    }

    #[test]
    fn the_brightest_samples_do_not_overflow() {
        let scale = Scale::new(1.0);
        let most = scale.clamped(Vec3::MAX).x;
        assert_eq!(most, MOST);
        assert!(scale.clamps(Vec3::MAX) && !scale.clamps(Vec3::splat(MOST as f32)));
        // 2^30 of them.
        let mut all = sum(most, 1.0, scale);
        (0..30).for_each(|_| all += all);
        assert_eq!(all.mean(scale), DVec3::splat(most));
    }

    /// Any split, merged in any order, gives the same bits.
    #[test]
    fn partial_sums_merge_in_any_order() {
        let (mut random, scale) = (Pcg64Mcg::seed_from_u64(1), Scale::new(1.0));
        for _ in 0..200 {
            // Over 12 powers of ten, as fireflies and shadows are.
            let mut samples: Vec<Sum> = (0..64)
                .map(|_| {
                    sum(10_f64.powf(random.random::<f64>() * 12.0 - 6.0), random.random::<f64>() - 0.2, scale)
                })
                .collect();
            let total = |sums: &[Sum]| {
                sums.iter().fold(Sum::default(), |mut sum, more| {
                    sum += *more;
                    sum
                })
            };
            let expected = total(&samples);
            samples.shuffle(&mut random);
            let (first, others) = samples.split_at(random.random_range(0..=64));
            let mut found = total(others);
            found += total(first);
            assert_eq!(found, expected);
        }
    }

    /// As many samples as there is room for, the brightest and the darkest together, keep every digit.
    #[test]
    fn short_sums_are_exact() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for kind in 0..4 {
            let (mut short, mut long) = (ShortSum::default(), Sum::default());
            for at in 0..ShortSum::MOST {
                let size = match (kind, at % 2) {
                    (0, _) | (3, 0) => MOST,
                    (1, _) | (3, _) => 1e-12,
                    _ => 10_f64.powf(random.random::<f64>() * 24.0 - 15.0),
                };
                // Filters have lobes of both signs, and weights a little above 1.
                let weight = if kind == 0 { 1.2 } else { 1.4 * random.random::<f64>() - 0.2 };
                let units = Scale::ONE.units((DVec3::splat(size) * weight).extend(weight));
                short += units;
                long += Sum::new(units);
            }
            let mut found = Sum::default();
            short.add_to(&mut found);
            assert_eq!(found, long, "{kind}");
        }
    }
}
