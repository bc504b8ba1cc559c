//! Float pictures: read and write.
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

mod eightbit;
mod error;
mod exr;
mod format;
mod image;
mod pfm;

pub use error::ImageError;
pub use format::Format;
pub use image::{Channel, Image, Window};
