//! The texture coordinates of surfaces, whatever their shapes.

use fearless_simd::{Simd, mask64x8, prelude::*};
use lookat_scene::Shape;

use super::Found;
use crate::number::{LANES, those, vectorized};
use crate::parametric::Parametrics;
use crate::surface::points::Surfaces;
use crate::traceable::Traceable;
use crate::triangle::parametric::Triangles;

/// Texture coordinates: of the surfaces themselves, and as their shading normals have it.
pub(super) struct Coordinates<S: Simd> {
    pub flat: Parametrics<S>,
    pub shading: Parametrics<S>,
}

impl<S: Simd> Coordinates<S> {
    /// Of surfaces that are active, where rays have found them.
    #[inline(never)]
    pub fn new(
        scene: &Traceable,
        surfaces: &Surfaces<S>,
        found: &[Option<Found>; LANES],
        active: mask64x8<S>,
    ) -> Self {
        let simd = active.token();
        vectorized!(simd, {
            let all = || those(active).filter_map(|lane| Some((lane, found[lane].as_ref()?)));
            let mut triangles = Triangles::default();
            for (lane, (_, hit)) in all() {
                let (primitive, index) = (scene.primitive(hit.element.primitive), hit.element.index);
                if let Shape::TriangleMesh(mesh) = &primitive.shape {
                    let mut ns = surfaces.ns.lane(lane);
                    if let Some(instance) = scene.instance(hit.element.instance) {
                        ns = instance.normal_to_object(ns);
                    }
                    let normal = (ns, primitive.reverse_orientation);
                    triangles.put(lane, (mesh, index as usize), hit.barycentric, normal);
                }
            }
            let [flat, shading] = triangles.parametrics(simd);
            let mut coordinates = Coordinates { flat, shading };
            for (lane, found) in all() {
                coordinates.place(scene, surfaces, (lane, found));
            }
            coordinates
        })
    }

    /// What is no triangle of the world, one by one.
    #[inline(never)]
    fn place(&mut self, scene: &Traceable, surfaces: &Surfaces<S>, (lane, (ray, hit)): (usize, &Found)) {
        let instance = scene.instance(hit.element.instance);
        let own = match &scene.primitive(hit.element.primitive).shape {
            Shape::TriangleMesh(_) if instance.is_none() => return,
            Shape::TriangleMesh(_) => [self.flat.lane(lane), self.shading.lane(lane)],
            Shape::Curve(_) => {
                let d = instance.map_or(ray.d, |instance| instance.vector_to_object(ray.d));
                [scene.curves.parametric(hit.element.index, d, hit.barycentric.into()); 2]
            }
            Shape::Quadric(_) => {
                let p = surfaces.p.lane(lane);
                let p = instance.map_or(p, |instance| instance.to_object(p));
                // Every quadric is one of the curved shapes.
                let curved = scene.curved(hit.element.primitive);
                [curved.map(|curved| curved.parametric(p)).unwrap_or_default(); 2]
            }
        };
        let [flat, shading] = own.map(|own| match instance {
            Some(instance) => instance.parametric_to_world(own),
            None => own,
        });
        self.flat.put(lane, &flat);
        self.shading.put(lane, &shading);
    }
}
