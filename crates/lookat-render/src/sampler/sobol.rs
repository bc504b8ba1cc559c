//! Sobol' points, scrambled after Owen.
//!
//! Each pair of dimensions takes the first two dimensions of the sequence, a (0, 2)-sequence, in an order of its own: [`ORDERS`]. So no
//! pair leaves gaps, however few samples there are, and a pair and the place on the film lie well in four dimensions.
//!
//! The pixels of aligned squares of 4 x 4 share scrambles, so that the errors of neighbors cancel. Each takes the sequence with a shift of its
//! own, by bits: [`SHIFTS`]. However many samples have been taken, those of a square of 2 x 2 or 4 x 4 pixels are a net, too, as those of
//! each pixel are. So nobody needs to know the number of samples in advance.

use std::array::from_fn;
use std::sync::LazyLock;

use fearless_simd::{Simd, f64x8, prelude::*, u32x8};
use lookat_scene::MAX_SAMPLES;

use super::Sample;
use super::hash::{lowbias, mix, of_place, owen_scramble_rev, reversed, units};
use super::orders::{DIMENSIONS, FIRST_SHARED, ORDERS, SHIFTS};
use crate::number::LANES;

/// Bits of an index: 2^16 samples share their scrambles.
const BITS: u32 = 16;
const MASK: u32 = (1 << BITS) - 1;

/// The highest bits of an index, where pixels share scrambles: they tell the pixels apart.
const PIXEL_BITS: u32 = SHIFTS[0].len() as u32;

/// What each bit of a reversed index adds to a reversed point.
type Directions = [u32; BITS as usize];

/// For each dimension as the first of a pair, the directions of both: of pixels that share no scrambles, and of pixels that do.
static DIRECTIONS: LazyLock<[Vec<[Directions; 2]>; 2]> = LazyLock::new(|| {
    let alone: Vec<[Directions; 2]> = ORDERS.iter().map(directions).collect();
    let mut shared = alone.clone();
    for (directions, shifts) in shared[FIRST_SHARED as usize..].iter_mut().zip(&SHIFTS) {
        for (of_pair, directions) in directions.iter_mut().enumerate() {
            for (direction, shift) in directions.iter_mut().zip(shifts.iter().rev()) {
                *direction = shift[of_pair];
            }
        }
    }
    [alone, shared]
});

fn directions(order: &[u16; BITS as usize]) -> [Directions; 2] {
    // The direction numbers of the second dimension are the rows of Pascal's triangle modulo 2 (PBR 8.7).
    let mut second = [1; BITS as usize];
    for bit in 1..second.len() {
        second[bit] = second[bit - 1] ^ second[bit - 1] << 1;
    }
    let first = from_fn(|bit| 1 << bit);
    [first, second].map(|of_bits| {
        from_fn(|reversed_bit| {
            let ordered = order[BITS as usize - 1 - reversed_bit];
            (0..BITS as usize).filter(|bit| ordered >> bit & 1 == 1).fold(0, |sum, bit| sum ^ of_bits[bit])
        })
    })
}

/// With so many samples of a pixel, it shares scrambles with no other one: the sequence goes on for as long.
pub(super) const ALONE: u32 = 1 << BITS;

/// The bits of an index that tell pixels apart. `count`: how many samples a pixel is to have; [`MAX_SAMPLES`] where that is not known.
fn pixel_bits(count: u32) -> u32 {
    if count <= ALONE >> PIXEL_BITS || count == MAX_SAMPLES { PIXEL_BITS } else { 0 }
}

/// The seed that chooses the scrambles of a sample, and the number of the sample among those with the same seed. `count`: how many samples
/// its pixel is to have.
pub(super) fn place((seed, pixel, index): Sample, count: u32) -> (u64, u32) {
    let pixel_bits = pixel_bits(count);
    let bits = BITS - pixel_bits;
    let [x, y] = pixel.map(|at| spread(at.cast_unsigned()));
    let pixel = x | y << 1;
    let seed = of_place(seed, pixel >> pixel_bits);
    // Samples beyond those that can be numbered have other scrambles.
    let seed = if index >> bits == 0 { seed } else { of_place(seed, u64::from(index >> bits)) };
    (seed, ((pixel << bits) as u32 | index & ((1 << bits) - 1)) & MASK)
}

/// The bits of a number with a gap after each.
fn spread(x: u32) -> u64 {
    const STEPS: [(u32, u64); 5] = [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ];
    STEPS.iter().fold(u64::from(x), |x, (shift, mask)| (x | x << shift) & mask)
}

/// The bits of a reversed index that tell pixels apart.
pub(super) fn pixel_mask(count: u32) -> u32 {
    (1 << pixel_bits(count)) - 1
}

/// Points of the sequence, shuffled and to be scrambled: what all dimensions share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shuffled {
    seeds: [u32; LANES],
    /// Those of the pixels.
    own_seeds: [u32; LANES],
    /// In reverse.
    indices: [u32; LANES],
    /// The bits of these that tell pixels apart; none where they share no scrambles.
    pixel_mask: u32,
}

/// True if neighbors share the scrambles of a dimension, so that their errors cancel: for a lens and the first two surfaces. Sharing the
/// dimensions of later surfaces gains less than 2 % in eight scenes. After many choices it does harm: behind eight panes of glass, the means
/// of 8 x 8 pixels had 2.8 times the error of independent samples with all dimensions shared, and have 0.66 times the error with these.
///
/// Nor do they share the place on the film. What the filter makes of an edge rises across one pixel and falls across the next. So samples
/// at complementary places in the two have more noise: 4 to 6 % at 16 samples with a triangle, a gaussian and Mitchell's filter.
fn is_shared(dimension: u32) -> bool {
    (FIRST_SHARED..FIRST_SHARED + SHIFTS.len() as u32).contains(&dimension)
}

impl Shuffled {
    /// `turn`: how many times all dimensions have been taken. `pixel_mask`: the bits of a reversed index that tell pixels apart.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        turn: u32,
        (seeds, indices): ([u64; LANES], [u32; LANES]),
        pixel_mask: u32,
    ) -> Self {
        let seeds: [u32; LANES] = from_fn(|lane| mix(seeds[lane] ^ u64::from(turn)) as u32);
        let wide = u32x8::from_slice(simd, &seeds);
        let scramble = lowbias(wide ^ 0x9fb2_b5a1);
        let reversed = reversed(indices.simd_into(simd)) >> (u32::BITS - BITS);
        let pixels = reversed & pixel_mask;
        // The pixels that share scrambles take their samples in one order.
        let shuffled = owen_scramble_rev((reversed ^ pixels) << (u32::BITS - BITS), scramble);
        let shuffled = shuffled >> (u32::BITS - BITS) ^ pixels;
        let own_seeds = lowbias(wide ^ (pixels * 0x9e37_79b9));
        Shuffled { seeds, own_seeds: own_seeds.to_array(), indices: shuffled.to_array(), pixel_mask }
    }

    /// The numbers of the first or second dimension of a pair.
    #[inline(always)]
    fn numbers<S: Simd>(&self, simd: S, dimension: u32, of_pair: u32) -> f64x8<S> {
        let (seeds, mask) =
            if is_shared(dimension) { (&self.seeds, MASK) } else { (&self.own_seeds, !self.pixel_mask) };
        let seeds = u32x8::from_slice(simd, seeds);
        let indices = u32x8::from_slice(simd, &self.indices) & mask;
        let own = dimension % DIMENSIONS;
        let directions = &DIRECTIONS[usize::from(self.pixel_mask != 0)];
        let mut point: u32x8<S> = 0.simd_into(simd);
        for (bit, direction) in directions[own as usize][of_pair as usize].iter().enumerate() {
            // All bits where this one is set.
            let is_set = u32x8::splat(simd, 0) - (indices >> bit as u32 & 1);
            point ^= is_set & *direction;
        }
        let scramble = lowbias(seeds ^ (own + of_pair + 1).wrapping_mul(0x9e37_79b9));
        units(reversed(owen_scramble_rev(point, scramble)), scramble)
    }

    /// The points as the dimensions of this turn shuffle them.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, dimension: u32, samples: ([u64; LANES], [u32; LANES])) -> Shuffled {
        match dimension / DIMENSIONS {
            0 => *self,
            turn => Shuffled::new(simd, turn, samples, self.pixel_mask),
        }
    }
}

/// The numbers of points in a dimension. `first`: the points as the first dimensions shuffle them.
#[inline(always)]
pub(super) fn numbers<S: Simd>(
    simd: S,
    dimension: u32,
    samples: ([u64; LANES], [u32; LANES]),
    first: &Shuffled,
) -> f64x8<S> {
    first.at(simd, dimension, samples).numbers(simd, dimension, 0)
}

/// The same in a dimension and the next.
#[inline(always)]
pub(super) fn pairs<S: Simd>(
    simd: S,
    dimension: u32,
    samples: ([u64; LANES], [u32; LANES]),
    first: &Shuffled,
) -> [f64x8<S>; 2] {
    let points = first.at(simd, dimension, samples);
    [0, 1].map(|of_pair| points.numbers(simd, dimension, of_pair))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::testing::baseline;

    /// The pairs of some dimensions, of so many samples of a pixel.
    fn points(pixel: [i32; 2], dimension: u32, count: u32) -> Vec<[f64; 2]> {
        let of = |index| {
            let (seed, index) = place((7, pixel, index), count);
            let samples = ([seed; LANES], [index; LANES]);
            baseline!(simd => {
                let first = Shuffled::new(simd, 0, samples, pixel_mask(count));
                pairs(simd, dimension, samples, &first).map(|x| x[3])
            })
        };
        (0..count).map(of).collect()
    }

    /// How many of the intervals with these counts of halvings along each number hold a point.
    fn filled<const N: usize>(points: &[[f64; N]], halvings: [u32; N]) -> usize {
        let cell = |point: &[f64; N]| -> [u32; N] {
            from_fn(|at| (point[at] * f64::from(1_u32 << halvings[at])) as u32)
        };
        points.iter().map(cell).collect::<BTreeSet<_>>().len()
    }

    /// So all pairs are (0, 2)-sequences.
    #[test]
    fn orders_are_upper_triangular() {
        for order in &ORDERS {
            assert!(order.iter().enumerate().all(|(bit, column)| column >> bit == 1), "{order:?}");
        }
    }

    #[test]
    fn all_pairs_are_nets_in_each_pixel() {
        for dimension in (0..2 * DIMENSIONS).step_by(3) {
            for bits in 0..8 {
                let points = points([3, 8], dimension, 1 << bits);
                for across in 0..=bits {
                    let filled = filled(&points, [across, bits - across]);
                    assert_eq!(filled, points.len(), "{dimension}: {bits} {across}");
                }
            }
        }
    }

    /// A prefix of the samples is as good as so many: samples are taken in passes.
    #[test]
    fn pairs_are_sequences() {
        for (dimension, bits) in [(0, 4), (5, 6), (31, 5)] {
            let points = points([2, 1], dimension, 200);
            for points in points.chunks_exact(1 << bits) {
                for across in 0..=bits {
                    assert_eq!(filled(points, [across, bits - across]), points.len(), "{dimension}");
                }
            }
        }
    }

    /// However many samples there are so far, those of aligned squares of pixels are nets, too; not their places on the film.
    #[test]
    fn squares_of_pixels_are_nets() {
        let of_square = |dimension, pixels: u32, bits: u32| -> Vec<[f64; 2]> {
            let side = pixels.isqrt() as i32;
            let pixels = (0..side * side).map(|at| [-4 + at % side, 8 + at / side]);
            pixels.flat_map(|pixel| points(pixel, dimension, 1 << bits)).collect()
        };
        for dimension in [2, 5, 9, 12] {
            for (pixels, bits) in (0..6).flat_map(|bits| [(4, bits), (16, bits)]) {
                let points = of_square(dimension, pixels, bits);
                let halvings = points.len().ilog2();
                for across in 0..=halvings {
                    let filled = filled(&points, [across, halvings - across]);
                    assert_eq!(filled, points.len(), "{dimension}: {pixels} {bits} {across}");
                }
            }
        }
        for dimension in [0, 14, 40] {
            assert!(filled(&of_square(dimension, 16, 4), [4, 4]) < 200, "{dimension}");
        }
    }

    /// So a picture that ends with the time has the samples of one with as many.
    #[test]
    fn samples_do_not_depend_on_their_number() {
        let sample = |index| (7, [5, -3], index);
        for count in [1, 3, 64, 4096] {
            for index in [0, count / 2, count - 1] {
                assert_eq!(place(sample(index), count), place(sample(index), MAX_SAMPLES));
            }
            assert_eq!(pixel_mask(count), pixel_mask(MAX_SAMPLES));
        }
        assert_eq!(pixel_mask(ALONE), 0);
    }

    /// A filter weighs samples by their places on the film. So that what it weighs stays even, places and each pair are even together: of
    /// the intervals in four dimensions that could hold one sample each, more do than with the places of another pixel.
    #[test]
    fn pairs_and_places_on_the_film_are_even_together() {
        for bits in [4, 6, 8] {
            let shares = [[1, 1], [700, 1]].map(|pixel| {
                let film = points(pixel, 0, 1 << bits);
                let (mut intervals, mut full) = (0, 0);
                for dimension in 2..12 {
                    let pairs = points([1, 1], dimension, 1 << bits);
                    let joined: Vec<[f64; 4]> =
                        film.iter().zip(pairs).map(|([x, y], [u, v])| [*x, *y, u, v]).collect();
                    for i in 0..=bits {
                        for j in 0..=bits - i {
                            for k in 0..=bits - i - j {
                                intervals += joined.len();
                                full += filled(&joined, [i, j, k, bits - i - j - k]);
                            }
                        }
                    }
                }
                full as f64 / intervals as f64
            });
            assert!(shares[0] > shares[1] + 0.03, "2^{bits}: {shares:?}");
        }
    }
}
