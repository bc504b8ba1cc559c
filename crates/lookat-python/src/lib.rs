//! The Python module of lookat. `packaging/python/lookat/__init__.pyi` describes it for Python's users.

// Macros of PyO3 give each argument of a Python function its own argument in Rust.
#![allow(clippy::too_many_arguments, reason = "keyword arguments of Python functions")]

mod camera;
mod charting;
mod comparison;
mod film;
mod mesh;
mod picture;
mod rendering;
mod scene;
mod view;

use lookat_image::{Charge, MemoryBudget};
use pyo3::prelude::*;

/// Reads, renders and compares pbrt-v3 scenes.
#[pymodule]
mod _lookat {
    use super::*;

    #[pymodule_export]
    use camera::Camera;
    #[pymodule_export]
    use charting::{Chart, chart};
    #[pymodule_export]
    use comparison::compare;
    #[pymodule_export]
    use film::Film;
    #[pymodule_export]
    use mesh::Mesh;
    #[pymodule_export]
    use picture::Picture;
    #[pymodule_export]
    use rendering::render;
    #[pymodule_export]
    use scene::{Scene, SceneError, check, load};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

/// A value of JSON as a Python object.
fn as_python<'py>(py: Python<'py>, value: &impl serde::Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value)
        .map_err(|error| pyo3::exceptions::PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Starts the threads of the process, once. Fails in a process that was forked afterwards, which has no threads.
fn start_threads() -> PyResult<()> {
    static PROCESS: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    let process = *PROCESS.get_or_init(|| {
        lookat_render::start_threads(std::thread::available_parallelism().map_or(1, usize::from));
        std::process::id()
    });
    if process != std::process::id() {
        return Err(pyo3::exceptions::PyRuntimeError::new_err(
            "lookat was used before this process was forked, and its threads are gone: start processes with \"spawn\"",
        ));
    }
    Ok(())
}

/// Takes memory, or raises `MemoryError`.
fn reserve(memory: &MemoryBudget, bytes: u64) -> PyResult<Charge> {
    memory.reserve(bytes).map_err(|shortage| pyo3::exceptions::PyMemoryError::new_err(shortage.to_string()))
}

/// A `ValueError` with a message.
fn value_error(message: impl std::fmt::Display) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(message.to_string())
}

/// Runs without the lock of the interpreter, on a thread of its own, and listens to Ctrl-C meanwhile. `tick` is called in between, and
/// `stop` once if it fails or Ctrl-C is pressed: then the work should end soon.
fn run_detached<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send,
    stop: &std::sync::atomic::AtomicBool,
    tick: impl Fn(Python<'_>) -> PyResult<()> + Sync,
) -> PyResult<T> {
    use std::sync::{atomic::Ordering, mpsc};
    use std::time::Duration;

    /// How long Ctrl-C waits at most.
    const STEP: Duration = Duration::from_millis(50);
    py.detach(|| {
        std::thread::scope(|scope| {
            let (tell, told) = mpsc::channel::<()>();
            let worker = scope.spawn(move || {
                // Closed at the end, also by a panic.
                let _tell = tell;
                work()
            });
            let mut failed = Ok(());
            while let Err(mpsc::RecvTimeoutError::Timeout) = told.recv_timeout(STEP) {
                if failed.is_ok() {
                    failed = Python::attach(|py| py.check_signals().and_then(|()| tick(py)));
                    stop.store(failed.is_err(), Ordering::Relaxed);
                }
            }
            let result = worker.join().map_err(|_| {
                pyo3::exceptions::PyRuntimeError::new_err("lookat has failed: please report it")
            })?;
            failed.map(|()| result)
        })
    })
}
