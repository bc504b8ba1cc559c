//! Quadrics that emit light. pbrt-v3 samples them with measures of object space (Sphere::Sample, Disk::Area, Cylinder::Area).

mod scaling;

use std::f64::consts::TAU;

use super::{Evidence, warn};
use crate::Shape;
use crate::report::Report;
use crate::shape::{Cylinder, Disk, Quadric, QuadricForm, Sphere};
use scaling::Scaling;

const USE_MESH: &str = "use a mesh of the same shape: lookat and pbrt-v3 then agree";

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for (primitive, emission, at) in evidence.shape_lights() {
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

/// How pbrt-v3 samples a quadric wrongly, and the way out.
fn sampling(quadric: &Quadric) -> Option<(String, String)> {
    let scaling = Scaling::of(&quadric.world_from_object, &quadric.form);
    match counts_as_whole(quadric) {
        true => Some(partial_light(&quadric.form, scaling)),
        false => scaled_light(&quadric.form, scaling),
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
