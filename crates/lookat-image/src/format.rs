//! The file formats by name.

use std::path::Path;

use ::image::ImageFormat;

use crate::decoded;
use crate::error::Fault;

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

    /// The most pixels that a picture has each way.
    pub fn most_side(self) -> u32 {
        match self {
            Format::Tga => u16::MAX.into(),
            // Numbers with a sign, of 32 bits.
            Format::Exr | Format::Png | Format::Pfm => i32::MAX as u32,
        }
    }
}

/// True if the extension of a name stands for a format that is read.
pub(crate) fn is_read(path: &Path) -> bool {
    decoded::known(path).is_some() || Format::from_path(path).is_some()
}

/// Fails where the first bytes of a file are not those of the format that its name says. Other names say nothing.
pub(crate) fn check_beginning(path: &Path, bytes: &[u8]) -> Result<(), Fault> {
    if !is_read(path) || bytes.is_empty() {
        return Ok(());
    }
    // PFM is none of these.
    let named = ImageFormat::from_path(path).ok();
    match ::image::guess_format(bytes).ok() {
        Some(found) if named != Some(found) => Err(Fault::Foreign(Some(match found {
            ImageFormat::Pnm => "pnm",
            found => found.extensions_str()[0],
        }))),
        // These always tell.
        None if matches!(named, Some(ImageFormat::Png | ImageFormat::Jpeg)) => Err(Fault::Foreign(None)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_names_the_format() {
        let check = |path: &str, expected| assert_eq!(Format::from_path(Path::new(path)), expected, "{path}");
        check("a.exr", Some(Format::Exr));
        check("dir.exr/a.PNG", Some(Format::Png));
        check("a.b.pfm", Some(Format::Pfm));
        check("a.tGa", Some(Format::Tga));
        check("a.gif", None);
        check("exr", None);
    }

    #[test]
    fn the_first_bytes_tell_what_a_name_does_not() {
        let check = |path: &str, bytes: &[u8], expected: Option<Option<&str>>| {
            let found = match check_beginning(Path::new(path), bytes) {
                Err(Fault::Foreign(format)) => Some(format),
                Err(fault) => panic!("{fault:?}"),
                Ok(()) => None,
            };
            assert_eq!(found, expected, "{path}");
        };
        let (jpg, png, exr) = (b"\xff\xd8\xff\xe0", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01");
        check("a.png", jpg, Some(Some("jpg")));
        check("a.JPEG", jpg, None);
        check("a.jpg", png, Some(Some("png")));
        check("a.jpg", b"<html>", Some(None));
        check("a.tga", exr, Some(Some("exr")));
        check("a.exr", exr, None);
        check("a.pfm", b"P6 1 1 255", Some(Some("pnm")));
        check("a.pfm", b"PF 1 1 -1", None);
        check("a.hdr", b"#?RGBE", None);
        check("a.tga", b"\0\0\x02\0", None);
        check("a.png", b"", None);
        // Names that claim nothing.
        check("a", exr, None);
        check("a.gif", png, None);
    }
}
