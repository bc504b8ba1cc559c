//! Whether a scene built in code keeps the promises of a scene.

mod material;
mod shape;
mod texture;
mod view;

use std::collections::HashSet;
use std::error::Error;
use std::fmt;
use std::sync::Arc;

use glam::Vec3;
use lookat_image::MipMap;

use crate::sampler::MOST_NESTED;
use crate::transform::in_range;
use crate::{Emission, Light, Primitive, Scene, Shape, color};
use material::{has_textures, is_bounded, is_material};
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

/// All promises that a scene breaks.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Faults(pub Vec<Invalid>);

impl Faults {
    fn check(&mut self, is_right: bool, field: &str, message: &'static str) {
        if !is_right {
            self.0.push(Invalid { field: field.to_owned(), message });
        }
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let lines: Vec<String> = self.0.iter().map(Invalid::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl Error for Faults {}

impl Scene {
    /// Checks the promises of a scene, which one built in code may break: transformations are invertible, lengths and counts are
    /// positive where they must be, numbers are finite, also inside of textures, and no number, count or nesting is above the
    /// limits that [`load`](crate::load()) has. `load` gives only valid scenes. With a scene that is not valid, a renderer may
    /// show anything, panic, run forever or exhaust the memory.
    ///
    /// # Errors
    ///
    /// All broken promises.
    pub fn validate(&self) -> Result<(), Faults> {
        let mut found = Faults::default();
        view_faults(&self.view, &mut found);
        let list = |primitives: &[Primitive], place: &str, found: &mut Faults| {
            for (index, primitive) in primitives.iter().enumerate() {
                primitive_faults(primitive, &format!("{place}primitives[{index}]"), found);
            }
        };
        list(&self.world.primitives, "world.", &mut found);
        let mut known = HashSet::new();
        for (index, instance) in self.world.instances.iter().enumerate() {
            let place = format!("world.instances[{index}]");
            found.check(instance.world_from_object.in_range(), &place, NO_TRANSFORM);
            found.check(!instance.object.primitives.is_empty(), &place, "the object has no shapes");
            if known.insert(Arc::as_ptr(&instance.object)) {
                list(&instance.object.primitives, &format!("{place}.object."), &mut found);
            }
        }
        for (index, light) in self.world.lights.iter().enumerate() {
            let is_right = is_light(light);
            found.check(is_right, &format!("world.lights[{index}]"), "its numbers are out of range");
        }
        if found.0.is_empty() { Ok(()) } else { Err(found) }
    }
}

const NO_TRANSFORM: &str = "the matrix or its inverse has entries that are not finite, or above 1e50";

/// True for a number of samples within a camera sample.
fn has_samples(samples: u32) -> bool {
    (1..=MOST_NESTED as u32).contains(&samples)
}

fn primitive_faults(primitive: &Primitive, place: &str, found: &mut Faults) {
    let is_right = match &primitive.shape {
        Shape::Quadric(quadric) => is_quadric(quadric),
        Shape::Curve(curve) => is_curve(curve),
        // Its constructors check it.
        Shape::TriangleMesh(_) => true,
    };
    found.check(is_right, &format!("{place}.shape"), "its numbers are out of range");
    let is_right = primitive.shape.is_mirrored().is_none_or(|is_mirrored| is_mirrored == primitive.mirrored);
    found.check(is_right, &format!("{place}.mirrored"), "the transformation of the shape says otherwise");
    let (material, field) = (&primitive.material, format!("{place}.material"));
    let is_visited = is_bounded(material);
    found.check(is_visited, &field, "a mix has too many parts");
    found.check(!is_visited || is_material(material), &field, "a color, an index or a part is out of range");
    found.check(!is_visited || has_textures(material), &field, TEXTURE);
    let masks = primitive.cutout.iter().flat_map(|cutout| [&cutout.alpha, &cutout.shadow_alpha]);
    found.check(masks.flatten().all(is_texture), &format!("{place}.cutout"), TEXTURE);
    let is_light = |light: Emission| color::is_in_range(light.radiance) && has_samples(light.samples);
    let is_right = primitive.emission.is_none_or(is_light);
    found.check(is_right, &format!("{place}.emission"), "its numbers are out of range");
}

const TEXTURE: &str = "a number of a texture is out of range, or it has too many parts";

fn is_light(light: &Light) -> bool {
    match *light {
        Light::Point { position, intensity } => {
            in_range(&position.to_array()) && color::is_in_range(intensity)
        }
        Light::Spot { ref world_from_light, intensity, cos_total_width, cos_falloff_start } => {
            let are_cosines =
                [cos_total_width, cos_falloff_start].iter().all(|cos| (-1.0..=1.0).contains(cos));
            are_cosines && world_from_light.in_range() && color::is_in_range(intensity)
        }
        Light::Distant { direction, radiance } => {
            (direction.length() - 1.0).abs() < 1e-9 && color::is_in_range(radiance)
        }
        Light::Infinite { radiance, samples } => color::is_in_range(radiance) && has_samples(samples),
        Light::Environment { ref map, scale, ref world_from_light, samples } => {
            is_map(map) && color::is_in_range(scale) && world_from_light.in_range() && has_samples(samples)
        }
        Light::Goniometric { ref world_from_light, intensity, ref map } => {
            is_map(map) && color::is_in_range(intensity) && world_from_light.in_range()
        }
        Light::Projection { ref world_from_light, intensity, ref map, half_size } => {
            let has_size = half_size.min_element() > 0.0 && half_size.is_finite();
            let is_placed = has_size && world_from_light.in_range();
            is_placed && color::is_in_range(intensity) && map.as_ref().is_none_or(|map| is_map(map))
        }
    }
}

/// True if no texel is negative, infinite or no number.
fn is_map(map: &MipMap<Vec3>) -> bool {
    map.mean().is_finite() && map.texels().iter().all(|texel| texel.min_element() >= 0.0)
}

#[cfg(test)]
mod tests;
