//! Prepares a world for rendering: its hierarchy and its light tables, relative to an origin near the eye. A world that differs
//! only in materials or lights keeps the hierarchy.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use lookat_image::MipMap;
use lookat_scene::{
    Camera, Emission, Instance, Light, Mesh, Object, Primitive, Scene, Shape, Transform, View, World,
};
use rayon::prelude::*;

use crate::camera::CameraRays;
use crate::curved::Curved;
use crate::light::LightTable;
use crate::traceable::{Traceable, placed_box};
use crate::triangle::corners;

/// A world with its trees and light tables. Views of it render without preparing it again:
///
/// ```
/// # use std::{ops::ControlFlow, path::Path};
/// # let text = r#"Camera "perspective" Film "image" "integer xresolution" 8 "integer yresolution" 8
/// #     Sampler "sobol" "integer pixelsamples" 1 Integrator "path" WorldBegin LightSource "infinite"
/// #     Translate 0 0 3 Shape "sphere" WorldEnd"#;
/// # let scene = lookat_scene::load(Path::new("a"), &|_| Ok(text.into()), &Default::default()).scene.unwrap();
/// use lookat_render::Prepared;
///
/// let prepared = Prepared::new(&scene);
/// let mut view = scene.view.clone();
/// view.film.scale = 2.0;
/// let rendered = prepared.render(&view, &Default::default(), &|_| ControlFlow::Continue(()));
/// assert_eq!(rendered.image.rgb().unwrap()[0], [2.0; 3]);
/// ```
///
/// Coordinates are relative to an origin: the eye, rounded to a lattice whose cells are at most as large as
/// four worlds. After [`Prepared::look`], each view has the same pixels as when it is rendered alone.
pub struct Prepared {
    world: Arc<World>,
    lattice: Lattice,
    pub(crate) brightest: Brightest,
    pub(crate) traceable: Traceable,
    pub(crate) lights: LightTable,
}

impl Prepared {
    /// Prepares the world of a scene for its view, on the threads of the process.
    pub fn new(scene: &Scene) -> Prepared {
        let world = scene.world.clone();
        let lattice = Lattice::new(&world);
        let (traceable, lights) = relative_to(&world, lattice.origin(CameraRays::eye(&scene.view.camera)));
        let brightest = Brightest::new(&world);
        Prepared { world, lattice, brightest, traceable, lights }
    }

    /// Takes another scene over. Keeps the trees if only views, materials and lights differ, and also the light tables if the lights are the
    /// same. The pictures equal the ones after [`Prepared::new`].
    pub fn renew(&mut self, scene: &Scene) {
        let world = &scene.world;
        if !is_geometry(&self.world, world) {
            self.clear();
            *self = Prepared::new(scene);
            return;
        }
        let are_lights = are_lights(&self.world, world);
        self.world = world.clone();
        self.traceable.renew(world);
        self.brightest = Brightest::new(world);
        if !are_lights {
            self.lights = LightTable::new(world, &self.traceable);
        }
    }

    /// Gives the memory of the trees back.
    fn clear(&mut self) {
        self.world = Arc::default();
        (self.traceable, self.lights) = relative_to(&self.world, self.traceable.origin);
    }

    /// True if a camera is in the cell of the origin, so that nothing has to be prepared for it.
    pub fn is_near(&self, camera: &Camera) -> bool {
        self.lattice.origin(CameraRays::eye(camera)) == self.traceable.origin
    }

    /// Moves the origin to the cell of a camera, so that its pictures equal those of [`render`](crate::render()). This builds
    /// the BVHs and light tables again, unless the camera [is near](Prepared::is_near). Returns the time that it took.
    pub fn look(&mut self, camera: &Camera) -> Duration {
        let started = Instant::now();
        if !self.is_near(camera) {
            let origin = self.lattice.origin(CameraRays::eye(camera));
            let world = self.world.clone();
            self.clear();
            (self.traceable, self.lights) = relative_to(&world, origin);
            self.world = world;
        }
        started.elapsed()
    }

    /// The camera rays of a view. They are exact if the camera [is near](Prepared::is_near).
    pub fn camera(&self, view: &View) -> CameraRays {
        CameraRays::new(&view.camera, &view.film, self.traceable.origin)
    }

    /// The world.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }
}

fn relative_to(world: &Arc<World>, origin: DVec3) -> (Traceable, LightTable) {
    let traceable = Traceable::new(world, origin);
    let lights = LightTable::new(world, &traceable);
    (traceable, lights)
}

/// About the most bytes that preparing a world takes: trees while they are built, and tables of lights. By measurement.
pub fn preparation_bytes(world: &World) -> u64 {
    const TRIANGLE: u64 = 250;
    const GLOWING_TRIANGLE: u64 = 350;
    const QUADRIC: u64 = 500;
    const CURVE_PIECE: u64 = 500;
    const INSTANCE: u64 = 480;
    /// A leaf of the tree of lights, and what is said of it.
    const LIGHT: u64 = 500;
    /// The bytes of the table of a light with a picture.
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
    world.shapes().map(of_shape).sum::<u64>()
        + INSTANCE * world.instances.len() as u64
        + LIGHT * world.lights.len() as u64
        + TABLE * world.lights.iter().filter(has_table).count() as u64
}

/// The places where the origin may lie: multiples of the side of a cell.
///
/// Cells are small enough that `f32` tells neighbors apart, and large enough that a camera seldom leaves one: as large as 4
/// worlds, but at most 1024 of the smaller shapes.
struct Lattice {
    /// A power of two, or 0 for a world without extent.
    cell: f64,
}

/// The side of a cell in sizes of shapes.
const CELL: f64 = 1024.0;
/// This share of the shapes is smaller than the size that counts.
const SMALLER: usize = 10;
/// The most that it is in sizes of the world.
const WORLDS: f64 = 4.0;
/// About as many shapes are measured at most: a few tell how large they are.
const MEASURED: usize = 1 << 12;

/// A box along the axes.
type Corners = [DVec3; 2];

impl Lattice {
    pub fn new(world: &World) -> Lattice {
        let mut boxes = boxes(&world.primitives, stride(&world.primitives));
        let every = world.instances.len().div_ceil(MEASURED).max(1);
        let mut known: HashMap<*const Object, Corners> = HashMap::new();
        boxes.extend(world.instances.iter().step_by(every).map(|instance| {
            let object =
                known.entry(Arc::as_ptr(&instance.object)).or_insert_with(|| of_object(&instance.object));
            match instance.motion {
                Some(_) => instance.bounds(*object),
                None => placed_box(*object, |p| instance.world_from_object.point(p)),
            }
        }));
        // Objects without an element have no box.
        boxes.retain(|[low, high]| low.is_finite() && high.is_finite());
        let [low, high] = around(boxes.iter().copied());
        let mut sizes: Vec<f64> = boxes.iter().map(|[low, high]| (high - low).max_element()).collect();
        sizes.retain(|size| *size > 0.0);
        let at = sizes.len() / SMALLER;
        let small = if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(at, f64::total_cmp).1 };
        let side = (CELL * small).min(WORLDS * (high - low).max_element());
        let is_normal = side.is_normal() && side > 0.0;
        Lattice { cell: if is_normal { libm::exp2(libm::log2(side).floor()) } else { 0.0 } }
    }

    /// The origin for an eye: the nearest place of the lattice, or the eye itself where the lattice is too fine for it.
    pub fn origin(&self, eye: DVec3) -> DVec3 {
        // Adds 0, so that no coordinate is -0.
        let origin = (eye / self.cell).round() * self.cell + DVec3::ZERO;
        if origin.is_finite() { origin } else { eye }
    }
}

/// The number of triangles of a shape. A quadric or a curve counts as one.
fn elements(primitive: &Primitive) -> usize {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => mesh.triangles(),
        Shape::Quadric(_) | Shape::Curve(_) => 1,
    }
}

/// The box around an element.
fn corners_of(primitive: &Primitive, index: usize) -> Corners {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => around(corners(mesh, index, DVec3::ZERO).map(|p| [p; 2])),
        Shape::Quadric(quadric) => {
            let shape = Curved::new(quadric, DVec3::ZERO);
            [shape.center - shape.half_extent(), shape.center + shape.half_extent()]
        }
        Shape::Curve(curve) => {
            around(curve.segments.iter().flatten().map(|p| [curve.world_from_object.point(*p); 2]))
        }
    }
}

/// The box around what can be seen of a shape: `None` for a mesh without area.
pub(crate) fn corners_of_shape(primitive: &Primitive) -> Option<Corners> {
    match &primitive.shape {
        Shape::TriangleMesh(mesh) => {
            let drawn = (0..mesh.triangles()).into_par_iter().with_min_len(1 << 12);
            let drawn = drawn.filter(|index| mesh.has_area(*index));
            drawn.map(|index| corners_of(primitive, index)).reduce_with(|a, b| around([a, b]))
        }
        Shape::Quadric(_) | Shape::Curve(_) => Some(corners_of(primitive, 0)),
    }
}

/// The boxes around every so many of the elements.
fn boxes(primitives: &[Primitive], stride: usize) -> Vec<Corners> {
    let mut boxes = Vec::new();
    let mut number: usize = 0;
    for primitive in primitives {
        let count = elements(primitive);
        let first = number.next_multiple_of(stride) - number;
        boxes.extend((first..count).step_by(stride).map(|index| corners_of(primitive, index)));
        number += count;
    }
    boxes
}

/// A box around an object, in its own space.
fn of_object(object: &Object) -> Corners {
    around(boxes(&object.primitives, stride(&object.primitives)))
}

fn around(boxes: impl IntoIterator<Item = Corners>) -> Corners {
    let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    boxes.into_iter().fold(nothing, |[low, high], corners| [low.min(corners[0]), high.max(corners[1])])
}

/// The distance of boxes to measure, so that they are not too many.
fn stride(primitives: &[Primitive]) -> usize {
    primitives.iter().map(elements).sum::<usize>().div_ceil(MEASURED).max(1)
}

/// True if worlds have the same trees: the same shapes and instances at the same positions in the same order, and the same
/// emitting shapes.
fn is_geometry(a: &World, b: &World) -> bool {
    are_shapes(&a.primitives, &b.primitives)
        && a.instances.len() == b.instances.len()
        && a.objects().len() == b.objects().len()
        && are_instances(&a.instances, &b.instances)
}

/// True if worlds of the same geometry have the same light tables.
fn are_lights(a: &World, b: &World) -> bool {
    // Its place in the text makes no difference.
    let light = |shape: &Primitive| shape.emission.as_deref().map(|own| Emission { span: None, ..*own });
    let is_emitter = |(a, b): (&Primitive, &Primitive)| match &a.emission {
        // Textures are not compared, and a table keeps its mesh.
        Some(_) => {
            let has_cutout = a.cutout.is_some() || b.cutout.is_some();
            let is_mesh = match (&a.shape, &b.shape) {
                (Shape::TriangleMesh(a), Shape::TriangleMesh(b)) => Arc::ptr_eq(a, b),
                _ => true,
            };
            let is_side = (a.reverse_orientation, a.mirrored) == (b.reverse_orientation, b.mirrored);
            light(a) == light(b) && !has_cutout && is_mesh && is_side
        }
        None => true,
    };
    a.lights.len() == b.lights.len()
        && a.lights.iter().zip(&b.lights).all(|(a, b)| is_light(a, b))
        && a.primitives.iter().zip(&b.primitives).all(is_emitter)
}

fn are_instances(a: &[Instance], b: &[Instance]) -> bool {
    // Each object of one world is one object of the other.
    let mut objects: HashMap<*const Object, *const Object> = HashMap::new();
    let mut is_object =
        |a: &Arc<Object>, b: &Arc<Object>| match objects.insert(Arc::as_ptr(a), Arc::as_ptr(b)) {
            Some(known) => known == Arc::as_ptr(b),
            None => are_shapes(&a.primitives, &b.primitives),
        };
    a.iter().zip(b).all(|(a, b)| {
        let is_placed = is_transform(&a.world_from_object, &b.world_from_object) && a.motion == b.motion;
        is_placed && is_object(&a.object, &b.object)
    })
}

fn are_shapes(a: &[Primitive], b: &[Primitive]) -> bool {
    let is_one = |(a, b): (&Primitive, &Primitive)| {
        a.emission.is_some() == b.emission.is_some() && is_shape(&a.shape, &b.shape)
    };
    a.len() == b.len() && a.iter().zip(b).all(is_one)
}

fn is_shape(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::TriangleMesh(a), Shape::TriangleMesh(b)) => Arc::ptr_eq(a, b) || is_mesh(a, b),
        (Shape::Quadric(a), Shape::Quadric(b)) => {
            a == b && is_transform(&a.world_from_object, &b.world_from_object)
        }
        (Shape::Curve(a), Shape::Curve(b)) => {
            a == b && is_transform(&a.world_from_object, &b.world_from_object)
        }
        _ => false,
    }
}

fn is_mesh(a: &Mesh, b: &Mesh) -> bool {
    a.indices() == b.indices()
        && are_bits(a.positions().as_flattened(), b.positions().as_flattened())
        && are_bits(a.normals().as_flattened(), b.normals().as_flattened())
        && are_bits(a.tangents().as_flattened(), b.tangents().as_flattened())
        && are_bits(a.uvs().as_flattened(), b.uvs().as_flattened())
}

fn is_transform(a: &Transform, b: &Transform) -> bool {
    let bits = |transform: &Transform| {
        [transform.matrix(), transform.inverse_matrix()]
            .map(|matrix| matrix.to_cols_array().map(f64::to_bits))
    };
    bits(a) == bits(b)
}

/// True if numbers have the same bits: 0 is not -0.
fn are_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn is_light(a: &Light, b: &Light) -> bool {
    // Comparing pictures takes longer than preparing other lights.
    let is_map = |a: &Arc<MipMap<_>>, b: &Arc<MipMap<_>>| Arc::ptr_eq(a, b);
    match (a, b) {
        (Light::Environment { map, .. }, Light::Environment { map: other, .. }) if !is_map(map, other) => {
            false
        }
        (Light::Goniometric { map, .. }, Light::Goniometric { map: other, .. }) if !is_map(map, other) => {
            false
        }
        _ => a == b,
    }
}

/// The largest numbers of a world's lights, in any channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Brightest {
    /// The most radiance of what a ray can hit.
    pub emitted: f64,
    /// The most intensity of a light that is a point, or irradiance of one that is a direction.
    pub intensity: f64,
}

impl Brightest {
    pub fn new(world: &World) -> Brightest {
        let surfaces =
            world.shapes().filter_map(|shape| shape.emission.as_ref()).map(|emission| emission.radiance);
        let mut brightest = Brightest { emitted: surfaces.map(most).fold(0.0, f64::max), intensity: 0.0 };
        for light in &world.lights {
            match light {
                Light::Infinite { radiance, .. } => {
                    brightest.emitted = brightest.emitted.max(most(*radiance))
                }
                Light::Environment { map, scale, .. } => {
                    // As if one texel had all the light.
                    let texels = (map.width() * map.height()) as f64;
                    brightest.emitted = brightest.emitted.max(most(*scale) * most(map.mean()) * texels);
                }
                Light::Point { intensity, .. }
                | Light::Spot { intensity, .. }
                | Light::Distant { radiance: intensity, .. }
                | Light::Goniometric { intensity, .. }
                | Light::Projection { intensity, .. } => {
                    brightest.intensity = brightest.intensity.max(most(*intensity));
                }
            }
        }
        brightest
    }
}

fn most(color: Vec3) -> f64 {
    f64::from(color.abs().max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Settings;
    use crate::render::render;
    use crate::testing::scene;
    use lookat_scene::Transform;
    use std::ops::ControlFlow;

    /// A prepared world gives the same picture as its scene alone, bit for bit. Earlier views make no difference.
    #[test]
    fn views_do_not_depend_on_those_before() {
        let mut scene = scene(
            r#"Film "image" "integer xresolution" 24 "integer yresolution" 16
            Camera "perspective" "float fov" 6 "float lensradius" .1 "float focaldistance" 60
            Sampler "halton" "integer pixelsamples" 4 Integrator "path" WorldBegin
            LightSource "infinite" "rgb L" [.4 .4 .4] LightSource "point" "point from" [1 3 1]
            ObjectBegin "o" Material "plastic" Shape "sphere" "float radius" .4 ObjectEnd
            AttributeBegin Translate .8 .4 0 ObjectInstance "o" AttributeEnd
            AttributeBegin AreaLightSource "diffuse" Translate -1 1 0 Shape "disk" "float radius" .3 AttributeEnd
            Texture "t" "color" "checkerboard" "string mapping" "planar" "rgb tex1" [1 .2 .2]
            Material "matte" "texture Kd" "t"
            Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4 -4 0 4 4 0 4 4 0 -4]
            Translate 0 .2 1 Shape "curve" "point P" [-1 0 0 0 1 0 0 0 0 1 1 0] "float width" .1 WorldEnd"#,
        );
        let mut prepared = Prepared::new(&scene);
        let (mut moves, mut origin) = (0, prepared.traceable.origin);
        for number in 0..24 {
            // There and back.
            let (sin, cos) = (0.15 * (if number < 12 { number } else { 23 - number }) as f64).sin_cos();
            let eye = DVec3::new(60.0 * sin, 20.0, -60.0 * cos);
            scene.view.camera.world_from_camera =
                Transform::look_at(eye, DVec3::ZERO, DVec3::Y).unwrap().inverse();
            let settings = Settings { seed: number, ..Settings::default() };
            let progress = |_: crate::Progress| ControlFlow::Continue(());
            let is_near = prepared.is_near(&scene.view.camera);
            let unmoved = prepared.render(&scene.view, &settings, &progress).image.rgb().unwrap();
            prepared.look(&scene.view.camera);
            let seen = prepared.render(&scene.view, &settings, &progress).image.rgb().unwrap();
            let alone = render(&scene, &settings, &progress);
            assert_eq!(Some(&seen), alone.image.rgb().as_ref(), "{number}");
            // From another cell, roundings decide ties otherwise: the ground is an edge of the checks, at y = 0.
            let differing = unmoved.iter().zip(&seen).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-6).count();
            assert!(differing <= if is_near { 0 } else { seen.len() / 10 }, "{number}: {differing}");
            let mean = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| pixel[0]).sum::<f32>();
            assert!((mean(&unmoved) / mean(&seen) - 1.0).abs() < 0.005, "{number}");
            moves += u32::from(origin != prepared.traceable.origin);
            origin = prepared.traceable.origin;
        }
        // The last view lies in the cell of the first.
        assert!((5..23).contains(&moves), "{moves}");
        let before = prepared.traceable.world.blocks.as_ptr();
        scene.view.camera.world_from_camera =
            Transform::look_at(DVec3::new(0.01, 20.0, -60.0), DVec3::ZERO, DVec3::Y).unwrap().inverse();
        prepared.look(&scene.view.camera);
        assert_eq!(prepared.traceable.world.blocks.as_ptr(), before);
    }

    const WORLD: &str = r#"LookAt 0 2 -9 0 0 0 0 1 0 Camera "perspective" "float fov" 40
        Film "image" "integer xresolution" 24 "integer yresolution" 16
        Sampler "halton" "integer pixelsamples" 4 Integrator "path" WorldBegin
        LightSource "infinite" "rgb L" [.4 .4 .4] LightSource "point" "point from" [1 3 -1]
        ObjectBegin "o" Material "plastic" Shape "sphere" "float radius" .4 ObjectEnd
        ObjectBegin "p" Material "glass" Shape "sphere" "float radius" .3 Shape "disk" ObjectEnd
        AttributeBegin Translate .8 .4 0 ObjectInstance "o" Translate 1 0 0 ObjectInstance "p" AttributeEnd
        AttributeBegin AreaLightSource "diffuse" "rgb L" [3 2 1] Translate -1 1 0 Shape "disk" "float radius" .3
        Shape "trianglemesh" "integer indices" [0 1 2] "point P" [-2 2 0 -2 3 0 -1 3 0] AttributeEnd
        Texture "t" "color" "checkerboard" "rgb tex1" [1 .2 .2] Material "matte" "texture Kd" "t"
        Texture "hole" "float" "checkerboard" "float tex1" 0 "float tex2" 1 "float uscale" 7
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4 -4 0 4 4 0 4 4 0 -4] "float alpha" 1
        Translate 0 .2 1 Shape "curve" "point P" [-1 0 0 0 1 0 0 0 0 1 1 0] "float width" .1 WorldEnd"#;

    /// Other scenes have the same pictures as when they are prepared alone, from one to the next and back.
    #[test]
    fn a_scene_that_is_taken_over_has_its_own_picture() {
        let edits = [
            ("LookAt 0 2 -9", "LookAt 300 200 -900", true),
            ("LookAt 0 2 -9", "# moved in the text\n LookAt 0 2.5 -9", true),
            ("[.4 .4 .4]", "[.1 .2 .3]", true),
            ("[1 3 -1]", "[-1 3 -1]", true),
            ("LightSource \"point\"", "LightSource \"spot\" LightSource \"point\"", true),
            ("[3 2 1]", "[1 2 3]", true),
            ("\"plastic\"", "\"mirror\"", true),
            ("[1 .2 .2]", "[.2 1 .2]", true),
            ("\"float alpha\" 1", "\"texture alpha\" \"hole\"", true),
            ("\"glass\" Shape", "\"glass\" ReverseOrientation Shape", true),
            ("Translate -1 1 0 Shape", "Translate -1 1 0 ReverseOrientation Shape", true),
            ("AreaLightSource \"diffuse\" \"rgb L\" [3 2 1]", "", false),
            ("Translate -1 1 0", "Translate -1 1.5 0", false),
            ("Translate .8 .4 0", "Translate .8 .5 0", false),
            ("-2 2 0 -2 3 0", "-2 2 0 -2 3.5 0", false),
            ("0 1 2 0 2 3", "0 1 2 0 3 2", false),
            ("[-4 0 -4 -4", "[-4 -0 -4 -4", false),
            ("Translate 0 .2 1 Shape", "Translate 0 .3 1 Shape", false),
            ("Shape \"disk\" ObjectEnd", "ObjectEnd", false),
            ("ObjectInstance \"p\"", "", false),
            ("ObjectInstance \"p\"", "ObjectInstance \"o\"", false),
            ("ObjectInstance \"p\"", "ObjectInstance \"p\" Translate 0 1 0 ObjectInstance \"p\"", false),
        ];
        let mut prepared = Prepared::new(&scene(WORLD));
        for (old, new, keeps_trees) in edits {
            assert_eq!(WORLD.matches(old).count(), 1, "{old}");
            for text in [WORLD.replace(old, new), WORLD.to_owned()] {
                let scene = scene(&text);
                assert_eq!(is_geometry(&prepared.world, &scene.world), keeps_trees, "{new}");
                prepared.renew(&scene);
                let picked = |prepared: &Prepared| {
                    prepared.pick(&scene.view, glam::DVec2::new(12.0, 8.0)).map(|hit| hit.primitive.span)
                };
                let progress = |_: crate::Progress| ControlFlow::Continue(());
                let seen = prepared.render(&scene.view, &Settings::default(), &progress).image.rgb();
                assert!(seen == render(&scene, &Settings::default(), &progress).image.rgb(), "{new}");
                assert_eq!(picked(&prepared), picked(&Prepared::new(&scene)), "{new}");
            }
        }
    }

    fn lattice(world: &str) -> Lattice {
        Lattice::new(
            &scene(&format!(
                "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
                LightSource \"infinite\" {world} WorldEnd"
            ))
            .world,
        )
    }

    const GROUND: &str = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
        \"point P\" [-1e6 0 -1e6 -1e6 0 1e6 1e6 0 1e6 1e6 0 -1e6]";
    const BALL: &str = "Shape \"sphere\"";

    #[test]
    fn cells_are_about_as_large_as_what_there_is_to_see() {
        assert_eq!(lattice(BALL).cell, 8.0);
        assert_eq!(lattice(GROUND).cell, 4_194_304.0);
        // 1,024 times the size of the ball, the smallest shape.
        assert_eq!(lattice(&format!("{GROUND} {BALL}")).cell, 2048.0);
        assert_eq!(lattice(&format!("Translate 1e8 0 0 {BALL}")).cell, 8.0);
        let placed = format!("ObjectBegin \"a\" {BALL} ObjectEnd Scale 8 8 8 ObjectInstance \"a\"");
        assert_eq!(lattice(&placed).cell, 64.0);
        let curve = "Shape \"curve\" \"point P\" [0 0 0 0 0 1 0 0 2 0 0 4]";
        assert_eq!(lattice(curve).cell, 16.0);
    }

    #[test]
    fn shapes_are_measured_far_into_long_lists() {
        let long = format!("{GROUND} {}", "Translate 2 0 0 Shape \"sphere\" ".repeat(3 * MEASURED));
        assert_eq!(lattice(&long).cell, 2048.0);
    }

    #[test]
    fn the_origin_is_near_the_eye() {
        let lattice = lattice(BALL);
        let eye = DVec3::new(3.1, -700.2, 1e9 + 0.1);
        let origin = lattice.origin(eye);
        assert!((eye - origin).abs().max_element() <= 4.0 && origin != eye);
        assert_eq!(lattice.origin(origin + 3.9), origin);
        // Where there is nothing, or it is too small for the eye, coordinates are relative to the eye.
        for cell in [0.0, 1e-300] {
            assert_eq!(Lattice { cell }.origin(eye * 1e20), eye * 1e20);
        }
        assert_eq!(Lattice::new(&World::default()).origin(eye), eye);
    }
}
