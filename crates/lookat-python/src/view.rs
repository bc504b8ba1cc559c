//! How a scene is seen: what a scene shares with its camera and its film.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lookat_scene::{CameraPlacement, View};
use pyo3::prelude::*;

use crate::value_error;

/// A view, and how its camera was placed.
pub struct PlacedView {
    pub view: View,
    /// What placed the camera. `None` if no `LookAt` has.
    pub placement: Option<CameraPlacement>,
    /// True if another place of the camera would change the world.
    pub world_follows_camera: bool,
}

impl PlacedView {
    /// Fails if another place of the camera would change the world.
    pub fn check_placed_freely(&self) -> PyResult<()> {
        if self.world_follows_camera {
            return Err(value_error(
                "CoordSysTransform \"camera\" places a part of this world relative to the camera: change the camera in the text",
            ));
        }
        Ok(())
    }
}

/// The view of a scene: the scene, its camera and its film change the same one, from any thread.
#[derive(Clone)]
pub struct SharedView(Arc<Mutex<PlacedView>>);

impl SharedView {
    pub fn new(view: PlacedView) -> SharedView {
        SharedView(Arc::new(Mutex::new(view)))
    }

    /// For as long as no Python code runs: another thread may wait for the view with the GIL.
    pub fn lock(&self) -> MutexGuard<'_, PlacedView> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
