//! Light that samples of lights find, and that directions from the BSDF find, weighed against each other (PBR 14.3.1).

use glam::{DVec2, DVec3, Vec3};
use lookat_scene::LightChoice;

use super::Tracer;
use crate::bsdf::{Bsdf, BsdfSample, Part};
use crate::light::{LightTable, Lune};
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
    /// How many samples there are of a light from the point `p` of a surface, in the mean.
    fn of_light(self, lights: &LightTable, p: DVec3, lune: Option<&Lune>, light: usize) -> f64 {
        match self {
            Samples::One(choice) => lights.probability(choice, p, lune, light),
            Samples::Each { .. } => f64::from(lights.samples(light)),
        }
    }

    /// How many directions from the BSDF there are.
    pub fn directions(self) -> f64 {
        match self {
            Samples::One(_) => 1.0,
            Samples::Each { directions } => f64::from(directions),
        }
    }
}

/// A surface that light comes to.
pub(super) struct Vertex<'v> {
    pub surface: &'v Surface<'v>,
    pub bsdf: &'v Bsdf<'v>,
    /// What of the BSDF directions are sampled from.
    pub part: Part,
    pub lune: Option<Lune>,
}

impl<'v> Vertex<'v> {
    pub fn new(lights: &LightTable, surface: &'v Surface<'v>, bsdf: &'v Bsdf<'v>, part: Part) -> Self {
        Vertex { surface, bsdf, part, lune: lights.lune(bsdf) }
    }
}

/// A direction from the BSDF, for which it has to be known how likely it was.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    samples: Samples,
    /// The point of the surface that it leaves.
    from: DVec3,
    lune: Option<Lune>,
    /// Density by solid angle, times the number of directions.
    pdf: f64,
}

impl Direction {
    pub fn new(vertex: &Vertex, sample: &BsdfSample, samples: Samples) -> Self {
        Direction {
            samples,
            from: vertex.surface.p,
            lune: vertex.lune,
            pdf: sample.pdf * samples.directions(),
        }
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
        lights.skies(self.lune.as_ref(), d).map(weighed).sum()
    }

    fn samples_of(&self, lights: &LightTable, light: usize) -> f64 {
        self.samples.of_light(lights, self.from, self.lune.as_ref(), light)
    }
}

/// What one light, chosen at random, brings straight to a surface.
pub(super) fn one_light(
    tracer: &mut Tracer,
    vertex: &Vertex,
    stream: &mut SampleStream,
    choice: LightChoice,
) -> Vec3 {
    let lights = tracer.lights();
    let Some((light, probability)) = lights.choose(choice, vertex.surface.p, vertex.lune.as_ref(), stream)
    else {
        stream.skip(2);
        return Vec3::ZERO;
    };
    let u = match lights.is_delta(light) {
        true => stream.left_2d(),
        false => stream.next_2d(),
    };
    sampled_light(tracer, vertex, (light, probability), Samples::One(choice), u)
}

/// The share of one sample of a light in what it brings straight to a surface. `count`: how many there are, in the mean.
pub(super) fn sampled_light(
    tracer: &mut Tracer,
    vertex: &Vertex,
    (light, count): (usize, f64),
    samples: Samples,
    u: DVec2,
) -> Vec3 {
    let lights = tracer.lights();
    let Vertex { surface, bsdf, part, lune } = vertex;
    let Some(sample) = lights.sample(light, surface, lune.as_ref(), u) else {
        return Vec3::ZERO;
    };
    let reflected = bsdf.f_cos(sample.shadow.d) * sample.li;
    if reflected == Vec3::ZERO || tracer.occluded(&sample.shadow) {
        return Vec3::ZERO;
    }
    let direct = reflected / count as f32;
    let Some(pdf) = sample.pdf else { return direct };
    let other = bsdf.pdf(sample.shadow.d, *part) * samples.directions();
    direct * lights.weight(light, pdf * count, other) / pdf as f32
}
