//! Pixel filters, by importance sampling: each camera sample belongs to one pixel, so a pixel depends on no other.

use glam::DVec2;
use lookat_scene::{Filter, FilterKind};

/// Places camera samples around the center of a pixel in proportion to the filter's absolute value (Ernst, Stamminger
/// and Greiner, "Filter Importance Sampling", 2006).
#[derive(Debug)]
pub(crate) struct FilterSampler {
    x: Axis,
    y: Axis,
}

impl FilterSampler {
    pub fn new(filter: &Filter) -> Self {
        FilterSampler {
            x: Axis::new(filter.kind, filter.radius.x),
            y: Axis::new(filter.kind, filter.radius.y),
        }
    }

    /// The offset from the center of the pixel, in pixels, and whether the filter is negative there.
    pub fn sample(&self, u: DVec2) -> (DVec2, bool) {
        let ((x, negative_x), (y, negative_y)) = (self.x.sample(u.x), self.y.sample(u.y));
        (DVec2::new(x, y), negative_x != negative_y)
    }

    /// Whether places are looked up in tables.
    pub fn has_tables(&self) -> bool {
        !self.x.cdf.is_empty() || !self.y.cdf.is_empty()
    }

    /// The integral of the absolute value over the integral: 1 for a filter that is nowhere negative.
    pub fn weight(&self) -> f64 {
        self.x.weight * self.y.weight
    }
}

/// The filter along one axis, as steps.
#[derive(Debug, Default)]
struct Axis {
    radius: f64,
    /// The share of the absolute value up to the end of each step; empty for a constant filter.
    cdf: Vec<f64>,
    /// Where to look from for numbers from 0 on, from one over the number of steps on, and so forth: the step of the least of
    /// them (Chen and Asau, "On Generating Random Variates from an Empirical Distribution", 1974).
    guide: Vec<u32>,
    negative: Vec<bool>,
    weight: f64,
}

/// Steps across the whole width, at least. pbrt-v3 takes 32.
const STEPS: usize = 1024;
/// Steps across a lobe of the filter, at least.
const STEPS_OF_LOBE: f64 = 16.0;

impl Axis {
    fn new(kind: FilterKind, radius: f64) -> Self {
        let lobe = match kind {
            FilterKind::Box => return Axis { radius, weight: 1.0, ..Axis::default() },
            FilterKind::Triangle | FilterKind::Mitchell { .. } => radius,
            FilterKind::Gaussian { alpha } => 1.0 / alpha.sqrt(),
            FilterKind::Sinc { tau } => tau.min(1.0),
        };
        let steps = STEPS.max((2.0 * radius / lobe * STEPS_OF_LOBE).ceil() as usize);
        let middle = |step: usize| ((step as f64 + 0.5) / steps as f64 * 2.0 - 1.0) * radius;
        let values: Vec<f64> = (0..steps).map(|step| evaluate(kind, radius, middle(step))).collect();
        let absolute: f64 = values.iter().map(|value| value.abs()).sum();
        let mut sum = 0.0;
        let cdf = values.iter().map(|value| {
            sum += value.abs() / absolute;
            sum
        });
        let cdf: Vec<f64> = cdf.collect();
        let first = |number: usize| cdf.partition_point(|share| *share <= number as f64 / steps as f64);
        Axis {
            radius,
            guide: (0..steps).map(|number| first(number) as u32).collect(),
            cdf,
            negative: values.iter().map(|value| *value < 0.0).collect(),
            weight: absolute / values.iter().sum::<f64>(),
        }
    }

    fn sample(&self, u: f64) -> (f64, bool) {
        if self.cdf.is_empty() {
            return ((2.0 * u - 1.0) * self.radius, false);
        }
        let steps = self.cdf.len();
        let mut step = self.guide[((u * steps as f64) as usize).min(steps - 1)] as usize;
        // The product may be rounded to the next.
        while step > 0 && self.cdf[step - 1] > u {
            step -= 1;
        }
        while step < steps - 1 && self.cdf[step] <= u {
            step += 1;
        }
        let before = if step == 0 { 0.0 } else { self.cdf[step - 1] };
        let within = ((u - before) / (self.cdf[step] - before)).clamp(0.0, 1.0);
        let x = ((step as f64 + within) / steps as f64 * 2.0 - 1.0) * self.radius;
        (x, self.negative[step])
    }
}

/// The filters of pbrt-v3 along one axis (PBR 7.8), up to a constant factor.
fn evaluate(kind: FilterKind, radius: f64, x: f64) -> f64 {
    match kind {
        FilterKind::Box => 1.0,
        FilterKind::Triangle => (radius - x.abs()).max(0.0),
        FilterKind::Gaussian { alpha } => {
            (libm::exp(-alpha * x * x) - libm::exp(-alpha * radius * radius)).max(0.0)
        }
        FilterKind::Mitchell { b, c } => mitchell(b, c, (2.0 * x / radius).abs()),
        FilterKind::Sinc { tau } => sinc(x) * sinc(x / tau) * f64::from(x.abs() <= radius),
    }
}

fn mitchell(b: f64, c: f64, x: f64) -> f64 {
    if x > 1.0 {
        return (-b - 6.0 * c) * x.powi(3)
            + (6.0 * b + 30.0 * c) * x * x
            + (-12.0 * b - 48.0 * c) * x
            + 8.0 * b
            + 24.0 * c;
    }
    (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0 - 2.0 * b
}

fn sinc(x: f64) -> f64 {
    let x = std::f64::consts::PI * x.abs();
    if x < 1e-5 { 1.0 } else { libm::sin(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of `offset^2` under the filter, by sampling and by quadrature.
    #[test]
    fn samples_follow_the_filter() {
        let third = 1.0 / 3.0;
        for kind in [
            FilterKind::Box,
            FilterKind::Triangle,
            FilterKind::Gaussian { alpha: 2.0 },
            FilterKind::Mitchell { b: third, c: third },
            FilterKind::Sinc { tau: 3.0 },
        ] {
            let radius = 2.0;
            let axis = Axis::new(kind, radius);
            let count = 100_000;
            let sampled: f64 = (0..count)
                .map(|i| axis.sample((f64::from(i) + 0.5) / f64::from(count)))
                .map(|(x, negative)| if negative { -x * x } else { x * x } * axis.weight)
                .sum::<f64>()
                / f64::from(count);
            let points = (0..count).map(|i| ((f64::from(i) + 0.5) / f64::from(count) * 2.0 - 1.0) * radius);
            let (mut moment, mut integral) = (0.0, 0.0);
            for x in points {
                moment += evaluate(kind, radius, x) * x * x;
                integral += evaluate(kind, radius, x);
            }
            let expected = moment / integral;
            assert!((sampled - expected).abs() < 1e-4, "{kind:?}: {sampled} {expected}");
        }
    }

    /// The share of negative samples, and the mean of `offset^2` where there is none, against a hundred times the steps.
    #[test]
    fn wide_filters_have_steps_enough() {
        for (kind, radius) in [
            (FilterKind::Gaussian { alpha: 1e4 }, 100.0),
            (FilterKind::Sinc { tau: 0.1 }, 100.0),
            (FilterKind::Sinc { tau: 3.0 }, 100.0),
        ] {
            let axis = Axis::new(kind, radius);
            let count = 3_200_000;
            let (mut absolute, mut integral, mut moment) = (0.0, 0.0, 0.0);
            for i in 0..count {
                let x = ((f64::from(i) + 0.5) / f64::from(count) * 2.0 - 1.0) * radius;
                let value = evaluate(kind, radius, x);
                (absolute, integral, moment) =
                    (absolute + value.abs(), integral + value, moment + value * x * x);
            }
            let expected = absolute / integral;
            assert!((axis.weight / expected - 1.0).abs() < 0.01, "{kind:?}: {} {expected}", axis.weight);
            if expected == 1.0 {
                let squares = (0..1000).map(|i| axis.sample((f64::from(i) + 0.5) / 1000.0).0.powi(2));
                let (sampled, expected) = (squares.sum::<f64>() / 1000.0, moment / integral);
                assert!((sampled / expected - 1.0).abs() < 0.01, "{kind:?}: {sampled} {expected}");
            }
        }
    }
}
