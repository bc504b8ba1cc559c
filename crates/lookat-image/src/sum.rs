//! Sums over all pixels of two pictures of the same size, on all threads. They are added in one order, whatever
//! the number of threads.

use rayon::prelude::*;

/// The pixels that are worked on at a time.
pub(crate) const GRAIN: usize = 1 << 14;

/// Corresponding parts of two pictures.
pub(crate) fn blocks<'a>(
    actual: &'a [[f32; 3]],
    expected: &'a [[f32; 3]],
) -> impl IndexedParallelIterator<Item = (&'a [[f32; 3]], &'a [[f32; 3]])> {
    assert_eq!(actual.len(), expected.len());
    actual.par_chunks(GRAIN).zip(expected.par_chunks(GRAIN))
}

/// Sums of some terms over all pixels.
pub(crate) fn pixel_sums<const N: usize>(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    terms: impl Fn(&[f32; 3], &[f32; 3]) -> [f64; N] + Sync,
) -> [f64; N] {
    total(blocks(actual, expected).map(|(actual, expected)| lane_sums(actual, expected, &terms)))
}

/// Sums of some terms over all channels of all pixels.
pub(crate) fn sample_sums<const N: usize>(
    actual: &[[f32; 3]],
    expected: &[[f32; 3]],
    terms: impl Fn(f32, f32) -> [f64; N] + Sync,
) -> [f64; N] {
    total(blocks(actual, expected).map(|(actual, expected)| {
        lane_sums(actual.as_flattened(), expected.as_flattened(), |&a, &b| terms(a, b))
    }))
}

/// The sum over blocks, in their order.
fn total<const N: usize>(blocks: impl IndexedParallelIterator<Item = [f64; N]>) -> [f64; N] {
    blocks
        .collect::<Vec<_>>()
        .into_iter()
        .fold([0.0; N], |sum, block| std::array::from_fn(|i| sum[i] + block[i]))
}

/// Sums of some terms over pairs. Eight sums of each term, which do not wait for each other.
fn lane_sums<T, const N: usize>(
    actual: &[T],
    expected: &[T],
    terms: impl Fn(&T, &T) -> [f64; N],
) -> [f64; N] {
    const LANES: usize = 8;
    let mut lanes = [[0.0; LANES]; N];
    let mut add = |lane: usize, a: &T, b: &T| {
        for (lanes, term) in lanes.iter_mut().zip(terms(a, b)) {
            lanes[lane] += term;
        }
    };
    let ((a_chunks, a_rest), (b_chunks, b_rest)) =
        (actual.as_chunks::<LANES>(), expected.as_chunks::<LANES>());
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            add(lane, &a[lane], &b[lane]);
        }
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        add(0, a, b);
    }
    lanes.map(|lanes| lanes.iter().sum())
}
