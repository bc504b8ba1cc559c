//! The picture in memory.

use std::io;

use crate::{Charge, ImageFault, MemoryBudget};

/// The channels of linear color.
const RGB: [&str; 3] = ["R", "G", "B"];

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

    /// The pixels that both windows cover. `None` if there is none.
    pub fn intersection(self, other: Window) -> Option<Window> {
        let span = |a: i32, a_size: u32, b: i32, b_size: u32| {
            let end = (i64::from(a) + i64::from(a_size)).min(i64::from(b) + i64::from(b_size));
            u32::try_from(end - i64::from(a.max(b))).ok().filter(|size| *size > 0)
        };
        let width = span(self.x, self.width, other.x, other.width)?;
        let height = span(self.y, self.height, other.y, other.height)?;
        Some(Window { x: self.x.max(other.x), y: self.y.max(other.y), width, height })
    }

    /// The indices of the pixels of `part`, a window inside this one, among all pixels row by row.
    pub(crate) fn indices(self, part: Window) -> impl Iterator<Item = usize> {
        let (left, top) = ((part.x - self.x) as usize, (part.y - self.y) as usize);
        let (width, height, row) = (part.width as usize, part.height as usize, self.width as usize);
        (top..top + height).flat_map(move |y| (left..left + width).map(move |x| y * row + x))
    }

    /// The values of `part`, a window inside this one. `values` has one value for each pixel of this window, row by row.
    pub fn cut<T: Copy>(self, values: Vec<T>, part: Window) -> Vec<T> {
        if self == part {
            return values;
        }
        self.indices(part).map(|i| values[i]).collect()
    }

    /// Fails if there is no pixel.
    pub(crate) fn not_empty(self) -> Result<Self, ImageFault> {
        if self.area() == 0 { Err(ImageFault::Damaged("it has no pixels".into())) } else { Ok(self) }
    }

    /// Reserves the memory to read a picture of this size: `pixel_bytes` for each pixel, and `more`.
    pub(crate) fn reserve(
        self,
        pixel_bytes: u64,
        more: u64,
        memory: &MemoryBudget,
    ) -> Result<Charge, ImageFault> {
        let Window { width, height, .. } = self;
        let bytes = self.area().saturating_mul(pixel_bytes).saturating_add(more);
        memory.reserve(bytes).map_err(|shortage| ImageFault::TooLarge { width, height, shortage })
    }
}

/// The windows of a picture: where its samples lie in the full picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placement {
    /// See [`Image::data_window`].
    pub data_window: Window,
    /// See [`Image::display_window`].
    pub display_window: Window,
    /// See [`Image::has_windows`].
    pub has_windows: bool,
}

impl Placement {
    /// A picture that does not say where it lies.
    pub(crate) fn alone(window: Window) -> Placement {
        Placement { data_window: window, display_window: window, has_windows: false }
    }
}

/// One named plane of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The name, as in an EXR file: "R", "G" and "B" are linear color, "Y" is gray; other names are free. Distinct within an
    /// image, not empty, without NUL.
    pub name: String,
    /// One value for each pixel of the data window, row by row, top row first. Any float, including NaN and infinity.
    pub samples: Vec<f32>,
}

impl Channel {
    /// A channel of so many zeros.
    pub(crate) fn blank(name: &str, pixels: usize) -> Result<Channel, ImageFault> {
        let mut samples = Vec::new();
        samples.try_reserve_exact(pixels).map_err(io::Error::from)?;
        samples.resize(pixels, 0.0);
        Ok(Channel { name: name.into(), samples })
    }
}

/// One named plane of integers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IntegerChannel {
    /// The name in an EXR file: distinct within an image, also from those of [`Channel`]s, not empty, without NUL.
    pub name: String,
    /// One value for each pixel of the data window, row by row, top row first.
    pub samples: Vec<u32>,
}

/// The precision of the values in the file of a picture.
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
    /// The samples lie here, in pixels.
    pub data_window: Window,
    /// The whole picture, in pixels. The data window may be smaller, larger or beside it.
    pub display_window: Window,
    /// At least one channel, each with [`Window::area`] samples of the data window. A file may change their order.
    pub channels: Vec<Channel>,
    /// Integers beside the channels, such as sums that are to be exact. Only EXR files hold them, and only
    /// [`read_integers`](crate::read_integers) reads them as integers.
    pub integers: Vec<IntegerChannel>,
    /// A JSON text, stored in EXR and PNG files under the name "lookat". TGA and PFM files cannot hold it. It is not parsed here.
    pub metadata: Option<String>,
    /// The layers of the EXR file that the picture was read from, as [`PictureFile::open_layer`](crate::PictureFile::open_layer)
    /// takes them. Empty for other pictures. Not written.
    pub layers: Vec<String>,
    /// The precision of the file that the picture was read from. Not written.
    pub precision: Precision,
    /// True if the windows say where the picture lies in a larger one. Among files, only EXR stores that.
    pub has_windows: bool,
}

impl Image {
    /// A picture of 32-bit float without metadata. `channels` lie over the data window.
    pub fn new(placement: Placement, channels: Vec<Channel>) -> Self {
        let Placement { data_window, display_window, has_windows } = placement;
        let (integers, layers, precision) = (Vec::new(), Vec::new(), Precision::Single);
        Image {
            data_window,
            display_window,
            channels,
            integers,
            metadata: None,
            layers,
            precision,
            has_windows,
        }
    }

    /// A color picture without metadata. `pixels` are linear red, green and blue over the data window, row by
    /// row, top row first.
    pub fn from_rgb(data_window: Window, display_window: Window, pixels: &[[f32; 3]]) -> Self {
        let plane = |i: usize| pixels.iter().map(|pixel| pixel[i]).collect();
        Image::from_planes(data_window, display_window, [0, 1, 2].map(plane))
    }

    /// A color picture without metadata. `planes` are linear red, green and blue, each over the data window.
    pub fn from_planes(data_window: Window, display_window: Window, planes: [Vec<f32>; 3]) -> Self {
        let placement = Placement { data_window, display_window, has_windows: true };
        let channels = RGB.into_iter().zip(planes);
        Image::new(
            placement,
            channels.map(|(name, samples)| Channel { name: name.into(), samples }).collect(),
        )
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

    /// The planes of linear red, green and blue: the channels R, G and B, or else Y three times. `None` if the picture
    /// has neither.
    pub fn rgb_planes(&self) -> Option<[&[f32]; 3]> {
        match RGB.map(|name| self.channel(name)) {
            [Some(r), Some(g), Some(b)] => Some([r, g, b]),
            _ => self.channel("Y").map(|gray| [gray; 3]),
        }
    }

    /// The bytes of all samples.
    pub fn bytes(&self) -> u64 {
        self.channels.iter().map(|channel| size_of_val(&channel.samples[..]) as u64).sum()
    }

    /// The windows of the picture.
    pub fn placement(&self) -> Placement {
        let Image { data_window, display_window, has_windows, .. } = *self;
        Placement { data_window, display_window, has_windows }
    }

    /// The indices of the channels that a format without channel names shows: R, G and B, or else Y or the only channel.
    pub(crate) fn visible_channels(&self) -> Result<Vec<usize>, ImageFault> {
        let index = |name: &str| self.channels.iter().position(|channel| channel.name == name);
        let only = (self.channels.len() == 1).then_some(0);
        let colors: Option<Vec<usize>> = RGB.into_iter().map(index).collect();
        let reason = "the picture has several channels, but neither R, G and B nor Y";
        let visible = colors.or_else(|| index("Y").or(only).map(|gray| vec![gray]));
        visible.ok_or_else(|| ImageFault::Refused(reason.into()))
    }

    /// The samples of the channels that a format without channel names shows.
    pub(crate) fn visible_planes(&self) -> Result<Vec<&[f32]>, ImageFault> {
        Ok(self.visible_channels()?.into_iter().map(|at| &self.channels[at].samples[..]).collect())
    }
}

/// The pixels of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Pixels {
    /// 32-bit float.
    Values(Image),
    /// 8 bits.
    Bytes(ByteImage),
}

/// A picture of gray or of red, green and blue in 8 bits.
#[derive(Debug, Clone, PartialEq)]
pub struct ByteImage {
    /// All pixels.
    pub window: Window,
    /// 1 or 3.
    pub channels: usize,
    /// All channels of the first pixel, then of the second, row by row, top row first.
    pub bytes: Vec<u8>,
    /// What the bytes stand for.
    pub values: Box<[f32; 256]>,
}

impl From<Pixels> for Image {
    fn from(pixels: Pixels) -> Image {
        let ByteImage { window, channels, bytes, values } = match pixels {
            Pixels::Values(image) => return image,
            Pixels::Bytes(bytes) => bytes,
        };
        let plane = |i: usize| {
            bytes.iter().skip(i % channels).step_by(channels).map(|byte| values[usize::from(*byte)]).collect()
        };
        let image = Image::from_planes(window, window, [0, 1, 2].map(plane));
        Image { precision: Precision::Integer, has_windows: false, ..image }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Window = Window { x: 0, y: 0, width: 1, height: 1 };

    #[test]
    fn rgb_comes_from_color_or_gray() {
        let mut image = Image::from_rgb(ONE, ONE, &[[1.0, 2.0, 3.0]]);
        assert_eq!(image.rgb(), Some(vec![[1.0, 2.0, 3.0]]));
        image.channels.truncate(1);
        assert_eq!(image.rgb(), None);
        image.channels[0].name = "Y".into();
        assert_eq!(image.rgb(), Some(vec![[1.0; 3]]));
    }
}
