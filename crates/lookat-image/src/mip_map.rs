//! Pictures that can be looked up at any place and any size (PBR 10.4.3): mip maps, their Lanczos filter for sizes that are no
//! powers of two, and elliptically weighted averages.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::f64::consts::PI;
use std::fmt;
use std::ops::{Add, Mul, Range};
use std::sync::LazyLock;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// The texels beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture repeats.
    Repeat,
    /// All texels are 0.
    Black,
    /// The nearest texel of the picture.
    Clamp,
}

/// A value that can be averaged: one number, or linear RGB.
pub trait Texel:
    Copy + Default + fmt::Debug + PartialEq + Send + Sync + Add<Output = Self> + Mul<f32, Output = Self>
{
    /// Raises negative components to 0.
    fn not_negative(self) -> Self;
}

impl Texel for f32 {
    fn not_negative(self) -> Self {
        self.max(0.0)
    }
}

impl Texel for Vec3 {
    fn not_negative(self) -> Self {
        self.max(Vec3::ZERO)
    }
}

/// A picture in ever coarser versions: each has half the width and height of the one before, down to one texel.
///
/// Places are in (0..1)^2 over the picture; the first texel of the first row is at the corner (0, 0).
#[derive(Clone, PartialEq)]
pub struct MipMap<T> {
    /// From finest to coarsest.
    levels: Vec<Level<T>>,
    wrap: Wrap,
    /// The columns and rows of the given picture.
    picture_size: [usize; 2],
}

/// One version of the picture.
#[derive(Clone, PartialEq)]
struct Level<T> {
    width: usize,
    height: usize,
    /// Row by row.
    texels: Vec<T>,
}

impl<T: Texel> MipMap<T> {
    /// Makes the mip map of a picture with `width` times `height` texels, row by row. A Lanczos filter enlarges sizes to the next
    /// powers of two, as in pbrt-v3; negative values become 0 then.
    ///
    /// # Panics
    ///
    /// If the number of texels is another one, or 0.
    pub fn new(width: usize, height: usize, texels: Vec<T>, wrap: Wrap) -> Self {
        assert!(!texels.is_empty() && texels.len() == width * height, "a picture of {width} x {height}");
        let mut level = to_powers_of_two(Level { width, height, texels }, wrap);
        let mut levels = Vec::new();
        while level.texels.len() > 1 {
            let next = level.halved(wrap);
            levels.push(level);
            level = next;
        }
        levels.push(level);
        MipMap { levels, wrap, picture_size: [width, height] }
    }

    /// The most bytes of a mip map of a picture of this size: the coarser versions add a third, or as much again where one side is 1.
    pub fn bytes_of(width: u32, height: u32) -> u64 {
        let [width, height] = [width, height].map(|side| u64::from(side).next_power_of_two());
        let finest = width.saturating_mul(height).saturating_mul(size_of::<T>() as u64);
        finest.saturating_add(if width.min(height) == 1 { finest } else { finest / 2 })
    }

    /// The columns and rows of the picture that the map was made of.
    pub fn picture_size(&self) -> [usize; 2] {
        self.picture_size
    }

    /// Columns of the finest version, a power of two.
    pub fn width(&self) -> usize {
        self.levels[0].width
    }

    /// Rows of the finest version, a power of two.
    pub fn height(&self) -> usize {
        self.levels[0].height
    }

    /// The texels of the finest version, row by row.
    pub fn texels(&self) -> &[T] {
        &self.levels[0].texels
    }

    /// Bytes that the texels of all versions take.
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| size_of_val(&level.texels[..])).sum()
    }

    /// The mean of all texels.
    pub fn mean(&self) -> T {
        self.levels[self.levels.len() - 1].texels[0]
    }

    /// Positions are clamped to this distance in texels: farther ones are not exact.
    pub const FAR: f64 = 1e15;

    /// Four texels of the finest version: rows `t` and `t + 1`, columns `s` and `s + 1`. They may lie beyond the edges.
    #[inline]
    pub fn corners(&self, s: i64, t: i64) -> [T; 4] {
        let Level { width, height, ref texels } = self.levels[0];
        if s >= 0 && t >= 0 && s < width as i64 - 1 && t < height as i64 - 1 {
            let first = t as usize * width + s as usize;
            return [texels[first], texels[first + 1], texels[first + width], texels[first + width + 1]];
        }
        self.wrapped_corners(s, t)
    }

    #[inline(never)]
    fn wrapped_corners(&self, s: i64, t: i64) -> [T; 4] {
        let [low, high] = [t, t + 1].map(|t| self.levels[0].row(t, self.wrap));
        let texel = |row, s| texel(row, s, self.wrap);
        [texel(low, s), texel(low, s + 1), texel(high, s), texel(high, s + 1)]
    }

    /// The finest version at `st`, linear between the centers of texels.
    pub fn bilinear(&self, st: DVec2) -> T {
        self.bilinear_at(0, st)
    }

    /// The mean around `st` over about `width`: linear between texels and between versions (PBR 10.4.4).
    pub fn trilinear(&self, st: DVec2, width: f64) -> T {
        let last = self.levels.len() - 1;
        let level = last as f64 + libm::log2(width.max(1e-8));
        if level >= last as f64 || level.is_nan() {
            return self.mean();
        }
        if level < 0.0 {
            return self.bilinear(st);
        }
        let finer = level as usize;
        let share = (level - finer as f64) as f32;
        lerp(share, self.bilinear_at(finer, st), self.bilinear_at(finer + 1, st))
    }

    fn bilinear_at(&self, level: usize, st: DVec2) -> T {
        let level = &self.levels[level];
        let position = level.position(st);
        let (s, t) = (floor(position.x), floor(position.y));
        let rest = (position - DVec2::new(s as f64, t as f64)).as_vec2();
        let row = |t| lerp(rest.x, level.texel(s, t, self.wrap), level.texel(s + 1, t, self.wrap));
        lerp(rest.y, row(t), row(t + 1))
    }
}

impl<T: Texel> Level<T> {
    /// The texel, which may lie beyond the edges.
    fn texel(&self, s: i64, t: i64, wrap: Wrap) -> T {
        texel(self.row(t, wrap), s, wrap)
    }

    /// The row, which may lie beyond the edges; without texels where nothing is.
    fn row(&self, t: i64, wrap: Wrap) -> &[T] {
        wrapped(t, self.height, wrap).map_or(&[], |t| &self.texels[t * self.width..][..self.width])
    }

    /// The position of `st` among the centers of texels.
    fn position(&self, st: DVec2) -> DVec2 {
        let far = DVec2::splat(MipMap::<T>::FAR);
        (st * DVec2::new(self.width as f64, self.height as f64) - 0.5).clamp(-far, far)
    }

    /// Each texel is the mean of four. As in pbrt-v3, where a side has one texel only, the other is beyond the edge.
    fn halved(&self, wrap: Wrap) -> Level<T> {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = vec![T::default(); width * height];
        texels.par_chunks_mut(width).enumerate().for_each(|(t, row)| {
            let t = 2 * t as i64;
            for (s, texel) in row.iter_mut().enumerate() {
                let s = 2 * s as i64;
                let pair = |t| self.texel(s, t, wrap) + self.texel(s + 1, t, wrap);
                *texel = (pair(t) + pair(t + 1)) * 0.25;
            }
        });
        Level { width, height, texels }
    }
}

/// The texel of a row, which may lie beyond the edges.
fn texel<T: Texel>(row: &[T], s: i64, wrap: Wrap) -> T {
    wrapped(s, row.len(), wrap).map_or(T::default(), |s| row[s])
}

/// The index among `count` texels; `None` for black beyond the edges. `count` is 0 only in a row of black.
#[inline]
fn wrapped(index: i64, count: usize, wrap: Wrap) -> Option<usize> {
    let end = count as i64;
    match wrap {
        _ if (0..end).contains(&index) => Some(index as usize),
        // A division would take longer than all else that is done with a texel.
        Wrap::Repeat if count.is_power_of_two() => Some(index as usize & (count - 1)),
        Wrap::Repeat => Some(index.rem_euclid(end) as usize),
        Wrap::Clamp => Some(index.clamp(0, end - 1) as usize),
        Wrap::Black => None,
    }
}

fn lerp<T: Texel>(x: f32, a: T, b: T) -> T {
    a * (1.0 - x) + b * x
}

/// Omits the texels.
impl<T: Texel> fmt::Debug for MipMap<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "MipMap {{ {} x {}, {:?} }}", self.width(), self.height(), self.wrap)
    }
}

/// Steps of the squared radius in the table of EWA weights, as in pbrt-v3.
const STEPS: usize = 128;

/// A Gaussian that comes to 0 at radius 1: the last weight is 0.
static WEIGHTS: LazyLock<[f32; STEPS]> = LazyLock::new(|| {
    const ALPHA: f64 = 2.0;
    std::array::from_fn(|i| {
        let squared_radius = i as f64 / (STEPS - 1) as f64;
        (libm::exp(-ALPHA * squared_radius) - libm::exp(-ALPHA)) as f32
    })
});

/// The insides of an ellipse around the origin: `a s^2 + b s t + c t^2 < 1`, in texels.
struct Ellipse {
    a: f64,
    b: f64,
    c: f64,
    /// Half the height of a parallelogram that touches the ellipse on all four sides. Two sides are along rows.
    half_height: f64,
    /// Half the length of the sides along rows.
    half_width: f64,
    /// The distance of the middle of a row of the parallelogram from the middle of the row before.
    shear: f64,
}

impl<T: Texel> MipMap<T> {
    /// The elliptically weighted average (PBR 10.4.5; Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989).
    ///
    /// The weighted mean over the ellipse around `st` with the axes `dst0` and `dst1`. If one is more than
    /// `max_anisotropy` times as long as the other, the other is made longer: more blur for less work.
    pub fn ewa(&self, st: DVec2, dst0: DVec2, dst1: DVec2, max_anisotropy: f64) -> T {
        let (major, mut minor) =
            if dst0.length_squared() < dst1.length_squared() { (dst1, dst0) } else { (dst0, dst1) };
        let (major_length, mut minor_length) = (major.length(), minor.length());
        if !major_length.is_finite() {
            return self.mean();
        }
        if minor_length * max_anisotropy < major_length && minor_length > 0.0 {
            let scale = major_length / (minor_length * max_anisotropy);
            minor *= scale;
            minor_length *= scale;
        }
        if minor_length == 0.0 {
            return self.bilinear(st);
        }
        let last = self.levels.len() - 1;
        let level = (last as f64 + libm::log2(minor_length)).max(0.0);
        if level >= last as f64 + 1.0 {
            return self.mean();
        }
        let finer = level as usize;
        let at = |level| self.ewa_at(level, st, major, minor);
        match (level - finer as f64) as f32 {
            // Everywhere in an enlarged picture.
            0.0 => at(finer),
            share => lerp(share, at(finer), at(finer + 1)),
        }
    }

    fn ewa_at(&self, level: usize, st: DVec2, dst0: DVec2, dst1: DVec2) -> T {
        let Some(level) = self.levels.get(level) else { return self.mean() };
        let size = DVec2::new(level.width as f64, level.height as f64);
        Ellipse::new(dst0 * size, dst1 * size).mean(level, level.position(st), self.wrap)
    }
}

impl Ellipse {
    /// The ellipse with these axes, made wider by about one texel, so that there are always texels inside.
    fn new(x: DVec2, y: DVec2) -> Self {
        let a = x.y * x.y + y.y * y.y + 1.0;
        let b = -2.0 * (x.x * x.y + y.x * y.y);
        let c = x.x * x.x + y.x * y.x + 1.0;
        let f = a * c - b * b * 0.25;
        let (half_height, half_width) = (a.sqrt(), (f / a).sqrt());
        Ellipse { a: a / f, b: b / f, c: c / f, half_height, half_width, shear: -0.5 * b / a }
    }

    fn mean<T: Texel>(&self, level: &Level<T>, center: DVec2, wrap: Wrap) -> T {
        let weights = &*WEIGHTS;
        let (mut sum, mut total) = (T::default(), 0.0);
        for t in whole(center.y, self.half_height) {
            let row = level.row(t, wrap);
            let dt = t as f64 - center.y;
            for s in whole(center.x + self.shear * dt, self.half_width) {
                let ds = s as f64 - center.x;
                let squared_radius = self.a * ds * ds + self.b * ds * dt + self.c * dt * dt;
                // The last weight is for texels outside.
                let weight = weights[((squared_radius * STEPS as f64) as i32 as usize).min(STEPS - 1)];
                sum = sum + texel(row, s, wrap) * weight;
                total += weight;
            }
        }
        if total > 0.0 { sum * (1.0 / total) } else { level.texel(center.x as i64, center.y as i64, wrap) }
    }
}

/// The whole numbers that are not farther than `reach` from `middle`.
fn whole(middle: f64, reach: f64) -> Range<i64> {
    -floor(reach - middle)..floor(middle + reach) + 1
}

/// The texels that one new texel is made of.
struct Weights {
    first: i64,
    weights: [f32; 4],
}

/// The picture with both sides brought up to the next power of two; as it is where they are. First across, then down;
/// what comes out below 0 is 0 (pbrt-v3's MIPMap constructor).
fn to_powers_of_two<T: Texel>(level: Level<T>, wrap: Wrap) -> Level<T> {
    let Level { width: old_width, height: old_height, texels } = level;
    let (width, height) = (old_width.next_power_of_two(), old_height.next_power_of_two());
    if (width, height) == (old_width, old_height) {
        return Level { width, height, texels };
    }
    let (across, down) = (weights(old_width, width), weights(old_height, height));
    let mut wide = vec![T::default(); width * old_height];
    wide.par_chunks_mut(width).zip(texels.par_chunks(old_width)).for_each(|(new, old)| {
        for (texel, weights) in new.iter_mut().zip(&across) {
            *texel = weights.sum(old_width, wrap, |s| old[s]);
        }
    });
    drop(texels);
    let mut texels = vec![T::default(); width * height];
    texels.par_chunks_mut(width).zip(&down).for_each(|(row, weights)| {
        for (s, texel) in row.iter_mut().enumerate() {
            *texel = weights.sum(old_height, wrap, |t| wide[t * width + s]).not_negative();
        }
    });
    Level { width, height, texels }
}

impl Weights {
    fn sum<T: Texel>(&self, count: usize, wrap: Wrap, texel: impl Fn(usize) -> T) -> T {
        let mut sum = T::default();
        for (index, weight) in (self.first..).zip(self.weights) {
            if let Some(at) = wrapped(index, count, wrap) {
                sum = sum + texel(at) * weight;
            }
        }
        sum
    }
}

/// The weights of the four nearest of `old` texels for each of `new` ones, by the Lanczos filter. Their sum is 1.
fn weights(old: usize, new: usize) -> Vec<Weights> {
    let one = |i: usize| {
        let center = (i as f64 + 0.5) * old as f64 / new as f64;
        let first = (center - LANCZOS_RADIUS + 0.5).floor();
        let weights = [0.5, 1.5, 2.5, 3.5].map(|at| lanczos((first + at - center) / LANCZOS_RADIUS));
        let sum: f64 = weights.iter().sum();
        Weights { first: first as i64, weights: weights.map(|weight| (weight / sum) as f32) }
    };
    (0..new).map(one).collect()
}

/// The radius of the Lanczos filter, in old texels.
const LANCZOS_RADIUS: f64 = 2.0;

/// sinc(2 x) sinc(x) for `x` from -1 to 1, else 0 (pbrt-v3's Lanczos with tau 2).
fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| if x.abs() < 1e-5 { 1.0 } else { libm::sin(PI * x) / (PI * x) };
    if x.abs() > 1.0 { 0.0 } else { sinc(2.0 * x) * sinc(x) }
}

/// The largest integer that is not above `x`. It saturates at the ends of `i64`; 0 for NaN.
///
/// On baseline x86-64, `f64::floor` is a function call.
#[inline]
pub fn floor(x: f64) -> i64 {
    let toward_zero = x as i64;
    toward_zero.saturating_sub(i64::from(toward_zero as f64 > x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize) -> Vec<f32> {
        (0..count).map(|i| (i * 37 % 101) as f32).collect()
    }

    #[test]
    fn centers_of_texels_are_the_texels() {
        let map = MipMap::new(8, 4, numbers(32), Wrap::Repeat);
        for (i, expected) in numbers(32).into_iter().enumerate() {
            let st = DVec2::new((i % 8) as f64 + 0.5, (i / 8) as f64 + 0.5) / DVec2::new(8.0, 4.0);
            assert_eq!(map.bilinear(st), expected);
            assert_eq!(map.bilinear(st + DVec2::new(3.0, -2.0)), expected);
        }
    }

    #[test]
    fn beyond_the_edges() {
        let at = |wrap, s: f64, t: f64| {
            MipMap::new(2, 2, vec![1.0, 2.0, 3.0, 4.0], wrap).bilinear(DVec2::new(s, t))
        };
        // The left edge is half way between the first texel and what lies beyond.
        assert_eq!(at(Wrap::Repeat, 0.0, 0.25), 1.5);
        assert_eq!(at(Wrap::Clamp, 0.0, 0.25), 1.0);
        assert_eq!(at(Wrap::Black, 0.0, 0.25), 0.5);
        assert_eq!(at(Wrap::Clamp, 7.0, 9.0), 4.0);
        assert_eq!(at(Wrap::Black, 7.0, 9.0), 0.0);
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black] {
            assert!(at(wrap, 1e300, -1e300).is_finite());
        }
    }

    #[test]
    fn each_version_is_the_mean_of_the_one_before() {
        let map = MipMap::new(4, 4, numbers(16), Wrap::Clamp);
        let mean = numbers(16).iter().sum::<f32>() / 16.0;
        assert!((map.mean() - mean).abs() < 1e-5);
        // A width of 1/2 is the version with two texels a side, whose middle is the mean; that of 1/4 the finest.
        let st = DVec2::splat(0.5);
        assert!((map.trilinear(st, 0.5) - mean).abs() < 1e-5);
        assert_eq!(map.trilinear(DVec2::splat(0.375), 0.25), map.bilinear(DVec2::splat(0.375)));
        let both = (map.bilinear(st) + map.trilinear(st, 0.5)) * 0.5;
        assert!((map.trilinear(st, 0.5 / f64::sqrt(2.0)) - both).abs() < 1e-5);
        assert_eq!(map.trilinear(st, f64::INFINITY), map.mean());
    }

    /// A picture of one row, beyond which there is nothing, loses half of its light at each step, as in pbrt-v3.
    #[test]
    fn one_row_on_black_gets_darker() {
        let map = MipMap::new(4, 1, vec![1.0_f32; 4], Wrap::Black);
        assert_eq!(map.mean(), 0.25);
    }

    fn map() -> MipMap<f32> {
        let texels = (0..64 * 32).map(|i| (i * 7919 % 251) as f32).collect();
        MipMap::new(64, 32, texels, Wrap::Repeat)
    }

    /// pbrt-v3's loop over the box around the ellipse finds the same texels as the loop over rows.
    #[test]
    fn the_mean_is_that_over_the_whole_box() {
        let map = map();
        let level = &map.levels[0];
        for (x, y) in [((3.0, 1.0), (-0.5, 1.5)), ((0.2, 0.1), (0.0, 0.3)), ((9.0, 8.0), (1.0, -1.0))] {
            let ellipse = Ellipse::new(x.into(), y.into());
            let center = DVec2::new(17.3, 11.8);
            let (mut sum, mut total) = (0.0, 0.0);
            for t in -30..60 {
                for s in -30..60 {
                    let (ds, dt) = (f64::from(s) - center.x, f64::from(t) - center.y);
                    let squared_radius = ellipse.a * ds * ds + ellipse.b * ds * dt + ellipse.c * dt * dt;
                    if squared_radius < 1.0 {
                        let weight = WEIGHTS[(squared_radius * 128.0) as usize];
                        sum += level.texel(s.into(), t.into(), Wrap::Repeat) * weight;
                        total += weight;
                    }
                }
            }
            assert!((ellipse.mean(level, center, Wrap::Repeat) - sum / total).abs() < 1e-3);
        }
    }

    #[test]
    fn a_point_is_the_finest_version_and_all_is_the_mean() {
        let map = map();
        let st = DVec2::new(0.3, 0.7);
        assert_eq!(map.ewa(st, DVec2::ZERO, DVec2::ZERO, 8.0), map.bilinear(st));
        assert_eq!(map.ewa(st, DVec2::X, DVec2::ZERO, 8.0), map.bilinear(st));
        assert_eq!(map.ewa(st, DVec2::X * 2.0, DVec2::Y * 3.0, 8.0), map.mean());
        assert_eq!(map.ewa(st, DVec2::X * f64::INFINITY, DVec2::Y, 8.0), map.mean());
        // Either axis may be the longer one.
        let (x, y) = (DVec2::new(0.1, 0.02), DVec2::new(0.0, 0.05));
        assert_eq!(map.ewa(st, x, y, 8.0), map.ewa(st, y, x, 8.0));
    }

    /// Of a ramp the mean over any ellipse is the value at its center.
    #[test]
    fn a_ramp_stays() {
        let ramp = MipMap::new(64, 64, (0..64 * 64).map(|i| (i % 64) as f32).collect(), Wrap::Clamp);
        for (x, y) in [((0.05, 0.02), (0.0, 0.03)), ((0.01, 0.0), (0.1, 0.1))] {
            let value = ramp.ewa(DVec2::new(0.5, 0.5), DVec2::from(x), DVec2::from(y), 8.0);
            assert!((value - 31.5).abs() < 0.3, "{value}");
        }
    }

    /// A thin ellipse is widened: across, then, it covers more.
    #[test]
    fn anisotropy_is_limited() {
        let stripes = MipMap::new(64, 64, (0..64 * 64).map(|i| (i / 64 % 2) as f32).collect(), Wrap::Repeat);
        let at = |limit| stripes.ewa(DVec2::new(0.5, 0.5078125), DVec2::X * 0.9, DVec2::Y * 0.001, limit);
        assert!((at(4.0) - 0.5).abs() < 0.01 && (at(1e4) - 0.5).abs() > 0.1);
    }

    fn resampled<T: Texel>(width: usize, height: usize, texels: Vec<T>, wrap: Wrap) -> Vec<T> {
        to_powers_of_two(Level { width, height, texels }, wrap).texels
    }

    #[test]
    fn powers_of_two_stay_with_negative_values() {
        assert_eq!(resampled(2, 1, vec![-1.0, 2.0], Wrap::Repeat), [-1.0, 2.0]);
    }

    /// What is the same everywhere stays so where the picture repeats or is continued.
    #[test]
    fn a_constant_stays() {
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            let all = resampled(5, 3, vec![Vec3::new(1.0, 2.0, 3.0); 15], wrap);
            assert_eq!(all.len(), 32);
            assert!(all.iter().all(|texel| (*texel - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-5));
        }
        assert!(resampled(5, 3, vec![1.0; 15], Wrap::Black)[0] < 0.99);
    }

    /// pbrt-v3's figures for 3 texels to 4: the new centers are at 3/8, 9/8, 15/8 and 21/8 old texels.
    #[test]
    fn weights_are_those_of_lanczos() {
        let four = weights(3, 4);
        assert_eq!(four.iter().map(|one| one.first).collect::<Vec<_>>(), [-2, -1, 0, 1]);
        for (one, i) in four.iter().zip(0..) {
            assert!((one.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let center = (f64::from(i) + 0.5) * 0.75;
            let value = |j: i32| {
                let x = ((one.first as f64 + f64::from(j) + 0.5 - center) / 2.0).abs() * PI;
                if x > PI { 0.0 } else { (2.0 * x).sin() / (2.0 * x) * x.sin() / x }
            };
            let ratio = value(1) / value(2);
            assert!((f64::from(one.weights[1] / one.weights[2]) - ratio).abs() < 1e-4 * ratio.abs());
        }
    }

    /// The filter undershoots beside an edge; the result does not.
    #[test]
    fn nothing_is_negative() {
        let all = resampled(5, 1, vec![0.0, 0.0, 1.0, 0.0, 0.0], Wrap::Clamp);
        assert!(all.iter().all(|texel| *texel >= 0.0) && all.contains(&0.0));
    }

    #[test]
    fn it_is_that_of_the_standard_library() {
        let near_whole = [-3.0_f64, -1.0, -0.0, 0.0, 1.0, 2.0, 4503599627370495.0, -4503599627370497.0];
        for x in near_whole.iter().flat_map(|x| [x.next_down(), *x, x.next_up(), x + 0.5]) {
            assert_eq!(floor(x), x.floor() as i64, "{x}");
        }
    }

    #[test]
    fn what_no_integer_holds() {
        assert_eq!(
            [floor(1e300), floor(f64::INFINITY), floor(-(2.0_f64.powi(63)))],
            [i64::MAX, i64::MAX, i64::MIN]
        );
        assert_eq!([-1e19, -1e300, f64::NEG_INFINITY].map(floor), [i64::MIN; 3]);
        assert_eq!(floor(f64::NAN), 0);
    }
}
