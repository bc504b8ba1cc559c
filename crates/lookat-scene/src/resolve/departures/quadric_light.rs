//! Quadrics that emit light. pbrt-v3 samples them with measures of object space (Sphere::Sample, Disk::Area, Cylinder::Area).

use std::f64::consts::TAU;

use super::Warn;
use super::scaling::Scaling;
use crate::shape::{Cylinder, Disk, Quadric, QuadricForm, Sphere};

const USE_MESH: &str = "use a mesh of the same shape: lookat and pbrt-v3 then agree";

impl Warn<'_> {
    /// `glows_inward`: one side emits, under a transformation that mirrors.
    pub(super) fn quadric_light(&mut self, name: &str, quadric: &Quadric, glows_inward: bool) {
        if let QuadricForm::Cone(_) | QuadricForm::Paraboloid(_) | QuadricForm::Hyperboloid(_) = quadric.form
        {
            self.push(
                &format!("pbrt-v3 aborts where a {name} emits light"),
                "use a sphere, disk, cylinder or mesh: it emits light in both programs",
            );
            return;
        }
        let scaling = Scaling::of(&quadric.world_from_object, &quadric.form);
        if counts_as_whole(quadric) {
            self.partial_light(name, &quadric.form, scaling);
        } else {
            self.scaled_light(name, &quadric.form, scaling);
        }
        if glows_inward {
            self.push(
                &format!("pbrt-v3 shows this mirrored {name} glowing inward but sends its light outward"),
                "leave out the mirroring Scale, or add \"bool twosided\" \"true\" to the AreaLightSource",
            );
        }
    }

    fn partial_light(&mut self, name: &str, form: &QuadricForm, scaling: Scaling) {
        let message = match (form, scaling) {
            (QuadricForm::Sphere(_), Scaling::Unchanged) => {
                "pbrt-v3 lights the surroundings with the whole sphere, not only with this part"
            }
            (_, Scaling::Unchanged) => "pbrt-v3 spreads the light of this part of a disk over the whole disk",
            _ => &format!("pbrt-v3 samples this {name} as if it were whole, and not scaled or sheared"),
        };
        self.push(message, "use a mesh of the part: lookat and pbrt-v3 then agree");
    }

    fn scaled_light(&mut self, name: &str, form: &QuadricForm, scaling: Scaling) {
        match (form, scaling) {
            (_, Scaling::Unchanged) => {}
            (_, Scaling::Uneven) => {
                let message =
                    format!("pbrt-v3 samples the light of this {name} as if it were not scaled or sheared");
                self.push(&message, USE_MESH);
            }
            (QuadricForm::Sphere(sphere), Scaling::Factor { length: Some(length), .. }) if length > 1.0 => {
                // pbrt-v3 ends shadow rays 1e-4 of their length before their target.
                let distance = rounded((length - 1.0) * sphere.radius * 1e4);
                let message = format!(
                    "pbrt-v3 samples this scaled {name} inside its surface: almost none of its light reaches surfaces within {distance} units"
                );
                self.push(&message, &without_scale(form, length));
            }
            (_, Scaling::Factor { length, area }) => {
                let factor = rounded(1.0 / area);
                let message = format!(
                    "pbrt-v3 samples this {name} with its unscaled size: the surroundings get about {factor} times the correct light"
                );
                let advice = length.map_or(USE_MESH.into(), |length| without_scale(form, length));
                let help = format!("{advice}; to keep the brightness of pbrt-v3, multiply L by {factor}");
                self.push(&message, &help);
            }
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
    let digits = 5 - value.abs().log10().floor().clamp(-300.0, 300.0) as i32;
    let power = 10.0_f64.powi(digits);
    let rounded = (value * power).round() / power;
    if rounded.is_finite() { rounded } else { value }
}
