//! The world while it is read.

use std::sync::Arc;

use crate::picture::Pictures;
use crate::ply::PlyFiles;
use crate::{AnimatedTransform, Instance, Light, Medium, Object, Primitive, Transform, World};

/// Shapes, objects and lights so far.
#[derive(Default)]
pub(crate) struct Draft {
    pub world: Group,
    /// All objects, also unnamed ones.
    pub objects: Vec<Group>,
    /// The index of the object that is open.
    pub open: Option<usize>,
    pub lights: Vec<Light>,
    pub media: Vec<Medium>,
    /// The medium that the camera is in.
    pub camera_medium: Option<u32>,
    pub pictures: Pictures,
    pub meshes: PlyFiles,
}

/// The shapes of the world or of an object.
#[derive(Default)]
pub(crate) struct Group {
    pub primitives: Vec<Primitive>,
    /// Of an object: shapes that move in it.
    pub instances: Vec<Placed>,
}

impl Group {
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty() && self.instances.is_empty()
    }
}

/// An object that is placed in the world or in another object.
pub(crate) struct Placed {
    /// The index of the object.
    pub object: usize,
    /// The transformation at the start time.
    pub ctm: Arc<Transform>,
    /// `None` if it stands still.
    pub motion: Option<Box<AnimatedTransform>>,
}

impl Draft {
    /// An empty world. With `fast`, files of meshes and pictures are only checked.
    pub fn new(fast: bool) -> Self {
        let mut draft = Draft::default();
        (draft.pictures.fast, draft.meshes.fast) = (fast, fast);
        draft
    }

    /// Adds a primitive to the open object or to the world. One that moves is an object with an instance.
    pub fn add(&mut self, primitive: Primitive, motion: Option<Box<AnimatedTransform>>) {
        let Some(motion) = motion else {
            self.open_group().primitives.push(primitive);
            return;
        };
        let object = self.new_object();
        self.objects[object].primitives.push(primitive);
        let [start, _] = motion.ends();
        self.open_group().instances.push(Placed { object, ctm: Arc::new(start), motion: Some(motion) });
    }

    /// The open object, or the world.
    fn open_group(&mut self) -> &mut Group {
        match self.open {
            Some(object) => &mut self.objects[object],
            None => &mut self.world,
        }
    }

    /// Adds an object without shapes and returns its index.
    pub fn new_object(&mut self) -> usize {
        self.objects.push(Group::default());
        self.objects.len() - 1
    }

    /// The complete world.
    pub fn build(self) -> Built {
        let (shapes, nested): (Vec<_>, Vec<_>) =
            self.objects.into_iter().map(|object| (object.primitives, object.instances)).unzip();
        let objects: Vec<Arc<Object>> =
            shapes.into_iter().map(|primitives| Arc::new(Object { primitives })).collect();
        let mut instances = Vec::with_capacity(self.world.instances.len());
        for outer in &self.world.instances {
            let motion = outer.motion.as_deref().map(|motion| Arc::from([*motion]));
            let object = objects[outer.object].clone();
            instances.push(Instance { object, world_from_object: outer.ctm.clone(), motion });
            instances.extend(nested[outer.object].iter().map(|inner| Instance {
                object: objects[inner.object].clone(),
                world_from_object: Arc::new(*outer.ctm * *inner.ctm),
                motion: Some([outer, inner].map(Placed::motion).into()),
            }));
        }
        // An object may have lost its shapes to errors.
        instances.retain(|instance| !instance.object.primitives.is_empty());
        let world = World {
            primitives: self.world.primitives,
            instances,
            lights: self.lights,
            media: self.media,
            camera_medium: self.camera_medium,
        };
        Built { world, objects, unread: self.pictures.unread + self.meshes.unread }
    }
}

impl Placed {
    /// The motion, or that of what stands still.
    fn motion(&self) -> AnimatedTransform {
        self.motion.as_deref().copied().unwrap_or_else(|| AnimatedTransform::still(*self.ctm))
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
