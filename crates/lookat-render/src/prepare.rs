//! From a scene to what rays are traced against: everything relative to the eye, sorted into trees.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use arrayvec::ArrayVec;
use glam::DVec3;
use lookat_scene::{Light, Mesh, Object, Primitive, Scene, Shape};
use rayon::prelude::*;

use crate::arithmetic::{Precision, Simd};
use crate::bounds::Bounds;
use crate::bvh::{Bvh, Reference, WIDTH, around, build};
use crate::camera::CameraRays;
use crate::curve::Curves;
use crate::curved::Curved;
use crate::emitters::Emitters;
use crate::instance::PlacedInstance;
use crate::ray::Hit;
use crate::triangle::block::{Block, of_place, place};
use crate::triangle::{Extent, Triangle, corners};

/// A scene that rays can be traced in. Positions are relative to the eye.
pub(crate) struct Traceable<'s> {
    /// The world position that coordinates are relative to.
    pub eye: DVec3,
    /// All primitives, those of the world first; element names refer to them.
    pub primitives: Vec<&'s Primitive>,
    pub(crate) curved: Vec<Curved>,
    /// Which of the curved shapes a primitive is, or [`NOT_CURVED`].
    curved_of: Vec<u32>,
    /// Curves; the index of an element names the piece.
    pub curves: Curves<'s>,
    pub(crate) world: Group,
    pub(crate) objects: Vec<Group>,
    pub(crate) instances: Vec<PlacedInstance>,
    pub emitters: Emitters,
    /// Whether any mesh may have holes.
    pub(crate) has_cutouts: bool,
    /// Whether the world has only triangles and spheres, which are cheap to test: rays that go down its tree together test more.
    pub(crate) is_cheap: bool,
    pub(crate) precision: Precision,
    pub(crate) simd: Simd,
}

/// About the most bytes that preparing a scene takes: trees while they are built, and tables of lights. By measurement.
pub fn preparation_bytes(scene: &Scene) -> u64 {
    const TRIANGLE: u64 = 250;
    const GLOWING_TRIANGLE: u64 = 100;
    const QUADRIC: u64 = 500;
    const CURVE_PIECE: u64 = 500;
    const INSTANCE: u64 = 300;
    /// Of a light with a picture.
    const TABLE: u64 = 80_000_000;
    let of_shape = |primitive: &Primitive| match &primitive.shape {
        Shape::TriangleMesh(mesh) => {
            let glow = if primitive.emission.is_some() { GLOWING_TRIANGLE } else { 0 };
            (TRIANGLE + glow) * mesh.triangles() as u64
        }
        Shape::Curve(curve) => CURVE_PIECE * ((curve.segments.len() as u64) << curve.split_depth),
        Shape::Quadric(_) => QUADRIC,
    };
    let has_table = |light: &&Light| matches!(light, Light::Environment { .. });
    scene.shapes().map(of_shape).sum::<u64>()
        + INSTANCE * scene.instances.len() as u64
        + TABLE * scene.lights.iter().filter(has_table).count() as u64
}

/// Elements with their tree.
pub(crate) struct Group {
    pub bvh: Bvh,
    pub blocks: Vec<Block>,
    pub others: Vec<Other>,
}

impl Group {
    /// The triangle at a place, see [`Hit::place`].
    #[inline(always)]
    pub fn triangle(&self, place: u32) -> &Triangle {
        let (block, lane) = of_place(place);
        self.blocks[block].triangle(lane)
    }

    /// All triangles, each with its place.
    pub fn triangles(&self) -> impl Iterator<Item = (u32, &Triangle)> {
        self.blocks
            .iter()
            .enumerate()
            .flat_map(|(number, block)| (0..).map(move |lane| place(number, lane)).zip(block.triangles()))
    }
}

const NOT_CURVED: u32 = u32::MAX;

/// An element that is no triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Other {
    Curved { primitive: u32, shape: u32 },
    Curve { primitive: u32, piece: u32 },
    Instance { instance: u32 },
}

impl<'s> Traceable<'s> {
    pub fn new(scene: &'s Scene, precision: Precision) -> Self {
        let eye = CameraRays::eye(&scene.camera);
        let mut builder = Builder::default();
        let mut world = builder.elements(&scene.primitives, eye);
        // Each object is prepared once, in its own space, however many copies there are.
        let mut objects: Vec<Group> = Vec::new();
        let mut known: HashMap<*const Object, (usize, bool)> = HashMap::new();
        let mut instances = Vec::new();
        for instance in &scene.instances {
            let (object, glows) = *known.entry(Arc::as_ptr(&instance.object)).or_insert_with(|| {
                let elements = builder.elements(&instance.object.primitives, DVec3::ZERO);
                let glows = !elements.emitters.is_empty();
                objects.push(elements.group());
                (objects.len() - 1, glows)
            });
            let placed = PlacedInstance::new(object, &instance.world_from_object, eye);
            let bounds = placed.bounds(objects[object].bvh.bounds());
            world.push(bounds, Other::Instance { instance: instances.len() as u32 });
            if glows {
                world.emitters.push(bounds);
            }
            instances.push(placed);
        }
        let emitters = Emitters::new(std::mem::take(&mut world.emitters));
        let world = world.group();
        let Builder { primitives, curved, curved_of, curves } = builder;
        let is_sphere = |shape: u32| curved[shape as usize].as_sphere().is_some();
        let is_cheap = world
            .others
            .iter()
            .all(|other| matches!(other, Other::Curved { shape, .. } if is_sphere(*shape)));
        let has_cutouts = primitives.iter().any(|primitive| primitive.cutout.is_some());
        Traceable {
            eye,
            primitives,
            curved,
            curved_of,
            curves,
            world,
            objects,
            instances,
            emitters,
            has_cutouts,
            is_cheap,
            precision,
            simd: Simd::best(),
        }
    }

    /// A box around everything.
    pub fn bounds(&self) -> Bounds {
        self.world.bvh.bounds()
    }

    /// Whether what is hit emits light.
    pub fn emits(&self, hit: &Hit) -> bool {
        self.primitives[hit.element.primitive as usize].emission.is_some()
    }

    /// The curved shape that a primitive is.
    pub fn curved(&self, primitive: u32) -> Option<&Curved> {
        self.curved.get(self.curved_of[primitive as usize] as usize)
    }

    pub fn instance(&self, instance: u32) -> Option<&PlacedInstance> {
        self.instances.get(instance as usize)
    }
}

/// Numbers primitives as they come.
#[derive(Default)]
struct Builder<'s> {
    primitives: Vec<&'s Primitive>,
    curved: Vec<Curved>,
    curved_of: Vec<u32>,
    curves: Curves<'s>,
}

/// Elements that become one tree.
struct Elements<'s> {
    /// What positions of meshes are relative to.
    eye: DVec3,
    /// Meshes, the number of their primitive, and which of all triangles are theirs.
    meshes: Vec<(&'s Mesh, u32, Range<usize>)>,
    others: Vec<Other>,
    references: Vec<Reference>,
    /// Boxes around those that emit light.
    emitters: Vec<Bounds>,
}

impl<'s> Builder<'s> {
    fn elements(&mut self, primitives: &'s [Primitive], eye: DVec3) -> Elements<'s> {
        let mut all = Elements {
            eye,
            meshes: Vec::new(),
            others: Vec::new(),
            references: Vec::new(),
            emitters: Vec::new(),
        };
        for shape in primitives {
            let primitive = self.primitives.len() as u32;
            self.primitives.push(shape);
            self.curved_of.push(NOT_CURVED);
            let before = all.references.len();
            match &shape.shape {
                Shape::Quadric(quadric) => {
                    let shape = Curved::new(quadric, eye);
                    let (half, number) = (shape.half_extent(), self.curved.len() as u32);
                    let bounds = Bounds::padded(shape.center - half, shape.center + half, shape.magnitude());
                    all.push(bounds, Other::Curved { primitive, shape: number });
                    self.curved.push(shape);
                    self.curved_of[primitive as usize] = number;
                }
                Shape::Curve(curve) => {
                    for (piece, [low, high], magnitude) in self.curves.add(curve, eye) {
                        all.push(Bounds::padded(low, high, magnitude), Other::Curve { primitive, piece });
                    }
                }
                Shape::TriangleMesh(mesh) => all.push_mesh(mesh, primitive),
            }
            if shape.emission.is_some() {
                all.emitters.push(around(&all.references[before..]));
            }
        }
        all
    }
}

impl<'s> Elements<'s> {
    fn push(&mut self, bounds: Bounds, other: Other) {
        self.references.push(Reference::other(bounds, self.others.len() as u32));
        self.others.push(other);
    }

    fn push_mesh(&mut self, mesh: &'s Mesh, primitive: u32) {
        let first = self.meshes.last().map_or(0, |(.., range)| range.end);
        let eye = self.eye;
        let reference = |index: usize| {
            // Triangles without area cannot be seen.
            mesh.has_area(index).then(|| {
                let Extent { low, high, .. } = Extent::new(&corners(mesh, index, eye));
                Reference::triangle(Bounds::new(low, high), (first + index) as u32)
            })
        };
        self.references
            .par_extend((0..mesh.triangles()).into_par_iter().with_min_len(1 << 12).filter_map(reference));
        self.meshes.push((mesh, primitive, first..first + mesh.triangles()));
    }

    /// Sorts the elements into a tree.
    fn group(mut self) -> Group {
        let mut references = std::mem::take(&mut self.references);
        let tree = build(&mut references);
        let sorted = references.iter().filter(|reference| reference.is_triangle);
        let order: Vec<u32> = sorted.map(|reference| reference.number).collect();
        drop(references);
        let mut first = 0;
        let next = |length: &u8| {
            first += usize::from(*length);
            &order[first - usize::from(*length)..first]
        };
        let blocks: Vec<&[u32]> = tree.blocks.iter().map(next).collect();
        let block = |numbers: &&[u32]| {
            let triangles: ArrayVec<Triangle, WIDTH> =
                numbers.iter().map(|number| self.triangle(*number)).collect();
            Block::new(&triangles)
        };
        Group { bvh: tree.bvh, blocks: blocks.par_iter().map(block).collect(), others: self.others }
    }

    fn triangle(&self, number: u32) -> Triangle {
        let number = number as usize;
        let at = self.meshes.partition_point(|(.., range)| range.end <= number);
        let (mesh, primitive, range) = &self.meshes[at];
        Triangle::new(mesh, number - range.start, *primitive, self.eye)
    }
}
