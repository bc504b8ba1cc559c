//! Weighted sums along rows and columns of a plane: the two halves of a separable filter.

use std::ops::{Add, Mul};

/// `f32` where speed counts, `f64` where differences of large sums are taken.
pub(crate) trait Number: Copy + Default + Add<Output = Self> + Mul<Output = Self> {}
impl Number for f32 {}
impl Number for f64 {}

/// Filters each row of a plane with `width` columns. What comes out has `margin` fewer columns on both sides.
/// The number of weights is odd and at most 2 * `margin` + 1; the middle one is for the pixel itself.
pub(crate) fn along_rows<T: Number>(plane: &[T], width: usize, margin: usize, weights: &[T]) -> Vec<T> {
    let narrow = width - 2 * margin;
    let first = margin - weights.len() / 2;
    let mut out = vec![T::default(); plane.len() / width * narrow];
    for (row, out) in plane.chunks_exact(width).zip(out.chunks_exact_mut(narrow)) {
        weigh(weights, |k| &row[first + k..][..narrow], out);
    }
    out
}

/// Filters each column of a plane with `width` columns. What comes out has `margin` fewer rows above and
/// below. The weights are as in [`along_rows`].
pub(crate) fn down_columns<T: Number>(plane: &[T], width: usize, margin: usize, weights: &[T]) -> Vec<T> {
    let first = margin - weights.len() / 2;
    let mut out = vec![T::default(); plane.len() - 2 * margin * width];
    for (y, out) in out.chunks_exact_mut(width).enumerate() {
        weigh(weights, |k| &plane[(y + first + k) * width..][..width], out);
    }
    out
}

/// `out` = sum of `weights[k] * rows(k)`; each of the rows is as long as `out`. Sixteen sums at a time stay in
/// registers.
fn weigh<'a, T: Number + 'a>(weights: &[T], rows: impl Fn(usize) -> &'a [T], out: &mut [T]) {
    const LANES: usize = 16;
    let whole = out.len() - out.len() % LANES;
    for start in (0..whole).step_by(LANES) {
        let mut sums = [T::default(); LANES];
        for (k, &weight) in weights.iter().enumerate() {
            for (sum, &value) in sums.iter_mut().zip(&rows(k)[start..start + LANES]) {
                *sum = *sum + weight * value;
            }
        }
        out[start..start + LANES].copy_from_slice(&sums);
    }
    for (x, out) in out.iter_mut().enumerate().skip(whole) {
        *out = weights.iter().enumerate().fold(T::default(), |sum, (k, &weight)| sum + weight * rows(k)[x]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighs_neighbors() {
        // Five rows of 21 columns, more than sixteen inside the margin; each number tells its place.
        let plane: Vec<f64> = (0..5 * 21).map(|i| f64::from(i % 21 + 100 * (i / 21))).collect();
        let rows = along_rows(&plane, 21, 2, &[1.0, 0.0, 10.0]);
        assert_eq!(rows.len(), 5 * 17);
        for (i, &value) in rows.iter().enumerate() {
            let at = |x: usize| plane[i / 17 * 21 + i % 17 + x];
            assert_eq!(value, at(1) + 10.0 * at(3), "{i}");
        }

        let columns = down_columns(&plane, 21, 1, &[1.0, 0.0, 10.0]);
        assert_eq!(columns.len(), 3 * 21);
        for (i, &value) in columns.iter().enumerate() {
            assert_eq!(value, plane[i] + 10.0 * plane[i + 42], "{i}");
        }
        assert_eq!(down_columns(&plane, 21, 2, &[1.0]), plane[42..63]);
    }
}
