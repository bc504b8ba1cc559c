//! Pictures as the page holds them: half floats, so that the reader chooses the exposure.

use std::io::Write;

use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::{Compression, write::ZlibEncoder};
use half::f16;
use lookat_image::{
    Aligned, Encoded, Image, NOT_FINITE_COLOR, Window, box_means, difference_color, difference_limit,
    suitable_exposure,
};

/// The most pixels of a picture on the page. A larger picture is reduced by averaging boxes.
const MOST_PIXELS: usize = 1 << 20;
/// Measured bytes for each pixel while a picture is packed.
pub const PACKING_BYTES: u64 = 64;
/// The longest side of a thumbnail in pixels.
const THUMBNAIL: usize = 96;

/// Expected and actual picture, or one of them, ready for the page.
#[derive(Debug, Clone)]
pub struct Picture {
    /// `expected` or `actual`: the only picture there is. `None` for both.
    pub only: Option<&'static str>,
    pub width: usize,
    pub height: usize,
    /// The position of the first pixel in the full picture.
    pub corner: [i32; 2],
    /// The side of the averaged boxes in pixels.
    pub reduced: usize,
    /// The number of pixels in only one of the pictures.
    pub left_out: u64,
    /// True if all pixels are finite.
    pub finite: bool,
    /// The exposure in stops that makes the picture visible, usually 0.
    pub stops: i32,
    /// The difference at the end of the color scale.
    pub scale: f64,
    /// Both pictures, packed, in base64. Empty once the page has written them.
    pub data: String,
    /// The name of the element with the data. Empty until then.
    pub id: String,
    /// PNG files in base64: the actual picture and the difference, or the only picture.
    pub thumbnails: Vec<String>,
}

impl Picture {
    /// Packs two pictures.
    pub fn new(pair: &Aligned) -> Picture {
        let picture = Picture::of(Pixels::of(pair), pair.window);
        Picture { left_out: pair.left_out, ..picture }
    }

    /// Packs a picture that there is nothing to compare with. `role` is `expected` or `actual`. `None` without colors.
    pub fn alone(image: &Image, role: &'static str) -> Option<Picture> {
        let Window { width, height, .. } = image.data_window;
        let expected = image.rgb()?;
        // What the page adds to the expected picture to have the actual one.
        let difference =
            expected.iter().map(|pixel| if is_finite(pixel) { [0.0; 3] } else { *pixel }).collect();
        let pixels = Pixels { width: width as usize, height: height as usize, expected, difference };
        let mut picture = Picture::of(pixels, image.data_window);
        picture.thumbnails.truncate(1);
        Some(Picture { only: Some(role), ..picture })
    }

    fn of(full: Pixels, window: Window) -> Picture {
        let reduced = (1..).find(|&side| full.reduced_area(side) <= MOST_PIXELS).unwrap_or(1);
        let pixels = if reduced > 1 { full.reduce(reduced) } else { full };
        let stops = suitable_exposure(&pixels.expected) as i32;
        let differences: Vec<f32> = pixels.difference.iter().map(largest).collect();
        let scale = difference_limit(&differences).unwrap_or(1.0);
        let small = pixels.reduce(pixels.width.max(pixels.height).div_ceil(THUMBNAIL));
        let color = |pixel: &[f32; 3]| difference_color(f64::from(largest(pixel)) / scale);
        let difference = small.png(small.difference.iter().map(color));
        Picture {
            only: None,
            width: pixels.width,
            height: pixels.height,
            corner: [window.x, window.y],
            reduced,
            left_out: 0,
            finite: pixels.expected.iter().chain(&pixels.difference).flatten().all(|value| value.is_finite()),
            stops,
            scale,
            data: pixels.pack(),
            id: String::new(),
            thumbnails: vec![small.actual_png(stops), difference],
        }
    }
}

/// The expected picture, and the difference to the actual one.
struct Pixels {
    width: usize,
    height: usize,
    expected: Vec<[f32; 3]>,
    /// Actual minus expected, or actual where expected is not finite.
    difference: Vec<[f32; 3]>,
}

impl Pixels {
    fn of(pair: &Aligned) -> Pixels {
        let minus = |a: f32, e: f32| if e.is_finite() { a - e } else { a };
        let both = pair.actual.iter().zip(&pair.expected);
        Pixels {
            width: pair.window.width as usize,
            height: pair.window.height as usize,
            expected: pair.expected.clone(),
            difference: both.map(|(a, e)| std::array::from_fn(|c| minus(a[c], e[c]))).collect(),
        }
    }

    fn reduced_area(&self, side: usize) -> usize {
        self.width.div_ceil(side) * self.height.div_ceil(side)
    }

    /// The means of boxes of `side` by `side` pixels.
    fn reduce(&self, side: usize) -> Pixels {
        Pixels {
            width: self.width.div_ceil(side),
            height: self.height.div_ceil(side),
            expected: box_means(&self.expected, self.width, side),
            difference: box_means(&self.difference, self.width, side),
        }
    }

    /// Red, green and blue of all pixels, expected and then difference, as half floats: all high bytes, then all low
    /// bytes, which compresses better.
    fn pack(&self) -> String {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        for at in 0..2 {
            let values = self.expected.as_flattened().iter().chain(self.difference.as_flattened());
            let bytes: Vec<u8> = values.map(|value| half(*value).to_be_bytes()[at]).collect();
            // Writing to memory does not fail.
            let _ = packed.write_all(&bytes);
        }
        BASE64_STANDARD.encode(packed.finish().unwrap_or_default())
    }

    /// The actual picture as displayed.
    fn actual_png(&self, stops: i32) -> String {
        let gain = 2_f32.powi(stops);
        let plus = |e: f32, d: f32| gain * if e.is_finite() { e + d } else { d };
        let both = self.expected.iter().zip(&self.difference);
        let actual: Vec<[f32; 3]> = both.map(|(e, d)| std::array::from_fn(|c| plus(e[c], d[c]))).collect();
        let shown = Encoded::from_linear(&actual).pixels;
        let bytes = shown.iter().zip(&actual).map(|(shown, actual)| {
            if is_finite(actual) {
                shown.map(|value| (255.0 * value).round() as u8)
            } else {
                NOT_FINITE_COLOR
            }
        });
        self.png(bytes)
    }

    fn png(&self, pixels: impl Iterator<Item = [u8; 3]>) -> String {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let bytes: Vec<u8> = pixels.flatten().collect();
        // Writing to memory does not fail.
        let _ = encoder.write_header().and_then(|mut writer| writer.write_image_data(&bytes));
        BASE64_STANDARD.encode(file)
    }
}

fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|value| value.is_finite())
}

/// The nearest half float. Finite values stay finite.
fn half(value: f32) -> f16 {
    let largest = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-largest, largest) } else { value })
}

/// The largest channel difference.
fn largest(pixel: &[f32; 3]) -> f32 {
    let beyond =
        |most: f32, value: f32| if value.abs() > most.abs() || value.is_nan() { value } else { most };
    if is_finite(pixel) { pixel.iter().copied().fold(0.0, beyond) } else { f32::NAN }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;
    use lookat_image::{Precision, Window};

    use super::*;

    fn pair(width: u32, actual: &[f32], expected: &[f32]) -> Aligned {
        let gray = |values: &[f32]| values.iter().map(|value| [*value; 3]).collect();
        let window = Window { x: 3, y: -2, width, height: actual.len() as u32 / width };
        Aligned {
            window,
            actual: gray(actual),
            expected: gray(expected),
            actual_errors: None,
            expected_errors: None,
            precision: Precision::Single,
            left_out: 0,
            is_placed: [false; 2],
        }
    }

    /// The first channel of all pixels, expected and then difference.
    fn unpacked(picture: &Picture) -> Vec<f32> {
        let packed = BASE64_STANDARD.decode(&picture.data).unwrap();
        let mut bytes = Vec::new();
        ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
        let (high, low) = bytes.split_at(bytes.len() / 2);
        let values = high.iter().zip(low).map(|(high, low)| f16::from_be_bytes([*high, *low]).to_f32());
        values.step_by(3).collect()
    }

    #[test]
    fn small_differences_stay_exact() {
        let picture = Picture::new(&pair(2, &[1000.001, 0.5], &[1000.0, 0.25]));
        let values = unpacked(&picture);
        assert_eq!([values[0], values[1], values[3]], [1000.0, 0.25, 0.25]);
        assert!((values[2] - 0.001).abs() < 5e-5, "{}", values[2]);
        assert_eq!((picture.corner, picture.reduced, picture.finite), ([3, -2], 1, true));
    }

    #[test]
    fn only_what_is_infinite_is_infinite() {
        let (huge, inf) = (1e30, f32::INFINITY);
        let picture = Picture::new(&pair(4, &[huge, inf, 7.0, 0.0], &[0.0, 0.0, inf, -huge]));
        assert_eq!(unpacked(&picture), [0.0, 0.0, inf, -65504.0, 65504.0, inf, 7.0, 65504.0]);
        assert!(!picture.finite);
    }

    #[test]
    fn large_pictures_are_reduced_by_means() {
        let columns = |width: usize| (0..width * 1025).map(move |i| (i % width) as f32).collect::<Vec<_>>();
        let picture = Picture::new(&pair(1025, &vec![0.0; 1025 * 1025], &columns(1025)));
        assert_eq!((picture.width, picture.height, picture.reduced), (513, 513, 2));
        let values = unpacked(&picture);
        // The last box of a row is half as wide.
        assert_eq!(values[..2], [0.5, 2.5]);
        assert_eq!(values[511..514], [1022.5, 1024.0, 0.5]);
    }

    #[test]
    fn thumbnails_are_small_pictures() {
        let picture = Picture::new(&pair(200, &[0.25; 200 * 3], &[0.0; 200 * 3]));
        let png = BASE64_STANDARD.decode(&picture.thumbnails[0]).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((frame.width, frame.height), (67, 1));
        assert!(bytes.iter().all(|byte| *byte == 137));
    }
}
