//! Integrators, and what they share: tracing with a count of rays.

mod ambient;
pub(crate) mod direct;
mod lighting;
pub(crate) mod path;
mod paths;
pub(crate) mod wave;
mod weighed;
mod world;

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use glam::Vec3;
use lookat_scene::Integrator;

use crate::bsdf::Lobes;
use crate::camera::lanes::Viewer;
use crate::lanes::LANES;
use crate::sampler::lanes::Streams;
use crate::trace::lanes::Rays;
use wave::Wave;
use world::World;

use crate::light::LightTable;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;
use crate::trace::{Form, Forms, StreamSize};
use crate::traceable::Traceable;

/// The most surfaces without a material that a ray passes through in a row.
pub(crate) const MAX_PASSED: u32 = 1000;

/// Traces rays and counts them.
pub(crate) struct Tracer<'s> {
    scene: &'s Traceable,
    lights: &'s LightTable,
    pub rays: u64,
    /// How many packets of camera rays go together.
    pub stream_size: StreamSize,
    /// What has been made of rays that are traced next.
    pub forms: Box<Forms>,
}

impl<'s> Tracer<'s> {
    pub fn new(scene: &'s Traceable, lights: &'s LightTable) -> Self {
        Tracer { scene, lights, rays: 0, stream_size: StreamSize::LARGEST, forms: Box::new(Forms::new()) }
    }

    pub fn lights(&self) -> &'s LightTable {
        self.lights
    }

    /// The nearest hit.
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.scene.nearest(ray)
    }

    /// The same of a ray of which a form has been made, that of `lane`, put where it is to be.
    pub fn find_formed(&mut self, ray: &Ray, lane: usize, found: &mut Option<Hit>) {
        self.rays += 1;
        self.scene.find_formed(ray, Form { of: &self.forms, lane }, found);
    }

    /// The surface at a hit of `ray`. Apart from the search for it, because large values are best not moved.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'s> {
        Surface::new(self.scene, ray, hit)
    }

    /// What a ray sees straight ahead. `glows`: also what has no material.
    pub fn light_ahead(&self, ray: &Ray, hit: Option<&Hit>, glows: bool) -> Vec3 {
        let Some(hit) = hit else { return self.lights.background(ray.d) };
        let surface = self.surface(ray, hit);
        if glows || !surface.is_passed() { surface.le(-ray.d) } else { Vec3::ZERO }
    }

    /// Whether there is light that rays find: other than that of points and of single directions.
    pub fn may_find_light(&self) -> bool {
        self.lights.has_skies() || !self.scene.emitters.is_empty()
    }

    /// Whether what is hit emits light.
    pub fn emits(&self, hit: &Hit) -> bool {
        self.scene.emits(hit)
    }

    /// Whether something is in the way of a ray of which a form has been made, that of `lane`; of a shadow ray, if `is_shadow`.
    pub fn occluded_formed(&mut self, ray: &Ray, lane: usize, is_shadow: bool) -> bool {
        self.rays += 1;
        self.scene.occluded_formed(ray, Form { of: &self.forms, lane }, is_shadow)
    }
}

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
