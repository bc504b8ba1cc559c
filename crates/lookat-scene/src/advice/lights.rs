//! Advice about lights.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::Vec3;
use lookat_syntax::{Diagnostic, Span};

use crate::advice::{Summary, warn};
use crate::report::Report;
use crate::shape::{Cylinder, Disk, Quadric, QuadricForm, Sphere};
use crate::texture::Texture;
use crate::{Emission, Integrator, Light, Material, MaterialKind, Primitive, Shape, Transform};

pub(super) fn darkness(summary: &Summary, report: &mut Report) {
    let Some(integrator) = summary.integrator() else { return };
    if matches!(integrator, Integrator::AmbientOcclusion { .. }) {
        return;
    }
    let world = &summary.built.world;
    let emissions: Vec<&Emission> = summary.drawn.iter().filter_map(|it| it.emission.as_deref()).collect();
    let shows_emission_alone = matches!(integrator, Integrator::Path { max_depth: 0, .. });
    let (message, help) = if world.lights.is_empty() && emissions.is_empty() {
        let help = "add a light: LightSource \"infinite\" illuminates a scene from all directions";
        ("the scene has no lights: the picture is black", help)
    } else if world.lights.iter().all(Light::is_black) && emissions.iter().all(|emission| emission.is_black())
    {
        let help = "give them a color and a scale above 0";
        ("all lights of the scene are black: the picture is black", help)
    } else if shows_emission_alone && emissions.is_empty() && world.lights.iter().all(Light::is_delta) {
        let help = "write \"integer maxdepth\" 1 or more, so that surfaces are lit";
        ("maxdepth 0 shows only lights, and no light of the scene is visible: the picture is black", help)
    } else {
        return;
    };
    warn(report, summary.world(), message, help);
}

pub(super) fn caustics(summary: &Summary, report: &mut Report) {
    let Some(kind) = summary.resolved.and_then(|resolved| resolved.replaced_integrator.as_ref()) else {
        return;
    };
    let with = if summary.built.world.media.is_empty() { "path" } else { "volpath" };
    let message = format!("lookat renders Integrator \"{}\" with \"{with}\"", kind.value);
    let casts_caustics = summary.built.world.lights.iter().any(Light::is_delta)
        && summary.drawn.iter().any(|primitive| is_specular(&primitive.material));
    report.push(if casts_caustics { Diagnostic::warning(kind.span, message).help(
            "\"path\" does not find caustics of point, spot and distant lights; for caustics, use a shape with an AreaLightSource",
        ) } else { Diagnostic::note_at(kind.span, message).help("the picture is the same apart from its noise") });
}

/// True if a material has specular lobes, which reflect or refract light in single directions.
fn is_specular(material: &Material) -> bool {
    material.all().iter().any(|part| match &part.kind {
        MaterialKind::Mirror(_) | MaterialKind::Glass(_) | MaterialKind::Subsurface(_) => true,
        MaterialKind::Uber(uber) => {
            let is_black = |share: &Texture<Vec3>| share.constant() == Some(Vec3::ZERO);
            !is_black(&uber.kr) || !is_black(&uber.kt) || uber.opacity.constant() != Some(Vec3::ONE)
        }
        MaterialKind::None
        | MaterialKind::Disney(_)
        | MaterialKind::Hair(_)
        | MaterialKind::Fourier(_)
        | MaterialKind::Matte(_)
        | MaterialKind::Metal(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Plastic(_)
        | MaterialKind::Substrate(_)
        | MaterialKind::Translucent(_) => false,
    })
}

pub(super) fn hidden_lights(summary: &Summary, report: &mut Report) {
    let of_objects = summary.built.objects.iter().flat_map(|object| &object.primitives);
    for at in of_objects.filter(|primitive| primitive.light().is_some()).filter_map(|it| it.span) {
        let message = "an emissive shape inside an object is visible, but illuminates nothing: move it out of the object";
        report.unsupported(at, message.into());
    }
    let is_curve = |primitive: &&Primitive| matches!(primitive.shape, Shape::Curve(_));
    let emissive = || summary.built.world.primitives.iter().filter(|primitive| primitive.light().is_some());
    for at in emissive().filter(is_curve).filter_map(|primitive| primitive.span) {
        let message =
            "an emissive curve is visible, but illuminates nothing: use a mesh or a quadric as a light";
        report.unsupported(at, message.into());
    }
    if !summary.resolved.is_some_and(|resolved| resolved.passes_boundaries) {
        return;
    }
    let is_boundary = |primitive: &&&Primitive| matches!(primitive.material.kind, MaterialKind::None);
    let emissive = summary.drawn.iter().filter(|primitive| primitive.light().is_some());
    for at in emissive.filter(is_boundary).filter_map(|primitive| primitive.span) {
        let message = "in pbrt-v3, shadow rays pass through this emissive surface without a material, and only light samples find its light";
        let help = "write Material \"matte\" \"rgb Kd\" [0 0 0]: lookat and pbrt-v3 then agree";
        warn(report, at, message, help);
    }
}

pub(super) fn idle_lights(summary: &Summary, report: &mut Report) {
    // The AreaLightSource of each shape that emits light, and whether the shape can be drawn.
    let mut is_drawn: HashMap<Span, bool> = HashMap::new();
    for primitive in summary.built.all() {
        if let Some(at) = primitive.emission.as_ref().and_then(|emission| emission.span) {
            *is_drawn.entry(at).or_default() |= !primitive.shape.is_invisible();
        }
    }
    let idle = summary.facts.emissions.iter().filter(|at| is_drawn.get(at) != Some(&true));
    for (at, is_alone) in idle.map(|at| (*at, !is_drawn.contains_key(at))) {
        let (message, help) = if is_alone {
            (
                "no shape follows this AreaLightSource: it emits no light",
                "put it before the shape that emits light, in the same block",
            )
        } else {
            (
                "this AreaLightSource emits no light: none of its shapes can be drawn",
                "use a shape with an area",
            )
        };
        warn(report, at, message, help);
    }
}

// Meshes that emit light, where pbrt-v3 differs.

pub(super) fn mesh_lights(summary: &Summary, report: &mut Report) {
    for (primitive, emission, at) in summary.shape_lights() {
        let Shape::TriangleMesh(mesh) = &primitive.shape else { continue };
        if primitive.reverse_orientation && !emission.two_sided {
            if !mesh.normals().is_empty() {
                let message = "pbrt-v3 shows this reversed mesh glowing on one side but sends its light from the other, the side of \"N\"";
                warn(report, at, message, "remove ReverseOrientation: \"N\" decides the side that emits");
            } else if !mesh.tangents().is_empty() {
                let message = "pbrt-v3 shows this mesh with \"S\" glowing as if it had no ReverseOrientation, but sends its light from the reversed side";
                let help = "remove \"S\", or swap two corners of each triangle instead of ReverseOrientation";
                warn(report, at, message, help);
            }
        }
        if primitive.cutout.as_ref().is_some_and(|cutout| cutout.alpha.is_some()) {
            let help = "delete the triangles in the holes instead of hiding them with \"alpha\"";
            warn(report, at, "pbrt-v3 lights the surroundings from the holes of this mesh, too", help);
        }
    }
}

// `shadowalpha` with light of a sky or a shape. Light of point, spot and distant lights passes by the same amount in
// pbrt-v3 and lookat.

pub(super) fn shadow_alpha(summary: &Summary, report: &mut Report) {
    let world = &summary.built.world;
    let has_other = !world.lights.iter().all(Light::is_delta)
        || world.primitives.iter().any(|primitive| primitive.light().is_some());
    if let Some(at) = summary.facts.shadow_alpha.filter(|_| has_other) {
        let message = "light of skies and shapes passes \"shadowalpha\" only partly, and by different amounts in pbrt-v3 and lookat";
        warn(report, at, message, "to make holes for all light, use \"alpha\" instead");
    }
}

// Quadrics that emit light. pbrt-v3 samples them with measures of object space (Sphere::Sample, Disk::Area, Cylinder::Area).

const USE_MESH: &str = "use a mesh of the same shape: lookat and pbrt-v3 then agree";

pub(super) fn quadric_lights(summary: &Summary, report: &mut Report) {
    for (primitive, emission, at) in summary.shape_lights() {
        let Shape::Quadric(quadric) = &primitive.shape else { continue };
        let name = quadric.form.name();
        if let QuadricForm::Cone(_) | QuadricForm::Paraboloid(_) | QuadricForm::Hyperboloid(_) = quadric.form
        {
            let help = "use a sphere, disk, cylinder or mesh: it emits light in both programs";
            warn(report, at, format!("pbrt-v3 aborts where a {name} emits light"), help);
            continue;
        }
        if let Some((message, help)) = sampling(quadric) {
            warn(report, at, message, help);
        }
        if primitive.mirrored && !emission.two_sided {
            let message =
                format!("pbrt-v3 shows this mirrored {name} glowing inward but sends its light outward");
            let help = "remove the mirroring Scale, or add \"bool twosided\" \"true\" to the AreaLightSource";
            warn(report, at, message, help);
        }
    }
}

/// The message and help for a quadric that pbrt-v3 samples wrongly.
fn sampling(quadric: &Quadric) -> Option<(String, String)> {
    let scaling = Scaling::of(&quadric.world_from_object, &quadric.form);
    if counts_as_whole(quadric) {
        Some(partial_light(&quadric.form, scaling))
    } else {
        scaled_light(&quadric.form, scaling)
    }
}

fn partial_light(form: &QuadricForm, scaling: Scaling) -> (String, String) {
    let message = match (form, scaling) {
        (QuadricForm::Sphere(_), Scaling::Unchanged) => {
            "pbrt-v3 lights the surroundings with the whole sphere, not only with this part".into()
        }
        (_, Scaling::Unchanged) => {
            "pbrt-v3 spreads the light of this part of a disk over the whole disk".into()
        }
        _ => format!("pbrt-v3 samples this {} as if it were whole, and not scaled or sheared", form.name()),
    };
    (message, "use a mesh of the part: lookat and pbrt-v3 then agree".into())
}

fn scaled_light(form: &QuadricForm, scaling: Scaling) -> Option<(String, String)> {
    let name = form.name();
    match (form, scaling) {
        (_, Scaling::Unchanged) => None,
        (_, Scaling::Uneven) => {
            let message =
                format!("pbrt-v3 samples the light of this {name} as if it were not scaled or sheared");
            Some((message, USE_MESH.into()))
        }
        (QuadricForm::Sphere(sphere), Scaling::Factor { length: Some(length), .. }) if length > 1.0 => {
            // pbrt-v3 ends shadow rays 1e-4 of their length before their target.
            let distance = rounded((length - 1.0) * sphere.radius * 1e4);
            let message = format!(
                "pbrt-v3 samples this scaled {name} inside its surface: almost none of its light reaches surfaces within {distance} units"
            );
            Some((message, without_scale(form, length)))
        }
        (_, Scaling::Factor { length, area }) => {
            let factor = rounded(1.0 / area);
            let message = format!(
                "pbrt-v3 samples this {name} with its unscaled size: the surroundings get about {factor} times the correct light"
            );
            let advice = length.map_or(USE_MESH.into(), |length| without_scale(form, length));
            Some((message, format!("{advice}; to keep the brightness of pbrt-v3, multiply L by {factor}")))
        }
    }
}

/// True if pbrt-v3 samples the whole shape in place of this part. It samples parts of cylinders right.
fn counts_as_whole(quadric: &Quadric) -> bool {
    let is_cut = quadric.phi_max < TAU;
    match quadric.form {
        QuadricForm::Sphere(sphere) => {
            is_cut || sphere.z_min > -sphere.radius || sphere.z_max < sphere.radius
        }
        QuadricForm::Disk(disk) => is_cut || disk.inner_radius > 0.0,
        _ => false,
    }
}

/// The advice to scale the parameters of a whole shape by `length` instead of the shape.
fn without_scale(form: &QuadricForm, length: f64) -> String {
    let lengths = match *form {
        QuadricForm::Sphere(Sphere { radius, z_min, z_max })
        | QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }) => {
            vec![("radius", radius), ("zmin", z_min), ("zmax", z_max)]
        }
        QuadricForm::Disk(Disk { radius, height, .. }) => vec![("radius", radius), ("height", height)],
        _ => vec![],
    };
    let scaled = lengths.into_iter().filter(|(_, value)| *value != 0.0);
    let scaled = scaled.map(|(name, value)| format!("\"float {name}\" {}", rounded(length * value)));
    let (parameters, factor) = (scaled.collect::<Vec<_>>().join(" "), rounded(length));
    format!(
        "remove the scale, write {parameters}, and multiply each Translate after the scale by {factor}: lookat and pbrt-v3 then agree"
    )
}

/// A number with few digits, as people write it.
fn rounded(value: f64) -> f64 {
    let digits = 5 - libm::log10(value.abs()).floor().clamp(-300.0, 300.0) as i32;
    let power = 10.0_f64.powi(digits);
    let rounded = (value * power).round() / power;
    if rounded.is_finite() { rounded } else { value }
}

/// The change of the lengths and the area of a quadric.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scaling {
    /// No change that is visible.
    Unchanged,
    /// The area changes by a factor. So do lengths, where they all change by one factor.
    Factor { length: Option<f64>, area: f64 },
    /// The factor of the area is not the same everywhere.
    Uneven,
}

/// The largest relative change of lengths that counts as none: it changes the light by 0.2 %. Files often have matrices
/// with three to five digits.
const TOLERANCE: f64 = 1e-3;

/// The largest growth of a sphere that counts as none: a larger sphere may block its own samples, unless shadow rays end before its surface. In pbrt-v3 they
/// end 1e-4 of their length (ShadowEpsilon in core/pbrt.h) before their target.
const GROWTH: f64 = 1e-4;

impl Scaling {
    pub(super) fn of(world_from_object: &Transform, form: &QuadricForm) -> Self {
        if let Some(length) = world_from_object.uniform_scale(TOLERANCE) {
            let most = if matches!(form, QuadricForm::Sphere(_)) { GROWTH } else { TOLERANCE };
            return if length - 1.0 > -TOLERANCE && length - 1.0 < most {
                Scaling::Unchanged
            } else {
                Scaling::Factor { length: Some(length), area: length * length }
            };
        }
        if !matches!(form, QuadricForm::Disk(_)) {
            return Scaling::Uneven;
        }
        let [x, y, _] = world_from_object.axes();
        let area = x.cross(y).length();
        if (area - 1.0).abs() < 2.0 * TOLERANCE {
            Scaling::Unchanged
        } else {
            Scaling::Factor { length: None, area }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DMat4};

    use super::*;
    use crate::shape::{Disk, Sphere};

    const SPHERE: QuadricForm = QuadricForm::Sphere(Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0 });
    const DISK: QuadricForm = QuadricForm::Disk(Disk { height: 0.0, radius: 1.0, inner_radius: 0.0 });

    fn of(columns: [[f64; 3]; 3], form: &QuadricForm) -> Scaling {
        let matrix = DMat4::from_mat3(DMat3::from_cols_array_2d(&columns));
        Scaling::of(&Transform::from_matrix(matrix).unwrap(), form)
    }

    fn diagonal([x, y, z]: [f64; 3], form: &QuadricForm) -> Scaling {
        of([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]], form)
    }

    #[test]
    fn rounded_matrices_change_nothing() {
        for form in [SPHERE, DISK] {
            assert_eq!(diagonal([1.00002; 3], &form), Scaling::Unchanged);
            assert_eq!(diagonal([1.0, 1.0, 1.00002], &form), Scaling::Unchanged);
            for cos in [0.86603, 0.866] {
                let turned = [[cos, 0.5, 0.0], [-0.5, cos, 0.0], [0.0, 0.0, 1.0]];
                assert_eq!(of(turned, &form), Scaling::Unchanged);
            }
        }
    }

    #[test]
    fn a_sphere_that_grows_a_little_blocks_its_light() {
        assert!(matches!(diagonal([1.0005; 3], &SPHERE), Scaling::Factor { .. }));
        assert_eq!(diagonal([0.9995; 3], &SPHERE), Scaling::Unchanged);
        assert_eq!(diagonal([1.0005; 3], &DISK), Scaling::Unchanged);
    }

    #[test]
    fn the_area_of_a_disk_depends_on_its_plane_alone() {
        assert_eq!(diagonal([2.0, 3.0, 5.0], &DISK), Scaling::Factor { length: None, area: 6.0 });
        assert_eq!(diagonal([1.0, 1.0, 5.0], &DISK), Scaling::Unchanged);
        let sheared = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(of(sheared, &DISK), Scaling::Unchanged);
        assert_eq!(of(sheared, &SPHERE), Scaling::Uneven);
    }
}
