//! What two worlds have in common.

use std::collections::HashMap;
use std::sync::Arc;

use lookat_image::MipMap;
use lookat_scene::{Emission, Instance, Light, Mesh, Object, Primitive, Shape, Transform, World};

/// Whether worlds have the same trees: shapes and instances at the same places in the same order, and the same of them emit.
pub(super) fn is_geometry(a: &World, b: &World) -> bool {
    are_shapes(&a.primitives, &b.primitives)
        && a.instances.len() == b.instances.len()
        && a.objects().len() == b.objects().len()
        && are_instances(&a.instances, &b.instances)
}

/// Whether worlds of the same geometry have the same light tables.
pub(super) fn are_lights(a: &World, b: &World) -> bool {
    // Its place in the text makes no difference.
    let light = |shape: &Primitive| shape.emission.map(|emission| Emission { span: None, ..emission });
    let is_emitter = |(a, b): (&Primitive, &Primitive)| match a.emission {
        // Textures are not compared, and a table keeps its mesh.
        Some(_) => {
            let has_cutout = a.cutout.is_some() || b.cutout.is_some();
            let is_mesh = match (&a.shape, &b.shape) {
                (Shape::TriangleMesh(a), Shape::TriangleMesh(b)) => Arc::ptr_eq(a, b),
                _ => true,
            };
            let is_side = (a.reverse_orientation, a.mirrored) == (b.reverse_orientation, b.mirrored);
            light(a) == light(b) && !has_cutout && is_mesh && is_side
        }
        None => true,
    };
    a.lights.len() == b.lights.len()
        && a.lights.iter().zip(&b.lights).all(|(a, b)| is_light(a, b))
        && a.primitives.iter().zip(&b.primitives).all(is_emitter)
}

fn are_instances(a: &[Instance], b: &[Instance]) -> bool {
    // Each object of one world is one object of the other.
    let mut objects: HashMap<*const Object, *const Object> = HashMap::new();
    let mut is_object =
        |a: &Arc<Object>, b: &Arc<Object>| match objects.insert(Arc::as_ptr(a), Arc::as_ptr(b)) {
            Some(known) => known == Arc::as_ptr(b),
            None => are_shapes(&a.primitives, &b.primitives),
        };
    a.iter().zip(b).all(|(a, b)| {
        is_transform(&a.world_from_object, &b.world_from_object) && is_object(&a.object, &b.object)
    })
}

fn are_shapes(a: &[Primitive], b: &[Primitive]) -> bool {
    let is_one = |(a, b): (&Primitive, &Primitive)| {
        a.emission.is_some() == b.emission.is_some() && is_shape(&a.shape, &b.shape)
    };
    a.len() == b.len() && a.iter().zip(b).all(is_one)
}

fn is_shape(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::TriangleMesh(a), Shape::TriangleMesh(b)) => Arc::ptr_eq(a, b) || is_mesh(a, b),
        (Shape::Quadric(a), Shape::Quadric(b)) => {
            a == b && is_transform(&a.world_from_object, &b.world_from_object)
        }
        (Shape::Curve(a), Shape::Curve(b)) => {
            a == b && is_transform(&a.world_from_object, &b.world_from_object)
        }
        _ => false,
    }
}

fn is_mesh(a: &Mesh, b: &Mesh) -> bool {
    a.indices() == b.indices()
        && are_bits(a.positions().as_flattened(), b.positions().as_flattened())
        && are_bits(a.normals().as_flattened(), b.normals().as_flattened())
        && are_bits(a.tangents().as_flattened(), b.tangents().as_flattened())
        && are_bits(a.uvs().as_flattened(), b.uvs().as_flattened())
}

fn is_transform(a: &Transform, b: &Transform) -> bool {
    let bits = |transform: &Transform| {
        [transform.matrix(), transform.inverse_matrix()]
            .map(|matrix| matrix.to_cols_array().map(f64::to_bits))
    };
    bits(a) == bits(b)
}

/// Whether numbers have the same bits: 0 is not -0.
fn are_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn is_light(a: &Light, b: &Light) -> bool {
    // Comparing pictures takes longer than preparing other lights.
    let is_map = |a: &Arc<MipMap<_>>, b: &Arc<MipMap<_>>| Arc::ptr_eq(a, b);
    match (a, b) {
        (Light::Environment { map, .. }, Light::Environment { map: other, .. }) if !is_map(map, other) => {
            false
        }
        (Light::Goniometric { map, .. }, Light::Goniometric { map: other, .. }) if !is_map(map, other) => {
            false
        }
        _ => a == b,
    }
}
