//! The file formats by name.

use std::path::Path;

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
}
