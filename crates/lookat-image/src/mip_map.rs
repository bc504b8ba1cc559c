//! Pictures that can be looked up at any place and any size (PBR 10.4.3).

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod ewa;
mod resample;

use std::fmt;
use std::ops::{Add, Mul};

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use crate::floor;
use resample::to_powers_of_two;

/// What lies beyond the edges of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// Zero.
    Black,
    /// The nearest pixel.
    Clamp,
}

/// A value that can be averaged: one number, or linear RGB.
pub trait Texel:
    Copy + Default + fmt::Debug + PartialEq + Send + Sync + Add<Output = Self> + Mul<f32, Output = Self>
{
    /// With 0 for each component that is less.
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
    /// The finest first.
    levels: Vec<Level<T>>,
    wrap: Wrap,
    /// Columns and rows that were given.
    picture_size: [usize; 2],
}

/// One of the versions.
#[derive(Clone, PartialEq)]
struct Level<T> {
    width: usize,
    height: usize,
    /// Row by row.
    texels: Vec<T>,
}

impl<T: Texel> MipMap<T> {
    /// Of a picture with `width` times `height` texels, row by row. Sizes that are no powers of two are brought to the
    /// next ones by a Lanczos filter, as in pbrt-v3; values below 0 are 0 then.
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

    /// The most bytes that [`MipMap::new`] keeps of a picture of that size: the coarser versions add a third, or as much again
    /// where one side is 1.
    pub fn bytes_of(width: u32, height: u32) -> u64 {
        let [width, height] = [width, height].map(|side| u64::from(side).next_power_of_two());
        let finest = width.saturating_mul(height).saturating_mul(size_of::<T>() as u64);
        finest.saturating_add(if width.min(height) == 1 { finest } else { finest / 2 })
    }

    /// Columns and rows of the picture that it was made of.
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

    /// Places among texels that are farther away are brought nearer: they cannot be told apart.
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
        let place = level.place(st);
        let (s, t) = (floor(place.x), floor(place.y));
        let rest = (place - DVec2::new(s as f64, t as f64)).as_vec2();
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

    /// Where `st` lies among the centers of texels.
    fn place(&self, st: DVec2) -> DVec2 {
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

/// Where `index` lies among `count` texels, of which there may be none only where black lies beyond.
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

/// Without the texels.
impl<T: Texel> fmt::Debug for MipMap<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "MipMap {{ {} x {}, {:?} }}", self.width(), self.height(), self.wrap)
    }
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
}
