//! Builds the hierarchy on all threads: a binary tree by the surface area heuristic, optimized by reinsertion, then collapsed into nodes with
//! eight children.

mod binary;
mod collapse;
mod reinsertion;

use glam::{Vec3A, Vec4};

use super::{Bvh, Child};
use crate::frame::Bounds;

/// An element to be sorted into a tree: its box, and which it is.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Reference {
    /// The least corner, and the bits of the number.
    min: Vec4,
    /// The greatest corner, and 1 for a triangle or 0.
    max: Vec4,
}

/// Added to the bits of numbers, so that they are not too small for fast arithmetic.
const NORMAL: u32 = 1 << 30;

impl Reference {
    pub fn triangle(bounds: Bounds, number: u32) -> Self {
        Reference { min: bounds.min.extend(f32::from_bits(number | NORMAL)), max: bounds.max.extend(1.0) }
    }

    /// A reference to a non-triangle.
    pub fn non_triangle(bounds: Bounds, number: u32) -> Self {
        Reference { max: bounds.max.extend(0.0), ..Reference::triangle(bounds, number) }
    }

    /// Among the triangles, or among the others.
    pub fn number(&self) -> u32 {
        self.min.w.to_bits() & !NORMAL
    }

    pub fn is_triangle(&self) -> bool {
        self.max.w == 1.0
    }

    /// True if its box is.
    pub fn is_empty(&self) -> bool {
        self.bounds().is_empty()
    }

    #[inline(always)]
    fn bounds(&self) -> Bounds {
        Bounds { min: Vec3A::from_vec4(self.min), max: Vec3A::from_vec4(self.max) }
    }
}

/// The box around elements.
pub(crate) fn around(references: &[Reference]) -> Bounds {
    references.iter().fold(Bounds::EMPTY, |all, reference| all.union(reference.bounds()))
}

/// The result of [`build`].
pub(crate) struct Tree {
    pub bvh: Bvh,
    /// The number of triangles of each block. Blocks take triangles in the order of the sorted references.
    pub blocks: Vec<u8>,
}

/// A node of a binary tree.
#[derive(Debug, Clone, Copy)]
struct BinaryNode {
    min: [f32; 3],
    max: [f32; 3],
    /// Of a leaf, [`NONE`] and the leaf. The number of a block is that of its first element until all blocks are known.
    children: [u32; 2],
    parent: u32,
}

/// No node.
const NONE: u32 = u32::MAX;

impl BinaryNode {
    #[inline(always)]
    fn bounds(&self) -> Bounds {
        Bounds { min: self.min.into(), max: self.max.into() }
    }

    #[inline(always)]
    fn set_bounds(&mut self, bounds: Bounds) {
        (self.min, self.max) = (bounds.min.into(), bounds.max.into());
    }

    fn leaf(&self) -> Option<Child> {
        (self.children[0] == NONE).then_some(Child(self.children[1]))
    }
}

/// Compares surfaces in the range of `f32`.
#[derive(Debug, Clone, Copy)]
struct Size(f32);

impl Size {
    fn of(bounds: &Bounds) -> Self {
        Size((bounds.max - bounds.min).max_element().recip())
    }

    /// Half the surface of a box, where the longest side of the whole is 1.
    #[inline(always)]
    fn area(self, bounds: Bounds) -> f32 {
        let [x, y, z] = ((bounds.max - bounds.min) * self.0).to_array();
        x * y + y * z + z * x
    }
}

/// Builds the tree over some elements. Sorts them so that the elements of a block are neighbors.
pub(crate) fn build(references: &mut [Reference]) -> Tree {
    // That many take more than a hundred gigabytes.
    assert!(references.len() < Child::MOST, "more than {} triangles and shapes", Child::MOST);
    if references.is_empty() {
        let bvh = Bvh { nodes: Vec::new(), root: Child::EMPTY, bounds: Bounds::EMPTY };
        return Tree { bvh, blocks: Vec::new() };
    }
    let (mut binary, mut blocks) = binary::build(references);
    reinsertion::optimize(&mut binary);
    let collapsed = collapse::collapse(&binary);
    let (nodes, root) = collapsed.unwrap_or_else(|| {
        (binary, blocks) = binary::build(references);
        collapse::collapse(&binary).expect("elements are halved before a tree is too deep")
    });
    Tree { bvh: Bvh { nodes, root, bounds: binary[0].bounds() }, blocks }
}
