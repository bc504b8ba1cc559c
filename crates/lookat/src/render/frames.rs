//! Cameras of the command line: `--turntable`, `--animate` and `--focus`.

use lookat_render::Prepared;
use lookat_scene::glam::{DVec2, DVec3};
use lookat_scene::{Camera, CameraPlacement, FileCamera, Loaded, LookAtError, Scene, Transform, View};

use crate::args::{Animation, FocusPlace, Parameter, Render, ViewOverride};
use crate::failure::Failure;

/// The camera of each picture.
pub fn cameras(arguments: &Render, scene: &Scene, loaded: &Loaded) -> Result<Vec<Camera>, Failure> {
    let camera = &scene.view.camera;
    match (arguments.frames.turntable, arguments.frames.animate) {
        (Some(count), _) => {
            check_world(loaded, "--turntable")?;
            let turntable = Turntable::new(scene, loaded.placement)?;
            (0..count).map(|number| turntable.camera(camera, number, count)).collect()
        }
        (None, Some(animation)) => {
            let last = arguments.frames.frames.unwrap_or(1) - 1;
            (0..=last)
                .map(|number| animated(camera, loaded, animation, animation.value(number, last)))
                .collect()
        }
        (None, None) => Ok(vec![camera.clone()]),
    }
}

/// Fails if a moving camera changes the world.
fn check_world(loaded: &Loaded, option: &str) -> Result<(), Failure> {
    if loaded.world_follows_camera {
        Err(format!(
            "{option} moves the camera, and CoordSysTransform \"camera\" places a part of this world relative to it; render single pictures with --lookat"
        ).into())
    } else {
        Ok(())
    }
}

/// The camera with another value of a parameter.
fn animated(
    camera: &Camera,
    loaded: &Loaded,
    Animation { parameter, .. }: Animation,
    value: f64,
) -> Result<Camera, Failure> {
    let (option, mut view) = (format!("--animate {}", parameter.name()), ViewOverride::default());
    parameter.set(value, &mut view);
    let mut view = view.options();
    if let Parameter::LookAt(at) = parameter {
        check_world(loaded, &option)?;
        let mut points = loaded.placement.map(|placement| placement.points).ok_or_else(|| {
            format!("{option} needs a LookAt that places the camera; give one with --lookat")
        })?;
        points[at] = value;
        view.look_at = Some(points);
    }
    let file = FileCamera { placement: loaded.placement, focal_distance: None };
    Ok(view.changed(camera, &file).map_err(|fault| format!("{option} at {value}: {fault}"))?)
}

/// A camera that turns around a point.
struct Turntable {
    placement: CameraPlacement,
    axis: DVec3,
}

impl Turntable {
    /// Around the target of `LookAt` and its up vector. Without one, around the middle of the world and the axis of the
    /// world that is nearest to the upper side of the picture.
    fn new(scene: &Scene, placement: Option<CameraPlacement>) -> Result<Turntable, Failure> {
        if let Some(placement) = placement {
            return Ok(Turntable { placement, axis: DVec3::from_slice(&placement.points[6..]) });
        }
        let [low, high] = scene.world.bounds().ok_or("--turntable needs a shape to turn around")?;
        let world_from_camera = scene.view.camera.middle();
        let (eye, middle) = (world_from_camera.point(DVec3::ZERO), (low + high) / 2.0);
        let up = world_from_camera.vector(DVec3::Y);
        let axis = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .max_by(|a, b| up.dot(*a).abs().total_cmp(&up.dot(*b).abs()));
        let axis = axis.map_or(DVec3::Y, |axis| axis * up.dot(axis).signum());
        let points = [eye, middle, axis].map(|point| point.to_array()).concat();
        let points = <[f64; 9]>::try_from(points).map_err(|_| "nine numbers".to_owned())?;
        // The camera may look past the middle, or mirror the picture.
        let placement = CameraPlacement::of(world_from_camera, points).map_err(|fault| around(&fault))?;
        Ok(Turntable { placement, axis })
    }

    /// The camera of a picture. The first picture has the camera of the scene, in the middle of its motion.
    fn camera(&self, camera: &Camera, number: u32, count: u32) -> Result<Camera, Failure> {
        if number == 0 {
            return Ok(camera.clone().placed(camera.middle()));
        }
        let turn = Transform::rotate(360.0 * f64::from(number) / f64::from(count), self.axis)
            .ok_or("--turntable: the up vector of LookAt is zero")?;
        let mut points = self.placement.points;
        let [eye, look] = [0, 3].map(|at| DVec3::from_slice(&points[at..at + 3]));
        points[..3].copy_from_slice(&(look + turn.vector(eye - look)).to_array());
        let placed = CameraPlacement { points, ..self.placement }.world_from_camera();
        let world_from_camera = placed.map_err(|fault| around(&fault))?;
        Ok(camera.clone().placed(world_from_camera))
    }
}

fn around(fault: &LookAtError) -> String {
    format!("--turntable: {fault}; place the camera with --lookat")
}

/// Focuses the lens of a view, and returns the line to write into the scene. Fails without a lens, or where nothing is.
pub fn focus(prepared: &Prepared, view: &mut View, place: FocusPlace) -> Result<String, Failure> {
    if view.camera.lens.is_none() {
        let message = "--focus needs a lens: add \"float lensradius\" to Camera, or use --lens-radius";
        return Err(message.into());
    }
    let [width, height] = view.film.resolution;
    let size = DVec2::new(f64::from(width), f64::from(height));
    let film = match place {
        FocusPlace::Pixel(at) => at + 0.5,
        FocusPlace::Fractions(at) => at * size,
    };
    if film.x > size.x || film.y > size.y {
        bail!("--focus: the picture has only {width} x {height} pixels");
    }
    let at = format!("{}, {}", film.x.floor(), film.y.floor());
    let Some(depth) = prepared.pick(view, film).map(|picked| picked.depth).filter(|depth| *depth > 0.0)
    else {
        bail!("--focus: there is nothing to focus on at pixel {at}; choose another place");
    };
    // Six digits, so that the line is short and gives the same picture.
    let depth = format!("{depth:.5e}").parse().unwrap_or(depth);
    if let Some(refused) = view.camera.lens_system().and_then(|lenses| lenses.refused_focus(depth)) {
        bail!("--focus: {refused}; choose another place than pixel {at}");
    }
    if let Some(lens) = &mut view.camera.lens {
        lens.focal_distance = depth;
    }
    let name = view.camera.focus_parameter();
    Ok(format!("focused on pixel {at}; to keep this, write \"float {name}\" {depth} in Camera"))
}
