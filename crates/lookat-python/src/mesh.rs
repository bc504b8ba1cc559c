//! Triangle meshes as arrays.

use std::sync::Arc;

use lookat_scene::MeshError;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::value_error;

/// A triangle mesh. Its arrays are views of its memory, which cannot be written.
#[pyclass(module = "lookat", frozen)]
pub struct Mesh {
    pub mesh: Arc<lookat_scene::Mesh>,
}

#[pymethods]
impl Mesh {
    /// A mesh of vertices in world space, and of three vertex numbers for each triangle.
    #[new]
    #[pyo3(signature = (positions, indices, normals = None, uvs = None))]
    fn new(
        positions: &Bound<'_, PyAny>,
        indices: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Mesh> {
        let indices: Vec<[i64; 3]> = rows(indices, "indices", "iu")?;
        let indices = indices.into_flattened().into_iter().map(i32::try_from).collect::<Result<_, _>>();
        let indices = indices.map_err(|_| value_error(MeshError::IndexOutOfRange))?;
        let mut mesh =
            lookat_scene::Mesh::new(rows(positions, "positions", "iuf")?, indices).map_err(value_error)?;
        if let Some(normals) = normals {
            mesh = mesh.with_normals(rows(normals, "normals", "iuf")?).map_err(value_error)?;
        }
        if let Some(uvs) = uvs {
            mesh = mesh.with_uvs(rows(uvs, "uvs", "iuf")?).map_err(value_error)?;
        }
        Ok(Mesh { mesh: Arc::new(mesh) })
    }

    /// The positions of the vertices, N x 3.
    #[getter]
    fn positions<'py>(own: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(&own, |mesh| mesh.positions())
    }

    /// The numbers of the vertices of each triangle, N x 3.
    #[getter]
    fn indices<'py>(own: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(&own, |mesh| mesh.indices().as_chunks::<3>().0)
    }

    /// The shading normals of the vertices, N x 3; without rows if there are none.
    #[getter]
    fn normals<'py>(own: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(&own, |mesh| mesh.normals())
    }

    /// The texture coordinates of the vertices, N x 2; without rows if there are none.
    #[getter]
    fn uvs<'py>(own: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(&own, |mesh| mesh.uvs())
    }

    fn __repr__(&self) -> String {
        let (triangles, vertices) = (self.mesh.indices().len() / 3, self.mesh.positions().len());
        format!("<lookat.Mesh {triangles} triangles, {vertices} vertices>")
    }
}

/// A view of the rows of an array of a mesh, which keeps the mesh alive.
fn view<'py, T: numpy::Element + Copy, const N: usize>(
    own: &Bound<'py, Mesh>,
    array: impl Fn(&lookat_scene::Mesh) -> &[[T; N]],
) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView2::from(array(&own.get().mesh));
    // SAFETY: the array holds the Python object of the mesh, which holds the memory, and nothing ever writes to either.
    let array = unsafe { PyArray::borrow_from_array(&view, own.clone().into_any()) };
    array.try_readwrite().map_err(value_error)?.make_nonwriteable();
    Ok(array.into_any())
}

/// The rows of an array, copied. `kinds`: the kinds of numbers that it may have, by the letters of NumPy's `dtype.kind`.
fn rows<T: numpy::Element + Copy, const N: usize>(
    array: &Bound<'_, PyAny>,
    name: &str,
    kinds: &str,
) -> PyResult<Vec<[T; N]>> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (array,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !kinds.contains(&kind) {
        return Err(value_error(format!(
            "{name} must be an array of numbers, not of {}",
            array.getattr("dtype")?
        )));
    }
    let array = array.call_method1("astype", (T::get_dtype(array.py()),))?;
    let array: PyReadonlyArray2<'_, T> = array
        .extract()
        .map_err(|_| value_error(format!("{name} must be an array of rows with {N} numbers")))?;
    let array = array.as_array();
    if array.ncols() != N {
        return Err(value_error(format!("{name} must have {N} columns, not {}", array.ncols())));
    }
    Ok(array.rows().into_iter().map(|row: ArrayView1<'_, T>| std::array::from_fn(|at| row[at])).collect())
}
