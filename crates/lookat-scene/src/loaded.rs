//! The result of loading a scene.

use std::collections::BTreeSet;
use std::path::PathBuf;

use lookat_image::MemoryBudget;
use lookat_syntax::Diagnostic;

use crate::{CameraPlacement, Places, Scene, Sources, Symbol};

/// The result of [`load`](crate::load()).
#[derive(Debug)]
pub struct Loaded {
    /// The texts that diagnostics refer to.
    pub sources: Sources,
    /// All files read: scene text, pictures, meshes and spectra.
    pub inputs: BTreeSet<PathBuf>,
    /// The scene. `None` if there is a `misfit`, if there are errors without `keep_going`, if the text does not fit the memory limit, with
    /// `fast`, or if no scene could be built at all.
    pub scene: Option<Scene>,
    /// Where the text says how the scene is seen and lit.
    pub places: Places,
    /// The file that the scene names for its picture (`filename` of `Film`), relative to the working folder. Default:
    /// `pbrt.exr`.
    pub output: PathBuf,
    /// The problems, in reading order.
    pub diagnostics: Vec<Diagnostic>,
    /// Materials, textures, objects, media, coordinate systems and included files, in the order of their definition or,
    /// if undefined, of their first use.
    pub symbols: Vec<Symbol>,
    /// The memory budget that is left after reading.
    pub memory: MemoryBudget,
    /// With [`fast`](crate::LoadOptions::fast), the number of uses of mesh and picture files whose contents were not read;
    /// otherwise 0.
    pub unread: usize,
    /// True if `keep_going` would give a scene.
    pub can_keep_going: bool,
    /// The `LookAt` that places the camera. `None` for a camera that is placed otherwise.
    pub placement: Option<CameraPlacement>,
    /// True if the world uses the coordinate system of the camera.
    pub world_follows_camera: bool,
    /// The reason why the [`FilmOverride`](crate::FilmOverride) or the [`ViewOverride`](crate::ViewOverride) does not fit
    /// the scene.
    pub misfit: Option<String>,
}
