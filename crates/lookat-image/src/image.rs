//! The picture in memory, and how it becomes a file.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use crate::error::{Fault, ImageError};
use crate::file::replace;
use crate::{Charge, Format, MemoryBudget, PictureFile, eightbit, exr, pfm};

/// A rectangle of pixels; y points down and the origin is at the top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The leftmost column.
    pub x: i32,
    /// The topmost row.
    pub y: i32,
    /// The number of columns; at least 1 for a data window.
    pub width: u32,
    /// The number of rows; at least 1 for a data window.
    pub height: u32,
}

impl Window {
    /// The number of pixels inside.
    pub fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Width and height.
    pub fn size(self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Fails if there is no pixel.
    pub(crate) fn not_empty(self) -> Result<Self, Fault> {
        if self.area() == 0 { Err(Fault::Damaged("it has no pixels".into())) } else { Ok(self) }
    }

    /// Reserves the memory to read a picture of this size: so many bytes for each pixel, and some more.
    pub(crate) fn reserve(self, pixel_bytes: u64, more: u64, memory: &MemoryBudget) -> Result<Charge, Fault> {
        let Window { width, height, .. } = self;
        let bytes = self.area().saturating_mul(pixel_bytes).saturating_add(more);
        memory.reserve(bytes).map_err(|shortage| Fault::TooLarge { width, height, shortage })
    }
}

/// An empty array with room for so many values.
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, Fault> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(io::Error::from)?;
    Ok(values)
}

/// Where the samples of a picture lie in the full picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placement {
    /// As in [`Image`].
    pub data_window: Window,
    /// As in [`Image`].
    pub display_window: Window,
    /// As in [`Image`].
    pub has_windows: bool,
}

/// One named plane of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// As in an EXR file: "R", "G" and "B" are linear color, "Y" is gray; any other name has the meaning its
    /// user gives it. Distinct within an image, not empty, without NUL.
    pub name: String,
    /// One value for each pixel of the data window, row by row, top row first. Any float, NaN and infinity
    /// included.
    pub samples: Vec<f32>,
}

/// How finely a file keeps the values of a picture. It is not written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precision {
    /// Integers of 8 or 16 bits; in Radiance HDR three of 8 bits with a common exponent.
    Integer,
    /// 16-bit float: 11 bits of the value.
    Half,
    /// 32-bit float, or a picture that comes from no file.
    Single,
}

/// A picture: the channels over the data window, which is the part of the display window that was computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Where the samples lie, in pixels.
    pub data_window: Window,
    /// The whole picture, in pixels. The data window may be smaller, larger or beside it.
    pub display_window: Window,
    /// At least one, each with [`Window::area`] samples of the data window. In any order; a file may change
    /// it.
    pub channels: Vec<Channel>,
    /// A JSON text that goes along in EXR and PNG, under the name "lookat"; TGA and PFM have no place for it.
    /// It is not parsed here.
    pub metadata: Option<String>,
    /// The names that [`PictureFile::open_layer`] takes for the EXR file from which this was read; none for other
    /// pictures. They are not written.
    pub layers: Vec<String>,
    /// Of the file from which this was read.
    pub precision: Precision,
    /// Whether it says where it lies in a larger picture; of files, .exr alone does.
    pub has_windows: bool,
}

impl Image {
    /// A color picture without metadata. `pixels` are linear red, green and blue over the data window, row by
    /// row, top row first.
    pub fn from_rgb(data_window: Window, display_window: Window, pixels: &[[f32; 3]]) -> Self {
        let plane = |i: usize| pixels.iter().map(|pixel| pixel[i]).collect();
        Image::from_planes(data_window, display_window, [0, 1, 2].map(plane))
    }

    /// The same, from linear red, green and blue one after the other.
    pub fn from_planes(data_window: Window, display_window: Window, planes: [Vec<f32>; 3]) -> Self {
        let channels = ["R", "G", "B"]
            .iter()
            .zip(planes)
            .map(|(name, samples)| Channel { name: name.to_string(), samples });
        Image {
            data_window,
            display_window,
            channels: channels.collect(),
            metadata: None,
            layers: Vec::new(),
            precision: Precision::Single,
            has_windows: true,
        }
    }

    /// The samples of the channel with this name; case counts.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.samples.as_slice())
    }

    /// Linear red, green and blue of each pixel of the data window: the channels R, G and B, or else Y three
    /// times. Alpha takes no part. `None` if the picture has neither.
    pub fn rgb(&self) -> Option<Vec<[f32; 3]>> {
        let [r, g, b] = self.rgb_planes()?;
        Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect())
    }

    /// The same, plane by plane.
    pub fn rgb_planes(&self) -> Option<[&[f32]; 3]> {
        self.color_planes().or_else(|| self.channel("Y").map(|gray| [gray; 3]))
    }

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
        let format =
            Format::from_path(path).ok_or_else(|| ImageError::UnknownFormat { path: path.into() })?;
        self.write_as(format, path).map_err(|fault| ImageError::writing(path, fault))
    }

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

    /// Bytes that the samples take.
    pub fn bytes(&self) -> u64 {
        self.channels.iter().map(|channel| size_of_val(&channel.samples[..]) as u64).sum()
    }

    /// Where the samples lie.
    pub fn placement(&self) -> Placement {
        let Image { data_window, display_window, has_windows, .. } = *self;
        Placement { data_window, display_window, has_windows }
    }

    fn write_as(&self, format: Format, path: &Path) -> Result<(), Fault> {
        self.check()?;
        replace(path, |out| match format {
            Format::Exr => exr::write(self, out),
            Format::Png => eightbit::write_png(self, out),
            Format::Pfm => pfm::write(self, out),
            Format::Tga => eightbit::write_tga(self, out),
        })
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

    fn color_planes(&self) -> Option<[&[f32]; 3]> {
        Some([self.channel("R")?, self.channel("G")?, self.channel("B")?])
    }

    /// What a format without channel names shows: R, G and B, or else one plane, Y or the only channel.
    pub(crate) fn visible_planes(&self) -> Result<Vec<&[f32]>, Fault> {
        if let Some(planes) = self.color_planes() {
            return Ok(planes.to_vec());
        }
        match (self.channel("Y"), self.channels.as_slice()) {
            (Some(gray), _) => Ok(vec![gray]),
            (None, [only]) => Ok(vec![only.samples.as_slice()]),
            _ => Err(Fault::Unfit("the picture has several channels, but neither R, G and B nor Y".into())),
        }
    }
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

    #[cfg(unix)]
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

    #[cfg(unix)]
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

    #[test]
    fn rgb_comes_from_color_or_gray() {
        let mut image = Image::from_rgb(ONE, ONE, &[[1.0, 2.0, 3.0]]);
        assert_eq!(image.rgb(), Some(vec![[1.0, 2.0, 3.0]]));
        image.channels.truncate(1);
        assert_eq!(image.rgb(), None);
        image.channels[0].name = "Y".into();
        assert_eq!(image.rgb(), Some(vec![[1.0; 3]]));
    }

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
