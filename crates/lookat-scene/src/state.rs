//! The graphics state: the globals of pbrt-v3's api.cpp.

mod open;

use std::rc::Rc;

use crate::material::MaterialInstance;
use crate::names::Names;
use crate::symbols::SymbolKind;
use crate::texture::Textures;
use crate::{Emission, Transform};

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
    pub emission: Option<Emission>,
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

impl GraphicsState {
    pub fn new() -> Self {
        GraphicsState {
            ctm: Transform::IDENTITY,
            at_start: true,
            reverse_orientation: false,
            material: Rc::new(MaterialInstance::default()),
            emission: None,
        }
    }
}
