//! Light that samples of lights find, and that directions from the BSDF find, weighed against each other (PBR 14.3.1).

pub(super) mod lanes;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::{DirectStrategy, LightChoice};

use super::Tracer;
use crate::bsdf::{Bsdf, BsdfSample, Part};
use crate::light::{LightTable, Lune, Receiver};
use crate::ray::{Hit, Ray};
use crate::sampler::SampleStream;
use crate::surface::Surface;

/// How many samples of lights and how many directions from the BSDF there are at a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    pub lights: LightSamples,
    pub directions: u32,
}

/// Which lights are sampled.
#[derive(Debug, Clone, Copy)]
pub(super) enum LightSamples {
    /// One, chosen at random.
    One(LightChoice),
    /// All of them, as often as the strategy says.
    Each(DirectStrategy),
}

impl Samples {
    /// One light, and one direction; or two, where no light is to be sampled.
    pub fn of_one(lights: &LightTable, choice: LightChoice, lune: Option<&Lune>) -> Self {
        let directions = if lights.leaves_all_to_directions(lune) { 2 } else { 1 };
        Samples { lights: LightSamples::One(choice), directions }
    }
}

/// A surface that light comes to.
pub(super) struct Vertex<'v> {
    pub surface: &'v Surface<'v>,
    pub bsdf: &'v Bsdf<'v>,
    /// What of the BSDF directions are sampled from.
    pub part: Part,
    pub sampling: Sampling<'v>,
}

/// How light is sampled at a surface.
#[derive(Clone, Copy)]
pub(super) struct Sampling<'v> {
    /// Its point, and the directions that its BSDF scatters light from.
    pub receiver: &'v Receiver,
    pub lune: Option<&'v Lune>,
    pub samples: Samples,
}

impl Sampling<'_> {
    /// How many samples there are of a light, in the mean.
    fn samples_of(&self, lights: &LightTable, light: usize) -> f64 {
        match self.samples.lights {
            LightSamples::One(choice) => lights.probability(choice, self.receiver, self.lune, light),
            LightSamples::Each(strategy) => f64::from(lights.samples(light, strategy)),
        }
    }
}

/// How emission that a ray finds counts.
#[derive(Clone, Copy)]
pub(super) enum Emission<'v> {
    /// In full: the ray comes from where no light could be sampled.
    Full,
    /// Weighed against samples of lights at the surface that the ray left.
    Weighed {
        from: &'v Sampling<'v>,
        /// Density of the ray by solid angle, times the number of directions.
        pdf: f64,
    },
}

impl<'v> Emission<'v> {
    /// That found by a sample of the BSDF.
    pub fn by(vertex: &'v Vertex<'v>, sample: &BsdfSample) -> Self {
        match sample.is_specular {
            true => Emission::Full,
            false => Emission::weighed(&vertex.sampling, sample.pdf),
        }
    }

    /// That found by a direction of density `pdf`, which is not the only one nearby.
    pub fn weighed(from: &'v Sampling<'v>, pdf: f64) -> Self {
        Emission::Weighed { from, pdf: pdf * f64::from(from.samples.directions) }
    }

    /// What counts of the emission of a surface, as its part of all directions.
    pub fn emitted(self, lights: &LightTable, surface: &Surface, wo: DVec3) -> Vec3 {
        let le = surface.le(wo);
        let Emission::Weighed { from, pdf } = self else { return le };
        let light = lights.of_element(surface.element).filter(|_| le != Vec3::ZERO);
        let Some(light) = light else { return Vec3::ZERO };
        let density = lights.surface_pdf(light, from.receiver.p, -wo, surface);
        let other = density * from.samples_of(lights, light);
        le * lights.weight(light, pdf, other) / from.samples.directions as f32
    }

    /// What counts of the radiance from where there is nothing, in the same way.
    pub fn background(self, lights: &LightTable, d: DVec3) -> Vec3 {
        let Emission::Weighed { from, pdf } = self else { return lights.background(d) };
        let weighed = |(light, radiance, other): (usize, Vec3, f64)| {
            // Most often nothing else finds it.
            let other = if other > 0.0 { other * from.samples_of(lights, light) } else { 0.0 };
            radiance * lights.weight(light, pdf, other)
        };
        lights.skies(from.lune, d).map(weighed).sum::<Vec3>() / from.samples.directions as f32
    }
}

/// What one light, chosen at random, brings straight to a surface; where none is to be sampled, what one more direction
/// finds.
pub(super) fn one_light(
    tracer: &mut Tracer,
    vertex: &Vertex,
    stream: &mut SampleStream,
    choice: LightChoice,
) -> Vec3 {
    let lights = tracer.lights();
    let Sampling { receiver, lune, samples } = vertex.sampling;
    let chosen = lights.choose(choice, receiver, lune, stream);
    match chosen {
        Some((light, probability)) => {
            // Where nothing about a light is left to chance, its numbers stay untaken.
            let u = if lights.is_delta(light) {
                stream.skip(2);
                DVec2::ZERO
            } else {
                stream.next_2d()
            };
            sampled_light(tracer, vertex, (light, probability), u)
        }
        None if samples.directions > 1 => by_directions(tracer, vertex, stream, 1),
        None => {
            stream.skip(2);
            Vec3::ZERO
        }
    }
}

/// The share of one sample of a light in what it brings straight to a surface. `count`: how many there are, in the mean.
pub(super) fn sampled_light(
    tracer: &mut Tracer,
    vertex: &Vertex,
    (light, count): (usize, f64),
    u: DVec2,
) -> Vec3 {
    let lights = tracer.lights();
    let Vertex { surface, bsdf, part, sampling: Sampling { lune, samples, .. } } = vertex;
    // By reference: it is large.
    let sample = lights.sample(light, surface, *lune, u);
    let Some(sample) = &sample else { return Vec3::ZERO };
    let reflected = bsdf.f_cos(sample.shadow.d) * sample.li;
    if reflected == Vec3::ZERO || tracer.occluded(&sample.shadow) {
        return Vec3::ZERO;
    }
    let direct = reflected / count as f32;
    let Some(pdf) = sample.pdf else { return direct };
    let other = bsdf.pdf(sample.shadow.d, *part) * f64::from(samples.directions);
    direct * lights.weight(light, pdf * count, other) / pdf as f32
}

/// Light that some of the directions from the BSDF find: `count`, of one pattern.
pub(super) fn by_directions(
    tracer: &mut Tracer,
    vertex: &Vertex,
    stream: &mut SampleStream,
    count: u32,
) -> Vec3 {
    let mut found = Vec3::ZERO;
    for k in 0..count {
        let sample = vertex.bsdf.sample(stream.nested_2d(count, k), vertex.part);
        let Some(sample) = &sample else { continue };
        // What lies in single directions counts in full where the path goes on there.
        if sample.is_specular {
            continue;
        }
        let emission = Emission::by(vertex, sample);
        found += sample.weight() * found_light(tracer, emission, &vertex.surface.leave(sample.wi));
    }
    found
}

/// Light that a ray finds. Most rays cannot find any, and need not be traced.
pub(super) fn found_light(tracer: &mut Tracer, emission: Emission, ray: &Ray) -> Vec3 {
    if tracer.may_meet_emitter(ray) {
        let found = tracer.nearest(ray);
        return light_of(tracer, emission, ray, found.as_ref());
    }
    let lights = tracer.lights();
    if lights.has_skies() && !tracer.meets(ray) { emission.background(lights, ray.d) } else { Vec3::ZERO }
}

/// Light of what a ray has found.
pub(super) fn light_of(tracer: &Tracer, emission: Emission, ray: &Ray, found: Option<&Hit>) -> Vec3 {
    match found {
        None => emission.background(tracer.lights(), ray.d),
        Some(hit) if tracer.emits(hit) => {
            emission.emitted(tracer.lights(), &tracer.surface(ray, hit), -ray.d)
        }
        Some(_) => Vec3::ZERO,
    }
}
