//! What all integrators share: tracing with a count of rays.

pub(crate) mod ambient;
pub(crate) mod direct;
pub(crate) mod lanes;
pub(crate) mod path;
mod weighed;

use std::ops::Range;

use glam::DVec3;

use crate::bsdf::{Bsdf, Lobes};
use crate::camera::CameraRay;
use crate::light::LightTable;
use crate::ray::{Hit, Ray};
use crate::shading;
use crate::surface::Surface;
use crate::trace::{BUNDLE, Form, Forms};
use crate::traceable::Traceable;

/// The most surfaces without a material that a ray passes through in a row.
pub(crate) const MAX_PASSED: u32 = 1000;

/// A ray from the camera, and what it has met.
pub(crate) struct FirstHit<'h> {
    pub camera_ray: &'h CameraRay<'h>,
    pub ray: &'h Ray,
    pub hit: Option<&'h Hit>,
}

/// Traces rays and counts them.
pub(crate) struct Tracer<'s> {
    scene: &'s Traceable,
    lights: &'s LightTable,
    pub rays: u64,
    /// How many bundles of rays are traced one by one, after one that did not stay together.
    apart: u32,
    /// How many of them there are left.
    apart_left: u32,
    /// What has been made of rays that are traced next.
    pub forms: Box<Forms>,
}

/// Bundles of rays are not tried again for longer.
const LONGEST_APART: u32 = 63;

impl<'s> Tracer<'s> {
    pub fn new(scene: &'s Traceable, lights: &'s LightTable) -> Self {
        Tracer { scene, lights, rays: 0, apart: 0, apart_left: 0, forms: Box::new(Forms::new()) }
    }

    pub fn lights(&self) -> &'s LightTable {
        self.lights
    }

    /// The nearest hit.
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.rays += 1;
        self.scene.nearest(ray)
    }

    /// The same, put where it is to be: large values are best not moved.
    pub fn find(&mut self, ray: &Ray, found: &mut Option<Hit>) {
        self.rays += 1;
        self.scene.find(ray, found);
    }

    /// The same of a ray of which a form has been made, that of `lane`.
    pub fn find_formed(&mut self, ray: &Ray, lane: usize, found: &mut Option<Hit>) {
        self.rays += 1;
        self.scene.find_formed(ray, Form { of: &self.forms, lane }, found);
    }

    /// Whether so many bundles of rays are to be traced as such; if not, they count as traced one by one.
    pub fn bundles(&mut self, count: u32) -> bool {
        let are_apart = self.apart_left >= count;
        self.apart_left -= if are_apart { count } else { 0 };
        self.scene.is_cheap && !are_apart
    }

    /// The nearest hits of rays that run side by side.
    pub fn nearest_of(&mut self, rays: &[Ray; BUNDLE]) -> [Option<Hit>; BUNDLE] {
        if self.apart_left > 0 {
            self.apart_left -= 1;
            return rays.each_ref().map(|ray| self.nearest(ray));
        }
        self.rays += BUNDLE as u64;
        let (hits, together) = self.scene.nearest_of(rays);
        // Neighbors mostly fare alike; so twice as long each time.
        self.apart = if together { 0 } else { LONGEST_APART.min(2 * self.apart + 1) };
        self.apart_left = self.apart;
        hits
    }

    /// The surface at a hit of `ray`. Apart from the search for it, because large values are best not moved.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'s> {
        Surface::new(self.scene, ray, hit)
    }

    /// How a surface scatters light towards `wo`. `camera_ray`: what has found it, if nothing lies between.
    #[inline]
    pub fn bsdf<'l>(
        &self,
        surface: &Surface<'s>,
        wo: DVec3,
        camera_ray: Option<&CameraRay>,
        lobes: &'l mut Lobes,
    ) -> Bsdf<'l> {
        shading::bsdf(self.scene, surface, wo, camera_ray, lobes)
    }

    /// Whether there is light that rays find: other than that of points and of single directions.
    pub fn may_find_light(&self) -> bool {
        self.lights.has_skies() || !self.scene.emitters.is_empty()
    }

    /// Whether a ray may meet what emits light.
    pub fn may_meet_emitter(&self, ray: &Ray) -> bool {
        self.scene.emitters.may_be_met(ray)
    }

    /// Whether what is hit emits light.
    pub fn emits(&self, hit: &Hit) -> bool {
        self.scene.emits(hit)
    }

    /// Whether a ray meets anything.
    pub fn meets(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.scene.meets(ray)
    }

    /// Whether something is in the way of a shadow ray.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        self.rays += 1;
        self.scene.occluded(ray)
    }

    /// The same of a ray of which a form has been made, that of `lane`.
    pub fn occluded_formed(&mut self, ray: &Ray, lane: usize) -> bool {
        self.rays += 1;
        self.scene.occluded_formed(ray, Form { of: &self.forms, lane })
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
