//! Float pictures: read, write and compare.
//!
//! An [`Image`] is a set of named channels over a data window, in linear values. The extension of the path
//! chooses the file [`Format`]: EXR keeps everything, PFM keeps the numbers, PNG and TGA are for looking at.
//!
//! The feature `compare`, on by default, adds error metrics, noise tests and a picture of the difference. It needs statistics and
//! fonts.
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

mod change;
mod color;
#[cfg(feature = "compare")]
mod compare;
mod error;
mod exr;
mod format;
mod image;
mod memory;
mod mip_map;
mod pfm;
mod picture_file;
mod pixel_error;
mod raster;
mod replace;
mod tone;

pub use change::{change_file, keep_aside};
pub use color::{LUMINANCE, linear_from_srgb, luminance};
#[cfg(feature = "compare")]
pub use compare::*;
pub use error::{ImageError, ImageFault, io_reason};
pub use format::Format;
pub use image::{ByteImage, Channel, Image, IntegerChannel, Pixels, Placement, Precision, Window};
pub use memory::{Charge, MemoryBudget, OutOfMemory, byte_words};
pub use mip_map::{Level, MipMap, Texel, Wrap, floor};
pub use picture_file::{PictureFile, open_file, read_integers};
pub use pixel_error::{PixelError, Shared};
pub use raster::rgb_png;
pub use replace::{TemporaryFile, TemporaryName, exit, has_text, remove_leftovers, write_file, write_target};
pub use tone::{ToneCurve, ToneMapping};
