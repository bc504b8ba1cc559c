//! Whether a scene built in code keeps the promises of a scene.

mod material;
mod shape;
mod texture;
mod view;

use std::error::Error;
use std::fmt;

use crate::{Light, Primitive, Scene, Shape, Transform};
use material::{has_textures, is_material};
use shape::{is_curve, is_quadric};
use texture::is_texture;
use view::view_faults;

/// A promise that a scene breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Invalid {
    /// The field, for example `world.primitives[2].shape`.
    pub field: String,
    /// What is wrong with it.
    pub message: &'static str,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: {}", self.field, self.message)
    }
}

impl Error for Invalid {}

impl Scene {
    /// Checks the promises of a scene, which one built in code may break: transformations are invertible, lengths and counts are
    /// positive where they must be, and numbers are finite, also inside of textures, except an unlimited
    /// `max_sample_luminance`. [`load`](crate::load()) gives only valid scenes. A renderer may show anything for a scene
    /// that is not valid.
    ///
    /// # Errors
    ///
    /// All broken promises.
    pub fn validate(&self) -> Result<(), Vec<Invalid>> {
        let mut found = Vec::new();
        view_faults(&self.view, &mut found);
        for (index, primitive) in self.world.primitives.iter().enumerate() {
            primitive_faults(primitive, &format!("world.primitives[{index}]"), &mut found);
        }
        for (index, instance) in self.world.instances.iter().enumerate() {
            let place = format!("world.instances[{index}]");
            found.check(is_placed(&instance.world_from_object), &place, NO_TRANSFORM);
            found.check(!instance.object.primitives.is_empty(), &place, "the object has no shapes");
            for (index, primitive) in instance.object.primitives.iter().enumerate() {
                primitive_faults(primitive, &format!("{place}.object.primitives[{index}]"), &mut found);
            }
        }
        for (index, light) in self.world.lights.iter().enumerate() {
            let is_right = is_light(light);
            found.check(is_right, &format!("world.lights[{index}]"), "its numbers are out of range");
        }
        if found.is_empty() { Ok(()) } else { Err(found) }
    }
}

const NO_TRANSFORM: &str = "the matrix or its inverse is not finite";

trait Faults {
    fn check(&mut self, is_right: bool, field: &str, message: &'static str);
}

impl Faults for Vec<Invalid> {
    fn check(&mut self, is_right: bool, field: &str, message: &'static str) {
        if !is_right {
            self.push(Invalid { field: field.to_owned(), message });
        }
    }
}

fn is_placed(transform: &Transform) -> bool {
    transform.matrix().is_finite() && transform.inverse_matrix().is_finite()
}

fn is_length(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

fn primitive_faults(primitive: &Primitive, place: &str, found: &mut Vec<Invalid>) {
    let is_right = match &primitive.shape {
        Shape::Quadric(quadric) => is_quadric(quadric),
        Shape::Curve(curve) => is_curve(curve),
        // Its constructors check it.
        Shape::TriangleMesh(_) => true,
    };
    found.check(is_right, &format!("{place}.shape"), "its numbers are out of range");
    let (material, field) = (&primitive.material, format!("{place}.material"));
    found.check(is_material(material), &field, "a color, an index or a part is out of range");
    found.check(has_textures(material), &field, "a number of a texture is out of range");
    let masks = primitive.cutout.iter().flat_map(|cutout| [&cutout.alpha, &cutout.shadow_alpha]);
    let is_right = masks.flatten().all(is_texture);
    found.check(is_right, &format!("{place}.cutout"), "a number of a texture is out of range");
    let is_light = primitive.emission.is_none_or(|light| light.radiance.is_finite() && light.samples > 0);
    found.check(is_light, &format!("{place}.emission"), "its numbers are out of range");
}

fn is_light(light: &Light) -> bool {
    match *light {
        Light::Point { position, intensity } => position.is_finite() && intensity.is_finite(),
        Light::Spot { position, light_from_world, intensity, cos_total_width, cos_falloff_start } => {
            let cosines = cos_total_width.is_finite() && cos_falloff_start.is_finite();
            position.is_finite() && light_from_world.is_finite() && intensity.is_finite() && cosines
        }
        Light::Distant { direction, radiance } => {
            (direction.length() - 1.0).abs() < 1e-9 && radiance.is_finite()
        }
        Light::Infinite { radiance, samples } => radiance.is_finite() && samples > 0,
        Light::Environment { ref map, scale, ref world_from_light, samples } => {
            let finite = map.mean().is_finite() && scale.is_finite();
            finite && is_placed(world_from_light) && samples > 0
        }
        Light::Goniometric { position, light_from_world, intensity, ref map } => {
            let finite = position.is_finite() && light_from_world.is_finite() && intensity.is_finite();
            finite && map.mean().is_finite()
        }
        Light::Projection { position, light_from_world, intensity, ref map, half_size } => {
            let finite = position.is_finite() && light_from_world.is_finite() && intensity.is_finite();
            let has_map = map.as_ref().is_none_or(|map| map.mean().is_finite());
            finite && has_map && half_size.min_element() > 0.0 && half_size.is_finite()
        }
    }
}

#[cfg(test)]
mod tests;
