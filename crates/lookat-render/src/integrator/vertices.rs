//! Direct lighting at the vertices of paths: samples of lights and of BSDFs (PBR 14.3).

use fearless_simd::{Simd, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::DirectStrategy;

use super::lighting::{Illumination, LightSamples, Lighting, most_samples};
use super::path_batch::PathBatch;
use super::path_record::PathRecord;
use super::profiler::Stage;
use crate::bsdf::{Bsdf, BsdfSample, LobeFilter, LobeSlots};
use crate::camera::Viewer;
use crate::integrator::world::Tracer;
use crate::light::{Chosen, LightSampler, Lunes, Receivers, weights};
use crate::number::{Colors, Vec2x8, bits, vectorized};
use crate::sampler::Streams;
use crate::shading::Shaded;
use crate::trace::rays::Rays;

/// Eight path vertices, with the state for direct lighting.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Vertices<'v, S: Simd> {
    pub illumination: Illumination<'v, S>,
    /// The paths to the vertices.
    pub paths: &'v PathRecord<S>,
    pub bsdf: &'v Bsdf<'v, S>,
}

/// Direct light before its shadow rays are traced.
pub(in crate::integrator) struct Unoccluded<S: Simd> {
    pub light: Colors<S>,
    pub shadow: Rays<S>,
    /// The lanes whose light a shadow ray has to reach.
    pub is_sampled: mask64x8<S>,
}

impl<'s> Lighting<'s> {
    /// Shades the hits of paths, calls `does` with their vertices, and returns their light sampler. `camera`: what has sent the rays, if
    /// these are camera rays.
    #[inline(always)]
    pub fn at_hits<S: Simd>(
        &'s self,
        simd: S,
        tracer: &mut Tracer,
        paths: &PathRecord<S>,
        camera: Option<Viewer>,
        batch: &mut PathBatch,
        does: impl FnOnce(&mut Tracer, &Vertices<S>, &mut PathBatch),
    ) -> LightSampler<'s, S> {
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
        let sampler = match self.samples {
            LightSamples::One(choice) => LightSampler::new(simd, self.table, choice, receivers),
            LightSamples::Each(_) => LightSampler::of_triangles(simd, self.table, receivers),
        };
        let illumination = Illumination { simd, lighting: self, receivers, sampler: &sampler };
        does(tracer, &Vertices { illumination, paths, bsdf }, batch);
        sampler
    }
}

impl<S: Simd> Vertices<'_, S> {
    /// The paths that go on along sampled directions. Their rays are not traced yet. The integrator sets what they carry.
    #[inline(always)]
    pub fn scattered(&self, sample: &BsdfSample<S>, active: mask64x8<S>) -> PathRecord<S> {
        let BsdfSample { is_valid, wi, pdf, weight, is_delta, .. } = *sample;
        PathRecord {
            active: active & is_valid,
            rays: self.illumination.receivers.surfaces.spawn_ray(wi),
            throughput: self.paths.throughput * weight,
            pdf,
            is_delta,
            ..PathRecord::new(self.illumination.simd, self.paths.rays, self.paths.samples, active)
        }
    }

    /// Direct light from light samples. Ends the profiler stage of lights.
    #[inline(never)]
    pub fn direct(&self, tracer: &mut Tracer, streams: &mut Streams, active: mask64x8<S>) -> Colors<S> {
        let Illumination { simd, lighting, .. } = self.illumination;
        vectorized!(simd, {
            let light = match lighting.samples {
                LightSamples::One(_) => self.one_light(tracer, streams, active),
                LightSamples::Each(strategy) => self.each_light(tracer, streams, (strategy, active)),
            };
            tracer.profile(|profiler| profiler.enter(Stage::Scattering));
            light
        })
    }

    /// Direct light from one light, chosen at random.
    #[inline(always)]
    fn one_light(&self, tracer: &mut Tracer, streams: &mut Streams, active: mask64x8<S>) -> Colors<S> {
        let Unoccluded { light, shadow, is_sampled } = self.one_light_unoccluded(tracer, streams, active);
        if !is_sampled.any_true() {
            return light;
        }
        let Illumination { simd, lighting, .. } = self.illumination;
        let occluded = lighting.world.occluded(simd, tracer, &shadow, is_sampled, true);
        Colors::splat(simd, Vec3::ZERO).keep_where_wide(occluded, light)
    }

    /// Direct light from one light, chosen at random, before its shadow rays are traced. Surfaces without a light to sample use one more
    /// BSDF direction.
    #[inline(always)]
    pub fn one_light_unoccluded(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        active: mask64x8<S>,
    ) -> Unoccluded<S> {
        let Illumination { simd, lighting: Lighting { table, .. }, receivers, sampler } = self.illumination;
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
        let mut found = Unoccluded {
            light: Colors::splat(simd, Vec3::ZERO),
            shadow: Rays::new(receivers.surfaces.p, receivers.surfaces.n),
            is_sampled: bits(simd, 0),
        };
        if chosen.is_valid.any_true() {
            self.sample_light(u, &chosen, &mut found);
        }
        if scattered.any_true() {
            found.light = self.by_direction(tracer, u, scattered).keep_where_wide(scattered, found.light);
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
        let Illumination { simd, lighting, receivers, .. } = self.illumination;
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
        let Illumination { simd, sampler, .. } = self.illumination;
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
        let (Illumination { simd, lighting, .. }, bsdf) = (self.illumination, self.bsdf);
        vectorized!(simd, {
            let sample = bsdf.sample(u, lighting.filter);
            // What lies in single directions counts in full where the path goes on there.
            let mut scattered = self.scattered(&sample, active & !sample.is_delta);
            let (mut seeing, mut hits) = ([scattered.active], [scattered.hits]);
            lighting.world.find_emission(simd, tracer, &[&scattered.rays], &mut seeing, &mut hits);
            [scattered.active] = seeing;
            [scattered.hits] = hits;
            let light = self.illumination.light_of(tracer, &scattered);
            (sample.weight * light).keep_where_wide(scattered.active, Colors::splat(simd, Vec3::ZERO))
        })
    }

    /// The MIS-weighted light of one sample of each chosen light. The probabilities are the mean numbers of samples of the
    /// lights.
    #[inline(never)]
    fn sampled_light(&self, tracer: &mut Tracer, u: Vec2x8<S>, chosen: &Chosen<S>) -> Colors<S> {
        let Illumination { simd, lighting, .. } = self.illumination;
        vectorized!(simd, {
            let black = Colors::splat(simd, Vec3::ZERO);
            let surfaces = self.illumination.receivers.surfaces;
            let shadow = Rays::new(surfaces.p, surfaces.n);
            let mut found = Unoccluded { light: black, shadow, is_sampled: bits(simd, 0) };
            self.sample_light(u, chosen, &mut found);
            let occluded = lighting.world.occluded(simd, tracer, &found.shadow, found.is_sampled, true);
            black.keep_where_wide(occluded, found.light)
        })
    }

    /// Does what [`Vertices::sampled_light`] does, before the shadow rays are traced.
    #[inline(never)]
    fn sample_light(&self, u: Vec2x8<S>, chosen: &Chosen<S>, found: &mut Unoccluded<S>) {
        let (Illumination { simd, lighting, .. }, bsdf) = (self.illumination, self.bsdf);
        vectorized!(simd, {
            let sample = self.illumination.sample(u, chosen);
            let (f_cos, pdf) = bsdf.f_cos_pdf(sample.shadow.d, lighting.filter);
            let reflected = f_cos * sample.li;
            let is_sampled = chosen.is_valid & sample.is_valid & reflected.is_light();
            let is_sky = chosen.light.simd_ge(lighting.table.first_sky as f64);
            let other = pdf * self.illumination.directions();
            // Small probabilities and densities are no `f32`.
            let density = sample.pdf * chosen.probability;
            let weight = weights(is_sky, density, other);
            let share = sample.has_pdf.select(weight, 1.0.simd_into(simd)) / density;
            found.light =
                reflected.scaled(share).keep_where_wide(is_sampled, Colors::splat(simd, Vec3::ZERO));
            found.shadow = sample.shadow;
            found.is_sampled = is_sampled;
        })
    }
}
