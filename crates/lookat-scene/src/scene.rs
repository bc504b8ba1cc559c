//! The resolved scene: its parts, its bounds and its memory.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::DVec3;
use lookat_syntax::Span;

use crate::{
    AnimatedTransform, AnyTexture, Camera, Cutout, Emission, Film, Filter, Integrator, Light, Material,
    Medium, Sampler, Shape, Transform,
};

/// A scene, ready to render: a view of a world. Lengths are in world units, except for quadrics and curves, which are in
/// object space. Angles are in radians unless a field says degrees. Colors are linear RGB; transformations are `f64`.
/// Nothing is left to look up, and nothing can fail.
#[derive(Debug, Clone)]
pub struct Scene {
    /// How the world is seen.
    pub view: View,
    /// What is seen. Views share it.
    pub world: Arc<World>,
}

/// The directives before `WorldBegin`: how a picture is taken.
#[derive(Debug, Clone)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The size of the picture.
    pub film: Film,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The sampler and its number of samples.
    pub sampler: Sampler,
    /// The light transport algorithm.
    pub integrator: Integrator,
}

/// The directives after `WorldBegin`: shapes and lights.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// The shapes of the world.
    pub primitives: Vec<Primitive>,
    /// The object instances of the world.
    pub instances: Vec<Instance>,
    /// The lights without a shape. An emissive shape stores its own emission.
    pub lights: Vec<Light>,
    /// The participating media. Empty under integrators that ignore media.
    pub media: Vec<Medium>,
    /// The medium that the camera is in: an index in `media`. `None` is empty space.
    pub camera_medium: Option<u32>,
}

/// The media on both sides of a shape: indices in [`World::media`]. `None` is empty space.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MediumInterface {
    /// The medium on the side that the normal points away from.
    pub inside: Option<u32>,
    /// The medium on the side that the normal points to.
    pub outside: Option<u32>,
}

impl View {
    /// A view by the box filter, the Halton sampler with 16 samples per pixel and path tracing up to depth 5: the defaults of
    /// pbrt-v3.
    pub fn new(camera: Camera, film: Film) -> View {
        View {
            camera,
            film,
            filter: Filter::BOX,
            sampler: Sampler::PBRT_DEFAULT,
            integrator: Integrator::PBRT_DEFAULT,
        }
    }
}

impl Scene {
    /// A view of a world.
    pub fn new(view: View, world: World) -> Scene {
        Scene { view, world: Arc::new(world) }
    }

    /// True if the camera or any shape moves.
    pub fn has_motion(&self) -> bool {
        self.view.camera.motion.is_some() || self.world.has_motion()
    }
}

impl Primitive {
    /// A shape of a material: without holes, and dark.
    pub fn new(shape: Shape, material: Arc<Material>) -> Primitive {
        Primitive {
            mirrored: shape.is_mirrored().unwrap_or(false),
            shape,
            span: None,
            reverse_orientation: false,
            material,
            cutout: None,
            emission: None,
            medium: None,
        }
    }

    /// This shape as an area light.
    pub fn with_emission(self, emission: Emission) -> Primitive {
        Primitive { emission: Some(Arc::new(emission)), ..self }
    }

    /// The alpha masks of the shape.
    pub(crate) fn masks(&self) -> impl Iterator<Item = AnyTexture<'_>> {
        let masks = self.cutout.iter().flat_map(|cutout| [&cutout.alpha, &cutout.shadow_alpha]);
        masks.flatten().map(AnyTexture::Numbers)
    }

    /// The emission of the shape. `None` if it is black.
    pub(crate) fn light(&self) -> Option<&Emission> {
        self.emission.as_deref().filter(|emission| !emission.is_black())
    }
}

/// A shape with its material and emission. Its space is the world, or the object that contains it.
#[derive(Debug, Clone)]
pub struct Primitive {
    /// The shape.
    pub shape: Shape,
    /// The Shape directive that made it. `None` for a shape made in code.
    pub span: Option<Span>,
    /// True under `ReverseOrientation`: normals are flipped.
    pub reverse_orientation: bool,
    /// True if the transformation from object space swaps handedness. For a mesh: the one that its vertices went through.
    pub mirrored: bool,
    /// The material.
    pub material: Arc<Material>,
    /// The alpha mask. Only meshes have one.
    pub cutout: Option<Box<Cutout>>,
    /// The emitted light.
    pub emission: Option<Arc<Emission>>,
    /// The media that it separates. `None` for a shape that has the same medium on both sides.
    pub medium: Option<MediumInterface>,
}

/// The shapes between `ObjectBegin` and `ObjectEnd`. As in pbrt-v3, an emissive shape of an object is visible but is
/// not a light source.
#[derive(Debug, Clone, Default)]
pub struct Object {
    /// The shapes, in object space.
    pub primitives: Vec<Primitive>,
}

/// An object instance.
#[derive(Debug, Clone)]
pub struct Instance {
    /// The object.
    pub object: Arc<Object>,
    /// The current transformation at `ObjectInstance`. Of an object that moves, the one at the start time.
    pub world_from_object: Arc<Transform>,
    /// The motions whose product, the last one applied first, places an object that moves. `None` if it stands still.
    pub motion: Option<Arc<[AnimatedTransform]>>,
}

impl Instance {
    /// An object that stands still.
    pub fn new(object: Arc<Object>, world_from_object: Transform) -> Instance {
        Instance { object, world_from_object: Arc::new(world_from_object), motion: None }
    }

    /// The lowest and the highest corner of a box around all places of a box of the object, except for rounding.
    pub fn bounds(&self, [low, high]: [DVec3; 2]) -> [DVec3; 2] {
        match &self.motion {
            Some(motions) => motions.iter().rev().fold([low, high], |bounds, motion| motion.bounds(bounds)),
            None => transformed([low, high], &self.world_from_object),
        }
    }
}

/// The lowest and the highest corner of a box.
type Bounds = [DVec3; 2];

impl World {
    /// True if any shape moves.
    pub fn has_motion(&self) -> bool {
        self.instances.iter().any(|instance| instance.motion.is_some())
    }

    /// The lowest and the highest corner of a box around all shapes, not always the smallest. `None` for a world
    /// without shapes.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut objects: HashMap<*const Object, Option<Bounds>> = HashMap::new();
        let instances = self.instances.iter().filter_map(|instance| {
            let object = objects.entry(Arc::as_ptr(&instance.object));
            let own = *object
                .or_insert_with(|| around(instance.object.primitives.iter().filter_map(Primitive::bounds)));
            own.map(|own| instance.bounds(own))
        });
        around(self.primitives.iter().filter_map(Primitive::bounds).chain(instances))
    }
}

impl Primitive {
    /// The lowest and the highest corner of a box around the shape. `None` for a shape without points.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        match &self.shape {
            Shape::TriangleMesh(mesh) => {
                around(mesh.positions().iter().map(|point| [DVec3::from(*point); 2]))
            }
            Shape::Quadric(quadric) => {
                let (low, high) = quadric.corners();
                Some(transformed([low, high], &quadric.world_from_object))
            }
            Shape::Curve(curve) => {
                let points = curve.segments.iter().flatten();
                around(points.map(|point| [curve.world_from_object.point(*point); 2]))
            }
        }
    }
}

/// The box around a transformed box.
pub(crate) fn transformed([low, high]: Bounds, transform: &Transform) -> Bounds {
    let (center, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let extent = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| transform.vector(axis * half).abs());
    let (center, extent) = (transform.point(center), extent[0] + extent[1] + extent[2]);
    [center - extent, center + extent]
}

pub(crate) fn around(boxes: impl Iterator<Item = Bounds>) -> Option<Bounds> {
    boxes.reduce(|[low, high], other| [low.min(other[0]), high.max(other[1])])
}

/// The memory of a world. Shared arrays count once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Memory {
    /// Bytes of the shapes without their meshes, also of objects.
    pub shapes: usize,
    /// Bytes of the instances.
    pub instances: usize,
    /// Bytes of the meshes.
    pub meshes: usize,
    /// The number of pictures. A file read with two settings counts twice.
    pub pictures: usize,
    /// Bytes of the pictures, including MIP levels.
    pub picture_bytes: usize,
    /// Bytes of the media.
    pub media: usize,
    /// Bytes of the tables of materials.
    pub tables: usize,
}

impl World {
    /// The objects with instances in the world, each once.
    pub fn objects(&self) -> Vec<&Arc<Object>> {
        let mut objects: Vec<&Arc<Object>> = Vec::new();
        let mut known = HashSet::new();
        for instance in &self.instances {
            if known.insert(Arc::as_ptr(&instance.object)) {
                objects.push(&instance.object);
            }
        }
        objects
    }

    /// All shapes, including shapes of instanced objects.
    pub fn shapes(&self) -> impl Iterator<Item = &Primitive> {
        let of_objects = self.objects().into_iter().flat_map(|object| &object.primitives);
        self.primitives.iter().chain(of_objects)
    }

    /// The memory of the world.
    pub fn memory(&self) -> Memory {
        let (mut meshes, mut pictures, mut tables) = (HashMap::new(), HashMap::new(), HashMap::new());
        let mut materials = HashSet::new();
        for primitive in self.shapes() {
            if let Shape::TriangleMesh(mesh) = &primitive.shape {
                meshes.insert(Arc::as_ptr(mesh), mesh.bytes());
            }
            let is_new = materials.insert(Arc::as_ptr(&primitive.material));
            let of_material = is_new.then(|| primitive.material.textures());
            if is_new {
                let own = primitive.material.all().into_iter().filter_map(|part| part.kind.table());
                tables.extend(own.map(|table| (Arc::as_ptr(table), table.bytes())));
            }
            let textures = of_material.into_iter().flatten().chain(primitive.masks());
            pictures.extend(textures.flat_map(AnyTexture::all).filter_map(AnyTexture::picture));
        }
        pictures.extend(
            self.lights.iter().filter_map(Light::map).map(|map| (Arc::as_ptr(map).addr(), map.bytes())),
        );
        Memory {
            shapes: self.shapes().map(shape_bytes).sum(),
            instances: size_of_val(&self.instances[..]),
            meshes: meshes.values().sum(),
            pictures: pictures.len(),
            picture_bytes: pictures.values().sum(),
            media: self.media.iter().map(Medium::bytes).sum(),
            tables: tables.values().sum(),
        }
    }
}

fn shape_bytes(primitive: &Primitive) -> usize {
    let array = match &primitive.shape {
        Shape::Curve(curve) => size_of_val(&curve.segments[..]),
        _ => 0,
    };
    size_of::<Primitive>() + array
}

/// The places of what a view consists of, and of the lights. `None` where the text leaves a default.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// The type of `Camera`.
    pub camera: Option<Span>,
    /// The numbers of `screenwindow`.
    pub screen_window: Option<Span>,
    /// The number of `lensradius`.
    pub lens_radius: Option<Span>,
    /// The number of `focaldistance` or `focusdistance`.
    pub focal_distance: Option<Span>,
    /// The numbers of `cropwindow`.
    pub crop_window: Option<Span>,
    /// `WorldBegin`.
    pub world_begin: Option<Span>,
    /// The types of `LightSource`, in the order of [`World::lights`](crate::World::lights).
    pub lights: Vec<Span>,
}

#[cfg(test)]
mod tests {
    mod bounds {
        use super::super::*;
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
    mod memory {
        use std::path::Path;

        use crate::{Instance, LoadOptions, Memory, Primitive, load};

        fn memory(world: &str) -> Memory {
            let text = format!(
                "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"path\" WorldBegin
            LightSource \"infinite\" {world} WorldEnd"
            );
            let read = |path: &Path| match path.extension() {
                Some(_) => Ok(pfm()),
                None => Ok(text.clone().into()),
            };
            load(Path::new("x"), &read, &LoadOptions::default()).scene.unwrap().world.memory()
        }

        /// A gray picture of 2 x 2 pixels.
        fn pfm() -> Vec<u8> {
            [b"Pf\n2 2\n-1\n".as_slice(), &[0; 16]].concat()
        }

        const TRIANGLE: &str =
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 1 1 0 1 0 1 1]";

        #[test]
        fn what_is_shared_counts_once() {
            let one = 3 * 24 + 3 * 4;
            assert_eq!(memory(&TRIANGLE.repeat(2)).meshes, 2 * one);
            let object = format!("ObjectBegin \"a\" {TRIANGLE} ObjectEnd");
            let copies = "ObjectInstance \"a\" ".repeat(3);
            let copied = memory(&format!("{object} {copies}"));
            assert_eq!((copied.meshes, copied.instances), (one, 3 * size_of::<Instance>()));
            assert_eq!(memory(&object).meshes, 0);
        }

        #[test]
        fn pictures_are_found_in_textures_of_textures_and_in_cutouts() {
            let map = |name: &str, kind: &str, more: &str| {
                format!("Texture \"{name}\" \"{kind}\" \"imagemap\" \"string filename\" \"a.pfm\" {more} ")
            };
            // Four texels and their mean.
            let of_numbers = map("n", "float", "");
            let cut = format!("{of_numbers} {TRIANGLE} \"texture alpha\" \"n\"");
            let one = size_of::<Primitive>();
            let with_cut =
                Memory { shapes: one, meshes: 84, pictures: 1, picture_bytes: 5 * 4, ..Memory::default() };
            assert_eq!(memory(&cut), with_cut);
            let of_colors = map("c", "spectrum", "");
            let scaled = "Texture \"s\" \"spectrum\" \"scale\" \"texture tex1\" \"c\" \"rgb tex2\" [.1 .2 .3]
            Material \"plastic\" \"texture Ks\" \"s\" \"texture Kd\" \"c\"";
            let found = memory(&format!("{of_colors} {scaled} Shape \"sphere\" {cut}"));
            assert_eq!(
                found,
                Memory { shapes: 2 * one, pictures: 2, picture_bytes: 5 * 4 + 5 * 12, ..with_cut }
            );
        }
    }
}
