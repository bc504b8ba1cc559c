//! How heavy the tail of differences is: whether a few pixels make up most of their sum.

/// Below this tail index, the variance of the values is infinite: their standard error says nothing of their mean.
pub const FINITE_VARIANCE: f64 = 2.0;

/// The tail index of distances from 0: they are larger than x with a probability that falls as x to the power of minus this. That of
/// Hill, "A Simple General Approach to Inference About the Tail of a Distribution", 1975, over as many values as Vehtari et al.,
/// "Pareto Smoothed Importance Sampling", 2024, take for the tail. Infinite for equal values; 0 if less than those differ from 0.
pub(super) fn tail_index(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.map(f64::abs).collect();
    let count = values.len() as f64;
    let tail = (0.2 * count).min(3.0 * count.sqrt()).ceil() as usize;
    if tail >= values.len() {
        return f64::INFINITY;
    }
    values.select_nth_unstable_by(tail, |a, b| b.total_cmp(a));
    let threshold = values[tail];
    // Equal values may all be 0.
    let above = values[..tail].iter().filter(|value| **value > threshold);
    tail as f64 / above.fold(0.0, |sum, value| sum + (value / threshold).ln())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_of_a_power_is_found() {
        for (index, within) in [(0.5, 0.1), (1.5, 0.3), (3.0, 0.6)] {
            let quantile = |i: u32| (-1_f64).powi(i as i32) * ((f64::from(i) + 0.5) / 1e4).powf(-1.0 / index);
            let found = tail_index((0..10_000).map(quantile));
            assert!((found - index).abs() < within, "{found}, not {index}");
        }
        assert_eq!(tail_index(std::iter::repeat_n(-0.5, 256)), f64::INFINITY);
        assert_eq!(tail_index(std::iter::repeat_n(0.0, 256)), f64::INFINITY);
        assert_eq!(tail_index((0..256).map(|i| if i < 10 { 1.0 } else { 0.0 })), 0.0);
        assert_eq!(tail_index([1.0].into_iter()), f64::INFINITY);
    }
}
