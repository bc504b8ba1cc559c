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
    /// A mesh of vertices in world space, and of three vertex numbers for each triangle. With `copy=False`, arrays of float64 and int32 stay where
    /// they are, and are locked.
    #[new]
    #[pyo3(signature = (positions, indices, normals = None, uvs = None, *, copy = true))]
    fn new(
        positions: &Bound<'_, PyAny>,
        indices: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        copy: bool,
    ) -> PyResult<Mesh> {
        let mut arrays = Arrays { copy, locked: Vec::new() };
        let made = arrays.mesh(positions, indices, normals, uvs);
        if made.is_err() {
            arrays.unlock()?;
        }
        made
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
        // SAFETY: `Arrays::rows` has made sure that there are so many rows, without gaps and aligned, in a locked array, which this keeps
        // alive. NumPy has ways around its lock, of which the docstring of `copy` tells: whoever takes them breaks this.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

impl<T, const N: usize> AsRef<[T]> for Rows<T, N> {
    fn as_ref(&self) -> &[T] {
        let rows: &[[T; N]] = self.as_ref();
        rows.as_flattened()
    }
}

/// The arrays that a mesh is made of.
struct Arrays<'py> {
    /// True if the mesh has memory of its own.
    copy: bool,
    /// The arrays that could be written before.
    locked: Vec<Bound<'py, PyAny>>,
}

impl<'py> Arrays<'py> {
    fn mesh(
        &mut self,
        positions: &Bound<'py, PyAny>,
        indices: &Bound<'py, PyAny>,
        normals: Option<&Bound<'py, PyAny>>,
        uvs: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Mesh> {
        // All are locked before any is checked: finding an array may run code that changes another.
        let positions = MeshArray::shared(self.rows::<f64, 3>(positions, "positions")?);
        let indices = self.numbers(indices)?;
        let normals = normals.map(|normals| self.rows::<f64, 3>(normals, "normals")).transpose()?;
        let uvs = uvs.map(|uvs| self.rows::<f64, 2>(uvs, "uvs")).transpose()?;
        let mut mesh = lookat_scene::Mesh::new(positions, indices).map_err(value_error)?;
        if let Some(normals) = normals {
            mesh = mesh.with_normals(MeshArray::shared(normals)).map_err(value_error)?;
        }
        if let Some(uvs) = uvs {
            mesh = mesh.with_uvs(MeshArray::shared(uvs)).map_err(value_error)?;
        }
        Ok(Mesh { mesh: Arc::new(mesh) })
    }

    /// Gives the arrays back, because no mesh has come of them.
    fn unlock(self) -> PyResult<()> {
        self.locked.iter().try_for_each(|array| array.call_method1("setflags", (true,)).map(drop))
    }

    /// The rows of an array, copied if it is to be, or cannot be locked: if it has another type or gaps, or is a view of memory that others
    /// may write to.
    fn rows<T: Element, const N: usize>(
        &mut self,
        array: &Bound<'py, PyAny>,
        name: &str,
    ) -> PyResult<Arc<Rows<T, N>>> {
        let given = array.py().import("numpy")?.call_method1("asarray", (array,))?;
        let mut array = converted::<T, N>(&given, name, "iuf")?;
        if self.copy && array.is(&given) || !is_alone(&array)? {
            array = array.call_method0("copy")?.cast_into::<PyArray2<T>>().map_err(value_error)?;
        }
        if array.getattr("flags")?.getattr("writeable")?.extract()? {
            array.call_method1("setflags", (false,))?;
            self.locked.push(array.clone().into_any());
        }
        let (first, count) = (array.data().cast::<[T; N]>().cast_const(), array.shape()[0]);
        Ok(Arc::new(Rows { first, count, _array: array.unbind() }))
    }

    /// The vertex numbers of triangles, one after the other.
    fn numbers(&mut self, array: &Bound<'py, PyAny>) -> PyResult<MeshArray<i32>> {
        let array = array.py().import("numpy")?.call_method1("asarray", (array,))?;
        if array.getattr("dtype")?.eq(i32::get_dtype(array.py()))? {
            return Ok(MeshArray::shared(self.rows::<i32, 3>(&array, "indices")?));
        }
        // Others are checked before they become shorter.
        let numbers = converted::<i64, 3>(&array, "indices", "iu")?;
        let numbers = numbers.try_readonly().map_err(value_error)?;
        let numbers =
            numbers.as_array().iter().map(|number| i32::try_from(*number)).collect::<Result<_, _>>();
        numbers.map_err(|_| value_error(MeshError::IndexOutOfRange))
    }
}

/// True if an array has memory of its own, or is a view of what nobody can write: of a mesh.
fn is_alone(array: &Bound<'_, PyAny>) -> PyResult<bool> {
    let base = array.getattr("base")?;
    Ok(base.is_none() || base.is_instance_of::<Mesh>())
}

/// An array with rows of N numbers of a type. `kinds`: the kinds of numbers that it may have before, by the letters of NumPy's `dtype.kind`.
fn converted<'py, T: Element, const N: usize>(
    array: &Bound<'py, PyAny>,
    name: &str,
    kinds: &str,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !kinds.contains(&kind) {
        return Err(value_error(format!("{name} must be an array of numbers, not of {dtype}")));
    }
    let numpy = array.py().import("numpy")?;
    // Without gaps, and aligned.
    let array = numpy.call_method1("require", (array, T::get_dtype(numpy.py()), ["C", "A"]))?;
    let array = array
        .cast_into::<PyArray2<T>>()
        .map_err(|_| value_error(format!("{name} must be an array of rows with {N} numbers")))?;
    match array.shape()[1] {
        columns if columns == N => Ok(array),
        columns => Err(value_error(format!("{name} must have {N} columns, not {columns}"))),
    }
}
