//! Where the origin of coordinates lies.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use lookat_scene::{Object, Primitive, Shape, World};
use rayon::prelude::*;

use crate::curved::Curved;
use crate::instance::placed_box;
use crate::triangle::corners;

/// The places where the origin may lie: multiples of the side of a cell.
///
/// Cells are small enough that `f32` tells neighbors apart, and large enough that a camera seldom leaves one: as large as 4
/// worlds, but at most 1024 of the smaller shapes.
pub(super) struct Lattice {
    /// A power of two, or 0 for a world without extent.
    cell: f64,
}

/// The side of a cell in sizes of shapes.
const CELL: f64 = 1024.0;
/// This share of the shapes is smaller than the size that counts.
const SMALLER: usize = 10;
/// The most that it is in sizes of the world.
const WORLDS: f64 = 4.0;
/// About as many shapes are measured at most: a few tell how large they are.
const MEASURED: usize = 1 << 12;

/// A box along the axes.
type Corners = [DVec3; 2];

impl Lattice {
    pub fn new(world: &World) -> Lattice {
        let mut boxes = boxes(&world.primitives, stride(&world.primitives));
        let every = world.instances.len().div_ceil(MEASURED).max(1);
        let mut known: HashMap<*const Object, Corners> = HashMap::new();
        boxes.extend(world.instances.iter().step_by(every).map(|instance| {
            let object =
                known.entry(Arc::as_ptr(&instance.object)).or_insert_with(|| of_object(&instance.object));
            placed_box(*object, |p| instance.world_from_object.point(p))
        }));
        // Objects without an element have no box.
        boxes.retain(|[low, high]| low.is_finite() && high.is_finite());
        let [low, high] = around(boxes.iter().copied());
        let mut sizes: Vec<f64> = boxes.iter().map(|[low, high]| (high - low).max_element()).collect();
        sizes.retain(|size| *size > 0.0);
        let at = sizes.len() / SMALLER;
        let small = if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(at, f64::total_cmp).1 };
        let side = (CELL * small).min(WORLDS * (high - low).max_element());
        let is_normal = side.is_normal() && side > 0.0;
        Lattice { cell: if is_normal { libm::exp2(libm::log2(side).floor()) } else { 0.0 } }
    }

    /// The origin for an eye: the nearest place of the lattice, or the eye itself where the lattice is too fine for it.
    pub fn origin(&self, eye: DVec3) -> DVec3 {
        // Adds 0, so that no coordinate is -0.
        let origin = (eye / self.cell).round() * self.cell + DVec3::ZERO;
        if origin.is_finite() { origin } else { eye }
    }
}

/// How many triangles a shape has; a quadric or a curve counts as one.
fn elements(primitive: &Primitive) -> usize {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => mesh.triangles(),
        Shape::Quadric(_) | Shape::Curve(_) => 1,
    }
}

/// The box around an element.
fn corners_of(primitive: &Primitive, index: usize) -> Corners {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => around(corners(mesh, index, DVec3::ZERO).map(|p| [p; 2])),
        Shape::Quadric(quadric) => {
            let shape = Curved::new(quadric, DVec3::ZERO);
            [shape.center - shape.half_extent(), shape.center + shape.half_extent()]
        }
        Shape::Curve(curve) => {
            around(curve.segments.iter().flatten().map(|p| [curve.world_from_object.point(*p); 2]))
        }
    }
}

/// The box around what can be seen of a shape: `None` for a mesh without area.
pub(crate) fn corners_of_shape(primitive: &Primitive) -> Option<Corners> {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => {
            let drawn = (0..mesh.triangles()).into_par_iter().with_min_len(1 << 12);
            let drawn = drawn.filter(|index| mesh.has_area(*index));
            drawn.map(|index| corners_of(primitive, index)).reduce_with(|a, b| around([a, b]))
        }
        Shape::Quadric(_) | Shape::Curve(_) => Some(corners_of(primitive, 0)),
    }
}

/// The boxes around every so many of the elements.
fn boxes(primitives: &[Primitive], stride: usize) -> Vec<Corners> {
    let mut boxes = Vec::new();
    let mut number: usize = 0;
    for primitive in primitives {
        let count = elements(primitive);
        let first = number.next_multiple_of(stride) - number;
        boxes.extend((first..count).step_by(stride).map(|index| corners_of(primitive, index)));
        number += count;
    }
    boxes
}

/// A box around an object, in its own space.
fn of_object(object: &Object) -> Corners {
    around(boxes(&object.primitives, stride(&object.primitives)))
}

fn around(boxes: impl IntoIterator<Item = Corners>) -> Corners {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    boxes.into_iter().fold(nothing, |[low, high], corners| [low.min(corners[0]), high.max(corners[1])])
}

/// The distance of boxes to measure, so that they are not too many.
fn stride(primitives: &[Primitive]) -> usize {
    primitives.iter().map(elements).sum::<usize>().div_ceil(MEASURED).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scene;

    fn lattice(world: &str) -> Lattice {
        Lattice::new(
            &scene(&format!(
                "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
                LightSource \"infinite\" {world} WorldEnd"
            ))
            .world,
        )
    }

    const GROUND: &str = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
        \"point P\" [-1e6 0 -1e6 -1e6 0 1e6 1e6 0 1e6 1e6 0 -1e6]";
    const BALL: &str = "Shape \"sphere\"";

    #[test]
    fn cells_are_about_as_large_as_what_there_is_to_see() {
        assert_eq!(lattice(BALL).cell, 8.0);
        assert_eq!(lattice(GROUND).cell, 4_194_304.0);
        // 1,024 times the size of the ball, the smallest shape.
        assert_eq!(lattice(&format!("{GROUND} {BALL}")).cell, 2048.0);
        assert_eq!(lattice(&format!("Translate 1e8 0 0 {BALL}")).cell, 8.0);
        let placed = format!("ObjectBegin \"a\" {BALL} ObjectEnd Scale 8 8 8 ObjectInstance \"a\"");
        assert_eq!(lattice(&placed).cell, 64.0);
        let curve = "Shape \"curve\" \"point P\" [0 0 0 0 0 1 0 0 2 0 0 4]";
        assert_eq!(lattice(curve).cell, 16.0);
    }

    #[test]
    fn shapes_are_measured_far_into_long_lists() {
        let long = format!("{GROUND} {}", "Translate 2 0 0 Shape \"sphere\" ".repeat(3 * MEASURED));
        assert_eq!(lattice(&long).cell, 2048.0);
    }

    #[test]
    fn the_origin_is_near_the_eye() {
        let lattice = lattice(BALL);
        let eye = DVec3::new(3.1, -700.2, 1e9 + 0.1);
        let origin = lattice.origin(eye);
        assert!((eye - origin).abs().max_element() <= 4.0 && origin != eye);
        assert_eq!(lattice.origin(origin + 3.9), origin);
        // Where there is nothing, or it is too small for the eye, coordinates are relative to the eye.
        for cell in [0.0, 1e-300] {
            assert_eq!(Lattice { cell }.origin(eye * 1e20), eye * 1e20);
        }
        assert_eq!(Lattice::new(&World::default()).origin(eye), eye);
    }
}
