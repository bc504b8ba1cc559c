//! Pictures that can be looked up at any place and any size (PBR 10.4.3): mip maps, and their Lanczos filter for sizes that are no
//! powers of two.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::f64::consts::PI;
use std::fmt;
use std::ops::{Add, Mul};

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
    /// The number of components.
    const COMPONENTS: usize;

    /// Raises negative components to 0.
    fn not_negative(self) -> Self;

    /// The texel at an index, in bytes of which each stands for a component with this value. `None` behind the last.
    fn of_bytes(bytes: &[u8], index: usize, values: &[f32; 256]) -> Option<Self>;
}

impl Texel for f32 {
    const COMPONENTS: usize = 1;

    fn not_negative(self) -> Self {
        self.max(0.0)
    }

    #[inline]
    fn of_bytes(bytes: &[u8], index: usize, values: &[f32; 256]) -> Option<Self> {
        bytes.get(index).map(|byte| values[usize::from(*byte)])
    }
}

impl Texel for Vec3 {
    const COMPONENTS: usize = 3;

    fn not_negative(self) -> Self {
        self.max(Vec3::ZERO)
    }

    #[inline]
    fn of_bytes(bytes: &[u8], index: usize, values: &[f32; 256]) -> Option<Self> {
        // Without a division by the size of a texel.
        let rgb: &[u8; 3] = bytes.get(index.checked_mul(3)?..)?.first_chunk()?;
        Some(rgb.map(|byte| values[usize::from(byte)]).into())
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

/// One version of a picture.
#[derive(Clone, PartialEq)]
pub struct Level<T> {
    width: usize,
    height: usize,
    texels: Texels<T>,
}

/// Texels, row by row.
#[derive(Clone, PartialEq)]
enum Texels<T> {
    Values(Vec<T>),
    /// A byte for each component.
    Bytes {
        bytes: Vec<u8>,
        /// What the bytes stand for.
        values: Box<[f32; 256]>,
    },
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
        let [full_width, full_height] = [width, height].map(usize::next_power_of_two);
        let texels = Texels::Values(to_powers_of_two([width, height], texels, wrap));
        MipMap::of_finest(Level { width: full_width, height: full_height, texels }, [width, height], wrap)
    }

    /// Makes the mip map of a picture with a byte for each component of a texel. `values`: what the bytes stand for. If both sides are
    /// powers of two, the finest version stays as it is.
    ///
    /// # Panics
    ///
    /// If the number of bytes is another one, or 0.
    pub fn of_bytes(
        width: usize,
        height: usize,
        bytes: Vec<u8>,
        values: Box<[f32; 256]>,
        wrap: Wrap,
    ) -> Self {
        let count = width * height;
        assert!(count > 0 && bytes.len() == count * T::COMPONENTS, "a picture of {width} x {height}");
        if width.is_power_of_two() && height.is_power_of_two() {
            let texels = Texels::Bytes { bytes, values };
            return MipMap::of_finest(Level { width, height, texels }, [width, height], wrap);
        }
        let texel = |index| T::of_bytes(&bytes, index, &values).unwrap_or_default();
        MipMap::new(width, height, (0..count).into_par_iter().map(texel).collect(), wrap)
    }

    fn of_finest(mut level: Level<T>, picture_size: [usize; 2], wrap: Wrap) -> Self {
        let mut levels = Vec::new();
        while level.len() > 1 {
            let next = level.halved(wrap);
            levels.push(level);
            level = next;
        }
        levels.push(level);
        MipMap { levels, wrap, picture_size }
    }

    /// The most bytes of a mip map of a picture of this size: the coarser versions add a third, or as much again where one side is 1.
    /// `of_bytes`: made by [`MipMap::of_bytes`].
    pub fn bytes_of(width: u32, height: u32, of_bytes: bool) -> u64 {
        let sides = [width, height].map(|side| u64::from(side).next_power_of_two());
        let texels = sides[0].saturating_mul(sides[1]);
        let values = texels.saturating_mul(size_of::<T>() as u64);
        let is_kept = of_bytes && width.is_power_of_two() && height.is_power_of_two();
        let finest = if is_kept { texels.saturating_mul(T::COMPONENTS as u64) } else { values };
        finest.saturating_add(if width.min(height) == 1 { values } else { values / 2 })
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

    /// All versions, from finest to coarsest.
    pub fn levels(&self) -> &[Level<T>] {
        &self.levels
    }

    /// The texels beyond the edges.
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// The texels of the finest version, row by row.
    pub fn texels(&self) -> impl Iterator<Item = T> {
        let finest = &self.levels[0];
        (0..finest.len()).map(|index| finest.texel(index))
    }

    /// Bytes that the texels of all versions take.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level<T>| match &level.texels {
            Texels::Values(values) => size_of_val(&values[..]),
            Texels::Bytes { bytes, .. } => bytes.len(),
        };
        self.levels.iter().map(of).sum()
    }

    /// The mean of all texels.
    pub fn mean(&self) -> T {
        self.levels[self.levels.len() - 1].texel(0)
    }

    /// Positions are clamped to this distance in texels: farther ones are not exact.
    pub const FAR: f64 = 1e15;

    /// The finest version at `st`, linear between the centers of texels.
    pub fn bilinear(&self, st: DVec2) -> T {
        let level = &self.levels[0];
        let far = DVec2::splat(Self::FAR);
        let position = (st * DVec2::new(level.width as f64, level.height as f64) - 0.5).clamp(-far, far);
        let (s, t) = (floor(position.x), floor(position.y));
        let rest = (position - DVec2::new(s as f64, t as f64)).as_vec2();
        let [a, b, c, d] = level.corners(s, t, self.wrap);
        lerp(rest.y, lerp(rest.x, a, b), lerp(rest.x, c, d))
    }
}

impl<T: Texel> Level<T> {
    /// Columns, a power of two.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows, a power of two.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    fn len(&self) -> usize {
        self.width * self.height
    }

    /// The texel at an index, row by row; black behind the last.
    #[inline]
    pub fn texel(&self, index: usize) -> T {
        let texel = match &self.texels {
            Texels::Values(values) => values.get(index).copied(),
            Texels::Bytes { bytes, values } => T::of_bytes(bytes, index, values),
        };
        texel.unwrap_or_default()
    }

    /// Four texels: rows `t` and `t + 1`, columns `s` and `s + 1`. They may lie beyond the edges.
    #[inline]
    pub fn corners(&self, s: i64, t: i64, wrap: Wrap) -> [T; 4] {
        let Level { width, height, .. } = *self;
        if s >= 0 && t >= 0 && s < width as i64 - 1 && t < height as i64 - 1 {
            let first = t as usize * width + s as usize;
            return [first, first + 1, first + width, first + width + 1].map(|index| self.texel(index));
        }
        self.wrapped_corners(s, t, wrap)
    }

    #[inline(never)]
    fn wrapped_corners(&self, s: i64, t: i64, wrap: Wrap) -> [T; 4] {
        [(s, t), (s + 1, t), (s, t + 1), (s + 1, t + 1)].map(|(s, t)| {
            let (s, t) = (wrapped(s, self.width, wrap), wrapped(t, self.height, wrap));
            s.zip(t).map_or(T::default(), |(s, t)| self.texel(t * self.width + s))
        })
    }

    /// Each texel is the mean of four. As in pbrt-v3, where a side has one texel only, the other is beyond the edge.
    fn halved(&self, wrap: Wrap) -> Level<T> {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = vec![T::default(); width * height];
        texels.par_chunks_mut(width).enumerate().for_each(|(t, row)| {
            let t = 2 * t as i64;
            for (s, texel) in row.iter_mut().enumerate() {
                let s = 2 * s as i64;
                let [a, b, c, d] = self.corners(s, t, wrap);
                *texel = ((a + b) + (c + d)) * 0.25;
            }
        });
        Level { width, height, texels: Texels::Values(texels) }
    }
}

/// The index among `count` texels; `None` for black beyond the edges.
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

/// The texels that one new texel is made of.
struct Weights {
    first: i64,
    weights: [f32; 4],
}

/// The texels of a picture with both sides brought up to the next power of two; as they are where both are. First across, then down;
/// what comes out below 0 is 0 (pbrt-v3's MIPMap constructor).
fn to_powers_of_two<T: Texel>(old_size: [usize; 2], texels: Vec<T>, wrap: Wrap) -> Vec<T> {
    let ([old_width, old_height], [width, height]) = (old_size, old_size.map(usize::next_power_of_two));
    if [width, height] == old_size {
        return texels;
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
    texels
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
        let sizes = map.levels().iter().map(|level| [level.width(), level.height()]);
        assert_eq!(sizes.collect::<Vec<_>>(), [[4, 4], [2, 2], [1, 1]]);
        let [_, level, _] = map.levels() else { unreachable!() };
        let (texels, first) = (numbers(16), [0, 1, 4, 5].map(|i| numbers(16)[i]));
        assert_eq!(level.texel(0), first.iter().sum::<f32>() / 4.0);
        assert_eq!(level.texel(3), [10, 11, 14, 15].map(|i| texels[i]).iter().sum::<f32>() / 4.0);
    }

    #[test]
    fn bytes_are_the_values_that_they_stand_for() {
        let values: Box<[f32; 256]> = Box::new(std::array::from_fn(|byte| byte as f32 * 0.37 - 1.0));
        for (width, height) in [(8, 4), (1, 16), (5, 3), (1, 1)] {
            let bytes: Vec<u8> = (0..width * height * 3).map(|i| (i * 89 % 256) as u8).collect();
            let numbers = || bytes.iter().map(|byte| values[usize::from(*byte)]);
            for wrap in [Wrap::Repeat, Wrap::Black, Wrap::Clamp] {
                let colors: Vec<f32> = numbers().collect();
                let colors = colors.as_chunks().0.iter().map(|rgb: &[f32; 3]| Vec3::from(*rgb)).collect();
                let of_bytes = MipMap::<Vec3>::of_bytes(width, height, bytes.clone(), values.clone(), wrap);
                let wide = MipMap::new(width, height, colors, wrap);
                check_is_same(&of_bytes, &wide);
                assert!(
                    of_bytes.bytes() as u64 <= MipMap::<Vec3>::bytes_of(width as u32, height as u32, true)
                );
                let gray = MipMap::<f32>::of_bytes(width * 3, height, bytes.clone(), values.clone(), wrap);
                check_is_same(&gray, &MipMap::new(width * 3, height, numbers().collect(), wrap));
            }
        }
        let wide = MipMap::new(64, 64, vec![Vec3::ONE; 64 * 64], Wrap::Repeat).bytes();
        let bytes = MipMap::<Vec3>::of_bytes(64, 64, vec![0; 64 * 64 * 3], values, Wrap::Repeat).bytes();
        assert!(bytes * 16 <= wide * 7, "{bytes} {wide}");
    }

    fn check_is_same<T: Texel>(a: &MipMap<T>, b: &MipMap<T>) {
        let sizes =
            |map: &MipMap<T>| map.levels.iter().map(|level| [level.width, level.height]).collect::<Vec<_>>();
        assert_eq!((sizes(a), a.picture_size), (sizes(b), b.picture_size));
        for (a, own) in a.levels.iter().zip(&b.levels) {
            assert!((0..=own.len()).all(|index| a.texel(index) == own.texel(index)));
            let places = || (-3..12).flat_map(|s| (-3..12).map(move |t| (s, t)));
            assert!(places().all(|(s, t)| a.corners(s, t, b.wrap) == own.corners(s, t, b.wrap)));
        }
    }

    /// A picture of one row, beyond which there is nothing, loses half of its light at each step, as in pbrt-v3.
    #[test]
    fn one_row_on_black_gets_darker() {
        let map = MipMap::new(4, 1, vec![1.0_f32; 4], Wrap::Black);
        assert_eq!(map.mean(), 0.25);
    }

    fn resampled<T: Texel>(width: usize, height: usize, texels: Vec<T>, wrap: Wrap) -> Vec<T> {
        to_powers_of_two([width, height], texels, wrap)
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
