//! PNG, TGA, JPEG and Radiance HDR files, by the `image` and `png` crates. PNG and TGA are written in 8-bit sRGB.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::array::from_fn;
use std::error::Error;
use std::io::{BufRead, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::Path;

use ::image::codecs::hdr::HdrDecoder;
use ::image::codecs::tga::TgaEncoder;
use ::image::{
    ColorType, DynamicImage, ExtendedColorType, GrayImage, ImageDecoder, ImageEncoder, ImageError,
    ImageFormat, ImageReader, Limits,
};

use crate::color::{linear_from_srgb, of_byte};
use crate::format::{Format, Input, METADATA, Opened};
use crate::image::{ByteImage, Pixels, Placement};
use crate::{Image, ImageFault, MemoryBudget, Precision, Window};

/// The formats by their extensions, with a bound for the bytes of pixels that one byte of a file can stand for. PNG shrinks
/// to 1/1032 what may be 1 bit for 32; a row of HDR may be a color and a count.
const FORMATS: [(&str, ImageFormat, u64); 5] = [
    ("png", ImageFormat::Png, 1 << 16),
    ("tga", ImageFormat::Tga, 1 << 10),
    ("jpg", ImageFormat::Jpeg, 1 << 11),
    ("jpeg", ImageFormat::Jpeg, 1 << 11),
    ("hdr", ImageFormat::Hdr, 1 << 16),
];

/// The treatment of integer values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Curve {
    /// They are converted from the sRGB curve to linear values.
    Linear,
    /// They stay as stored, from 0 to 1.
    Stored,
}

/// The message for an extension that stands for no format that is read.
pub(crate) const READ: &str =
    "lookat reads exr, pfm, png, tga, jpg and hdr, by the extension of the file name";

/// The entry of [`FORMATS`] for the extension of a name.
pub(crate) fn known(path: &Path) -> Option<&'static (&'static str, ImageFormat, u64)> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().find(|(known, ..)| *known == extension)
}

/// The most bytes that a PNG decoder takes for metadata, such as a color profile, and for a row.
const METADATA_BYTES: u64 = 1 << 24;

/// The bytes of three 32-bit floats.
const PIXEL_BYTES: u64 = 12;

/// Reads the header. The pixels are R, G and B; alpha is dropped.
pub(crate) fn open<'a>(
    mut input: Box<dyn Input + 'a>,
    path: &Path,
    curve: Curve,
    memory: &MemoryBudget,
) -> Result<Opened<'a>, ImageFault> {
    let Some((_, format, densest)) = known(path) else {
        return Err(ImageFault::Refused(READ.into()));
    };
    let length = input.seek(SeekFrom::End(0))?;
    if *format == ImageFormat::Jpeg && !jpeg_is_ended(&mut input, length)? {
        return Err(ImageFault::Damaged("the file ends inside the picture".into()));
    }
    let bytes = match format {
        // The decoder holds the file.
        ImageFormat::Jpeg => length,
        ImageFormat::Png => METADATA_BYTES.min(memory.left() / 8),
        _ => 0,
    };
    let decoder_charge =
        memory.reserve(bytes).map_err(|shortage| ImageFault::Refused(shortage.to_string()))?;
    input.rewind()?;
    let metadata = if *format == ImageFormat::Png { png_metadata(&mut input, bytes) } else { None };
    input.rewind()?;
    let is_hdr = *format == ImageFormat::Hdr;
    let decoder: Box<dyn ImageDecoder> = if is_hdr && input.fill_buf()?.starts_with(b"#?RGBE\n") {
        // The other first line that such files have; the decoder knows one.
        input.seek(SeekFrom::Start(6))?;
        Box::new(HdrDecoder::new(b"#?RADIANCE".chain(input))?)
    } else {
        let mut reader = ImageReader::with_format(input, *format);
        let mut limits = Limits::no_limits();
        // Only PNG decoders mind it here, and they do not count the pixels.
        limits.max_alloc = Some(bytes);
        reader.limits(limits);
        Box::new(reader.into_decoder()?)
    };
    let (width, height) = decoder.dimensions();
    let window = Window { x: 0, y: 0, width, height }.not_empty()?;
    if decoder.total_bytes() > length.saturating_mul(*densest) {
        return Err(ImageFault::Damaged(format!("the file is too short for {width} x {height} pixels")));
    }
    let linear = move |value| if curve == Curve::Linear && !is_hdr { linear_from_srgb(value) } else { value };
    let channels_of_bytes = match decoder.color_type() {
        ColorType::L8 | ColorType::La8 => Some(1),
        ColorType::Rgb8 | ColorType::Rgba8 => Some(3),
        _ => None,
    };
    let read = move |memory: &MemoryBudget, keeps_bytes: bool| {
        let _decoder_charge = decoder_charge;
        // As stored with the decoder's own copy of it, then as bytes, or as 32-bit float and then plane by plane.
        let stored = 2 * u64::from(decoder.color_type().bytes_per_pixel());
        let own = match channels_of_bytes {
            Some(channels) if keeps_bytes => channels as u64,
            _ => PIXEL_BYTES + stored.max(PIXEL_BYTES),
        };
        let charge = window.reserve(own.max(stored), 0, memory)?;
        let decoded = DynamicImage::from_decoder(decoder)?;
        let Some(channels) = channels_of_bytes else {
            let mut values = decoded.into_rgb32f().into_raw();
            for value in &mut values {
                *value = linear(*value);
            }
            let image = Image::from_rgb(window, window, values.as_chunks().0);
            let image = Image { precision: Precision::Integer, has_windows: false, ..image };
            return Ok((Pixels::Values(image), charge));
        };
        let bytes =
            if channels == 1 { decoded.into_luma8().into_raw() } else { decoded.into_rgb8().into_raw() };
        let values = if channels == 1 { grays() } else { from_fn(|byte| of_byte(byte as u8)) }.map(linear);
        Ok((Pixels::Bytes(ByteImage { window, channels, bytes, values: Box::new(values) }), charge))
    };
    Ok(Opened { placement: Placement::alone(window), metadata, channels_of_bytes, read: Box::new(read) })
}

/// The values that the decoders' crate gives gray bytes as colors: some are a rounding error away from a fraction of 255.
fn grays() -> [f32; 256] {
    let bytes = (0..=255).collect();
    let picture = GrayImage::from_raw(256, 1, bytes).map(DynamicImage::ImageLuma8);
    let colors = picture.unwrap_or_default().into_rgb32f();
    from_fn(|byte| colors.get_pixel(byte as u32, 0).0[0])
}

/// The text that lookat writes before the pixels. The decoder does not give it. The caller rewinds the file.
fn png_metadata(input: impl BufRead + Seek, bytes: u64) -> Option<String> {
    let limits = png::Limits { bytes: usize::try_from(bytes).unwrap_or(usize::MAX) };
    // If the header is faulty, the decoder of the pixels says so.
    let reader = png::Decoder::new_with_limits(input, limits).read_info().ok()?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    texts.find(|chunk| chunk.keyword == METADATA).map(|chunk| chunk.text.clone())
}

/// True if the end of a JPEG picture is among the last bytes of the file. Its decoder invents missing pixels.
fn jpeg_is_ended(input: &mut (impl BufRead + Seek), length: u64) -> Result<bool, ImageFault> {
    /// Some programs add bytes of their own.
    const TAIL: u64 = 1 << 16;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let scan = jpeg_scan(input)?.unwrap_or(length);
    input.seek(SeekFrom::Start(scan.max(length.saturating_sub(TAIL))))?;
    let mut tail = Vec::new();
    input.take(TAIL).read_to_end(&mut tail)?;
    Ok(tail.windows(2).any(|bytes| bytes == END_OF_IMAGE))
}

/// The offset of the first scan of a JPEG picture: a thumbnail with an end of its own may precede it. `None` if the file ends before
/// the scan.
fn jpeg_scan(input: &mut (impl BufRead + Seek)) -> Result<Option<u64>, ImageFault> {
    const START_OF_SCAN: u8 = 0xda;
    // After the start of the picture, segments: a marker, a length that counts its own two bytes, and the rest.
    let mut at = 2;
    loop {
        input.seek(SeekFrom::Start(at))?;
        let mut head = [0; 4];
        if let Err(error) = input.read_exact(&mut head) {
            return if error.kind() == ErrorKind::UnexpectedEof { Ok(None) } else { Err(error.into()) };
        }
        match head {
            [0xff, START_OF_SCAN, ..] => return Ok(Some(at)),
            // Fill bytes.
            [0xff, 0xff, ..] => at += 1,
            [0xff, _, high, low] => at += 2 + u64::from(u16::from_be_bytes([high, low])),
            // The decoder reports it.
            _ => return Ok(Some(0)),
        }
    }
}

impl From<ImageError> for ImageFault {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::IoError(error) => error.into(),
            ImageError::Decoding(error) => {
                // The cause alone: the format is known.
                let cause = error.source().map_or_else(|| error.to_string(), ToString::to_string);
                ImageFault::Damaged(cause.trim_end().trim_end_matches('.').into())
            }
            ImageError::Limits(_) => ImageFault::Refused("its metadata takes too much memory".into()),
            error => ImageFault::Refused(error.to_string()),
        }
    }
}

/// Writes color or gray, tagged as sRGB, with the metadata in a text chunk.
pub(crate) fn write_png(image: &Image, out: impl Write) -> Result<(), ImageFault> {
    let planes = image.visible_planes()?;
    let mut encoder = png::Encoder::new(out, image.data_window.width, image.data_window.height);
    encoder.set_color(if planes.len() == 3 { png::ColorType::Rgb } else { png::ColorType::Grayscale });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    if let Some(metadata) = &image.metadata {
        encoder.add_text_chunk(METADATA.into(), ascii(metadata))?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes(&planes))?;
    Ok(writer.finish()?)
}

/// A PNG file of 8-bit sRGB. `bytes` are red, green and blue of each pixel, row by row.
///
/// # Errors
///
/// [`ImageFault::Refused`] if these are no whole rows of `width` pixels, or more than the format holds.
pub fn rgb_png(width: usize, bytes: &[u8]) -> Result<Vec<u8>, ImageFault> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, (bytes.len() / 3 / width) as u32);
    encoder.set_color(png::ColorType::Rgb);
    // A tenth larger and five times as fast as the usual.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

/// Writes color or gray.
pub(crate) fn write_tga(image: &Image, out: impl Write) -> Result<(), ImageFault> {
    let planes = image.visible_planes()?;
    let (width, height) = (image.data_window.width, image.data_window.height);
    let most = Format::Tga.most_side();
    if width.max(height) > most {
        return Err(ImageFault::Refused(format!("a TGA file has at most {most} pixels per side")));
    }
    let color = if planes.len() == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::L8 };
    // Runs that cross rows, which the encoder makes, break readers that follow the specification.
    Ok(TgaEncoder::new(out).disable_rle().write_image(&bytes(&planes), width, height, color)?)
}

impl From<png::EncodingError> for ImageFault {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(error) => error.into(),
            error => ImageFault::Refused(error.to_string()),
        }
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
    use ::image::{GrayAlphaImage, RgbImage, RgbaImage};
    use std::io::Cursor;

    /// Bytes stand for what the decoders' crate makes of them.
    #[test]
    fn bytes_have_the_values_of_floats() {
        let bytes = |channels: u32| {
            (0..256 * channels).map(|i| (i / channels * (1 + i % channels) % 256) as u8).collect()
        };
        let all = [
            DynamicImage::ImageLuma8(GrayImage::from_raw(16, 16, bytes(1)).unwrap()),
            DynamicImage::ImageLumaA8(GrayAlphaImage::from_raw(16, 16, bytes(2)).unwrap()),
            DynamicImage::ImageRgb8(RgbImage::from_raw(16, 16, bytes(3)).unwrap()),
            DynamicImage::ImageRgba8(RgbaImage::from_raw(16, 16, bytes(4)).unwrap()),
        ];
        for picture in all {
            let mut file = Cursor::new(Vec::new());
            picture.write_to(&mut file, ImageFormat::Png).unwrap();
            let memory = MemoryBudget::new(1 << 30);
            for curve in [Curve::Stored, Curve::Linear] {
                let opened = || {
                    open(Box::new(Cursor::new(file.get_ref())), Path::new("a.png"), curve, &memory).unwrap()
                };
                let pixels = (opened().read)(&memory, true).unwrap().0;
                assert!(
                    matches!(&pixels, Pixels::Bytes(image) if Some(image.channels) == opened().channels_of_bytes)
                );
                let bits = |of: &mut dyn Iterator<Item = f32>| of.map(f32::to_bits).collect::<Vec<_>>();
                let expected = picture.to_rgb32f().into_raw().into_iter();
                let found = Image::from(pixels).rgb().unwrap();
                assert_eq!(
                    bits(&mut found.as_flattened().iter().copied()),
                    bits(&mut expected.map(|value| if curve == Curve::Linear {
                        linear_from_srgb(value)
                    } else {
                        value
                    })),
                );
            }
        }
    }

    use crate::PictureFile;

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
        let reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let text = &reader.info().uncompressed_latin1_text[0];
        assert_eq!(text.keyword, "lookat");
        assert_eq!(text.text, r#"{"scene": "K\u00fcche \ud83d\ude00"}"#);
        // Reading finds it, before the pixels and with them.
        let expected = Some(text.text.as_str());
        let memory = MemoryBudget::new(1 << 20);
        let opened = PictureFile::of_bytes(Path::new("a.png"), &file, &memory).unwrap();
        assert_eq!(opened.metadata().as_deref(), expected);
        assert_eq!(opened.read().unwrap().0.metadata.as_deref(), expected);
    }

    fn decode(name: &str, bytes: &[u8], memory: u64) -> Result<Image, crate::ImageError> {
        let memory = MemoryBudget::new(memory);
        Ok(PictureFile::of_bytes(Path::new(name), bytes, &memory)?.read()?.0)
    }

    #[test]
    fn too_many_pixels_are_refused_before_any_is_decoded() {
        let directory = tempfile::tempdir().unwrap();
        let window = Window { x: 0, y: 0, width: 64, height: 32 };
        let image = Image::from_rgb(window, window, &[[0.5; 3]; 64 * 32]);
        for name in ["a.png", "a.exr", "a.pfm", "a.tga"] {
            let path = directory.path().join(name);
            image.write(&path).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            let decode = |memory| decode(path.to_str().unwrap(), &bytes, memory);
            assert_eq!(decode(1 << 20).unwrap().data_window, window, "{name}");
            let error = decode(64 * 32 * 12 - 1).unwrap_err();
            assert!(
                matches!(error.fault, ImageFault::TooLarge { width: 64, height: 32, .. }),
                "{name}: {error}"
            );
        }
    }

    #[test]
    fn eight_bits_come_back_to_half_a_step() {
        let directory = tempfile::tempdir().unwrap();
        let window = Window { x: 0, y: 0, width: 2, height: 2 };
        let pixels = [[0.0, 0.5, 1.0], [0.18, 0.003, 0.9], [0.02, 0.3, 0.7], [1.0, 1.0, 0.0]];
        let image = Image::from_rgb(window, window, &pixels);
        for name in ["a.png", "a.tga"] {
            let path = directory.path().join(name);
            image.write(&path).unwrap();
            let back = Image::read(&path).unwrap().rgb().unwrap();
            for (a, b) in back.as_flattened().iter().zip(pixels.as_flattened()) {
                // Half a step of the curve, at its steepest.
                assert!((a - b).abs() < 2.3 * 0.5 / 255.0, "{name}: {a} {b}");
            }
        }
    }

    #[test]
    fn radiance_files_have_either_first_line() {
        let of = |first: &str| {
            let header = format!("{first}\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
            let bytes = [header.as_bytes(), &[128, 64, 32, 130]].concat();
            decode("a.hdr", &bytes, 1 << 20).map(|image| image.rgb().unwrap())
        };
        assert_eq!(of("#?RADIANCE").unwrap(), [[2.0, 1.0, 0.5]]);
        assert_eq!(of("#?RGBE").unwrap(), [[2.0, 1.0, 0.5]]);
        assert!(of("#?OTHER").is_err());
    }

    #[test]
    fn jpeg_files_that_are_cut_short_are_refused() {
        let pixels: Vec<u8> = (0..64 * 64).map(|index: u32| (index * index) as u8).collect();
        let mut whole = Vec::new();
        let encoder = ::image::codecs::jpeg::JpegEncoder::new(&mut whole);
        encoder.write_image(&pixels, 64, 64, ::image::ExtendedColorType::L8).unwrap();
        // Another picture within, with an end of its own, and filling.
        whole.splice(2..2, *b"\xff\xff\xe1\x00\x08\xff\xd8\xff\xd9..");
        let read = |bytes: &[u8]| decode("a.jpg", bytes, 1 << 20);
        assert_eq!(read(&whole).unwrap().data_window.width, 64);
        for length in [whole.len() - 2, whole.len() * 2 / 3, 400, 12, 4] {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.jpg", "a.tga", "a.hdr", "a.gif"] {
            for bytes in [&b""[..], b"x", b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR", b"\xff\xd8\xff\xe0"] {
                let path = directory.path().join(name);
                std::fs::write(&path, bytes).unwrap();
                let error = Image::read(&path).unwrap_err();
                assert!(error.to_string().contains("a."), "{error}");
            }
        }
    }
}
