//! Light that samples of lights find, and that directions from the BSDF find, weighed against each other (PBR 14.3.1).

use std::rc::Rc;

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::LightChoice;

use super::{Found, Tracer};
use crate::bsdf::{Bsdf, BsdfSample, Part};
use crate::light::{LightTable, Lune, Receiver};
use crate::ray::Ray;
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
    /// As many of each light as it asks for.
    Each,
}

impl Samples {
    /// One light, and one direction; or two, where no light is to be sampled.
    pub fn of_one(lights: &LightTable, choice: LightChoice, lune: Option<&Lune>) -> Self {
        let directions = if lights.leaves_all_to_directions(lune) { 2 } else { 1 };
        Samples { lights: LightSamples::One(choice), directions }
    }

    /// How many samples there are of a light from a point of a surface, in the mean.
    fn of_light(self, lights: &LightTable, at: &Receiver, lune: Option<&Lune>, light: usize) -> f64 {
        match self.lights {
            LightSamples::One(choice) => lights.probability(choice, at, lune, light),
            LightSamples::Each => f64::from(lights.samples(light)),
        }
    }
}

/// A surface that light comes to.
pub(super) struct Vertex<'v> {
    pub surface: &'v Surface<'v>,
    pub bsdf: &'v Bsdf<'v>,
    /// What of the BSDF directions are sampled from.
    pub part: Part,
    /// Few surfaces have one: the others are not to pay for its size.
    pub lune: Option<Rc<Lune>>,
    pub samples: Samples,
}

impl Vertex<'_> {
    fn receiver(&self) -> Receiver {
        Receiver { p: self.surface.p, domain: self.bsdf.domain() }
    }
}

/// One of the directions from the BSDF at a surface: it has to be known how likely it was.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    samples: Samples,
    /// Where it leaves the surface.
    from: Receiver,
    lune: Option<Rc<Lune>>,
    /// Density by solid angle, times the number of directions.
    pdf: f64,
}

/// How emission that a ray finds counts.
pub(super) enum Emission {
    /// In full: the ray comes from the camera, or from where no light could be sampled.
    Full,
    /// Weighed against samples of lights at the surface that the ray left.
    Weighed(Direction),
    /// Not at all: pbrt-v3 sees no light through a surface without a material, except from the camera.
    Hidden,
}

impl Emission {
    /// That of a surface.
    pub fn emitted(&self, lights: &LightTable, surface: &Surface, wo: DVec3) -> Vec3 {
        match self {
            Emission::Full => surface.le(wo),
            Emission::Weighed(direction) => direction.emitted(lights, surface, wo),
            Emission::Hidden => Vec3::ZERO,
        }
    }

    /// The radiance from where there is nothing.
    pub fn background(&self, lights: &LightTable, d: DVec3) -> Vec3 {
        match self {
            Emission::Full => lights.background(d),
            Emission::Weighed(direction) => direction.background(lights, d),
            Emission::Hidden => Vec3::ZERO,
        }
    }
}

impl Direction {
    pub fn new(vertex: &Vertex, sample: &BsdfSample) -> Self {
        let pdf = sample.pdf * f64::from(vertex.samples.directions);
        Direction { samples: vertex.samples, from: vertex.receiver(), lune: vertex.lune.clone(), pdf }
    }

    /// What counts of the emission of a surface that it finds, as its part of all directions.
    fn emitted(&self, lights: &LightTable, surface: &Surface, wo: DVec3) -> Vec3 {
        let le = surface.le(wo);
        let light = lights.of_element(surface.element).filter(|_| le != Vec3::ZERO);
        let Some(light) = light else { return Vec3::ZERO };
        let other = lights.surface_pdf(light, self.from.p, -wo, surface) * self.samples_of(lights, light);
        le * lights.weight(light, self.pdf, other) / self.samples.directions as f32
    }

    /// What counts of the radiance from where there is nothing, in the same way.
    fn background(&self, lights: &LightTable, d: DVec3) -> Vec3 {
        let weighed = |(light, radiance, other): (usize, Vec3, f64)| {
            // Most often nothing else finds it.
            let other = if other > 0.0 { other * self.samples_of(lights, light) } else { 0.0 };
            radiance * lights.weight(light, self.pdf, other)
        };
        lights.skies(self.lune.as_deref(), d).map(weighed).sum::<Vec3>() / self.samples.directions as f32
    }

    fn samples_of(&self, lights: &LightTable, light: usize) -> f64 {
        self.samples.of_light(lights, &self.from, self.lune.as_deref(), light)
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
    let chosen = lights.choose(choice, &vertex.receiver(), vertex.lune.as_deref(), stream);
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
        None if vertex.samples.directions > 1 => by_directions(tracer, vertex, stream, 1),
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
    let Vertex { surface, bsdf, part, lune, samples } = vertex;
    let Some(sample) = lights.sample(light, surface, lune.as_deref(), u) else {
        return Vec3::ZERO;
    };
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
        let Some(sample) = vertex.bsdf.sample(stream.nested_2d(count, k), vertex.part) else { continue };
        // What lies in single directions counts in full where the path goes on there.
        if sample.is_specular {
            continue;
        }
        let emission = Emission::Weighed(Direction::new(vertex, &sample));
        found += sample.weight() * found_light(tracer, &emission, &vertex.surface.leave(sample.wi));
    }
    found
}

/// Light that a ray finds.
pub(super) fn found_light(tracer: &mut Tracer, emission: &Emission, ray: &Ray) -> Vec3 {
    let lights = tracer.lights();
    match tracer.find_light(ray) {
        Found::Nothing => Vec3::ZERO,
        Found::Sky => emission.background(lights, ray.d),
        Found::Surface(hit) => emission.emitted(lights, &tracer.surface(ray, &hit), -ray.d),
    }
}
