//! What the caller changes of a scene.

/// What the caller changes of a scene, as the command line does.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Samples per pixel, at least 1.
    pub samples_per_pixel: Option<u32>,
    /// Width and height of the full picture, each at least 1.
    pub resolution: Option<[u32; 2]>,
    /// The crop window: xmin, xmax, ymin, ymax from 0 to 1.
    pub crop: Option<[f64; 4]>,
    /// A draft, as pbrt-v3's: a quarter of the resolution each way and one sample per pixel.
    pub quick: bool,
    /// Leave out directives that are in error and make a scene of the others.
    pub keep_going: bool,
    /// Bytes that reading the scene may take, in all. Default: [`MemoryBudget::machine_limit`](lookat_image::MemoryBudget::machine_limit).
    pub max_memory: Option<u64>,
    /// Take a part of a scene, which other files include, for no error: only warn that it is one.
    pub accept_part: bool,
}
