//! The film of a scene.

use lookat_scene::{MAX_PIXELS, MAX_SIDE, PixelBounds, ScreenWindow};
use pyo3::prelude::*;

use crate::value_error;
use crate::view::SharedView;

/// The film of a scene. What is set changes the scene.
#[pyclass(module = "lookat")]
pub struct Film {
    pub view: SharedView,
}

#[pymethods]
impl Film {
    /// Width and height of the full picture in pixels.
    #[getter]
    fn resolution(&self) -> (u32, u32) {
        self.view.lock().view.film.resolution.into()
    }

    /// Another size shows as much along the shorter side, and all of the picture: the crop window is gone.
    #[setter]
    fn set_resolution(&self, size: [u32; 2]) -> PyResult<()> {
        let [width, height] = size;
        let fits = (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height);
        if !fits || u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(value_error(format!(
                "width and height must be from 1 to {MAX_SIDE}, with at most {MAX_PIXELS} pixels"
            )));
        }
        let view = &mut self.view.lock().view;
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
    fn crop(&self) -> (u32, u32, u32, u32) {
        let PixelBounds { x0, y0, x1, y1 } = self.view.lock().view.film.crop;
        (x0, x1, y0, y1)
    }

    #[setter]
    fn set_crop(&self, edges: [u32; 4]) -> PyResult<()> {
        let [x0, x1, y0, y1] = edges;
        let film = &mut self.view.lock().view.film;
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
    fn scale(&self) -> f64 {
        self.view.lock().view.film.scale
    }

    #[setter]
    fn set_scale(&self, scale: f64) -> PyResult<()> {
        if !scale.is_finite() {
            return Err(value_error("the scale must be a finite number"));
        }
        self.view.lock().view.film.scale = scale;
        Ok(())
    }

    /// The largest luminance of a sample; brighter ones are scaled down.
    #[getter]
    fn max_sample_luminance(&self) -> f64 {
        self.view.lock().view.film.max_sample_luminance
    }

    #[setter]
    fn set_max_sample_luminance(&self, luminance: f64) -> PyResult<()> {
        if luminance.is_nan() || luminance <= 0.0 {
            return Err(value_error("the luminance must be above 0"));
        }
        self.view.lock().view.film.max_sample_luminance = luminance;
        Ok(())
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.resolution();
        format!("<lookat.Film {width}x{height}, crop {:?}>", self.crop())
    }
}
