//! A world in the form that rays are traced in: positions relative to an origin; hierarchies of the world, of objects, and of
//! instances of these.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, Simd, f64x8, prelude::*};
use glam::{DMat3, DVec3};
use lookat_scene::{AnimatedTransform, MaterialKind, Mesh, Object, Primitive, Shape, Transform, World};
use rayon::prelude::*;

use crate::bssrdf::Tables;
use crate::bvh::{Bvh, Reference, around, build};
use crate::curve::Curves;
use crate::curved::Curved;
use crate::emitters::Emitters;
use crate::frame::Bounds;
use crate::medium::majorants::Majorants;
use crate::number::{Vec3x8, prefetch, three};
use crate::parametric::{Parametric, Parametrics};
use crate::ray::{Hit, Ray};
use crate::trace::rays::Labels;
use crate::triangle::{Block, Extent, Triangle, corners};

/// A world that rays can be traced in. Positions are relative to the origin.
pub(crate) struct Traceable {
    /// The world position that coordinates are relative to.
    pub origin: DVec3,
    pub source: Arc<World>,
    /// The primitives of objects: the object, and which of its primitives.
    of_objects: Vec<(Arc<Object>, u32)>,
    pub(crate) curved: Vec<Curved>,
    /// The index of each primitive among the curved shapes, or [`NOT_CURVED`].
    curved_of: Vec<u32>,
    /// Curves; the index of an element names the piece.
    pub curves: Curves,
    pub(crate) world: Group,
    pub(crate) objects: Vec<Group>,
    /// The number of the first primitive of each object.
    pub(crate) first_of_objects: Vec<u32>,
    pub(crate) instances: Vec<PlacedInstance>,
    has_motion: bool,
    /// Of each medium whose density is a grid.
    pub majorants: Vec<Option<Majorants>>,
    /// Of media inside of surfaces.
    pub tables: Tables,
    pub emitters: Emitters,
    pub labels: Labels,
    /// True for each primitive that may have holes. Empty if none has.
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
            let placed = PlacedInstance {
                motion: instance.motion.clone(),
                ..PlacedInstance::new(object, &instance.world_from_object, origin)
            };
            let of_object = objects[object].bvh.bounds;
            if of_object.is_empty() {
                continue;
            }
            let bounds = placed.bounds(of_object, origin);
            world.push(
                bounds,
                NonTriangle::Instance { instance: instances.len() as u32, object: object as u32 },
            );
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
            has_motion: instances.iter().any(|instance| instance.motion.is_some()),
            instances,
            majorants: Vec::new(),
            tables: Tables::default(),
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
        self.tables.renew(source);
        self.majorants = source.media.par_iter().map(Majorants::of).collect();
        let has_cutouts = source.shapes().any(|primitive| primitive.cutout.is_some());
        let is_cut_out = |primitive: &Primitive| primitive.cutout.is_some();
        let before = std::mem::take(&mut self.cutouts);
        self.cutouts = if has_cutouts { self.primitives().map(is_cut_out).collect() } else { Vec::new() };
        if self.cutouts != before {
            let has_holes = |primitive| is_cut_out_in(&self.cutouts, primitive);
            for group in std::iter::once(&mut self.world).chain(&mut self.objects) {
                let triangles = &group.triangles;
                let find =
                    |block: &mut Block| block.find_solid(triangles, |triangle| has_holes(triangle.primitive));
                group.blocks.par_iter_mut().for_each(find);
            }
        }
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

    /// True if any primitive may have holes.
    pub fn has_cutouts(&self) -> bool {
        !self.cutouts.is_empty()
    }

    /// True if the primitive with a number may have holes.
    #[inline(always)]
    pub fn is_cut_out(&self, number: u32) -> bool {
        is_cut_out_in(&self.cutouts, number)
    }

    /// All primitives, in the order of their numbers.
    pub fn primitives(&self) -> impl ExactSizeIterator<Item = &Primitive> {
        (0..self.curved_of.len() as u32).map(|number| self.primitive(number))
    }

    /// True if light passes straight through the hit surface, because it has no material.
    pub fn is_passed(&self, hit: &Hit) -> bool {
        matches!(self.primitive(hit.element.primitive).material.kind(), MaterialKind::None)
    }

    /// True if the hit surface emits light.
    pub fn emits(&self, hit: &Hit) -> bool {
        self.primitive(hit.element.primitive).emission.is_some()
    }

    /// The curved shape that a primitive is.
    pub fn curved(&self, primitive: u32) -> Option<&Curved> {
        self.curved.get(self.curved_of[primitive as usize] as usize)
    }

    /// An instance, at a [time](Ray::time). `None` for [`ElementId::WORLD`](crate::ray::ElementId::WORLD).
    #[inline(always)]
    pub fn instance(&self, instance: u32, time: f64) -> Option<Cow<'_, PlacedInstance>> {
        ((instance as usize) < self.instances.len()).then(|| self.placed(instance, time))
    }

    /// One of the instances, at a [time](Ray::time).
    #[inline(always)]
    pub fn placed(&self, instance: u32, time: f64) -> Cow<'_, PlacedInstance> {
        let placed = &self.instances[instance as usize];
        match &placed.motion {
            None => Cow::Borrowed(placed),
            Some(motions) => Cow::Owned(PlacedInstance::moving(placed.object, motions, time, self.origin)),
        }
    }

    /// True if an instance, or the world, is at the same place at two times.
    #[inline(always)]
    pub fn is_still(&self, instance: u32, [a, b]: [f64; 2]) -> bool {
        !self.has_motion
            || a == b
            || self.instances.get(instance as usize).is_none_or(|it| it.motion.is_none())
    }

    /// True if anything in the world moves.
    pub fn has_motion(&self) -> bool {
        self.has_motion
    }

    /// Asks for the memory of a non-triangle.
    #[inline(always)]
    pub fn prefetch(&self, other: NonTriangle) {
        match other {
            NonTriangle::Curved { shape, .. } => prefetch(&raw const self.curved[shape as usize], 0..3),
            NonTriangle::Curve { piece, .. } => self.curves.prefetch(piece),
            NonTriangle::Instance { instance, .. } => {
                prefetch(&raw const self.instances[instance as usize], 0..4)
            }
        }
    }

    /// The elements of an instance, or of the world.
    #[inline(always)]
    pub fn group(&self, instance: u32) -> &Group {
        self.instances.get(instance as usize).map_or(&self.world, |placed| &self.objects[placed.object])
    }
}

#[inline(always)]
fn is_cut_out_in(cutouts: &[bool], number: u32) -> bool {
    cutouts.get(number as usize).is_some_and(|is_cut_out| *is_cut_out)
}

/// For a primitive that is no curved shape.
const NOT_CURVED: u32 = u32::MAX;

/// Elements with their tree.
pub(crate) struct Group {
    pub bvh: Bvh,
    /// Bounds that reject most triangles. Stored apart from the triangles, to stay in the cache.
    pub blocks: Vec<Block>,
    /// Each at its place, see [`crate::ray::Hit::place`].
    pub triangles: Vec<Triangle>,
    pub non_triangles: Vec<NonTriangle>,
}

impl Group {
    /// The shape that is all there is, and no triangle.
    #[inline(always)]
    pub fn single_shape(&self) -> Option<NonTriangle> {
        match self.non_triangles[..] {
            [other] if self.blocks.is_empty() => Some(other),
            _ => None,
        }
    }

    /// The triangle at a place.
    #[inline(always)]
    pub fn triangle(&self, place: u32) -> &Triangle {
        &self.triangles[place as usize]
    }
}

/// An element that is no triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NonTriangle {
    Curved {
        primitive: u32,
        shape: u32,
    },
    Curve {
        primitive: u32,
        piece: u32,
    },
    /// `object`: the number of the object that it is a copy of.
    Instance {
        instance: u32,
        object: u32,
    },
}

/// Numbers primitives as they come.
#[derive(Default)]
struct Builder {
    pub curved: Vec<Curved>,
    /// The index of each primitive among the curved shapes, or [`NOT_CURVED`].
    pub curved_of: Vec<u32>,
    pub curves: Curves,
}

/// Elements that become one tree.
#[derive(Default)]
struct Elements<'s> {
    /// The world position that coordinates are relative to.
    origin: DVec3,
    /// Meshes, the number of their primitive, and which of all triangles are theirs.
    meshes: Vec<(&'s Mesh, u32, Range<usize>)>,
    non_triangles: Vec<NonTriangle>,
    references: Vec<Reference>,
    /// Boxes around the elements that emit light.
    pub emitters: Vec<Bounds>,
}

impl Builder {
    pub fn elements<'s>(&mut self, primitives: &'s [Primitive], origin: DVec3) -> Elements<'s> {
        let mut all = Elements { origin, ..Elements::default() };
        for shape in primitives {
            let primitive = self.curved_of.len() as u32;
            self.curved_of.push(NOT_CURVED);
            let before = all.references.len();
            match &shape.shape {
                Shape::Quadric(quadric) => {
                    let shape = Curved::new(quadric, origin);
                    let (half, number) = (shape.half_extent(), self.curved.len() as u32);
                    let bounds = Bounds::padded(shape.center - half, shape.center + half, shape.magnitude());
                    all.push(bounds, NonTriangle::Curved { primitive, shape: number });
                    self.curved.push(shape);
                    self.curved_of[primitive as usize] = number;
                }
                Shape::Curve(curve) => {
                    for (piece, [low, high], magnitude) in self.curves.add(curve, origin) {
                        all.push(
                            Bounds::padded(low, high, magnitude),
                            NonTriangle::Curve { primitive, piece },
                        );
                    }
                }
                Shape::TriangleMesh(mesh) => all.push_mesh(mesh, primitive),
            }
            if shape.emission.is_some() && all.references.len() > before {
                all.emitters.push(around(&all.references[before..]));
            }
        }
        all
    }
}

impl<'s> Elements<'s> {
    pub fn push(&mut self, bounds: Bounds, other: NonTriangle) {
        self.references.push(Reference::non_triangle(bounds, self.non_triangles.len() as u32));
        self.non_triangles.push(other);
    }

    fn push_mesh(&mut self, mesh: &'s Mesh, primitive: u32) {
        let first = self.meshes.last().map_or(0, |(.., range)| range.end);
        let origin = self.origin;
        let reference = |index: usize| {
            let Extent { low, high, .. } = Extent::new(&corners(mesh, index, origin));
            // Triangles without area cannot be seen.
            let bounds = if mesh.has_area(index) { Bounds::new(low, high) } else { Bounds::EMPTY };
            Reference::triangle(bounds, (first + index) as u32)
        };
        let before = self.references.len();
        self.references
            .par_extend((0..mesh.triangles()).into_par_iter().with_min_len(1 << 12).map(reference));
        if self.references[before..].iter().any(Reference::is_empty) {
            self.references.retain(|reference| !reference.is_empty());
        }
        self.meshes.push((mesh, primitive, first..first + mesh.triangles()));
    }

    /// Sorts the elements into a tree.
    pub fn group(mut self) -> Group {
        let mut references = std::mem::take(&mut self.references);
        let tree = build(&mut references);
        let sorted: Vec<u32> =
            references.iter().filter(|it| it.is_triangle()).map(Reference::number).collect();
        drop(references);
        let triangles: Vec<Triangle> = sorted.par_iter().map(|number| self.triangle(*number)).collect();
        let mut end = 0;
        let next = |length: &u8| {
            end += usize::from(*length);
            end - usize::from(*length)..end
        };
        let ranges: Vec<Range<usize>> = tree.blocks.iter().map(next).collect();
        let block = |range: &Range<usize>| Block::new(&triangles[range.clone()], range.start);
        let blocks = ranges.par_iter().map(block).collect();
        Group { bvh: tree.bvh, blocks, triangles, non_triangles: self.non_triangles }
    }

    fn triangle(&self, number: u32) -> Triangle {
        let number = number as usize;
        let at = self.meshes.partition_point(|(.., range)| range.end <= number);
        let (mesh, primitive, range) = &self.meshes[at];
        Triangle::new(mesh, number - range.start, *primitive, self.origin)
    }
}

/// A copy of an object.
#[derive(Clone)]
pub(crate) struct PlacedInstance {
    pub object: usize,
    /// Takes world positions to the object: a matrix and an offset.
    object_from_world: DMat3,
    offset: DVec3,
    world_from_object: DMat3,
    origin: DVec3,
    /// See [`Instance::motion`](lookat_scene::Instance::motion). The fields above are those at the start time.
    motion: Option<Arc<[AnimatedTransform]>>,
}

impl PlacedInstance {
    /// The copy of the object of a number, in a world of that origin.
    pub fn new(object: usize, world_from_object: &Transform, world_origin: DVec3) -> Self {
        let (m, inv) = (world_from_object.matrix(), world_from_object.inverse_matrix());
        PlacedInstance {
            object,
            object_from_world: *world_from_object.inverse_linear(),
            offset: inv.transform_point3(world_origin),
            world_from_object: *world_from_object.linear(),
            origin: m.w_axis.truncate() - world_origin,
            motion: None,
        }
    }

    /// A copy that moves, at a [time](Ray::time).
    #[cold]
    #[inline(never)]
    fn moving(object: usize, motions: &[AnimatedTransform], time: f64, world_origin: DVec3) -> Self {
        let placed = motions.iter().map(|motion| motion.at(time)).reduce(|outer, inner| outer * inner);
        PlacedInstance::new(object, &placed.unwrap_or_default(), world_origin)
    }

    /// A position of the world in the space of the object.
    pub fn to_object(&self, p: DVec3) -> DVec3 {
        self.object_from_world * p + self.offset
    }

    /// As [`PlacedInstance::to_object`].
    #[inline(always)]
    pub fn points_to_object<S: Simd>(&self, p: Vec3x8<S>) -> Vec3x8<S> {
        p.by(&self.object_from_world).moved_by(self.offset)
    }

    /// The largest coordinate that the way back to the world computes with, for a position of the object whose own
    /// coordinates are up to `magnitude`.
    pub fn magnitude(&self, magnitude: f64) -> f64 {
        let m = &self.world_from_object;
        let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        (rows * magnitude + self.origin.abs()).max_element()
    }

    /// Transforms a point from the instance to the world.
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

    /// Does what [`PlacedInstance::to_world`] does, in eight lanes.
    #[inline(always)]
    pub fn points_to_world<S: Simd>(&self, p: Vec3x8<S>) -> Vec3x8<S> {
        p.by(&self.world_from_object) + Vec3x8::splat(p.x.token(), self.origin)
    }

    /// Does what [`PlacedInstance::magnitude`] does, in eight lanes.
    #[inline(always)]
    pub fn magnitudes<S: Simd>(&self, magnitude: f64x8<S>) -> f64x8<S> {
        let DMat3 { x_axis, y_axis, z_axis } = self.world_from_object;
        let (rows, origin) = (x_axis.abs() + y_axis.abs() + z_axis.abs(), self.origin.abs());
        let [x, y, z] = three!(axis, magnitude * rows[axis] + origin[axis]);
        x.max(y).max(z)
    }

    /// Does what [`PlacedInstance::normal_to_world`] does, in eight lanes.
    #[inline(always)]
    pub fn normals_to_world<S: Simd>(&self, n: Vec3x8<S>) -> Vec3x8<S> {
        n.by(&self.object_from_world.transpose()).normalize_or(DVec3::Z)
    }

    /// Normals of the world, in the object.
    #[inline(always)]
    pub fn normals_to_object<S: Simd>(&self, n: Vec3x8<S>) -> Vec3x8<S> {
        n.by(&self.world_from_object.transpose()).normalize_or(DVec3::Z)
    }

    /// Derivatives in the object, in the world.
    #[inline(always)]
    pub fn parametrics_to_world<S: Simd>(&self, object: &Parametrics<S>) -> Parametrics<S> {
        let normals = self.object_from_world.transpose();
        Parametric {
            uv: object.uv,
            dpdu: object.dpdu.by(&self.world_from_object),
            dpdv: object.dpdv.by(&self.world_from_object),
            dndu: object.dndu.by(&normals),
            dndv: object.dndv.by(&normals),
        }
    }

    /// The ray in the space of the object; distances along it are the same.
    pub fn ray(&self, ray: &Ray, t_max: f64) -> Ray {
        Ray { o: self.to_object(ray.o), d: self.object_from_world * ray.d, t_max, ..*ray }
    }

    /// A box around the copy of an object with a box, wherever it moves.
    pub fn bounds(&self, object: Bounds, world_origin: DVec3) -> Bounds {
        let (low, high) = object.corners();
        let magnitude = low.abs().max(high.abs()).max_element();
        let Some(motions) = &self.motion else {
            let [min, max] = placed_box([low, high], |p| self.to_world(p));
            return Bounds::padded(min, max, self.magnitude(magnitude));
        };
        let [min, max] = motions.iter().rev().fold([low, high], |corners, motion| motion.bounds(corners));
        // On its way, the norm of a matrix is less than four times the larger one of the ends.
        let magnitude = motions.iter().rev().fold(magnitude, |magnitude, motion| {
            let at = |end| PlacedInstance::new(self.object, &end, DVec3::ZERO).magnitude(magnitude);
            4.0 * motion.ends().map(at).into_iter().fold(0.0, f64::max)
        });
        let magnitude = magnitude + world_origin.abs().max_element();
        Bounds::padded(min - world_origin, max - world_origin, magnitude)
    }
}

/// The box around a placed box. Rounding is not covered.
pub(crate) fn placed_box(corners: [DVec3; 2], place: impl Fn(DVec3) -> DVec3) -> [DVec3; 2] {
    let corner = |at: usize| {
        let pick = |axis: usize| corners[at >> axis & 1][axis];
        place(DVec3::new(pick(0), pick(1), pick(2)))
    };
    let points: [DVec3; 8] = std::array::from_fn(corner);
    let min = points.iter().fold(DVec3::INFINITY, |min, p| min.min(*p));
    let max = points.iter().fold(DVec3::NEG_INFINITY, |max, p| max.max(*p));
    [min, max]
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use crate::testing::scene;
    use crate::{Settings, render};

    fn picture(camera: &str, world: &str) -> Vec<[f32; 3]> {
        let scene = scene(&format!(
            "LookAt 0 1 -5 0 0 0 0 1 0 {camera} Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32 PixelFilter \"box\"
             Sampler \"sobol\" \"integer pixelsamples\" 16 Integrator \"path\" WorldBegin LightSource \"infinite\"
             Texture \"t\" \"spectrum\" \"checkerboard\" \"float uscale\" 5 \"float vscale\" 5 Material \"matte\" \"texture Kd\" \"t\"
             AttributeBegin Translate 0 -1 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 4 AttributeEnd {world} WorldEnd"
        ));
        render(&scene, &Settings::default(), &|_| ControlFlow::Continue(())).image.rgb().unwrap()
    }

    /// At an instant, moving shapes and a moving camera give the picture of those that stand still there.
    #[test]
    fn an_instant_is_a_still_picture() {
        let shapes = "Shape \"sphere\" \"float radius\" .5 Translate 1 0 0 Shape \"cylinder\" \"float radius\" .2
            Translate -2 0 0 Shape \"loopsubdiv\" \"integer nlevels\" 2 \"integer indices\" [0 1 2 0 2 3 0 3 1 1 3 2]
            \"point P\" [0 0 0 1 0 0 0 1 0 0 0 1]";
        let motion = |x: f64, degrees: f64| {
            format!("ActiveTransform EndTime Translate {x} 0 0 Rotate {degrees} 0 0 1 ActiveTransform All")
        };
        let stand = |x: f64, degrees: f64| format!("Translate {x} 0 0 Rotate {degrees} 0 0 1");
        let camera = "Camera \"perspective\" \"float fov\" 50";
        let instant = format!("{camera} \"float shutteropen\" .25 \"float shutterclose\" .25");
        let alone =
            "Shape \"sphere\" \"float radius\" .5 Shape \"cylinder\" \"float radius\" .2 \"float zmin\" -2";
        let object = format!("ObjectBegin \"o\" {shapes} ObjectEnd");
        for (moving, still) in [
            (
                picture(&instant, &format!("{} {alone}", motion(2.0, 80.0))),
                picture(camera, &format!("{} {alone}", stand(0.5, 20.0))),
            ),
            (
                picture(&instant, &format!("{object} {} ObjectInstance \"o\"", motion(2.0, 80.0))),
                picture(camera, &format!("{object} {} ObjectInstance \"o\"", stand(0.5, 20.0))),
            ),
            (
                picture(&format!("{} {instant}", motion(2.0, 0.0)), shapes),
                picture(&format!("{} {camera}", stand(0.5, 0.0)), shapes),
            ),
        ] {
            let differing = moving.iter().zip(&still).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3).count();
            // Rounding decides at edges of shapes and squares.
            assert!(differing < moving.len() / 50, "{differing}");
            assert!(still.iter().any(|pixel| pixel[0] < 0.9 * still[0][0]));
        }
    }

    /// The picture of an open shutter is the mean of those of instants.
    #[test]
    fn an_open_shutter_takes_the_mean_of_instants() {
        let world = "ActiveTransform EndTime Translate 2 0 0 ActiveTransform All Material \"matte\" \"rgb Kd\" [0 0 0] Shape \"sphere\"";
        let camera = |open: f64, close: f64| {
            format!("Camera \"perspective\" \"float shutteropen\" {open} \"float shutterclose\" {close}")
        };
        let open = picture(&camera(0.0, 1.0), world);
        let mut mean = vec![0.0; open.len()];
        for at in 0..64 {
            let time = (f64::from(at) + 0.5) / 64.0;
            for (mean, pixel) in mean.iter_mut().zip(picture(&camera(time, time), world)) {
                *mean += pixel[0] / 64.0;
            }
        }
        let error = mean.iter().zip(&open).map(|(mean, pixel)| (mean - pixel[0]).powi(2)).sum::<f32>();
        let error = (error / open.len() as f32).sqrt();
        assert!(error < 0.03, "{error}");
    }
}
