//! Pixel filters: how much each sample counts for the pixels around it (PBR 7.8 and 7.9).

use std::f64::consts::PI;

use glam::DVec2;
use lookat_scene::{Filter, FilterKind};

/// The weights of a sample for the pixels whose filter reaches it.
#[derive(Debug, Clone)]
pub(crate) struct PixelFilter {
    axes: [Axis; 2],
}

impl PixelFilter {
    pub fn new(filter: &Filter) -> Self {
        let axis = |axis: usize| Axis::new(filter.kind, filter.radius[axis], filter.reach()[axis]);
        PixelFilter { axes: [axis(0), axis(1)] }
    }

    /// The largest distance in pixels, across and down, at which a sample still counts.
    pub fn reach(&self) -> [u32; 2] {
        [0, 1].map(|axis| self.axes[axis].reach)
    }

    /// The weight of a sample for the pixel that it lies in, at `place` in its unit square.
    #[inline(always)]
    pub fn own(&self, place: DVec2) -> f64 {
        self.axes[0].own(place.x) * self.axes[1].own(place.y)
    }

    /// The noise-equivalent area in pixels: the square of the integral over the integral of the square, at least 1.
    pub fn noise_area(&self) -> f64 {
        self.axes[0].noise_area * self.axes[1].noise_area
    }

    /// The integral of the weights over the distance, in pixels.
    pub fn integral(&self) -> f64 {
        self.axes[0].integral * self.axes[1].integral
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
                for (sum, weight) in sums.iter_mut().zip(&weights) {
                    *sum += weight / STEPS as f64;
                }
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
    noise_area: f64,
    integral: f64,
    /// For a Gaussian: its value at the radius.
    floor: f64,
    /// Values at whole pixel distances, which do not depend on the sample. For a Gaussian: its value. For a sinc: sine and
    /// cosine of the window's angle.
    far: Vec<[f64; 2]>,
}

/// With larger exponents a Gaussian is evaluated pixel by pixel: products would leave the range of numbers.
const MOST_EXPONENT: f64 = 300.0;

impl Axis {
    fn new(kind: FilterKind, radius: f64, reach: u32) -> Self {
        const STEPS: u32 = 1 << 14;
        let offsets = (0..=2 * reach).map(|k| f64::from(k) - f64::from(reach));
        let (floor, far) = match kind {
            FilterKind::Gaussian { alpha } => {
                let far = offsets.map(|k| [libm::exp(-alpha * k * k), 0.0]).collect();
                (libm::exp(-alpha * radius * radius), far)
            }
            FilterKind::Sinc { tau } => {
                (0.0, offsets.map(|k| [libm::sin(PI * k / tau), libm::cos(PI * k / tau)]).collect())
            }
            _ => (0.0, Vec::new()),
        };
        let mut axis = Axis { kind, radius, reach, scale: 1.0, noise_area: 1.0, integral: 1.0, floor, far };
        let step = radius / f64::from(STEPS);
        let values: Vec<f64> = (0..STEPS).map(|at| axis.at((f64::from(at) + 0.5) * step)).collect();
        let integral = |of: fn(f64) -> f64| 2.0 * step * values.iter().copied().map(of).sum::<f64>();
        let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        axis.scale = integral(f64::abs).max(most).recip();
        axis.integral = integral(|value| value) * axis.scale;
        axis.noise_area = (integral(|value| value).powi(2) / integral(|value| value * value)).max(1.0);
        axis
    }

    /// The weight for the pixel that a sample lies in.
    #[inline(always)]
    fn own(&self, place: f64) -> f64 {
        self.at(0.5 - place) * self.scale
    }

    /// The filter of pbrt-v3 (PBR 7.8) at a distance, up to a constant factor.
    #[inline(always)]
    fn at(&self, x: f64) -> f64 {
        let radius = self.radius;
        match self.kind {
            FilterKind::Box => f64::from(-radius <= x && x < radius),
            FilterKind::Triangle => (radius - x.abs()).max(0.0),
            FilterKind::Gaussian { alpha } => (libm::exp(-alpha * x * x) - self.floor).max(0.0),
            FilterKind::Mitchell { b, c } => mitchell(b, c, (2.0 * x / radius).abs()),
            FilterKind::Sinc { tau } => {
                let (x, window) = (PI * x, PI * x / tau);
                self.windowed(x, libm::sin(x), window, libm::sin(window))
            }
        }
    }

    /// A sinc with Lanczos' window, by two angles and their sines.
    #[inline(always)]
    fn windowed(&self, x: f64, sin: f64, window: f64, sin_window: f64) -> f64 {
        if x.abs() > PI * self.radius {
            return 0.0;
        }
        let sinc = |x: f64, sin: f64| if x.abs() < 1e-5 { 1.0 } else { sin / x };
        sinc(x, sin) * sinc(window, sin_window)
    }

    /// The weights of a sample for the pixels from `reach` before its own on.
    #[inline(always)]
    fn weigh(&self, place: f64, weights: &mut Vec<f64>) {
        let (reach, own, scale) = (f64::from(self.reach), 0.5 - place, self.scale);
        weights.clear();
        let offsets = (0..=2 * self.reach).map(|k| f64::from(k) - reach);
        match self.kind {
            // exp(-a (k + t)^2) = exp(-a k^2) exp(-a t^2) exp(-2 a t)^k
            FilterKind::Gaussian { alpha } if alpha * (reach + 1.0) * (reach + 1.0) < MOST_EXPONENT => {
                let step = libm::exp(-2.0 * alpha * own);
                let mut factor = libm::exp(-alpha * own * own + 2.0 * alpha * own * reach);
                weights.extend(self.far.iter().map(|[far, _]| {
                    let value = far * factor - self.floor;
                    factor *= step;
                    value.max(0.0) * scale
                }));
            }
            // sin(k + t) = sin(k) cos(t) + cos(k) sin(t)
            FilterKind::Sinc { tau } => {
                let (sin, window) = (libm::sin(PI * own), PI * own / tau);
                let (sin_window, cos_window) = (libm::sin(window), libm::cos(window));
                weights.extend(offsets.zip(&self.far).map(|(k, [sin_k, cos_k])| {
                    let sin = if k.rem_euclid(2.0) == 0.0 { sin } else { -sin };
                    let x = k + own;
                    self.windowed(PI * x, sin, PI * x / tau, sin_k * cos_window + cos_k * sin_window) * scale
                }));
            }
            _ => weights.extend(offsets.map(|k| self.at(k + own) * scale)),
        }
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
                if x <= 4.0 { sinc(PI * x) * sinc(PI * x / 3.0) } else { 0.0 }
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
