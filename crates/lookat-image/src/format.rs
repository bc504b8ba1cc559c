//! The file formats of pictures, and a picture of which the header has been read.

use std::io::{BufRead, Seek};
use std::path::Path;

use crate::image::{Pixels, Placement};
use crate::{Charge, ImageFault, MemoryBudget};

/// A file format for pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: any channels in float, both windows and the metadata.
    Exr,
    /// Portable Network Graphics, 8-bit sRGB.
    Png,
    /// Portable FloatMap: color or gray in 32-bit float.
    Pfm,
    /// Truevision Targa, 8-bit sRGB.
    Tga,
}

impl Format {
    /// The formats that are written, as a message lists them.
    pub const NAMES: &'static str = "exr, png, pfm and tga";

    /// The format that the extension of `path` stands for; upper and lower case are the same.
    pub fn from_path(path: &Path) -> Option<Format> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "exr" => Some(Format::Exr),
            "png" => Some(Format::Png),
            "pfm" => Some(Format::Pfm),
            "tga" => Some(Format::Tga),
            _ => None,
        }
    }

    /// True for 8-bit sRGB; the other formats keep linear values.
    pub fn is_eight_bit(self) -> bool {
        matches!(self, Format::Png | Format::Tga)
    }

    /// The largest width and height, in pixels.
    pub fn most_side(self) -> u32 {
        match self {
            Format::Tga => u16::MAX.into(),
            // Numbers with a sign, of 32 bits.
            Format::Exr | Format::Png | Format::Pfm => i32::MAX as u32,
        }
    }
}

/// A source of a picture.
pub(crate) trait Input: BufRead + Seek {}

impl<T: BufRead + Seek> Input for T {}

/// Reads the pixels; the charge is for all memory that this takes. True if pixels of 8 bits may stay so.
type ReadPixels<'a> = dyn FnOnce(&MemoryBudget, bool) -> Result<(Pixels, Charge), ImageFault> + 'a;

/// A picture of which the header has been read.
pub(crate) struct Opened<'a> {
    pub placement: Placement,
    /// See [`Image::metadata`](crate::Image::metadata). `read` does not set it.
    pub metadata: Option<String>,
    /// See [`PictureFile::channels_of_bytes`](crate::PictureFile::channels_of_bytes).
    pub channels_of_bytes: Option<usize>,
    pub read: Box<ReadPixels<'a>>,
}

/// The one custom attribute, and the keyword of the text in a PNG file: the crate writes several attributes in random
/// order, so no two files would be alike.
pub(crate) const METADATA: &str = "lookat";
