//! Prepares a world for rays: its trees and its light tables, relative to an origin near the eye.

mod brightest;
mod origin;
mod same;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use lookat_scene::{Camera, Light, Primitive, Scene, Shape, View, World};

use crate::camera::CameraRays;
use crate::light::LightTable;
use crate::traceable::Traceable;
pub(crate) use brightest::Brightest;
use origin::Lattice;
pub(crate) use origin::corners_of_shape;

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
/// let mut prepared = Prepared::new(&scene);
/// let mut view = scene.view.clone();
/// view.film.scale = 2.0;
/// let rendered = prepared.render(&view, &Default::default(), &|_| ControlFlow::Continue(()));
/// assert_eq!(rendered.image.rgb().unwrap()[0], [2.0; 3]);
/// ```
///
/// Coordinates are relative to an origin: the eye, rounded to a lattice whose cells are at most as large as
/// four worlds. A view from another cell prepares the world again. So each view has the same pixels as when it is rendered alone.
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
        if !same::is_geometry(&self.world, world) {
            self.clear();
            *self = Prepared::new(scene);
            return;
        }
        let are_lights = same::are_lights(&self.world, world);
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

    /// Whether a camera is in the cell of the origin, so that nothing has to be prepared for it.
    pub fn is_near(&self, camera: &Camera) -> bool {
        self.lattice.origin(CameraRays::eye(camera)) == self.traceable.origin
    }

    /// Moves the origin to the cell of a camera, and returns the time that this took.
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

    /// The rays of a camera of the origin's cell.
    pub(crate) fn camera(&self, view: &View) -> CameraRays {
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
    world.shapes().map(of_shape).sum::<u64>()
        + INSTANCE * world.instances.len() as u64
        + LIGHT * world.lights.len() as u64
        + TABLE * world.lights.iter().filter(has_table).count() as u64
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use lookat_scene::Transform;

    use super::*;
    use crate::render::{Settings, render};
    use crate::testing::scene;

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
            let unmoved = prepared.render_unmoved(&scene.view, &settings, &progress).image.rgb().unwrap();
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
                assert_eq!(same::is_geometry(&prepared.world, &scene.world), keeps_trees, "{new}");
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
}
