//! Directives that change the current transformation.

use glam::{DMat4, DVec4};
use lookat_syntax::{Diagnostic, Span};

use super::Resolver;
use crate::facts::Block;
use crate::transform::{LookAtFault, Transform, out_of_range};
use crate::view_override::{CameraPlacement, look_at};

impl Resolver<'_> {
    pub(super) fn concat(&mut self, transform: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.set_ctm(self.state.ctm * transform, at)?;
        if let Some(placement) = self.facts.placed.as_mut().filter(|_| self.state.at_start) {
            placement.after = placement.after * transform;
        }
        Ok(())
    }

    pub(super) fn replace(&mut self, ctm: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        self.facts.placed = None;
        self.set_ctm(ctm, at)
    }

    fn set_ctm(&mut self, ctm: Transform, at: Span) -> Result<(), Box<Diagnostic>> {
        let ctm = in_range(ctm, at)?;
        if self.block == Block::Options && ctm != self.state.ctm {
            self.facts.idle_transform.get_or_insert(at);
        }
        // Transformations of the end time only add motion.
        if self.state.at_start {
            self.state.ctm = ctm;
        }
        Ok(())
    }

    /// Notes that something uses the current transformation before `WorldBegin`.
    pub(super) fn use_transform(&mut self) {
        if self.block == Block::Options {
            self.facts.idle_transform = None;
        }
    }

    pub(super) fn look_at(&mut self, points: [f64; 9], span: Span) -> Result<(), Box<Diagnostic>> {
        if self.block == Block::World && self.blocks.open.is_empty() {
            self.facts.look_at_in_world.get_or_insert(span);
        }
        match look_at(points) {
            Ok(transform) => {
                let before = self.state.ctm;
                self.concat(transform, span)?;
                if self.state.at_start {
                    let after = Transform::IDENTITY;
                    self.facts.placed = Some(CameraPlacement { span: Some(span), before, points, after });
                }
                Ok(())
            }
            Err(fault) => {
                let help = match fault {
                    LookAtFault::EyeAtLook => {
                        "the first three numbers are the eye, the next three the target: make them different"
                    }
                    LookAtFault::ZeroUp => {
                        "write the direction that is up in the picture, usually 0 1 0 or 0 0 1"
                    }
                    LookAtFault::UpParallel => {
                        "the last three numbers are the direction that is up in the picture: choose one that is not parallel to the view"
                    }
                    LookAtFault::OutOfRange => "write smaller numbers",
                };
                Err(Box::new(Diagnostic::error(span, fault.to_string()).help(help)))
            }
        }
    }
}

fn in_range(transform: Transform, at: Span) -> Result<Transform, Box<Diagnostic>> {
    if transform.in_range() {
        return Ok(transform);
    }
    let help = "transformations accumulate: check the ones before it, too";
    Err(Box::new(Diagnostic::error(at, out_of_range()).help(help)))
}

pub(super) fn scale(by: [f64; 3], span: &Span) -> Result<Transform, Box<Diagnostic>> {
    let message =
        if by.contains(&0.0) { "Scale by 0 is not invertible" } else { "this Scale is too small to invert" };
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
