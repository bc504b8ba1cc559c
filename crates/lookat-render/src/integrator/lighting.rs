//! Light that samples of lights and directions from BSDFs find from points side by side, weighed against each other.

use std::array::from_fn;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, Vec3};
use lookat_scene::{DirectStrategy, LightChoice};

use super::tracer::Tracer;
use super::weighed::{LightSamples, Samples, Sampling, Weighed, most_samples};
use crate::bsdf::{Bsdf, Part};
use crate::integrator::world::World;
use crate::lanes::{Colors, LANES, bits, those, to_f32};
use crate::light::lanes::{LightSamples as SampledLights, SampledLight, weights};
use crate::light::{LightTable, Lune, Receiver};
use crate::sampler::lanes::Streams;
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::{Hits, Rays};

/// The lights of a scene, and how surfaces sample them.
pub(in crate::integrator) struct Lighting<'s> {
    table: &'s LightTable,
    /// All of them, those first that are sampled where there is no [`Lune`].
    sampled: Vec<SampledLight<'s>>,
    /// How many samples there are where there is no lune.
    usual: Samples,
    /// What of the BSDFs directions are sampled from.
    part: Part,
    /// Whether skies are sampled in another way where normals differ.
    has_lunes: bool,
    /// What a direction brings from where there is nothing, as its part of all, if no sky is a picture, and there are no lunes.
    even_sky: Option<Vec3>,
}

/// The [`Lune`] of each surface.
pub(in crate::integrator) type Lunes = [Option<Lune>; LANES];

/// Surfaces that rays have hit.
pub(in crate::integrator) struct Vertices<'v, S: Simd> {
    pub world: &'v World<'v>,
    pub rays: &'v Rays<S>,
    pub hits: &'v Hits<S>,
    pub surfaces: &'v Surfaces<S>,
    pub bsdf: &'v Bsdf<'v, S>,
    pub lunes: &'v Lunes,
}

/// Directions from there.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Directions<S: Simd> {
    pub rays: Rays<S>,
    /// Densities by solid angle.
    pub pdf: f64x8<S>,
    /// Those that no other could have been sampled near to.
    pub is_specular: mask64x8<S>,
}

impl<'s> Lighting<'s> {
    /// `part`: what of the BSDFs directions are sampled from; `has_normals`: whether shading normals may differ from geometric
    /// ones.
    pub fn new(table: &'s LightTable, lights: LightSamples, part: Part, has_normals: bool) -> Self {
        let has_lunes = has_normals && table.has_skies();
        let usual = Samples::new(table, lights, None);
        let even_sky = table.even_sky().filter(|_| !has_lunes).map(|sky| sky / usual.directions as f32);
        Lighting { table, sampled: table.sampled_lights(), usual, part, has_lunes, even_sky }
    }

    /// The lunes of surfaces that scatter light into all directions.
    #[inline(always)]
    pub fn lunes<S: Simd>(&self, bsdf: &Bsdf<S>, active: mask64x8<S>) -> Lunes {
        let mut lunes = [None; LANES];
        if self.has_lunes {
            for lane in those(active & bsdf.has(Part::Smooth)) {
                lunes[lane] = self.table.lune(&bsdf.domain(lane));
            }
        }
        lunes
    }

    /// How many samples of each kind there are at a surface.
    fn samples(&self, lune: Option<&Lune>) -> Samples {
        if lune.is_none() { self.usual } else { Samples::new(self.table, self.usual.lights, lune) }
    }

    /// Light that comes straight to surfaces by way of samples of lights.
    #[inline(never)]
    pub fn direct<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || match self.usual.lights {
                LightSamples::One(choice) => {
                    self.one_light(simd, tracer, streams, vertices, (choice, active))
                }
                LightSamples::Each(strategy) => {
                    self.each_light(simd, tracer, streams, vertices, (strategy, active))
                }
            },
        )
    }

    /// What one light, chosen at random, brings straight to a surface; where none is to be sampled, what one more direction
    /// finds.
    #[inline(always)]
    fn one_light<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S>,
        (choice, active): (LightChoice, mask64x8<S>),
    ) -> Colors<S> {
        let mut chosen = [(0, 1.0); LANES];
        let (sampled, scattered) = self.choose(simd, streams, vertices, (choice, active), &mut chosen);
        let extended = self.extended(simd, &chosen) & sampled;
        let u = streams.next_2d(simd, extended | scattered);
        let mut found = Colors::splat(simd, Vec3::ZERO);
        if sampled.any_true() {
            found = self.sampled_light(simd, tracer, vertices, u, sampled, &chosen);
        }
        if scattered.any_true() {
            found = self.by_direction(simd, tracer, vertices, u, scattered).or(scattered, found);
        }
        found
    }

    /// Light from all lights, as often as the strategy says; where a light is not sampled, directions take its place.
    #[inline(never)]
    fn each_light<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S>,
        (strategy, active): (DirectStrategy, mask64x8<S>),
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut sum = Colors::splat(simd, Vec3::ZERO);
                for light in 0..self.table.len() {
                    let count = self.table.samples(light, strategy);
                    let sampled = self.eligible(simd, vertices.lunes, light, active);
                    let scattered = active & !sampled;
                    for k in 0..count {
                        let u = match self.table.is_delta(light) {
                            true => [0.0.simd_into(simd); 2],
                            false => streams.nested_2d(simd, active, (count, k)),
                        };
                        if sampled.any_true() {
                            let chosen = &[(light, f64::from(count)); LANES];
                            let own = self.sampled_light(simd, tracer, vertices, u, sampled, chosen);
                            sum = (sum + own).or(sampled, sum);
                        }
                        if scattered.any_true() {
                            let own = self.by_direction(simd, tracer, vertices, u, scattered);
                            sum = (sum + own).or(scattered, sum);
                        }
                    }
                }
                let most = most_samples(self.table, strategy);
                for k in 0..most {
                    let u = streams.nested_2d(simd, active, (most, k));
                    sum = sum + self.by_direction(simd, tracer, vertices, u, active);
                }
                sum
            },
        )
    }

    /// Light that one direction from each BSDF finds.
    #[inline(never)]
    pub fn by_direction<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        vertices: &Vertices<S>,
        u: [f64x8<S>; 2],
        active: mask64x8<S>,
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let sample = vertices.bsdf.sample(u, self.part);
                // What lies in single directions counts in full where the path goes on there.
                let asked = active & sample.is_there & !sample.is_specular;
                let (rays, is_specular) = (vertices.surfaces.leave(sample.wi), sample.is_specular);
                let directions = Directions { rays, pdf: sample.pdf, is_specular };
                let light = self.found_light(simd, tracer, vertices, &directions, asked);
                (sample.weight * light).or(asked, Colors::splat(simd, Vec3::ZERO))
            },
        )
    }

    /// The share of one sample of each chosen light in what it brings straight to a surface. `chosen`: the light, and how many samples
    /// of it there are, in the mean.
    #[inline(never)]
    fn sampled_light<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        vertices: &Vertices<S>,
        u: [f64x8<S>; 2],
        mut active: mask64x8<S>,
        chosen: &[(usize, f64); LANES],
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let Vertices { surfaces, bsdf, .. } = *vertices;
                let mut sample = self.sample(simd, surfaces, u, active, chosen);
                for lane in those(sample.is_open & active) {
                    // A scalar surface is needed for that.
                    let surface = vertices.world.surface(tracer, vertices.rays, vertices.hits, lane);
                    let one = surface.and_then(|surface| {
                        let u = DVec2::new(u[0][lane], u[1][lane]);
                        self.table.sample(chosen[lane].0, &surface, vertices.lunes[lane].as_ref(), u)
                    });
                    sample.put(lane, one.as_ref(), tracer.scene.labels);
                }
                let (f_cos, pdf) = bsdf.f_cos_pdf(sample.shadow.d, self.part);
                let reflected = f_cos * sample.li;
                active &= sample.is_there & reflected.is_light();
                active &= !vertices.world.met(simd, tracer, &sample.shadow, (active, true));
                let (mut count, mut is_sky) = ([1.0; LANES], 0);
                let first_sky = self.table.first_sky();
                for (lane, (light, probability)) in chosen.iter().enumerate() {
                    count[lane] = *probability;
                    is_sky |= u64::from(*light >= first_sky) << lane;
                }
                let count: f64x8<S> = count.simd_into(simd);
                let direct = reflected / to_f32(count);
                let other = pdf * self.directions(simd, vertices.lunes);
                let weight = weights(bits(simd, is_sky), sample.pdf * count, other);
                let weighed = direct * weight / to_f32(sample.pdf);
                weighed.or(sample.has_pdf, direct).or(active, Colors::splat(simd, Vec3::ZERO))
            },
        )
    }

    /// Where a light is sampled.
    #[inline(always)]
    fn eligible<S: Simd>(&self, simd: S, lunes: &Lunes, light: usize, active: mask64x8<S>) -> mask64x8<S> {
        if !self.has_lunes {
            return if light < self.table.eligible(None) { active } else { bits(simd, 0) };
        }
        let mut eligible = 0;
        for lane in those(active) {
            eligible |= u64::from(light < self.table.eligible(lunes[lane].as_ref())) << lane;
        }
        bits(simd, eligible)
    }

    /// How many directions there are at each surface.
    #[inline(always)]
    fn directions<S: Simd>(&self, simd: S, lunes: &Lunes) -> f64x8<S> {
        if !self.has_lunes {
            return f64::from(self.usual.directions).simd_into(simd);
        }
        let directions: [f64; LANES] =
            from_fn(|lane| f64::from(self.samples(lunes[lane].as_ref()).directions));
        directions.simd_into(simd)
    }

    /// A light for each surface, and its probability: where there is one, and where one more direction takes its place.
    #[inline(always)]
    fn choose<S: Simd>(
        &self,
        simd: S,
        streams: &mut Streams,
        vertices: &Vertices<S>,
        (choice, active): (LightChoice, mask64x8<S>),
        chosen: &mut [(usize, f64); LANES],
    ) -> (mask64x8<S>, mask64x8<S>) {
        let no = bits(simd, 0);
        if !self.has_lunes && self.table.eligible(None) < 2 {
            streams.skip(1);
            return match self.table.eligible(None) {
                1 => (active, no),
                _ if self.table.len() > 0 => (no, active),
                _ => (no, no),
            };
        }
        let (mut sampled, mut asked) = (active.to_bitmask(), 0);
        for lane in those(active) {
            let eligible = self.table.eligible(vertices.lunes[lane].as_ref());
            asked |= u64::from(eligible > 1) << lane;
            if eligible == 0 {
                sampled &= !(1 << lane);
            }
        }
        let scattered = active & !bits(simd, sampled);
        let numbers = streams.next_1d(bits(simd, asked));
        for lane in those(bits(simd, asked)) {
            let (receiver, lune) = (vertices.receiver(lane), vertices.lunes[lane].as_ref());
            match self.table.chosen(choice, &receiver, lune, numbers[lane]) {
                Some(light) => chosen[lane] = light,
                None => sampled &= !(1 << lane),
            }
        }
        (bits(simd, sampled), scattered)
    }

    /// Where the light that is chosen is more than a point or a direction. Where nothing about a light is left to chance, its
    /// numbers stay untaken.
    #[inline(always)]
    fn extended<S: Simd>(&self, simd: S, chosen: &[(usize, f64); LANES]) -> mask64x8<S> {
        let mut extended = 0;
        for (lane, (light, _)) in chosen.iter().enumerate() {
            extended |= u64::from(*light < self.table.len() && !self.table.is_delta(*light)) << lane;
        }
        bits(simd, extended)
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
    ) -> SampledLights<S> {
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

    /// Light that rays find. Most rays cannot find any, and need not be traced.
    #[inline(never)]
    pub fn found_light<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        vertices: &Vertices<S>,
        directions: &Directions<S>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut found = Colors::splat(simd, Vec3::ZERO);
                let may_meet = tracer.scene.emitters.may_be_met_by(simd, &directions.rays) & active;
                if may_meet.any_true() {
                    let hits = vertices.world.nearest(simd, tracer, &directions.rays, may_meet);
                    found = self.light_of(simd, tracer, vertices, directions, &hits, may_meet);
                }
                let rest = active & !may_meet;
                if self.table.has_skies() && rest.any_true() {
                    let is_free = rest & !vertices.world.met(simd, tracer, &directions.rays, (rest, false));
                    let nothing = Hits::none(simd);
                    let sky = self.light_of(simd, tracer, vertices, directions, &nothing, is_free);
                    found = sky.or(is_free, found);
                }
                found
            },
        )
    }

    /// Light of what rays have found, weighed against samples of lights.
    #[inline(never)]
    pub fn light_of<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        vertices: &Vertices<S>,
        directions: &Directions<S>,
        hits: &Hits<S>,
        active: mask64x8<S>,
    ) -> Colors<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut found = Colors::splat(simd, Vec3::ZERO);
                let mut is_light = hits.emits & active;
                if self.table.has_skies() {
                    let is_free = active & !hits.is_hit();
                    match self.even_sky {
                        Some(sky) => {
                            found = Colors::splat(simd, sky).or(is_free, found);
                            is_light |= is_free & directions.is_specular;
                        }
                        None => is_light |= is_free,
                    }
                }
                for lane in those(is_light) {
                    let (ray, hit) = vertices.world.one(&directions.rays, hits, lane);
                    if directions.is_specular.to_bitmask() >> lane & 1 == 1 {
                        found.put(lane, tracer.light_ahead(&ray, hit.as_ref(), true));
                        continue;
                    }
                    let (receiver, lune) = (&vertices.receiver(lane), vertices.lunes[lane].as_ref());
                    let sampling = &Sampling { receiver, lune, samples: self.samples(lune) };
                    let weighed = Weighed::new(sampling, directions.pdf[lane]);
                    found.put(lane, weighed.light(tracer, &ray, hit.as_ref()));
                }
                found
            },
        )
    }
}

impl<S: Simd> Vertices<'_, S> {
    /// One of them.
    fn receiver(&self, lane: usize) -> Receiver {
        Receiver { p: self.surfaces.p.lane(lane), domain: self.bsdf.domain(lane) }
    }
}
