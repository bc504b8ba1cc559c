//! The elements of a world, sorted into trees.

use std::ops::Range;

use glam::DVec3;
use lookat_scene::{Mesh, Primitive, Shape};
use rayon::prelude::*;

use super::group::{Group, NOT_CURVED, Other};
use crate::bounds::Bounds;
use crate::bvh::{Reference, around, build};
use crate::curve::Curves;
use crate::curved::Curved;
use crate::triangle::block::Block;
use crate::triangle::{Extent, Triangle, corners};

/// Numbers primitives as they come.
#[derive(Default)]
pub(super) struct Builder {
    pub curved: Vec<Curved>,
    /// Which of the curved shapes a primitive is, or [`NOT_CURVED`].
    pub curved_of: Vec<u32>,
    pub curves: Curves,
}

/// Elements that become one tree.
#[derive(Default)]
pub(super) struct Elements<'s> {
    /// What positions of meshes are relative to.
    origin: DVec3,
    /// Meshes, the number of their primitive, and which of all triangles are theirs.
    meshes: Vec<(&'s Mesh, u32, Range<usize>)>,
    others: Vec<Other>,
    references: Vec<Reference>,
    /// Boxes around the elements that emit light.
    pub emitters: Vec<Bounds>,
}

impl Builder {
    pub fn elements<'s>(&mut self, primitives: &'s [Primitive], origin: DVec3) -> Elements<'s> {
        let mut all = Elements { origin, ..Elements::default() };
        for shape in primitives {
            let primitive = self.curved_of.len() as u32;
            self.curved_of.push(NOT_CURVED);
            let before = all.references.len();
            match &shape.shape {
                Shape::Quadric(quadric) => {
                    let shape = Curved::new(quadric, origin);
                    let (half, number) = (shape.half_extent(), self.curved.len() as u32);
                    let bounds = Bounds::padded(shape.center - half, shape.center + half, shape.magnitude());
                    all.push(bounds, Other::Curved { primitive, shape: number });
                    self.curved.push(shape);
                    self.curved_of[primitive as usize] = number;
                }
                Shape::Curve(curve) => {
                    for (piece, [low, high], magnitude) in self.curves.add(curve, origin) {
                        all.push(Bounds::padded(low, high, magnitude), Other::Curve { primitive, piece });
                    }
                }
                Shape::TriangleMesh(mesh) => all.push_mesh(mesh, primitive),
            }
            if shape.emission.is_some() && all.references.len() > before {
                all.emitters.push(around(&all.references[before..]));
            }
        }
        all
    }
}

impl<'s> Elements<'s> {
    pub fn push(&mut self, bounds: Bounds, other: Other) {
        self.references.push(Reference::other(bounds, self.others.len() as u32));
        self.others.push(other);
    }

    fn push_mesh(&mut self, mesh: &'s Mesh, primitive: u32) {
        let first = self.meshes.last().map_or(0, |(.., range)| range.end);
        let origin = self.origin;
        let reference = |index: usize| {
            // Triangles without area cannot be seen.
            mesh.has_area(index).then(|| {
                let Extent { low, high, .. } = Extent::new(&corners(mesh, index, origin));
                Reference::triangle(Bounds::new(low, high), (first + index) as u32)
            })
        };
        self.references
            .par_extend((0..mesh.triangles()).into_par_iter().with_min_len(1 << 12).filter_map(reference));
        self.meshes.push((mesh, primitive, first..first + mesh.triangles()));
    }

    /// Sorts the elements into a tree.
    pub fn group(mut self) -> Group {
        let mut references = std::mem::take(&mut self.references);
        let tree = build(&mut references);
        let sorted: Vec<u32> = references.iter().filter(|it| it.is_triangle).map(|it| it.number).collect();
        drop(references);
        let triangles: Vec<Triangle> = sorted.par_iter().map(|number| self.triangle(*number)).collect();
        let mut end = 0;
        let next = |length: &u8| {
            end += usize::from(*length);
            end - usize::from(*length)..end
        };
        let ranges: Vec<Range<usize>> = tree.blocks.iter().map(next).collect();
        let block = |range: &Range<usize>| Block::new(&triangles[range.clone()], range.start);
        let blocks = ranges.par_iter().map(block).collect();
        Group { bvh: tree.bvh, blocks, triangles, others: self.others }
    }

    fn triangle(&self, number: u32) -> Triangle {
        let number = number as usize;
        let at = self.meshes.partition_point(|(.., range)| range.end <= number);
        let (mesh, primitive, range) = &self.meshes[at];
        Triangle::new(mesh, number - range.start, *primitive, self.origin)
    }
}
