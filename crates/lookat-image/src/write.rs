//! Writes pictures.

use std::collections::HashSet;
use std::io::{Cursor, Seek, Write};
use std::path::Path;

use crate::error::{Fault, ImageError};
use crate::file::replace;
use crate::{Channel, Format, Image, Window, eightbit, exr, pfm};

impl Image {
    /// Writes the file in the format that its extension names.
    ///
    /// - EXR: all channels in 32-bit float, ZIP compression, both windows and the metadata. The same picture
    ///   gives the same bytes.
    /// - PFM: 32-bit float; R, G and B, or else Y, or else the only channel.
    /// - PNG and TGA: the same choice of channels in 8-bit sRGB, clamped to 0..1, NaN as 0. PNG has the
    ///   metadata.
    ///
    /// The last three hold only the pixels of the data window and do not say where it lies.
    ///
    /// # Errors
    ///
    /// [`ImageError::UnknownFormat`] for another extension, [`ImageError::Write`] if the file system refuses
    /// or the picture does not fit. The file appears whole or not at all, and what was there before stays
    /// until then.
    pub fn write(&self, path: &Path) -> Result<(), ImageError> {
        let format = written(path)?;
        let replaced = self.check().and_then(|()| replace(path, |out| self.encode(format, out)));
        replaced.map_err(|fault| ImageError::writing(path, fault))
    }

    /// The bytes that [`Image::write`] writes to a file of this name.
    ///
    /// # Errors
    ///
    /// [`ImageError::UnknownFormat`] for another extension, [`ImageError::Write`] if the picture does not fit.
    pub fn to_bytes(&self, path: &Path) -> Result<Vec<u8>, ImageError> {
        let format = written(path)?;
        let mut out = Cursor::new(Vec::new());
        let encoded = self.check().and_then(|()| self.encode(format, &mut out));
        encoded.map(|()| out.into_inner()).map_err(|fault| ImageError::writing(path, fault))
    }

    fn encode(&self, format: Format, out: &mut (impl Write + Seek)) -> Result<(), Fault> {
        match format {
            Format::Exr => exr::write::write(self, out),
            Format::Png => eightbit::write_png(self, out),
            Format::Pfm => pfm::write(self, out),
            Format::Tga => eightbit::write_tga(self, out),
        }
    }

    /// Whether the public fields agree with each other.
    fn check(&self) -> Result<(), Fault> {
        let Window { width, height, .. } = self.data_window;
        if self.data_window.area() == 0 || self.channels.is_empty() {
            return Err(Fault::Unfit("the picture is empty".into()));
        }
        let mut names = HashSet::new();
        for Channel { name, samples } in &self.channels {
            if samples.len() as u64 != self.data_window.area() {
                let count = samples.len();
                return Err(Fault::Unfit(format!(
                    "channel `{name}` has {count} samples for {width} x {height} pixels"
                )));
            }
            if name.is_empty() || name.contains('\0') || !names.insert(name) {
                return Err(Fault::Unfit(format!(
                    "the channel name {name:?} is empty, not text or used twice"
                )));
            }
        }
        Ok(())
    }
}

fn written(path: &Path) -> Result<Format, ImageError> {
    Format::from_path(path).ok_or_else(|| ImageError::UnknownFormat { path: path.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Window = Window { x: 0, y: 0, width: 1, height: 1 };

    fn names(directory: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(directory).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_refused_picture_leaves_nothing_behind() {
        let directory = tempfile::tempdir().unwrap();
        let image = Image::from_rgb(ONE, ONE, &[[1.0; 3]]);
        let check = |image: &Image, path: &Path, expected: &str| {
            let error = image.write(path).unwrap_err().to_string();
            assert_eq!(error, expected.replace('@', &path.display().to_string()));
        };

        check(
            &image,
            Path::new("x.gif"),
            "unknown picture format `.gif`: lookat writes exr, png, pfm and tga",
        );
        check(&image, Path::new("x"), "unknown picture format `x`: lookat writes exr, png, pfm and tga");
        check(
            &image,
            &directory.path().join("none/x.exr"),
            "cannot write @: there is no such file or folder",
        );

        // A directory in the way is found only when the finished file is to take its place.
        let occupied = directory.path().join("x.exr");
        std::fs::create_dir(&occupied).unwrap();
        check(&image, &occupied, "cannot write @: it is a folder");

        // Faults that the formats find in the middle of writing.
        let wide = Window { width: 70_000, ..ONE };
        let wide = Image::from_rgb(wide, wide, &[[0.0; 3]; 70_000]);
        check(
            &wide,
            &directory.path().join("x.tga"),
            "cannot write @: a TGA file has at most 65535 pixels per side",
        );
        let far = Image { data_window: Window { x: i32::MAX, ..ONE }, ..image.clone() };
        check(&far, &directory.path().join("y.exr"), "cannot write @: window size exceeding integer maximum");
        let short = Image { data_window: wide.data_window, ..image.clone() };
        let expected = "cannot write @: channel `R` has 1 samples for 70000 x 1 pixels";
        check(&short, &directory.path().join("x.png"), expected);
        let mut twice = image.clone();
        twice.channels[1].name = "R".into();
        check(
            &twice,
            &directory.path().join("x.pfm"),
            "cannot write @: the channel name \"R\" is empty, not text or used twice",
        );
        assert_eq!(names(directory.path()), ["x.exr"]);

        // Nor is what is no file.
        #[cfg(unix)]
        {
            let path = directory.path().join("socket.exr");
            let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
            check(&image, &path, "cannot write @: the existing path is not a file");
            std::fs::remove_file(&path).unwrap();
        }

        // What was there before stays.
        let path = directory.path().join("kept.png");
        image.write(&path).unwrap();
        let before = std::fs::read(&path).unwrap();
        twice.write(&path).unwrap_err();
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }

    #[test]
    fn a_link_stays_a_link() {
        let directory = tempfile::tempdir().unwrap();
        let (link, file) = (directory.path().join("link.exr"), directory.path().join("file.exr"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        Image::from_rgb(ONE, ONE, &[[1.0; 3]]).write(&link).unwrap();
        assert!(link.is_symlink() && !file.is_symlink());
        assert!(Image::read(&file).is_ok());
    }

    #[test]
    fn links_to_nothing_are_followed_and_circles_refused() {
        let directory = tempfile::tempdir().unwrap();
        let (link, next, file) = (
            directory.path().join("link.exr"),
            directory.path().join("next.exr"),
            directory.path().join("file.exr"),
        );
        std::os::unix::fs::symlink("next.exr", &link).unwrap();
        std::os::unix::fs::symlink("file.exr", &next).unwrap();
        let image = Image::from_rgb(ONE, ONE, &[[1.0; 3]]);
        image.write(&link).unwrap();
        assert!(link.is_symlink() && next.is_symlink() && file.is_file() && !file.is_symlink());
        std::fs::remove_file(&file).unwrap();
        std::os::unix::fs::symlink("link.exr", &file).unwrap();
        assert!(image.write(&link).is_err() && link.is_symlink() && file.is_symlink());
    }
}
