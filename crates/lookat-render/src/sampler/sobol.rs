//! Sobol' points, scrambled after Owen.
//!
//! Each pair of dimensions takes the first two dimensions of the sequence, a (0, 2)-sequence, in an order of its own: [`ORDERS`]. So no
//! pair leaves gaps, however few samples there are, and a pair and the position on the film lie well in four dimensions.
//!
//! The pixels of aligned squares of 4 x 4 share scrambles, so that the errors of neighbors cancel. Each takes the sequence with a shift of its
//! own, by bits: [`SHIFTS`]. However many samples have been taken, those of a square of 2 x 2 or 4 x 4 pixels are a net, too, as those of
//! each pixel are. So nobody needs to know the number of samples in advance.

use std::array::from_fn;
use std::sync::LazyLock;

use fearless_simd::{Simd, f64x8, prelude::*, u32x8};
use lookat_scene::MAX_SAMPLES;

use super::{Sample, lowbias, mix, of_position, owen_scramble_rev, reversed, units};
use crate::number::LANES;

/// Bits of an index: 2^16 samples share their scrambles.
const BITS: u32 = 16;
const MASK: u32 = (1 << BITS) - 1;

/// The highest bits of an index, where pixels share scrambles: they tell the pixels apart.
const PIXEL_BITS: u32 = SHIFTS[0].len() as u32;

/// The bits that each bit of a reversed index adds to a reversed point.
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

/// The bits of an index that tell the pixels with one seed apart; none where each has a seed of its own. `count`: how many samples a pixel is
/// to have, [`MAX_SAMPLES`] where that is not known.
pub(super) fn pixel_bits(count: u32) -> u32 {
    if count <= ALONE >> PIXEL_BITS || count == MAX_SAMPLES { PIXEL_BITS } else { 0 }
}

/// The seed that chooses the scrambles of a sample, and the number of the sample among those with the same seed.
pub(super) fn sequence(Sample { seed, pixel, index }: Sample, pixel_bits: u32) -> (u64, u32) {
    let bits = BITS - pixel_bits;
    let [x, y] = pixel.map(|at| spread(at.cast_unsigned()));
    let pixel = x | y << 1;
    let seed = of_position(seed, pixel >> pixel_bits);
    // Samples beyond those that can be numbered have other scrambles.
    let seed = if index >> bits == 0 { seed } else { of_position(seed, u64::from(index >> bits)) };
    (seed, ((pixel << bits) as u32 | index & ((1 << bits) - 1)) & MASK)
}

/// True if two samples of a pixel have one seed: with any sampler, their numbers differ by the bits that their indices differ by.
pub(super) fn is_beside(one: Sample, other: Sample, pixel_bits: u32) -> bool {
    let is_same = (one.seed, one.pixel) == (other.seed, other.pixel);
    is_same && (one.index ^ other.index) >> (BITS - pixel_bits) == 0
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

/// Points of the sequence, shuffled and to be scrambled: what all dimensions share.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shuffled {
    seeds: [u32; LANES],
    /// The seeds of the pixels.
    own_seeds: [u32; LANES],
    /// The indices with reversed bits.
    indices: [u32; LANES],
    /// The bits of these that tell pixels apart; none where they share no scrambles.
    pixel_mask: u32,
}

/// True if neighbors share the scrambles of a dimension, so that their errors cancel: for a lens and the first two surfaces. Sharing the
/// dimensions of later surfaces gains less than 2 % in eight scenes. After many choices it does harm: behind eight panes of glass, the means
/// of 8 x 8 pixels had 2.8 times the error of independent samples with all dimensions shared, and have 0.66 times the error with these.
///
/// Nor do they share the position on the film. What the filter makes of an edge rises across one pixel and falls across the next. So samples
/// at complementary positions in the two have more noise: 4 to 6 % at 16 samples with a triangle, a gaussian and Mitchell's filter.
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

/// The points in a dimension and the next.
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

/// Dimensions with an order of their own.
pub(super) const DIMENSIONS: u32 = ORDERS.len() as u32;

/// For each dimension that pixels share, from [`FIRST_SHARED`] on, as the first of a pair: what each bit of a pixel's place in its square, in
/// Morton order, adds to both numbers, modulo 2, from their first digit on.
///
/// For the first 2 or 4 of these bits, and any power of two of samples up to 2^12, the points fill all elementary intervals. A search, digit
/// by digit, found 576 such shifts; the pixels that only one or three bits tell apart fill most. Of these, each dimension takes the
/// shift with which the points of a square and those of the dimensions before leave the fewest gaps in four dimensions.
#[rustfmt::skip]
pub(super) static SHIFTS: [[[u32; 2]; 4]; 12] = [
    [[31597, 44470], [5851, 22235], [17684, 46161], [41610, 37839]],
    [[46811, 22235], [28086, 31597], [15603, 35368], [7801, 39399]],
    [[60854, 39789], [5851, 30427], [41610, 46031], [15993, 14823]],
    [[14043, 5851], [39789, 28086], [10142, 59294], [57994, 21455]],
    [[28086, 23405], [31597, 60854], [46161, 17684], [35368, 15603]],
    [[28086, 39789], [7021, 11702], [8842, 62415], [37189, 4421]],
    [[60854, 56173], [46811, 30427], [26526, 10142], [63975, 40569]],
    [[60854, 39789], [39789, 60854], [53052, 10402], [26526, 26526]],
    [[31597, 44470], [5851, 22235], [17684, 46161], [41610, 37839]],
    [[60854, 39789], [5851, 63195], [23015, 24185], [10402, 20284]],
    [[60854, 39789], [39789, 60854], [53052, 10402], [26526, 26526]],
    [[60854, 39789], [5851, 63195], [23015, 24185], [10402, 20284]],
];

/// The first of the shared dimensions.
pub(super) const FIRST_SHARED: u32 = 2;

/// For each dimension as the first of a pair, what each bit of an index adds to the index of the point that is taken, modulo 2: an upper
/// triangular matrix, one column after the other. Any such matrix keeps a (0, 2)-sequence one (Faure and Tezuka, "Another Random
/// Scrambling of Digital (t, s)-Sequences", 2002).
///
/// Found by a search, column by column, with 40 candidates kept: in the mean over 4 to 4,096 samples, the points that share an elementary
/// interval in four dimensions with another one are few, for the pair with the position on the film (which counts three times) and with each
/// pair found before whose dimension is at most seven away. The search began with the pairs of a light and of a lens.
#[rustfmt::skip]
pub(super) static ORDERS: [[u16; 16]; 64] = [
    [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768],
    [1, 3, 4, 13, 24, 60, 91, 215, 337, 728, 1458, 2524, 5276, 11390, 30312, 45573],
    [1, 2, 5, 11, 23, 52, 74, 163, 356, 746, 1919, 4048, 4382, 14131, 18454, 61600],
    [1, 3, 6, 8, 31, 37, 105, 244, 346, 934, 1657, 3596, 7138, 9098, 23685, 48764],
    [1, 3, 4, 10, 23, 36, 70, 167, 318, 595, 1689, 3034, 7451, 11203, 19281, 55599],
    [1, 3, 4, 13, 17, 50, 87, 219, 386, 895, 1385, 2660, 7217, 14209, 31176, 61831],
    [1, 3, 7, 11, 26, 61, 83, 216, 309, 671, 1082, 2724, 7678, 10812, 22882, 60219],
    [1, 2, 4, 15, 22, 35, 65, 196, 368, 622, 1483, 2273, 5227, 14791, 30771, 54084],
    [1, 2, 6, 10, 23, 56, 65, 253, 362, 676, 1449, 2090, 4547, 10963, 22678, 45546],
    [1, 2, 5, 13, 24, 46, 79, 188, 390, 1001, 1891, 2769, 7806, 8902, 16878, 62583],
    [1, 2, 5, 11, 23, 52, 74, 184, 351, 949, 1956, 3765, 4568, 10765, 23010, 64196],
    [1, 2, 6, 15, 25, 55, 120, 205, 334, 676, 1063, 2961, 8189, 13740, 22934, 57302],
    [1, 2, 5, 12, 22, 40, 123, 143, 356, 822, 1486, 3183, 7940, 11140, 30330, 54213],
    [1, 3, 4, 13, 17, 50, 87, 219, 384, 749, 1117, 3903, 7889, 10080, 21690, 58366],
    [1, 2, 7, 13, 29, 41, 70, 142, 295, 517, 1726, 2512, 4775, 12440, 22843, 48359],
    [1, 2, 4, 15, 22, 35, 65, 158, 474, 708, 1639, 3809, 6731, 11134, 16401, 59565],
    [1, 2, 7, 12, 27, 45, 84, 210, 342, 1018, 1845, 3071, 6837, 14019, 23873, 34755],
    [1, 2, 5, 13, 24, 46, 103, 208, 313, 891, 1432, 3766, 6835, 15570, 23028, 55331],
    [1, 2, 5, 11, 23, 52, 74, 226, 415, 557, 2039, 2676, 7540, 10930, 16781, 34848],
    [1, 2, 6, 15, 25, 55, 120, 181, 502, 574, 1874, 2383, 6676, 13625, 29998, 35321],
    [1, 2, 6, 15, 22, 40, 77, 161, 447, 630, 1941, 3548, 6058, 11286, 19691, 32789],
    [1, 2, 5, 11, 16, 33, 67, 193, 293, 947, 1196, 2477, 6106, 14182, 23299, 56162],
    [1, 2, 7, 13, 29, 41, 70, 165, 427, 716, 1953, 3052, 6605, 13302, 23416, 36207],
    [1, 2, 4, 15, 22, 35, 65, 206, 450, 708, 1757, 3514, 7568, 13885, 22253, 42837],
    [1, 3, 7, 10, 28, 56, 95, 168, 338, 585, 1244, 3683, 4832, 9546, 22056, 48547],
    [1, 3, 4, 11, 30, 58, 97, 147, 332, 736, 1958, 2495, 8085, 13329, 20099, 43214],
    [1, 3, 4, 13, 22, 39, 89, 154, 439, 635, 1640, 2376, 4353, 8208, 21467, 33888],
    [1, 2, 6, 11, 25, 43, 92, 141, 258, 650, 1284, 3406, 4390, 12231, 17254, 60262],
    [1, 2, 6, 15, 22, 40, 77, 217, 447, 966, 1547, 3132, 6627, 9157, 20577, 64129],
    [1, 3, 4, 13, 17, 50, 87, 239, 310, 742, 1130, 2781, 4602, 16187, 26768, 43555],
    [1, 2, 7, 13, 29, 41, 70, 165, 467, 695, 1548, 4071, 5682, 11545, 28994, 62529],
    [1, 2, 7, 12, 28, 35, 126, 128, 407, 1016, 1772, 2061, 4306, 13851, 31515, 47435],
    [1, 2, 5, 12, 23, 47, 86, 191, 441, 759, 1714, 2548, 6197, 10777, 22760, 33892],
    [1, 3, 6, 9, 16, 52, 69, 183, 327, 895, 1548, 3160, 7463, 8455, 17949, 34733],
    [1, 2, 5, 11, 23, 52, 74, 207, 415, 693, 1402, 2501, 6339, 8950, 28208, 45965],
    [1, 2, 5, 11, 16, 33, 105, 142, 358, 650, 1503, 3220, 4152, 8303, 19341, 37497],
    [1, 2, 6, 15, 22, 40, 77, 157, 455, 707, 1762, 3197, 5650, 10054, 27791, 42111],
    [1, 3, 4, 13, 17, 50, 87, 191, 406, 634, 1408, 2704, 5231, 11549, 19331, 56411],
    [1, 2, 7, 13, 29, 41, 70, 165, 371, 613, 1325, 4018, 4981, 14927, 21153, 51948],
    [1, 2, 7, 12, 16, 35, 86, 242, 435, 625, 1471, 3970, 6640, 10193, 23034, 34520],
    [1, 2, 5, 12, 23, 47, 86, 229, 443, 880, 1517, 3127, 6690, 10811, 20024, 50888],
    [1, 3, 6, 9, 16, 52, 121, 183, 395, 760, 1213, 3584, 5120, 13933, 21422, 37441],
    [1, 3, 4, 13, 22, 39, 89, 242, 439, 618, 1295, 3248, 4717, 12713, 29617, 34020],
    [1, 3, 4, 13, 17, 50, 104, 246, 328, 1009, 1759, 3235, 6683, 8293, 27323, 45057],
    [1, 3, 6, 8, 23, 48, 98, 211, 388, 589, 1037, 3146, 7465, 10762, 32719, 63267],
    [1, 3, 4, 13, 17, 50, 87, 251, 335, 1008, 1870, 3212, 7430, 9295, 31278, 50367],
    [1, 2, 7, 13, 29, 41, 70, 228, 287, 878, 1280, 2613, 5919, 10813, 20455, 44154],
    [1, 2, 7, 12, 28, 35, 126, 242, 363, 565, 1898, 3493, 5323, 14369, 29142, 59527],
    [1, 3, 4, 10, 22, 59, 66, 157, 265, 750, 1295, 4083, 4323, 10156, 19004, 37762],
    [1, 3, 6, 15, 16, 52, 115, 184, 398, 946, 1537, 3649, 5691, 12784, 17654, 37002],
    [1, 3, 4, 13, 22, 39, 89, 248, 367, 820, 1577, 3143, 6134, 14816, 32588, 39866],
    [1, 3, 4, 13, 17, 50, 104, 129, 422, 586, 1309, 3838, 6782, 13227, 30014, 57619],
    [1, 3, 6, 8, 23, 48, 98, 211, 388, 638, 1037, 3092, 4233, 8228, 26323, 53018],
    [1, 2, 6, 11, 25, 51, 124, 232, 356, 817, 1927, 3527, 5195, 12354, 16554, 46553],
    [1, 2, 7, 13, 29, 41, 70, 142, 295, 685, 1917, 3290, 6651, 8724, 29544, 55316],
    [1, 3, 7, 10, 27, 49, 126, 139, 422, 918, 1773, 3299, 5247, 16287, 27993, 52852],
    [1, 2, 5, 12, 23, 47, 86, 234, 351, 768, 1090, 3187, 4840, 13905, 31365, 41801],
    [1, 2, 6, 8, 17, 39, 117, 226, 500, 581, 1241, 3781, 4213, 8443, 32600, 50047],
    [1, 2, 5, 11, 23, 52, 74, 215, 465, 907, 1336, 3904, 8012, 8208, 17419, 59400],
    [1, 2, 5, 11, 16, 33, 105, 198, 459, 861, 1382, 3449, 4652, 13064, 17375, 50919],
    [1, 3, 6, 8, 23, 48, 98, 241, 388, 947, 1530, 3514, 4331, 11475, 27041, 42930],
    [1, 2, 6, 11, 25, 43, 124, 184, 308, 737, 2023, 4087, 7856, 10860, 18174, 34499],
    [1, 2, 7, 13, 29, 41, 70, 175, 459, 869, 1044, 2508, 5510, 9373, 23885, 65228],
    [1, 2, 7, 12, 28, 35, 126, 188, 463, 1018, 1398, 3337, 7581, 11851, 24274, 46892],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;
    use std::collections::BTreeSet;

    /// The pairs of some dimensions, of so many samples of a pixel.
    fn points(pixel: [i32; 2], dimension: u32, count: u32) -> Vec<[f64; 2]> {
        let of = |index| {
            let (seed, index) = sequence(Sample { seed: 7, pixel, index }, pixel_bits(count));
            let samples = ([seed; LANES], [index; LANES]);
            baseline!(simd => {
                let first = Shuffled::new(simd, 0, samples, (1 << pixel_bits(count)) - 1);
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

    /// However many samples there are so far, those of aligned squares of pixels are nets, too; not their positions on the film.
    #[test]
    fn squares_of_pixels_are_nets() {
        let of_square = |dimension, pixels: u32, bits: u32| -> Vec<[f64; 2]> {
            let side = pixels.isqrt() as i32;
            let pixels = (0..side * side).map(|at| [-4 + at % side, 8 + at / side]);
            pixels.flat_map(|pixel| points(pixel, dimension, 1 << bits)).collect()
        };
        for dimension in FIRST_SHARED..FIRST_SHARED + SHIFTS.len() as u32 {
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
        for count in [1, 3, 64, 4096] {
            assert_eq!(pixel_bits(count), pixel_bits(MAX_SAMPLES));
        }
        assert_eq!(pixel_bits(ALONE), 0);
    }

    /// A filter weighs samples by their positions on the film. So that what it weighs stays even, positions and each pair are even together: of
    /// the intervals in four dimensions that could hold one sample each, more do than with the positions of another pixel.
    #[test]
    fn pairs_and_positions_on_the_film_are_even_together() {
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
