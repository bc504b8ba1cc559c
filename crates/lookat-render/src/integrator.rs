//! Integrators: the light along camera rays.

mod ambient;
pub(crate) mod direct;
mod lighting;
pub(crate) mod path;
mod paths;
mod tracer;
pub(crate) mod wave;
mod weighed;
mod world;

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use lookat_scene::Integrator;

use crate::bsdf::Lobes;
use crate::camera::lanes::Viewer;
use crate::lanes::LANES;
use crate::light::LightTable;
use crate::sampler::lanes::Streams;
use crate::trace::lanes::Rays;
use crate::traceable::Traceable;
pub(crate) use tracer::Tracer;
use wave::Wave;
use world::World;

/// What takes the samples of a scene.
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

    /// The world, and what it is made of.
    pub fn world(&self) -> &World<'s> {
        match self {
            SceneIntegrator::Path(path) => &path.world,
            SceneIntegrator::Direct(direct) => &direct.world,
            SceneIntegrator::Ambient(ambient) => &ambient.world,
        }
    }

    /// Takes the samples of camera rays: adds what they see to the radiance in the wave. `dimension`: how many numbers camera rays have
    /// taken.
    #[inline(always)]
    pub fn li<S: Simd, const LAMBERT: bool>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        (wave, lobes): (&mut Wave, &mut [Lobes; LANES]),
        (packets, samples): (&[Rays<S>], &[ArrayVec<u16, LANES>]),
        camera: (Viewer, u32),
    ) {
        let rays = (packets, samples);
        match self {
            SceneIntegrator::Path(path) => {
                path.begin(simd, tracer, rays, wave);
                path.follow::<_, LAMBERT>(simd, tracer, streams, (wave, lobes), camera);
            }
            SceneIntegrator::Direct(direct) => {
                direct.begin(simd, tracer, rays, wave);
                direct.follow::<_, LAMBERT>(simd, tracer, streams, (wave, lobes), camera);
            }
            SceneIntegrator::Ambient(ambient) => {
                ambient.begin(simd, tracer, rays, wave);
                ambient.follow(simd, tracer, streams, wave, camera.1);
            }
        }
    }
}

/// Numbers that are taken at each surface, and for what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draw {
    /// What they choose.
    pub of: &'static str,
    /// How many, at most.
    pub numbers: u32,
    /// The surfaces where they are, counted from 0.
    pub surfaces: Range<u32>,
}
