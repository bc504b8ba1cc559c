//! A world that rays are traced in: everything relative to an origin, in trees.

mod elements;
mod group;

use std::collections::HashMap;
use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use lookat_scene::{MaterialKind, Object, Primitive, Shape, World};

use crate::curve::Curves;
use crate::curved::Curved;
use crate::emitters::Emitters;
use crate::instance::PlacedInstance;
use crate::ray::Hit;
use crate::trace::rays::Labels;
use elements::Builder;
pub(crate) use group::{Group, Other};

/// A world that rays can be traced in. Positions are relative to the origin.
pub(crate) struct Traceable {
    /// The world position that coordinates are relative to.
    pub origin: DVec3,
    pub source: Arc<World>,
    /// The primitives of objects: the object, and which of its primitives.
    of_objects: Vec<(Arc<Object>, u32)>,
    pub(crate) curved: Vec<Curved>,
    /// Which of the curved shapes a primitive is, or [`group::NOT_CURVED`].
    curved_of: Vec<u32>,
    /// Curves; the index of an element names the piece.
    pub curves: Curves,
    pub(crate) world: Group,
    pub(crate) objects: Vec<Group>,
    /// The number of the first primitive of each object.
    pub(crate) first_of_objects: Vec<u32>,
    pub(crate) instances: Vec<PlacedInstance>,
    pub emitters: Emitters,
    pub labels: Labels,
    /// Which primitives may have holes; empty if none has.
    cutouts: Vec<bool>,
    /// The instructions that rays are traced with.
    pub(crate) level: Level,
}

impl Traceable {
    pub fn new(source: &Arc<World>, origin: DVec3) -> Self {
        let mut builder = Builder::default();
        let mut world = builder.elements(&source.primitives, origin);
        // Each object is prepared once, in its own space, however many copies there are.
        let (mut objects, mut first_of_objects): (Vec<Group>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut known: HashMap<*const Object, (usize, bool)> = HashMap::new();
        let mut instances = Vec::new();
        for instance in &source.instances {
            let (object, glows) = *known.entry(Arc::as_ptr(&instance.object)).or_insert_with(|| {
                let primitives = &instance.object.primitives;
                first_of_objects.push(builder.curved_of.len() as u32);
                let elements = builder.elements(primitives, DVec3::ZERO);
                let glows = !elements.emitters.is_empty();
                objects.push(elements.group());
                (objects.len() - 1, glows)
            });
            let placed = PlacedInstance::new(object, &instance.world_from_object, origin);
            let of_object = objects[object].bvh.bounds;
            if of_object.is_empty() {
                continue;
            }
            let bounds = placed.bounds(of_object);
            world.push(bounds, Other::Instance { instance: instances.len() as u32 });
            if glows {
                world.emitters.push(bounds);
            }
            instances.push(placed);
        }
        let emitters = Emitters::new(std::mem::take(&mut world.emitters));
        let world = world.group();
        let Builder { curved, curved_of, curves } = builder;
        let in_mesh = source.shapes().map(|primitive| match &primitive.shape {
            Shape::TriangleMesh(mesh) => mesh.triangles(),
            Shape::Quadric(_) | Shape::Curve(_) => 0,
        });
        let labels = Labels::new(curved_of.len(), in_mesh.max().unwrap_or(0).max(curves.len()));
        let mut traceable = Traceable {
            origin,
            source: Arc::default(),
            of_objects: Vec::new(),
            curved,
            curved_of,
            curves,
            world,
            objects,
            first_of_objects,
            instances,
            emitters,
            labels,
            cutouts: Vec::new(),
            level: Level::new(),
        };
        traceable.renew(source);
        traceable
    }

    /// Takes over a world whose shapes and instances are the same.
    pub fn renew(&mut self, source: &Arc<World>) {
        let of_object = |object: &Arc<Object>| {
            let object = object.clone();
            (0..object.primitives.len() as u32).map(move |index| (object.clone(), index))
        };
        self.of_objects = source.objects().into_iter().flat_map(of_object).collect();
        self.source = source.clone();
        self.cutouts = match source.shapes().any(|primitive| primitive.cutout.is_some()) {
            true => self.primitives().map(|primitive| primitive.cutout.is_some()).collect(),
            false => Vec::new(),
        };
    }

    /// The primitive with a number. Numbers start with the primitives of the world; the primitives of objects follow.
    #[inline]
    pub fn primitive(&self, number: u32) -> &Primitive {
        let number = number as usize;
        let world = &self.source.primitives;
        world.get(number).unwrap_or_else(|| {
            let (object, index) = &self.of_objects[number - world.len()];
            &object.primitives[*index as usize]
        })
    }

    /// Whether any primitive may have holes.
    pub fn has_cutouts(&self) -> bool {
        !self.cutouts.is_empty()
    }

    /// Whether the primitive with a number may have holes.
    #[inline(always)]
    pub fn is_cut_out(&self, number: u32) -> bool {
        self.cutouts.get(number as usize).is_some_and(|is_cut_out| *is_cut_out)
    }

    /// All primitives, in the order of their numbers.
    pub fn primitives(&self) -> impl ExactSizeIterator<Item = &Primitive> {
        (0..self.curved_of.len() as u32).map(|number| self.primitive(number))
    }

    /// Whether light passes straight through what is hit, as it has no material.
    pub fn is_passed(&self, hit: &Hit) -> bool {
        matches!(self.primitive(hit.element.primitive).material.kind(), MaterialKind::None)
    }

    /// Whether what is hit emits light.
    pub fn emits(&self, hit: &Hit) -> bool {
        self.primitive(hit.element.primitive).emission.is_some()
    }

    /// The curved shape that a primitive is.
    pub fn curved(&self, primitive: u32) -> Option<&Curved> {
        self.curved.get(self.curved_of[primitive as usize] as usize)
    }

    pub fn instance(&self, instance: u32) -> Option<&PlacedInstance> {
        self.instances.get(instance as usize)
    }

    /// The elements of an instance, or of the world.
    #[inline(always)]
    pub fn group(&self, instance: u32) -> &Group {
        self.instance(instance).map_or(&self.world, |placed| &self.objects[placed.object])
    }
}
