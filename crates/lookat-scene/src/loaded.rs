//! What reading a scene gives.

use std::collections::BTreeSet;
use std::path::PathBuf;

use lookat_image::MemoryBudget;
use lookat_syntax::Diagnostic;

use crate::{Scene, Sources};

/// What [`load`](crate::load()) found.
#[derive(Debug)]
pub struct Loaded {
    /// The files that were read; diagnostics point into them.
    pub sources: Sources,
    /// All files that were read: these, and the pictures, meshes and spectra that they name.
    pub inputs: BTreeSet<PathBuf>,
    /// The scene. There is one exactly when no diagnostic is an error, or when errors are to be left out, and there is no
    /// `misfit`.
    pub scene: Option<Scene>,
    /// What is wrong, in the order in which the scene is read.
    pub diagnostics: Vec<Diagnostic>,
    /// What reading has left of the memory that there is.
    pub memory: MemoryBudget,
    /// Whether there is a scene if errors are left out.
    pub can_keep_going: bool,
    /// Why the resolution or the crop window of the caller's [`Overrides`](crate::Overrides) does not fit the scene.
    pub misfit: Option<String>,
}
