//! Light that samples of lights find, and that directions from the BSDF find, weighed against each other (PBR 14.3.1).

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::LightChoice;

use super::Tracer;
use crate::bsdf::{Bsdf, BsdfSample, Domain, Part};
use crate::light::LightTable;
use crate::sampler::SampleStream;
use crate::surface::Surface;

/// How many samples of lights and how many directions from the BSDF there are at a surface.
#[derive(Debug, Clone, Copy)]
pub(super) enum Samples {
    /// One of each; the light is chosen at random.
    One(LightChoice),
    /// As many of each light as it asks for, and so many directions.
    Each { directions: u32 },
}

impl Samples {
    /// Of a light at the point `p`, in the mean.
    fn of_light(self, lights: &LightTable, p: DVec3, domain: &Domain, light: usize) -> f64 {
        match self {
            Samples::One(choice) => lights.probability(choice, p, domain, light),
            Samples::Each { .. } => f64::from(lights.samples(light)),
        }
    }

    pub fn directions(self) -> f64 {
        match self {
            Samples::One(_) => 1.0,
            Samples::Each { directions } => f64::from(directions),
        }
    }
}

/// A direction from the BSDF, for which it has to be known how likely it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    samples: Samples,
    /// The point of the surface that it leaves.
    from: DVec3,
    domain: Domain,
    /// Density by solid angle, times the number of directions.
    pdf: f64,
}

impl Direction {
    pub fn new(surface: &Surface, bsdf: &Bsdf, sample: &BsdfSample, samples: Samples) -> Self {
        Direction { samples, from: surface.p, domain: bsdf.domain(), pdf: sample.pdf * samples.directions() }
    }

    /// What counts of the emission of a surface that it finds.
    pub fn emitted(&self, lights: &LightTable, surface: &Surface, wo: DVec3) -> Vec3 {
        let le = surface.le(wo);
        let light = lights.of_element(surface.element).filter(|_| le != Vec3::ZERO);
        let Some(light) = light else { return Vec3::ZERO };
        let other = lights.surface_pdf(light, self.from, surface) * self.samples_of(lights, light);
        le * lights.weight(light, self.pdf, other)
    }

    /// What counts of the radiance from where there is nothing.
    pub fn background(&self, lights: &LightTable, d: DVec3) -> Vec3 {
        let weighed = |(light, radiance, other): (usize, Vec3, f64)| {
            // Most often nothing else finds it.
            let other = if other > 0.0 { other * self.samples_of(lights, light) } else { 0.0 };
            radiance * lights.weight(light, self.pdf, other)
        };
        lights.infinite(&self.domain, d).map(weighed).sum()
    }

    fn samples_of(&self, lights: &LightTable, light: usize) -> f64 {
        self.samples.of_light(lights, self.from, &self.domain, light)
    }
}

/// What one light, chosen at random, brings straight to a surface; `part` of the BSDF is sampled for directions.
pub(super) fn one_light(
    tracer: &mut Tracer,
    (surface, bsdf, part): (&Surface, &Bsdf, Part),
    stream: &mut SampleStream,
    choice: LightChoice,
) -> Vec3 {
    let lights = tracer.lights();
    let Some((light, probability)) = lights.choose(choice, surface.p, &bsdf.domain(), stream) else {
        stream.skip(2);
        return Vec3::ZERO;
    };
    let u = match lights.is_delta(light) {
        true => stream.left_2d(),
        false => stream.next_2d(),
    };
    sampled_light(tracer, (surface, bsdf, part), (light, probability), Samples::One(choice), u)
}

/// The share of one sample of a light in what it brings straight to a surface. `count`: how many there are, in the mean.
pub(super) fn sampled_light(
    tracer: &mut Tracer,
    (surface, bsdf, part): (&Surface, &Bsdf, Part),
    (light, count): (usize, f64),
    samples: Samples,
    u: DVec2,
) -> Vec3 {
    let lights = tracer.lights();
    let Some(sample) = lights.sample(light, surface, bsdf, u) else {
        return Vec3::ZERO;
    };
    let f_cos = bsdf.f_cos(sample.shadow.d);
    if f_cos == Vec3::ZERO || tracer.occluded(&sample.shadow) {
        return Vec3::ZERO;
    }
    let direct = f_cos * sample.li / count as f32;
    let Some(pdf) = sample.pdf else { return direct };
    let other = bsdf.pdf(sample.shadow.d, part) * samples.directions();
    direct * lights.weight(light, pdf * count, other) / pdf as f32
}
