//! Direct lighting at the vertices of paths: samples of lights and of BSDFs (PBR 14.3).

use fearless_simd::{Simd, f32x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::Vec3;
use lookat_scene::DirectStrategy;

use super::bodies::Entrances;
use super::lighting::{Illumination, LightSamples, Lighting, most_samples};
use super::path_batch::{PathBatch, ShadowRays};
use super::path_record::PathRecord;
use super::profiler::Stage;
use crate::bsdf::{Bsdf, BsdfSample, Domain, LobeFilter, LobeSlots};
use crate::camera::Viewer;
use crate::integrator::world::Tracer;
use crate::light::{Chosen, Estimates, Lunes, Receivers, weights};
use crate::medium::{Media, Phase};
use crate::number::{Vec2x8, Vec3fx8, Vec3x8, bits, narrow, splat_f32, vectorized, widen};
use crate::ray::ElementId;
use crate::sampler::Streams;
use crate::shading::{Found, Shaded};
use crate::surface::Surfaces;
use crate::trace::rays::NONE;

/// Eight path vertices, with the state for direct lighting.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Vertices<'v, S: Simd> {
    pub illumination: Illumination<'v, S>,
    /// The paths to the vertices.
    pub paths: &'v PathRecord<S>,
    pub scattering: Scattering<'v, S>,
    /// The media inside and outside of the surfaces. In a medium, both are that.
    pub media: [u32x8<S>; 2],
    /// The bodies that light enters, if there are any.
    pub bodies: Option<&'v Entrances<S>>,
}

/// What scatters light at vertices.
#[derive(Clone, Copy)]
pub(in crate::integrator) enum Scattering<'v, S: Simd> {
    Surface(&'v Bsdf<'v, S>),
    Medium(Phase<S>),
}

impl<S: Simd> Scattering<'_, S> {
    /// What [`Bsdf::f_cos_pdf`] gives; of a phase function without a cosine.
    #[inline(always)]
    pub fn f_cos_pdf(&self, wi: Vec3fx8<S>, filter: LobeFilter) -> (Vec3fx8<S>, f32x8<S>) {
        match self {
            Scattering::Surface(bsdf) => bsdf.f_cos_pdf(wi, filter),
            Scattering::Medium(phase) => {
                let p = phase.p(wi);
                (Vec3fx8 { x: p, y: p, z: p }, p)
            }
        }
    }

    /// Samples directions.
    #[inline(always)]
    pub fn sample(&self, u: Vec2x8<S>, filter: LobeFilter) -> BsdfSample<S> {
        match self {
            Scattering::Surface(bsdf) => bsdf.sample(u, filter),
            Scattering::Medium(phase) => {
                let (simd, wi) = (u[0].token(), phase.sample(u));
                BsdfSample {
                    is_valid: bits(simd, 0xff),
                    wi: wi.widen(),
                    pdf: phase.p(wi),
                    weight: Vec3fx8::splat(simd, Vec3::ONE),
                    is_delta: bits(simd, 0),
                    radiance_scale: splat_f32(simd, 1.0),
                }
            }
        }
    }
}

impl Lighting<'_> {
    /// Shades the hits of paths, and calls `does` with their vertices. `camera`: what has sent the rays, if these are camera rays.
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
        let mut shaded = self.world.shaded(simd, tracer, paths, views.as_ref(), &mut slots);
        let bodies = if self.bodies.is_some() {
            Entrances::new(simd, &self.world.materials, paths, &mut shaded, slots.inside())
        } else {
            None
        };
        let wo = -paths.rays.d;
        self.at_surfaces(
            simd,
            tracer,
            (paths, wo),
            (&shaded, bodies.as_ref()),
            &mut slots,
            |tracer, vertices| {
                does(tracer, vertices, batch);
            },
        );
    }

    /// Calls `does` with vertices at surfaces that scatter light towards `wo`.
    #[inline(always)]
    pub fn at_surfaces<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        (paths, wo): (&PathRecord<S>, Vec3x8<S>),
        (shaded, bodies): (&Shaded<S>, Option<&Entrances<S>>),
        slots: &mut LobeSlots<S>,
        does: impl FnOnce(&mut Tracer, &Vertices<S>),
    ) {
        let Shaded { found: Found { surfaces, elements, .. }, frames, .. } = shaded;
        let surfaces = *surfaces;
        let bsdf = &Bsdf::new(surfaces.n, surfaces.ns, *frames, wo, slots);
        tracer.profile(|profiler| profiler.enter(Stage::Lights));
        let domain = bsdf.domain();
        let smooth = paths.active & bsdf.has(LobeFilter::NonDelta);
        let lunes = if self.has_lunes { Lunes::new(&domain, smooth) } else { None };
        let receivers = &Receivers { surfaces, domain, lunes };
        let mut estimates = Estimates::new();
        let sampler = &self.sampler(simd, receivers, &mut estimates);
        let illumination = Illumination { simd, lighting: self, receivers, sampler };
        let media = match &self.world.media {
            Some(media) => media.sides(elements, paths.medium, paths.active),
            None => [paths.medium; 2],
        };
        let scattering = Scattering::Surface(bsdf);
        does(tracer, &Vertices { illumination, paths, scattering, media, bodies });
    }

    /// Calls `does` with the points where paths scatter in media.
    #[inline(always)]
    pub fn in_media<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        media: &Media,
        paths: &PathRecord<S>,
        does: impl FnOnce(&mut Tracer, &Vertices<S>),
    ) {
        tracer.profile(|profiler| profiler.enter(Stage::Lights));
        let (p, zero) = (paths.rays.at(paths.hits.t), Vec3fx8::splat(simd, Vec3::ZERO));
        let (element, instance) = (NONE.simd_into(simd), ElementId::WORLD.simd_into(simd));
        // Without a normal, rays leave them without an offset.
        let ns = zero.widen();
        let (magnitude, time) = (p.magnitude(), paths.rays.time);
        let surfaces = Surfaces { p, n: zero, ns, magnitude, element, instance, time };
        let all = mask32x8::splat(simd, true);
        // Light comes from everywhere, and counts without a cosine.
        let domain = Domain { n: zero, ns: zero, is_two_sided: all, is_diffuse: !all };
        let receivers = &Receivers { surfaces, domain, lunes: None };
        let mut estimates = Estimates::new();
        let sampler = &self.sampler(simd, receivers, &mut estimates);
        let illumination = Illumination { simd, lighting: self, receivers, sampler };
        let asymmetry = f32x8::from_fn(simd, |lane| media.asymmetry(paths.medium[lane]));
        let scattering = Scattering::Medium(Phase { wo: (-paths.rays.d).narrow().normalize(), asymmetry });
        does(tracer, &Vertices { illumination, paths, scattering, media: [paths.medium; 2], bodies: None });
    }
}

impl<S: Simd> Vertices<'_, S> {
    /// The paths that go on along sampled directions. Their rays are not traced yet.
    #[inline(always)]
    pub fn scattered(&self, sample: &BsdfSample<S>, active: mask64x8<S>) -> PathRecord<S> {
        let BsdfSample { is_valid, wi, pdf, weight, is_delta, .. } = *sample;
        PathRecord {
            active: active & is_valid,
            rays: self.illumination.receivers.surfaces.spawn_ray(wi),
            throughput: self.paths.throughput * weight,
            pdf,
            is_delta,
            medium: self.medium_towards(wi),
            ..PathRecord::new(self.illumination.simd, self.paths.rays, self.paths.samples, active)
        }
    }

    /// The media that rays in directions `d` are in.
    #[inline(always)]
    fn medium_towards(&self, d: Vec3x8<S>) -> u32x8<S> {
        let [inside, outside] = self.media;
        // On the side where `spawn_ray` starts them.
        let is_outside = d.dot(self.illumination.receivers.surfaces.n.widen()).simd_gt(0.0);
        narrow(is_outside).select(outside, inside)
    }

    /// Samples direct light. Its rays are traced later. Ends the profiler stage of lights.
    #[inline(never)]
    pub fn direct(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        active: mask64x8<S>,
        batch: &mut PathBatch,
    ) {
        let Illumination { simd, lighting, .. } = self.illumination;
        vectorized!(simd, {
            match lighting.samples {
                LightSamples::One(_) => self.one_light(tracer, streams, active, batch),
                LightSamples::Each(strategy) => {
                    self.each_light(tracer, streams, (strategy, active), batch);
                }
            }
            tracer.profile(|profiler| profiler.enter(Stage::Scattering));
        });
    }

    /// Direct light from one light, chosen at random. Surfaces without a light to sample use one more BSDF direction.
    #[inline(always)]
    fn one_light(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        active: mask64x8<S>,
        batch: &mut PathBatch,
    ) {
        let Illumination { simd, lighting: Lighting { table, .. }, receivers, sampler } = self.illumination;
        let scattered = active & widen(table.eligible_at(simd, receivers).simd_eq(0));
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
        if chosen.is_valid.any_true() {
            self.sample_light(tracer, u, &chosen, batch);
        }
        if scattered.any_true() {
            self.by_direction(tracer, u, scattered, batch);
        }
    }

    /// Direct light from all lights, with as many samples as the strategy says. BSDF directions replace lights that are not
    /// sampled.
    #[inline(never)]
    fn each_light(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        (strategy, active): (DirectStrategy, mask64x8<S>),
        batch: &mut PathBatch,
    ) {
        let Illumination { simd, lighting, receivers, .. } = self.illumination;
        let table = lighting.table;
        vectorized!(simd, {
            let eligible = table.eligible_at(simd, receivers);
            for light in 0..table.len() {
                let (count, parts) = (table.samples(light, strategy), table.parts(light));
                let sampled = active & widen(eligible.simd_gt(light as u32));
                let scattered = active & !sampled;
                // The samples of one part after those of another.
                for i in 0..u64::from(count) * u64::from(parts) {
                    if !tracer.should_continue() {
                        return;
                    }
                    let (part, k) = (i / u64::from(count), (i % u64::from(count)) as u32);
                    let u = if table.is_delta(light) {
                        [0.0.simd_into(simd); 2]
                    } else {
                        streams.nested_2d(simd, (count, k))
                    };
                    if sampled.any_true() {
                        let probability = splat_f32(simd, count as f32);
                        let light = (light as u32).simd_into(simd);
                        let triangle = Some((part as u32).simd_into(simd));
                        let chosen = Chosen { is_valid: sampled, light, triangle, probability };
                        self.sample_light(tracer, u, &chosen, batch);
                    }
                    if scattered.any_true() {
                        self.by_direction(tracer, u, scattered, batch);
                    }
                }
            }
            if lighting.chosen_triangles > 0 {
                self.chosen_triangles(tracer, streams, (lighting.chosen_triangles, active), batch);
            }
            let most = most_samples(table, strategy);
            for k in 0..most {
                if !tracer.should_continue() {
                    return;
                }
                let u = streams.nested_2d(simd, (most, k));
                self.by_direction(tracer, u, active, batch);
            }
        });
    }

    /// Direct light from `count` triangles, chosen among the lights with too many triangles to sample each.
    #[inline(never)]
    fn chosen_triangles(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        (count, active): (u32, mask64x8<S>),
        batch: &mut PathBatch,
    ) {
        let Illumination { simd, sampler, .. } = self.illumination;
        vectorized!(simd, {
            for k in 0..count {
                if !tracer.should_continue() {
                    return;
                }
                let (number, u) = streams.nested_3d(simd, (count, k));
                let mut chosen = sampler.choose(number, active);
                chosen.probability *= count as f32;
                if chosen.is_valid.any_true() {
                    self.sample_light(tracer, u, &chosen, batch);
                }
            }
        });
    }

    /// Looks for light along one direction sampled from each BSDF.
    #[inline(never)]
    pub fn by_direction(
        &self,
        tracer: &mut Tracer,
        u: Vec2x8<S>,
        active: mask64x8<S>,
        batch: &mut PathBatch,
    ) {
        let (Illumination { simd, lighting, receivers, .. }, scattering) =
            (self.illumination, self.scattering);
        vectorized!(simd, {
            let sample = scattering.sample(u, lighting.filter);
            // What lies in single directions counts in full where the path goes on there.
            let mut active = active & !sample.is_delta;
            if let Some(bodies) = self.bodies {
                active &= !bodies.enters(sample.wi);
            }
            let scattered = self.scattered(&sample, active);
            lighting.look_for_emission((simd, tracer), &scattered, receivers, batch);
        });
    }

    /// Samples each of the chosen lights once, with MIS weights. The probabilities are the mean numbers of samples of the lights.
    #[inline(never)]
    fn sample_light(&self, tracer: &mut Tracer, u: Vec2x8<S>, chosen: &Chosen<S>, batch: &mut PathBatch) {
        let (Illumination { simd, lighting, .. }, scattering) = (self.illumination, self.scattering);
        vectorized!(simd, {
            let sample = self.illumination.sample(u, chosen);
            let (f_cos, pdf) = scattering.f_cos_pdf(sample.shadow.d.narrow(), lighting.filter);
            let reflected = f_cos * sample.li;
            let mut active = chosen.is_valid & sample.is_valid & reflected.is_light();
            if let Some(bodies) = self.bodies {
                active &= !bodies.enters(sample.shadow.d);
            }
            if !active.any_true() {
                return;
            }
            let is_sky = chosen.light.simd_ge(lighting.table.first_sky as u32);
            let other = pdf * self.illumination.directions();
            let density = sample.pdf * chosen.probability;
            let weight = weights(is_sky, density, other);
            let share = narrow(sample.has_pdf).select(weight, splat_f32(simd, 1.0)) / density;
            let PathRecord { throughput, samples, .. } = *self.paths;
            let light = throughput * (reflected * share);
            let medium = self.medium_towards(sample.shadow.d);
            let rays = ShadowRays { rays: sample.shadow, light, samples, medium };
            batch.push_shadow_rays(simd, (&lighting.world, tracer), &rays, active);
        });
    }
}
