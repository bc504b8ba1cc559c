//! Integrators: the light along camera rays.

mod ambient;
pub(crate) mod direct;
mod lighting;
pub(crate) mod path;
pub(crate) mod path_batch;
mod profiler;
mod replay;
pub(crate) mod world;

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use lookat_scene::Integrator;

use crate::camera::Viewer;
pub(crate) use crate::integrator::replay::{Segment, segments, stage_profiles};
pub(crate) use crate::integrator::world::{MAX_PASSED, Supervisor, Tracer};
use crate::light::LightTable;
use crate::number::LANES;
use crate::sampler::{CAMERA_NUMBERS, Streams};
use crate::trace::rays::Rays;
use crate::traceable::Traceable;
use path_batch::PathBatch;
pub use profiler::StageProfile;
pub(crate) use profiler::{Profiler, Stage};
use world::{Sees, World};

/// The integrator of a scene.
pub(crate) enum SceneIntegrator<'s> {
    Path(path::Paths<'s>),
    Direct(direct::Direct<'s>),
    Ambient(ambient::Ambient<'s>),
}

impl<'s> SceneIntegrator<'s> {
    pub fn new(integrator: &Integrator, traceable: &'s Traceable, lights: &'s LightTable) -> Self {
        let world = World::new(traceable);
        match *integrator {
            Integrator::Path { max_depth, roulette_threshold, light_choice } => {
                let rest = (max_depth, roulette_threshold);
                SceneIntegrator::Path(path::Paths::new(world, lights, light_choice, rest))
            }
            Integrator::DirectLighting { strategy, max_depth } => {
                SceneIntegrator::Direct(direct::Direct::new(world, lights, strategy, max_depth))
            }
            Integrator::AmbientOcclusion { cosine, samples } => {
                SceneIntegrator::Ambient(ambient::Ambient { world, cosine, samples })
            }
        }
    }

    /// The world that the integrator traces rays in.
    pub fn world(&self) -> &World<'s> {
        match self {
            SceneIntegrator::Path(path) => &path.world,
            SceneIntegrator::Direct(direct) => &direct.world,
            SceneIntegrator::Ambient(ambient) => &ambient.world,
        }
    }

    /// Adds the radiance along camera rays to the batch, surface by surface. The radiance is incomplete once the tracer [is
    /// stopped](Tracer::is_stopped).
    #[inline(always)]
    pub fn li<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        batch: &mut PathBatch,
        rays: (&[Rays<S>], &[ArrayVec<u16, LANES>]),
        camera: Viewer,
    ) {
        let (surfaces, numbers, sees) = match self {
            SceneIntegrator::Path(path) => (path.max_depth, path::numbers(path.max_depth), Sees::All),
            SceneIntegrator::Direct(direct) => (direct.surfaces(), direct.numbers(), Sees::Materials),
            SceneIntegrator::Ambient(_) => (1, 0, Sees::Nothing),
        };
        self.world().start_paths(simd, tracer, rays, (surfaces > 0, sees), batch);
        while let Some((depth, count)) = batch.begin_surface() {
            for first in (0..count).step_by(LANES) {
                if !tracer.should_continue() {
                    return;
                }
                tracer.profile(|profiler| {
                    profiler.enter(Stage::Shading);
                    profiler.count(LANES.min(count - first) as u64);
                });
                let paths = batch.packet(simd, first, count.min(first + LANES));
                // Beyond 2^32, which takes a hundred thousand lights, dimensions repeat.
                let before = CAMERA_NUMBERS.wrapping_add(depth.wrapping_mul(numbers));
                streams.choose(simd, &paths.samples, before);
                let at = ((depth == 0).then_some(camera), depth);
                match self {
                    SceneIntegrator::Path(path) => {
                        path.surface(simd, tracer, streams, &paths, at, batch);
                    }
                    SceneIntegrator::Direct(direct) => {
                        direct.surface(simd, tracer, streams, &paths, at, batch);
                    }
                    SceneIntegrator::Ambient(ambient) => {
                        ambient.surface(simd, tracer, streams, &paths, batch);
                    }
                }
            }
        }
    }
}

/// The sample dimensions that a path uses for one purpose at each surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleDimensions {
    /// The purpose, such as "light choice".
    pub purpose: &'static str,
    /// The most dimensions at each surface.
    pub count: u32,
    /// The surfaces of a path that use them, counted from 0.
    pub surfaces: Range<u32>,
}
