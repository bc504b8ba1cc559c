//! The world while it is read. Meshes and pictures in files are handles until `load`.

use std::collections::HashSet;
use std::sync::Arc;

use crate::files::Files;
use crate::fill::Fill;
use crate::mesh::Mesh;
use crate::mesh_file::PlyFiles;
use crate::params::{FileParam, Params};
use crate::picture::Pictures;
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
                    self.list(slot.object)[slot.index].shape = Shape::TriangleMesh(Arc::new(mesh));
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
    /// All shapes, also those of objects without an instance.
    pub fn shapes(&self) -> impl Iterator<Item = &Primitive> {
        self.world.primitives.iter().chain(self.objects.iter().flat_map(|object| &object.primitives))
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
mod tests {
    use std::cell::RefCell;
    use std::path::{Path, PathBuf};
    use std::sync::Arc;

    use crate::{Light, Loaded, MaterialKind, Overrides, Shape, Texture, Varying, load};

    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0\n3 0 1 2\n";

    /// Loads a world, and returns the files read, except for the scene.
    fn loaded(world: &str, overrides: &Overrides) -> (Loaded, Vec<PathBuf>) {
        let text = format!(
            "Camera \"perspective\" Film \"image\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            LightSource \"infinite\" {world} WorldEnd"
        );
        let files = RefCell::new(Vec::new());
        let read = |path: &Path| {
            if path == Path::new("a.pbrt") {
                return Ok(text.clone().into());
            }
            files.borrow_mut().push(path.to_owned());
            Ok(match path.to_str() {
                Some("a.ply") => PLY.into(),
                // A picture of 2 x 1 pixels.
                Some("a.pfm") => [b"Pf\n2 1\n-1\n".as_slice(), &[0; 8]].concat(),
                _ => Vec::new(),
            })
        };
        let loaded = load(Path::new("a.pbrt"), &read, overrides);
        (loaded, files.into_inner())
    }

    fn mesh(name: &str) -> String {
        format!("Shape \"plymesh\" \"string filename\" \"{name}\" ")
    }

    #[test]
    fn a_mesh_file_is_read_once_and_placed_for_each_shape() {
        let world =
            format!("{} Translate 5 0 0 ObjectBegin \"o\" {0} ObjectEnd ObjectInstance \"o\"", mesh("a.ply"));
        let (loaded, files) = loaded(&world, &Overrides::default());
        assert_eq!(files, [Path::new("a.ply")]);
        let world = loaded.scene.unwrap().world;
        let shapes = [&world.primitives[0], &world.instances[0].object.primitives[0]];
        let x = shapes.map(|primitive| match &primitive.shape {
            Shape::TriangleMesh(mesh) => mesh.positions[1][0],
            other => panic!("{other:?}"),
        });
        assert_eq!(x, [1.0, 6.0]);
    }

    #[test]
    fn shapes_with_wrong_files_are_left_out() {
        let (bad, good) = (mesh("bad.ply"), mesh("a.ply"));
        let world = format!(
            "{bad} {good} {bad} Shape \"sphere\" ObjectBegin \"o\" {bad} ObjectEnd ObjectInstance \"o\""
        );
        let keep_going = Overrides { keep_going: true, ..Overrides::default() };
        let (loaded, _) = loaded(&world, &keep_going);
        assert_eq!((loaded.diagnostics.len(), loaded.diagnostics[0].all_places().count()), (1, 3));
        let world = loaded.scene.unwrap().world;
        assert!(matches!(&world.primitives[0].shape, Shape::TriangleMesh(mesh) if mesh.positions.len() == 3));
        assert!(matches!(world.primitives[1].shape, Shape::Quadric(_)));
        assert!(world.primitives.len() == 2 && world.instances.is_empty());
    }

    #[test]
    fn pictures_replace_their_stand_ins_and_stay_shared() {
        let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.pfm\"
            Texture \"s\" \"spectrum\" \"scale\" \"texture tex1\" \"t\"
            Material \"matte\" \"texture Kd\" \"s\" Shape \"sphere\" Shape \"sphere\"
            Material \"mirror\" \"texture Kr\" \"t\" Shape \"sphere\"
            LightSource \"projection\" \"string mapname\" \"a.pfm\"";
        let (loaded, files) = loaded(texture, &Overrides::default());
        assert_eq!(files, [Path::new("a.pfm"); 2], "one read for each of two settings");
        let world = loaded.scene.unwrap().world;
        let [first, second, mirror] = &world.primitives[..] else { panic!("{world:?}") };
        assert!(Arc::ptr_eq(&first.material, &second.material));
        let MaterialKind::Matte(matte) = &first.material.kind else { panic!("{first:?}") };
        let MaterialKind::Mirror(mirror) = &mirror.material.kind else { panic!("{mirror:?}") };
        let (Texture::Varying(scale), Texture::Varying(image)) = (&matte.kd, &mirror.kr) else { panic!() };
        let Varying::Scale([Texture::Varying(scaled), _]) = &scale.texture else { panic!("{scale:?}") };
        assert!(Arc::ptr_eq(scaled, image));
        let Varying::ImageMap(image) = &image.texture else { panic!("{image:?}") };
        assert_eq!(image.map.picture_size(), [2, 1]);
        let Light::Projection { half_size, .. } = &world.lights[1] else { panic!("{:?}", world.lights) };
        assert!((half_size.x / half_size.y - 2.0).abs() < 1e-12);
    }

    /// As in pbrt-v3.
    #[test]
    fn a_wrong_picture_is_gray_on_a_surface_and_missing_in_a_light() {
        let world = "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"bad.pfm\" \"float scale\" 3
            Material \"matte\" \"texture sigma\" \"t\" Shape \"sphere\"
            LightSource \"infinite\" \"string mapname\" \"bad.pfm\"";
        let keep_going = Overrides { keep_going: true, ..Overrides::default() };
        let world = loaded(world, &keep_going).0.scene.unwrap().world;
        let MaterialKind::Matte(matte) = &world.primitives[0].material.kind else { panic!("{world:?}") };
        let Texture::Varying(node) = &matte.sigma else { panic!("{matte:?}") };
        let Varying::ImageMap(image) = &node.texture else { panic!("{node:?}") };
        assert!((image.map.mean() - 1.5).abs() < 1e-6);
        assert!(matches!(world.lights[1], Light::Infinite { .. }));
    }

    #[test]
    fn a_fast_check_finds_no_darkness_in_what_it_does_not_read() {
        let world = format!("AreaLightSource \"diffuse\" {}", mesh("a.ply"));
        let fast = Overrides { fast: true, ..Overrides::default() };
        let (loaded, _) = loaded(&world, &fast);
        assert!(loaded.diagnostics.is_empty() && loaded.scene.is_none(), "{:?}", loaded.diagnostics);
        assert_eq!(loaded.unread, 1);
    }
}
