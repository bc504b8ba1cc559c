//! Reading and writing picture files: the format, then the header, then the pixels.

use std::collections::HashSet;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use ::image::ImageFormat;

use crate::format::{Format, Input, Opened};
use crate::image::{Pixels, Placement};
use crate::raster::{self, Curve};
use crate::replace::replace;
use crate::{Channel, Charge, Image, ImageError, ImageFault, IntegerChannel, MemoryBudget, Window, exr, pfm};

/// True if the extension of a name stands for a format that is read.
pub(crate) fn is_read(path: &Path) -> bool {
    raster::known(path).is_some() || Format::from_path(path).is_some()
}

/// Fails if the first bytes of a file belong to another format than its extension. Unknown extensions pass.
pub(crate) fn check_beginning(path: &Path, bytes: &[u8]) -> Result<(), ImageFault> {
    if !is_read(path) || bytes.is_empty() {
        return Ok(());
    }
    // `None` for PFM.
    let named = ImageFormat::from_path(path).ok();
    match ::image::guess_format(bytes).ok() {
        Some(found) if named != Some(found) => {
            let is_pnm = found == ImageFormat::Pnm;
            Err(ImageFault::WrongFormat(Some(if is_pnm { "pnm" } else { found.extensions_str()[0] })))
        }
        // These formats have first bytes that always match.
        None if matches!(named, Some(ImageFormat::Png | ImageFormat::Jpeg)) => {
            Err(ImageFault::WrongFormat(None))
        }
        _ => Ok(()),
    }
}

/// A picture file after reading its header, before its pixels.
pub struct PictureFile<'a> {
    path: PathBuf,
    opened: Opened<'a>,
    memory: MemoryBudget,
}

impl Image {
    /// Reads an EXR, PFM, PNG, TGA, JPEG or Radiance HDR file, by its extension.
    ///
    /// Integer formats are converted from the sRGB curve to linear values, without their alpha. A PFM file gives R, G and B, or
    /// Y, multiplied by its scale. Of an EXR file this reads the first part that has R, G and B or Y, with all its channels as
    /// 32-bit float. If there is none, but only one layer with such channels, it is read like [`PictureFile::open_layer`] does;
    /// if there are several layers or no colors, this reads the first part.
    ///
    /// # Errors
    ///
    /// The errors of [`PictureFile::open`] and [`PictureFile::read`], with the memory of this machine.
    pub fn read(path: &Path) -> Result<Image, ImageError> {
        Ok(PictureFile::open(path, &MemoryBudget::default())?.read()?.0)
    }

    /// Writes the file in the format that its extension names.
    ///
    /// - EXR: all channels in 32-bit float, ZIP compression, both windows and the metadata. The same picture gives the same
    ///   bytes.
    /// - PFM: 32-bit float; R, G and B, or else Y, or else the only channel.
    /// - PNG and TGA: the same choice of channels in 8-bit sRGB, clamped to 0..1, NaN as 0. PNG has the metadata.
    ///
    /// The last three hold only the pixels of the data window and do not say where it lies.
    ///
    /// # Errors
    ///
    /// [`ImageFault::UnknownFormat`] for another extension, [`ImageFault::Refused`] if the file system refuses or the picture does
    /// not fit. The file appears whole or not at all, and what was there before stays until then.
    pub fn write(&self, path: &Path) -> Result<(), ImageError> {
        let encode = |format| replace(path, None, |out| self.encode(format, out));
        self.format(path).and_then(encode).map_err(|fault| ImageError::writing(path, fault))
    }

    /// Writes an EXR file as [`Image::write`] does, but without compression, several times as fast and as large, and keeps what had this
    /// name before as `previous`, in the same folder. If the program is killed meanwhile, the file is still whole.
    ///
    /// # Errors
    ///
    /// As [`Image::write`], and [`ImageFault::UnknownFormat`] for another extension than .exr.
    pub fn write_checkpoint(&self, path: &Path, previous: &Path) -> Result<(), ImageError> {
        let encode = |format| match format {
            Format::Exr => replace(path, Some(previous), |out| exr::write(self, false, out)),
            _ => Err(ImageFault::UnknownFormat),
        };
        self.format(path).and_then(encode).map_err(|fault| ImageError::writing(path, fault))
    }

    /// The bytes that [`Image::write`] writes to a file of this name.
    ///
    /// # Errors
    ///
    /// [`ImageFault::UnknownFormat`] for another extension, [`ImageFault::Refused`] if the picture does not fit.
    pub fn to_bytes(&self, path: &Path) -> Result<Vec<u8>, ImageError> {
        let mut out = Cursor::new(Vec::new());
        let encoded = self.format(path).and_then(|format| self.encode(format, &mut out));
        encoded.map(|()| out.into_inner()).map_err(|fault| ImageError::writing(path, fault))
    }

    fn encode(&self, format: Format, out: &mut (impl Write + Seek)) -> Result<(), ImageFault> {
        match format {
            Format::Exr => exr::write(self, true, out),
            Format::Png => raster::write_png(self, out),
            Format::Pfm => pfm::write(self, out),
            Format::Tga => raster::write_tga(self, out),
        }
    }

    /// The format of a file to write. Fails if the public fields contradict each other.
    fn format(&self, path: &Path) -> Result<Format, ImageFault> {
        let format = Format::from_path(path).ok_or(ImageFault::UnknownFormat)?;
        let refused = |reason: String| Err(ImageFault::Refused(reason));
        let Window { width, height, .. } = self.data_window;
        if self.data_window.area() == 0 || self.channels.is_empty() {
            return refused("the picture is empty".into());
        }
        let mut names = HashSet::new();
        let channels = self.channels.iter().map(|Channel { name, samples }| (name, samples.len()));
        let integers = self.integers.iter().map(|IntegerChannel { name, samples }| (name, samples.len()));
        for (name, count) in channels.chain(integers) {
            if count as u64 != self.data_window.area() {
                return refused(format!(
                    "channel `{name}` has {count} samples for {width} x {height} pixels"
                ));
            }
            if name.is_empty() || name.contains('\0') || !names.insert(name) {
                return refused(format!("the channel name {name:?} is empty, not text or used twice"));
            }
        }
        Ok(format)
    }
}

/// Reads the channels of 32-bit integers of an EXR file: what [`Image::integers`] has written.
///
/// # Errors
///
/// As [`PictureFile::open`] and [`PictureFile::read`].
pub fn read_integers(
    path: &Path,
    memory: &MemoryBudget,
) -> Result<(Vec<IntegerChannel>, Charge), ImageError> {
    let file = open_file(path).map_err(|error| ImageError::reading(path, error))?;
    exr::read_integers(BufReader::new(file), memory).map_err(|fault| ImageError::reading(path, fault))
}

impl<'a> PictureFile<'a> {
    /// Reads the header of an EXR, PFM, PNG, TGA, JPEG or Radiance HDR file. See [`Image::read`]. A JPEG file is read whole;
    /// `memory` is charged for it, and later for the pixels.
    ///
    /// # Errors
    ///
    /// [`ImageFault::Refused`] if the file system or the memory budget refuses, no format has this extension, or an EXR file has
    /// deep data, subsampled channels, or DWA or HTJ2K compression; [`ImageFault::WrongFormat`] and [`ImageFault::Damaged`] for
    /// a wrong header.
    pub fn open(path: &Path, memory: &MemoryBudget) -> Result<Self, ImageError> {
        Self::open_path(path, None, memory)
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
    /// [`ImageFault::Refused`] if the file has no such layer or another format than EXR; else as [`PictureFile::open`].
    pub fn open_layer(path: &Path, layer: &str, memory: &MemoryBudget) -> Result<Self, ImageError> {
        if Format::from_path(path) == Some(Format::Exr) {
            Self::open_path(path, Some(layer), memory)
        } else {
            Err(ImageError::reading(path, ImageFault::Refused("only EXR files have layers".into())))
        }
    }

    /// Reads the header of a picture for a texture, from the bytes of a file. The path only gives the format. Values
    /// of integer formats are scaled to 0 to 1 and keep their curve.
    ///
    /// # Errors
    ///
    /// The errors of [`PictureFile::open`].
    pub fn of_bytes(path: &Path, bytes: &'a [u8], memory: &MemoryBudget) -> Result<Self, ImageError> {
        Self::of_input(path, Box::new(Cursor::new(bytes)), Curve::Stored, None, memory)
    }

    /// Checks only the extension of a picture's name.
    ///
    /// # Errors
    ///
    /// [`ImageFault::Refused`] if it stands for no format that is read.
    pub fn check_name(path: &Path) -> Result<(), ImageError> {
        let refused = || ImageError::reading(path, ImageFault::Refused(raster::READ.into()));
        if is_read(path) { Ok(()) } else { Err(refused()) }
    }

    fn open_path(path: &Path, layer: Option<&str>, memory: &MemoryBudget) -> Result<Self, ImageError> {
        let file = open_file(path).map_err(|error| ImageError::reading(path, error))?;
        Self::of_input(path, Box::new(BufReader::new(file)), Curve::Linear, layer, memory)
    }

    fn of_input(
        path: &Path,
        mut input: Box<dyn Input + 'a>,
        curve: Curve,
        layer: Option<&str>,
        memory: &MemoryBudget,
    ) -> Result<Self, ImageError> {
        let open = || {
            let beginning = input.fill_buf()?;
            if beginning.is_empty() {
                return Err(ImageFault::Refused("the file is empty".into()));
            }
            check_beginning(path, beginning)?;
            match Format::from_path(path) {
                Some(Format::Exr) => exr::open(input, layer),
                Some(Format::Pfm) => pfm::open(input),
                _ => raster::open(input, path, curve, memory),
            }
        };
        let opened = open().map_err(|fault| ImageError::reading(path, fault))?;
        Ok(PictureFile { path: path.into(), opened, memory: memory.clone() })
    }

    /// The windows of the picture.
    pub fn placement(&self) -> Placement {
        self.opened.placement
    }

    /// See [`Image::metadata`].
    pub fn metadata(&self) -> Option<String> {
        self.opened.metadata.clone()
    }

    /// 1 or 3 for gray or color in 8 bits, which [`PictureFile::read_pixels`] gives as bytes.
    pub fn channels_of_bytes(&self) -> Option<usize> {
        self.opened.channels_of_bytes
    }

    /// Reads the pixels. The charge is for the picture.
    ///
    /// # Errors
    ///
    /// [`ImageFault::TooLarge`] if the memory budget has no room for the pixels; none is decoded then. [`ImageFault::Damaged`] for
    /// wrong contents.
    pub fn read(self) -> Result<(Image, Charge), ImageError> {
        let metadata = self.metadata();
        let (pixels, mut charge) = self.pixels(false)?;
        let image = Image { metadata, ..pixels.into() };
        // Less than for reading, so it fits.
        let _ = charge.resize(image.bytes());
        Ok((image, charge))
    }

    /// Reads the pixels without metadata; those of 8 bits stay so. The charge is for reading them.
    ///
    /// # Errors
    ///
    /// The errors of [`PictureFile::read`].
    pub fn read_pixels(self) -> Result<(Pixels, Charge), ImageError> {
        self.pixels(true)
    }

    fn pixels(self, keeps_bytes: bool) -> Result<(Pixels, Charge), ImageError> {
        let PictureFile { path, opened, memory } = self;
        (opened.read)(&memory, keeps_bytes).map_err(|fault| ImageError::reading(&path, fault))
    }
}

/// Opens a file for reading.
///
/// # Errors
///
/// The errors of [`File::open`]; also for a folder, a pipe or a device: opening a pipe waits for a writer, and some devices never end.
pub fn open_file(path: &Path) -> io::Result<File> {
    // First, because opening a device can change it.
    check_is_file(&std::fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // Another program may have put a pipe there since: then this does not wait.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
    );
    let file = match options.open(path) {
        // A file server has lent the file, and takes it back first.
        Err(error) if error.kind() == ErrorKind::WouldBlock => File::open(path)?,
        opened => opened?,
    };
    check_is_file(&file.metadata()?)?;
    Ok(file)
}

/// Fails unless this is a file.
fn check_is_file(found: &Metadata) -> io::Result<()> {
    if found.is_file() {
        Ok(())
    } else if found.is_dir() {
        Err(ErrorKind::IsADirectory.into())
    } else {
        Err(io::Error::other("it is a pipe or a device, not a file"))
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
                Err(ImageFault::WrongFormat(format)) => Some(format),
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
