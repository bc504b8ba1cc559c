//! PNG and TGA: 8-bit sRGB, for looking at.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::io::Write;

use ::image::codecs::tga::TgaEncoder;
use ::image::{ExtendedColorType, ImageEncoder};

use crate::error::Fault;
use crate::exr::METADATA;
use crate::{Format, Image};

/// Writes color or gray, tagged as sRGB, with the metadata in a text chunk.
pub(crate) fn write_png(image: &Image, out: impl Write) -> Result<(), Fault> {
    let planes = image.visible_planes()?;
    let mut encoder = png::Encoder::new(out, image.data_window.width, image.data_window.height);
    encoder.set_color(if planes.len() == 3 { png::ColorType::Rgb } else { png::ColorType::Grayscale });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    if let Some(metadata) = &image.metadata {
        encoder.add_text_chunk(METADATA.into(), ascii(metadata)).map_err(png_fault)?;
    }
    let mut writer = encoder.write_header().map_err(png_fault)?;
    writer.write_image_data(&bytes(&planes)).map_err(png_fault)?;
    writer.finish().map_err(png_fault)
}

/// Writes color or gray.
pub(crate) fn write_tga(image: &Image, out: impl Write) -> Result<(), Fault> {
    let planes = image.visible_planes()?;
    let (width, height) = (image.data_window.width, image.data_window.height);
    let most = Format::Tga.most_side();
    if width.max(height) > most {
        return Err(Fault::Unfit(format!("a TGA file has at most {most} pixels per side")));
    }
    let color = if planes.len() == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::L8 };
    // Runs that cross rows, which the encoder makes, break readers that follow the specification.
    TgaEncoder::new(out).disable_rle().write_image(&bytes(&planes), width, height, color).map_err(|error| {
        match error {
            ::image::ImageError::IoError(error) => Fault::Io(error),
            error => Fault::Unfit(error.to_string()),
        }
    })
}

fn png_fault(error: png::EncodingError) -> Fault {
    match error {
        png::EncodingError::IoError(error) => Fault::Io(error),
        error => Fault::Unfit(error.to_string()),
    }
}

/// All planes of the first pixel, then of the second, and so on.
fn bytes(planes: &[&[f32]]) -> Vec<u8> {
    let pixels = planes.first().map_or(0, |plane| plane.len());
    (0..pixels).flat_map(|i| planes.iter().map(move |plane| srgb_byte(plane[i]))).collect()
}

/// The sRGB transfer curve of IEC 61966-2-1, clamped to 0..1 and rounded to the nearest of 256 steps. NaN is
/// 0.
fn srgb_byte(linear: f32) -> u8 {
    let curve = match linear.clamp(0.0, 1.0) {
        low if low <= 0.003_130_8 => 12.92 * low,
        high => 1.055 * libm::powf(high, 1.0 / 2.4) - 0.055,
    };
    // NaN comes through the clamp and the curve, and the cast makes it 0.
    (255.0 * curve).round() as u8
}

/// A JSON text in ASCII, since a PNG text chunk is Latin-1. Only within a JSON string may another character
/// stand, and there an escape means the same.
fn ascii(json: &str) -> String {
    let mut out = String::new();
    for character in json.chars() {
        match character {
            _ if character.is_ascii() => out.push(character),
            _ => out.extend(character.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}"))),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MemoryBudget, PictureFile, Window};

    const WINDOW: Window = Window { x: 5, y: -3, width: 2, height: 2 };
    const PIXELS: [[f32; 3]; 4] =
        [[0.0, 0.5, 1.0], [f32::NAN, -1.0, 7.0], [0.2, 0.001, f32::INFINITY], [0.213, 1.0, 0.0]];
    const BYTES: [u8; 12] = [0, 188, 255, 0, 0, 255, 124, 3, 255, 127, 255, 0];

    #[test]
    fn follows_the_srgb_curve() {
        let check = |linear, expected| assert_eq!(srgb_byte(linear), expected, "{linear}");
        check(0.0, 0);
        check(-0.0, 0);
        check(f32::NEG_INFINITY, 0);
        check(f32::NAN, 0);
        check(0.003_130_8, 10);
        check(0.18, 118);
        check(0.213, 127);
        check(0.215, 128);
        check(0.5, 188);
        check(1.0, 255);
        check(1e30, 255);
    }

    #[test]
    fn each_byte_comes_back() {
        for byte in 0..=255u8 {
            let encoded = f32::from(byte) / 255.0;
            let linear =
                if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
            assert_eq!(srgb_byte(linear), byte);
        }
    }

    #[test]
    fn png_and_tga_decode_to_the_right_bytes() {
        let directory = tempfile::tempdir().unwrap();
        let color = Image::from_rgb(WINDOW, WINDOW, &PIXELS);
        let mut gray = color.clone();
        gray.channels.truncate(1);
        for name in ["picture.png", "picture.TGA"] {
            let path = directory.path().join(name);
            color.write(&path).unwrap();
            let decoded = ::image::open(&path).unwrap();
            assert_eq!((decoded.width(), decoded.height()), (2, 2));
            assert_eq!(decoded.as_rgb8().unwrap().as_raw(), &BYTES);
            gray.write(&path).unwrap();
            assert_eq!(::image::open(&path).unwrap().as_luma8().unwrap().as_raw(), &[0, 0, 124, 127]);
        }
    }

    #[test]
    fn png_keeps_the_metadata() {
        let metadata = Some("{\"scene\": \"K\u{fc}che \u{1f600}\"}".to_string());
        let image = Image { metadata, ..Image::from_rgb(WINDOW, WINDOW, &PIXELS) };
        let mut file = Vec::new();
        write_png(&image, &mut file).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let text = &reader.info().uncompressed_latin1_text[0];
        assert_eq!(text.keyword, "lookat");
        assert_eq!(text.text, r#"{"scene": "K\u00fcche \ud83d\ude00"}"#);
        // Reading finds it, before the pixels and with them.
        let expected = Some(text.text.as_str());
        let memory = MemoryBudget::new(1 << 20);
        let opened = PictureFile::of_bytes(std::path::Path::new("a.png"), &file, &memory).unwrap();
        assert_eq!(opened.metadata().as_deref(), expected);
        assert_eq!(opened.read().unwrap().0.metadata.as_deref(), expected);
    }
}
