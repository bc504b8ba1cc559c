//! Light that samples of lights and directions from BSDFs find from points side by side, weighed against each other.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, Vec3};
use lookat_scene::LightChoice;

use super::{Emission, Samples, Sampling, light_of};
use crate::bsdf::lanes::Bsdfs;
use crate::integrator::Tracer;
use crate::integrator::lanes::world::World;
use crate::lanes::{Colors, LANES, bits, those, to_f32};
use crate::light::lanes::{LightSamples, SampledLight, weights};
use crate::light::{LightTable, Receiver};
use crate::sampler::lanes::Streams;
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::{Hits, Rays};

/// The light of a scene, in which one light is chosen at each surface.
pub(in crate::integrator) struct Lighting<'s> {
    table: &'s LightTable,
    /// Those that are sampled: the first ones.
    sampled: Vec<SampledLight<'s>>,
    choice: LightChoice,
    /// How many samples of each kind there are at a surface.
    samples: Samples,
    /// What a direction brings from where there is nothing, as its part of all, if no sky is a picture.
    even_sky: Option<Vec3>,
}

/// Surfaces that rays have hit.
pub(in crate::integrator) struct Vertices<'v, S: Simd, const LAMBERT: bool> {
    pub world: &'v World<'v>,
    pub rays: &'v Rays<S>,
    pub hits: &'v Hits<S>,
    pub surfaces: &'v Surfaces<S>,
    pub bsdfs: &'v Bsdfs<'v, S, LAMBERT>,
}

/// Directions from there.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Directions<S: Simd> {
    pub rays: Rays<S>,
    /// Densities by solid angle.
    pub pdf: f64x8<S>,
}

impl<'s> Lighting<'s> {
    /// `None` of skies where shading normals may differ from geometric ones: they are sampled in another way from each point
    /// there.
    pub fn new(table: &'s LightTable, choice: LightChoice, has_normals: bool) -> Option<Self> {
        if has_normals && table.has_skies() {
            return None;
        }
        let sampled = table.sampled_lights();
        let samples = Samples::of_one(table, choice, None);
        // Of none a direction is sampled in another way.
        let even_sky = table.even_sky().map(|sky| sky / samples.directions as f32);
        Some(Lighting { table, sampled, choice, samples, even_sky })
    }

    /// As [`super::one_light`], to the bit.
    #[inline(always)]
    pub fn one_light<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S, LAMBERT>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        if !self.sampled.is_empty() {
            return self.sampled_light(simd, tracer, streams, vertices, active);
        }
        streams.skip(1);
        let black = Colors::splat(simd, Vec3::ZERO);
        if self.samples.directions < 2 {
            streams.skip(2);
            return black;
        }
        let sample = vertices.bsdfs.sample(streams.next_2d(simd, active));
        let active = active & sample.is_there;
        let found = Directions { rays: vertices.surfaces.leave(sample.wi), pdf: sample.pdf };
        (sample.weight * self.found_light(simd, tracer, vertices, &found, active)).or(active, black)
    }

    /// As [`super::sampled_light`], of one that is chosen.
    #[inline(always)]
    fn sampled_light<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S, LAMBERT>,
        mut active: mask64x8<S>,
    ) -> Colors<S> {
        let Vertices { surfaces, bsdfs, .. } = *vertices;
        let mut chosen = [(0, 1.0); LANES];
        if self.sampled.len() == 1 {
            streams.skip(1);
        } else {
            active &= self.choose(simd, streams, vertices, active, &mut chosen);
        }
        let u = self.light_numbers(simd, streams, active, &chosen);
        let mut sample = self.sample(simd, surfaces, u, active, &chosen);
        for lane in those(sample.is_open & active) {
            // A scalar surface is needed for that.
            let surface = vertices.world.surface(tracer, vertices.rays, vertices.hits, lane);
            let one = surface.and_then(|surface| {
                self.table.sample(chosen[lane].0, &surface, None, DVec2::new(u[0][lane], u[1][lane]))
            });
            sample.put(lane, one.as_ref());
        }
        let (f_cos, pdf) = bsdfs.f_cos_pdf(sample.shadow.d);
        let reflected = f_cos * sample.li;
        active &= sample.is_there & reflected.is_light();
        active &= !vertices.world.met(simd, tracer, &sample.shadow, active);
        let mut count = [1.0; LANES];
        let mut is_sky = 0;
        for (lane, (light, probability)) in chosen.iter().enumerate() {
            count[lane] = *probability;
            is_sky |= u64::from(*light >= self.table.first_sky()) << lane;
        }
        let count: f64x8<S> = count.simd_into(simd);
        let direct = reflected / to_f32(count);
        let other = pdf * f64::from(self.samples.directions);
        let weight = weights(bits(simd, is_sky), sample.pdf * count, other);
        let weighed = direct * weight / to_f32(sample.pdf);
        weighed.or(sample.has_pdf, direct).or(active, Colors::splat(simd, Vec3::ZERO))
    }

    /// A light for each surface, and its probability; and where there is one.
    #[inline(always)]
    fn choose<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        streams: &mut Streams,
        vertices: &Vertices<S, LAMBERT>,
        active: mask64x8<S>,
        chosen: &mut [(usize, f64); LANES],
    ) -> mask64x8<S> {
        let numbers = streams.next_1d(active);
        let mut are_chosen = 0;
        for lane in those(active) {
            let receiver = vertices.receiver(lane);
            if let Some(light) = self.table.chosen(self.choice, &receiver, None, numbers[lane]) {
                chosen[lane] = light;
                are_chosen |= 1 << lane;
            }
        }
        bits(simd, are_chosen)
    }

    /// Numbers to sample the lights by that are chosen. Where nothing about a light is left to chance, they stay untaken.
    #[inline(always)]
    fn light_numbers<S: Simd>(
        &self,
        simd: S,
        streams: &mut Streams,
        active: mask64x8<S>,
        chosen: &[(usize, f64); LANES],
    ) -> [f64x8<S>; 2] {
        let mut is_extended = 0;
        for (lane, (light, _)) in chosen.iter().enumerate() {
            is_extended |= u64::from(!self.table.is_delta(*light)) << lane;
        }
        streams.next_2d(simd, active & bits(simd, is_extended))
    }

    /// Samples of lights that are chosen.
    #[inline(always)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        surfaces: &Surfaces<S>,
        u: [f64x8<S>; 2],
        active: mask64x8<S>,
        chosen: &[(usize, f64); LANES],
    ) -> LightSamples<S> {
        let (first, _) = chosen[0];
        let mut of_first = 0;
        for (lane, (light, _)) in chosen.iter().enumerate() {
            of_first |= u64::from(*light == first) << lane;
        }
        let mut samples = self.sampled[first].samples(simd, surfaces, u);
        let mut rest = active.to_bitmask() & !of_first;
        while rest != 0 {
            let (light, _) = chosen[rest.trailing_zeros() as usize];
            let mut is_same = 0;
            for (lane, (other, _)) in chosen.iter().enumerate() {
                is_same |= u64::from(*other == light) << lane;
            }
            samples = self.sampled[light].samples(simd, surfaces, u).or(bits(simd, is_same), samples);
            rest &= !is_same;
        }
        samples
    }

    /// As [`super::found_light`], to the bit.
    #[inline(always)]
    pub fn found_light<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        vertices: &Vertices<S, LAMBERT>,
        directions: &Directions<S>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        let mut found = Colors::splat(simd, Vec3::ZERO);
        let may_meet = tracer.scene.emitters.may_be_met_by(simd, &directions.rays) & active;
        if may_meet.any_true() {
            let hits = vertices.world.nearest(simd, tracer, &directions.rays, may_meet, false);
            found = self.light_of(simd, tracer, vertices, directions, &hits, may_meet);
        }
        let rest = active & !may_meet;
        if self.table.has_skies() && rest.any_true() {
            let is_free = rest & !vertices.world.met(simd, tracer, &directions.rays, rest);
            let nothing = Hits::none(simd);
            let sky = self.light_of(simd, tracer, vertices, directions, &nothing, is_free);
            found = sky.or(is_free, found);
        }
        found
    }

    /// As [`super::light_of`], to the bit.
    #[inline(always)]
    pub fn light_of<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &Tracer,
        vertices: &Vertices<S, LAMBERT>,
        directions: &Directions<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        let mut found = Colors::splat(simd, Vec3::ZERO);
        let mut is_light = hits.emits & active;
        if self.table.has_skies() {
            let is_free = active & !hits.is_hit();
            match self.even_sky {
                Some(sky) => found = Colors::splat(simd, sky).or(is_free, found),
                None => is_light |= is_free,
            }
        }
        for lane in those(is_light) {
            let receiver = &vertices.receiver(lane);
            let sampling = &Sampling { receiver, lune: None, samples: self.samples };
            let (ray, hit) = vertices.world.one(&directions.rays, hits, lane);
            let emission = Emission::weighed(sampling, directions.pdf[lane]);
            found.put(lane, light_of(tracer, emission, &ray, hit.as_ref()));
        }
        found
    }
}

impl<S: Simd, const LAMBERT: bool> Vertices<'_, S, LAMBERT> {
    /// One of them.
    fn receiver(&self, lane: usize) -> Receiver {
        Receiver { p: self.surfaces.p.lane(lane), domain: self.bsdfs.domain(lane) }
    }
}
