//! Scenes, and what is wrong with them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lookat_image::MemoryBudget;
use lookat_render::{Prepared, preparation_bytes};
use lookat_scene::syntax::{Diagnostic, Severity};
use lookat_scene::{LoadOptions, Loaded, Place, Shape, Sources, World, as_json, load_opened};
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::camera::Camera;
use crate::film::Film;
use crate::mesh::Mesh;
use crate::view::{PlacedView, SharedView};
use crate::{as_python, reserve, start_threads, value_error};

create_exception!(lookat, SceneError, PyValueError, "A scene has errors. `diagnostics` lists them.");

/// A scene. `camera`, `film` and the number of samples can be changed.
#[pyclass(module = "lookat")]
pub struct Scene {
    view: SharedView,
    world: Arc<World>,
    /// The world as the renderer needs it. `None` before the first picture, and after a change.
    pub prepared: Option<Arc<Prepared>>,
    pub sources: Arc<Sources>,
    /// The memory that is left after reading.
    pub memory: MemoryBudget,
    diagnostics: Vec<Diagnostic>,
    output: PathBuf,
}

#[pymethods]
impl Scene {
    #[getter]
    fn camera(&self) -> Camera {
        Camera { view: self.view.clone() }
    }

    #[getter]
    fn film(&self) -> Film {
        Film { view: self.view.clone() }
    }

    #[getter]
    fn spp(&self) -> u32 {
        self.view.lock().view.sampler.samples_per_pixel
    }

    #[setter]
    fn set_spp(&self, samples: u32) -> PyResult<()> {
        if !(1..=lookat_scene::MAX_SAMPLES).contains(&samples) {
            return Err(value_error(format!("spp must be from 1 to {}", lookat_scene::MAX_SAMPLES)));
        }
        let sampler = &mut self.view.lock().view.sampler;
        *sampler = sampler.with_samples(samples);
        Ok(())
    }

    /// The file that the scene names for its picture.
    #[getter]
    fn output(&self) -> &Path {
        &self.output
    }

    #[getter]
    fn diagnostics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        as_python(py, &as_json(&self.diagnostics, &self.sources))
    }

    /// The triangle meshes of the world, without those of objects. Their arrays are views of the scene's memory.
    #[getter]
    fn meshes(&self) -> Vec<Mesh> {
        self.meshes_in_world().map(|(_, mesh)| Mesh { mesh: mesh.clone() }).collect()
    }

    /// Replaces a mesh, by its number in `meshes`. It keeps material, light and medium.
    fn set_mesh(&mut self, index: usize, mesh: &Mesh) -> PyResult<()> {
        let found = self.meshes_in_world().nth(index).map(|(at, _)| at);
        let at = found.ok_or_else(|| {
            pyo3::exceptions::PyIndexError::new_err(format!("the scene has no mesh {index}"))
        })?;
        Arc::make_mut(&mut self.world).primitives[at].shape = Shape::TriangleMesh(mesh.mesh.clone());
        self.prepared = None;
        Ok(())
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.view.lock().view.film.resolution;
        let name = self.sources.files.first().map(|file| file.path.display().to_string());
        format!("<lookat.Scene {} {width}x{height}, {} spp>", name.unwrap_or_default(), self.spp())
    }
}

impl Scene {
    /// The scene as it is now.
    pub fn scene(&self) -> lookat_scene::Scene {
        lookat_scene::Scene { view: self.view.lock().view.clone(), world: self.world.clone() }
    }

    fn meshes_in_world(&self) -> impl Iterator<Item = (usize, &Arc<lookat_scene::Mesh>)> {
        self.world.primitives.iter().enumerate().filter_map(|(at, primitive)| match &primitive.shape {
            Shape::TriangleMesh(mesh) => Some((at, mesh)),
            _ => None,
        })
    }

    /// The world as the renderer needs it, if it is prepared near the eye.
    pub fn prepared(&self) -> Option<Arc<Prepared>> {
        self.prepared.clone().filter(|prepared| prepared.is_near(&self.view.lock().view.camera))
    }

    /// Keeps a world that has been prepared, unless the scene has another one by now.
    pub fn keep(&mut self, prepared: Arc<Prepared>) {
        if Arc::ptr_eq(prepared.world(), &self.world) {
            self.prepared = Some(prepared);
        }
    }
}

/// Reads a scene from a file, or from a text: names of files have no line breaks and no quotes.
fn read(path_or_text: &Bound<'_, PyAny>) -> PyResult<Loaded> {
    start_threads()?;
    let text: Option<String> = path_or_text.extract().ok().filter(|text: &String| text.contains(['\n', '"']));
    let path: PathBuf = if text.is_some() { "text".into() } else { path_or_text.extract()? };
    let loaded = path_or_text.py().detach(|| {
        let open = |file: &Path| match &text {
            Some(text) if file == path => {
                Ok(Box::new(std::io::Cursor::new(text.clone().into_bytes())) as Box<dyn std::io::Read>)
            }
            _ => Ok(Box::new(lookat_image::open_file(file)?) as Box<dyn std::io::Read>),
        };
        load_opened(&path, &open, &LoadOptions::default())
    });
    Ok(loaded)
}

/// Reads a scene: a path, or a text of several lines. Raises `SceneError` if it has errors.
#[pyfunction]
pub fn load(path_or_text: &Bound<'_, PyAny>) -> PyResult<Scene> {
    let py = path_or_text.py();
    let Loaded { scene, sources, diagnostics, placement, output, memory, world_follows_camera, .. } =
        read(path_or_text)?;
    match scene {
        Some(lookat_scene::Scene { view, world }) => Ok(Scene {
            view: SharedView::new(PlacedView { view, placement, world_follows_camera }),
            world,
            prepared: None,
            sources: Arc::new(sources),
            memory,
            diagnostics,
            output,
        }),
        None => {
            let error = PyErr::new::<SceneError, _>(message(&diagnostics, &sources));
            error.value(py).setattr("diagnostics", as_python(py, &as_json(&diagnostics, &sources))?)?;
            Err(error)
        }
    }
}

/// The problems of a scene, as `lookat check --json` lists them: a path, or a text of several lines. `view` also looks at what the picture
/// shows.
#[pyfunction]
#[pyo3(signature = (path_or_text, *, view = false))]
pub fn check<'py>(path_or_text: &Bound<'py, PyAny>, view: bool) -> PyResult<Bound<'py, PyAny>> {
    let py = path_or_text.py();
    let mut loaded = read(path_or_text)?;
    if let (Some(scene), true) = (&loaded.scene, view) {
        let _charge = reserve(&loaded.memory, preparation_bytes(&scene.world))?;
        let advice = py.detach(|| lookat_sight::advise(&loaded, scene, &mut Prepared::new(scene)));
        loaded.diagnostics.extend(advice);
    }
    as_python(py, &as_json(&loaded.diagnostics, &loaded.sources))
}

/// The errors in words, one in a line.
fn message(diagnostics: &[Diagnostic], sources: &Sources) -> String {
    let errors = diagnostics.iter().filter(|it| it.severity == Severity::Error);
    let line = |error: &Diagnostic| {
        let place = error.labels.first().map(|label| {
            let Place { file, line, column } = Place::new(label.span, sources);
            format!("{file}:{line}:{column}: ")
        });
        let help = error.help.as_deref().map(|help| format!("; help: {help}"));
        format!("{}{}{}", place.unwrap_or_default(), error.message, help.unwrap_or_default())
    };
    errors.map(line).collect::<Vec<_>>().join("\n")
}
