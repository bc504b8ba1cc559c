//! Exact sums of weighted samples: in fixed point, so that partial sums give the same bits in any order. `FilmSums` is the sums of a
//! whole film as plain data, which programs add, write and read.

use std::array::from_fn;
use std::ops::AddAssign;
use std::sync::PoisonError;

use glam::{DVec3, DVec4, Vec3};
use lookat_image::{Image, IntegerChannel};
use serde::{Deserialize, Serialize};

use super::{Area, Film, develop, lock};

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
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
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
            let fixed = (i128::from(self.high[channel]) << LOW) + i128::from(self.low[channel]);
            fixed as f64 / LOW_UNITS / if channel < 3 { scale.high } else { HIGH }
        };
        DVec4::from(from_fn(value))
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

    /// A word of 32 bits: see [`name`].
    fn word(&self, color: usize, word: usize) -> u32 {
        let units = if word < 2 { self.high[color] } else { self.low[color] };
        (units >> (32 * (word % 2))) as u32
    }

    /// Sets a word, which is 0 before.
    fn set_word(&mut self, color: usize, word: usize, bits: u32) {
        let units = if word < 2 { &mut self.high[color] } else { &mut self.low[color] };
        *units |= i64::from(bits) << (32 * (word % 2));
    }

    /// True if the low units are fewer than one high unit.
    pub fn is_carried(&self) -> bool {
        self.low.iter().all(|low| (0..1 << LOW).contains(low))
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

/// The value of a pixel: the mean of its samples, and what splats of so many light paths add.
pub(crate) fn value(sum: &Sum, splats: Option<&Sum>, light_paths: u64, scale: Scale) -> DVec3 {
    let splats = splats.map(|splats| splats.weighted(scale).truncate() / light_paths.max(1) as f64);
    sum.mean(scale) + splats.unwrap_or_default()
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

/// The spread of the replicates of a pixel. Replicates are independent estimates of its value, each a weighted sum. They are
/// added in a fixed order.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Spread {
    /// About the value of the pixel: sums of what differs from it do not lose their digits.
    near: DVec3,
    /// With the weight W of a replicate and the difference D between its sum and W times `near`: the sums of D and W, of D D, of D W
    /// and of W W.
    off: DVec3,
    weight: f64,
    squares: DVec3,
    products: DVec3,
    weights: f64,
    pub replicates: u32,
    /// The samples of the pixel itself in all of them.
    pub samples: u32,
}

impl Spread {
    /// Adds a replicate: its weighted sum and the samples of the pixel itself.
    pub fn add(&mut self, sum: DVec4, samples: u32) {
        let weight = sum.w;
        if self.replicates == 0 && weight != 0.0 {
            self.near = sum.truncate() / weight;
        }
        let off = sum.truncate() - self.near * weight;
        self.off += off;
        self.weight += weight;
        self.squares += off * off;
        self.products += off * weight;
        self.weights += weight * weight;
        self.replicates += 1;
        self.samples += samples;
    }

    /// The standard error of the weighted mean of all replicates together; infinite for less than two, and where it is not known.
    /// It uses the delta method for a ratio: replicates with the sum S and the weight W scatter by S - M W around the mean
    /// M.
    pub fn standard_error(&self) -> Vec3 {
        let weight = self.weight;
        if self.replicates < 2 || weight == 0.0 {
            return Vec3::INFINITY;
        }
        let off = self.off / weight;
        let squares = self.squares - 2.0 * off * self.products + off * off * self.weights;
        let count = f64::from(self.replicates);
        // Rounding may leave less than nothing.
        let variance = squares.max(DVec3::ZERO) * (count / (count - 1.0)) / (weight * weight);
        let errors = DVec3::from(variance.to_array().map(f64::sqrt)).as_vec3();
        Vec3::select(errors.is_finite_mask(), errors, Vec3::INFINITY)
    }
}

/// All that the samples of a picture have brought: per pixel the sums of weighted radiance and of weights, in integers, and how many
/// samples there are. So partial sums give the same bits in any order, and the sum of all is the picture of one rendering.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmSums {
    /// The film of the picture.
    pub film: lookat_scene::Film,
    /// The weights of the filter for the unit squares around a pixel, across and down: from so many pixels before its own on to so many
    /// after it as the filter reaches.
    pub weights: [Vec<f64>; 2],
    /// The samples taken in each pixel of the crop window and as far beyond it as the filter reaches, row by row.
    pub counts: Vec<u32>,
    /// The light paths whose splats are in the sums.
    pub light_paths: u64,
    scale: Scale,
    /// The sums of samples: one for each pixel of the crop window, row by row.
    sums: Vec<Sum>,
    /// The sums of splats in the same order. Empty without splats.
    splats: Vec<Sum>,
}

/// Why sums do not add up, or cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FilmSumsError {
    /// The film, the filter or the brightness of the scene differs.
    #[error("the film sums are of different pictures: scene, film and filter must be the same")]
    OtherPicture,
    /// A pixel would have more samples than a film, or this rendering, has room for.
    #[error("a pixel would have more samples than there is room for")]
    TooManySamples,
    /// The bytes are no film sums, are damaged, or of another version of lookat.
    #[error("these are no film sums, or they are damaged, or of another version of lookat")]
    Unreadable,
}

impl Film<'_> {
    /// Starts with sums, once the scale is set. `most`: the samples that each pixel is to have. Fails if they are of another picture, or have
    /// more samples.
    pub fn restore(&self, so_far: FilmSums, most: u32) -> Result<(), FilmSumsError> {
        let weights = self.filter.of_squares();
        let is_own = (&so_far.film, &so_far.weights, so_far.scale) == (self.settings, &weights, self.scale());
        if !is_own || !so_far.splats.is_empty() {
            return Err(FilmSumsError::OtherPicture);
        }
        if so_far.counts.iter().any(|count| *count > most) {
            return Err(FilmSumsError::TooManySamples);
        }
        let (crop, sources) = (self.crop(), self.sources());
        for tile in &self.tiles {
            let tile = &mut *lock(tile);
            for (pixel, count) in tile.sources.pixels().zip(&mut tile.counts) {
                *count = so_far.counts[sources.index(pixel)];
            }
            for (pixel, sum) in tile.bounds.pixels().zip(&mut tile.sums) {
                *sum = so_far.sums[crop.index(pixel)];
            }
        }
        Ok(())
    }

    /// The sums so far: each sample is in all of the pixels that it counts for, or in none.
    pub fn sums(&self) -> FilmSums {
        let (crop, sources) = (self.crop(), self.sources());
        let mut all = FilmSums {
            film: self.settings.clone(),
            weights: self.filter.of_squares(),
            counts: vec![0; sources.size()],
            light_paths: self.light_paths(),
            scale: self.scale(),
            sums: vec![Sum::default(); crop.size()],
            splats: Vec::new(),
        };
        // Only now: other threads wait.
        let _whole = self.adding.write().unwrap_or_else(PoisonError::into_inner);
        for tile in &self.tiles {
            let tile = lock(tile);
            for (pixel, count) in tile.sources.pixels().zip(&tile.counts) {
                all.counts[sources.index(pixel)] = *count;
            }
            for (own, pixel) in tile.bounds.pixels().enumerate() {
                all.sums[crop.index(pixel)] = tile.so_far(own);
            }
            if !tile.splats.is_empty() {
                all.splats.resize(crop.size(), Sum::default());
            }
            for (splats, pixel) in tile.splats.iter().zip(tile.bounds.pixels()) {
                all.splats[crop.index(pixel)] = *splats;
            }
        }
        all
    }
}

/// Changes whenever the bytes of a header do.
const FORMAT: u32 = 2;

/// The most pixels that any filter reaches.
const MOST_REACH: usize = 100;

/// The pixels in which samples are taken: see [`FilmSums::counts`].
fn sources(film: &lookat_scene::Film, weights: &[Vec<f64>; 2]) -> Area {
    let reach = weights.each_ref().map(|weights| (weights.len() / 2) as u32);
    Area::of(film.crop).grown(reach)
}

/// What [`FilmSums`] are made of beside their integers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SumsHeader {
    /// See [`FilmSums::film`].
    pub film: lookat_scene::Film,
    /// See [`FilmSums::weights`].
    pub weights: [Vec<f64>; 2],
    /// See [`FilmSums::light_paths`].
    pub light_paths: u64,
    scale: Scale,
    /// [`FilmSums::counts`], as runs of equal ones: how many, and the samples of each.
    runs: Vec<(u32, u32)>,
}

impl SumsHeader {
    /// The number of samples, if all pixels have as many.
    pub fn samples(&self) -> Option<u32> {
        let samples = self.runs.first()?.1;
        self.runs.iter().all(|run| run.1 == samples).then_some(samples)
    }

    /// The most samples of a pixel.
    pub fn most_samples(&self) -> u32 {
        self.runs.iter().map(|run| run.1).max().unwrap_or(0)
    }

    /// As bytes, without loss.
    pub fn to_bytes(&self) -> Vec<u8> {
        postcard::to_allocvec(&(FORMAT, self)).expect("plain data in memory can be written")
    }

    /// What [`SumsHeader::to_bytes`] has written.
    pub fn from_bytes(bytes: &[u8]) -> Result<SumsHeader, FilmSumsError> {
        let read: Result<(u32, SumsHeader), _> = postcard::from_bytes(bytes);
        let read = read.ok().filter(|(format, header)| *format == FORMAT && header.is_sound());
        read.map(|(_, header)| header).ok_or(FilmSumsError::Unreadable)
    }

    /// True if it can be that of a film: nothing else takes memory.
    fn is_sound(&self) -> bool {
        let lookat_scene::Film { resolution: [width, height], crop, .. } = self.film;
        let fits = |from, to, side| from < to && to <= side && side <= lookat_scene::MAX_SIDE;
        let reaches = self.weights.each_ref().map(Vec::len);
        fits(crop.x0, crop.x1, width)
            && fits(crop.y0, crop.y1, height)
            && crop.area() <= lookat_scene::MAX_PIXELS
            && reaches.iter().all(|count| count % 2 == 1 && count / 2 <= MOST_REACH)
            && self.scale.is_valid()
            && self.runs.iter().map(|(length, _)| u64::from(*length)).sum::<u64>()
                == sources(&self.film, &self.weights).size() as u64
    }

    /// Bytes of the sums that it belongs to, about.
    pub fn bytes(&self) -> u64 {
        let counts = sources(&self.film, &self.weights).size() * size_of::<u32>();
        self.film.crop.area() * size_of::<Sum>() as u64 + counts as u64
    }
}

/// What names of channels begin with.
const SUMS: &str = "sums";
const SPLATS: &str = "splats";

/// The colors, or the weight, and the words of 32 bits of their sums.
fn words() -> impl Iterator<Item = (usize, usize)> {
    (0..4).flat_map(|color| (0..4).map(move |word| (color, word)))
}

/// The name of a channel of words: first the high units, then the low ones, each with its lower word first.
fn name(kind: &str, color: usize, word: usize) -> String {
    format!("{kind}.{}.{word}", ["R", "G", "B", "weight"][color])
}

impl FilmSums {
    /// Bytes of a pixel.
    pub(crate) const PIXEL_BYTES: usize = size_of::<Sum>() + size_of::<u32>();

    /// Adds the sums of other samples. If it fails, nothing has changed. The caller sees to it that both are of one scene, and have other
    /// samples: other seeds or numbers.
    pub fn add(&mut self, other: &FilmSums) -> Result<(), FilmSumsError> {
        if !self.is_like(other) {
            return Err(FilmSumsError::OtherPicture);
        }
        let count = |(own, more): (&u32, &u32)| own.checked_add(*more);
        let counts: Option<_> = self.counts.iter().zip(&other.counts).map(count).collect();
        let light_paths = self.light_paths.checked_add(other.light_paths);
        self.counts = counts.filter(|_| light_paths.is_some()).ok_or(FilmSumsError::TooManySamples)?;
        self.light_paths = light_paths.unwrap_or_default();
        self.splats.resize(self.splats.len().max(other.splats.len()), Sum::default());
        for (own, more) in [(&mut self.sums, &other.sums), (&mut self.splats, &other.splats)] {
            for (own, more) in own.iter_mut().zip(more) {
                *own += *more;
            }
        }
        Ok(())
    }

    /// True if both are of one picture, as far as sums tell.
    fn is_like(&self, other: &FilmSums) -> bool {
        (&self.film, &self.weights, self.scale) == (&other.film, &other.weights, other.scale)
    }

    /// The picture: linear RGB, with the crop window as data window. Pixels without samples are black.
    pub fn image(&self) -> Image {
        let value = |(at, sum): (usize, &Sum)| value(sum, self.splats.get(at), self.light_paths, self.scale);
        develop(&self.film, self.sums.iter().enumerate().map(value).enumerate())
    }

    /// The samples of each pixel of the picture, row by row.
    pub fn samples(&self) -> impl Iterator<Item = u32> {
        let sources = sources(&self.film, &self.weights);
        Area::of(self.film.crop).pixels().map(move |pixel| self.counts[sources.index(pixel)])
    }

    /// The mean number of samples of the pixels of the picture.
    pub fn mean_samples(&self) -> f64 {
        self.samples().map(f64::from).sum::<f64>() / self.film.crop.area() as f64
    }

    /// The sums as channels of integers, without loss, and what else they need.
    pub fn to_channels(&self) -> (SumsHeader, Vec<IntegerChannel>) {
        let FilmSums { film, weights, light_paths, scale, counts, .. } = self;
        let runs = counts.chunk_by(|a, b| a == b).map(|run| (run.len() as u32, run[0])).collect();
        let (film, weights) = (film.clone(), weights.clone());
        let header = SumsHeader { film, weights, light_paths: *light_paths, scale: *scale, runs };
        let kinds = [(SUMS, &self.sums), (SPLATS, &self.splats)];
        let channels = kinds.into_iter().filter(|(_, sums)| !sums.is_empty()).flat_map(|(kind, sums)| {
            words().map(move |(color, word)| IntegerChannel {
                name: name(kind, color, word),
                samples: sums.iter().map(|sum| sum.word(color, word)).collect(),
            })
        });
        (header, channels.collect())
    }

    /// The sums that [`FilmSums::to_channels`] has written.
    pub fn from_channels(header: SumsHeader, channels: &[IntegerChannel]) -> Result<FilmSums, FilmSumsError> {
        let SumsHeader { film, weights, light_paths, scale, runs } = header;
        let read = |kind: &str| -> Option<Vec<Sum>> {
            let mut sums = vec![Sum::default(); Area::of(film.crop).size()];
            for (color, word) in words() {
                let own = name(kind, color, word);
                let channel = channels.iter().find(|channel| channel.name == own)?;
                for (sum, bits) in sums.iter_mut().zip(&channel.samples) {
                    sum.set_word(color, word, *bits);
                }
            }
            Some(sums)
        };
        // Before memory is taken for as many.
        let is_sized = |channel: &IntegerChannel| channel.samples.len() as u64 == film.crop.area();
        if channels.is_empty() || !channels.iter().all(is_sized) {
            return Err(FilmSumsError::Unreadable);
        }
        let sums = read(SUMS).ok_or(FilmSumsError::Unreadable)?;
        let splats = read(SPLATS).unwrap_or_default();
        let mut counts = Vec::with_capacity(sources(&film, &weights).size());
        for (length, count) in runs {
            counts.resize(counts.len() + length as usize, count);
        }
        let is_carried = sums.iter().chain(&splats).all(Sum::is_carried);
        let all = FilmSums { film, weights, counts, light_paths, scale, sums, splats };
        if is_carried { Ok(all) } else { Err(FilmSumsError::Unreadable) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Part, Settings, render};
    use crate::testing::scene;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_pcg::Pcg64Mcg;
    use std::ops::ControlFlow;

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

    /// The error that the spread of replicates tells.
    fn error(replicates: &[DVec4]) -> Vec3 {
        let mut spread = Spread::default();
        replicates.iter().for_each(|replicate| spread.add(*replicate, 1));
        spread.standard_error()
    }

    #[test]
    fn the_spread_is_that_of_the_replicates() {
        assert_eq!(error(&[DVec4::new(1.0, 5.0, 0.0, 1.0)]), Vec3::INFINITY);
        // The variance of 1, 2 and 6 is 7.
        let values = [1.0, 2.0, 6.0].map(|x| DVec4::new(x, 5.0, 0.0, 1.0));
        assert!((error(&values) - Vec3::new((7.0_f32 / 3.0).sqrt(), 0.0, 0.0)).length() < 1e-6);
    }

    /// Errors are known for values from black to brighter than any picture, and far below the value. Only black has errors of 0.
    #[test]
    fn errors_of_dark_and_bright_pixels_are_not_lost() {
        for mean in [0.0, 1e-12, 1e-4, 1.0, 1e6, 1e9] {
            for relative in [0.1, 1e-6] {
                let of = |at: usize| mean * (1.0 + if at.is_multiple_of(2) { relative } else { -relative });
                let replicates: Vec<_> = (0..16).map(|at| DVec3::splat(of(at) * 64.0).extend(64.0)).collect();
                let found = error(&replicates).x;
                let expected = (relative * mean / 15_f64.sqrt()) as f32;
                assert!(
                    (found - expected).abs() <= 1e-3 * expected + 1e-15,
                    "{mean} {relative}: {found} {expected}"
                );
            }
        }
    }

    /// With weights of both signs: over many pixels of random samples, the mean squared error of the values is the mean of the
    /// squared standard errors.
    #[test]
    fn the_spread_tells_the_error_under_negative_weights() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut sums = [0.0; 2];
        for _ in 0..20_000 {
            let (mut all, mut spread) = (Sum::default(), Spread::default());
            for _ in 0..16 {
                let mut replicate = DVec4::ZERO;
                for _ in 0..16 {
                    let (is_negative, value) = (random.random::<f64>() < 0.2, random.random::<f64>());
                    let (weight, value) =
                        if is_negative { (-0.5, 3.0 + 2.0 * value) } else { (1.0, 3.0 + value) };
                    replicate += (DVec3::splat(value) * weight).extend(weight);
                }
                spread.add(replicate, 16);
                all += Sum::new(Scale::ONE.units(replicate));
            }
            // The mean is 3.5 times 0.8 minus 4 times 0.1, over 0.7.
            sums[0] += (all.mean(Scale::ONE).x - 2.4 / 0.7).powi(2);
            sums[1] += f64::from(spread.standard_error().x).powi(2);
        }
        let ratio = sums[0] / sums[1];
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }

    /// The sums of a picture at its end, and the picture.
    fn sums(seed: u64, width: u32, lamp: &str) -> (FilmSums, Image) {
        filtered(seed, width, lamp, "gaussian")
    }

    /// The sums and the picture of one rendering with this filter.
    fn filtered(seed: u64, width: u32, lamp: &str, filter: &str) -> (FilmSums, Image) {
        let scene = scene(&format!(
            "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" {width} \"integer yresolution\" 16
            \"float cropwindow\" [.2 .9 0 1] \"float scale\" 3 Camera \"perspective\" PixelFilter \"{filter}\"
            Sampler \"sobol\" \"integer pixelsamples\" 5 Integrator \"path\" WorldBegin
            LightSource \"infinite\" \"rgb L\" [.5 1 {lamp}] Shape \"sphere\" WorldEnd"
        ));
        let settings = Settings { seed, keep_sums: true, ..Settings::default() };
        let rendered = render(&scene, &settings, &|_| ControlFlow::Continue(()));
        (rendered.sums.unwrap(), rendered.image)
    }

    #[test]
    fn sums_give_the_picture_and_add_up_in_any_order() {
        let parts = [1, 2, 3].map(|seed| sums(seed, 24, "2"));
        for (sums, image) in &parts {
            assert_eq!(sums.image(), *image);
            assert!(sums.counts.iter().all(|count| *count == 5));
        }
        let sum = |order: [usize; 3]| {
            let mut sum = parts[order[0]].0.clone();
            order[1..].iter().for_each(|part| sum.add(&parts[*part].0).unwrap());
            sum
        };
        let all = sum([0, 1, 2]);
        assert_eq!(all, sum([2, 0, 1]));
        assert!(all.counts.iter().all(|count| *count == 15));
        let means = |image: &Image| -> f64 {
            image.channels.iter().flat_map(|channel| &channel.samples).map(|value| f64::from(*value)).sum()
        };
        let mean = parts.iter().map(|(_, image)| means(image)).sum::<f64>() / 3.0;
        assert!((means(&all.image()) / mean - 1.0).abs() < 1e-3);
    }

    /// The sums of parts are those of the whole, in every bit: where a part ends makes no difference.
    #[test]
    fn parts_add_up_to_the_sums_of_the_whole() {
        for filter in ["box", "triangle", "gaussian", "mitchell", "sinc"] {
            let scene = scene(&format!(
                "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 30
                Camera \"perspective\" PixelFilter \"{filter}\" Sampler \"halton\" \"integer pixelsamples\" 53
                Integrator \"path\" WorldBegin LightSource \"infinite\" \"rgb L\" [.5 1 1e-3]
                LightSource \"point\" \"point from\" [0 2 -2] \"rgb I\" [1e3 1e3 1e3] Shape \"sphere\" WorldEnd"
            ));
            let sums = |part: Option<Part>| {
                let settings = Settings { part, keep_sums: true, ..Settings::default() };
                render(&scene, &settings, &|_| ControlFlow::Continue(())).sums.unwrap()
            };
            let whole = sums(None);
            for of in [2, 7, 53] {
                let mut added = sums(Some(Part { index: 0, of }));
                (1..of).for_each(|index| added.add(&sums(Some(Part { index, of }))).unwrap());
                assert!(added == whole, "{filter}: {of} parts");
            }
        }
    }

    #[test]
    fn sums_are_written_and_read_without_loss() {
        let (mut sums, _) = sums(1, 24, "2");
        sums.counts[7] += 3;
        let (header, channels) = sums.to_channels();
        assert_eq!(header.samples(), None);
        let bytes = header.to_bytes();
        let read = |bytes: &[u8]| FilmSums::from_channels(SumsHeader::from_bytes(bytes)?, &channels);
        assert_eq!(read(&bytes), Ok(sums));
        for bad in [&bytes[..bytes.len() / 2], &bytes[1..], b"", b"PF\n8 8\n"] {
            assert_eq!(read(bad), Err(FilmSumsError::Unreadable));
        }
        // Damaged bytes never panic.
        for (at, bit) in (0..bytes.len()).flat_map(|at| (0..8).map(move |bit| (at, bit))) {
            let mut bad = bytes.clone();
            bad[at] ^= 1 << bit;
            if let Ok(sums) = read(&bad) {
                sums.image();
            }
        }
    }

    #[test]
    fn sums_of_other_pictures_do_not_add_up() {
        let (mut own, _) = sums(1, 24, "2");
        let before = own.clone();
        // Another width, another brightness.
        for (width, lamp) in [(25, "2"), (24, "2000")] {
            assert_eq!(own.add(&sums(1, width, lamp).0), Err(FilmSumsError::OtherPicture));
        }
        // Another filter of the same radius.
        assert_eq!(own.add(&filtered(1, 24, "2", "mitchell").0), Err(FilmSumsError::OtherPicture));
        let mut full = own.clone();
        full.counts[7] = u32::MAX;
        assert_eq!(own.add(&full), Err(FilmSumsError::TooManySamples));
        assert_eq!(own, before);
    }
}
