//! Warnings about shapes that pbrt-v3 renders otherwise. `docs/differences.md` lists all differences.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use lookat_syntax::{Diagnostic, Span, Text};

use super::Resolver;
use crate::report::Report;
use crate::shape::{Cylinder, Disk, Quadric, QuadricForm, Sphere};
use crate::{CurveKind, Mesh, Primitive, Shape, Transform};

/// Measures that differ by less are the same to pbrt-v3, whose numbers have 24 bits.
const TOLERANCE: f64 = 1e-5;

impl Resolver<'_> {
    /// Warns about a shape of the type at `name`.
    pub(super) fn warn_of_departures(&mut self, name: &Text, primitive: &Primitive) {
        let emission = primitive.emission.filter(|emission| !emission.is_black() && self.object.is_none());
        let warn = &mut Warn { report: &mut self.report, at: name.span };
        match &primitive.shape {
            Shape::Curve(curve) => {
                // A note: every curve has it, and no parameter makes both pictures equal.
                let message = "pbrt-v3 draws curves up to a twentieth of their width thinner where they bend, without shadows of surfaces closer than 3.5 widths";
                let note = Diagnostic::note_at(name.span, message);
                warn.report
                    .push(note.help("a high \"splitdepth\" makes the difference of the widths smaller"));
                if let CurveKind::Ribbon(normals) = &curve.kind
                    && normals.windows(2).any(|pair| pair[0] == pair[1])
                {
                    warn.push(
                        "pbrt-v3 may abort, or leave out parts, where successive normals of a ribbon are equal",
                        "turn one of the two normals by a thousandth",
                    );
                }
            }
            Shape::Quadric(quadric) if emission.is_some() => {
                let two_sided = emission.is_some_and(|emission| emission.two_sided);
                warn.quadric_light(&name.value, quadric, primitive.mirrored && !two_sided);
            }
            Shape::TriangleMesh(mesh) if emission.is_some() => {
                let two_sided = emission.is_some_and(|emission| emission.two_sided);
                warn.mesh_light(mesh, primitive.reverse_orientation && !two_sided);
                if primitive.cutout.as_ref().is_some_and(|cutout| cutout.alpha.is_some()) {
                    warn.push(
                        "pbrt-v3 lights the surroundings from the holes of this mesh, too",
                        "leave the triangles in the holes out of the mesh, instead of \"alpha\"",
                    );
                }
            }
            _ => {}
        }
        if primitive.cutout.as_ref().is_some_and(|cutout| cutout.shadow_alpha.is_some()) {
            self.shadow_alpha.get_or_insert(name.span);
        }
    }

    /// Light that has a direction only passes `shadowalpha` alike in both.
    pub(super) fn warn_of_shadow_alpha(&mut self) {
        let has_other = !self.lights.iter().all(crate::Light::is_delta)
            || self.primitives.iter().any(|primitive| primitive.emission.is_some());
        if let Some(at) = self.shadow_alpha.filter(|_| has_other) {
            Warn { report: &mut self.report, at }.push(
                "light of skies and shapes passes \"shadowalpha\" in part, in pbrt-v3 another part than here",
                "\"alpha\" makes holes for all light",
            );
        }
    }
}

/// Where warnings about a shape go.
struct Warn<'r> {
    report: &'r mut Report,
    at: Span,
}

impl Warn<'_> {
    fn push(&mut self, message: &str, help: &str) {
        self.report.push(Diagnostic::warning(self.at, message).help(help));
    }

    fn quadric_light(&mut self, name: &str, quadric: &Quadric, glows_inward: bool) {
        let is_part = quadric.phi_max < TAU;
        match quadric.form {
            QuadricForm::Cone(_) | QuadricForm::Paraboloid(_) | QuadricForm::Hyperboloid(_) => {
                let message = format!("pbrt-v3 aborts where a {name} emits light");
                self.push(&message, "a sphere, disk, cylinder or mesh emits light in both");
                return;
            }
            QuadricForm::Sphere(sphere)
                if is_part || sphere.z_min > -sphere.radius || sphere.z_max < sphere.radius =>
            {
                self.push(
                    "pbrt-v3 lights the surroundings with the whole sphere, of which this is a part",
                    "a mesh of the part lights the surroundings alike in both",
                );
            }
            QuadricForm::Disk(disk) if is_part || disk.inner_radius > 0.0 => self.push(
                "pbrt-v3 spreads the light of this part of a disk over the whole disk",
                "a mesh of the part lights the surroundings alike in both",
            ),
            _ => {}
        }
        if glows_inward {
            self.push(
                &format!("pbrt-v3 shows this mirrored {name} glow inward, and lets it light outward"),
                "leave out the mirroring Scale, or add \"bool twosided\" \"true\" to the AreaLightSource",
            );
        }
        self.scaled_light(name, quadric);
    }

    /// pbrt-v3 samples lights with measures of object space (Sphere::Sample, Disk::Area, Cylinder::Area).
    fn scaled_light(&mut self, name: &str, quadric: &Quadric) {
        let scale = Scaling::of(&quadric.world_from_object, &quadric.form);
        if scale == Scaling::Rigid {
            return;
        }
        let Scaling::Factor { length, area } = scale else {
            let message =
                format!("pbrt-v3 samples the light of this {name} as if it were not scaled or sheared");
            self.push(&message, "a mesh of the same form lights the surroundings alike in both");
            return;
        };
        let factor = rounded(1.0 / area);
        let (lines, blocked) = match quadric.form {
            QuadricForm::Sphere(Sphere { radius, .. }) => {
                (length.map(|length| format!("\"float radius\" {}", rounded(length * radius))), area > 1.0)
            }
            QuadricForm::Disk(Disk { radius, height, .. }) => {
                let lines = length.map(|length| {
                    let radius = format!("\"float radius\" {}", rounded(length * radius));
                    if height == 0.0 {
                        radius
                    } else {
                        format!("{radius} \"float height\" {}", rounded(length * height))
                    }
                });
                (lines, false)
            }
            QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }) => {
                let lines = length.map(|length| {
                    let [radius, low, high] = [radius, z_min, z_max].map(|measure| rounded(length * measure));
                    format!("\"float radius\" {radius} \"float zmin\" {low} \"float zmax\" {high}")
                });
                (lines, false)
            }
            _ => return,
        };
        let message = match blocked {
            true => format!(
                "pbrt-v3 samples this scaled {name} inside its surface: almost none of its light arrives"
            ),
            false => format!(
                "pbrt-v3 samples this {name} with its unscaled size: it lights the surroundings about {factor} times as bright"
            ),
        };
        let lines = match lines {
            Some(lines) => format!("write {lines} without the scale, and both agree"),
            None => "a mesh of the same form lights alike in both".into(),
        };
        let keep =
            if blocked { String::new() } else { format!("; L times {factor} keeps pbrt-v3's brightness") };
        self.push(&message, &(lines + &keep));
    }

    fn mesh_light(&mut self, mesh: &Mesh, reversed: bool) {
        if !reversed {
            return;
        }
        if !mesh.normals.is_empty() {
            self.push(
                "pbrt-v3 shows this reversed mesh glow on one side, and light from the side of \"N\"",
                "leave out ReverseOrientation: \"N\" decides the side that emits",
            );
        } else if !mesh.tangents.is_empty() {
            self.push(
                "pbrt-v3 lets this mesh with \"S\" glow on the side that ReverseOrientation does not choose",
                "leave out \"S\", or exchange two corners of each triangle instead of ReverseOrientation",
            );
        }
    }
}

/// How a transformation changes the measures of a quadric.
#[derive(Debug, PartialEq)]
enum Scaling {
    Rigid,
    /// The area by a factor; lengths too, where they all change alike.
    Factor {
        length: Option<f64>,
        area: f64,
    },
    /// Not everywhere by the same factor.
    Uneven,
}

impl Scaling {
    fn of(world_from_object: &Transform, form: &QuadricForm) -> Self {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| world_from_object.vector(axis));
        let length = DMat3::from_cols(x, y, z).determinant().abs().cbrt();
        let is_alike = |a: DVec3, b: DVec3| {
            (a.length() / length - 1.0).abs() < TOLERANCE && a.dot(b).abs() < TOLERANCE * length * length
        };
        if is_alike(x, y) && is_alike(y, z) && is_alike(z, x) {
            return match (length - 1.0).abs() < TOLERANCE {
                true => Scaling::Rigid,
                false => Scaling::Factor { length: Some(length), area: length * length },
            };
        }
        match form {
            QuadricForm::Disk(_) => {
                let area = x.cross(y).length();
                match (area - 1.0).abs() < TOLERANCE {
                    true => Scaling::Rigid,
                    false => Scaling::Factor { length: None, area },
                }
            }
            _ => Scaling::Uneven,
        }
    }
}

/// A number with few digits, as people write it.
fn rounded(value: f64) -> f64 {
    let digits = 5 - value.abs().log10().floor().clamp(-300.0, 300.0) as i32;
    let power = 10.0_f64.powi(digits);
    let rounded = (value * power).round() / power;
    if rounded.is_finite() { rounded } else { value }
}
