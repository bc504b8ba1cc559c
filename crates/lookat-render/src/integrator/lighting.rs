//! Direct lighting at eight points: samples of lights and of BSDFs, combined by multiple importance sampling (PBR 14.3).

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::{DirectStrategy, LightChoice};

use super::path_batch::PathBatch;
use super::path_record::PathRecord;
use super::profiler::Stage;
use super::world::World;
use crate::bsdf::{Bsdf, BsdfSample, LobeFilter, LobeSlots};
use crate::camera::Viewer;
use crate::integrator::world::Tracer;
use crate::light::{Chosen, LightHits, LightSample, LightSampler, LightTable, Lunes, Receivers, weights};
use crate::number::{Colors, Vec2x8, bits, groups, set_lanes, to_f32, vectorized};
use crate::sampler::Streams;
use crate::shading::Shaded;
use crate::trace::rays::{Hits, WORLD};

/// A world, its lights, and how surfaces sample them.
pub(in crate::integrator) struct Lighting<'s> {
    pub world: World<'s>,
    table: &'s LightTable,
    /// The number in the world of the element that each light is, see [`World::number`].
    numbers: Vec<f64>,
    /// The lights that are sampled at each surface.
    samples: LightSamples,
    /// The number of triangles that are chosen at each surface, if all lights are sampled: see [`LightTable::chosen_triangles`].
    chosen_triangles: u32,
    /// The number of BSDF directions at a surface without a lune, and with one.
    directions: [f64; 2],
    /// The lobes that BSDF directions are sampled from.
    filter: LobeFilter,
    /// True if surfaces with a lune sample skies differently: some shading normals differ from the geometric ones.
    has_lunes: bool,
}

/// Eight path vertices, with the state for direct lighting.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Vertices<'v, S: Simd> {
    pub simd: S,
    lighting: &'v Lighting<'v>,
    /// The paths to the vertices.
    pub paths: &'v PathRecord<S>,
    pub bsdf: &'v Bsdf<'v, S>,
    receivers: &'v Receivers<'v, S>,
    sampler: &'v LightSampler<'v, S>,
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
            directions: [false, true].map(|has_lune| f64::from(directions(table, lights, has_lune))),
            filter,
            has_lunes: world.materials.has_normals && table.has_skies(),
            world,
        }
    }

    /// Shades the hits of paths, and calls `does` with their vertices. `camera`: what has sent the rays, if these are camera
    /// rays.
    #[inline(always)]
    pub fn at_hits<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        paths: &PathRecord<S>,
        camera: Option<Viewer>,
        batch: &mut PathBatch,
        does: impl FnOnce(&mut Tracer, &Vertices<S>, &mut PathBatch),
    ) {
        let mut slots = LobeSlots::new();
        let views = camera.map(|of| paths.views(of, &batch.camera_samples));
        let shaded = self.world.shaded(simd, tracer, paths, views.as_ref(), &mut slots);
        let Shaded { surfaces, frames, .. } = &shaded;
        let bsdf = &Bsdf::new(surfaces.n, surfaces.ns, *frames, -paths.rays.d, &mut slots);
        tracer.profile(|profiler| profiler.enter(Stage::Lights));
        let domain = bsdf.domain();
        let smooth = paths.active & bsdf.has(LobeFilter::NonDelta);
        let lunes = if self.has_lunes { Lunes::new(&domain, smooth) } else { None };
        let receivers = &Receivers { surfaces, domain, lunes };
        let sampler = &match self.samples {
            LightSamples::One(choice) => LightSampler::new(simd, self.table, choice, receivers),
            LightSamples::Each(_) => LightSampler::of_triangles(simd, self.table, receivers),
        };
        does(tracer, &Vertices { simd, lighting: self, paths, bsdf, receivers, sampler }, batch);
    }
}

impl<S: Simd> Vertices<'_, S> {
    /// The paths that go on along sampled directions. Their rays are not traced yet. The integrator sets what they carry.
    #[inline(always)]
    pub fn scattered(&self, sample: &BsdfSample<S>, active: mask64x8<S>) -> PathRecord<S> {
        let BsdfSample { is_valid, wi, pdf, weight, is_delta, .. } = *sample;
        PathRecord {
            active: active & is_valid,
            rays: self.receivers.surfaces.spawn_ray(wi),
            throughput: self.paths.throughput * weight,
            pdf,
            is_delta,
            ..PathRecord::new(self.simd, self.paths.rays, self.paths.samples, active)
        }
    }

    /// Direct light from light samples. Ends the profiler stage of lights.
    #[inline(never)]
    pub fn direct(&self, tracer: &mut Tracer, streams: &mut Streams, active: mask64x8<S>) -> Colors<S> {
        vectorized!(self.simd, {
            let light = match self.lighting.samples {
                LightSamples::One(_) => self.one_light(tracer, streams, active),
                LightSamples::Each(strategy) => self.each_light(tracer, streams, (strategy, active)),
            };
            tracer.profile(|profiler| profiler.enter(Stage::Scattering));
            light
        })
    }

    /// Direct light from one light, chosen at random. Surfaces without a light to sample use one more BSDF direction.
    #[inline(always)]
    fn one_light(&self, tracer: &mut Tracer, streams: &mut Streams, active: mask64x8<S>) -> Colors<S> {
        let Vertices { simd, lighting: Lighting { table, .. }, receivers, sampler, .. } = *self;
        let scattered = active & table.eligible_at(simd, receivers).simd_eq(0.0);
        let has_choice = sampler.has_choice() & active;
        let number = if has_choice.any_true() {
            streams.next_1d(simd)
        } else {
            streams.skip(1);
            0.0.simd_into(simd)
        };
        let chosen = sampler.choose(number, active & !scattered);
        let scattered = if table.len() > 0 { scattered } else { bits(simd, 0) };
        let u = streams.next_2d(simd);
        let mut found = Colors::splat(simd, Vec3::ZERO);
        if chosen.is_valid.any_true() {
            found = self.sampled_light(tracer, u, &chosen);
        }
        if scattered.any_true() {
            found = self.by_direction(tracer, u, scattered).keep_where_wide(scattered, found);
        }
        found
    }

    /// Direct light from all lights, with as many samples as the strategy says. BSDF directions replace lights that are not
    /// sampled.
    #[inline(never)]
    fn each_light(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        (strategy, active): (DirectStrategy, mask64x8<S>),
    ) -> Colors<S> {
        let Vertices { simd, lighting, receivers, .. } = *self;
        let table = lighting.table;
        vectorized!(simd, {
            let mut sum = Colors::splat(simd, Vec3::ZERO);
            let eligible = table.eligible_at(simd, receivers);
            for light in 0..table.len() {
                let (count, parts) = (table.samples(light, strategy), table.parts(light));
                let sampled = active & eligible.simd_gt(light as f64);
                let scattered = active & !sampled;
                // The samples of one part after those of another.
                for i in 0..u64::from(count) * u64::from(parts) {
                    if !tracer.should_continue() {
                        return sum;
                    }
                    let (part, k) = (i / u64::from(count), (i % u64::from(count)) as u32);
                    let u = if table.is_delta(light) {
                        [0.0.simd_into(simd); 2]
                    } else {
                        streams.nested_2d(simd, (count, k))
                    };
                    if sampled.any_true() {
                        let probability = f64::from(count).simd_into(simd);
                        let light = (light as f64).simd_into(simd);
                        let triangle = Some((part as f64).simd_into(simd));
                        let chosen = Chosen { is_valid: sampled, light, triangle, probability };
                        let own = self.sampled_light(tracer, u, &chosen);
                        sum = (sum + own).keep_where_wide(sampled, sum);
                    }
                    if scattered.any_true() {
                        let own = self.by_direction(tracer, u, scattered);
                        sum = (sum + own).keep_where_wide(scattered, sum);
                    }
                }
            }
            if lighting.chosen_triangles > 0 {
                sum = sum + self.chosen_triangles(tracer, streams, (lighting.chosen_triangles, active));
            }
            let most = most_samples(table, strategy);
            for k in 0..most {
                if !tracer.should_continue() {
                    return sum;
                }
                let u = streams.nested_2d(simd, (most, k));
                sum = sum + self.by_direction(tracer, u, active);
            }
            sum
        })
    }

    /// Direct light from `count` triangles, chosen among the lights with too many triangles to sample each.
    #[inline(never)]
    fn chosen_triangles(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        (count, active): (u32, mask64x8<S>),
    ) -> Colors<S> {
        let Vertices { simd, sampler, .. } = *self;
        vectorized!(simd, {
            let mut sum = Colors::splat(simd, Vec3::ZERO);
            for k in 0..count {
                if !tracer.should_continue() {
                    return sum;
                }
                let (number, u) = streams.nested_3d(simd, (count, k));
                let mut chosen = sampler.choose(number, active);
                chosen.probability *= f64::from(count);
                if chosen.is_valid.any_true() {
                    sum = sum + self.sampled_light(tracer, u, &chosen);
                }
            }
            sum
        })
    }

    /// The light found by one direction sampled from each BSDF.
    #[inline(never)]
    pub fn by_direction(&self, tracer: &mut Tracer, u: Vec2x8<S>, active: mask64x8<S>) -> Colors<S> {
        let Vertices { simd, lighting, bsdf, .. } = *self;
        vectorized!(simd, {
            let sample = bsdf.sample(u, lighting.filter);
            // What lies in single directions counts in full where the path goes on there.
            let scattered = self.scattered(&sample, active & !sample.is_delta);
            let light = self.found_light(tracer, &scattered);
            (sample.weight * light).keep_where_wide(scattered.active, Colors::splat(simd, Vec3::ZERO))
        })
    }

    /// The MIS-weighted light of one sample of each chosen light. The probabilities are the mean numbers of samples of the
    /// lights.
    #[inline(never)]
    fn sampled_light(&self, tracer: &mut Tracer, u: Vec2x8<S>, chosen: &Chosen<S>) -> Colors<S> {
        let Vertices { simd, lighting, bsdf, .. } = *self;
        vectorized!(simd, {
            let sample = self.sample(u, chosen);
            let (f_cos, pdf) = bsdf.f_cos_pdf(sample.shadow.d, lighting.filter);
            let reflected = f_cos * sample.li;
            let mut active = chosen.is_valid & sample.is_valid & reflected.is_light();
            active &= !lighting.world.occluded(simd, tracer, &sample.shadow, active, true);
            let is_sky = chosen.light.simd_ge(lighting.table.first_sky as f64);
            let other = pdf * self.directions();
            // Small probabilities and densities are no `f32`.
            let density = sample.pdf * chosen.probability;
            let weight = weights(is_sky, density, other);
            let share = sample.has_pdf.select(weight, 1.0.simd_into(simd)) / density;
            reflected.scaled(share).keep_where_wide(active, Colors::splat(simd, Vec3::ZERO))
        })
    }

    /// The number of BSDF directions at each surface.
    #[inline(always)]
    fn directions(&self) -> f64x8<S> {
        self.receivers.by_lune(self.simd, self.lighting.directions)
    }

    /// Samples the chosen lights.
    #[inline(always)]
    fn sample(&self, u: Vec2x8<S>, chosen: &Chosen<S>) -> LightSample<S> {
        let Vertices { simd, lighting, receivers: at, .. } = *self;
        let (mut rest, mut before) = (chosen.is_valid, None::<LightSample<S>>);
        loop {
            let light = chosen.light[rest.to_bitmask().trailing_zeros() as usize];
            let mut is_same = chosen.light.simd_eq(light);
            let number = light as usize;
            let is_alike = |lane: &usize| lighting.table.are_alike(number, chosen.light[*lane] as usize);
            let alike = set_lanes(rest & !is_same).filter(is_alike).fold(0, |alike, lane| alike | 1 << lane);
            let in_world = at.surfaces.instance.simd_eq(WORLD);
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

    /// The MIS-weighted light that rays find. Rays that cannot find an emitter are only tested for occlusion of the sky.
    #[inline(never)]
    pub fn found_light(&self, tracer: &mut Tracer, scattered: &PathRecord<S>) -> Colors<S> {
        let Vertices { simd, lighting: Lighting { world, table, .. }, .. } = *self;
        let PathRecord { rays, active, .. } = scattered;
        vectorized!(simd, {
            let mut found = Colors::splat(simd, Vec3::ZERO);
            let may_meet = tracer.scene.emitters.may_be_hit(simd, rays) & *active;
            if may_meet.any_true() {
                let hits = world.nearest(simd, tracer, rays, may_meet);
                found = self.light_of(tracer, &PathRecord { hits, active: may_meet, ..*scattered });
            }
            let rest = *active & !may_meet;
            if table.has_skies() && rest.any_true() {
                let is_free = rest & !world.occluded(simd, tracer, rays, rest, false);
                let escaped = PathRecord { hits: Hits::none(simd), active: is_free, ..*scattered };
                found = self.light_of(tracer, &escaped).keep_where_wide(is_free, found);
            }
            found
        })
    }

    /// The MIS-weighted light of the hits of paths.
    #[inline(never)]
    pub fn light_of(&self, tracer: &Tracer, scattered: &PathRecord<S>) -> Colors<S> {
        let Vertices { simd, lighting: Lighting { table, world, .. }, receivers, .. } = *self;
        let PathRecord { active, rays, hits, is_delta, .. } = scattered;
        vectorized!(simd, {
            let black = Colors::splat(simd, Vec3::ZERO);
            let mut found = black;
            let count = self.directions();
            let pdf = scattered.pdf * count;
            // What lies in single directions counts in full.
            let all = is_delta.select(1.0.simd_into(simd), count);
            let is_lit = hits.emits & *active;
            if is_lit.any_true() {
                let none: f64x8<S> = 0.0.simd_into(simd);
                let (mut light, mut density, mut of_light) = (none, none, 0);
                let (d, by_triangle) = (rays.d, self.by_triangle());
                let mut on_light = LightHits { is_valid: is_lit, d, p: d, n: d, triangle: none, by_triangle };
                for lane in set_lanes(is_lit) {
                    let (ray, Some(hit)) = world.one(rays, hits, lane) else { continue };
                    let surface = tracer.surface(&ray, &hit);
                    found.set_lane(lane, surface.le(-ray.d));
                    if let Some(number) = table.of_element(surface.element) {
                        of_light |= 1 << lane;
                        light[lane] = number as f64;
                        on_light.triangle[lane] = f64::from(surface.element.index);
                        on_light.p.set_lane(lane, surface.p);
                        on_light.n.set_lane(lane, surface.n);
                    }
                }
                for (lane, alike) in groups(of_light, |a, b| light[a] == light[b]) {
                    on_light.is_valid = bits(simd, alike);
                    let own = table.surface_pdf(simd, light[lane] as usize, receivers.surfaces, &on_light);
                    density = on_light.is_valid.select(own, density);
                }
                let triangle = on_light.triangle;
                let other = density * self.samples_of((light, triangle), is_lit);
                let weight = to_f32(weights(bits(simd, 0), pdf, other));
                found = (found * weight).keep_where_wide(!*is_delta, found);
            }
            let is_free = *active & !hits.is_hit();
            if table.has_skies() && is_free.any_true() {
                let mut sum = black;
                for sky in table.first_sky..table.len() {
                    let (radiance, density) = table.sky(simd, sky, receivers.lunes.as_ref(), rays.d);
                    // Most often nothing else finds it.
                    let weighed = density.simd_gt(0.0) & !*is_delta & is_free;
                    let mut own = radiance;
                    if weighed.any_true() {
                        let light = ((sky as f64).simd_into(simd), 0.0.simd_into(simd));
                        let other = density * self.samples_of(light, is_free);
                        let weight = to_f32(weights(bits(simd, 0xff), pdf, other));
                        own = (radiance * weight).keep_where_wide(weighed, radiance);
                    }
                    sum = sum + own;
                }
                found = sum.keep_where_wide(is_free, found);
            }
            found / to_f32(all)
        })
    }

    /// True if triangles of lights are chosen one by one.
    fn by_triangle(&self) -> bool {
        matches!(self.lighting.samples, LightSamples::Each(_)) || self.sampler.by_triangle()
    }

    /// The mean number of samples of lights or their triangles.
    #[inline(always)]
    fn samples_of(&self, (light, triangle): (f64x8<S>, f64x8<S>), active: mask64x8<S>) -> f64x8<S> {
        let Lighting { table, samples, chosen_triangles, .. } = self.lighting;
        match *samples {
            LightSamples::One(_) => self.sampler.probability((light, triangle), active),
            LightSamples::Each(strategy) => {
                let mut counts: f64x8<S> = f64::from(*chosen_triangles).simd_into(self.simd);
                if *chosen_triangles > 0 {
                    counts *= self.sampler.probability((light, triangle), active);
                }
                for lane in set_lanes(active) {
                    let number = light[lane] as usize;
                    if table.parts(number) > 0 {
                        counts[lane] = f64::from(table.samples(number, strategy));
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
