//! Direct lighting of samples side by side, from lights of no extent and skies that are everywhere alike.

use fearless_simd::{Simd, mask64x8, prelude::*};
use glam::{DVec3, Vec3};
use lookat_scene::{DirectStrategy, Integrator};

use crate::bsdf::lanes::Bsdfs;
use crate::camera::lanes::Views;
use crate::integrator::Tracer;
use crate::integrator::lanes::world::World;
use crate::lanes::Colors;
use crate::light::LightTable;
use crate::light::lanes::PlainLight;
use crate::sampler::lanes::Streams;
use crate::shading::lanes::Shaded;
use crate::trace::lanes::Rays;
use crate::traceable::Traceable;

/// A scene that [`Lanes::li`] serves for.
pub(crate) struct Lanes<'s> {
    pub(in crate::integrator) world: World<'s>,
    /// Those that are sampled.
    lights: Vec<PlainLight>,
    /// So many directions from the BSDF look for light.
    directions: u32,
    /// What one of these brings from where there is nothing, as its part of all.
    sky: Vec3,
    background: Vec3,
}

impl<'s> Lanes<'s> {
    /// `None` of scenes that have anything else.
    pub fn new(integrator: &Integrator, traceable: &'s Traceable, lights: &LightTable) -> Option<Self> {
        let Integrator::DirectLighting { strategy, .. } = *integrator else { return None };
        if strategy == DirectStrategy::One || !traceable.emitters.is_empty() {
            return None;
        }
        let sampled = lights.plain_lights()?;
        let world = World::new(traceable)?;
        // Where normals differ, skies are sampled in another way from each point.
        if lights.has_skies() && world.has_normals() {
            return None;
        }
        let mut directions = 0;
        for count in super::directions(lights, strategy, sampled.len()) {
            if count > 1 {
                return None;
            }
            directions += count;
        }
        // Of no direction is it sampled in another way.
        let sky = lights.even_sky()?;
        Some(Lanes {
            world,
            lights: sampled,
            directions,
            sky: sky / directions as f32,
            background: lights.background(DVec3::Z),
        })
    }

    /// The radiance along those of the camera rays that are active; as [`super::li`], to the bit.
    #[inline(always)]
    pub fn li<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        (rays, views): (&Rays<S>, &Views),
        active: mask64x8<S>,
        streams: &mut Streams,
    ) -> Colors<S> {
        let hits = self.world.nearest(simd, tracer, rays, active, true);
        let background = Colors::splat(simd, self.background);
        let is_hit = hits.is_hit() & active;
        if !is_hit.any_true() {
            return background;
        }
        let Shaded { surfaces, frames, coats, .. } =
            &self.world.shaded(simd, tracer, (rays, &hits), Some(views), active);
        let bsdfs: Bsdfs<S, LAMBERT> = Bsdfs::new(surfaces.n, frames, -rays.d, coats);
        let black = Colors::splat(simd, Vec3::ZERO);
        let mut radiance = black;
        for light in &self.lights {
            let sample = light.samples(simd, surfaces);
            let reflected = bsdfs.f_cos_pdf(sample.shadow.d).0 * sample.li;
            let asked = sample.is_there & reflected.is_light() & is_hit;
            let is_free = !self.world.met(simd, tracer, &sample.shadow, asked);
            radiance = radiance + reflected.or(asked & is_free, black);
        }
        for _ in 0..self.directions {
            let sample = bsdfs.sample(streams.next_2d(simd, active));
            let asked = sample.is_there & is_hit;
            let is_free = !self.world.met(simd, tracer, &surfaces.leave(sample.wi), asked);
            radiance = radiance + (sample.weight * Colors::splat(simd, self.sky)).or(asked & is_free, black);
        }
        radiance.or(is_hit, background)
    }
}
