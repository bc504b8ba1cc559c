//! The world while it is read.

use std::sync::Arc;

use crate::picture::Pictures;
use crate::ply::PlyFiles;
use crate::{Instance, Light, Medium, Object, Primitive, Transform, World};

/// Shapes, objects and lights so far.
#[derive(Default)]
pub(crate) struct Draft {
    pub primitives: Vec<Primitive>,
    /// All objects, also unnamed ones.
    pub objects: Vec<Object>,
    /// The index of the object that is open.
    pub open: Option<usize>,
    /// The index of an object, and its placement.
    pub instances: Vec<(usize, Transform)>,
    pub lights: Vec<Light>,
    pub media: Vec<Medium>,
    /// The medium that the camera is in.
    pub camera_medium: Option<u32>,
    pub pictures: Pictures,
    pub meshes: PlyFiles,
}

impl Draft {
    /// An empty world. With `fast`, files of meshes and pictures are only checked.
    pub fn new(fast: bool) -> Self {
        let mut draft = Draft::default();
        (draft.pictures.fast, draft.meshes.fast) = (fast, fast);
        draft
    }

    /// Adds a primitive to the open object or to the world.
    pub fn add(&mut self, primitive: Primitive) {
        match self.open {
            Some(object) => self.objects[object].primitives.push(primitive),
            None => self.primitives.push(primitive),
        }
    }

    /// Adds an object without shapes and returns its index.
    pub fn new_object(&mut self) -> usize {
        self.objects.push(Object::default());
        self.objects.len() - 1
    }

    /// The complete world.
    pub fn build(self) -> Built {
        let objects: Vec<Arc<Object>> = self.objects.into_iter().map(Arc::new).collect();
        let instances = self.instances.into_iter();
        let instances = instances.map(|(object, world_from_object)| Instance {
            object: objects[object].clone(),
            world_from_object,
        });
        // An object may have lost its shapes to errors.
        let instances = instances.filter(|instance| !instance.object.primitives.is_empty()).collect();
        let world = World {
            primitives: self.primitives,
            instances,
            lights: self.lights,
            media: self.media,
            camera_medium: self.camera_medium,
        };
        Built { world, objects, unread: self.pictures.unread + self.meshes.unread }
    }
}

/// The complete world.
pub(crate) struct Built {
    pub world: World,
    /// All objects, also those without an instance.
    pub objects: Vec<Arc<Object>>,
    /// The number of uses of files that were only checked.
    pub unread: usize,
}

impl Built {
    /// All shapes, also those of objects without an instance.
    pub fn all(&self) -> impl Iterator<Item = &Primitive> {
        self.world.primitives.iter().chain(self.objects.iter().flat_map(|object| &object.primitives))
    }
}

#[cfg(test)]
mod tests;
