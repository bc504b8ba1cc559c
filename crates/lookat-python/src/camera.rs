//! The camera of a scene.

use lookat_scene::glam::DMat4;
use lookat_scene::{CameraPlacement, FileCamera, Transform, ViewOverride};
use numpy::{AllowTypeChange, PyArray2, PyArrayLike2, PyArrayMethods, ToPyArray, ndarray::ArrayView2};
use pyo3::prelude::*;

use crate::scene::Scene;
use crate::value_error;

/// The camera of a scene. What is set changes the scene.
#[pyclass(module = "lookat")]
pub struct Camera {
    pub scene: Py<Scene>,
}

impl Camera {
    /// A value of the camera.
    fn get<T>(&self, py: Python<'_>, value: impl Fn(&lookat_scene::Camera) -> T) -> T {
        value(&self.scene.borrow(py).scene.view.camera)
    }

    /// Fails for cameras on which a parameter has no effect.
    fn check_thin_lens(&self, py: Python<'_>, parameter: &str) -> PyResult<()> {
        let kind = self.get(py, |camera| camera.projection.name());
        match kind {
            "realistic" | "environment" => {
                Err(value_error(format!("{parameter} has no effect on a camera of type {kind}")))
            }
            _ => Ok(()),
        }
    }

    /// Changes the camera.
    fn set(&self, py: Python<'_>, change: ViewOverride) -> PyResult<()> {
        let scene = &mut *self.scene.borrow_mut(py);
        if change.look_at.is_some() {
            scene.check_placed_freely()?;
        }
        // A camera that no LookAt places can be placed by one.
        let placement = scene.placement.or(change.look_at.map(CameraPlacement::new));
        let file = FileCamera { placement, focal_distance: None };
        scene.scene.view.camera = change.changed(&scene.scene.view.camera, &file).map_err(value_error)?;
        Ok(())
    }
}

#[pymethods]
impl Camera {
    /// The type: perspective, orthographic, environment or realistic.
    #[getter]
    fn kind(&self, py: Python<'_>) -> &'static str {
        self.get(py, |camera| camera.projection.name())
    }

    /// The angle of view in degrees; `None` for cameras that have none. Only a perspective camera takes another.
    #[getter]
    fn fov(&self, py: Python<'_>) -> Option<f64> {
        self.get(py, lookat_scene::Camera::fov)
    }

    #[setter]
    fn set_fov(&self, py: Python<'_>, fov: f64) -> PyResult<()> {
        let kind = self.kind(py);
        if kind != "perspective" {
            return Err(value_error(format!("the fov of a camera of type {kind} cannot be set")));
        }
        self.set(py, ViewOverride { fov: Some(fov), ..ViewOverride::default() })
    }

    /// The position of the eye in the world.
    #[getter]
    fn eye(&self, py: Python<'_>) -> (f64, f64, f64) {
        self.get(py, |camera| camera.world_from_camera.matrix().w_axis.truncate().into())
    }

    /// Places the camera: the eye, the point that it looks at, and the direction that is up in the picture.
    #[pyo3(signature = (eye, target, up = [0.0, 1.0, 0.0]))]
    fn look_at(&self, py: Python<'_>, eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> PyResult<()> {
        let mut points = [0.0; 9];
        for (points, own) in points.chunks_mut(3).zip([eye, target, up]) {
            points.copy_from_slice(&own);
        }
        self.set(py, ViewOverride { look_at: Some(points), ..ViewOverride::default() })
    }

    /// World from camera space: a matrix of 4 x 4 for column vectors.
    #[getter]
    fn world_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.get(py, |camera| camera.world_from_camera.matrix().transpose().to_cols_array_2d());
        let array = ArrayView2::from(&rows).to_pyarray(py);
        // A copy: what is written to it would be lost.
        array.try_readwrite().map_err(value_error)?.make_nonwriteable();
        Ok(array)
    }

    #[setter]
    fn set_world_from_camera(
        &self,
        py: Python<'_>,
        matrix: PyArrayLike2<'_, f64, AllowTypeChange>,
    ) -> PyResult<()> {
        let matrix = matrix.as_array();
        if matrix.shape() != [4, 4] {
            return Err(value_error("expected a matrix of 4 x 4"));
        }
        let matrix = DMat4::from_cols_array(&std::array::from_fn(|at| matrix[[at % 4, at / 4]]));
        let transform = Transform::from_matrix(matrix);
        let transform = transform.ok_or_else(|| value_error("the matrix is singular or not affine"))?;
        let scene = &mut *self.scene.borrow_mut(py);
        scene.check_placed_freely()?;
        scene.placement = None;
        scene.scene.view.camera = scene.scene.view.camera.clone().placed(transform);
        Ok(())
    }

    /// The radius of the lens; 0 is a pinhole.
    #[getter]
    fn lens_radius(&self, py: Python<'_>) -> f64 {
        self.get(py, |camera| camera.lens.map_or(0.0, |lens| lens.radius))
    }

    #[setter]
    fn set_lens_radius(&self, py: Python<'_>, radius: f64) -> PyResult<()> {
        self.check_thin_lens(py, "lens_radius")?;
        self.set(py, ViewOverride { lens_radius: Some(radius), ..ViewOverride::default() })
    }

    /// The distance to the plane in focus; `None` for a pinhole.
    #[getter]
    fn focal_distance(&self, py: Python<'_>) -> Option<f64> {
        self.get(py, |camera| camera.lens.map(|lens| lens.focal_distance))
    }

    #[setter]
    fn set_focal_distance(&self, py: Python<'_>, distance: f64) -> PyResult<()> {
        if self.get(py, |camera| camera.lens.is_none()) {
            return Err(value_error("a pinhole is sharp at all distances: set lens_radius first"));
        }
        self.set(py, ViewOverride { focal_distance: Some(distance), ..ViewOverride::default() })
    }

    /// The part of the screen on the film: x from, x to, y from, y to.
    #[getter]
    fn screen_window(&self, py: Python<'_>) -> (f64, f64, f64, f64) {
        self.get(py, |camera| camera.screen.edges().into())
    }

    #[setter]
    fn set_screen_window(&self, py: Python<'_>, edges: [f64; 4]) -> PyResult<()> {
        self.check_thin_lens(py, "screen_window")?;
        self.set(py, ViewOverride { screen_window: Some(edges), ..ViewOverride::default() })
    }

    /// When the shutter opens and closes.
    #[getter]
    fn shutter(&self, py: Python<'_>) -> (f64, f64) {
        self.get(py, |camera| (camera.shutter.open, camera.shutter.close))
    }

    #[setter]
    fn set_shutter(&self, py: Python<'_>, times: [f64; 2]) -> PyResult<()> {
        let [open, close] = times;
        if !(open.is_finite() && close.is_finite() && open <= close) {
            return Err(value_error("the shutter opens no later than it closes"));
        }
        let scene = &mut *self.scene.borrow_mut(py);
        (scene.scene.view.camera.shutter.open, scene.scene.view.camera.shutter.close) = (open, close);
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (x, y, z) = self.eye(py);
        let fov = self.fov(py).map(|fov| format!(", fov {fov}"));
        format!("<lookat.Camera {} at ({x}, {y}, {z}){}>", self.kind(py), fov.unwrap_or_default())
    }
}
