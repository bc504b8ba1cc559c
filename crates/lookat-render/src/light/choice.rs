//! Which of the lights is sampled.

use std::f64::consts::PI;

use arrayvec::ArrayVec;
use lookat_scene::LightChoice;

use super::lune::Lune;
use super::receiver::Receiver;
use super::{LightTable, SceneLight};
use crate::color::strength;
use crate::traceable::Traceable;
use crate::warp::pick;

/// No estimate is larger, so that their sum is finite.
const MOST: f64 = 1e300;

/// With more lights than this, "spatial" chooses by power: it estimates each light at each point.
const MANY: usize = 32;

impl LightTable {
    /// A light for a point of a surface with that [`Lune`], and its probability; by the number `u`, where there are several.
    pub fn chosen(
        &self,
        choice: LightChoice,
        at: &Receiver,
        lune: Option<&Lune>,
        u: f64,
    ) -> Option<(usize, f64)> {
        let count = self.eligible(lune);
        let (light, probability) = match self.rule(choice) {
            LightChoice::Uniform => (((u * count as f64) as usize).min(count - 1), 1.0 / count as f64),
            LightChoice::Power => {
                let total = self.total_power(count, lune);
                let mark = u * total;
                let light = self.power_cdf.partition_point(|sum| *sum <= mark);
                if light < self.first_sky {
                    (light, share(self.power_shares[light], total))
                } else {
                    let (sky, power, _) =
                        pick(self.powers_of_skies(count, lune), mark - self.power_of_others())?;
                    (self.first_sky + sky, share(power, total))
                }
            }
            LightChoice::Spatial => {
                let estimates: ArrayVec<f64, MANY> = self.estimates(count, at, lune).collect();
                let total: f64 = estimates.iter().sum();
                let (light, estimate, _) = pick(estimates.iter().copied(), u * total)?;
                (light, share(estimate, total))
            }
        };
        (probability > 0.0).then_some((light, probability))
    }

    /// The probability with which [`LightTable::chosen`] gives a light.
    pub fn probability(&self, choice: LightChoice, at: &Receiver, lune: Option<&Lune>, light: usize) -> f64 {
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
                share(self.lights[light].estimate(at, lune), self.estimates(count, at, lune).sum())
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
    fn estimates(&self, count: usize, at: &Receiver, lune: Option<&Lune>) -> impl Iterator<Item = f64> {
        self.lights[..count].iter().map(move |light| light.estimate(at, lune))
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

impl SceneLight {
    /// About the irradiance that its samples are for, were nothing in the way.
    fn estimate(&self, at: &Receiver, lune: Option<&Lune>) -> f64 {
        match self {
            SceneLight::Distant { direction, radiance } => strength(*radiance) * at.cosine(*direction, 0.0),
            SceneLight::Infinite { radiance, .. } => strength(*radiance) * PI * self.sampled_share(lune),
            SceneLight::Environment(environment) => environment.brightness() * PI * self.sampled_share(lune),
            SceneLight::Surface(surface) => surface.estimate(at),
            SceneLight::Point { .. }
            | SceneLight::Spot { .. }
            | SceneLight::Goniometric(_)
            | SceneLight::Projection(_) => self.seen_from(at.p).map_or(0.0, |seen| {
                let irradiance = strength(seen.intensity) / seen.squared_distance;
                irradiance.min(MOST) * at.cosine(seen.wi, 0.0)
            }),
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
            SceneLight::Surface(surface) => surface.brightness * surface.facing.sides * surface.area * PI,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::Path;
    use std::sync::Arc;

    use glam::{DVec2, DVec3, Vec3};
    use lookat_image::{MipMap, Wrap};
    use lookat_scene::{DirectStrategy, Integrator, Light, LoadOptions, SamplerKind, Transform, load};

    use super::*;
    use crate::Prepared;
    use crate::bsdf::Domain;
    use crate::render::{Settings, render};
    use crate::sampler::SampleStream;

    /// A lamp, one that is dark, a sphere and two skies; and the same with more lamps than "spatial" estimates.
    const LAMPS: &str = r#"LightSource "infinite" "rgb L" [.5 .5 .5] LightSource "point" "rgb I" [9 9 9]
        LightSource "point" "rgb I" [0 0 0] LightSource "infinite" "rgb L" [.1 .1 .1]
        AttributeBegin AreaLightSource "diffuse" Translate 3 0 0 Shape "sphere" AttributeEnd"#;

    fn with(lamps: &str, with_sky: bool, check: impl Fn(&LightTable)) {
        let text =
            format!("Film \"image\" Camera \"perspective\" WorldBegin {lamps} Shape \"sphere\" WorldEnd");
        let loaded = load(Path::new("x"), &|_| Ok(text.clone().into()), &LoadOptions::default());
        let mut scene = loaded.scene.unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
        let mut texels = vec![Vec3::splat(0.1); 32];
        texels[9] = Vec3::splat(5.0);
        let map = Arc::new(MipMap::new(8, 4, texels, Wrap::Repeat));
        let world_from_light = Transform::IDENTITY;
        let sky = Light::Environment { map, scale: Vec3::ONE, world_from_light, samples: 1 };
        if with_sky {
            Arc::make_mut(&mut scene.world).lights.push(sky);
        }
        check(&Prepared::new(&scene).lights);
    }

    fn lune(degrees: f64, is_two_sided: bool) -> Option<Lune> {
        let ns = DVec2::from_angle((90.0 - degrees).to_radians()).extend(0.0);
        Lune::new(&Domain { n: DVec3::Y, ns, is_two_sided, is_diffuse: false })
    }

    /// Lights are chosen as often as they are said to be.
    #[test]
    fn probabilities_are_those_of_choices() {
        let sampler = lookat_scene::Sampler { kind: SamplerKind::Sobol, samples_per_pixel: 1 << 14 };
        let p = DVec3::new(0.5, 1.0, 2.0);
        let at = Receiver {
            p,
            domain: Domain { n: DVec3::Y, ns: DVec3::Y, is_two_sided: false, is_diffuse: true },
        };
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
                                let mut stream = SampleStream::new(&sampler, 0, [0, 0]);
                                stream.restart(index);
                                let chosen = match table.eligible(lune.as_ref()) {
                                    0 => None,
                                    1 => Some((0, 1.0)),
                                    _ => table.chosen(choice, &at, lune.as_ref(), stream.next_1d()),
                                };
                                let Some((light, said)) = chosen else { continue };
                                let expected = table.probability(choice, &at, lune.as_ref(), light);
                                assert!((said / expected - 1.0).abs() < 1e-12, "{choice:?} {light}");
                                found[light] += 1;
                            }
                            for (light, found) in found.into_iter().enumerate() {
                                let found = f64::from(found) / f64::from(sampler.samples_per_pixel);
                                let said = table.probability(choice, &at, lune.as_ref(), light);
                                assert!((found - said).abs() < 3e-4, "{choice:?} {light}: {found} {said}");
                            }
                        }
                    }
                });
            }
        }
    }

    /// A lamp above a floor, and others that do not light it: from below, from behind their backs, or past it.
    const BESIDE: &str = r#"LightSource "point" "rgb I" [1 1 1] "point from" [1 2 0]
        LightSource "point" "rgb I" [9 9 9] "point from" [0 -1 0]
        LightSource "distant" "rgb L" [9 9 9] "point from" [0 -1 0] "point to" [0 0 0]
        LightSource "spot" "rgb I" [9 9 9] "point from" [3 1 0] "point to" [9 1 0]
        AttributeBegin Translate 3 1 0 Rotate 90 0 1 0 LightSource "projection" "rgb I" [9 9 9] AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Translate 0 3 0 Rotate -90 1 0 0
        Shape "disk" "float radius" .2 AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
        "point P" [0 3 0 1 3 0 0 3 -1] AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] ReverseOrientation Translate 0 3 0 Rotate 90 1 0 0
        Shape "disk" "float radius" .2 AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] ReverseOrientation Scale -1 1 1
        Shape "trianglemesh" "integer indices" [0 1 2] "point P" [0 3 0 0 3 -1 1 3 0] AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
        "point P" [0 3 0 0 3 -1 1 3 0] "normal N" [0 1 0 .6 .8 0 0 1 0] AttributeEnd"#;

    /// Lamps that do light it: from both sides, by normals that differ, and above the horizon with their rim alone.
    const AROUND: &str = r#"
        AttributeBegin AreaLightSource "diffuse" "bool twosided" "true" Translate 0 3 0 Rotate -90 1 0 0
        Shape "disk" "float radius" .2 AttributeEnd
        AttributeBegin AreaLightSource "diffuse" Shape "trianglemesh" "integer indices" [0 1 2]
        "point P" [0 3 0 1 3 0 0 3 -1] "normal N" [0 1 0 0 -1 0 0 1 0] AttributeEnd
        AttributeBegin AreaLightSource "diffuse" Translate 3 -.5 0 Shape "sphere" AttributeEnd"#;

    #[test]
    fn lights_that_shine_elsewhere_are_not_chosen() {
        with(BESIDE, false, |table| {
            let domain = Domain { n: DVec3::Y, ns: DVec3::Y, is_two_sided: false, is_diffuse: true };
            let shares = |domain| -> Vec<bool> {
                let at = Receiver { p: DVec3::ZERO, domain };
                let share = |light| table.probability(LightChoice::Spatial, &at, None, light);
                let shares: Vec<f64> = (0..table.len()).map(share).collect();
                assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{shares:?}");
                shares.iter().map(|share| *share > 0.0).collect()
            };
            let (above, below) = ([true, false, false], [true; 3]);
            assert_eq!(shares(domain), [above.as_slice(), &[false; 7]].concat());
            // Through what lets light through, two more shine.
            let domain = Domain { is_two_sided: true, is_diffuse: false, ..domain };
            assert_eq!(shares(domain), [below.as_slice(), &[false; 7]].concat());
        });
        with(AROUND, false, |table| {
            let domain = Domain { n: DVec3::Y, ns: DVec3::Y, is_two_sided: false, is_diffuse: true };
            // From a floor, and from the middle of each of the lamps.
            for p in
                [DVec3::ZERO, DVec3::Y * 3.0, DVec3::new(1.0, 9.0, -1.0) / 3.0, DVec3::new(3.0, -0.5, 0.0)]
            {
                let at = Receiver { p, domain };
                let share = |light| table.probability(LightChoice::Spatial, &at, None, light);
                let shares: Vec<f64> = (0..table.len()).map(share).collect();
                assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{p} {shares:?}");
                assert!(p != DVec3::ZERO || shares.iter().all(|share| *share > 0.0), "{shares:?}");
            }
        });
    }

    /// In grazing light a glossy surface has its highlight: that light is not to be chosen seldom.
    #[test]
    fn glossy_surfaces_do_not_ask_for_cosines() {
        let lamps =
            r#"LightSource "distant" "point from" [0 9 0] LightSource "distant" "point from" [9 .01 0]"#;
        with(lamps, false, |table| {
            let domain = Domain { n: DVec3::Y, ns: DVec3::Y, is_two_sided: false, is_diffuse: false };
            let share = |is_diffuse| {
                let at = Receiver { p: DVec3::ZERO, domain: Domain { is_diffuse, ..domain } };
                table.probability(LightChoice::Spatial, &at, None, 1)
            };
            assert_eq!(share(false), 0.5);
            assert!(share(true) < 0.1);
        });
    }

    /// Other integrators sample a light as often as it asks to be.
    #[test]
    fn whitted_samples_each_light_once() {
        for (integrator, samples) in [("whitted", 1), ("directlighting", 8), ("path", 8)] {
            let scene = crate::testing::scene(&format!(
                r#"Film "image" Camera "perspective" Integrator "{integrator}" WorldBegin
                AreaLightSource "diffuse" "integer nsamples" 8 Shape "sphere" WorldEnd"#
            ));
            let strategy = match scene.view.integrator {
                Integrator::DirectLighting { strategy, .. } => strategy,
                _ => DirectStrategy::All,
            };
            assert_eq!(Prepared::new(&scene).lights.samples(0, strategy), samples);
        }
    }

    /// The light in a picture is the same however lights are chosen; and there is less noise where they are chosen by place.
    #[test]
    fn choices_change_no_mean() {
        let mut scene = crate::testing::scene(
            r#"LookAt 0 1.5 -3 0 0 0 0 1 0 Camera "perspective" "float fov" 40 Film "image" "integer xresolution" 16 "integer yresolution" 12
            Sampler "random" "integer pixelsamples" 16 Integrator "path" WorldBegin
            LightSource "point" "rgb I" [9 9 9] "point from" [-2 2 0] LightSource "point" "rgb I" [9 9 9] "point from" [0 .5 2]
            LightSource "spot" "rgb I" [40 40 40] "point from" [2 3 -1] "point to" [1 0 0] "float coneangle" 25
            AttributeBegin Translate -2 2 -1 Rotate 90 1 0 0 LightSource "projection" "rgb I" [9 9 9] AttributeEnd
            AttributeBegin AreaLightSource "diffuse" "rgb L" [5 5 5] Translate 2 1 1 Shape "sphere" "float radius" .3 AttributeEnd
            AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Translate 0 3 0 Rotate 90 1 0 0
            Shape "disk" "float radius" .5 AttributeEnd
            AttributeBegin AreaLightSource "diffuse" "rgb L" [9 9 9] Shape "trianglemesh" "integer indices" [0 1 2]
            "point P" [-2 0 1 -2 1 1 -2 0 2] AttributeEnd
            Material "plastic" Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4 -4 0 4 4 0 4 4 0 -4]
            Material "translucent" Translate 0 .3 0 Shape "sphere" "float radius" .3 WorldEnd"#,
        );
        const PICTURES: u64 = 16;
        let variance = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
        };
        // The mean of all pictures, its variance, and that of pixels.
        let mut looked_at = |light_choice| -> (f64, f64, f64) {
            scene.view.integrator = Integrator::Path { max_depth: 1, roulette_threshold: 1.0, light_choice };
            let picture = |seed| -> Vec<f64> {
                let settings = Settings { seed, ..Settings::default() };
                let rendered = render(&scene, &settings, &|_| ControlFlow::Continue(()));
                rendered.image.rgb().unwrap().iter().map(|pixel| f64::from(pixel[0])).collect()
            };
            let pictures: Vec<Vec<f64>> = (0..PICTURES).map(picture).collect();
            let pixels = pictures[0].len();
            let means: Vec<f64> =
                pictures.iter().map(|picture| picture.iter().sum::<f64>() / pixels as f64).collect();
            let of_pixel =
                |at: usize| variance(&pictures.iter().map(|picture| picture[at]).collect::<Vec<_>>());
            let noise = (0..pixels).map(of_pixel).sum::<f64>() / pixels as f64;
            (means.iter().sum::<f64>() / PICTURES as f64, variance(&means) / PICTURES as f64, noise)
        };
        let (expected, uniform, noise) = looked_at(LightChoice::Uniform);
        for choice in [LightChoice::Power, LightChoice::Spatial] {
            let (mean, variance, less) = looked_at(choice);
            assert!(
                (mean - expected).abs() < 4.0 * (variance + uniform).sqrt(),
                "{choice:?}: {mean} {expected}"
            );
            assert!(choice == LightChoice::Power || less < 0.6 * noise, "{less} {noise}");
        }
    }
}
