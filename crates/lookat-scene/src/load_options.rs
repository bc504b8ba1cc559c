//! How the caller wants a scene to be loaded.

use crate::film::FilmOverride;
use crate::view_override::ViewOverride;

/// How [`load`](crate::load()) reads a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadOptions {
    /// What to use instead of the size and the crop window that the scene gives. Default: what the scene gives.
    pub film: FilmOverride,
    /// What to use instead of the camera that the scene gives. Default: what the scene gives.
    pub view: ViewOverride,
    /// Omit directives with errors and build a scene from the others. Default: false.
    pub keep_going: bool,
    /// The most memory for reading the scene, in bytes. Default:
    /// [`MemoryBudget::machine_limit`](lookat_image::MemoryBudget::machine_limit).
    pub max_memory: Option<u64>,
    /// Accept a file that other scenes include: its missing parts are a warning instead of an error. Default: false.
    pub accept_part: bool,
    /// Only check: open the files of meshes and pictures, but read no more than the headers of meshes. Gives no scene.
    /// Default: false.
    pub fast: bool,
}
