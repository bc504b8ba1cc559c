//! Directives that change the current transformation.

use glam::{DMat4, DVec3, DVec4};
use lookat_syntax::{Diagnostic, Span, Text};

use super::{Block, Resolver};
use crate::angle;
use crate::elsewhere::Kind;
use crate::transform::{LARGEST, LookAtFault, Transform};
use crate::undefined::undefined;

/// The most rotations for which doubtful ones are reported. Among more, some look doubtful by chance.
const MANY_ROTATIONS: usize = 20;

impl Resolver<'_> {
    pub(super) fn concat(&mut self, transform: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.replace(self.state.ctm * transform, at)
    }

    pub(super) fn replace(&mut self, ctm: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        if self.block == Block::Options && self.options.camera_is_set() {
            self.idle_transform.get_or_insert(at);
        }
        let ctm = in_range(ctm, at)?;
        // Transformations of the end time only add motion.
        if self.state.at_start {
            self.state.ctm = ctm;
        }
        Ok(())
    }

    /// Warns if the angle looks like radians or like the last number.
    pub(super) fn doubt_rotation(&mut self, angle: f64, [x, y, z]: [f64; 3], span: Span) {
        self.rotations += 1;
        if let Some((severity, message, help)) = angle::doubt("the angle of Rotate", angle) {
            let doubt = Diagnostic::warning(span, message).help(help);
            self.doubted_rotations.push(Diagnostic { severity, ..doubt });
        }
        let is_axis = [angle, x, y].iter().all(|number| [-1.0, 0.0, 1.0].contains(number));
        if is_axis && (10.0..=720.0).contains(&z.abs()) {
            let message = format!("the angle of Rotate is {angle}: did you write the angle last?");
            let warning = Diagnostic::warning(span, message).help("write the angle first, then the axis");
            self.report.push(warning.fix(span, format!("Rotate {z} {angle} {x} {y}")));
        }
    }

    /// Reports doubtful rotations, unless there are so many rotations that some look doubtful by chance.
    pub(super) fn tell_doubted_rotations(&mut self) {
        if self.rotations < MANY_ROTATIONS * self.doubted_rotations.len() {
            self.report.extend(std::mem::take(&mut self.doubted_rotations));
        }
    }

    pub(super) fn look_at(&mut self, points: [f64; 9], span: Span) -> Result<(), Box<Diagnostic>> {
        let [eye, look, up] = [0, 3, 6].map(|at| DVec3::new(points[at], points[at + 1], points[at + 2]));
        if self.block == Block::World {
            let warning =
                Diagnostic::warning(span, "LookAt inside the world block moves shapes, not the camera")
                    .help("to place the camera, move LookAt before Camera");
            self.report.push(warning);
        }
        match Transform::look_at(eye, look, up) {
            Ok(transform) => self.concat(transform, span),
            Err(fault) => {
                let (message, help) = match fault {
                    LookAtFault::EyeAtLook => (
                        "the eye and the target of LookAt are the same point",
                        "the first three numbers are the eye, the next three the target: make them different",
                    ),
                    LookAtFault::ZeroUp => (
                        "the up vector of LookAt is zero",
                        "write the direction that is up in the picture, usually 0 1 0 or 0 0 1",
                    ),
                    LookAtFault::UpParallel => (
                        "the up vector of LookAt is parallel to the view",
                        "the last three numbers are the direction that is up in the picture: choose one that is not parallel to the view",
                    ),
                };
                Err(Box::new(Diagnostic::error(span, message).help(help)))
            }
        }
    }

    pub(super) fn coord_sys_transform(&mut self, name: Text) {
        match self.coordinate_systems.get(&name.value) {
            // Applies to both times.
            Some(transform) => self.state.ctm = *transform,
            None => {
                undefined(&mut self.report, Kind::CoordinateSystem, &name, self.coordinate_systems.keys())
            }
        }
    }

    pub(super) fn motion(&mut self, at: Span, keyword: &str) {
        let message = format!(
            "{keyword}: lookat does not render motion; it uses the transformations at the start time"
        );
        self.report.unsupported(at, message);
    }
}

fn in_range(transform: Transform, at: Span) -> Result<Transform, Box<Diagnostic>> {
    if transform.in_range() {
        return Ok(transform);
    }
    let message = format!("the transformation or its inverse has entries above {LARGEST:e}");
    Err(Box::new(
        Diagnostic::error(at, message).help("transformations accumulate: check the ones before it, too"),
    ))
}

pub(super) fn scale(by: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let message = if by.contains(&0.0) {
        "Scale by 0 is not invertible"
    } else {
        "Scale by such a small factor is not invertible"
    };
    Transform::scale(by.into()).ok_or_else(|| {
        Box::new(Diagnostic::error(*span, message).help("use nonzero factors, such as 1e-3 for a thin shape"))
    })
}

pub(super) fn rotate(degrees: f64, axis: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    Transform::rotate(degrees, axis.into()).ok_or_else(|| {
        Box::new(
            Diagnostic::error(*span, "the axis of Rotate has length 0")
                .help("the first number is the angle in degrees, the next three are the axis"),
        )
    })
}

pub(super) fn matrix(m: &[f64; 16], keyword: &str, span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let m = DMat4::from_cols_array(m);
    Transform::from_matrix(m).ok_or_else(|| {
        let affine = m.row(3) == DVec4::W;
        let (message, help) = if affine {
            ("is singular", "a transformation must be invertible: no row or column may be zero or a combination of the others")
        } else {
            (
                "is not affine",
                "write the matrix column by column: the 4th, 8th and 12th number are 0, the 16th is 1",
            )
        };
        Box::new(Diagnostic::error(*span, format!("the matrix of {keyword} {message}")).help(help))
    })
}
