//! Float pictures: read, write and compare.
//!
//! An [`Image`] is a set of named channels over a data window, in linear values. The extension of the path
//! chooses the file [`Format`]: EXR keeps everything, PFM keeps the numbers, PNG and TGA are for looking at.
//!
//! Two features, on by default: `write` writes pictures, and `compare`, which includes it, has error metrics, noise tests and a
//! picture of the difference. Without them the crate reads pictures, with neither statistics nor fonts.
//!
//! ```
//! use lookat_image::{Image, Window};
//!
//! let window = Window { x: 0, y: 0, width: 2, height: 1 };
//! let image = Image::from_rgb(window, window, &[[0.0, 0.5, 1.0], [2.0, 4.0, 8.0]]);
//!
//! let directory = tempfile::tempdir()?;
//! let path = directory.path().join("picture.exr");
//! image.write(&path)?;
//! assert_eq!(Image::read(&path)?.channel("B"), Some([1.0, 8.0].as_slice()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "compare")]
mod agreement;
#[cfg(feature = "compare")]
mod align;
#[cfg(feature = "compare")]
mod convolution;
mod decoded;
#[cfg(feature = "compare")]
mod display;
#[cfg(feature = "write")]
mod eightbit;
mod error;
mod errors;
mod exr;
#[cfg(feature = "write")]
mod file;
#[cfg(feature = "compare")]
mod flip;
mod floor;
mod format;
mod image;
mod input;
#[cfg(feature = "compare")]
mod light;
mod memory;
#[cfg(feature = "compare")]
mod metric;
mod mip_map;
#[cfg(feature = "compare")]
mod panel;
mod pfm;
mod picture_file;
#[cfg(feature = "compare")]
mod rank;
#[cfg(all(test, feature = "compare"))]
mod sample;
#[cfg(feature = "compare")]
mod ssim;
#[cfg(feature = "compare")]
mod sum;
#[cfg(feature = "write")]
mod tone;
#[cfg(feature = "write")]
mod write;

#[cfg(feature = "compare")]
pub use agreement::{Agreement, PixelTest, Test, Untestable, agreement};
#[cfg(feature = "compare")]
pub use align::{AlignError, Aligned, align, common_window};
pub use decoded::linear_from_srgb;
#[cfg(feature = "compare")]
pub use display::Encoded;
pub use error::{ImageError, io_reason};
pub use errors::{PixelError, Shared};
#[cfg(feature = "write")]
pub use file::{TemporaryFile, TemporaryName, change_file, exit, keep_aside, write_file, write_target};
#[cfg(feature = "compare")]
pub use flip::{Exposures, PIXELS_PER_DEGREE, hdr_flip, hdr_flip_map, ldr_flip, ldr_flip_map};
pub use floor::floor;
pub use format::Format;
pub use image::{Channel, Image, Placement, Precision, Window};
pub use input::{has_text, open_file};
#[cfg(feature = "compare")]
pub use light::Light;
pub use memory::{Charge, MemoryBudget, OutOfMemory, byte_words};
#[cfg(feature = "compare")]
pub use metric::{
    Largest, Means, largest_difference, mean, means, percentile_difference, psnr, relative_mse_trimmed, rmse,
    share_above,
};
pub use mip_map::{MipMap, Texel, Wrap};
#[cfg(feature = "compare")]
pub use panel::{
    DIFFERENCE_COLORS, NOT_FINITE_COLOR, PanelOptions, box_means, difference_color, difference_limit,
    suitable_exposure, write_panel,
};
pub use picture_file::PictureFile;
#[cfg(feature = "compare")]
pub use ssim::ssim;
#[cfg(feature = "write")]
pub use tone::{ToneCurve, ToneMapping, luminance};
