//! `Shape`: geometry and placement.

mod curve;
mod loop_subdivision;
mod nurbs;
mod quadric;

use std::sync::Arc;

use lookat_syntax::{ParamType, Text};

use crate::Transform;
use crate::cache::KeptMesh;
use crate::mesh::{self, Mesh, VertexShading, finish, grid, triangle_mesh};
use crate::params::Params;
use crate::params::value::{Floats, OptionalInteger};
use crate::schema::{Key, Kind, Range};

pub use crate::shape::curve::{Curve, CurveKind};
pub(crate) use crate::shape::quadric::Limits;
pub use crate::shape::quadric::{
    Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Quadric, QuadricForm, Sphere,
};

/// A placed shape.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A surface of revolution around the z axis of object space.
    Quadric(Arc<Quadric>),
    /// Triangles.
    TriangleMesh(Arc<Mesh>),
    /// A curve with a width.
    Curve(Arc<Curve>),
}

impl Shape {
    /// True if the transformation of a quadric or a curve swaps handedness. `None` for a mesh, whose vertices are transformed.
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

    /// True for a mesh without triangles that have an area.
    pub(crate) fn is_invisible(&self) -> bool {
        matches!(self, Shape::TriangleMesh(mesh) if 3 * mesh.without_area() == mesh.indices.len())
    }
}

pub(crate) const KINDS: &[Kind] = &[
    quadric::SPHERE_KIND,
    mesh::TRIANGLE_MESH,
    mesh::PLY_MESH,
    quadric::DISK_KIND,
    quadric::CYLINDER_KIND,
    quadric::CONE_KIND,
    quadric::PARABOLOID_KIND,
    quadric::HYPERBOLOID_KIND,
    curve::KIND,
    KIND,
    loop_subdivision::KIND,
    nurbs::KIND,
];

/// What a Shape directive makes.
pub(crate) enum Geometry {
    Shape(Shape),
    /// A mesh to be read from a file.
    PlyFile(Text),
}

/// pbrt-v3's MakeShapes. The remaining parameters belong to the material or are unknown. `kept` is the mesh, if an earlier load has
/// made it.
pub(crate) fn shape(params: &mut Params, kept: Option<KeptMesh>, ctm: &Arc<Transform>) -> Option<Geometry> {
    let world_from_object = **ctm;
    let shape = match params.kind() {
        "plymesh" => return params.take(&mesh::FILE_NAME).map(Geometry::PlyFile),
        "trianglemesh" => triangle_mesh(params, kept, world_from_object).map(Shape::TriangleMesh),
        "curve" => curve::curve(params, ctm).map(|curve| Shape::Curve(Arc::new(curve))),
        "heightfield" => heightfield(params, world_from_object).map(triangles),
        "loopsubdiv" => loop_subdivision::loop_subdivision(params, world_from_object).map(triangles),
        "nurbs" => nurbs::nurbs(params, world_from_object).map(triangles),
        _ if !params.is_known_kind(KINDS) => {
            params.ignore_rest();
            return params.reject_unknown_type(KINDS);
        }
        _ => quadric::quadric(params, world_from_object).map(|quadric| Shape::Quadric(Arc::new(quadric))),
    };
    shape.map(Geometry::Shape)
}

fn triangles(mesh: Mesh) -> Shape {
    Shape::TriangleMesh(Arc::new(mesh))
}

const NU: Key<OptionalInteger> =
    Key::optional_integer("nu", "the number of heights along u").within(Range::at_least(2.0)).required();
const NV: Key<OptionalInteger> =
    Key::optional_integer("nv", "the number of heights along v").within(Range::at_least(2.0)).required();
const HEIGHTS: Key<Floats> =
    Key::new("Pz", ParamType::Float, Floats, "nu times nv heights, in rows along x").required();

pub(super) const KIND: Kind =
    Kind::new("heightfield", "flat triangles over a grid of the unit square", &[&[&NU, &NV, &HEIGHTS]]);

/// pbrt-v3's CreateHeightfield: `Pz` has `nv` rows along y, each with `nu` heights along x.
pub(crate) fn heightfield(params: &mut Params, world_from_object: Transform) -> Option<Mesh> {
    let size = [&NU, &NV].map(|key| params.take(key));
    let heights = params.take(&HEIGHTS)?;
    let [nu, nv] = size.map(|count| count.unwrap_or_default() as usize);
    if nu.checked_mul(nv) != Some(heights.len()) && params.usable() {
        let message = format!("nu times nv is {nu} times {nv}, but there are {} heights", heights.len());
        params.reject("Pz", message, None);
    }
    if !params.usable() {
        return None;
    }
    // A position, coordinates, and the corners of two triangles.
    drop(params.reserve("Pz", (nu * nv).saturating_mul(24 + 16 + 2 * 12))?);
    let uvs: Vec<[f64; 2]> =
        (0..nv).flat_map(|v| (0..nu).map(move |u| [share(u, nu), share(v, nv)])).collect();
    let positions = uvs.iter().zip(heights).map(|([x, y], z)| [*x, *y, z]).collect();
    let mesh = Mesh { positions, indices: grid(nu, nv).into(), ..Mesh::default() }
        .with_shading(VertexShading { uvs: uvs.into(), ..VertexShading::default() });
    finish(params, mesh, world_from_object)
}

/// The position of a point along its side, from 0 to 1.
fn share(at: usize, of: usize) -> f64 {
    at as f64 / (of - 1) as f64
}
