//! Pixel filters: how much each sample counts for the pixels around it (PBR 7.8 and 7.9).

use glam::{DVec2, DVec4};
use lookat_scene::{Filter, FilterKind};

/// The weights of a sample for the pixels whose filter reaches it.
#[derive(Debug, Clone)]
pub(crate) struct PixelFilter {
    axes: [Axis; 2],
}

impl PixelFilter {
    pub fn new(filter: &Filter) -> Self {
        PixelFilter { axes: filter.radius.to_array().map(|radius| Axis::new(filter.kind, radius)) }
    }

    /// How many pixels away, across and down, a sample still counts.
    pub fn reach(&self) -> [u32; 2] {
        [0, 1].map(|axis| self.axes[axis].reach)
    }

    /// The number of pixels that a sample may count for.
    pub fn cells(&self) -> usize {
        self.reach().iter().map(|reach| 2 * *reach as usize + 1).product()
    }

    /// Adds a sample to the sums of the pixels around, row by row. `place`: where it is in the unit square of its pixel. `sample`: red,
    /// green, blue, and a weight of 1.
    #[inline(always)]
    pub fn add(&self, place: DVec2, sample: DVec4, weights: &mut [Vec<f64>; 2], sums: &mut [DVec4]) {
        if let ([sum], FilterKind::Box) = (&mut *sums, self.axes[0].kind) {
            *sum += sample * (self.axes[0].own(place.x) * self.axes[1].own(place.y));
            return;
        }
        self.weigh(place, weights);
        let [across, down] = &*weights;
        for (row, down) in sums.chunks_exact_mut(across.len()).zip(down) {
            let sample = sample * *down;
            row.iter_mut().zip(across).for_each(|(sum, across)| *sum += sample * *across);
        }
    }

    /// The weights of a sample for the pixels around, across and down.
    #[inline(always)]
    pub fn weigh(&self, place: DVec2, weights: &mut [Vec<f64>; 2]) {
        for (axis, weights) in weights.iter_mut().enumerate() {
            self.axes[axis].weigh(place[axis], weights);
        }
    }

    /// The weight of the unit squares of the pixels around, each evenly filled with samples.
    pub fn of_squares(&self) -> [Vec<f64>; 2] {
        const STEPS: usize = 64;
        let mean = |axis: &Axis| {
            let mut sums = vec![0.0; 2 * axis.reach as usize + 1];
            let mut weights = Vec::new();
            for step in 0..STEPS {
                axis.weigh((step as f64 + 0.5) / STEPS as f64, &mut weights);
                sums.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum += weight / STEPS as f64);
            }
            sums
        };
        [mean(&self.axes[0]), mean(&self.axes[1])]
    }
}

/// The filter along one axis.
#[derive(Debug, Clone)]
struct Axis {
    kind: FilterKind,
    radius: f64,
    reach: u32,
    /// Makes the largest weight, and the sum of the weights of a sample, about 1 at most.
    scale: f64,
}

impl Axis {
    fn new(kind: FilterKind, radius: f64) -> Self {
        const STEPS: u32 = 1 << 14;
        let values = (0..STEPS)
            .map(|step| evaluate(kind, radius, (f64::from(step) + 0.5) / f64::from(STEPS) * radius).abs());
        let (sum, most) = values.fold((0.0, 0.0_f64), |(sum, most), value| (sum + value, most.max(value)));
        let integral = 2.0 * radius * sum / f64::from(STEPS);
        Axis { kind, radius, reach: (radius - 0.5).ceil().max(0.0) as u32, scale: integral.max(most).recip() }
    }

    /// The weight for the pixel that a sample lies in.
    #[inline(always)]
    fn own(&self, place: f64) -> f64 {
        evaluate(self.kind, self.radius, 0.5 - place) * self.scale
    }

    /// The weights of a sample for the pixels from `reach` before its own on.
    #[inline(always)]
    fn weigh(&self, place: f64, weights: &mut Vec<f64>) {
        let reach = f64::from(self.reach);
        weights.clear();
        weights.extend((0..=2 * self.reach).map(|k| {
            let x = f64::from(k) - reach + 0.5 - place;
            evaluate(self.kind, self.radius, x) * self.scale
        }));
    }
}

/// The filters of pbrt-v3 along one axis (PBR 7.8), up to a constant factor.
#[inline(always)]
fn evaluate(kind: FilterKind, radius: f64, x: f64) -> f64 {
    match kind {
        FilterKind::Box => f64::from(-radius <= x && x < radius),
        FilterKind::Triangle => (radius - x.abs()).max(0.0),
        FilterKind::Gaussian { alpha } => {
            (libm::exp(-alpha * x * x) - libm::exp(-alpha * radius * radius)).max(0.0)
        }
        FilterKind::Mitchell { b, c } => mitchell(b, c, (2.0 * x / radius).abs()),
        FilterKind::Sinc { tau } if x.abs() <= radius => sinc(x) * sinc(x / tau),
        FilterKind::Sinc { .. } => 0.0,
    }
}

#[inline(always)]
fn mitchell(b: f64, c: f64, x: f64) -> f64 {
    if x >= 2.0 {
        return 0.0;
    }
    if x > 1.0 {
        return (((-b - 6.0 * c) * x + 6.0 * b + 30.0 * c) * x - 12.0 * b - 48.0 * c) * x
            + 8.0 * b
            + 24.0 * c;
    }
    ((12.0 - 9.0 * b - 6.0 * c) * x - 18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0 - 2.0 * b
}

fn sinc(x: f64) -> f64 {
    let x = std::f64::consts::PI * x.abs();
    if x < 1e-5 { 1.0 } else { libm::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    const THIRD: f64 = 1.0 / 3.0;

    type Function = fn(f64) -> f64;

    /// All filters with their radii, and the function that pbrt-v3 evaluates, by the distance.
    fn all() -> [(Filter, Function); 5] {
        let of = |kind, x, y| Filter { radius: DVec2::new(x, y), kind };
        [
            (of(FilterKind::Box, 0.5, 1.5), |x| f64::from(x < 1.5)),
            (of(FilterKind::Triangle, 2.0, 1.25), |x| (1.25 - x).max(0.0)),
            (of(FilterKind::Gaussian { alpha: 2.0 }, 2.0, 1.5), |x| {
                ((-2.0 * x * x).exp() - (-4.5_f64).exp()).max(0.0)
            }),
            (of(FilterKind::Mitchell { b: THIRD, c: THIRD }, 2.0, 2.0), |x| match x {
                x if x < 1.0 => (7.0 * x.powi(3) - 12.0 * x * x + 16.0 / 3.0) / 6.0,
                x if x < 2.0 => (-7.0 / 3.0 * x.powi(3) + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0,
                _ => 0.0,
            }),
            (of(FilterKind::Sinc { tau: 3.0 }, 4.0, 4.0), |x| {
                let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
                if x <= 4.0 {
                    sinc(std::f64::consts::PI * x) * sinc(std::f64::consts::PI * x / 3.0)
                } else {
                    0.0
                }
            }),
        ]
    }

    /// A sample counts for each pixel by the distance of its middle.
    #[test]
    fn weights_are_those_of_the_function() {
        for (filter, function) in all() {
            let own = PixelFilter::new(&filter);
            let mut weights = Default::default();
            let mut factor = None;
            for step in 0..100 {
                let place = DVec2::splat((f64::from(step) + 0.37) / 100.0);
                own.weigh(place, &mut weights);
                let reach = own.reach()[1] as i32;
                assert_eq!(weights[1].len(), 2 * reach as usize + 1);
                // Nothing beyond has a weight.
                for pixel in [-reach - 1, reach + 1] {
                    assert_eq!(function((f64::from(pixel) + 0.5 - place.y).abs()), 0.0, "{filter:?}");
                }
                for (pixel, weight) in (-reach..=reach).zip(&weights[1]) {
                    let expected = function((f64::from(pixel) + 0.5 - place.y).abs());
                    if expected.abs() < 1e-3 {
                        assert!(weight.abs() < 1e-2, "{filter:?}");
                        continue;
                    }
                    let factor = *factor.get_or_insert(weight / expected);
                    assert!((weight / expected / factor - 1.0).abs() < 1e-9, "{filter:?} {place} {pixel}");
                }
            }
        }
    }

    /// Sums over many samples of a source equal those of each sample, written out.
    #[test]
    fn sums_are_products_of_both_axes() {
        for (filter, _) in all() {
            let filter = PixelFilter::new(&filter);
            let (mut weights, mut sums) = (Default::default(), vec![DVec4::ZERO; filter.cells()]);
            let mut expected = vec![DVec4::ZERO; filter.cells()];
            for step in 0..10 {
                let place = DVec2::new(f64::from(step) * 0.1, f64::from(step * 7 % 10) * 0.1);
                let sample = DVec4::new(f64::from(step), 2.0, -1.0, 1.0);
                filter.add(place, sample, &mut weights, &mut sums);
                filter.weigh(place, &mut weights);
                let products = weights[1].iter().flat_map(|y| weights[0].iter().map(move |x| x * y));
                expected.iter_mut().zip(products).for_each(|(sum, weight)| *sum += sample * weight);
            }
            assert!(sums.iter().zip(&expected).all(|(a, b)| a.abs_diff_eq(*b, 1e-12)));
        }
    }

    /// Each weight is at most about 1, and all that a source gives and a pixel takes too: sums do not overflow.
    #[test]
    fn weights_are_scaled() {
        for (filter, _) in all() {
            let filter = PixelFilter::new(&filter);
            for squares in filter.of_squares() {
                let sum: f64 = squares.iter().map(|weight| weight.abs()).sum();
                assert!((0.3..1.1).contains(&sum), "{filter:?} {sum}");
            }
        }
    }
}
