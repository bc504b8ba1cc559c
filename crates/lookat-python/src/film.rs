//! The film of a scene.

use lookat_scene::{MAX_PIXELS, MAX_SIDE, PixelBounds, ScreenWindow};
use pyo3::prelude::*;

use crate::scene::Scene;
use crate::value_error;

/// The film of a scene. What is set changes the scene.
#[pyclass(module = "lookat")]
pub struct Film {
    pub scene: Py<Scene>,
}

#[pymethods]
impl Film {
    /// Width and height of the full picture in pixels.
    #[getter]
    fn resolution(&self, py: Python<'_>) -> (u32, u32) {
        self.scene.borrow(py).scene.view.film.resolution.into()
    }

    /// Another size shows as much along the shorter side, and all of the picture: the crop window is gone.
    #[setter]
    fn set_resolution(&self, py: Python<'_>, size: [u32; 2]) -> PyResult<()> {
        let [width, height] = size;
        let fits = (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height);
        if !fits || u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(value_error(format!(
                "width and height must be from 1 to {MAX_SIDE}, with at most {MAX_PIXELS} pixels"
            )));
        }
        let view = &mut self.scene.borrow_mut(py).scene.view;
        if view.camera.lens_system().is_some() && view.film.resolution != [width, height] {
            return Err(value_error(
                "the film of a realistic camera has its size in the scene: change it there",
            ));
        }
        let is_default = view.camera.screen == ScreenWindow::of_film(&view.film);
        view.film.resolution = [width, height];
        view.film.crop = PixelBounds { x0: 0, y0: 0, x1: width, y1: height };
        if is_default {
            view.camera.screen = ScreenWindow::of_film(&view.film);
        }
        Ok(())
    }

    /// The pixels to render: left, right, top and bottom, the right and the bottom one behind the last.
    #[getter]
    fn crop(&self, py: Python<'_>) -> (u32, u32, u32, u32) {
        let PixelBounds { x0, y0, x1, y1 } = self.scene.borrow(py).scene.view.film.crop;
        (x0, x1, y0, y1)
    }

    #[setter]
    fn set_crop(&self, py: Python<'_>, edges: [u32; 4]) -> PyResult<()> {
        let [x0, x1, y0, y1] = edges;
        let film = &mut self.scene.borrow_mut(py).scene.view.film;
        let [width, height] = film.resolution;
        if x0 >= x1 || x1 > width || y0 >= y1 || y1 > height {
            return Err(value_error(format!(
                "the crop window must be within {width} x {height} pixels, and not empty"
            )));
        }
        film.crop = PixelBounds { x0, y0, x1, y1 };
        Ok(())
    }

    /// The factor on every pixel.
    #[getter]
    fn scale(&self, py: Python<'_>) -> f64 {
        self.scene.borrow(py).scene.view.film.scale
    }

    #[setter]
    fn set_scale(&self, py: Python<'_>, scale: f64) -> PyResult<()> {
        if !scale.is_finite() {
            return Err(value_error("the scale must be a finite number"));
        }
        self.scene.borrow_mut(py).scene.view.film.scale = scale;
        Ok(())
    }

    /// The largest luminance of a sample; brighter ones are scaled down.
    #[getter]
    fn max_sample_luminance(&self, py: Python<'_>) -> f64 {
        self.scene.borrow(py).scene.view.film.max_sample_luminance
    }

    #[setter]
    fn set_max_sample_luminance(&self, py: Python<'_>, luminance: f64) -> PyResult<()> {
        if luminance.is_nan() || luminance <= 0.0 {
            return Err(value_error("the luminance must be above 0"));
        }
        self.scene.borrow_mut(py).scene.view.film.max_sample_luminance = luminance;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (width, height) = self.resolution(py);
        format!("<lookat.Film {width}x{height}, crop {:?}>", self.crop(py))
    }
}
