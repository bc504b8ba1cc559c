//! Which of the lights is sampled.

use std::f64::consts::PI;

use arrayvec::ArrayVec;
use glam::DVec3;
use lookat_scene::LightChoice;

use super::{LightTable, SceneLight};
use crate::color::strength;
use crate::prepare::Traceable;
use crate::sampler::SampleStream;

/// With more lights than this, "spatial" chooses by power: it estimates each light at each point.
const MANY: usize = 32;

impl LightTable<'_> {
    /// A light for the point `p`, and its probability; by one number, whether there is a choice or not.
    pub fn choose(&self, choice: LightChoice, p: DVec3, stream: &mut SampleStream) -> Option<(usize, f64)> {
        let last = self.lights.len().saturating_sub(1);
        if last == 0 {
            stream.skip(1);
            return (!self.lights.is_empty()).then_some((0, 1.0));
        }
        let u = stream.next_1d();
        let (light, probability) = match self.rule(choice) {
            LightChoice::Uniform => {
                let light = ((u * self.lights.len() as f64) as usize).min(last);
                (light, self.probability(choice, p, light))
            }
            LightChoice::Power => {
                let light = self.power_cdf.partition_point(|share| *share <= u).min(last);
                (light, self.probability(choice, p, light))
            }
            LightChoice::Spatial => {
                let estimates: ArrayVec<f64, MANY> = self.estimates(p).collect();
                let total: f64 = estimates.iter().sum();
                let mut rest = u * total;
                let passed = |estimate: &f64| {
                    rest -= estimate;
                    rest < 0.0
                };
                let light = estimates.iter().position(passed).unwrap_or(last);
                (light, share(estimates[light], total))
            }
        };
        (probability > 0.0).then_some((light, probability))
    }

    /// The probability with which [`LightTable::choose`] gives a light.
    pub fn probability(&self, choice: LightChoice, p: DVec3, light: usize) -> f64 {
        match self.rule(choice) {
            _ if self.lights.len() == 1 => 1.0,
            LightChoice::Uniform => 1.0 / self.lights.len() as f64,
            LightChoice::Power => self.power_shares[light],
            LightChoice::Spatial => share(self.lights[light].estimate(p), self.estimates(p).sum()),
        }
    }

    /// How lights are chosen where `choice` is asked for.
    pub fn rule(&self, choice: LightChoice) -> LightChoice {
        if choice == LightChoice::Spatial && self.lights.len() > MANY { LightChoice::Power } else { choice }
    }

    fn estimates(&self, p: DVec3) -> impl Iterator<Item = f64> {
        self.lights.iter().map(move |light| light.estimate(p))
    }
}

/// The share of an estimate in the sum of all.
fn share(estimate: f64, total: f64) -> f64 {
    if total > 0.0 { estimate / total } else { 0.0 }
}

/// This much of all samples goes to lights alike, so that a weak light next to what it lights is not forgotten over a
/// strong one far away.
const ALIKE: f64 = 0.01;

/// The share of each light in all samples, about that in their power, in a scene of the given radius.
pub(super) fn power_shares(lights: &[SceneLight], radius: f64) -> Vec<f64> {
    let power: Vec<f64> = lights.iter().map(|light| light.power(radius)).collect();
    let total: f64 = power.iter().sum();
    let alike = 1.0 / lights.len() as f64;
    // Where no light has power, or one has all too much, all are alike.
    if total <= 0.0 || !total.is_finite() {
        return vec![alike; lights.len()];
    }
    power.iter().map(|power| (1.0 - ALIKE) * power / total + ALIKE * alike).collect()
}

/// The sums of the shares up to each light.
pub(super) fn cumulated(shares: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |share: &f64| {
        sum += share;
        sum
    };
    shares.iter().map(add).collect()
}

/// About the radius of the scene.
pub(super) fn radius(traceable: &Traceable) -> f64 {
    let (low, high) = traceable.bounds().corners();
    let radius = (high - low).length() * 0.5;
    if radius.is_finite() { radius } else { 1.0 }
}

impl SceneLight<'_> {
    /// About the irradiance at `p`, were nothing in the way.
    fn estimate(&self, p: DVec3) -> f64 {
        let from_point = |intensity, position: DVec3| {
            strength(intensity) / position.distance_squared(p).max(f64::MIN_POSITIVE)
        };
        match self {
            SceneLight::Point { position, intensity } | SceneLight::Spot { position, intensity, .. } => {
                from_point(*intensity, *position)
            }
            SceneLight::Goniometric(light) => from_point(light.mean(), light.position),
            SceneLight::Projection(light) => from_point(light.mean(), light.position),
            SceneLight::Distant { radiance, .. } => strength(*radiance),
            SceneLight::Infinite { radiance, .. } => strength(*radiance) * PI,
            SceneLight::Environment(environment) => environment.brightness() * PI,
            SceneLight::Surface(surface) => {
                // A distant light fills its area over the squared distance; none fills more than the sky.
                surface.brightness * PI.min(surface.area / surface.center.distance_squared(p))
            }
        }
    }

    /// About the power that the light brings into a scene of the given radius.
    fn power(&self, radius: f64) -> f64 {
        match self {
            SceneLight::Point { intensity, .. } => 4.0 * PI * strength(*intensity),
            SceneLight::Spot { intensity, cos_total_width, cos_falloff_start, .. } => {
                2.0 * PI * (1.0 - 0.5 * (cos_total_width + cos_falloff_start)) * strength(*intensity)
            }
            SceneLight::Goniometric(light) => 4.0 * PI * strength(light.mean()),
            SceneLight::Projection(light) => light.solid_angle() * strength(light.mean()),
            SceneLight::Distant { radiance, .. } => PI * radius * radius * strength(*radiance),
            SceneLight::Infinite { radiance, .. } => PI * PI * radius * radius * strength(*radiance),
            SceneLight::Environment(environment) => PI * PI * radius * radius * environment.brightness(),
            SceneLight::Surface(surface) => surface.brightness * surface.area * PI,
        }
    }
}
