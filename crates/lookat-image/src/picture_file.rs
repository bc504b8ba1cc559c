//! Picture files in two steps: first the header, then the pixels.

use std::io::{BufRead, BufReader, Cursor};
use std::path::{Path, PathBuf};

use crate::decoded::{self, Curve, Input};
use crate::error::{Fault, ImageError};
use crate::format::{check_beginning, is_read};
use crate::image::Placement;
use crate::input::open_file;
use crate::{Charge, Format, Image, MemoryBudget, exr, pfm};

/// A picture file after reading its header, before its pixels.
pub struct PictureFile<'a> {
    path: PathBuf,
    body: Body<'a>,
    memory: MemoryBudget,
}

/// The source of the pixels.
enum Body<'a> {
    Exr(Box<exr::Opened<Box<dyn Input + 'a>>>),
    Pfm(pfm::Opened<Box<dyn Input + 'a>>),
    Other(decoded::Opened<'a>),
}

impl Image {
    /// Reads an EXR, PFM, PNG, TGA, JPEG or Radiance HDR file, as its extension says.
    ///
    /// Integer formats are taken from the sRGB curve to linear values, without their alpha. A PFM file gives R,
    /// G and B or Y; its scale is multiplied in. Of an EXR file this takes the first part that has R, G and B or
    /// Y, with all its channels as 32-bit float. If there is none, but only one layer with such channels, it is
    /// read as by [`PictureFile::open_layer`]; if there are several layers or no colors, it takes the first part.
    ///
    /// # Errors
    ///
    /// As [`PictureFile::open`] and [`PictureFile::read`], with the memory that this machine has.
    pub fn read(path: &Path) -> Result<Image, ImageError> {
        Ok(PictureFile::open(path, &MemoryBudget::default())?.read()?.0)
    }
}

impl<'a> PictureFile<'a> {
    /// Reads the header of an EXR, PFM, PNG, TGA, JPEG or Radiance HDR file. See [`Image::read`]. A JPEG file is read
    /// whole; `memory` is charged for it, and later for the pixels.
    ///
    /// # Errors
    ///
    /// [`ImageError::Read`] if the file system or the memory budget refuses, the format is another one, or what is to be read of an EXR
    /// file has deep data, subsampled channels, or DWA or HTJ2K compression; [`ImageError::NotThatFormat`] and
    /// [`ImageError::Damaged`] for a header that is not right.
    pub fn open(path: &Path, memory: &MemoryBudget) -> Result<Self, ImageError> {
        Self::open_file(path, None, memory)
    }

    /// Reads the header for one layer of an EXR file.
    ///
    /// `layer` is what the names of the layer's channels begin with, as `albedo` for `albedo.R`; or the name of
    /// a part of the file; or both, as `left.albedo`, where parts have equal layers; or the whole name of one
    /// channel, as `depth.Z`.
    ///
    /// Red, green and blue become R, G and B, whether they are called `R`, `r` or `red`; so do the X, Y and Z of
    /// a vector. A channel that is alone becomes Y. Others keep the last word of their names, as `A`.
    ///
    /// # Errors
    ///
    /// [`ImageError::Read`] if the file has no such layer or another format than EXR; else as [`PictureFile::open`].
    pub fn open_layer(path: &Path, layer: &str, memory: &MemoryBudget) -> Result<Self, ImageError> {
        match Format::from_path(path) {
            Some(Format::Exr) => Self::open_file(path, Some(layer), memory),
            _ => {
                let fault = Fault::Unfit("only EXR files have layers".into());
                Err(ImageError::reading(path, fault))
            }
        }
    }

    /// Reads the header of a picture for a texture, from the bytes of a file. The path only gives the format. Values
    /// of integer formats are scaled to 0 to 1 and keep their curve.
    ///
    /// # Errors
    ///
    /// As [`PictureFile::open`].
    pub fn of_bytes(path: &Path, bytes: &'a [u8], memory: &MemoryBudget) -> Result<Self, ImageError> {
        Self::of_input(path, Box::new(Cursor::new(bytes)), Curve::Stored, None, memory)
    }

    /// Checks only the extension of a picture's name.
    ///
    /// # Errors
    ///
    /// [`ImageError::Read`] if it stands for no format that is read.
    pub fn check_name(path: &Path) -> Result<(), ImageError> {
        match is_read(path) {
            true => Ok(()),
            false => Err(ImageError::reading(path, Fault::Unfit(decoded::READ.into()))),
        }
    }

    fn open_file(path: &Path, layer: Option<&str>, memory: &MemoryBudget) -> Result<Self, ImageError> {
        let file = open_file(path).map_err(|error| ImageError::reading(path, error.into()))?;
        Self::of_input(path, Box::new(BufReader::new(file)), Curve::Linear, layer, memory)
    }

    fn of_input(
        path: &Path,
        input: Box<dyn Input + 'a>,
        curve: Curve,
        layer: Option<&str>,
        memory: &MemoryBudget,
    ) -> Result<Self, ImageError> {
        match Body::open(path, input, curve, layer, memory) {
            Ok(body) => Ok(PictureFile { path: path.into(), body, memory: memory.clone() }),
            Err(fault) => Err(ImageError::reading(path, fault)),
        }
    }

    /// Where the pixels lie.
    pub fn placement(&self) -> Placement {
        let window = match &self.body {
            Body::Exr(file) => return file.placement(),
            Body::Pfm(file) => file.window,
            Body::Other(file) => file.window(),
        };
        Placement { data_window: window, display_window: window, has_windows: false }
    }

    /// The metadata, as in [`Image`].
    pub fn metadata(&self) -> Option<String> {
        match &self.body {
            Body::Exr(file) => file.metadata(),
            Body::Pfm(_) => None,
            Body::Other(file) => file.metadata.clone(),
        }
    }

    /// Reads the pixels. The charge is for the picture.
    ///
    /// # Errors
    ///
    /// [`ImageError::TooLarge`] if the memory budget has no room for them, before any is decoded;
    /// [`ImageError::Damaged`] for contents that are not right.
    pub fn read(self) -> Result<(Image, Charge), ImageError> {
        let memory = &self.memory;
        let read = match self.body {
            Body::Exr(file) => file.read(memory),
            Body::Pfm(file) => file.read(memory),
            Body::Other(file) => file.read(memory),
        };
        let (image, mut charge) = read.map_err(|fault| ImageError::reading(&self.path, fault))?;
        // Less than for reading, so it fits.
        let _ = charge.resize(image.bytes());
        Ok((image, charge))
    }
}

impl<'a> Body<'a> {
    fn open(
        path: &Path,
        mut input: Box<dyn Input + 'a>,
        curve: Curve,
        layer: Option<&str>,
        memory: &MemoryBudget,
    ) -> Result<Self, Fault> {
        check_beginning(path, input.fill_buf()?)?;
        Ok(match Format::from_path(path) {
            Some(Format::Exr) => Body::Exr(Box::new(exr::open(input, layer)?)),
            Some(Format::Pfm) => Body::Pfm(pfm::open(input)?),
            _ => Body::Other(decoded::open(input, path, curve, memory)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unreadable_paths_say_why() {
        let check = |path: &str, expected: &str| {
            assert_eq!(Image::read(Path::new(path)).unwrap_err().to_string(), expected);
        };
        check("none.exr", "cannot read none.exr: there is no such file or folder");
        check("none.png", "cannot read none.png: there is no such file or folder");
        check("none", "cannot read none: there is no such file or folder");
        let error =
            PictureFile::open_layer(Path::new("none.png"), "albedo", &MemoryBudget::default()).err().unwrap();
        assert_eq!(error.to_string(), "cannot read none.png: only EXR files have layers");
    }
}
