//! `Shape`: forms and their places.

mod curve;
mod heightfield;
mod loop_subdivision;
mod nurbs;

use std::sync::Arc;

use glam::DMat3;

use crate::Transform;
use crate::mesh::{Mesh, ply_mesh, triangle_mesh};
use crate::params::Params;
use crate::transform::LARGEST;

pub use curve::{Curve, CurveKind};

/// A form in its place.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A sphere around the origin of its object space, or part of one.
    Sphere(Box<Sphere>),
    /// Triangles.
    TriangleMesh(Arc<Mesh>),
    /// A band along a curve.
    Curve(Box<Curve>),
}

/// A sphere around the origin of object space, cut by planes of constant z and by an angle about the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Radius in object space, more than 0 (`radius`, default 1).
    pub radius: f64,
    /// Lowest z, from -radius (`zmin`, default -radius).
    pub z_min: f64,
    /// Highest z, to radius, above `z_min` (`zmax`, default radius).
    pub z_max: f64,
    /// Sweep about z from +x towards +y, in radians, more than 0 and at most 2 pi (`phimax`, default 360 degrees).
    pub phi_max: f64,
    /// Its place.
    pub world_from_object: Transform,
}

pub(crate) const NAMES: &[&str] = &[
    "sphere",
    "trianglemesh",
    "plymesh",
    "disk",
    "cylinder",
    "cone",
    "paraboloid",
    "hyperboloid",
    "curve",
    "heightfield",
    "loopsubdiv",
    "nurbs",
];

/// pbrt-v3's MakeShapes. The parameters that stay are those of the material, or unknown.
pub(crate) fn shape(params: &mut Params, world_from_object: Transform) -> Option<Shape> {
    match params.kind() {
        "sphere" => sphere(params, world_from_object).map(|sphere| Shape::Sphere(Box::new(sphere))),
        "trianglemesh" => {
            triangle_mesh(params, world_from_object).map(|mesh| Shape::TriangleMesh(Arc::new(mesh)))
        }
        "plymesh" => ply_mesh(params, world_from_object).map(|mesh| Shape::TriangleMesh(Arc::new(mesh))),
        "curve" => curve::curve(params, world_from_object).map(|curve| Shape::Curve(Box::new(curve))),
        "heightfield" => heightfield::heightfield(params, world_from_object).map(mesh),
        "loopsubdiv" => loop_subdivision::loop_subdivision(params, world_from_object).map(mesh),
        "nurbs" => nurbs::nurbs(params, world_from_object).map(mesh),
        kind if NAMES.contains(&kind) => {
            let message = format!("Shape \"{kind}\" is not rendered yet; it is left out");
            params.unsupported(message);
            params.ignore_rest();
            None
        }
        _ => {
            params.unknown_kind::<()>(NAMES);
            params.ignore_rest();
            None
        }
    }
}

fn mesh(mesh: Mesh) -> Shape {
    Shape::TriangleMesh(Arc::new(mesh))
}

fn sphere(params: &mut Params, world_from_object: Transform) -> Option<Sphere> {
    let radius = params.float("radius", 1.0);
    let linear = DMat3::from_mat4(world_from_object.m).to_cols_array();
    let largest = LARGEST / linear.iter().fold(1.0_f64, |max, x| max.max(x.abs()));
    if radius <= 0.0 {
        params.reject("radius", "the radius of a sphere must be more than 0", None);
    } else if !(LARGEST.recip()..=largest).contains(&radius) {
        let least = LARGEST.recip();
        let message = format!("the radius of a sphere must be from {least:e} to {largest:.1e} here");
        params.reject("radius", message, None);
    }
    let (z_min, z_max) = (params.float("zmin", -radius), params.float("zmax", radius));
    // Underlines the one that is given, where only one is.
    let given = if params.was_taken("zmin") { "zmin" } else { "zmax" };
    if radius > 0.0 && z_min >= z_max {
        params.reject(given, format!("zmin {z_min} is not below zmax {z_max}"), None);
    } else if radius > 0.0 && (z_min >= radius || z_max <= -radius) {
        params.reject(given, "nothing of the sphere lies between zmin and zmax", None);
    }
    let phi_max = params.float("phimax", 360.0);
    if phi_max <= 0.0 {
        params.reject("phimax", "phimax must be more than 0 degrees", None);
    }
    params.usable().then(|| Sphere {
        radius,
        z_min: z_min.max(-radius),
        z_max: z_max.min(radius),
        phi_max: phi_max.min(360.0).to_radians(),
        world_from_object,
    })
}
