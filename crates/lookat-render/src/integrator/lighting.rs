//! Lights and how surfaces sample them: light samples and what rays find, combined by multiple importance sampling (PBR 14.3).

use fearless_simd::{Simd, f32x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::Vec3;
use lookat_scene::{DirectStrategy, LightChoice};

use super::bodies::Bodies;
use super::path_batch::{PathBatch, Radiance, ScatteredPaths, add_light};
use super::path_record::{PathColumns, PathRecord};
use super::profiler::Stage;
use super::world::World;
use crate::bsdf::LobeFilter;
use crate::integrator::world::Tracer;
use crate::light::{Chosen, Estimates, LightHits, LightSample, LightSampler, LightTable, Receivers, weights};
use crate::number::{Vec2x8, Vec3fx8, bits, eights, groups, narrow, set_lanes, splat_f32, vectorized, widen};
use crate::ray::ElementId;

/// A world, its lights, and how surfaces sample them.
pub(in crate::integrator) struct Lighting<'s> {
    pub world: World<'s>,
    pub table: &'s LightTable,
    /// The number in the world of the element that each light is, see [`World::number`].
    numbers: Vec<f64>,
    /// The lights that are sampled at each surface.
    pub samples: LightSamples,
    /// The number of triangles that are chosen at each surface, if all lights are sampled: see [`LightTable::chosen_triangles`].
    pub chosen_triangles: u32,
    /// The number of BSDF directions at a surface without a lune, and with one.
    directions: [f32; 2],
    /// The lobes that BSDF directions are sampled from.
    pub filter: LobeFilter,
    /// The bodies that light enters and leaves, if the integrator looks inside and there are any.
    pub bodies: Option<Bodies<'s>>,
    /// True if surfaces with a lune sample skies differently: some shading normals differ from the geometric ones.
    pub has_lunes: bool,
}

/// Eight surfaces, and how their light is sampled.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Illumination<'v, S: Simd> {
    pub simd: S,
    pub lighting: &'v Lighting<'v>,
    pub receivers: &'v Receivers<S>,
    pub sampler: &'v LightSampler<'v, S>,
}

impl<'s> Lighting<'s> {
    /// `filter`: the lobes that BSDF directions are sampled from.
    pub fn new(world: World<'s>, table: &'s LightTable, lights: LightSamples, filter: LobeFilter) -> Self {
        let chosen_triangles = match lights {
            LightSamples::One(choice) => {
                table.prepare(choice);
                0
            }
            LightSamples::Each(strategy) => {
                table.prepare_triangles();
                table.chosen_triangles(strategy)
            }
        };
        Lighting {
            table,
            numbers: (0..table.len()).map(|light| world.number(table.curved_element(light))).collect(),
            samples: lights,
            chosen_triangles,
            directions: [false, true].map(|has_lune| directions(table, lights, has_lune) as f32),
            filter,
            has_lunes: world.materials.has_normals && table.has_skies(),
            bodies: None,
            world,
        }
    }
}

impl Lighting<'_> {
    /// The light sampler of surfaces, which keeps its estimates in `estimates`.
    #[inline(always)]
    pub fn sampler<'v, S: Simd>(
        &'v self,
        simd: S,
        receivers: &'v Receivers<S>,
        estimates: &'v mut Estimates,
    ) -> LightSampler<'v, S> {
        match self.samples {
            LightSamples::One(choice) => LightSampler::new(simd, (self.table, choice), receivers, estimates),
            LightSamples::Each(_) => LightSampler::of_triangles(simd, self.table, receivers, estimates),
        }
    }

    /// Adds the MIS-weighted emission that scattered rays see, once they are traced, times the transmittance on their way. `active`: the rays that may see any; each bit is one.
    #[inline(never)]
    pub fn add_emission<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        ScatteredPaths { paths, receivers }: &ScatteredPaths,
        active: u64,
        radiance: &mut Radiance,
    ) {
        vectorized!(simd, {
            let own = &mut PathRecord::none(simd);
            for (first, active) in eights(active) {
                paths.load(simd, first, paths.count, own);
                own.active = bits(simd, active);
                let mut sees = own.hits.emits;
                if self.table.has_skies() {
                    sees |= !own.hits.is_hit();
                }
                own.active &= sees;
                if own.active.any_true() {
                    if let Some(media) = &self.world.media {
                        let own_samples = (own.active, &tracer.seeds_of(own.samples));
                        let shares = media.transmittance((&own.rays, own.medium), own.ends(), own_samples);
                        own.throughput = own.throughput * shares;
                    }
                    let receivers = &receivers.eight(simd, first, self.has_lunes);
                    let mut estimates = Estimates::new();
                    let sampler = &self.sampler(simd, receivers, &mut estimates);
                    let illumination = Illumination { simd, lighting: self, receivers, sampler };
                    add_light(radiance, own, illumination.light_of(tracer, own), own.active);
                }
            }
        })
    }

    /// Makes scattered rays look for emission, later.
    #[inline(always)]
    pub fn look_for_emission<S: Simd>(
        &self,
        (simd, tracer): (S, &mut Tracer),
        scattered: &PathRecord<S>,
        receivers: &Receivers<S>,
        batch: &mut PathBatch,
    ) {
        // What has been seen is added up with the rays that wait, so there must be some.
        if !scattered.active.any_true() {
            return;
        }
        if batch.is_full() {
            self.trace_emission_rays(simd, tracer, batch);
        }
        batch.emission_rays.push(scattered, receivers);
    }

    /// Traces the rays that wait to look for emission, and adds what they see.
    #[inline(never)]
    fn trace_emission_rays<S: Simd>(&self, simd: S, tracer: &mut Tracer, batch: &mut PathBatch) {
        let PathBatch { emission, emission_rays, in_media, .. } = batch;
        let all = emission_rays.paths.all();
        let PathColumns { rays, hits, .. } = &mut emission_rays.paths;
        if let (Some(media), Some(own)) = (&self.world.media, in_media) {
            self.world.nearest(simd, tracer, rays, all, hits);
            self.lead(simd, tracer, media, (emission_rays, emission), None, &mut own.room);
        } else {
            let active = self.world.find_emission(simd, tracer, rays, all, hits);
            self.add_emission(simd, tracer, emission_rays, active, emission);
        }
        emission_rays.paths.count = 0;
    }

    /// Traces all rays that wait.
    #[inline(always)]
    pub fn trace_waiting<S: Simd>(&self, simd: S, tracer: &mut Tracer, batch: &mut PathBatch) {
        tracer.profile(|profiler| profiler.enter(Stage::Scattering));
        batch.trace_shadow_rays(simd, &self.world, tracer);
        if batch.emission_rays.paths.count > 0 {
            self.trace_emission_rays(simd, tracer, batch);
            for (radiance, emission) in batch.radiance.iter_mut().zip(&mut batch.emission) {
                *radiance += std::mem::take(emission);
            }
        }
    }
}

impl<S: Simd> Illumination<'_, S> {
    /// The number of BSDF directions at each surface.
    #[inline(always)]
    pub fn directions(&self) -> f32x8<S> {
        self.receivers.by_lune(self.simd, self.lighting.directions)
    }

    /// Samples the chosen lights.
    #[inline(always)]
    pub fn sample(&self, u: Vec2x8<S>, chosen: &Chosen<S>) -> LightSample<S> {
        let Illumination { simd, lighting, receivers: at, .. } = *self;
        let (mut rest, mut before) = (chosen.is_valid, None::<LightSample<S>>);
        loop {
            let light = chosen.light[rest.to_bitmask().trailing_zeros() as usize];
            let mut is_same = widen(chosen.light.simd_eq(light));
            let number = light as usize;
            let is_alike = |lane: &usize| lighting.table.are_alike(number, chosen.light[*lane] as usize);
            let alike = set_lanes(rest & !is_same).filter(is_alike).fold(0, |alike, lane| alike | 1 << lane);
            let in_world = widen(at.surfaces.instance.simd_eq(ElementId::WORLD));
            let own = match alike {
                0 => {
                    let leaving = in_world & at.surfaces.element.simd_eq(lighting.numbers[number]);
                    lighting.table.sample(simd, number, (at, leaving), (chosen.triangle, u))
                }
                _ => {
                    is_same = is_same & rest | bits(simd, alike);
                    let mut numbers = at.surfaces.element;
                    for lane in set_lanes(is_same) {
                        numbers[lane] = lighting.numbers[chosen.light[lane] as usize];
                    }
                    let leaving = in_world & at.surfaces.element.simd_eq(numbers);
                    lighting.table.sample_alike(simd, (chosen.light, is_same), (at, leaving), u)
                }
            };
            rest &= !is_same;
            let samples = match before {
                Some(before) => own.keep_where(is_same, before),
                None => own,
            };
            if !rest.any_true() {
                return samples;
            }
            before = Some(samples);
        }
    }

    /// The MIS-weighted light of the hits of paths.
    #[inline(never)]
    pub fn light_of(&self, tracer: &Tracer, scattered: &PathRecord<S>) -> Vec3fx8<S> {
        let Illumination { simd, lighting: Lighting { table, world, .. }, receivers, .. } = *self;
        let PathRecord { active, rays, hits, is_delta, .. } = scattered;
        vectorized!(simd, {
            let black = Vec3fx8::splat(simd, Vec3::ZERO);
            let mut found = black;
            let count = self.directions();
            let pdf = scattered.pdf * count;
            // What lies in single directions counts in full.
            let all = narrow(*is_delta).select(splat_f32(simd, 1.0), count);
            let is_lit = hits.emits & *active;
            if is_lit.any_true() {
                let none: u32x8<S> = 0.simd_into(simd);
                let (mut light, mut density, mut of_light) = (none, splat_f32(simd, 0.0), 0);
                let (d, by_triangle) = (rays.d, self.by_triangle());
                let mut on_light = LightHits { is_valid: is_lit, d, p: d, n: d, triangle: none, by_triangle };
                for lane in set_lanes(is_lit) {
                    let (ray, Some(hit)) = world.one(rays, hits, lane) else { continue };
                    let surface = tracer.surface(&ray, &hit);
                    found.set_lane(lane, surface.le(-ray.d));
                    if let Some(number) = table.of_element(surface.element) {
                        of_light |= 1 << lane;
                        light[lane] = number as u32;
                        on_light.triangle[lane] = surface.element.index;
                        on_light.p.set_lane(lane, surface.p);
                        on_light.n.set_lane(lane, surface.n);
                    }
                }
                for (lane, alike) in groups(of_light, |a, b| light[a] == light[b]) {
                    on_light.is_valid = bits(simd, alike);
                    let own = table.surface_pdf(simd, light[lane] as usize, &receivers.surfaces, &on_light);
                    density = narrow(on_light.is_valid).select(own, density);
                }
                let triangle = on_light.triangle;
                let other = density * self.samples_of((light, triangle), is_lit);
                let weight = weights(mask32x8::splat(simd, false), pdf, other);
                found = (found * weight).keep_where_wide(!*is_delta, found);
            }
            let is_free = *active & !hits.is_hit();
            if table.has_skies() && is_free.any_true() {
                let mut sum = black;
                for sky in table.first_sky..table.len() {
                    let (radiance, density) = table.sky(simd, sky, receivers.lunes.as_ref(), rays.d);
                    // Most often nothing else finds it.
                    let weighed = widen(density.simd_gt(0.0)) & !*is_delta & is_free;
                    let mut own = radiance;
                    if weighed.any_true() {
                        let light = ((sky as u32).simd_into(simd), 0.simd_into(simd));
                        let other = density * self.samples_of(light, is_free);
                        let weight = weights(mask32x8::splat(simd, true), pdf, other);
                        own = (radiance * weight).keep_where_wide(weighed, radiance);
                    }
                    sum = sum + own;
                }
                found = sum.keep_where_wide(is_free, found);
            }
            found / all
        })
    }

    /// True if triangles of lights are chosen one by one.
    fn by_triangle(&self) -> bool {
        matches!(self.lighting.samples, LightSamples::Each(_)) || self.sampler.by_triangle()
    }

    /// The mean number of samples of lights or their triangles.
    #[inline(always)]
    fn samples_of(&self, (light, triangle): (u32x8<S>, u32x8<S>), active: mask64x8<S>) -> f32x8<S> {
        let Lighting { table, samples, chosen_triangles, .. } = self.lighting;
        match *samples {
            LightSamples::One(_) => self.sampler.probability((light, triangle), active),
            LightSamples::Each(strategy) => {
                let mut counts = splat_f32(self.simd, *chosen_triangles as f32);
                if *chosen_triangles > 0 {
                    counts *= self.sampler.probability((light, triangle), active);
                }
                for lane in set_lanes(active) {
                    let number = light[lane] as usize;
                    if table.parts(number) > 0 {
                        counts[lane] = table.samples(number, strategy) as f32;
                    }
                }
                counts
            }
        }
    }
}

/// The lights that are sampled at each surface.
#[derive(Debug, Clone, Copy)]
pub(super) enum LightSamples {
    /// One light, chosen at random.
    One(LightChoice),
    /// All lights, with as many samples as the strategy says.
    Each(DirectStrategy),
}

/// The number of BSDF directions at a surface. For one light: one, or two if no light is sampled. For all lights: the most
/// samples of any light, plus the samples of each light that is not sampled.
pub(super) fn directions(table: &LightTable, lights: LightSamples, has_lune: bool) -> u32 {
    match lights {
        LightSamples::One(_) if table.leaves_all_to_directions(has_lune) => 2,
        LightSamples::One(_) => 1,
        LightSamples::Each(strategy) => {
            let others = (table.eligible(has_lune)..table.len()).map(|light| table.samples(light, strategy));
            others.fold(most_samples(table, strategy), u32::saturating_add)
        }
    }
}

/// The most samples of any light that is not a delta light.
pub(super) fn most_samples(table: &LightTable, strategy: DirectStrategy) -> u32 {
    let samples = (0..table.len()).map(|light| table.samples(light, strategy));
    samples.max().filter(|_| table.has_extended()).unwrap_or(0)
}
