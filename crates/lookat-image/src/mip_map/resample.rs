//! Sizes that are powers of two.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::{Level, Texel, Wrap, wrapped};

/// The texels that one new texel is made of.
struct Weights {
    first: i64,
    weights: [f32; 4],
}

/// The picture with both sides brought up to the next power of two; as it is where they are. First across, then down;
/// what comes out below 0 is 0 (pbrt-v3's MIPMap constructor).
pub(super) fn to_powers_of_two<T: Texel>(level: Level<T>, wrap: Wrap) -> Level<T> {
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

/// For each of `new` texels, those of `old` ones that make it: the four nearest, by the Lanczos filter, with a sum of 1.
fn weights(old: usize, new: usize) -> Vec<Weights> {
    let one = |i: usize| {
        let center = (i as f64 + 0.5) * old as f64 / new as f64;
        let first = (center - RADIUS + 0.5).floor();
        let weights = [0.5, 1.5, 2.5, 3.5].map(|at| lanczos((first + at - center) / RADIUS));
        let sum: f64 = weights.iter().sum();
        Weights { first: first as i64, weights: weights.map(|weight| (weight / sum) as f32) }
    };
    (0..new).map(one).collect()
}

/// Of the filter, in old texels.
const RADIUS: f64 = 2.0;

/// sinc(2 x) sinc(x) for `x` from -1 to 1, else 0 (pbrt-v3's Lanczos with tau 2).
fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| if x.abs() < 1e-5 { 1.0 } else { libm::sin(PI * x) / (PI * x) };
    if x.abs() > 1.0 { 0.0 } else { sinc(2.0 * x) * sinc(x) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

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
}
