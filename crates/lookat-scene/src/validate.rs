//! Whether a scene built in code keeps the promises of a scene.

mod material;
mod texture;

use std::error::Error;
use std::fmt;
use std::ops::RangeInclusive;

use crate::filter::{ALPHA_RANGE, MITCHELL_RANGE, RADIUS_RANGE, TAU_RANGE};
use crate::{
    Camera, Curve, CurveKind, Film, Filter, FilterKind, Integrator, Lens, Light, MAX_PIXELS, Primitive,
    Projection, Quadric, QuadricForm, Sampler, SamplerKind, Scene, Shape, Transform,
};
use material::{has_textures, is_material};
use texture::is_texture;

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
        self.view_faults(&mut found);
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

    fn view_faults(&self, found: &mut Vec<Invalid>) {
        let view = &self.view;
        found.check(is_placed(&view.camera.world_from_camera), "view.camera.world_from_camera", NO_TRANSFORM);
        found.check(is_camera(&view.camera), "view.camera", "its numbers are out of range");
        found.check(is_film(&view.film), "view.film", "its size, crop window or limits are out of range");
        found.check(is_filter(&view.filter), "view.filter", "its numbers are out of range");
        found.check(
            is_sampler(&view.sampler),
            "view.sampler",
            "there are no samples, or not as many as cells",
        );
        let is_right = match view.integrator {
            Integrator::Path { roulette_threshold, .. } => roulette_threshold.is_finite(),
            Integrator::DirectLighting { .. } => true,
            Integrator::AmbientOcclusion { samples, .. } => samples > 0,
        };
        found.check(is_right, "view.integrator", "its threshold is not finite, or it has no samples");
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

fn is_camera(camera: &Camera) -> bool {
    let has_angle = match camera.projection {
        Projection::Perspective { fov } => fov > 0.0 && fov < 180.0,
        Projection::Orthographic { .. } | Projection::Environment => true,
    };
    let size = camera.screen.max - camera.screen.min;
    let has_lens = |lens: Lens| is_length(lens.radius) && is_length(lens.focal_distance);
    has_angle && size.is_finite() && size.x != 0.0 && size.y != 0.0 && camera.lens.is_none_or(has_lens)
}

fn is_sampler(sampler: &Sampler) -> bool {
    let has_cells = match sampler.kind {
        SamplerKind::Stratified { cells: [across, down], .. } => {
            across > 0 && across.checked_mul(down).is_some_and(|cells| cells >= sampler.samples_per_pixel)
        }
        SamplerKind::Random | SamplerKind::Halton { .. } | SamplerKind::Sobol => true,
    };
    has_cells && sampler.samples_per_pixel > 0
}

fn is_length(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

fn is_film(film: &Film) -> bool {
    let (crop, [width, height]) = (film.crop, film.resolution);
    let has_pixels = crop.x0 < crop.x1 && crop.x1 <= width && crop.y0 < crop.y1 && crop.y1 <= height;
    has_pixels && crop.area() <= MAX_PIXELS && film.scale.is_finite() && film.max_sample_luminance > 0.0
}

fn is_filter(filter: &Filter) -> bool {
    let has_shape = match filter.kind {
        FilterKind::Box | FilterKind::Triangle => true,
        FilterKind::Gaussian { alpha } => ALPHA_RANGE.contains(alpha),
        FilterKind::Mitchell { b, c } => [b, c].iter().all(|x| MITCHELL_RANGE.contains(*x)),
        FilterKind::Sinc { tau } => TAU_RANGE.contains(tau),
    };
    has_shape && filter.radius.to_array().iter().all(|x| RADIUS_RANGE.contains(*x))
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

/// The depths of splits that [`Curve`] allows.
const SPLITS: RangeInclusive<u32> = 0..=5;

fn is_curve(curve: &Curve) -> bool {
    let [first, last] = curve.widths;
    let has_normals = match &curve.kind {
        CurveKind::Flat | CurveKind::Cylinder => true,
        CurveKind::Ribbon(normals) => {
            normals.len() == curve.segments.len() + 1 && normals.iter().all(|n| n.is_normalized())
        }
    };
    has_normals
        && !curve.segments.is_empty()
        && curve.segments.as_flattened().iter().all(|p| p.is_finite())
        && SPLITS.contains(&curve.split_depth)
        && first >= 0.0
        && last >= 0.0
        && is_length(first + last)
        && is_placed(&curve.world_from_object)
}

fn is_quadric(quadric: &Quadric) -> bool {
    let Quadric { form, phi_max, world_from_object } = *quadric;
    let has_form = match form {
        QuadricForm::Sphere(f) => -f.radius <= f.z_min && f.z_min < f.z_max && f.z_max <= f.radius,
        QuadricForm::Disk(f) => f.height.is_finite() && 0.0 <= f.inner_radius && f.inner_radius < f.radius,
        QuadricForm::Cylinder(f) => f.radius > 0.0 && f.z_min < f.z_max,
        QuadricForm::Cone(f) => f.radius > 0.0 && f.height > 0.0,
        QuadricForm::Paraboloid(f) => f.radius > 0.0 && f.z_min < f.z_max && f.z_max > 0.0,
        QuadricForm::Hyperboloid(f) => f.p1.z != f.p2.z && f.p2.z != 0.0,
    };
    let (low, high) = quadric.corners();
    let has_size = low.is_finite() && high.is_finite() && high.x > 0.0;
    has_form && has_size && phi_max > 0.0 && phi_max <= std::f64::consts::TAU && is_placed(&world_from_object)
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
        Light::Environment { ref map, scale, world_from_light, light_from_world, samples } => {
            let spaces = world_from_light.is_finite() && light_from_world.is_finite();
            map.mean().is_finite() && scale.is_finite() && spaces && samples > 0
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
