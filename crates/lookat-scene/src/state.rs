//! The graphics state: the globals of pbrt-v3's api.cpp.

mod open;

use std::rc::Rc;
use std::sync::Arc;

use lookat_syntax::{Entity, Param, ParamType, Spanned};

use crate::names::Names;
use crate::params::class;
use crate::symbols::SymbolKind;
use crate::texture::Textures;
use crate::{Emission, Material, Transform};

pub(crate) use open::{Blocks, Open};

/// The state that `AttributeBegin` saves and `AttributeEnd` restores.
#[derive(Clone)]
pub(crate) struct GraphicsState {
    /// The current transformation matrix (CTM).
    pub ctm: Transform,
    /// True if transformations apply to the start time. Without motion, only these transformations count.
    pub at_start: bool,
    pub reverse_orientation: bool,
    pub material: Rc<MaterialInstance>,
    /// The emission, with the place of its AreaLightSource.
    pub emission: Option<Spanned<Emission>>,
}

/// The named definitions. The end of a block undoes those of materials and textures.
pub(crate) struct Definitions {
    pub materials: Names<Rc<MaterialInstance>>,
    pub textures: Textures,
    /// The index of each object in the draft.
    pub objects: Names<usize>,
    pub media: Names<()>,
    pub coordinate_systems: Names<Transform>,
}

impl Definitions {
    pub fn new() -> Self {
        Definitions {
            materials: Names::new(SymbolKind::Material),
            textures: Textures::default(),
            objects: Names::new(SymbolKind::Object),
            media: Names::new(SymbolKind::Medium),
            coordinate_systems: Names::new(SymbolKind::CoordinateSystem),
        }
    }

    fn counts(&self) -> [usize; 3] {
        let Textures { float, spectrum } = &self.textures;
        [self.materials.definitions(), float.definitions(), spectrum.definitions()]
    }
}

/// The state at the start of a block.
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

/// A material with its source, because a shape may replace its parameters.
pub(crate) struct MaterialInstance {
    pub material: Arc<Material>,
    /// Its type and parameters as written.
    pub entity: Option<Entity>,
    /// The names and types of its parameters. `None` for a stand-in.
    pub known: Option<Vec<(&'static str, ParamType)>>,
}

impl MaterialInstance {
    /// Splits the parameters of a shape into material parameters and the rest.
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
