//! The camera of a scene.

use lookat_scene::glam::DMat4;
use lookat_scene::{CameraPlacement, FileCamera, Transform, ViewOverride};
use numpy::{AllowTypeChange, PyArray2, PyArrayLike2, PyArrayMethods, ToPyArray, ndarray::ArrayView2};
use pyo3::prelude::*;

use crate::value_error;
use crate::view::SharedView;

/// The camera of a scene. What is set changes the scene.
#[pyclass(module = "lookat")]
pub struct Camera {
    pub view: SharedView,
}

impl Camera {
    /// A value of the camera.
    fn get<T>(&self, value: impl Fn(&lookat_scene::Camera) -> T) -> T {
        value(&self.view.lock().view.camera)
    }

    /// Fails for cameras on which a parameter has no effect.
    fn check_thin_lens(&self, parameter: &str) -> PyResult<()> {
        let kind = self.get(|camera| camera.projection.name());
        match kind {
            "realistic" | "environment" => {
                Err(value_error(format!("{parameter} has no effect on a camera of type {kind}")))
            }
            _ => Ok(()),
        }
    }

    /// Changes the camera.
    fn set(&self, change: ViewOverride) -> PyResult<()> {
        let mut placed = self.view.lock();
        if change.look_at.is_some() {
            placed.check_placed_freely()?;
        }
        // A camera that no LookAt places can be placed by one.
        let placement = placed.placement.or(change.look_at.map(CameraPlacement::new));
        let file = FileCamera { placement, focal_distance: None };
        placed.view.camera = change.changed(&placed.view.camera, &file).map_err(value_error)?;
        Ok(())
    }
}

#[pymethods]
impl Camera {
    /// The type: perspective, orthographic, environment or realistic.
    #[getter]
    fn kind(&self) -> &'static str {
        self.get(|camera| camera.projection.name())
    }

    /// The angle of view in degrees; `None` for cameras that have none. Only a perspective camera takes another.
    #[getter]
    fn fov(&self) -> Option<f64> {
        self.get(lookat_scene::Camera::fov)
    }

    #[setter]
    fn set_fov(&self, fov: f64) -> PyResult<()> {
        let kind = self.kind();
        if kind != "perspective" {
            return Err(value_error(format!("the fov of a camera of type {kind} cannot be set")));
        }
        self.set(ViewOverride { fov: Some(fov), ..ViewOverride::default() })
    }

    /// The position of the eye in the world.
    #[getter]
    fn eye(&self) -> (f64, f64, f64) {
        self.get(|camera| camera.world_from_camera.matrix().w_axis.truncate().into())
    }

    /// Places the camera: the eye, the point that it looks at, and the direction that is up in the picture.
    #[pyo3(signature = (eye, target, up = [0.0, 1.0, 0.0]))]
    fn look_at(&self, eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> PyResult<()> {
        let mut points = [0.0; 9];
        for (points, own) in points.chunks_mut(3).zip([eye, target, up]) {
            points.copy_from_slice(&own);
        }
        self.set(ViewOverride { look_at: Some(points), ..ViewOverride::default() })
    }

    /// World from camera space: a matrix of 4 x 4 for column vectors.
    #[getter]
    fn world_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.get(|camera| camera.world_from_camera.matrix().transpose().to_cols_array_2d());
        let array = ArrayView2::from(&rows).to_pyarray(py);
        // A copy: what is written to it would be lost.
        array.try_readwrite().map_err(value_error)?.make_nonwriteable();
        Ok(array)
    }

    #[setter]
    fn set_world_from_camera(&self, matrix: PyArrayLike2<'_, f64, AllowTypeChange>) -> PyResult<()> {
        let matrix = matrix.as_array();
        if matrix.shape() != [4, 4] {
            return Err(value_error("expected a matrix of 4 x 4"));
        }
        let matrix = DMat4::from_cols_array(&std::array::from_fn(|at| matrix[[at % 4, at / 4]]));
        let transform = Transform::from_matrix(matrix);
        let transform = transform.ok_or_else(|| value_error("the matrix is singular or not affine"))?;
        let mut placed = self.view.lock();
        placed.check_placed_freely()?;
        placed.placement = None;
        placed.view.camera = placed.view.camera.clone().placed(transform);
        Ok(())
    }

    /// The radius of the lens; 0 is a pinhole.
    #[getter]
    fn lens_radius(&self) -> f64 {
        self.get(|camera| camera.lens.map_or(0.0, |lens| lens.radius))
    }

    #[setter]
    fn set_lens_radius(&self, radius: f64) -> PyResult<()> {
        self.check_thin_lens("lens_radius")?;
        self.set(ViewOverride { lens_radius: Some(radius), ..ViewOverride::default() })
    }

    /// The distance to the plane in focus; `None` for a pinhole.
    #[getter]
    fn focal_distance(&self) -> Option<f64> {
        self.get(|camera| camera.lens.map(|lens| lens.focal_distance))
    }

    #[setter]
    fn set_focal_distance(&self, distance: f64) -> PyResult<()> {
        if self.get(|camera| camera.lens.is_none()) {
            return Err(value_error("a pinhole is sharp at all distances: set lens_radius first"));
        }
        self.set(ViewOverride { focal_distance: Some(distance), ..ViewOverride::default() })
    }

    /// The part of the screen on the film: x from, x to, y from, y to.
    #[getter]
    fn screen_window(&self) -> (f64, f64, f64, f64) {
        self.get(|camera| camera.screen.edges().into())
    }

    #[setter]
    fn set_screen_window(&self, edges: [f64; 4]) -> PyResult<()> {
        self.check_thin_lens("screen_window")?;
        self.set(ViewOverride { screen_window: Some(edges), ..ViewOverride::default() })
    }

    /// When the shutter opens and closes.
    #[getter]
    fn shutter(&self) -> (f64, f64) {
        self.get(|camera| (camera.shutter.open, camera.shutter.close))
    }

    #[setter]
    fn set_shutter(&self, times: [f64; 2]) -> PyResult<()> {
        let [open, close] = times;
        if !(open.is_finite() && close.is_finite() && open <= close) {
            return Err(value_error("the shutter opens no later than it closes"));
        }
        let shutter = &mut self.view.lock().view.camera.shutter;
        (shutter.open, shutter.close) = (open, close);
        Ok(())
    }

    fn __repr__(&self) -> String {
        let (x, y, z) = self.eye();
        let fov = self.fov().map(|fov| format!(", fov {fov}"));
        format!("<lookat.Camera {} at ({x}, {y}, {z}){}>", self.kind(), fov.unwrap_or_default())
    }
}
