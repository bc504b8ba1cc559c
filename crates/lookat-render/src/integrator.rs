//! Integrators: the light along camera rays.

mod ambient;
mod bodies;
pub(crate) mod direct;
mod in_media;
mod lighting;
pub(crate) mod path;
pub(crate) mod path_batch;
pub(crate) mod path_record;
mod profiler;
mod receiver_columns;
mod replay;
mod subsurface;
mod vertices;
pub(crate) mod world;

use std::ops::Range;

use fearless_simd::Simd;
use lookat_scene::Integrator;

use crate::bsdf::LobeFilter;
use crate::camera::Viewer;
pub(crate) use crate::integrator::replay::{Segment, segments, stage_profiles};
pub(crate) use crate::integrator::world::{Supervisor, Tracer};
use crate::light::LightTable;
use crate::sampler::{CAMERA_NUMBERS, Streams};
use crate::traceable::Traceable;
use bodies::Bodies;
use lighting::{LightSamples, Lighting};
use path_batch::{BatchSurface, PathBatch, ScatteredPaths};
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
                let bodies = Bodies::new(&world.materials, traceable);
                let mut lighting =
                    Lighting::new(world, lights, LightSamples::One(light_choice), LobeFilter::All);
                lighting.bodies = bodies;
                SceneIntegrator::Path(path::Paths { lighting, max_depth, roulette_threshold })
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
            SceneIntegrator::Path(path) => &path.lighting.world,
            SceneIntegrator::Direct(direct) => &direct.lighting.world,
            SceneIntegrator::Ambient(ambient) => &ambient.world,
        }
    }

    /// True if light may enter surfaces and leave them at other points.
    pub fn has_bodies(&self) -> bool {
        matches!(self, SceneIntegrator::Path(path) if path.lighting.bodies.is_some())
    }

    /// Adds the radiance along the camera rays of a batch, surface by surface. The radiance is incomplete once the tracer [is
    /// stopped](Tracer::is_stopped).
    #[inline(always)]
    pub fn li<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        batch: &mut PathBatch,
        camera: Viewer,
    ) {
        let (surfaces, numbers, sees) = match self {
            SceneIntegrator::Path(path) => (path.max_depth, path.numbers(), Sees::All),
            SceneIntegrator::Direct(direct) => (direct.surfaces(), direct.numbers(), Sees::Materials),
            SceneIntegrator::Ambient(_) => (1, 0, Sees::Nothing),
        };
        let world = self.world();
        let (ScatteredPaths { paths, .. }, radiance) = batch.branch(0);
        world.nearest_of_camera(simd, tracer, &paths.rays, paths.all(), &mut paths.hits);
        if let (SceneIntegrator::Path(path), Some(media)) = (self, &world.media) {
            paths.set_medium(media.of_camera);
            path.lighting.advance(simd, tracer, (streams, 0), media, batch);
        } else {
            world.add_emitted(simd, tracer, paths, sees, radiance);
            if surfaces > 0 {
                world.continue_paths(simd, tracer, paths, sees, radiance);
            }
        }
        if surfaces == 0 {
            return;
        }
        while let Some((depth, count)) = batch.begin_surface() {
            // Beyond 2^32, which takes a hundred thousand lights, dimensions repeat.
            let dimension = CAMERA_NUMBERS.wrapping_add(depth.wrapping_mul(numbers));
            let camera = (depth == 0).then_some(camera);
            let surface = BatchSurface { depth, count, dimension, camera };
            match self {
                SceneIntegrator::Path(path) => path.surface(simd, tracer, streams, surface, batch),
                SceneIntegrator::Direct(direct) => direct.surface(simd, tracer, streams, surface, batch),
                SceneIntegrator::Ambient(ambient) => ambient.surface(simd, tracer, streams, surface, batch),
            }
            if tracer.is_stopped {
                return;
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
