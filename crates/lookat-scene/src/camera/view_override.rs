//! The placement of a camera, and what the caller sets of it instead of the scene.

use glam::DVec3;
use lookat_syntax::Span;
use serde::{Deserialize, Serialize};

use crate::camera::{
    Camera, FOCAL_DISTANCE, FOV, LENS_RADIUS_RANGE, Lens, Projection, SCREEN_WINDOW_HELP, ScreenWindow,
};
use crate::schema::Range;
use crate::transform::{LookAtError, Transform, in_range};

/// Settings that replace the placement and the parameters of the camera in the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ViewOverride {
    /// Eye, target and up vector of a `LookAt`. It replaces the whole camera transformation.
    pub look_at: Option<[f64; 9]>,
    /// The angle of view in degrees, above 0 and below 180. Only a perspective camera uses it.
    pub fov: Option<f64>,
    /// The radius of the aperture in units of camera space; 0 is a pinhole.
    pub lens_radius: Option<f64>,
    /// The distance to the plane of focus in units of camera space, above 0. Only a lens uses it.
    pub focal_distance: Option<f64>,
    /// The part of the screen on the film: xmin, xmax, ymin, ymax. Reversed edges mirror the picture.
    pub screen_window: Option<[f64; 4]>,
    /// An instant that replaces the time when the shutter is open, in units of `TransformTimes`.
    pub time: Option<f64>,
}

/// A camera that a `LookAt` places: `before`, the `LookAt` and `after` make the camera transformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPlacement {
    /// The `LookAt` in the text. `None` if the caller gives it.
    pub span: Option<Span>,
    /// The transformation before the `LookAt`, such as a mirroring `Scale -1 1 1`.
    pub before: Transform,
    /// Eye, target and up vector, in the space that `after` makes of the world.
    pub points: [f64; 9],
    /// The transformation after the `LookAt`, such as a rotation of the world.
    pub after: Transform,
}

/// What the file says about its camera beside the camera itself.
#[derive(Debug, Clone, Copy)]
pub struct FileCamera {
    /// The `LookAt`, or one that sees the same. `None` if the camera has no direction.
    pub placement: Option<CameraPlacement>,
    /// The `focaldistance`. A pinhole keeps it for the day it gets a lens.
    pub focal_distance: Option<f64>,
}

impl ViewOverride {
    /// The camera of the file with other values.
    ///
    /// # Errors
    ///
    /// The reason why one of them is out of range.
    pub fn changed(&self, own: &Camera, file: &FileCamera) -> Result<Camera, String> {
        self.check()?;
        let mut camera = own.clone();
        if let Some(points) = self.look_at {
            let placement = file.placement.ok_or("the camera of the file has no direction")?;
            let placed = CameraPlacement { points, ..placement }.world_from_camera();
            camera = camera.placed(placed.map_err(|fault| fault.to_string())?);
        }
        if let Some(time) = self.time {
            camera.shutter = camera.shutter.at(time);
        }
        if let (Some(fov), Projection::Perspective { .. }) = (self.fov, &own.projection) {
            camera.projection = Projection::Perspective { fov };
        }
        if let Some(lenses) = own.lens_system() {
            if let (Some(lens), Some(distance)) = (&mut camera.lens, self.focal_distance) {
                lens.focal_distance = distance;
                lenses.refused_focus(distance).map_or(Ok(()), Err)?;
            }
            return Ok(camera);
        }
        if let Some(edges) = self.screen_window {
            camera.screen = ScreenWindow::from(edges);
        }
        if own.projection != Projection::Environment {
            let radius = self.lens_radius.or(own.lens.map(|lens| lens.radius)).unwrap_or(0.0);
            let distance =
                self.focal_distance.or(own.lens.map(|lens| lens.focal_distance)).or(file.focal_distance);
            let lens = Lens { radius, focal_distance: distance.unwrap_or(Lens::UNFOCUSED) };
            camera.lens = (radius > 0.0).then_some(lens);
        }
        Ok(camera)
    }

    /// Fails if a value is out of range for every scene. The error is the reason.
    pub fn check(&self) -> Result<(), String> {
        let given = [
            self.look_at.as_ref().map(<[f64; 9]>::as_slice),
            self.screen_window.as_ref().map(<[f64; 4]>::as_slice),
        ];
        if !given.iter().flatten().all(|values| in_range(values)) {
            return Err("a number is too large".into());
        }
        if let Some(points) = self.look_at {
            CameraPlacement::new(points).world_from_camera().map_err(|fault| fault.to_string())?;
        }
        if let Some([x0, x1, y0, y1]) = self.screen_window
            && (x0 == x1 || y0 == y1)
        {
            return Err(format!("the window is empty: {SCREEN_WINDOW_HELP}"));
        }
        let within = |value: Option<f64>, range: Range, name: &str, unit: &str| match value {
            Some(value) if value.is_nan() => Err(format!("{name} must be a number")),
            Some(value) if !range.contains(value) => Err(format!("{name} must be {}{unit}", range.words())),
            Some(value) if !in_range(&[value]) => Err(format!("{name} is too large")),
            _ => Ok(()),
        };
        within(self.time, Range::ALL, "the time", "")?;
        within(self.fov, FOV.range, "the angle", " degrees")?;
        within(self.lens_radius, LENS_RADIUS_RANGE, "the radius", "")?;
        within(self.focal_distance, FOCAL_DISTANCE.range, "the distance", "")
    }

    /// The camera transformation, if it is set and valid.
    pub(crate) fn world_from_camera(&self) -> Option<Transform> {
        self.placement()?.world_from_camera().ok()
    }

    /// The placement of the camera, if it is set.
    pub(crate) fn placement(&self) -> Option<CameraPlacement> {
        self.look_at.map(CameraPlacement::new)
    }
}

impl CameraPlacement {
    /// The placement by eye, target and up vector alone.
    pub fn new(points: [f64; 9]) -> Self {
        CameraPlacement { span: None, before: Transform::IDENTITY, points, after: Transform::IDENTITY }
    }

    /// The placement of a camera by points of the caller's choice. `before` is the rest of the transformation, such as mirroring the picture.
    pub fn of(world_from_camera: Transform, points: [f64; 9]) -> Result<Self, LookAtError> {
        let looking = CameraPlacement::new(points);
        let before = world_from_camera.inverse() * looking.world_from_camera()?;
        Ok(CameraPlacement { before, ..looking })
    }

    /// World from camera space for this placement.
    pub fn world_from_camera(&self) -> Result<Transform, LookAtError> {
        let placed = (self.before * look_at(self.points)? * self.after).inverse();
        placed.in_range().then_some(placed).ok_or(LookAtError::OutOfRange)
    }

    /// True if the `LookAt` alone places the camera.
    pub fn is_plain(&self) -> bool {
        self.before == Transform::IDENTITY && self.after == Transform::IDENTITY
    }
}

/// The viewing transformation of eye, target and up vector.
pub(crate) fn look_at(points: [f64; 9]) -> Result<Transform, LookAtError> {
    let [eye, look, up] = [0, 3, 6].map(|at| DVec3::from_slice(&points[at..at + 3]));
    Transform::look_at(eye, look, up)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{LoadOptions, Loaded, load};

    const CAMERA: &str = "Scale -1 1 1 LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float halffov\" 10";

    fn loaded(camera: &str, view: ViewOverride) -> Loaded {
        let text = format!(
            "{camera} Film \"image\" Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\" \
            CoordSysTransform \"camera\" Shape \"sphere\" WorldEnd"
        );
        let options = LoadOptions { view, ..LoadOptions::default() };
        load(Path::new("a.pbrt"), &|_: &Path| Ok(text.clone().into()), &options)
    }

    /// An override gives the scene that its directive or parameter gives.
    #[test]
    fn an_override_acts_like_the_scene() {
        let none = ViewOverride::default();
        let moved = "LookAt 1 2 3 4 5 6 0 0 1";
        for (view, scene) in [
            (ViewOverride { fov: Some(50.0), ..none }, CAMERA.replace("halffov\" 10", "fov\" 50")),
            (ViewOverride { lens_radius: Some(0.5), ..none }, format!("{CAMERA} \"float lensradius\" .5")),
            (
                ViewOverride { lens_radius: Some(0.5), focal_distance: Some(3.0), ..none },
                format!("{CAMERA} \"float lensradius\" .5 \"float focaldistance\" 3"),
            ),
            (
                ViewOverride { screen_window: Some([-1.0, 2.0, 3.0, -4.0]), ..none },
                format!("{CAMERA} \"float screenwindow\" [-1 2 3 -4]"),
            ),
            (
                ViewOverride { look_at: Some([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 1.0]), ..none },
                CAMERA.replace("Scale -1 1 1 LookAt 0 0 -4 0 0 0 0 1 0", moved),
            ),
        ] {
            let (found, expected) = (loaded(CAMERA, view), loaded(&scene, none));
            let messages =
                |loaded: &Loaded| loaded.diagnostics.iter().map(|it| it.message.clone()).collect::<Vec<_>>();
            assert_eq!(messages(&found), messages(&expected), "{scene}");
            let (found, expected) = (found.scene.unwrap(), expected.scene.unwrap());
            assert_eq!(found.view.camera, expected.view.camera, "{scene}");
            // What the camera carries moves with it.
            assert_eq!(
                format!("{:?}", found.world.primitives[0].shape),
                format!("{:?}", expected.world.primitives[0].shape)
            );
        }
        let pinhole = ViewOverride { lens_radius: Some(0.0), ..none };
        let found = loaded(&format!("{CAMERA} \"float lensradius\" .5 \"float focaldistance\" 3"), pinhole);
        assert!(found.scene.unwrap().view.camera.lens.is_none() && found.diagnostics.is_empty());
    }

    #[test]
    fn values_out_of_range_do_not_fit() {
        let none = ViewOverride::default();
        for (view, reason) in [
            (ViewOverride { fov: Some(180.0), ..none }, "the angle must be above 0 and below 180 degrees"),
            (ViewOverride { lens_radius: Some(-1.0), ..none }, "the radius must be at least 0"),
            (ViewOverride { focal_distance: Some(0.0), ..none }, "the distance must be above 0"),
            (ViewOverride { focal_distance: Some(1e60), ..none }, "the distance is too large"),
            (ViewOverride { look_at: Some([f64::NAN; 9]), ..none }, "a number is too large"),
            (
                ViewOverride { look_at: Some([1e50, 1e50, -1e50, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), ..none },
                "the transformation or its inverse has entries above 1e50",
            ),
            (
                ViewOverride { look_at: Some([1.0; 9]), ..none },
                "the eye and the target of LookAt are the same point",
            ),
            (
                ViewOverride { screen_window: Some([1.0, 1.0, 0.0, 1.0]), ..none },
                "the window is empty: write the edges as xmin xmax ymin ymax",
            ),
        ] {
            let found = loaded(CAMERA, view);
            assert_eq!(found.override_error.as_deref(), Some(reason));
            assert!(found.scene.is_none());
        }
    }

    #[test]
    fn a_placement_gives_the_camera_again() {
        let found = loaded(CAMERA, ViewOverride::default());
        let camera = found.scene.unwrap().view.camera;
        assert!(matches!(camera.projection, Projection::Perspective { fov: 20.0 }));
        assert_eq!(found.placement.unwrap().world_from_camera(), Ok(camera.world_from_camera));
        assert!(found.world_follows_camera);
        for other in [
            "Translate 1 2 3",
            &CAMERA.replace(" Camera", " Identity Camera"),
            &CAMERA.replace("LookAt", "ActiveTransform EndTime LookAt"),
        ] {
            assert_eq!(loaded(other, ViewOverride::default()).placement, None);
        }
    }

    #[test]
    fn a_placement_knows_what_is_around_its_look_at() {
        let text = CAMERA.replace(
            " Camera",
            " Rotate 3 0 0 1 ActiveTransform EndTime Scale 2 2 2 ActiveTransform All Translate 1 2 3 Camera",
        );
        let found = loaded(&text, ViewOverride::default());
        let placement = found.placement.unwrap();
        assert!(!placement.is_plain() && placement.before.vector(DVec3::ONE) == DVec3::new(-1.0, 1.0, 1.0));
        let [made, own] =
            [placement.world_from_camera().unwrap(), found.scene.unwrap().view.camera.world_from_camera]
                .map(|transform| transform.matrix());
        assert!(made.abs_diff_eq(own, 1e-12), "{made} {own}");
    }
}
