//! Overrides of the caller.

/// Settings of the caller that replace settings of the scene, as on the command line.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Samples per pixel, at least 1.
    pub samples_per_pixel: Option<u32>,
    /// Width and height of the full picture, each at least 1.
    pub resolution: Option<[u32; 2]>,
    /// The crop window: xmin, xmax, ymin, ymax, from 0 to 1.
    pub crop: Option<[f64; 4]>,
    /// A draft like pbrt-v3's `--quick`: a quarter of the resolution each way, one sample per pixel.
    pub quick: bool,
    /// Omit directives with errors and build a scene from the others.
    pub keep_going: bool,
    /// The most memory for reading the scene, in bytes. Default:
    /// [`MemoryBudget::machine_limit`](lookat_image::MemoryBudget::machine_limit).
    pub max_memory: Option<u64>,
    /// Accept a file that other scenes include: its missing parts are a warning instead of an error.
    pub accept_part: bool,
    /// Only check: open the files of meshes and pictures, but read no more than the headers of meshes. Gives no scene.
    /// Default: false.
    pub fast: bool,
}
