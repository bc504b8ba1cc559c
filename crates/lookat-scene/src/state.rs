//! The state that directives change: what pbrt-v3's api.cpp keeps in globals.

use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{Entity, Param, ParamType, Span, Spanned};

use crate::names::Names;
use crate::params::class;
use crate::texture::Textures;
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
    /// With the place of its AreaLightSource.
    pub emission: Option<Spanned<Emission>>,
}

/// What directives have given a name to.
#[derive(Default)]
pub(crate) struct Definitions {
    pub materials: Names<Rc<MaterialInstance>>,
    pub textures: Textures,
}

impl Definitions {
    fn counts(&self) -> [usize; 3] {
        let Textures { float, spectrum } = &self.textures;
        [self.materials.definitions(), float.definitions(), spectrum.definitions()]
    }
}

/// The state at the beginning of a block.
pub(crate) struct Saved {
    state: GraphicsState,
    definitions: [usize; 3],
}

impl Saved {
    pub fn new(state: &GraphicsState, definitions: &Definitions) -> Box<Self> {
        Box::new(Saved { state: state.clone(), definitions: definitions.counts() })
    }

    pub fn restore(self, state: &mut GraphicsState, definitions: &mut Definitions) {
        *state = self.state;
        definitions.materials.take_back(self.definitions[0]);
        definitions.textures.float.take_back(self.definitions[1]);
        definitions.textures.spectrum.take_back(self.definitions[2]);
    }
}

/// A material with what made it: the parameters of a shape may replace some of its own.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// The type and the parameters that it was given.
    pub entity: Option<Entity>,
    /// The names and types of its parameters; none where something else stands in for it.
    pub known: Option<Vec<(&'static str, ParamType)>>,
}

impl MaterialInstance {
    /// Splits the parameters of a shape into those that replace some of the material's, and the others.
    pub fn split(&self, params: Vec<Param>) -> (Vec<Param>, Vec<Param>) {
        let Some(known) = &self.known else { return (params, Vec::new()) };
        let is_known = |param: &Param| {
            known.iter().any(|(name, ty)| *name == param.name.value && class(*ty) == class(param.ty))
        };
        params.into_iter().partition(is_known)
    }
}

impl GraphicsState {
    pub fn new() -> Self {
        let matte = MaterialInstance {
            material: Arc::new(Material::DEFAULT),
            entity: None,
            known: Some(vec![
                ("Kd", ParamType::Texture),
                ("Kd", ParamType::Rgb),
                ("sigma", ParamType::Texture),
                ("sigma", ParamType::Float),
                ("bumpmap", ParamType::Texture),
            ]),
        };
        GraphicsState {
            ctm: Transform::IDENTITY,
            at_start: true,
            reverse_orientation: false,
            material: Rc::new(matte),
            emission: None,
        }
    }
}

/// A block that is open, and what closing it restores.
pub(crate) enum Open {
    Attribute {
        saved: Box<Saved>,
        at: Span,
    },
    Transform {
        saved: Box<(Transform, bool)>,
        at: Span,
    },
    /// Without a name, one inside another, which is an error.
    Object {
        saved: Box<Saved>,
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

    /// The whole state, where it is kept.
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
}
