//! Which of the lights is sampled.

use std::f64::consts::PI;

use arrayvec::ArrayVec;
use glam::DVec3;
use lookat_scene::LightChoice;

use super::lune::Lune;
use super::{LightTable, SceneLight};
use crate::color::strength;
use crate::prepare::Traceable;
use crate::sampler::SampleStream;
use crate::warp::pick;

/// With more lights than this, "spatial" chooses by power: it estimates each light at each point.
const MANY: usize = 32;

impl LightTable<'_> {
    /// A light for a point `p` of a surface with that [`Lune`], and its probability; by one number, whether there is a
    /// choice or not.
    pub fn choose(
        &self,
        choice: LightChoice,
        p: DVec3,
        lune: Option<&Lune>,
        stream: &mut SampleStream,
    ) -> Option<(usize, f64)> {
        let count = self.eligible(lune);
        if count < 2 {
            stream.skip(1);
            return (count == 1).then_some((0, 1.0));
        }
        let (u, last) = (stream.next_1d(), count - 1);
        let (light, probability) = match self.rule(choice) {
            LightChoice::Uniform => (((u * count as f64) as usize).min(last), 1.0 / count as f64),
            LightChoice::Power => {
                let total = self.total_power(count, lune);
                let at = u * total;
                let light = self.power_cdf.partition_point(|sum| *sum <= at);
                if light < self.first_sky {
                    (light, share(self.power_shares[light], total))
                } else {
                    let (sky, power, _) =
                        pick(self.powers_of_skies(count, lune), at - self.power_of_others())?;
                    (self.first_sky + sky, share(power, total))
                }
            }
            LightChoice::Spatial => {
                let estimates: ArrayVec<f64, MANY> = self.estimates(count, p, lune).collect();
                let total: f64 = estimates.iter().sum();
                let (light, estimate, _) = pick(estimates.iter().copied(), u * total)?;
                (light, share(estimate, total))
            }
        };
        (probability > 0.0).then_some((light, probability))
    }

    /// The probability with which [`LightTable::choose`] gives a light.
    pub fn probability(&self, choice: LightChoice, p: DVec3, lune: Option<&Lune>, light: usize) -> f64 {
        let count = self.eligible(lune);
        match self.rule(choice) {
            _ if light >= count => 0.0,
            _ if count == 1 => 1.0,
            LightChoice::Uniform => 1.0 / count as f64,
            LightChoice::Power => {
                let power = self.power_shares[light] * self.lights[light].sampled_share(lune);
                share(power, self.total_power(count, lune))
            }
            LightChoice::Spatial => {
                share(self.lights[light].estimate(p, lune), self.estimates(count, p, lune).sum())
            }
        }
    }

    /// How many lights there are to sample from a surface with that [`Lune`]: the first ones.
    pub fn eligible(&self, lune: Option<&Lune>) -> usize {
        if lune.is_some() { self.lights.len() } else { self.uneven }
    }

    /// How lights are chosen where `choice` is asked for.
    pub fn rule(&self, choice: LightChoice) -> LightChoice {
        if choice == LightChoice::Spatial && self.lights.len() > MANY { LightChoice::Power } else { choice }
    }

    /// Of the first `count` lights.
    fn total_power(&self, count: usize, lune: Option<&Lune>) -> f64 {
        self.power_of_others() + self.powers_of_skies(count, lune).sum::<f64>()
    }

    /// Of all that are no skies.
    fn power_of_others(&self) -> f64 {
        self.power_cdf.last().copied().unwrap_or(0.0)
    }

    /// Of the first `count` lights, those of skies that their samples are for.
    fn powers_of_skies(&self, count: usize, lune: Option<&Lune>) -> impl Iterator<Item = f64> {
        (self.first_sky..count).map(move |sky| self.power_shares[sky] * self.lights[sky].sampled_share(lune))
    }

    /// Of the first `count` lights.
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
            SceneLight::Infinite { radiance, .. } => strength(*radiance) * PI * self.sampled_share(lune),
            SceneLight::Environment(environment) => environment.brightness() * PI * self.sampled_share(lune),
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

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use glam::{DMat3, DVec2, Vec3};
    use lookat_image::{MipMap, Wrap};
    use lookat_scene::{Light, Overrides, SamplerKind, load};

    use super::*;
    use crate::Precision;
    use crate::bsdf::Domain;

    /// A lamp, one that is dark, a sphere and two skies; and the same with more lamps than "spatial" estimates.
    const LAMPS: &str = r#"LightSource "infinite" "rgb L" [.5 .5 .5] LightSource "point" "rgb I" [9 9 9]
        LightSource "point" "rgb I" [0 0 0] LightSource "infinite" "rgb L" [.1 .1 .1]
        AttributeBegin AreaLightSource "diffuse" Translate 3 0 0 Shape "sphere" AttributeEnd"#;

    fn with(lamps: &str, with_sky: bool, check: impl Fn(&LightTable)) {
        let text =
            format!("Film \"image\" Camera \"perspective\" WorldBegin {lamps} Shape \"sphere\" WorldEnd");
        let loaded = load(Path::new("x"), &|_| Ok(text.clone().into()), &Overrides::default());
        let mut scene = loaded.scene.unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
        let mut texels = vec![Vec3::splat(0.1); 32];
        texels[9] = Vec3::splat(5.0);
        let map = Arc::new(MipMap::new(8, 4, texels, Wrap::Repeat));
        let (turned, scale, samples) = (DMat3::IDENTITY, Vec3::ONE, 1);
        let sky =
            Light::Environment { map, scale, world_from_light: turned, light_from_world: turned, samples };
        if with_sky {
            scene.lights.push(sky);
        }
        check(&LightTable::new(&scene, &Traceable::new(&scene, Precision::Mixed)));
    }

    fn lune(degrees: f64, is_two_sided: bool) -> Option<Lune> {
        let ns = DVec2::from_angle((90.0 - degrees).to_radians()).extend(0.0);
        Lune::new(&Domain { n: DVec3::Y, ns, is_two_sided })
    }

    /// Lights are chosen as often as they are said to be.
    #[test]
    fn probabilities_are_those_of_choices() {
        let sampler = lookat_scene::Sampler { kind: SamplerKind::Sobol, samples_per_pixel: 1 << 14 };
        let p = DVec3::new(0.5, 1.0, 2.0);
        let many = LAMPS.to_string() + &r#" LightSource "point" "rgb I" [.1 .1 .1]"#.repeat(MANY);
        for lamps in
            [LAMPS, &many, r#"LightSource "infinite""#, r#"LightSource "infinite" LightSource "point""#]
        {
            for with_sky in [false, true] {
                with(lamps, with_sky, |table| {
                    for choice in [LightChoice::Uniform, LightChoice::Power, LightChoice::Spatial] {
                        for lune in [None, lune(20.0, false), lune(60.0, true)] {
                            let mut found = vec![0_u32; table.len()];
                            for index in 0..sampler.samples_per_pixel {
                                let mut stream = SampleStream::new(&sampler, 0, [0, 0], index);
                                let Some((light, said)) = table.choose(choice, p, lune.as_ref(), &mut stream)
                                else {
                                    continue;
                                };
                                let expected = table.probability(choice, p, lune.as_ref(), light);
                                assert!((said / expected - 1.0).abs() < 1e-12, "{choice:?} {light}");
                                found[light] += 1;
                            }
                            for (light, found) in found.into_iter().enumerate() {
                                let found = f64::from(found) / f64::from(sampler.samples_per_pixel);
                                let said = table.probability(choice, p, lune.as_ref(), light);
                                assert!((found - said).abs() < 3e-4, "{choice:?} {light}: {found} {said}");
                            }
                        }
                    }
                });
            }
        }
    }
}
