//! `Shape`: geometry and placement.

mod cone;
mod curve;
mod cylinder;
mod disk;
mod heightfield;
mod hyperboloid;
mod limits;
mod loop_subdivision;
mod nurbs;
mod paraboloid;
mod sphere;

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;

use crate::Transform;
use crate::cache::KeptMesh;
use crate::mesh::{self, Mesh, ply_file, triangle_mesh};
use crate::params::{FileParam, Params};
use crate::schema::{Kind, names};
use limits::sweep;

pub use cone::Cone;
pub use curve::{Curve, CurveKind};
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use hyperboloid::Hyperboloid;
pub use paraboloid::Paraboloid;
pub use sphere::Sphere;

pub(crate) use limits::Limits;

/// A placed shape.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A surface of revolution around the z axis of object space.
    Quadric(Box<Quadric>),
    /// Triangles.
    TriangleMesh(Arc<Mesh>),
    /// A curve with a width.
    Curve(Arc<Curve>),
}

impl Shape {
    /// Whether the transformation of a quadric or a curve swaps handedness. `None` for a mesh, whose vertices are transformed.
    pub(crate) fn is_mirrored(&self) -> Option<bool> {
        match self {
            Shape::Quadric(quadric) => Some(quadric.world_from_object.swaps_handedness()),
            Shape::Curve(curve) => Some(curve.world_from_object.swaps_handedness()),
            Shape::TriangleMesh(_) => None,
        }
    }

    /// True for a mesh without triangles.
    pub(crate) fn is_empty(&self) -> bool {
        matches!(self, Shape::TriangleMesh(mesh) if mesh.indices.is_empty())
    }

    /// Whether it is a mesh all of whose triangles, if any, have zero area.
    pub(crate) fn is_invisible(&self) -> bool {
        matches!(self, Shape::TriangleMesh(mesh) if 3 * mesh.without_area() == mesh.indices.len())
    }
}

/// A quadric around the z axis of object space, or a part of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadric {
    /// The form.
    pub form: QuadricForm,
    /// The sweep angle about z from +x toward +y, in radians, above 0 and at most 2 pi (`phimax`, default 360
    /// degrees). A hyperboloid starts at its segment instead of +x.
    pub phi_max: f64,
    /// Its placement.
    pub world_from_object: Transform,
}

/// The form of a [`Quadric`], in object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuadricForm {
    /// A sphere around the origin.
    Sphere(Sphere),
    /// A disk or ring.
    Disk(Disk),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A cone.
    Cone(Cone),
    /// A paraboloid.
    Paraboloid(Paraboloid),
    /// A hyperboloid.
    Hyperboloid(Hyperboloid),
}

impl QuadricForm {
    /// The type name in scene files.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            QuadricForm::Sphere(_) => "sphere",
            QuadricForm::Disk(_) => "disk",
            QuadricForm::Cylinder(_) => "cylinder",
            QuadricForm::Cone(_) => "cone",
            QuadricForm::Paraboloid(_) => "paraboloid",
            QuadricForm::Hyperboloid(_) => "hyperboloid",
        }
    }
}

impl Quadric {
    /// A whole sphere around the origin of object space.
    pub fn sphere(radius: f64, world_from_object: Transform) -> Quadric {
        let form = QuadricForm::Sphere(Sphere { radius, z_min: -radius, z_max: radius });
        Quadric { form, phi_max: TAU, world_from_object }
    }

    /// The lowest and highest z, and the largest distance from the axis, in object space, for a full sweep.
    pub fn extent(&self) -> (f64, f64, f64) {
        match self.form {
            QuadricForm::Sphere(Sphere { radius, .. }) => (-radius, radius, radius),
            QuadricForm::Disk(Disk { height, radius, .. }) => (height, height, radius),
            QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }) => (z_min, z_max, radius),
            QuadricForm::Cone(Cone { radius, height }) => (0.0, height, radius),
            QuadricForm::Paraboloid(Paraboloid { radius, z_min, z_max }) => (z_min.max(0.0), z_max, radius),
            QuadricForm::Hyperboloid(Hyperboloid { p1, p2 }) => {
                (p1.z.min(p2.z), p1.z.max(p2.z), p1.truncate().length().max(p2.truncate().length()))
            }
        }
    }

    /// Two opposite corners of the bounding box in object space.
    pub fn corners(&self) -> (DVec3, DVec3) {
        let (low, high, radius) = self.extent();
        (DVec3::new(-radius, -radius, low), DVec3::new(radius, radius, high))
    }
}

pub(crate) const KINDS: &[Kind] = &[
    sphere::KIND,
    mesh::TRIANGLE_MESH,
    mesh::PLY_MESH,
    disk::KIND,
    cylinder::KIND,
    cone::KIND,
    paraboloid::KIND,
    hyperboloid::KIND,
    curve::KIND,
    heightfield::KIND,
    loop_subdivision::KIND,
    nurbs::KIND,
];

/// What a Shape directive makes.
pub(crate) enum Geometry {
    Shape(Shape),
    /// A mesh to be read from a file.
    PlyFile(FileParam),
}

/// pbrt-v3's MakeShapes. The remaining parameters belong to the material or are unknown. `kept` is the mesh, if an earlier load has
/// made it.
pub(crate) fn shape(
    params: &mut Params,
    kept: Option<KeptMesh>,
    world_from_object: Transform,
) -> Option<Geometry> {
    let shape = match params.kind() {
        "plymesh" => return ply_file(params).map(Geometry::PlyFile),
        "trianglemesh" => triangle_mesh(params, kept, world_from_object).map(Shape::TriangleMesh),
        "curve" => curve::curve(params, world_from_object).map(|curve| Shape::Curve(Arc::new(curve))),
        "heightfield" => heightfield::heightfield(params, world_from_object).map(triangles),
        "loopsubdiv" => loop_subdivision::loop_subdivision(params, world_from_object).map(triangles),
        "nurbs" => nurbs::nurbs(params, world_from_object).map(triangles),
        _ => quadric(params, world_from_object).map(|quadric| Shape::Quadric(Box::new(quadric))),
    };
    shape.map(Geometry::Shape)
}

fn quadric(params: &mut Params, world_from_object: Transform) -> Option<Quadric> {
    let limits = Limits::new(&world_from_object);
    let form = match params.kind() {
        "sphere" => QuadricForm::Sphere(sphere::sphere(params, &limits)),
        "disk" => QuadricForm::Disk(disk::disk(params, &limits)),
        "cylinder" => QuadricForm::Cylinder(cylinder::cylinder(params, &limits)),
        "cone" => QuadricForm::Cone(cone::cone(params, &limits)),
        "paraboloid" => QuadricForm::Paraboloid(paraboloid::paraboloid(params, &limits)),
        "hyperboloid" => QuadricForm::Hyperboloid(hyperboloid::hyperboloid(params, &limits)),
        _ => {
            params.unknown_kind::<()>(&names(KINDS));
            params.ignore_rest();
            return None;
        }
    };
    let phi_max = sweep(params).min(TAU);
    params.usable().then_some(Quadric { form, phi_max, world_from_object })
}

fn triangles(mesh: Mesh) -> Shape {
    Shape::TriangleMesh(Arc::new(mesh))
}
