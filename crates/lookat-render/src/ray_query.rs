//! Rays in a prepared world, for tools and measurements: what the renderer does with them, and nothing else. All positions are
//! relative to [`Prepared::origin`], unless they are said to be in the world.

use glam::{DVec2, DVec3};
use lookat_scene::{Primitive, View};

use crate::frame::Bounds;
use crate::prepare::{Prepared, corners_of_shape};
use crate::ray::{Hit, Ray, ShapeId};
use crate::surface::Surface;

/// A shape at a place of a picture.
#[derive(Debug, Clone, Copy)]
pub struct Picked<'p> {
    /// The shape, with the place of its directive. An instance gives a shape of its object.
    pub primitive: &'p Primitive,
    /// The point that is seen, in the world.
    pub p: DVec3,
    /// The unit normal there, on the side of the eye.
    pub n: DVec3,
    /// The z of the point in camera space: the focal distance at which it is sharp. Negative behind an environment camera.
    pub depth: f64,
}

impl Prepared {
    /// The position in the world that others are relative to.
    pub fn origin(&self) -> DVec3 {
        self.traceable.origin
    }

    /// The nearest hit of a ray.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.traceable.nearest(ray)
    }

    /// The nearest hit of a ray without trees, by testing every element in turn. `lookat stability` compares trees with it, to
    /// the bit, in V1 to V3. Only the renderer can compute it, because elements are rounded relative to [`Prepared::origin`].
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        self.traceable.nearest_by_all(ray)
    }

    /// True if anything is in the way of a ray that ends at its `t_max`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.traceable.occluded(ray)
    }

    /// The surface at a hit of a ray.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'_> {
        Surface::new(&self.traceable, ray, hit)
    }

    /// The shape that a view shows at `film`, in pixels from the top left corner of the full picture, through the middle of
    /// the lens. Surfaces without a material are seen, holes are not. `None` where there is nothing.
    pub fn pick(&self, view: &View, film: DVec2) -> Option<Picked<'_>> {
        let camera = self.camera(view);
        let ray = camera.ray(film, DVec2::splat(0.5));
        let Surface { p, n, primitive, .. } = self.surface(&ray, &self.nearest(&ray)?).facing(ray.d);
        Some(Picked { primitive, p: p + self.origin(), n, depth: camera.depth(p) })
    }

    /// The shapes of the world, then the instances that can be seen.
    pub fn shape_ids(&self) -> impl Iterator<Item = ShapeId> {
        let (primitives, instances) = (self.world().primitives.len() as u32, self.traceable.instances.len());
        (0..primitives).map(ShapeId::Primitive).chain((0..instances as u32).map(ShapeId::Instance))
    }

    /// The primitive of a shape; of an instance, the first of its object.
    pub fn primitive(&self, shape: ShapeId) -> &Primitive {
        let number = match shape {
            ShapeId::Primitive(number) => number,
            ShapeId::Instance(number) => {
                self.traceable.first_of_objects[self.traceable.instances[number as usize].object]
            }
        };
        self.traceable.primitive(number)
    }

    /// Two opposite corners of the box around a shape in the world. `None` for a mesh without area, which cannot be seen.
    pub fn shape_bounds(&self, shape: ShapeId) -> Option<[DVec3; 2]> {
        match shape {
            ShapeId::Primitive(_) => corners_of_shape(self.primitive(shape)),
            ShapeId::Instance(number) => {
                let placed = &self.traceable.instances[number as usize];
                let of_object = self.traceable.objects[placed.object].bvh.bounds;
                self.in_world(placed.bounds(of_object, self.origin()))
            }
        }
    }

    /// Two opposite corners of the box around all shapes in the world. `None` without shapes.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.in_world(self.traceable.world.bvh.bounds)
    }

    fn in_world(&self, bounds: Bounds) -> Option<[DVec3; 2]> {
        let (low, high) = bounds.corners();
        (!bounds.is_empty()).then(|| [low, high].map(|corner| corner + self.origin()))
    }
}

#[cfg(test)]
mod tests {
    use lookat_scene::load_str;

    use super::*;

    #[test]
    fn shapes_are_picked_with_their_lines() {
        let loaded = load_str(
            "LookAt 0 0 -10 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 60 \"float lensradius\" 1
            Film \"image\" \"integer xresolution\" 60 \"integer yresolution\" 60 Sampler \"sobol\" Integrator \"path\" WorldBegin
            LightSource \"infinite\"
            ObjectBegin \"o\"
              Shape \"disk\"
            ObjectEnd Translate -2 0 0
            Shape \"sphere\"
            Translate 4 0 1 ObjectInstance \"o\" WorldEnd",
        );
        let scene = loaded.scene.unwrap();
        let prepared = Prepared::new(&scene);
        let pixels = 30.0 / 30_f64.to_radians().tan();
        let pick = |x: f64, z: f64| {
            let film = DVec2::new(30.0 + pixels * x / (10.0 + z), 30.0);
            let Picked { primitive, p, n, depth } = prepared.pick(&scene.view, film)?;
            assert!((n.z + 1.0).abs() < 0.1 && (p.x - x).abs() < 0.2, "{p} {n}");
            Some((loaded.sources.location(primitive.span.unwrap()).line, depth))
        };
        let (line, depth) = pick(-1.8, -1.0).unwrap();
        assert!(line == 7 && (depth - 9.0).abs() < 0.05, "{line} {depth}");
        let (line, depth) = pick(2.0, 1.0).unwrap();
        assert!(line == 5 && (depth - 11.0).abs() < 1e-9, "{line} {depth}");
        assert_eq!(pick(0.0, 0.0), None);
    }
}
