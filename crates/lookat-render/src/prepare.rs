//! From a scene to what rays are traced against: everything relative to the eye, sorted into trees.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use lookat_scene::{Object, Primitive, Scene, Shape};

use crate::bounds::Bounds;
use crate::bvh::Bvh;
use crate::camera::CameraRays;
use crate::curve::Curves;
use crate::curved::Curved;
use crate::cutout;
use crate::parametric::Parametric;
use crate::ray::{ElementId, Hit, Ray};
use crate::triangle::{corners, extent, sorted};

#[cfg(not(feature = "plain-f32"))]
use {
    crate::curved::meet as meet_curved,
    crate::triangle::{ShearedRay as TriangleRay, corner},
    glam::DVec3 as Corner,
};
#[cfg(feature = "plain-f32")]
use {
    crate::plain::{PlainRay as TriangleRay, corner, curved as meet_curved},
    glam::Vec3 as Corner,
};

/// A scene that rays can be traced in. Positions are relative to the eye.
pub(crate) struct Traceable<'s> {
    /// The world position that coordinates are relative to.
    pub eye: DVec3,
    /// All primitives, those of the world first; element names refer to them.
    pub primitives: Vec<&'s Primitive>,
    curved: Vec<Curved>,
    /// Which of the curved shapes a primitive is, or [`NOT_CURVED`].
    curved_of: Vec<u32>,
    /// Curves; the index of an element names the piece.
    pub curves: Curves<'s>,
    world: Group,
    objects: Vec<Group>,
    instances: Vec<PlacedInstance>,
    /// Whether any mesh may have holes.
    has_cutouts: bool,
}

/// Elements with their tree.
struct Group {
    elements: Vec<Element>,
    bvh: Bvh,
}

const NOT_CURVED: u32 = u32::MAX;

/// What a leaf holds.
enum Element {
    /// Its corners are sorted; `first` are the places of the first two.
    Triangle {
        corners: [Corner; 3],
        primitive: u32,
        index: u32,
        first: [u8; 2],
    },
    Curved {
        primitive: u32,
        shape: u32,
    },
    Curve {
        primitive: u32,
        piece: u32,
    },
    Instance {
        instance: u32,
    },
}

/// A copy of an object.
pub(crate) struct PlacedInstance {
    object: usize,
    /// Takes eye-relative world positions to the object: a matrix and an offset.
    object_from_world: DMat3,
    offset: DVec3,
    world_from_object: DMat3,
    origin: DVec3,
}

impl<'s> Traceable<'s> {
    pub fn new(scene: &'s Scene) -> Self {
        let eye = CameraRays::eye(&scene.camera);
        let mut builder = Builder::default();
        let mut world = builder.elements(&scene.primitives, eye);
        // Each object is prepared once, in its own space, however many copies there are.
        let mut objects: Vec<Group> = Vec::new();
        let mut known: HashMap<*const Object, usize> = HashMap::new();
        let mut instances = Vec::new();
        for instance in &scene.instances {
            let object = *known.entry(Arc::as_ptr(&instance.object)).or_insert_with(|| {
                objects.push(Group::new(builder.elements(&instance.object.primitives, DVec3::ZERO)));
                objects.len() - 1
            });
            let (m, inv) = (instance.world_from_object.m, instance.world_from_object.inv);
            let placed = PlacedInstance {
                object,
                object_from_world: DMat3::from_mat4(inv),
                offset: inv.transform_point3(eye),
                world_from_object: DMat3::from_mat4(m),
                origin: m.w_axis.truncate() - eye,
            };
            let bounds = placed.bounds(objects[object].bounds());
            world.push(bounds, Element::Instance { instance: instances.len() as u32 });
            instances.push(placed);
        }
        let Builder { primitives, curved, curved_of, curves } = builder;
        let has_cutouts = primitives.iter().any(|primitive| primitive.cutout.is_some());
        let world = Group::new(world);
        Traceable { eye, primitives, curved, curved_of, curves, world, objects, instances, has_cutouts }
    }

    /// A box around everything.
    pub fn bounds(&self) -> Bounds {
        self.world.bounds()
    }

    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.nearest_of::<false>(ray)
    }

    /// The same, found without trees.
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        self.nearest_of::<true>(ray)
    }

    #[inline]
    fn nearest_of<const ALL: bool>(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = Hit { t: ray.t_max, element: ElementId::NONE, barycentric: [0.0; 2] };
        self.nearest_in::<ALL>(&self.world, ray, ElementId::WORLD, &mut hit);
        (hit.element != ElementId::NONE).then_some(hit)
    }

    /// Of `ALL` elements, or of those that the tree gives.
    fn nearest_in<const ALL: bool>(&self, group: &Group, ray: &Ray, instance: u32, hit: &mut Hit) {
        let sheared = TriangleRay::new(ray);
        let mut visit = |elements: &[Element]| {
            for element in elements {
                match element {
                    Element::Instance { instance } => {
                        let placed = &self.instances[*instance as usize];
                        let ray = placed.ray(ray, hit.t);
                        self.nearest_in::<ALL>(&self.objects[placed.object], &ray, *instance, hit);
                    }
                    other => {
                        if let Some(found) = self.meet(other, ray, &sheared, instance, hit.t)
                            && hit.yields_to(found.t, found.element)
                            && self.is_there(&found, false)
                        {
                            *hit = found;
                        }
                    }
                }
            }
            Some(hit.t)
        };
        if ALL {
            visit(&group.elements);
        } else {
            group.traverse(ray, visit);
        }
    }

    /// Whether anything but its target is in the way of a shadow ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_in(&self.world, ray, ElementId::WORLD)
    }

    fn occluded_in(&self, group: &Group, ray: &Ray, instance: u32) -> bool {
        let sheared = TriangleRay::new(ray);
        let mut found = false;
        group.traverse(ray, |elements| {
            found = elements.iter().any(|element| match element {
                Element::Instance { instance } => {
                    let placed = &self.instances[*instance as usize];
                    self.occluded_in(&self.objects[placed.object], &placed.ray(ray, ray.t_max), *instance)
                }
                other => self
                    .meet(other, ray, &sheared, instance, ray.t_max)
                    .is_some_and(|hit| hit.element != ray.target && self.is_there(&hit, true)),
            });
            (!found).then_some(ray.t_max)
        });
        found
    }

    /// Where the ray meets a triangle or curved shape, within `t_max`.
    #[inline]
    fn meet(
        &self,
        element: &Element,
        ray: &Ray,
        sheared: &TriangleRay,
        instance: u32,
        t_max: f64,
    ) -> Option<Hit> {
        match *element {
            Element::Triangle { ref corners, primitive, index, first } => {
                let (t, weights) = sheared.intersect(corners)?;
                let barycentric = first.map(|at| weights[usize::from(at)]);
                let element = ElementId { instance, primitive, index };
                // What is flat is not met again by a ray that leaves it.
                (t > 0.0 && t <= t_max && element != ray.leaving).then_some(Hit { t, element, barycentric })
            }
            Element::Curved { primitive, shape } => {
                let element = ElementId { instance, primitive, index: 0 };
                let t = meet_curved(&self.curved[shape as usize], ray, t_max, element == ray.leaving)?;
                Some(Hit { t, element, barycentric: [0.0; 2] })
            }
            Element::Curve { primitive, piece } => {
                let element = ElementId { instance, primitive, index: piece };
                let same = ElementId { index: ray.leaving.index, ..element } == ray.leaving;
                let leaving = same.then_some(ray.leaving.index);
                let meeting = self.curves.meet(piece, ray, t_max, leaving)?;
                Some(Hit { t: meeting.t, element, barycentric: meeting.uv.into() })
            }
            Element::Instance { .. } => None,
        }
    }

    /// Whether there is something where a ray meets a triangle, and no hole.
    #[inline]
    fn is_there(&self, hit: &Hit, is_shadow: bool) -> bool {
        let Hit { element, barycentric, .. } = *hit;
        !self.has_cutouts
            || cutout::is_there(self.primitives[element.primitive as usize], element, barycentric, is_shadow)
    }

    /// The curved shape that a primitive is.
    pub fn curved(&self, primitive: u32) -> Option<&Curved> {
        self.curved.get(self.curved_of[primitive as usize] as usize)
    }

    pub fn instance(&self, instance: u32) -> Option<&PlacedInstance> {
        self.instances.get(instance as usize)
    }
}

/// Numbers primitives as they come, and collects their elements.
#[derive(Default)]
struct Builder<'s> {
    primitives: Vec<&'s Primitive>,
    curved: Vec<Curved>,
    curved_of: Vec<u32>,
    curves: Curves<'s>,
}

/// Elements with their bounds.
#[derive(Default)]
struct Elements {
    bounds: Vec<Bounds>,
    elements: Vec<Element>,
}

impl Elements {
    fn push(&mut self, bounds: Bounds, element: Element) {
        self.bounds.push(bounds);
        self.elements.push(element);
    }
}

impl<'s> Builder<'s> {
    fn elements(&mut self, primitives: &'s [Primitive], eye: DVec3) -> Elements {
        let mut all = Elements::default();
        for shape in primitives {
            let primitive = self.primitives.len() as u32;
            self.primitives.push(shape);
            match &shape.shape {
                Shape::Quadric(quadric) => {
                    let shape = Curved::new(quadric, eye);
                    let half = shape.half_extent();
                    let number = self.curved.len() as u32;
                    all.push(
                        padded(shape.center - half, shape.center + half, shape.magnitude()),
                        Element::Curved { primitive, shape: number },
                    );
                    self.curved.push(shape);
                    self.curved_of.push(number);
                }
                Shape::Curve(curve) => {
                    self.curved_of.push(NOT_CURVED);
                    for (piece, [low, high], magnitude) in self.curves.add(curve, eye) {
                        all.push(padded(low, high, magnitude), Element::Curve { primitive, piece });
                    }
                }
                Shape::TriangleMesh(mesh) => {
                    self.curved_of.push(NOT_CURVED);
                    for index in 0..mesh.triangles() {
                        let corners = corners(mesh, index, eye);
                        // Triangles without area cannot be seen.
                        if mesh.has_area(index) {
                            let (sorted, first) = sorted(corners);
                            let element = Element::Triangle {
                                corners: sorted.map(corner),
                                primitive,
                                index: index as u32,
                                first,
                            };
                            let (low, high) = extent(&corners);
                            all.push(Bounds::new(low, high), element);
                        }
                    }
                }
            }
        }
        all
    }
}

/// A box whose corners were computed from coordinates of a magnitude: wider by what rounding may have taken.
fn padded(min: DVec3, max: DVec3, magnitude: f64) -> Bounds {
    let error = magnitude * 1e-14;
    Bounds::new(min - error, max + error)
}

impl Group {
    fn new(all: Elements) -> Self {
        let Elements { bounds, mut elements } = all;
        let (bvh, mut order) = Bvh::build(&bounds);
        reorder(&mut elements, &mut order);
        Group { elements, bvh }
    }

    fn bounds(&self) -> Bounds {
        self.bvh.bounds()
    }

    #[inline]
    fn traverse(&self, ray: &Ray, mut visit: impl FnMut(&[Element]) -> Option<f64>) {
        self.bvh.traverse(ray, |range| visit(&self.elements[range]));
    }
}

impl PlacedInstance {
    /// An eye-relative position in the space of the object.
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

    fn bounds(&self, object: Bounds) -> Bounds {
        let (low, high) = object.corners();
        let corner = |at: usize| {
            let pick = |axis: usize| if at >> axis & 1 == 0 { low[axis] } else { high[axis] };
            self.to_world(DVec3::new(pick(0), pick(1), pick(2)))
        };
        let points: Vec<DVec3> = (0..8).map(corner).collect();
        let min = points.iter().fold(DVec3::INFINITY, |min, p| min.min(*p));
        let max = points.iter().fold(DVec3::NEG_INFINITY, |max, p| max.max(*p));
        padded(min, max, self.magnitude(low.abs().max(high.abs()).max_element()))
    }
}

/// Brings to each place `i` what stands at `order[i]`, cycle by cycle, without a copy of the list. Uses `order` up.
fn reorder<T>(list: &mut [T], order: &mut [u32]) {
    for start in 0..list.len() {
        let mut at = start;
        loop {
            let from = std::mem::replace(&mut order[at], at as u32) as usize;
            if from == start || from == at {
                break;
            }
            list.swap(at, from);
            at = from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::reorder;

    #[test]
    fn reorders_in_place() {
        for order in [vec![], vec![0], vec![2, 0, 1, 3], vec![3, 2, 1, 0], vec![1, 2, 3, 4, 0]] {
            let mut list: Vec<u32> = (0..order.len() as u32).map(|i| i + 10).collect();
            reorder(&mut list, &mut order.clone());
            assert_eq!(list, order.iter().map(|i| i + 10).collect::<Vec<_>>());
        }
    }
}
