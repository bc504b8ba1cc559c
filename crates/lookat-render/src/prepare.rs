//! From a scene to what rays are traced against: everything relative to the eye, sorted into trees.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use lookat_scene::{Object, Primitive, Scene, Shape};

use crate::bounds::Bounds;
use crate::bvh::Bvh;
use crate::camera::CameraRays;
use crate::ray::{ElementId, Hit, Ray};
use crate::sphere::PlacedSphere;
use crate::triangle::{ShearedRay, corners};

/// A scene that rays can be traced in. Positions are relative to the eye.
pub(crate) struct Traceable<'s> {
    /// The world position that coordinates are relative to.
    pub eye: DVec3,
    /// All primitives, those of the world first; element names refer to them.
    pub primitives: Vec<&'s Primitive>,
    /// The spheres among them, by the number of the primitive.
    spheres: Vec<Option<PlacedSphere>>,
    world: Group,
    objects: Vec<Group>,
    instances: Vec<PlacedInstance>,
}

/// Elements with their tree.
#[derive(Default)]
struct Group {
    elements: Vec<Element>,
    bvh: Option<Bvh>,
}

/// What a leaf holds.
enum Element {
    Triangle { corners: [DVec3; 3], primitive: u32, index: u32 },
    Sphere { primitive: u32 },
    Instance { instance: u32 },
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
        let mut builder = Builder { primitives: Vec::new(), spheres: Vec::new() };
        let mut world = builder.elements(&scene.primitives, eye);
        // Each object is prepared once, in its own space, however many copies there are.
        let mut objects: Vec<(&Arc<Object>, Group)> = Vec::new();
        let mut instances = Vec::new();
        for instance in &scene.instances {
            let known = objects.iter().position(|(object, _)| Arc::ptr_eq(object, &instance.object));
            let object = known.unwrap_or_else(|| {
                let elements = builder.elements(&instance.object.primitives, DVec3::ZERO);
                objects.push((&instance.object, Group::new(elements)));
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
            let bounds = placed.bounds(objects[object].1.bounds());
            world.push((bounds, Element::Instance { instance: instances.len() as u32 }));
            instances.push(placed);
        }
        let Builder { primitives, spheres } = builder;
        Traceable {
            eye,
            primitives,
            spheres,
            world: Group::new(world),
            objects: objects.into_iter().map(|(_, group)| group).collect(),
            instances,
        }
    }

    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = Hit { t: ray.t_max, element: ElementId::NONE, barycentric: [0.0; 2] };
        self.nearest_in(&self.world, ray, ElementId::WORLD, &mut hit);
        (hit.element != ElementId::NONE).then_some(hit)
    }

    fn nearest_in(&self, group: &Group, ray: &Ray, instance: u32, hit: &mut Hit) {
        let sheared = ShearedRay::new(ray);
        group.traverse(ray, |elements| {
            for element in elements {
                match element {
                    Element::Instance { instance } => {
                        let placed = &self.instances[*instance as usize];
                        let ray = placed.ray(ray, hit.t);
                        self.nearest_in(&self.objects[placed.object], &ray, *instance, hit);
                    }
                    other => {
                        if let Some(found) = self.meet(other, ray, &sheared, instance, hit.t)
                            && hit.yields_to(found.t, found.element)
                        {
                            *hit = found;
                        }
                    }
                }
            }
            Some(hit.t)
        });
    }

    /// Whether anything but its target is in the way of a shadow ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occluded_in(&self.world, ray, ElementId::WORLD)
    }

    fn occluded_in(&self, group: &Group, ray: &Ray, instance: u32) -> bool {
        let sheared = ShearedRay::new(ray);
        let mut found = false;
        group.traverse(ray, |elements| {
            found = elements.iter().any(|element| match element {
                Element::Instance { instance } => {
                    let placed = &self.instances[*instance as usize];
                    self.occluded_in(&self.objects[placed.object], &placed.ray(ray, ray.t_max), *instance)
                }
                other => self
                    .meet(other, ray, &sheared, instance, ray.t_max)
                    .is_some_and(|hit| hit.element != ray.target),
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
        sheared: &ShearedRay,
        instance: u32,
        t_max: f64,
    ) -> Option<Hit> {
        match *element {
            Element::Triangle { ref corners, primitive, index } => {
                let (t, barycentric) = sheared.intersect(corners)?;
                let element = ElementId { instance, primitive, index };
                // What is flat is not met again by a ray that leaves it.
                (t > 0.0 && t <= t_max && element != ray.leaving).then_some(Hit { t, element, barycentric })
            }
            Element::Sphere { primitive } => {
                let element = ElementId { instance, primitive, index: 0 };
                let sphere = self.sphere(primitive)?;
                let t = sphere.intersect(ray, t_max, element == ray.leaving)?;
                Some(Hit { t, element, barycentric: [0.0; 2] })
            }
            Element::Instance { .. } => None,
        }
    }

    pub fn sphere(&self, primitive: u32) -> Option<&PlacedSphere> {
        self.spheres[primitive as usize].as_ref()
    }

    pub fn instance(&self, instance: u32) -> Option<&PlacedInstance> {
        self.instances.get(instance as usize)
    }
}

/// Collects the elements of primitives, numbered as they come.
struct Builder<'s> {
    primitives: Vec<&'s Primitive>,
    spheres: Vec<Option<PlacedSphere>>,
}

impl<'s> Builder<'s> {
    fn elements(&mut self, primitives: &'s [Primitive], eye: DVec3) -> Vec<(Bounds, Element)> {
        let mut elements = Vec::new();
        for shape in primitives {
            let primitive = self.primitives.len() as u32;
            self.primitives.push(shape);
            let mut sphere = None;
            match &shape.shape {
                Shape::Sphere(form) => {
                    let placed = PlacedSphere::new(**form, eye);
                    let half = placed.half_extent();
                    elements.push((
                        padded(placed.center - half, placed.center + half),
                        Element::Sphere { primitive },
                    ));
                    sphere = Some(placed);
                }
                Shape::TriangleMesh(mesh) => {
                    elements.extend((0..mesh.triangles()).filter_map(|index| {
                        let corners = corners(mesh, index, eye);
                        let element = Element::Triangle { corners, primitive, index: index as u32 };
                        // Triangles without area cannot be seen.
                        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                        (area != DVec3::ZERO).then(|| (Bounds::of_points(&corners), element))
                    }));
                }
            }
            self.spheres.push(sphere);
        }
        elements
    }
}

/// A box whose corners were computed: wider by what rounding may have taken.
fn padded(min: DVec3, max: DVec3) -> Bounds {
    let error = min.abs().max(max.abs()) * 1e-14;
    Bounds::new(min - error, max + error)
}

impl Group {
    fn new(elements: Vec<(Bounds, Element)>) -> Self {
        let (bounds, elements): (Vec<Bounds>, Vec<Element>) = elements.into_iter().unzip();
        let (bvh, order) = Bvh::build(&bounds);
        let mut elements: Vec<Option<Element>> = elements.into_iter().map(Some).collect();
        let sorted = order.iter().filter_map(|at| elements[*at as usize].take()).collect();
        Group { elements: sorted, bvh: Some(bvh) }
    }

    fn bounds(&self) -> Bounds {
        self.bvh.as_ref().map_or(Bounds::EMPTY, Bvh::bounds)
    }

    #[inline]
    fn traverse(&self, ray: &Ray, mut visit: impl FnMut(&[Element]) -> Option<f64>) {
        if let Some(bvh) = &self.bvh {
            bvh.traverse(ray, |range| visit(&self.elements[range]));
        }
    }
}

impl PlacedInstance {
    /// An eye-relative position in the space of the object.
    pub fn to_object(&self, p: DVec3) -> DVec3 {
        self.object_from_world * p + self.offset
    }

    /// And back.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.world_from_object * p + self.origin
    }

    /// A unit normal of the object, in the world.
    pub fn normal_to_world(&self, n: DVec3) -> DVec3 {
        (self.object_from_world.transpose() * n).normalize_or(DVec3::Z)
    }

    /// The ray in the space of the object; distances along it are the same.
    fn ray(&self, ray: &Ray, t_max: f64) -> Ray {
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
        padded(min, max)
    }
}
