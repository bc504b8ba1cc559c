//! Facts about a scene, collected while it is interpreted. The passes of `advice` turn them into messages.

use lookat_syntax::{EntityKind, Span};

use crate::CameraPlacement;
use crate::symbols::{SymbolId, SymbolKind};
use crate::transform::TransformSet;

/// Facts in the order in which the scene is read.
#[derive(Debug, Default)]
pub(crate) struct Facts {
    /// `WorldBegin`.
    pub world_begin: Option<Span>,
    /// The end of a scene without `WorldEnd`.
    pub missing_end: Option<Span>,
    /// The first directive of a file that other scenes include, and the block that it is a part of.
    pub part: Option<(Block, Span)>,
    /// World directives before `WorldBegin`: keyword and place.
    pub early: Vec<(&'static str, Span)>,
    /// Blocks without an end.
    pub unclosed: Vec<BlockStart>,
    /// Options that are left to their defaults.
    pub missing_options: Vec<EntityKind>,
    /// The types of the lights of the world.
    pub lights: Vec<Span>,
    /// The last Camera and its transformation.
    pub camera: Option<(Span, TransformSet)>,
    /// The last `LookAt` that is part of the current transformation.
    pub placed: Option<CameraPlacement>,
    /// The `LookAt` that places the camera.
    pub placement: Option<CameraPlacement>,
    /// True if the world uses the coordinate system of the camera.
    pub uses_camera_space: bool,
    /// The first transformation of the options that nothing has used: one after `Camera`, or without `Camera`.
    pub idle_transform: Option<Span>,
    /// `Rotate` directives.
    pub rotations: Vec<Rotation>,
    /// The first `LookAt` in the world that is in no block.
    pub look_at_in_world: Option<Span>,
    /// The ActiveTransform that nothing has ended at WorldEnd.
    pub active: Option<Span>,
    /// Names that are defined again while a definition is in scope.
    pub redefined: Vec<(SymbolKind, String, Span)>,
    /// Objects with shapes: the place of `ObjectBegin`, and the name.
    pub objects: Vec<(Span, SymbolId)>,
    /// AreaLightSources that are not black.
    pub emissions: Vec<Span>,
    /// The first shape without a material, which rays pass through.
    pub passed: Option<Span>,
    /// The first shape with `shadowalpha`.
    pub shadow_alpha: Option<Span>,
}

/// The block of a directive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Block {
    Options,
    World,
    /// The file after `WorldEnd`.
    Ended,
}

/// The kinds of blocks that directives open and close.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum BlockKind {
    Attribute,
    Transform,
    Object,
}

impl BlockKind {
    /// The directives that open and close a block.
    pub fn keywords(self) -> (&'static str, &'static str) {
        match self {
            BlockKind::Attribute => ("AttributeBegin", "AttributeEnd"),
            BlockKind::Transform => ("TransformBegin", "TransformEnd"),
            BlockKind::Object => ("ObjectBegin", "ObjectEnd"),
        }
    }
}

/// The start of a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockStart {
    pub kind: BlockKind,
    pub at: Span,
}

/// The numbers of a `Rotate`: the angle in degrees and the axis.
#[derive(Debug)]
pub(crate) struct Rotation {
    pub angle: f64,
    pub axis: [f64; 3],
    /// True if it applies to one of the two times of motion alone.
    pub is_motion: bool,
    pub at: Span,
}
