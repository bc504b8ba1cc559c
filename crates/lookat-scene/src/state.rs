//! The state that directives change: what pbrt-v3's api.cpp keeps in globals.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{Entity, Param, Span};

use crate::texture::Textures;
use crate::{Emission, Material, Transform};

/// What `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone)]
pub(crate) struct GraphicsState {
    /// pbrt's current transformation matrix.
    pub ctm: Transform,
    pub reverse_orientation: bool,
    pub material: Rc<MaterialInstance>,
    pub emission: Option<Emission>,
    /// Shared between states until one changes it.
    pub named_materials: Rc<HashMap<String, Rc<MaterialInstance>>>,
    pub textures: Rc<Textures>,
}

/// A material with what made it: the parameters of a shape may replace some of its own.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// The type and the parameters that it was given.
    pub entity: Option<Entity>,
    /// The names of all its parameters.
    pub names: Vec<&'static str>,
}

impl MaterialInstance {
    /// Splits the parameters of a shape into those that replace some of the material's, and the others.
    pub fn split(&self, params: Vec<Param>) -> (Vec<Param>, Vec<Param>) {
        params.into_iter().partition(|param| self.names.contains(&param.name.value.as_str()))
    }
}

impl GraphicsState {
    pub fn new() -> Self {
        let matte = MaterialInstance {
            material: Arc::new(Material::DEFAULT),
            entity: None,
            names: vec!["Kd", "sigma", "bumpmap"],
        };
        GraphicsState {
            ctm: Transform::IDENTITY,
            reverse_orientation: false,
            material: Rc::new(matte),
            emission: None,
            named_materials: Rc::default(),
            textures: Rc::default(),
        }
    }
}

/// A block that is open, and what closing it restores.
pub(crate) enum Open {
    Attribute {
        saved: Box<GraphicsState>,
        at: Span,
    },
    Transform {
        saved: Box<Transform>,
        at: Span,
    },
    /// Without a name, one inside another, which is an error.
    Object {
        saved: Box<GraphicsState>,
        name: Option<String>,
        at: Span,
    },
}

impl Open {
    /// The directives that open and close it.
    pub fn keywords(&self) -> (&'static str, &'static str) {
        match self {
            Open::Attribute { .. } => ("AttributeBegin", "AttributeEnd"),
            Open::Transform { .. } => ("TransformBegin", "TransformEnd"),
            Open::Object { .. } => ("ObjectBegin", "ObjectEnd"),
        }
    }

    pub fn at(&self) -> Span {
        match self {
            Open::Attribute { at, .. } | Open::Transform { at, .. } | Open::Object { at, .. } => *at,
        }
    }
}
