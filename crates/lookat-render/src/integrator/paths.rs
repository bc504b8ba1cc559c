//! Rays of paths, followed from one surface to the next.

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::Vec3;

use super::tracer::Tracer;
use super::world::{Sees, World};
use crate::integrator::wave::Wave;
use crate::number::{Colors, LANES, first_lanes, splat_f32, those, vectorized};
use crate::trace::MOST_PACKETS;
use crate::trace::rays::{Hits, Rays};

/// Rays with what they have hit, by what radiance along them is multiplied, and what the integrator keeps with their paths.
pub(crate) struct Found<S: Simd> {
    pub rays: Rays<S>,
    pub hits: Hits<S>,
    pub weight: (Colors<S>, f32x8<S>),
    /// Which of the directions from their surfaces these are, from 0.
    pub branch: usize,
}

impl World<'_> {
    /// Traces packets of camera rays, each for the samples of some numbers. Adds the light that they see. If paths go on, adds what they
    /// hit to the wave.
    #[inline(always)]
    pub fn begin<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        (packets, samples): (&[Rays<S>], &[ArrayVec<u16, LANES>]),
        (goes_on, sees): (bool, Sees),
        wave: &mut Wave,
    ) {
        let mut active: ArrayVec<mask64x8<S>, MOST_PACKETS> = ArrayVec::new();
        for samples in samples {
            active.push(first_lanes(simd, samples.len()));
        }
        let hits = self.nearest_of(simd, tracer, packets, &active);
        for (at, active) in active.iter().enumerate() {
            let weight = (Colors::splat(simd, Vec3::ONE), splat_f32(simd, 1.0));
            let found = &mut Found { rays: packets[at], hits: hits[at], weight, branch: 0 };
            self.see(simd, tracer, found, &samples[at], (*active, sees), wave);
            if goes_on {
                self.go_on(simd, tracer, found, &samples[at], (*active, *active, sees), wave);
            }
        }
    }

    /// Adds the light that rays see straight ahead.
    #[inline(always)]
    pub fn see<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        Found { rays, hits, weight, .. }: &Found<S>,
        samples: &[u16],
        (active, sees): (mask64x8<S>, Sees),
        wave: &mut Wave,
    ) {
        if sees == Sees::Nothing {
            return;
        }
        for lane in those(active & hits.emits) {
            if let (ray, Some(hit)) = self.one(rays, hits, lane) {
                let light = tracer.emitted(&ray, &hit, sees == Sees::All);
                wave.radiance[usize::from(samples[lane])] += weight.0.lane(lane) * light;
            }
        }
        let escaped = active & !hits.is_hit();
        if tracer.lights.has_skies() && escaped.any_true() {
            wave.add(samples, weight.0 * tracer.lights.background(simd, rays.d), escaped);
        }
    }

    /// Follows rays through surfaces without a material, and adds those that find one with a material to the wave. Where `is_full`, adds
    /// the light that rays see behind the first hit.
    #[inline(never)]
    pub fn go_on<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        Found { rays, hits, weight, branch }: &mut Found<S>,
        samples: &[u16],
        (active, is_full, sees): (mask64x8<S>, mask64x8<S>, Sees),
        wave: &mut Wave,
    ) {
        vectorized!(simd, {
            let mut passed = 0;
            if self.materials.has_passed {
                let add =
                    |lane, light| wave.radiance[usize::from(samples[lane])] += weight.0.lane(lane) * light;
                passed = self.pass(simd, tracer, rays, hits, (active, is_full, sees), add);
            }
            let goes_on = (active & hits.is_hit(), passed);
            wave.push(simd, (rays, hits), *weight, (samples, *branch), goes_on);
        })
    }
}
