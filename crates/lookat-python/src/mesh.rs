//! Triangle meshes as arrays.

use std::sync::Arc;

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
        positions: PyReadonlyArray2<'_, f64>,
        indices: PyReadonlyArray2<'_, i32>,
        normals: Option<PyReadonlyArray2<'_, f64>>,
        uvs: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Mesh> {
        let indices = rows::<i32, 3>(&indices, "indices")?.into_flattened();
        let mut mesh =
            lookat_scene::Mesh::new(rows(&positions, "positions")?, indices).map_err(value_error)?;
        if let Some(normals) = normals {
            mesh = mesh.with_normals(rows(&normals, "normals")?).map_err(value_error)?;
        }
        if let Some(uvs) = uvs {
            mesh = mesh.with_uvs(rows(&uvs, "uvs")?).map_err(value_error)?;
        }
        Ok(Mesh { mesh: Arc::new(mesh) })
    }

    /// The positions of the vertices, N x 3.
    #[getter]
    fn positions<'py>(own: Bound<'py, Self>) -> Bound<'py, PyAny> {
        view(&own, |mesh| mesh.positions())
    }

    /// The numbers of the vertices of each triangle, N x 3.
    #[getter]
    fn indices<'py>(own: Bound<'py, Self>) -> Bound<'py, PyAny> {
        view(&own, |mesh| mesh.indices().as_chunks::<3>().0)
    }

    /// The shading normals of the vertices, N x 3; without rows if there are none.
    #[getter]
    fn normals<'py>(own: Bound<'py, Self>) -> Bound<'py, PyAny> {
        view(&own, |mesh| mesh.normals())
    }

    /// The texture coordinates of the vertices, N x 2; without rows if there are none.
    #[getter]
    fn uvs<'py>(own: Bound<'py, Self>) -> Bound<'py, PyAny> {
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
) -> Bound<'py, PyAny> {
    let view = ArrayView2::from(array(&own.get().mesh));
    // SAFETY: the array holds the Python object of the mesh, which holds the memory, and nothing ever writes to either.
    let array = unsafe { PyArray::borrow_from_array(&view, own.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array.into_any()
}

/// The rows of an array, copied.
fn rows<T: numpy::Element + Copy, const N: usize>(
    array: &PyReadonlyArray2<'_, T>,
    name: &str,
) -> PyResult<Vec<[T; N]>> {
    let array = array.as_array();
    if array.ncols() != N {
        return Err(value_error(format!("{name} must have {N} columns, not {}", array.ncols())));
    }
    Ok(array.rows().into_iter().map(|row: ArrayView1<'_, T>| std::array::from_fn(|at| row[at])).collect())
}
