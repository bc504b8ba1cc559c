//! Which of the lights is sampled.

use std::f64::consts::PI;

use glam::DVec3;
use lookat_scene::{LightChoice, Scene, Shape};

use super::{LightTable, SceneLight};
use crate::color::luminance;

/// With more lights than this, "spatial" chooses by power: it estimates each light at each point.
const MANY: usize = 32;

impl LightTable<'_> {
    /// A light for the point `p` by a number from 0 to 1, and its probability.
    pub fn choose(&self, choice: LightChoice, p: DVec3, u: f64) -> Option<(usize, f64)> {
        let last = self.lights.len().checked_sub(1)?;
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
                // The sum serves both the choice and its probability.
                let total: f64 = self.estimates(p).sum();
                let mut rest = u * total;
                let passed = |estimate| {
                    rest -= estimate;
                    rest < 0.0
                };
                let light = self.estimates(p).position(passed).unwrap_or(last);
                (light, self.share(p, light, total))
            }
        };
        (probability > 0.0).then_some((light, probability))
    }

    /// The probability with which [`LightTable::choose`] gives a light.
    pub fn probability(&self, choice: LightChoice, p: DVec3, light: usize) -> f64 {
        match self.rule(choice) {
            LightChoice::Uniform => 1.0 / self.lights.len() as f64,
            LightChoice::Power if light == 0 => self.power_cdf[0],
            LightChoice::Power => self.power_cdf[light] - self.power_cdf[light - 1],
            LightChoice::Spatial => self.share(p, light, self.estimates(p).sum()),
        }
    }

    /// The share of a light in the sum of the estimates.
    fn share(&self, p: DVec3, light: usize, total: f64) -> f64 {
        if total > 0.0 { self.lights[light].estimate(p) / total } else { 0.0 }
    }

    fn rule(&self, choice: LightChoice) -> LightChoice {
        if choice == LightChoice::Spatial && self.lights.len() > MANY { LightChoice::Power } else { choice }
    }

    fn estimates(&self, p: DVec3) -> impl Iterator<Item = f64> {
        self.lights.iter().map(move |light| light.estimate(p))
    }
}

/// The share of the power of the lights up to each.
pub(super) fn power_cdf(lights: &[SceneLight], scene: &Scene, eye: DVec3) -> Vec<f64> {
    let radius = scene_radius(scene, eye);
    let power: Vec<f64> = lights.iter().map(|light| light.power(radius)).collect();
    let total: f64 = power.iter().sum();
    let mut sum = 0.0;
    let shares = power.iter().map(|power| {
        // Where no light has power, or one has all too much, all are alike.
        sum += if total > 0.0 && total.is_finite() { power / total } else { 1.0 / lights.len() as f64 };
        sum
    });
    shares.collect()
}

impl SceneLight<'_> {
    /// About the irradiance at `p`, were nothing in the way.
    fn estimate(&self, p: DVec3) -> f64 {
        match self {
            SceneLight::Point { position, intensity } | SceneLight::Spot { position, intensity, .. } => {
                luminance(*intensity) / position.distance_squared(p).max(f64::MIN_POSITIVE)
            }
            SceneLight::Goniometric(light) => {
                luminance(light.mean()) / light.position.distance_squared(p).max(f64::MIN_POSITIVE)
            }
            SceneLight::Projection(light) => {
                luminance(light.mean()) / light.position.distance_squared(p).max(f64::MIN_POSITIVE)
            }
            SceneLight::Distant { radiance, .. } => luminance(*radiance),
            SceneLight::Infinite { radiance, .. } => luminance(*radiance) * PI,
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
            SceneLight::Point { intensity, .. } => 4.0 * PI * luminance(*intensity),
            SceneLight::Spot { intensity, cos_total_width, cos_falloff_start, .. } => {
                2.0 * PI * (1.0 - 0.5 * (cos_total_width + cos_falloff_start)) * luminance(*intensity)
            }
            SceneLight::Goniometric(light) => 4.0 * PI * luminance(light.mean()),
            SceneLight::Projection(light) => light.solid_angle() * luminance(light.mean()),
            SceneLight::Distant { radiance, .. } => PI * radius * radius * luminance(*radiance),
            SceneLight::Infinite { radiance, .. } => PI * PI * radius * radius * luminance(*radiance),
            SceneLight::Environment(environment) => PI * PI * radius * radius * environment.brightness(),
            SceneLight::Surface(surface) => surface.brightness * surface.area * PI,
        }
    }
}

/// About the radius of the scene: from the middle of its shapes to the farthest corner of the box around their places.
fn scene_radius(scene: &Scene, eye: DVec3) -> f64 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut include = |p: DVec3| {
        min = min.min(p - eye);
        max = max.max(p - eye);
    };
    for primitive in &scene.primitives {
        match &primitive.shape {
            Shape::Quadric(quadric) => {
                let (low, high) = quadric.corners();
                include(quadric.world_from_object.point(low));
                include(quadric.world_from_object.point(high));
            }
            Shape::Curve(curve) => {
                let points = curve.segments.as_flattened().iter();
                points.for_each(|p| include(curve.world_from_object.point(*p)));
            }
            Shape::TriangleMesh(mesh) => mesh.positions.iter().for_each(|p| include(DVec3::from(*p))),
        }
    }
    scene.instances.iter().for_each(|instance| include(instance.world_from_object.point(DVec3::ZERO)));
    if min.x > max.x { 1.0 } else { (max - min).length() * 0.5 }
}
