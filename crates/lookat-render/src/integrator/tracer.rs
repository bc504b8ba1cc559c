//! Tracing, with a count of rays.

use fearless_simd::{Simd, mask64x8};
use glam::Vec3;

use super::profiler::{Profiler, Stage};
use crate::light::LightTable;
use crate::number::count;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;
use crate::trace::StreamSize;
use crate::trace::rays::Rays;
use crate::traceable::Traceable;

/// The most surfaces without a material that a ray passes through in a row.
pub(crate) const MAX_PASSED: u32 = 1000;

/// Decides whether sampling goes on.
pub(crate) trait Supervisor: Sync {
    /// False once sampling stops.
    fn goes_on(&self) -> bool;
}

/// The calls of [`Tracer::goes_on`] between two questions: about a millisecond.
const STEPS: u32 = 1 << 10;

/// Traces rays and counts them.
pub(crate) struct Tracer<'s> {
    pub(super) scene: &'s Traceable,
    pub(super) lights: &'s LightTable,
    pub rays: u64,
    /// How many packets of camera rays go together.
    pub stream_size: StreamSize,
    /// Asked every [`STEPS`] steps.
    supervisor: Option<&'s dyn Supervisor>,
    steps: u32,
    /// True once sampling has been stopped: the samples of the current wave are not complete.
    pub is_stopped: bool,
    /// Set while the stages of a rendering are measured.
    pub profiler: Option<Box<Profiler>>,
}

impl<'s> Tracer<'s> {
    pub fn new(scene: &'s Traceable, lights: &'s LightTable) -> Self {
        Tracer {
            scene,
            lights,
            rays: 0,
            stream_size: StreamSize::LARGEST,
            supervisor: None,
            steps: 0,
            is_stopped: false,
            profiler: None,
        }
    }

    /// The same, but asks whether to go on.
    pub fn supervised(self, supervisor: &'s dyn Supervisor) -> Self {
        Tracer { supervisor: Some(supervisor), ..self }
    }

    /// False once sampling stops. Called for each packet of rays, because the rays of one sample may take minutes.
    #[inline(always)]
    pub fn goes_on(&mut self) -> bool {
        self.steps += 1;
        if self.steps >= STEPS {
            self.ask();
        }
        !self.is_stopped
    }

    #[cold]
    #[inline(never)]
    fn ask(&mut self) {
        self.steps = 0;
        self.is_stopped |= self.supervisor.is_some_and(|supervisor| !supervisor.goes_on());
    }

    /// Does something with the profiler, if there is one.
    #[inline(always)]
    pub fn profile(&mut self, does: impl FnOnce(&mut Profiler)) {
        if let Some(profiler) = &mut self.profiler {
            does(profiler);
        }
    }

    /// Counts the active rays before they are traced, and starts their stage.
    #[inline(always)]
    pub fn begin_rays<S: Simd>(&mut self, stage: Stage, rays: &[Rays<S>], active: &[mask64x8<S>]) {
        for active in active {
            self.rays += count(*active);
        }
        self.profile(|profiler| profiler.begin_rays(stage, rays, active));
    }

    /// The nearest hit.
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.scene.nearest(ray)
    }

    /// The surface at a hit of `ray`. Apart from the search for it, because large values are best not moved.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'s> {
        Surface::new(self.scene, ray, hit)
    }

    /// What a surface that a ray has hit emits towards it. `glows`: also what has no material.
    pub fn emitted(&self, ray: &Ray, hit: &Hit, glows: bool) -> Vec3 {
        let is_lit = self.scene.emits(hit) && (glows || !self.scene.is_passed(hit));
        if is_lit { self.surface(ray, hit).le(-ray.d) } else { Vec3::ZERO }
    }

    /// Whether rays can find light: a sky, or a shape that emits.
    pub fn may_find_light(&self) -> bool {
        self.lights.has_skies() || !self.scene.emitters.is_empty()
    }
}
