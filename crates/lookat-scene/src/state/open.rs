//! Open blocks.

use std::collections::HashMap;

use lookat_syntax::{Span, Text};

use super::Saved;
use crate::Transform;
use crate::facts::Opened;

/// The open blocks.
#[derive(Default)]
pub(crate) struct Blocks {
    pub open: Vec<Open>,
    /// The first AttributeEnd in the open object that closes a block around the object.
    pub crossed: Option<Span>,
    /// Unmatched end directives, counted so that each is reported once.
    pub forgiven: HashMap<&'static str, usize>,
}

/// An open block and the state that its end restores.
pub(crate) enum Open {
    Attribute {
        saved: Box<Saved>,
        at: Span,
    },
    Transform {
        saved: Box<(Transform, bool)>,
        at: Span,
    },
    /// An object. It has no name if it is nested, which is an error.
    Object {
        saved: Box<Saved>,
        name: Option<Text>,
        at: Span,
    },
}

impl Open {
    /// The directives that open and close the block.
    pub fn keywords(&self) -> (&'static str, &'static str) {
        match self {
            Open::Attribute { .. } => ("AttributeBegin", "AttributeEnd"),
            Open::Transform { .. } => ("TransformBegin", "TransformEnd"),
            Open::Object { .. } => ("ObjectBegin", "ObjectEnd"),
        }
    }

    /// The directive that closes the block.
    pub fn end(&self) -> &'static str {
        self.keywords().1
    }

    /// The saved state, if the block saves all of it.
    pub fn saved(&mut self) -> Option<&mut Box<Saved>> {
        match self {
            Open::Attribute { saved, .. } | Open::Object { saved, .. } => Some(saved),
            Open::Transform { .. } => None,
        }
    }

    pub fn at(&self) -> Span {
        match self {
            Open::Attribute { at, .. } | Open::Transform { at, .. } | Open::Object { at, .. } => *at,
        }
    }

    /// Its keywords and place.
    pub fn opened(&self) -> Opened {
        Opened { keywords: self.keywords(), at: self.at() }
    }

    pub fn is_object(&self) -> bool {
        matches!(self, Open::Object { .. })
    }
}
