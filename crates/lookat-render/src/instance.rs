//! Copies of objects, in their places.

use glam::{DMat3, DVec3};
use lookat_scene::Transform;

use crate::bounds::Bounds;
use crate::parametric::Parametric;
use crate::ray::Ray;

/// A copy of an object.
pub(crate) struct PlacedInstance {
    pub object: usize,
    /// Takes world positions to the object: a matrix and an offset.
    object_from_world: DMat3,
    offset: DVec3,
    world_from_object: DMat3,
    origin: DVec3,
}

impl PlacedInstance {
    /// The copy of the object of a number, in a world of that origin.
    pub fn new(object: usize, world_from_object: &Transform, world_origin: DVec3) -> Self {
        let (m, inv) = (world_from_object.matrix(), world_from_object.inverse_matrix());
        PlacedInstance {
            object,
            object_from_world: DMat3::from_mat4(inv),
            offset: inv.transform_point3(world_origin),
            world_from_object: DMat3::from_mat4(m),
            origin: m.w_axis.truncate() - world_origin,
        }
    }

    /// A position of the world in the space of the object.
    pub fn to_object(&self, p: DVec3) -> DVec3 {
        self.object_from_world * p + self.offset
    }

    /// The largest coordinate that the way back to the world computes with, for a position of the object whose own
    /// coordinates are up to `magnitude`.
    pub fn magnitude(&self, magnitude: f64) -> f64 {
        let m = &self.world_from_object;
        let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        (rows * magnitude + self.origin.abs()).max_element()
    }

    /// And back.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.world_from_object * p + self.origin
    }

    /// A unit normal of the object, in the world.
    pub fn normal_to_world(&self, n: DVec3) -> DVec3 {
        (self.object_from_world.transpose() * n).normalize_or(DVec3::Z)
    }

    /// A direction of the world, in the object; distances along it are the same.
    pub fn vector_to_object(&self, v: DVec3) -> DVec3 {
        self.object_from_world * v
    }

    /// A normal of the world, in the object.
    pub fn normal_to_object(&self, n: DVec3) -> DVec3 {
        (self.world_from_object.transpose() * n).normalize_or(DVec3::Z)
    }

    /// Derivatives in the object, in the world.
    pub fn parametric_to_world(&self, object: Parametric) -> Parametric {
        let normals = self.object_from_world.transpose();
        Parametric {
            uv: object.uv,
            dpdu: self.world_from_object * object.dpdu,
            dpdv: self.world_from_object * object.dpdv,
            dndu: normals * object.dndu,
            dndv: normals * object.dndv,
        }
    }

    /// The ray in the space of the object; distances along it are the same.
    pub fn ray(&self, ray: &Ray, t_max: f64) -> Ray {
        Ray { o: self.to_object(ray.o), d: self.object_from_world * ray.d, t_max, ..*ray }
    }

    /// A box around the copy of an object with a box.
    pub fn bounds(&self, object: Bounds) -> Bounds {
        let (low, high) = object.corners();
        let [min, max] = placed_box([low, high], |p| self.to_world(p));
        Bounds::padded(min, max, self.magnitude(low.abs().max(high.abs()).max_element()))
    }
}

/// The box around a placed box. Rounding is not covered.
pub(crate) fn placed_box(corners: [DVec3; 2], place: impl Fn(DVec3) -> DVec3) -> [DVec3; 2] {
    let corner = |at: usize| {
        let pick = |axis: usize| corners[at >> axis & 1][axis];
        place(DVec3::new(pick(0), pick(1), pick(2)))
    };
    let points: [DVec3; 8] = std::array::from_fn(corner);
    let min = points.iter().fold(DVec3::INFINITY, |min, p| min.min(*p));
    let max = points.iter().fold(DVec3::NEG_INFINITY, |max, p| max.max(*p));
    [min, max]
}
