//! Warnings about shapes that pbrt-v3 renders otherwise. `docs/differences.md` lists all differences.

mod mesh_light;
mod quadric_light;
mod scaling;

use lookat_syntax::{Diagnostic, Span, Text};

use super::Resolver;
use crate::report::Report;
use crate::{CurveKind, Primitive, Shape};

impl Resolver<'_> {
    /// Warns about a shape of the type at `name`.
    pub(super) fn warn_of_departures(&mut self, name: &Text, primitive: &Primitive) {
        let emission = primitive.emission.filter(|emission| !emission.is_black() && self.object.is_none());
        let is_one_sided = emission.is_some_and(|emission| !emission.two_sided);
        let warn = &mut Warn { report: &mut self.report, at: name.span };
        match &primitive.shape {
            Shape::Curve(curve) => warn.curve(&curve.kind),
            Shape::Quadric(quadric) if emission.is_some() => {
                warn.quadric_light(&name.value, quadric, primitive.mirrored && is_one_sided);
            }
            Shape::TriangleMesh(mesh) if emission.is_some() => {
                warn.mesh_light(mesh, primitive.reverse_orientation && is_one_sided);
                if primitive.cutout.as_ref().is_some_and(|cutout| cutout.alpha.is_some()) {
                    warn.mesh_light_with_holes();
                }
            }
            _ => {}
        }
        if primitive.cutout.as_ref().is_some_and(|cutout| cutout.shadow_alpha.is_some()) {
            self.shadow_alpha.get_or_insert(name.span);
        }
    }

    /// Warns about `shadowalpha` if a sky or a shape emits light. Light of point, spot and distant lights passes by the same
    /// amount in pbrt-v3 and lookat.
    pub(super) fn warn_of_shadow_alpha(&mut self) {
        let has_other = !self.lights.iter().all(crate::Light::is_delta)
            || self.primitives.iter().any(|primitive| primitive.emission.is_some());
        if let Some(at) = self.shadow_alpha.filter(|_| has_other) {
            Warn { report: &mut self.report, at }.push(
                "light of skies and shapes passes \"shadowalpha\" only partly, and by different amounts in pbrt-v3 and lookat",
                "to make holes for all light, use \"alpha\" instead",
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

    fn curve(&mut self, kind: &CurveKind) {
        // A note: every curve has it, and no parameter makes both pictures equal.
        let message = "pbrt-v3 draws curves up to 5 % thinner where they bend, and omits shadows of surfaces closer than 3.5 curve widths";
        let help = "to reduce the difference in width, increase \"splitdepth\"";
        self.report.push(Diagnostic::note_at(self.at, message).help(help));
        if let CurveKind::Ribbon(normals) = kind
            && normals.windows(2).any(|pair| pair[0] == pair[1])
        {
            self.push(
                "pbrt-v3 may abort, or leave out parts, where successive normals of a ribbon are equal",
                "rotate one of the two normals by a thousandth of a radian",
            );
        }
    }
}
