//! How far the replicates of a pixel lie apart: its error.

use glam::{DVec3, DVec4, Vec3};
use lookat_image::{PixelError, Shared};
use serde::{Deserialize, Serialize};

use super::sum::{PixelSums, Scale, Sum};

/// The spread of the replicates of a pixel. Replicates are independent estimates of its value, each a weighted sum. They are
/// added in a fixed order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spread {
    /// About the value of the pixel: sums of what differs from it do not lose their digits.
    near: DVec3,
    /// With the weight W of a replicate and the difference D between its sum and W times `near`: the sums of D and W, of D D, of D W
    /// and of W W.
    off: DVec3,
    weight: f64,
    squares: DVec3,
    products: DVec3,
    weights: f64,
    pub replicates: u32,
    /// The samples of the pixel itself in all of them, whether they count or not.
    pub samples: u32,
}

impl Spread {
    /// Adds a replicate, unless no sample of it counts for the pixel.
    pub fn add_sum(&mut self, sum: &Sum, scale: Scale) {
        if sum.has_weight() {
            self.add(sum.weighted(scale));
        }
    }

    /// Adds a replicate: its weighted sum.
    pub fn add(&mut self, sum: DVec4) {
        let weight = sum.w;
        if self.replicates == 0 && weight != 0.0 {
            self.near = sum.truncate() / weight;
        }
        let off = sum.truncate() - self.near * weight;
        self.off += off;
        self.weight += weight;
        self.squares += off * off;
        self.products += off * weight;
        self.weights += weight * weight;
        self.replicates = self.replicates.saturating_add(1);
    }

    /// The standard error of the weighted mean of all replicates together; infinite for less than two, and where it is not known.
    /// It uses the delta method for a ratio: replicates with the sum S and the weight W scatter by S - M W around the mean
    /// M.
    pub fn standard_error(&self) -> Vec3 {
        let weight = self.weight;
        if self.replicates < 2 || weight == 0.0 {
            return Vec3::INFINITY;
        }
        let off = self.off / weight;
        let squares = self.squares - 2.0 * off * self.products + off * off * self.weights;
        let count = f64::from(self.replicates);
        // Rounding may leave less than nothing.
        let variance = squares.max(DVec3::ZERO) * (count / (count - 1.0)) / (weight * weight);
        let errors = DVec3::from(variance.to_array().map(f64::sqrt)).as_vec3();
        Vec3::select(errors.is_finite_mask(), errors, Vec3::INFINITY)
    }
}

/// What the replicates of a pixel tell of its error.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spreads {
    pub filtered: Spread,
    /// That of the samples in the pixel itself, without the filter. Without replicates if the filter makes no difference.
    pub unfiltered: Spread,
}

impl Spreads {
    /// The spreads of a pixel with these replicates, of so many samples in all. Leaves replicates out that no sample belongs to.
    pub fn of(replicates: &[PixelSums], at: usize, samples: u32, scale: Scale) -> Spreads {
        let mut spreads = Spreads::default();
        for PixelSums { filtered, unfiltered } in replicates {
            for (spread, sums) in [(&mut spreads.filtered, filtered), (&mut spreads.unfiltered, unfiltered)] {
                sums.get(at).into_iter().for_each(|sum| spread.add_sum(sum, scale));
            }
        }
        spreads.filtered.samples = samples;
        spreads
    }

    /// The error of a pixel on a film.
    ///
    /// `noise_area`: see [`Shared::noise_area`]. `None` if the filter makes no difference.
    pub fn error(&self, film: &lookat_scene::Film, noise_area: Option<f64>) -> PixelError {
        let of = |spread: &Spread| (spread.standard_error() * film.scale.abs() as f32).to_array();
        let unfiltered = of(&self.unfiltered);
        let shared = noise_area.map(|area| Shared { unfiltered, noise_area: area as f32 });
        let Spread { samples, replicates, .. } = self.filtered;
        PixelError { standard_error: of(&self.filtered), samples, replicates, shared }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    /// The error that the spread of replicates tells.
    fn error(replicates: &[DVec4]) -> Vec3 {
        let mut spread = Spread::default();
        replicates.iter().for_each(|replicate| spread.add(*replicate));
        spread.standard_error()
    }

    #[test]
    fn the_spread_is_that_of_the_replicates() {
        assert_eq!(error(&[DVec4::new(1.0, 5.0, 0.0, 1.0)]), Vec3::INFINITY);
        // The variance of 1, 2 and 6 is 7.
        let values = [1.0, 2.0, 6.0].map(|x| DVec4::new(x, 5.0, 0.0, 1.0));
        assert!((error(&values) - Vec3::new((7.0_f32 / 3.0).sqrt(), 0.0, 0.0)).length() < 1e-6);
    }

    /// Errors are known for values from black to brighter than any picture, and far below the value. Only black has errors of 0.
    #[test]
    fn errors_of_dark_and_bright_pixels_are_not_lost() {
        for mean in [0.0, 1e-12, 1e-4, 1.0, 1e6, 1e9] {
            for relative in [0.1, 1e-6] {
                let of = |at: usize| mean * (1.0 + if at.is_multiple_of(2) { relative } else { -relative });
                let replicates: Vec<_> = (0..16).map(|at| DVec3::splat(of(at) * 64.0).extend(64.0)).collect();
                let found = error(&replicates).x;
                let expected = (relative * mean / 15_f64.sqrt()) as f32;
                assert!(
                    (found - expected).abs() <= 1e-3 * expected + 1e-15,
                    "{mean} {relative}: {found} {expected}"
                );
            }
        }
    }

    /// With weights of both signs: over many pixels of random samples, the mean squared error of the values is the mean of the
    /// squared standard errors.
    #[test]
    fn the_spread_tells_the_error_under_negative_weights() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut sums = [0.0; 2];
        for _ in 0..20_000 {
            let (mut all, mut spread) = (Sum::default(), Spread::default());
            for _ in 0..16 {
                let mut replicate = DVec4::ZERO;
                for _ in 0..16 {
                    let (is_negative, value) = (random.random::<f64>() < 0.2, random.random::<f64>());
                    let (weight, value) =
                        if is_negative { (-0.5, 3.0 + 2.0 * value) } else { (1.0, 3.0 + value) };
                    replicate += (DVec3::splat(value) * weight).extend(weight);
                }
                spread.add(replicate);
                all += Sum::new(Scale::ONE.units(replicate));
            }
            // The mean is 3.5 times 0.8 minus 4 times 0.1, over 0.7.
            sums[0] += (all.mean(Scale::ONE).x - 2.4 / 0.7).powi(2);
            sums[1] += f64::from(spread.standard_error().x).powi(2);
        }
        let ratio = sums[0] / sums[1];
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }
}
