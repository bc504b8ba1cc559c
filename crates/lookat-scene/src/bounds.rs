//! Boxes around shapes.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use crate::{Object, Primitive, Shape, Transform, World};

/// The lowest and the highest corner of a box.
type Bounds = [DVec3; 2];

impl World {
    /// The lowest and the highest corner of a box around all shapes, not always the smallest. `None` for a world
    /// without shapes.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut objects: HashMap<*const Object, Option<Bounds>> = HashMap::new();
        let instances = self.instances.iter().filter_map(|instance| {
            let object = objects.entry(Arc::as_ptr(&instance.object));
            let own =
                *object.or_insert_with(|| around(instance.object.primitives.iter().filter_map(of_shape)));
            own.map(|own| placed(own, &instance.world_from_object))
        });
        around(self.primitives.iter().filter_map(of_shape).chain(instances))
    }
}

fn of_shape(primitive: &Primitive) -> Option<Bounds> {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => around(mesh.positions().iter().map(|point| [DVec3::from(*point); 2])),
        Shape::Quadric(quadric) => {
            let (low, high) = quadric.corners();
            Some(placed([low, high], &quadric.world_from_object))
        }
        Shape::Curve(curve) => {
            let points = curve.segments.iter().flatten();
            around(points.map(|point| [curve.world_from_object.point(*point); 2]))
        }
    }
}

/// The box around a transformed box.
fn placed([low, high]: Bounds, transform: &Transform) -> Bounds {
    let (center, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let extent = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| transform.vector(axis * half).abs());
    let (center, extent) = (transform.point(center), extent[0] + extent[1] + extent[2]);
    [center - extent, center + extent]
}

fn around(boxes: impl Iterator<Item = Bounds>) -> Option<Bounds> {
    boxes.reduce(|[low, high], other| [low.min(other[0]), high.max(other[1])])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_str;

    fn bounds(world: &str) -> Option<Bounds> {
        load_str(&format!("WorldBegin {world} WorldEnd")).scene.unwrap().world.bounds()
    }

    #[test]
    fn bounds_hold_all_shapes() {
        assert_eq!(bounds("LightSource \"point\""), None);
        let ball = "Translate 1 2 3 Scale 2 1 1 Rotate 90 0 0 1 Shape \"disk\" \"float radius\" 3 \"float height\" 2";
        assert_eq!(bounds(ball), Some([DVec3::new(-5.0, -1.0, 5.0), DVec3::new(7.0, 5.0, 5.0)]));
        let mesh = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-9 0 0 0 8 0 0 0 1]";
        let both = format!(
            "ObjectBegin \"o\" Translate 0 0 9 Shape \"sphere\" ObjectEnd Translate 7 0 0 ObjectInstance \"o\" Identity {mesh}"
        );
        assert_eq!(bounds(&both), Some([DVec3::new(-9.0, -1.0, 0.0), DVec3::new(8.0, 8.0, 10.0)]));
    }
}
