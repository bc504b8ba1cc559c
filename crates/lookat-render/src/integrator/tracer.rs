//! Tracing, with a count of rays.

use glam::Vec3;

use crate::light::LightTable;
use crate::ray::{Hit, Ray};
use crate::surface::Surface;
use crate::trace::StreamSize;
use crate::traceable::Traceable;

/// The most surfaces without a material that a ray passes through in a row.
pub(super) const MAX_PASSED: u32 = 1000;

/// Traces rays and counts them.
pub(crate) struct Tracer<'s> {
    pub(super) scene: &'s Traceable,
    lights: &'s LightTable,
    pub rays: u64,
    /// How many packets of camera rays go together.
    pub stream_size: StreamSize,
}

impl<'s> Tracer<'s> {
    pub fn new(scene: &'s Traceable, lights: &'s LightTable) -> Self {
        Tracer { scene, lights, rays: 0, stream_size: StreamSize::LARGEST }
    }

    pub fn lights(&self) -> &'s LightTable {
        self.lights
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
        let surface = self.surface(ray, hit);
        if glows || !surface.is_passed() { surface.le(-ray.d) } else { Vec3::ZERO }
    }

    /// Whether rays can find light: a sky, or a shape that emits.
    pub fn may_find_light(&self) -> bool {
        self.lights.has_skies() || !self.scene.emitters.is_empty()
    }
}
