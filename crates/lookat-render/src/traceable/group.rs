//! Elements of a world or of an object, in a tree.

use crate::bvh::Bvh;
use crate::triangle::Triangle;
use crate::triangle::block::Block;

/// For a primitive that is no curved shape.
pub(super) const NOT_CURVED: u32 = u32::MAX;

/// Elements with their tree.
pub(crate) struct Group {
    pub bvh: Bvh,
    /// What tells of most triangles that they are not met. Apart from these, to stay in the cache.
    pub blocks: Vec<Block>,
    /// Each at its place, see [`crate::ray::Hit::place`].
    pub triangles: Vec<Triangle>,
    pub others: Vec<Other>,
}

impl Group {
    /// The triangle at a place.
    #[inline(always)]
    pub fn triangle(&self, place: u32) -> &Triangle {
        &self.triangles[place as usize]
    }
}

/// An element that is no triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Other {
    Curved { primitive: u32, shape: u32 },
    Curve { primitive: u32, piece: u32 },
    Instance { instance: u32 },
}
