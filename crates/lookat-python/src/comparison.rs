//! Compares two pictures.

use lookat_image::{Comparison, Metric, Rules, THRESHOLD, align};
use pyo3::prelude::*;

use crate::picture::picture_of;
use crate::{as_python, start_threads, value_error};

/// The difference between two pictures, as `lookat compare --json` prints it.
#[pyfunction]
#[pyo3(signature = (actual, expected, *, only = Vec::new(), threshold = THRESHOLD))]
pub fn compare<'py>(
    actual: &Bound<'py, PyAny>,
    expected: &Bound<'py, PyAny>,
    only: Vec<String>,
    threshold: f32,
) -> PyResult<Bound<'py, PyAny>> {
    let py = actual.py();
    start_threads()?;
    if threshold.is_nan() || threshold < 0.0 {
        return Err(value_error("threshold must be 0 or more"));
    }
    let only = only.iter().map(|name| {
        Metric::from_name(name).ok_or_else(|| {
            value_error(format!("unknown metric {name:?}; the metrics are {}", Metric::names().join(", ")))
        })
    });
    let only = only.collect::<PyResult<Vec<_>>>()?;
    let pictures = [picture_of(actual)?, picture_of(expected)?];
    let pair = py.detach(|| align(&pictures[0], &pictures[1])).map_err(value_error)?;
    let comparison = py.detach(|| {
        let rules = Rules { limits: &[], only: &only, is_layer: false, threshold };
        Comparison::new(["actual", "expected"], &pair, rules)
    });
    as_python(py, &comparison.map_err(value_error)?)
}
