//! The camera of a scene with other values, for the page of `view` and for animations.

use lookat_scene::{Camera, CameraPlacement, Lens, Projection, ScreenWindow, ViewOverride};

use crate::failure::Failure;

/// What the file says about its camera beside the camera itself.
#[derive(Clone, Copy)]
pub struct FileCamera {
    /// The `LookAt`, or one that sees the same. `None` if the camera has no direction.
    pub placement: Option<CameraPlacement>,
    /// The `focaldistance`. A pinhole keeps it for the day it gets a lens.
    pub focal_distance: Option<f64>,
}

/// The camera of the file with other values. Fails if one of them is out of range.
pub fn changed(own: &Camera, file: &FileCamera, set: &ViewOverride) -> Result<Camera, Failure> {
    set.check()?;
    let mut camera = own.clone();
    if let Some(points) = set.look_at {
        let placement = file.placement.ok_or("the camera of the file has no direction")?;
        let placed = CameraPlacement { points, ..placement }.world_from_camera();
        camera = camera.placed(placed.map_err(|fault| fault.to_string())?);
    }
    if let Some(time) = set.time {
        camera.shutter = camera.shutter.at(time);
    }
    if let (Some(fov), Projection::Perspective { .. }) = (set.fov, &own.projection) {
        camera.projection = Projection::Perspective { fov };
    }
    if let Some(lenses) = own.lens_system() {
        if let (Some(lens), Some(distance)) = (&mut camera.lens, set.focal_distance) {
            lens.focal_distance = distance;
            lenses.refused_focus(distance).map_or(Ok(()), Err)?;
        }
        return Ok(camera);
    }
    if let Some(edges) = set.screen_window {
        camera.screen = ScreenWindow::from(edges);
    }
    if own.projection != Projection::Environment {
        let radius = set.lens_radius.or(own.lens.map(|lens| lens.radius)).unwrap_or(0.0);
        let distance =
            set.focal_distance.or(own.lens.map(|lens| lens.focal_distance)).or(file.focal_distance);
        let lens = Lens { radius, focal_distance: distance.unwrap_or(Lens::UNFOCUSED) };
        camera.lens = (radius > 0.0).then_some(lens);
    }
    Ok(camera)
}
