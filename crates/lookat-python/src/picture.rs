//! Pictures: arrays, files, and what a notebook shows.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lookat_image::{Image, MemoryBudget, PictureFile, ToneCurve, ToneMapping, Window};
use lookat_render::{Layer, Layers};
use numpy::ndarray::{Array2, Array3, ArrayView2};
use numpy::{AllowTypeChange, PyArray2, PyArray3, PyArrayLike3, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::{as_python, value_error};

/// A picture, with its layers and errors.
#[pyclass(module = "lookat", frozen)]
pub struct Picture {
    pub image: Arc<Image>,
    /// What is known of its rendering, as JSON.
    pub statistics: serde_json::Value,
}

impl Picture {
    pub fn new(image: Image, statistics: serde_json::Value) -> Picture {
        Picture { image: Arc::new(image), statistics }
    }

    fn size(&self) -> [usize; 2] {
        self.image.data_window.size().map(|side| side as usize)
    }

    /// Some channels as an array of height x width x channels.
    fn stacked<'py>(&self, py: Python<'py>, names: &[&str]) -> Option<Bound<'py, PyArray3<f32>>> {
        let [width, height] = self.size();
        let planes: Option<Vec<&[f32]>> = names.iter().map(|name| self.image.channel(name)).collect();
        let planes = planes?;
        let at = |(y, x, channel): (usize, usize, usize)| planes[channel][y * width + x];
        Some(Array3::from_shape_fn((height, width, names.len()), at).to_pyarray(py))
    }

    /// One channel as an array of height x width.
    fn plane<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray2<f32>>> {
        let [width, height] = self.size();
        let view = ArrayView2::from_shape((height, width), self.image.channel(name)?).ok()?;
        Some(view.to_pyarray(py))
    }

    /// The picture in 8 bits, as a PNG file.
    fn png(&self, mapping: ToneMapping) -> PyResult<Vec<u8>> {
        let mut image = Image::clone(&self.image);
        image.channels.retain(|channel| ["R", "G", "B"].contains(&&*channel.name));
        mapping.apply(&mut image);
        image.to_bytes(Path::new("picture.png")).map_err(value_error)
    }
}

#[pymethods]
impl Picture {
    /// Reads a picture: .exr, .pfm, .png, .tga, .jpg or .hdr.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Picture> {
        let (image, _charge) = PictureFile::open(&path, &MemoryBudget::default())
            .and_then(PictureFile::read)
            .map_err(value_error)?;
        Ok(Picture::new(image, serde_json::Value::Null))
    }

    /// Linear RGB: height x width x 3.
    #[getter]
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        self.stacked(py, &["R", "G", "B"]).ok_or_else(|| value_error("this picture has no colors"))
    }

    /// The layers by their names in `render`: height x width, or height x width x channels.
    #[getter]
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let layers = PyDict::new(py);
        let named = |name: &'static str| Some((name, Layer::named(name)?));
        for (name, layer) in Layers::names().filter_map(named) {
            let channels = layer.channels();
            match channels {
                [one] => self.plane(py, one).map(|plane| layers.set_item(name, plane)).transpose()?,
                _ => self.stacked(py, channels).map(|all| layers.set_item(name, all)).transpose()?,
            };
        }
        Ok(layers)
    }

    /// The standard error of each value: height x width x 3. `None` without error layers.
    #[getter]
    fn standard_error<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray3<f32>>> {
        let errors = self.image.errors()?;
        let [width, height] = self.size();
        let at = |(y, x, channel): (usize, usize, usize)| errors[y * width + x].standard_error[channel];
        Some(Array3::from_shape_fn((height, width, 3), at).to_pyarray(py))
    }

    /// The samples of each pixel, where the picture has errors or the layer `samples`: height x width.
    #[getter]
    fn samples<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<u32>>> {
        let [width, height] = self.size();
        let counts = self.image.channel("count.samples")?;
        let at = |(y, x): (usize, usize)| counts[y * width + x] as u32;
        Some(Array2::from_shape_fn((height, width), at).to_pyarray(py))
    }

    /// What is known of its rendering: samples, rays, seconds. `None` for pictures from files.
    #[getter]
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        as_python(py, &self.statistics)
    }

    /// Left, top, width and height of its pixels in the full picture.
    #[getter]
    fn window(&self) -> (i64, i64, i64, i64) {
        let Window { x, y, width, height } = self.image.data_window;
        (x.into(), y.into(), width.into(), height.into())
    }

    /// Writes the picture: .exr or .pfm, linear, or .png or .tga, with an exposure in stops or "auto", and a tone curve.
    #[pyo3(signature = (path, exposure = None, tone = "none"))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        exposure: Option<&Bound<'_, PyAny>>,
        tone: &str,
    ) -> PyResult<()> {
        let mapping = self.mapping(exposure, tone)?;
        let is_linear = lookat_image::Format::from_path(&path).is_some_and(|format| !format.is_eight_bit());
        if is_linear && (exposure.is_some() || tone != "none") {
            return Err(value_error("exposure and tone change only .png and .tga files"));
        }
        let image = self.image.clone();
        py.detach(move || {
            let mut image = Image::clone(&image);
            mapping.apply(&mut image);
            image.write(&path)
        })
        .map_err(|error| pyo3::exceptions::PyOSError::new_err(error.to_string()))
    }

    /// The picture for a notebook, at the exposure that suits it.
    fn _repr_png_(&self) -> PyResult<Vec<u8>> {
        self.png(ToneMapping { exposure: self.image.suitable_exposure(), curve: ToneCurve::None })
    }

    /// The pixels, for functions of NumPy.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if copy == Some(false) {
            return Err(value_error("the pixels are always copied"));
        }
        let pixels = self.pixels(py)?.into_any();
        match dtype {
            Some(dtype) => pixels.call_method1("astype", (dtype,)),
            None => Ok(pixels),
        }
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.size();
        format!("<lookat.Picture {width}x{height}, {} channels>", self.image.channels.len())
    }
}

impl Picture {
    fn mapping(&self, exposure: Option<&Bound<'_, PyAny>>, tone: &str) -> PyResult<ToneMapping> {
        let curve = ToneCurve::ALL.into_iter().find(|(name, _)| *name == tone).map(|(_, curve)| curve);
        let curve = curve.ok_or_else(|| {
            value_error(format!("the tone curves are {}", ToneCurve::ALL.map(|(name, _)| name).join(", ")))
        })?;
        let exposure = match exposure {
            None => 0.0,
            Some(value) if value.extract::<String>().is_ok_and(|text| text == "auto") => {
                self.image.suitable_exposure()
            }
            Some(value) => value.extract()?,
        };
        if !(-100.0..=100.0).contains(&exposure) {
            return Err(value_error("exposure must be from -100 to 100 stops, or \"auto\""));
        }
        Ok(ToneMapping { exposure, curve })
    }
}

/// A picture: one of lookat, the name of a file, or an array of height x width x 3.
pub fn picture_of(value: &Bound<'_, PyAny>) -> PyResult<Arc<Image>> {
    if let Ok(picture) = value.cast::<Picture>() {
        return Ok(picture.get().image.clone());
    }
    if value.hasattr("__array__")? {
        let array: PyArrayLike3<'_, f32, AllowTypeChange> =
            value.extract().map_err(|_| value_error("expected an array of height x width x 3 numbers"))?;
        let array = array.as_array();
        let (height, width, channels) = array.dim();
        if channels != 3 {
            return Err(value_error(format!(
                "expected an array of height x width x 3, not of {channels} channels"
            )));
        }
        let plane =
            |channel: usize| array.slice(numpy::ndarray::s![.., .., channel]).iter().copied().collect();
        let side = |side: usize| u32::try_from(side).map_err(value_error);
        let window = Window { x: 0, y: 0, width: side(width)?, height: side(height)? };
        return Ok(Arc::new(Image::from_planes(window, window, [0, 1, 2].map(plane))));
    }
    if let Ok(path) = value.extract::<PathBuf>() {
        return Ok(Picture::read(path)?.image);
    }
    Err(pyo3::exceptions::PyTypeError::new_err(
        "expected a Picture, the name of a file, or an array of height x width x 3",
    ))
}
