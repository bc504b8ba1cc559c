//! Matrices that are not affine. pbrt-v3 accepts them, and of infinite and distant lights it transforms only directions, which the
//! last row does not change. Everything else that uses such a matrix is an error.

use std::rc::Rc;

use glam::{DMat3, DMat4, DVec4};
use lookat_syntax::{Diagnostic, Span};

use super::Resolver;
use crate::Transform;
use crate::transform::in_range;

/// The current transformation after a matrix that is not affine.
#[derive(Clone)]
pub(crate) struct Projective {
    matrix: DMat4,
    /// The directive of the matrix that is not affine.
    keyword: &'static str,
    at: Span,
}

/// True if the last row of a matrix is 0 0 0 1.
pub(super) fn is_affine(m: &DMat4) -> bool {
    m.row(3) == DVec4::W
}

/// The message about a matrix that is not affine, without its severity.
fn message(keyword: &str) -> String {
    format!("the matrix of {keyword} is not affine")
}

const HELP: &str = "write the matrix column by column: the 4th, 8th and 12th number are 0, the 16th is 1";

/// The transformation of directions by the upper left of a matrix. `None` if it is not invertible.
fn of_directions(linear: DMat3) -> Option<Transform> {
    Transform::from_matrix(DMat4::from_mat3(linear)).filter(Transform::in_range)
}

impl Resolver<'_> {
    /// Multiplies `before` by a matrix that is not affine. The current transformation of all that needs an affine one stays.
    pub(super) fn concat_projective(
        &mut self,
        before: DMat4,
        m: DMat4,
        keyword: &'static str,
        at: Span,
    ) -> Result<(), Box<Diagnostic>> {
        let matrix = before * m;
        let is_usable = in_range(&matrix.to_cols_array()) && in_range(&matrix.inverse().to_cols_array());
        // Lights do not move.
        if !(is_usable && self.state.changes_start()) {
            return Diagnostic::error(at, message(keyword)).help(HELP).fail();
        }
        self.state.projective = Some(Rc::new(Projective { matrix, keyword, at }));
        Ok(())
    }

    /// The current transformation as a matrix, affine or not.
    pub(super) fn current_matrix(&self) -> DMat4 {
        self.state.projective.as_ref().map_or_else(|| self.state.ctm.start.matrix(), |it| it.matrix)
    }

    /// Multiplies a matrix that is not affine by a transformation.
    pub(super) fn follow_projective(&mut self, transform: &Transform) {
        let changes_start = self.state.changes_start();
        if let Some(projective) = self.state.projective.as_mut().filter(|_| changes_start) {
            let before = Projective::clone(projective);
            *projective = Rc::new(Projective { matrix: before.matrix * transform.matrix(), ..before });
        }
    }

    /// Reports, once, a matrix that is not affine where something uses the current transformation.
    pub(super) fn need_affine(&mut self, user: Span) {
        let Some(Projective { keyword, at, .. }) = self.state.projective.as_deref().cloned() else { return };
        if self.reported_matrices.insert((at, true)) {
            let error = Diagnostic::error(at, message(keyword)).help(HELP);
            self.report.push(error.related(user, "used here"));
        }
    }

    /// The transformation of an infinite light, or of a distant one. Reports a matrix that is not affine.
    pub(super) fn of_light_directions(&mut self, is_distant: bool, user: Span) -> Transform {
        let Some(Projective { matrix, keyword, at }) = self.state.projective.as_deref().cloned() else {
            return self.still_ctm("light", user);
        };
        // pbrt-v3 transforms the direction of a distant light to the world, and directions of rays to an infinite light, by the inverse
        // of the whole matrix.
        let linear = match is_distant {
            true => DMat3::from_mat4(matrix),
            false => DMat3::from_mat4(matrix.inverse()).inverse(),
        };
        let Some(transform) = of_directions(linear) else {
            return self.placing("light", user);
        };
        if self.reported_matrices.insert((at, false)) {
            let message =
                format!("{}: the light takes only directions from it, as in pbrt-v3", message(keyword));
            self.report.push(Diagnostic::warning(at, message).help(HELP).related(user, "used here"));
        }
        transform
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lookat_syntax::Severity;

    use crate::{Light, LoadOptions, load};

    /// The lights of a scene, and its messages.
    fn lights(world: &str) -> (Vec<Light>, Vec<(Severity, String)>) {
        let text = format!(
            "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"path\" WorldBegin Shape \"sphere\" {world} WorldEnd"
        );
        let read = |path: &Path| match path.extension() {
            Some(_) => Ok([b"Pf\n2 2\n-1\n".as_slice(), &[0; 16]].concat()),
            None => Ok(text.clone().into()),
        };
        let loaded = load(Path::new("x"), &read, &LoadOptions::default());
        let messages = loaded.diagnostics.into_iter().map(|it| (it.severity, it.message)).collect();
        (loaded.scene.map_or(Vec::new(), |scene| scene.world.lights.clone()), messages)
    }

    const LIGHTS: &str =
        "LightSource \"distant\" \"point to\" [1 2 3] LightSource \"infinite\" \"string mapname\" \"a.pfm\"";

    #[test]
    fn directions_do_without_the_last_row() {
        let under = |row: [f64; 4], offset: f64| {
            let [a, b, c, d] = row;
            let matrix = format!(
                "Rotate 30 1 0 0 ConcatTransform [0.6 0.8 0 {a} -0.8 0.6 0 {b} 0 0 1 {c} 0 0 {offset} {d}] Rotate 20 0 0 1 {LIGHTS}"
            );
            lights(&matrix)
        };
        let (expected, _) = under([0.0, 0.0, 0.0, 1.0], 0.0);
        for row in [[0.0, 0.0, 8.87, 1.0], [0.5, -3.0, 0.0, 1.0], [0.0, 0.0, 0.0, 2.0]] {
            let (found, messages) = under(row, 0.0);
            let warning = "the matrix of ConcatTransform is not affine: the light takes only directions from it, as in pbrt-v3";
            assert!(messages.contains(&(Severity::Warning, warning.into())), "{messages:?}");
            let [Light::Distant { direction, .. }, Light::Environment { world_from_light, .. }] = &found[..]
            else {
                panic!("{found:?}")
            };
            let [Light::Distant { direction: own, .. }, Light::Environment { world_from_light: before, .. }] =
                &expected[..]
            else {
                panic!("{expected:?}")
            };
            assert!((*direction - *own).length() < 1e-14, "{row:?}");
            assert!(world_from_light.linear().abs_diff_eq(*before.linear(), 1e-14), "{row:?}");
        }
        // With an offset, the inverse of the whole matrix has another upper left.
        let (found, _) = under([0.0, 0.0, 0.5, 1.0], 1.0);
        let [_, Light::Environment { world_from_light, .. }] = &found[..] else { panic!("{found:?}") };
        let [_, Light::Environment { world_from_light: before, .. }] = &expected[..] else {
            panic!("{expected:?}")
        };
        assert!(!world_from_light.linear().abs_diff_eq(*before.linear(), 0.1));
    }

    #[test]
    fn everything_else_refuses_such_a_matrix() {
        let matrix = "Transform [1 0 0 0 0 1 0 0 0 0 1 0.5 0 0 0 1]";
        for (user, is_error) in [
            ("Shape \"disk\"", true),
            ("LightSource \"point\"", true),
            ("LightSource \"spot\"", true),
            ("Texture \"a\" \"float\" \"fbm\"", true),
            ("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"a.pfm\"", false),
            ("Identity Shape \"disk\"", false),
            ("TransformBegin Rotate 3 0 0 1 TransformEnd Identity Shape \"disk\"", false),
            (LIGHTS, false),
            ("CoordinateSystem \"a\" Identity CoordSysTransform \"a\" Shape \"disk\"", true),
        ] {
            let (_, messages) = lights(&format!("{matrix} {user}"));
            let error = (Severity::Error, "the matrix of Transform is not affine".to_owned());
            assert_eq!(messages.contains(&error), is_error, "{user}: {messages:?}");
        }
    }
}
