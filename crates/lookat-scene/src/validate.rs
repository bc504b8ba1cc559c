//! Whether a scene built in code keeps the promises of a scene.

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::{DVec2, Vec3};
use lookat_image::MipMap;

use crate::camera::FOV;
use crate::integrator::LARGEST_DEPTH;
use crate::params::value::MOST_NESTED;
use crate::shape::Limits;
use crate::transform::in_range;
use crate::{
    AnimatedTransform, AnyTexture, Cells, Checkerboard, Curve, CurveKind, Dots, Emission, ImageFilter,
    Integrator, Light, MAX_SAMPLES, Mapping, Material, MaterialKind, Mix, Octaves, Primitive, Quadric,
    QuadricForm, SamplerKind, Scene, Shape, Shutter, Texture, Transform, Value, Varying, View, color,
};

/// A promise that a scene breaks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {message}")]
pub struct InvalidField {
    /// The field, for example `world.primitives[2].shape`.
    pub field: String,
    /// What is wrong with it.
    pub message: &'static str,
}

/// All promises that a scene breaks.
#[derive(Debug, Clone, Default, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.0.iter().map(InvalidField::to_string).collect::<Vec<_>>().join("\n"))]
pub struct InvalidScene(pub Vec<InvalidField>);

impl InvalidScene {
    fn check(&mut self, is_right: bool, field: &str, message: &'static str) {
        if !is_right {
            self.0.push(InvalidField { field: field.to_owned(), message });
        }
    }
}

impl Scene {
    /// Checks the promises of a scene, which one built in code may break: transformations are invertible, lengths and counts are
    /// positive where they must be, numbers are finite, also inside of textures, and no number, count or nesting is above the
    /// limits that [`load`](crate::load()) has. `load` gives only valid scenes. With a scene that is not valid, a renderer may
    /// show anything, panic, run forever or exhaust the memory.
    ///
    /// # Errors
    ///
    /// All broken promises.
    pub fn validate(&self) -> Result<(), InvalidScene> {
        let mut found = InvalidScene::default();
        view_faults(&self.view, &mut found);
        let is_medium =
            |medium: Option<u32>| medium.is_none_or(|index| (index as usize) < self.world.media.len());
        found.check(
            is_medium(self.world.camera_medium),
            "world.camera_medium",
            "the world has no such medium",
        );
        for (index, medium) in self.world.media.iter().enumerate() {
            found.check(medium.is_valid(), &format!("world.media[{index}]"), "its numbers are out of range");
        }
        let list = |primitives: &[Primitive], place: &str, found: &mut InvalidScene| {
            for (index, primitive) in primitives.iter().enumerate() {
                let place = format!("{place}primitives[{index}]");
                primitive_faults(primitive, &place, found);
                let is_right =
                    primitive.medium.is_none_or(|it| is_medium(it.inside) && is_medium(it.outside));
                found.check(is_right, &format!("{place}.medium"), "the world has no such medium");
            }
        };
        list(&self.world.primitives, "world.", &mut found);
        let mut known = HashSet::new();
        for (index, instance) in self.world.instances.iter().enumerate() {
            let place = format!("world.instances[{index}]");
            let motions = instance.motion.iter().flat_map(|motions| motions.iter());
            let mut transforms =
                motions.flat_map(AnimatedTransform::ends).chain([*instance.world_from_object]);
            found.check(transforms.all(|transform| transform.in_range()), &place, NO_TRANSFORM);
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

/// The number of samples within a camera sample.
const SAMPLES: RangeInclusive<u32> = 1..=MOST_NESTED as u32;

fn primitive_faults(primitive: &Primitive, place: &str, found: &mut InvalidScene) {
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
    // Others are not even visited: each level can double their number.
    if matches!(&material.kind, MaterialKind::Mix(mix) if mix.parts() > Mix::MOST) {
        found.check(false, &field, "a mix has too many parts");
    } else {
        let is_right = material.all().into_iter().all(is_material);
        found.check(is_right, &field, "a color, an index or a part is out of range");
        found.check(material.textures().all(are_textures), &field, TEXTURE);
    }
    found.check(primitive.masks().all(are_textures), &format!("{place}.cutout"), TEXTURE);
    let is_light = |light: &Emission| color::is_in_range(light.radiance) && SAMPLES.contains(&light.samples);
    let is_right = primitive.emission.as_deref().is_none_or(is_light);
    found.check(is_right, &format!("{place}.emission"), "its numbers are out of range");
}

const TEXTURE: &str = "a number of a texture is out of range, or it has too many parts";

fn is_light(light: &Light) -> bool {
    let has_samples = |samples: u32| SAMPLES.contains(&samples);
    let is_placed = match light {
        Light::Point { position, .. } => in_range(&position.to_array()),
        Light::Spot { world_from_light, cos_total_width, cos_falloff_start, .. } => {
            let are_cosines =
                [cos_total_width, cos_falloff_start].iter().all(|cos| (-1.0..=1.0).contains(*cos));
            are_cosines && world_from_light.in_range()
        }
        Light::Distant { direction, .. } => (direction.length() - 1.0).abs() < 1e-9,
        Light::Infinite { samples, .. } => has_samples(*samples),
        Light::Environment { world_from_light, samples, .. } => {
            world_from_light.in_range() && has_samples(*samples)
        }
        Light::Goniometric { world_from_light, .. } => world_from_light.in_range(),
        Light::Projection { world_from_light, half_size, .. } => {
            half_size.min_element() > 0.0 && half_size.is_finite() && world_from_light.in_range()
        }
    };
    is_placed && color::is_in_range(light.color()) && light.map().is_none_or(|map| is_map(map))
}

/// True if no texel is negative, infinite or no number.
fn is_map(map: &MipMap<Vec3>) -> bool {
    map.mean().is_finite() && map.texels().all(|texel| texel.min_element() >= 0.0)
}

/// Adds the promises that a view breaks.
fn view_faults(View { camera, film, filter, sampler, integrator }: &View, found: &mut InvalidScene) {
    const NUMBERS: &str = "its numbers are out of range";
    found.check(camera.world_from_camera.in_range(), "view.camera.world_from_camera", NO_TRANSFORM);
    let is_right = camera.motion.is_none_or(|motion| motion.ends().iter().all(Transform::in_range));
    found.check(is_right, "view.camera.motion", NO_TRANSFORM);
    let Shutter { open, close, transform_times: [start, end] } = camera.shutter;
    let is_right = in_range(&[open, close, start, end]) && open <= close && start < end;
    found.check(is_right, "view.camera.shutter", "its times are out of range or not in their order");
    let is_length = |x: f64| x > 0.0 && x.is_finite();
    let size = camera.screen.max - camera.screen.min;
    let has_screen = size.is_finite() && size.x != 0.0 && size.y != 0.0;
    let has_lens = camera.lens.is_none_or(|lens| is_length(lens.radius) && is_length(lens.focal_distance));
    let has_angle = camera.fov().is_none_or(|fov| FOV.range.contains(fov));
    let focus = camera.lens.map_or(0.0, |lens| lens.focal_distance);
    let has_lenses = camera.lens_system().is_none_or(|lenses| lenses.is_valid(focus));
    found.check(has_screen && has_lens && has_angle && has_lenses, "view.camera", NUMBERS);

    found.check(film.is_valid(), "view.film", "its size, crop window or limits are out of range");
    found.check(filter.is_valid(), "view.filter", NUMBERS);

    let has_cells = match sampler.kind {
        SamplerKind::Stratified { cells: [across, down], .. } => {
            across > 0 && across.checked_mul(down).is_some_and(|cells| cells >= sampler.samples_per_pixel)
        }
        SamplerKind::Random | SamplerKind::Sobol { .. } => true,
    };
    let is_right = has_cells && (1..=MAX_SAMPLES).contains(&sampler.samples_per_pixel);
    found.check(is_right, "view.sampler", "there are no samples, too many, or not as many as cells");

    let is_right = match *integrator {
        Integrator::Path { max_depth, roulette_threshold, .. } => {
            max_depth <= LARGEST_DEPTH as u32 && roulette_threshold.is_finite()
        }
        Integrator::DirectLighting { max_depth, .. } => max_depth <= LARGEST_DEPTH as u32,
        Integrator::AmbientOcclusion { samples, .. } => SAMPLES.contains(&samples),
    };
    found.check(is_right, "view.integrator", NUMBERS);
}

pub(super) fn is_curve(curve: &Curve) -> bool {
    let [first, last] = curve.widths;
    let has_normals = match &curve.kind {
        CurveKind::Flat | CurveKind::Cylinder => true,
        CurveKind::Ribbon(normals) => {
            normals.len() == curve.segments.len() + 1 && normals.iter().all(|n| n.is_normalized())
        }
    };
    has_normals
        && !curve.segments.is_empty()
        && curve.split_depth <= Curve::MOST_SPLITS
        && first >= 0.0
        && last >= 0.0
        && first + last > 0.0
        && curve.world_from_object.in_range()
        && curve.is_in_range()
}

fn is_quadric(quadric: &Quadric) -> bool {
    let Quadric { ref form, phi_max, ref world_from_object } = *quadric;
    let limits = Limits::new(world_from_object);
    let is_length = |x: f64| limits.lengths().contains(&x);
    let has_form = match form {
        QuadricForm::Sphere(f) => {
            is_length(f.radius) && -f.radius <= f.z_min && f.z_min < f.z_max && f.z_max <= f.radius
        }
        QuadricForm::Disk(f) => {
            let is_ring = 0.0 <= f.inner_radius && f.inner_radius < f.radius;
            is_length(f.radius) && is_ring && limits.contain(&[f.height])
        }
        QuadricForm::Cylinder(f) => {
            is_length(f.radius) && f.z_min < f.z_max && limits.contain(&[f.z_min, f.z_max])
        }
        QuadricForm::Cone(f) => is_length(f.radius) && is_length(f.height),
        QuadricForm::Paraboloid(f) => {
            let has_height = f.z_min < f.z_max && f.z_max > 0.0 && limits.contain(&[f.z_min, f.z_max]);
            is_length(f.radius) && has_height && f.is_curved()
        }
        QuadricForm::Hyperboloid(f) => {
            let is_off_axis = [f.p1, f.p2].iter().any(|p| p.truncate() != DVec2::ZERO);
            let are_near = [f.p1, f.p2].iter().all(|p| limits.contain(&p.to_array()));
            are_near && is_off_axis && f.p1.z != f.p2.z && f.p2.z != 0.0
        }
    };
    has_form && phi_max > 0.0 && phi_max <= TAU && world_from_object.in_range()
}

/// True if reflectances and indices of refraction that are constant are in range, without those of the parts of a mix.
fn is_material(material: &Material) -> bool {
    let kind = &material.kind;
    let is_share = |share: &Texture<Vec3>| share.constant().is_none_or(|color| color.min_element() >= 0.0);
    let is_surface = |part: &Arc<Material>| !matches!(part.kind, MaterialKind::None);
    (matches!(kind, MaterialKind::Metal(_)) || kind.colors().into_iter().all(is_share))
        && kind.index().and_then(Texture::constant).is_none_or(|index| index > 0.0)
        && !matches!(kind, MaterialKind::Mix(mix) if !mix.materials.iter().all(is_surface))
}

/// True if all numbers of a texture and of the textures below it are in range, and if those are not too many.
fn are_textures(texture: AnyTexture) -> bool {
    !texture.is_too_long()
        && texture.all().into_iter().all(|texture| match texture {
            AnyTexture::Numbers(texture) => is_texture(texture),
            AnyTexture::Colors(texture) => is_texture(texture),
        })
}

/// True if the numbers of a texture itself are in range.
fn is_texture<T: Value>(texture: &Texture<T>) -> bool {
    match texture {
        Texture::Constant(value) => value.is_finite(),
        Texture::Varying(node) => is_varying(node.texture()),
    }
}

/// True if the numbers of a texture itself are in range.
fn is_varying<T: Value>(varying: &Varying<T>) -> bool {
    let is_mapping = |mapping: &Mapping| match mapping {
        Mapping::Uv { scale, offset } => scale.is_finite() && offset.is_finite(),
        Mapping::Spherical { texture_from_world } | Mapping::Cylindrical { texture_from_world } => {
            texture_from_world.in_range()
        }
        Mapping::Planar { axes, offset } => axes.iter().all(|axis| axis.is_finite()) && offset.is_finite(),
    };
    let are_octaves = |Octaves { texture_from_world, count, roughness }: &Octaves| {
        let has_numbers = *count <= Octaves::MOST && Octaves::ROUGHNESS_RANGE.contains(*roughness);
        has_numbers && texture_from_world.in_range()
    };
    match varying {
        Varying::Scale(_) | Varying::Mix { .. } => true,
        Varying::ImageMap(image) => {
            let is_filter = match image.filter {
                ImageFilter::Trilinear => true,
                ImageFilter::Ellipse { max_anisotropy: most } => ImageFilter::ANISOTROPY_RANGE.contains(most),
            };
            is_filter && is_mapping(&image.mapping) && T::from_texel(image.map.mean()).is_finite()
        }
        Varying::Bilerp(bilerp) => {
            let mut corners = bilerp.corners.as_flattened().iter();
            is_mapping(&bilerp.mapping) && corners.all(|corner| corner.is_finite())
        }
        Varying::Uv(mapping)
        | Varying::Dots(Dots { mapping, .. })
        | Varying::Checkerboard(Checkerboard { cells: Cells::Plane { mapping, .. }, .. }) => {
            is_mapping(mapping)
        }
        Varying::Checkerboard(Checkerboard { cells: Cells::Space { texture_from_world }, .. })
        | Varying::Windy { texture_from_world } => texture_from_world.in_range(),
        Varying::Fbm(octaves) | Varying::Wrinkled(octaves) => are_octaves(octaves),
        Varying::Marble(marble) => {
            are_octaves(&marble.octaves) && marble.scale.is_finite() && marble.variation.is_finite()
        }
    }
}

#[cfg(test)]
mod tests;
