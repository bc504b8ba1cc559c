//! The world while it is read. Meshes and pictures in files are handles until `load`.

use std::collections::HashSet;
use std::sync::Arc;

use crate::files::Files;
use crate::fill::Fill;
use crate::mesh::Mesh;
use crate::params::{FileParam, Params};
use crate::picture::Pictures;
use crate::ply::PlyFiles;
use crate::report::Report;
use crate::shape::Geometry;
use crate::{Instance, Light, Object, Primitive, Shape, Transform, World};

/// Shapes, objects and lights so far.
pub(crate) struct Draft {
    pub primitives: Vec<Primitive>,
    /// All objects, also unnamed ones.
    pub objects: Vec<Object>,
    /// The index of the object that is open.
    pub open: Option<usize>,
    /// The index of an object, and its placement.
    pub instances: Vec<(usize, Transform)>,
    pub lights: Vec<Light>,
    pub pictures: Pictures,
    meshes: Vec<MeshFile>,
    /// The shape in place of each mesh file: a triangle, because a mesh without triangles would be invisible.
    stand_in: Arc<Mesh>,
}

/// The place of a primitive: the index of its object, or `None` for the world, and its index there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Slot {
    object: Option<usize>,
    index: usize,
}

/// A mesh to be read from a file.
struct MeshFile {
    file: FileParam,
    world_from_object: Transform,
    /// The primitive that gets the mesh. `None` if the file is only checked.
    slot: Option<Slot>,
}

impl Default for Draft {
    fn default() -> Self {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangle = Mesh { positions, indices: vec![0, 1, 2], ..Mesh::default() };
        Draft {
            primitives: Vec::new(),
            objects: Vec::new(),
            open: None,
            instances: Vec::new(),
            lights: Vec::new(),
            pictures: Pictures::default(),
            meshes: Vec::new(),
            stand_in: Arc::new(triangle),
        }
    }
}

impl Draft {
    /// The shape of a geometry. For a file, stores a handle.
    pub fn shape(&mut self, geometry: Geometry, world_from_object: Transform) -> Shape {
        match geometry {
            Geometry::Shape(shape) => shape,
            Geometry::PlyFile(file) => {
                self.meshes.push(MeshFile { file, world_from_object, slot: None });
                Shape::TriangleMesh(self.stand_in.clone())
            }
        }
    }

    /// Adds a primitive to the open object or to the world. Its shape is the last one of `shape`.
    pub fn add(&mut self, primitive: Primitive) -> Slot {
        let object = self.open;
        let slot = Slot { object, index: self.list(object).len() };
        if matches!(&primitive.shape, Shape::TriangleMesh(mesh) if Arc::ptr_eq(mesh, &self.stand_in)) {
            self.meshes.last_mut().into_iter().for_each(|mesh| mesh.slot = Some(slot));
        }
        self.list(object).push(primitive);
        slot
    }

    /// Adds an object without shapes and returns its index.
    pub fn new_object(&mut self) -> usize {
        self.objects.push(Object::default());
        self.objects.len() - 1
    }

    /// Reads the meshes and pictures of all handles, each file once. With `fast`, checks only that the files exist and
    /// the headers of meshes. Leaves out meshes with errors.
    pub fn load(mut self, fast: bool, files: &Files, report: &mut Report) -> Built {
        let unread = if fast { self.meshes.len() + self.pictures.len() } else { 0 };
        if fast {
            self.check_files(files, report);
        } else {
            self.load_meshes(files, report);
            self.load_pictures(files, report);
        }
        report.partial = false;
        self.build(unread)
    }

    fn check_files(&mut self, files: &Files, report: &mut Report) {
        for MeshFile { file, .. } in &self.meshes {
            PlyFiles::check_header(&mut Params::of_file(file, files, report), &file.name);
        }
        self.pictures.check(files, report);
    }

    fn load_meshes(&mut self, files: &Files, report: &mut Report) {
        let mut ply = PlyFiles::default();
        self.meshes.iter().for_each(|mesh| ply.expect(files, &mesh.file.name));
        let mut lost = HashSet::new();
        for MeshFile { file, world_from_object, slot } in std::mem::take(&mut self.meshes) {
            let mesh = ply.mesh(&mut Params::of_file(&file, files, report), &file.name, world_from_object);
            match (mesh, slot) {
                (Some(mesh), Some(slot)) => {
                    self.list(slot.object)[slot.index].shape = Shape::TriangleMesh(mesh);
                }
                (None, slot) => lost.extend(slot),
                (_, None) => {}
            }
        }
        let lists: HashSet<Option<usize>> = lost.iter().map(|slot| slot.object).collect();
        for object in lists {
            let mut indices = 0..;
            let is_kept = |index| !lost.contains(&Slot { object, index });
            self.list(object).retain(|_| indices.next().is_none_or(is_kept));
        }
    }

    fn load_pictures(&mut self, files: &Files, report: &mut Report) {
        if self.pictures.len() == 0 {
            return;
        }
        self.pictures.load(files, report);
        let mut fill = Fill::new(&self.pictures);
        let of_objects = self.objects.iter_mut().flat_map(|object| &mut object.primitives);
        self.primitives.iter_mut().chain(of_objects).for_each(|primitive| fill.primitive(primitive));
        self.lights.iter_mut().for_each(|light| fill.light(light));
    }

    /// The primitives of an object or of the world.
    fn list(&mut self, object: Option<usize>) -> &mut Vec<Primitive> {
        match object {
            Some(object) => &mut self.objects[object].primitives,
            None => &mut self.primitives,
        }
    }

    fn build(self, unread: usize) -> Built {
        let objects: Vec<Arc<Object>> = self.objects.into_iter().map(Arc::new).collect();
        let instances = self.instances.into_iter();
        let instances = instances.map(|(object, world_from_object)| Instance {
            object: objects[object].clone(),
            world_from_object,
        });
        // An object may have lost its shapes to errors.
        let instances = instances.filter(|instance| !instance.object.primitives.is_empty()).collect();
        let world = World { primitives: self.primitives, instances, lights: self.lights };
        Built { world, objects, unread }
    }
}

/// The complete world.
pub(crate) struct Built {
    pub world: World,
    /// All objects, also those without an instance.
    pub objects: Vec<Arc<Object>>,
    /// The number of handles that still have stand-ins.
    pub unread: usize,
}

impl Built {
    /// The shapes that a picture can show. Shapes of an object count once, however many instances it has.
    pub fn drawn(&self) -> Vec<&Primitive> {
        self.world.shapes().filter(|primitive| !primitive.shape.is_invisible()).collect()
    }

    /// A primitive, unless it had an error.
    pub fn primitive(&self, slot: Slot) -> Option<&Primitive> {
        match slot.object {
            Some(object) => self.objects.get(object)?.primitives.get(slot.index),
            None => self.world.primitives.get(slot.index),
        }
    }
}

#[cfg(test)]
mod tests;
