//! Which of the lights is sampled.

use std::f64::consts::PI;

use arrayvec::ArrayVec;
use glam::DVec3;
use lookat_scene::LightChoice;

use super::lune::Lune;
use super::{LightTable, SceneLight};
use crate::bsdf::Domain;
use crate::color::strength;
use crate::prepare::Traceable;
use crate::sampler::SampleStream;

/// With more lights than this, "spatial" chooses by power: it estimates each light at each point.
const MANY: usize = 32;

impl LightTable<'_> {
    /// A light for a point `p`, and its probability; by one number, whether there is a choice or not.
    pub fn choose(
        &self,
        choice: LightChoice,
        p: DVec3,
        domain: &Domain,
        stream: &mut SampleStream,
    ) -> Option<(usize, f64)> {
        let lune = Lune::new(domain);
        let count = self.first(lune.as_ref());
        if count < 2 {
            stream.skip(1);
            return (count == 1).then_some((0, 1.0));
        }
        let (u, last) = (stream.next_1d(), count - 1);
        let (light, probability) = match self.rule(choice) {
            LightChoice::Uniform => (((u * count as f64) as usize).min(last), 1.0 / count as f64),
            LightChoice::Power => {
                let total = self.power_cdf[last];
                let light = self.power_cdf[..last].partition_point(|sum| *sum <= u * total);
                (light, share(self.power_shares[light], total))
            }
            LightChoice::Spatial => {
                let estimates: ArrayVec<f64, MANY> = self.estimates(count, p, lune.as_ref()).collect();
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
    pub fn probability(&self, choice: LightChoice, p: DVec3, domain: &Domain, light: usize) -> f64 {
        let lune = Lune::new(domain);
        let count = self.first(lune.as_ref());
        match self.rule(choice) {
            _ if light >= count => 0.0,
            _ if count == 1 => 1.0,
            LightChoice::Uniform => 1.0 / count as f64,
            LightChoice::Power => share(self.power_shares[light], self.power_cdf[count - 1]),
            LightChoice::Spatial => {
                let total = self.estimates(count, p, lune.as_ref()).sum();
                share(self.lights[light].estimate(p, lune.as_ref()), total)
            }
        }
    }

    /// How many lights there are to sample from any surface: the first ones.
    pub fn always_eligible(&self) -> usize {
        self.uneven
    }

    /// How many there are to sample from this one.
    pub fn eligible(&self, domain: &Domain) -> usize {
        self.first(Lune::new(domain).as_ref())
    }

    fn first(&self, lune: Option<&Lune>) -> usize {
        if lune.is_some() { self.lights.len() } else { self.uneven }
    }

    /// How lights are chosen where `choice` is asked for.
    pub fn rule(&self, choice: LightChoice) -> LightChoice {
        if choice == LightChoice::Spatial && self.lights.len() > MANY { LightChoice::Power } else { choice }
    }

    /// Of the first lights.
    fn estimates(&self, count: usize, p: DVec3, lune: Option<&Lune>) -> impl Iterator<Item = f64> {
        self.lights[..count].iter().map(move |light| light.estimate(p, lune))
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
    /// About the irradiance at `p` that its samples are for, were nothing in the way.
    fn estimate(&self, p: DVec3, lune: Option<&Lune>) -> f64 {
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
            SceneLight::Infinite { radiance, .. } => strength(*radiance) * PI * lune.map_or(0.0, Lune::share),
            SceneLight::Environment(environment) => environment.sampled_brightness(lune) * PI,
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
            // Its samples are only for what BSDF samples miss.
            SceneLight::Infinite { .. } => 0.0,
            SceneLight::Environment(environment) => PI * PI * radius * radius * environment.brightness(),
            SceneLight::Surface(surface) => surface.brightness * surface.area * PI,
        }
    }
}
