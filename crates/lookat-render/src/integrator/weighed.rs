//! Light that samples of lights find, and that directions from the BSDF find, weighed against each other (PBR 14.3.1).

use glam::{DVec3, Vec3};
use lookat_scene::{DirectStrategy, LightChoice};

use super::tracer::Tracer;
use crate::light::{LightTable, Lune, Receiver};
use crate::ray::{Hit, Ray};
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
    /// For one light: one direction, or two where no light is sampled. For all lights: as many directions as the light with the most
    /// samples has, and the samples of each light that is not sampled.
    pub fn new(table: &LightTable, lights: LightSamples, lune: Option<&Lune>) -> Self {
        let directions = match lights {
            LightSamples::One(_) if table.leaves_all_to_directions(lune) => 2,
            LightSamples::One(_) => 1,
            LightSamples::Each(strategy) => {
                let others = (table.eligible(lune)..table.len()).map(|light| table.samples(light, strategy));
                others.fold(most_samples(table, strategy), u32::saturating_add)
            }
        };
        Samples { lights, directions }
    }
}

/// The most samples that any of the lights asks for, if any is more than a point or a direction.
pub(super) fn most_samples(table: &LightTable, strategy: DirectStrategy) -> u32 {
    let samples = (0..table.len()).map(|light| table.samples(light, strategy));
    samples.max().filter(|_| table.has_extended()).unwrap_or(0)
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

/// Emission that a ray finds, weighed against samples of lights at the surface that the ray left.
#[derive(Clone, Copy)]
pub(super) struct Weighed<'v> {
    from: &'v Sampling<'v>,
    /// Density of the ray by solid angle, times the number of directions.
    pdf: f64,
}

impl<'v> Weighed<'v> {
    /// That found by a direction of density `pdf`.
    pub fn new(from: &'v Sampling<'v>, pdf: f64) -> Self {
        Weighed { from, pdf: pdf * f64::from(from.samples.directions) }
    }

    /// Light of what the ray has found, as its part of all directions.
    pub fn light(self, tracer: &Tracer, ray: &Ray, found: Option<&Hit>) -> Vec3 {
        match found {
            None => self.background(tracer.lights(), ray.d),
            Some(hit) if tracer.emits(hit) => {
                self.emitted(tracer.lights(), &tracer.surface(ray, hit), -ray.d)
            }
            Some(_) => Vec3::ZERO,
        }
    }

    fn emitted(self, lights: &LightTable, surface: &Surface, wo: DVec3) -> Vec3 {
        let (Weighed { from, pdf }, le) = (self, surface.le(wo));
        let light = lights.of_element(surface.element).filter(|_| le != Vec3::ZERO);
        let Some(light) = light else { return Vec3::ZERO };
        let density = lights.surface_pdf(light, from.receiver.p, -wo, surface);
        let other = density * from.samples_of(lights, light);
        le * lights.weight(light, pdf, other) / from.samples.directions as f32
    }

    fn background(self, lights: &LightTable, d: DVec3) -> Vec3 {
        let Weighed { from, pdf } = self;
        let weighed = |(light, radiance, other): (usize, Vec3, f64)| {
            // Most often nothing else finds it.
            let other = if other > 0.0 { other * from.samples_of(lights, light) } else { 0.0 };
            radiance * lights.weight(light, pdf, other)
        };
        lights.skies(from.lune, d).map(weighed).sum::<Vec3>() / from.samples.directions as f32
    }
}
