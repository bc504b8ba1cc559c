//! Ambient occlusion, as pbrt-v3's AOIntegrator.

use std::f64::consts::PI;

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::Vec3;

use super::tracer::Tracer;
use crate::frame::lanes::Frames;
use crate::integrator::wave::{Taken, Wave};
use crate::integrator::world::World;
use crate::lanes::{first_lanes, those};
use crate::sampler::lanes::Streams;
use crate::warp::lanes::{square_to_cosine_hemisphere, square_to_uniform_hemisphere};
use crate::warp::square_to_uniform_hemisphere_pdf;

/// A scene with ambient occlusion.
pub(crate) struct Ambient<'s> {
    pub(in crate::integrator) world: World<'s>,
    pub cosine: bool,
    pub samples: u32,
}

impl Ambient<'_> {
    /// Adds pi times the share of the sky that surfaces see, weighed by the cosine.
    #[inline(never)]
    pub(super) fn surface<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &Taken<S>,
        wave: &mut Wave,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let active = first_lanes(simd, paths.samples.len());
                let surfaces = self.world.plain(simd, (&paths.rays, &paths.hits), active).surfaces;
                let n = (-surfaces.n).or(surfaces.n.dot(paths.rays.d).simd_gt(0.0), surfaces.n);
                let frames = Frames::from_z(n);
                let mut sum: f64x8<S> = 0.0.simd_into(simd);
                for k in 0..self.samples {
                    let u = streams.nested_2d(simd, active, (self.samples, k));
                    // The cosine over the density by solid angle.
                    let (local, value) = if self.cosine {
                        (square_to_cosine_hemisphere(u), PI.simd_into(simd))
                    } else {
                        let local = square_to_uniform_hemisphere(u);
                        (local, local.z / square_to_uniform_hemisphere_pdf())
                    };
                    let rays = surfaces.leave(frames.to_world(local));
                    let blocked = self.world.met(simd, tracer, &rays, (active, true));
                    sum = blocked.select(sum, sum + value);
                }
                let mean = sum / f64::from(self.samples);
                for lane in those(active) {
                    wave.radiance[usize::from(paths.samples[lane])] = Vec3::splat(mean[lane] as f32);
                }
            },
        )
    }
}
