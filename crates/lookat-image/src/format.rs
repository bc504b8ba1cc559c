//! The file formats by name.

use std::path::Path;

use ::image::ImageFormat;

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
}

/// The ending of the format that a file is of by its first bytes, where its name has another one.
pub(crate) fn other_than_named(path: &Path, bytes: &[u8]) -> Option<&'static str> {
    let format = ::image::guess_format(bytes).ok()?;
    let is_named = ImageFormat::from_path(path).is_ok_and(|named| named == format);
    (!is_named).then(|| match format {
        ImageFormat::Pnm => "pnm",
        format => format.extensions_str()[0],
    })
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
        let check =
            |path: &str, bytes, other| assert_eq!(other_than_named(Path::new(path), bytes), other, "{path}");
        check("a.png", b"\xff\xd8\xff\xe0", Some("jpg"));
        check("a.JPEG", b"\xff\xd8\xff\xe0", None);
        check("a.jpg", b"\x89PNG\r\n\x1a\n", Some("png"));
        check("a.tga", b"\x76\x2f\x31\x01", Some("exr"));
        check("a.exr", b"\x76\x2f\x31\x01", None);
        check("a.pfm", b"P6 1 1 255", Some("pnm"));
        check("a.pfm", b"PF 1 1 -1", None);
        check("a.tga", b"\0\0\x02\0", None);
        check("a.png", b"", None);
    }
}
