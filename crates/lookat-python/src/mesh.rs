//! Triangle meshes as arrays.

use std::sync::Arc;

use lookat_scene::{MeshArray, MeshError};
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::value_error;

/// A triangle mesh. Its arrays are views of its memory, which cannot be written.
#[pyclass(module = "lookat", frozen)]
pub struct Mesh {
    pub mesh: Arc<lookat_scene::Mesh>,
}

#[pymethods]
impl Mesh {
    /// A mesh of vertices in world space, and of three vertex numbers for each triangle. Arrays of float64 and int32 that own their memory are
    /// not copied, and cannot be written any more.
    #[new]
    #[pyo3(signature = (positions, indices, normals = None, uvs = None))]
    fn new(
        positions: &Bound<'_, PyAny>,
        indices: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Mesh> {
        let mut kept = Vec::new();
        let positions = MeshArray::shared(rows::<f64, 3>(positions, "positions", &mut kept)?);
        let mut mesh =
            lookat_scene::Mesh::new(positions, numbers(indices, &mut kept)?).map_err(value_error)?;
        if let Some(normals) = normals {
            let normals = MeshArray::shared(rows::<f64, 3>(normals, "normals", &mut kept)?);
            mesh = mesh.with_normals(normals).map_err(value_error)?;
        }
        if let Some(uvs) = uvs {
            let uvs = MeshArray::shared(rows::<f64, 2>(uvs, "uvs", &mut kept)?);
            mesh = mesh.with_uvs(uvs).map_err(value_error)?;
        }
        // Only now that nothing can fail.
        kept.iter().try_for_each(|array| array.call_method1("setflags", (false,)).map(drop))?;
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
fn view<'py, T: Element + Copy, const N: usize>(
    own: &Bound<'py, Mesh>,
    array: impl Fn(&lookat_scene::Mesh) -> &[[T; N]],
) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView2::from(array(&own.get().mesh));
    // SAFETY: the array holds the Python object of the mesh, which holds the memory, and nothing ever writes to either.
    let array = unsafe { PyArray::borrow_from_array(&view, own.clone().into_any()) };
    array.try_readwrite().map_err(value_error)?.make_nonwriteable();
    Ok(array.into_any())
}

/// The rows of an array of NumPy, as memory of a mesh.
struct Rows<T, const N: usize> {
    first: *const [T; N],
    count: usize,
    /// Keeps the memory.
    _array: Py<PyArray2<T>>,
}

// SAFETY: the memory is only read, from any thread; Python objects may be dropped on any thread.
unsafe impl<T: Send, const N: usize> Send for Rows<T, N> {}
// SAFETY: as above.
unsafe impl<T: Sync, const N: usize> Sync for Rows<T, N> {}

impl<T, const N: usize> AsRef<[[T; N]]> for Rows<T, N> {
    fn as_ref(&self) -> &[[T; N]] {
        if self.count == 0 {
            return &[];
        }
        // SAFETY: `rows` has made sure that there are so many rows, without gaps and aligned. The array keeps them, and NumPy does not
        // write to it any more.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

impl<T, const N: usize> AsRef<[T]> for Rows<T, N> {
    fn as_ref(&self) -> &[T] {
        let rows: &[[T; N]] = self.as_ref();
        rows.as_flattened()
    }
}

/// The rows of an array, without a copy if they have the right type and nobody else can write to them. `kept` gets the array that has them.
fn rows<'py, T: Element, const N: usize>(
    array: &Bound<'py, PyAny>,
    name: &str,
    kept: &mut Vec<Bound<'py, PyAny>>,
) -> PyResult<Arc<Rows<T, N>>> {
    let array = converted::<T, N>(array, name, "iuf")?;
    kept.push(array.clone().into_any());
    let (first, count) = (array.data().cast::<[T; N]>().cast_const(), array.shape()[0]);
    Ok(Arc::new(Rows { first, count, _array: array.unbind() }))
}

/// An array with rows of N numbers of a type. `kinds`: the kinds of numbers that it may have before, by the letters of NumPy's `dtype.kind`.
fn converted<'py, T: Element, const N: usize>(
    array: &Bound<'py, PyAny>,
    name: &str,
    kinds: &str,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (array,))?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !kinds.contains(&kind) {
        return Err(value_error(format!("{name} must be an array of numbers, not of {dtype}")));
    }
    // "C": without gaps, "A": aligned. A view that can be written is copied: its memory belongs to another array.
    let is_writable: bool = array.getattr("flags")?.getattr("writeable")?.extract()?;
    let needs = if is_writable { vec!["C", "A", "O"] } else { vec!["C", "A"] };
    let array = numpy.call_method1("require", (array, T::get_dtype(numpy.py()), needs))?;
    let array = array
        .cast_into::<PyArray2<T>>()
        .map_err(|_| value_error(format!("{name} must be an array of rows with {N} numbers")))?;
    match array.shape()[1] {
        columns if columns == N => Ok(array),
        columns => Err(value_error(format!("{name} must have {N} columns, not {columns}"))),
    }
}

/// The vertex numbers of triangles, one after the other.
fn numbers<'py>(array: &Bound<'py, PyAny>, kept: &mut Vec<Bound<'py, PyAny>>) -> PyResult<MeshArray<i32>> {
    let array = array.py().import("numpy")?.call_method1("asarray", (array,))?;
    if array.getattr("dtype")?.eq(i32::get_dtype(array.py()))? {
        return Ok(MeshArray::shared(rows::<i32, 3>(&array, "indices", kept)?));
    }
    // Others are checked before they become shorter.
    let numbers = converted::<i64, 3>(&array, "indices", "iu")?;
    let numbers = numbers.try_readonly().map_err(value_error)?;
    let numbers = numbers.as_array().iter().map(|number| i32::try_from(*number)).collect::<Result<_, _>>();
    numbers.map_err(|_| value_error(MeshError::IndexOutOfRange))
}
