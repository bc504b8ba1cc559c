//! Float pictures: read, write and compare.
//!
//! An [`Image`] is a set of named channels over a data window, in linear values. The extension of the path
//! chooses the file [`Format`]: EXR keeps everything, PFM keeps the numbers, PNG and TGA are for looking at.
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

mod agreement;
mod align;
mod convolution;
mod decoded;
mod display;
mod eightbit;
mod error;
mod errors;
mod exr;
mod file;
mod flip;
mod floor;
mod format;
mod image;
mod memory;
mod metric;
mod mip_map;
mod panel;
mod pfm;
mod picture_file;
mod rank;
#[cfg(test)]
mod sample;
mod ssim;
mod sum;
mod write;

pub use agreement::{Agreement, PixelTest, Test, Untestable, agreement};
pub use align::{AlignError, Aligned, align, common_window};
pub use decoded::linear_from_srgb;
pub use display::Encoded;
pub use error::{ImageError, io_reason};
pub use errors::PixelError;
pub use file::{exit, open_file, write_file, write_target};
pub use flip::{Exposures, PIXELS_PER_DEGREE, hdr_flip, hdr_flip_map, ldr_flip, ldr_flip_map};
pub use floor::floor;
pub use format::Format;
pub use image::{Channel, Image, Placement, Precision, Window};
pub use memory::{Charge, MemoryBudget, OutOfMemory, byte_words};
pub use metric::{
    Largest, Means, largest_difference, mean, means, percentile_difference, psnr, relative_mse_trimmed, rmse,
    share_above,
};
pub use mip_map::{MipMap, Texel, Wrap};
pub use panel::{
    DIFFERENCE_COLORS, NOT_FINITE_COLOR, PanelOptions, box_means, difference_color, difference_limit,
    suitable_exposure, write_panel,
};
pub use picture_file::PictureFile;
pub use ssim::ssim;
