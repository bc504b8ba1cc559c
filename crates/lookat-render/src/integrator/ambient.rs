//! Ambient occlusion, like pbrt-v3's AOIntegrator.

use std::f32::consts::PI;

use fearless_simd::Simd;

use crate::bsdf::LobeSlots;
use crate::frame::Frames;
use crate::integrator::path_batch::{BatchSurface, PathBatch, ShadowRays};
use crate::integrator::path_record::PathRecord;
use crate::integrator::world::{Tracer, World};
use crate::number::{Vec3fx8, splat_f32, to_f32, vectorized};
use crate::sampler::Streams;
use crate::warp::{
    square_to_cosine_hemisphere, square_to_uniform_hemisphere, square_to_uniform_hemisphere_pdf,
};

/// A scene with ambient occlusion.
pub(crate) struct Ambient<'s> {
    pub(in crate::integrator) world: World<'s>,
    pub cosine: bool,
    pub samples: u32,
}

impl Ambient<'_> {
    /// Adds pi times the cosine-weighted share of the sky that the surfaces see.
    #[inline(never)]
    pub(super) fn surface<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        at: BatchSurface,
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            at.for_each_packet(
                simd,
                (&mut *tracer, streams, &mut *batch),
                #[inline(always)]
                |(tracer, streams, batch), paths| self.sample(simd, tracer, streams, paths, batch),
            );
            batch.trace_shadow_rays(simd, &self.world, tracer);
        });
    }

    /// Samples directions from a packet of surfaces.
    #[inline(never)]
    fn sample<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &PathRecord<S>,
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            let surfaces = self.world.plain(simd, paths, &mut LobeSlots::new()).found.surfaces;
            let frames = Frames::from_z(surfaces.n.face_forward(-paths.rays.d.narrow()));
            for k in 0..self.samples {
                if !tracer.should_continue() {
                    return;
                }
                let u = streams.nested_2d(simd, (self.samples, k)).map(
                    #[inline(always)]
                    |u| to_f32(u),
                );
                // The cosine over the density by solid angle.
                let (local, value) = if self.cosine {
                    (square_to_cosine_hemisphere(u), splat_f32(simd, PI))
                } else {
                    let local = square_to_uniform_hemisphere(u);
                    (local, local.z / square_to_uniform_hemisphere_pdf())
                };
                let rays = surfaces.spawn_ray(frames.to_world(local).normalize().widen());
                let value = value / self.samples as f32;
                let light = Vec3fx8 { x: value, y: value, z: value };
                let rays = ShadowRays { rays, light, samples: paths.samples, medium: paths.medium };
                batch.push_shadow_rays(simd, (&self.world, &mut *tracer), &rays, paths.active);
            }
        });
    }
}
