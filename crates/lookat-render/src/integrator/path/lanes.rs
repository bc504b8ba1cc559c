//! Paths side by side, of plain materials: those that go on are brought together at each surface.

mod wave;

use fearless_simd::{Simd, mask64x8};
use glam::Vec3;
use lookat_scene::Integrator;

use super::{FIRST_ROULETTE, roulette};
use crate::bsdf::lanes::Bsdfs;
use crate::camera::lanes::{Viewer, Views};
use crate::integrator::Tracer;
use crate::integrator::lanes::world::World;
use crate::integrator::weighed::lanes::{Directions, Lighting, Vertices};
use crate::lanes::{Colors, LANES, bits, first_lanes, those};
use crate::light::LightTable;
use crate::sampler::lanes::Streams;
use crate::shading::lanes::Shaded;
use crate::trace::lanes::Rays;
use crate::traceable::Traceable;
use wave::Paths;
pub(crate) use wave::{WAVE, Wave};

/// A scene whose paths are followed side by side.
pub(crate) struct Lanes<'s> {
    pub(in crate::integrator) world: World<'s>,
    lighting: Lighting<'s>,
    max_depth: u32,
    roulette_threshold: f64,
}

impl<'s> Lanes<'s> {
    /// `None` of scenes that have anything else.
    pub fn new(integrator: &Integrator, traceable: &'s Traceable, lights: &'s LightTable) -> Option<Self> {
        let Integrator::Path { max_depth, roulette_threshold, light_choice } = *integrator else {
            return None;
        };
        let world = World::new(traceable)?;
        let lighting = Lighting::new(lights, light_choice, world.has_normals())?;
        Some(Lanes { world, lighting, max_depth, roulette_threshold })
    }

    /// Begins paths with camera rays: those of the samples of these numbers.
    #[inline(always)]
    pub fn begin<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &Rays<S>,
        samples: &[u16],
        wave: &mut Wave,
    ) {
        let active = first_lanes(simd, samples.len());
        let hits = self.world.nearest(simd, tracer, rays, active, true);
        let is_hit = hits.is_hit() & active;
        for lane in those(active & !is_hit) {
            wave.radiance[usize::from(samples[lane])] = tracer.lights().background(rays.d.lane(lane));
        }
        for lane in those(hits.emits & active) {
            let surface = self.world.surface(tracer, rays, &hits, lane);
            let le = surface.map_or(Vec3::ZERO, |surface| surface.le(-rays.d.lane(lane)));
            wave.radiance[usize::from(samples[lane])] = le;
        }
        wave.push(simd, (rays, &hits), Colors::splat(simd, Vec3::ONE), samples, is_hit);
    }

    /// Follows paths that have begun to their ends; as [`super::li`] does, to the bit. `dimension`: how many numbers camera rays
    /// have taken.
    #[inline(always)]
    pub fn follow<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        wave: &mut Wave,
        (camera, dimension): (Viewer, u32),
    ) {
        // The choice of a light, the light, the direction; roulette.
        let numbers = 5 + u32::from(!roulette(self.max_depth).is_empty());
        for depth in 0..self.max_depth {
            let count = wave.begin_surface();
            if count == 0 {
                return;
            }
            for first in (0..count).step_by(LANES) {
                let paths = wave.take(simd, first, count.min(first + LANES));
                streams.choose(&paths.samples, dimension + depth * numbers);
                let camera = (depth == 0).then_some(camera);
                self.surface::<S, LAMBERT>(simd, tracer, streams, &paths, (camera, depth), wave);
            }
        }
    }

    /// What becomes of paths at a surface.
    #[inline(always)]
    fn surface<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &Paths<S>,
        (camera, depth): (Option<Viewer>, u32),
        wave: &mut Wave,
    ) {
        let Paths { rays, hits, samples, .. } = paths;
        let mut active = first_lanes(simd, samples.len());
        let views = camera.map(|of| Views { of, places: &wave.places, samples });
        let Shaded { surfaces, frames, coats, .. } =
            &self.world.shaded(simd, tracer, (rays, hits), views.as_ref(), active);
        let bsdfs: Bsdfs<S, LAMBERT> = Bsdfs::new(surfaces.n, frames, -rays.d, coats);
        let vertices = &Vertices { world: &self.world, rays, hits, surfaces, bsdfs: &bsdfs };
        active &= bsdfs.has_lobes();
        let light = self.lighting.one_light(simd, tracer, streams, vertices, active);
        wave.add(samples, paths.beta * light, active);
        let is_last = depth + 1 >= self.max_depth;
        if is_last && !tracer.may_find_light() {
            return;
        }
        let sample = bsdfs.sample(streams.next_2d(simd, active));
        active &= sample.is_there;
        let mut beta = paths.beta * sample.weight;
        let directions = Directions { rays: surfaces.leave(sample.wi), pdf: sample.pdf };
        if is_last {
            let light = self.lighting.found_light(simd, tracer, vertices, &directions, active);
            wave.add(samples, beta * light, active);
            return;
        }
        if !roulette(self.max_depth).is_empty() {
            active = self.roulette(simd, streams, &mut beta, depth, active);
        }
        let found = self.world.nearest(simd, tracer, &directions.rays, active, false);
        let light = self.lighting.light_of(simd, tracer, vertices, &directions, &found, active);
        wave.add(samples, beta * light, active);
        wave.push(simd, (&directions.rays, &found), beta, samples, active & found.is_hit());
    }

    /// Those that go on.
    #[inline(always)]
    fn roulette<S: Simd>(
        &self,
        simd: S,
        streams: &mut Streams,
        beta: &mut Colors<S>,
        depth: u32,
        active: mask64x8<S>,
    ) -> mask64x8<S> {
        let mut asked = 0;
        if depth + 1 > FIRST_ROULETTE {
            for lane in those(active) {
                let strength = f64::from(beta.lane(lane).max_element());
                asked |= u64::from(strength < self.roulette_threshold) << lane;
            }
        }
        let numbers = streams.next_1d(bits(simd, asked));
        let mut ended = 0;
        for lane in those(bits(simd, asked)) {
            let own = beta.lane(lane);
            let end = (1.0 - f64::from(own.max_element())).max(0.05);
            ended |= u64::from(numbers[lane] < end) << lane;
            beta.put(lane, own / (1.0 - end) as f32);
        }
        active & !bits(simd, ended)
    }
}
