//! The state that directives change: what pbrt-v3's api.cpp keeps in globals.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::{Entity, Param, Span};

use crate::{Emission, Material, Transform};

/// What `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone)]
pub(crate) struct GraphicsState {
    /// pbrt's current transformation matrix.
    pub ctm: Transform,
    /// Transformations of the start time are being set, so they count: nothing moves.
    pub at_start: bool,
    pub reverse_orientation: bool,
    pub material: Rc<MaterialInstance>,
    pub emission: Option<Emission>,
    /// Shared between states until one changes it.
    pub named_materials: Rc<HashMap<String, Rc<MaterialInstance>>>,
    pub textures: Rc<Textures>,
}

/// The textures in scope. A texture that is not rendered has no value; parameters that name it keep their default.
#[derive(Debug, Clone, Default)]
pub(crate) struct Textures {
    pub float: HashMap<String, Option<f64>>,
    pub spectrum: HashMap<String, Option<Vec3>>,
}

impl Textures {
    /// The names of the textures of one kind of value.
    pub fn names(&self, value: &str) -> Vec<&str> {
        let mut names: Vec<&str> = match value {
            "float" => self.float.keys().map(String::as_str).collect(),
            _ => self.spectrum.keys().map(String::as_str).collect(),
        };
        names.sort_unstable();
        names
    }
}

/// A material with what made it: the parameters of a shape may replace some of its own.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// The type and the parameters that it was given.
    pub entity: Option<Entity>,
    /// The names of all its parameters; none where they are not known, because something else stands in for it.
    pub names: Option<Vec<&'static str>>,
}

impl MaterialInstance {
    /// Splits the parameters of a shape into those that replace some of the material's, and the others.
    pub fn split(&self, params: Vec<Param>) -> (Vec<Param>, Vec<Param>) {
        let Some(names) = &self.names else { return (params, Vec::new()) };
        params.into_iter().partition(|param| names.contains(&param.name.value.as_str()))
    }
}

impl GraphicsState {
    pub fn new() -> Self {
        let matte = MaterialInstance {
            material: Arc::new(Material::DEFAULT),
            entity: None,
            names: Some(vec!["Kd", "sigma", "bumpmap"]),
        };
        GraphicsState {
            ctm: Transform::IDENTITY,
            at_start: true,
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
        saved: Box<(Transform, bool)>,
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
