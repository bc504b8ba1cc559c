//! Elements of a world or of an object, in a tree.

use crate::bvh::Bvh;
use crate::triangle::Triangle;
use crate::triangle::block::{Block, of_place, place};

/// For a primitive that is no curved shape.
pub(super) const NOT_CURVED: u32 = u32::MAX;

/// Elements with their tree.
pub(crate) struct Group {
    pub bvh: Bvh,
    pub blocks: Vec<Block>,
    pub others: Vec<Other>,
}

impl Group {
    /// The triangle at a place, see [`crate::ray::Hit::place`].
    #[inline(always)]
    pub fn triangle(&self, place: u32) -> &Triangle {
        let (block, lane) = of_place(place);
        self.blocks[block].triangle(lane)
    }

    /// All triangles, each with its place.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, &Triangle)> {
        self.blocks
            .iter()
            .enumerate()
            .flat_map(|(number, block)| (0..).map(move |lane| place(number, lane)).zip(block.triangles()))
    }
}

/// An element that is no triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Other {
    Curved { primitive: u32, shape: u32 },
    Curve { primitive: u32, piece: u32 },
    Instance { instance: u32 },
}
