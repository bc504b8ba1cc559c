//! Layers of the one point that is seen through the middle of a pixel.

use glam::{DVec2, DVec3};
use lookat_scene::View;

use super::{Layer, Values};
use crate::integrator::MAX_PASSED;
use crate::render::sample::{Context, corner_of};
use crate::shading;
use crate::surface::Surface;
use crate::view_facts::depth;

impl Context<'_> {
    /// Looks through the middle of a pixel and of the lens, for the first surface with a material.
    pub(super) fn look(&self, view: &View, place: [i32; 2], values: &mut Values) {
        let scene = &self.prepared.traceable;
        let mut ray = self.camera.ray(corner_of(place) + 0.5, DVec2::splat(0.5));
        let (mut found, mut passed) = (scene.nearest(&ray), 0);
        while let Some(hit) = found.filter(|hit| scene.is_passed(hit)) {
            ray = Surface::new(scene, &ray, &hit).leave(ray.d);
            passed += 1;
            found = if passed > MAX_PASSED { None } else { scene.nearest(&ray) };
        }
        let Some(hit) = found else { return };
        let surface = Surface::new(scene, &ray, &hit);
        let shape = hit.element.primitive;
        let material = self.integrator.world().materials.number(shape);
        let number = |number: u32| DVec3::X * (f64::from(number) + 1.0);
        values[Layer::Depth as usize].x = depth(view, surface.p - self.camera.eye);
        values[Layer::Position as usize] = surface.p + scene.origin;
        values[Layer::Uv as usize] = shading::uv(scene, &surface, (ray, hit)).extend(0.0);
        values[Layer::Shape as usize] = number(shape);
        values[Layer::Material as usize] = number(material);
    }
}
