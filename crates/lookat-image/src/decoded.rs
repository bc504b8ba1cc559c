//! Pictures of 8 and 16 bits and Radiance HDR, as another library decodes them.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::array::from_fn;
use std::error::Error;
use std::io::{BufRead, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::LazyLock;

use ::image::codecs::hdr::HdrDecoder;
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::error::Fault;
use crate::exr::METADATA;
use crate::{Charge, Image, MemoryBudget, Precision, Window};

/// The formats that are read here, by their endings, with a bound for the bytes of pixels that one byte of a
/// file can stand for. PNG shrinks to 1/1032 what may be 1 bit for 32; a row of HDR may be a color and a
/// count.
const FORMATS: [(&str, ImageFormat, u64); 5] = [
    ("png", ImageFormat::Png, 1 << 16),
    ("tga", ImageFormat::Tga, 1 << 10),
    ("jpg", ImageFormat::Jpeg, 1 << 11),
    ("jpeg", ImageFormat::Jpeg, 1 << 11),
    ("hdr", ImageFormat::Hdr, 1 << 16),
];

/// What becomes of the values of integer formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Curve {
    /// They are taken from the sRGB curve to linear ones.
    Linear,
    /// They stay as they stand in the file, from 0 to 1.
    Stored,
}

/// What a picture is read from.
pub(crate) trait Input: BufRead + Seek {}

impl<T: BufRead + Seek> Input for T {}

/// What is read.
pub(crate) const READ: &str =
    "lookat reads exr, pfm, png, tga, jpg and hdr, by the extension of the file name";

/// Which of [`FORMATS`] the ending of a name stands for.
pub(crate) fn known(path: &Path) -> Option<&'static (&'static str, ImageFormat, u64)> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    FORMATS.iter().find(|(known, ..)| *known == ending)
}

/// A file whose header is read.
pub(crate) struct Opened<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
    /// See [`Image`].
    pub metadata: Option<String>,
    curve: Curve,
    /// For the decoder.
    charge: Charge,
}

/// The most bytes that a PNG decoder takes for metadata, such as a color profile, and for a row.
const METADATA_BYTES: u64 = 1 << 24;

/// Reads the header.
pub(crate) fn open<'a>(
    mut input: Box<dyn Input + 'a>,
    path: &Path,
    curve: Curve,
    memory: &MemoryBudget,
) -> Result<Opened<'a>, Fault> {
    let Some((_, format, densest)) = known(path) else {
        return Err(Fault::Unfit(READ.into()));
    };
    let length = input.seek(SeekFrom::End(0))?;
    let is_ended = *format != ImageFormat::Jpeg || jpeg_is_ended(&mut input, length)?;
    if !is_ended {
        return Err(Fault::Damaged("the file ends inside the picture".into()));
    }
    let bytes = match format {
        // The decoder holds the file.
        ImageFormat::Jpeg => length,
        ImageFormat::Png => METADATA_BYTES.min(memory.left() / 8),
        _ => 0,
    };
    let charge = memory.reserve(bytes).map_err(|shortage| Fault::Unfit(shortage.to_string()))?;
    input.rewind()?;
    let metadata = if *format == ImageFormat::Png { png_metadata(&mut input, bytes) } else { None };
    input.rewind()?;
    let is_hdr = *format == ImageFormat::Hdr;
    let decoder: Box<dyn ImageDecoder> = if is_hdr && input.fill_buf()?.starts_with(b"#?RGBE\n") {
        // The other first line that such files have; the decoder knows one.
        input.seek(SeekFrom::Start(6))?;
        Box::new(HdrDecoder::new(b"#?RADIANCE".chain(input)).map_err(fault)?)
    } else {
        let mut reader = ImageReader::with_format(input, *format);
        let mut limits = Limits::no_limits();
        // Only PNG decoders mind it here, and they do not count the pixels.
        limits.max_alloc = Some(bytes);
        reader.limits(limits);
        Box::new(reader.into_decoder().map_err(fault)?)
    };
    let curve = if is_hdr { Curve::Stored } else { curve };
    let file = Opened { decoder, metadata, curve, charge };
    let Window { width, height, .. } = file.window().not_empty()?;
    if file.decoder.total_bytes() > length.saturating_mul(*densest) {
        return Err(Fault::Damaged(format!("the file is too short for {width} x {height} pixels")));
    }
    Ok(file)
}

impl Opened<'_> {
    pub fn window(&self) -> Window {
        let (width, height) = self.decoder.dimensions();
        Window { x: 0, y: 0, width, height }
    }

    /// Reads R, G and B; alpha is left out.
    pub fn read(self, memory: &MemoryBudget) -> Result<(Image, Charge), Fault> {
        let window = self.window();
        let Opened { decoder, metadata, curve, charge: _of_decoder } = self;
        // As stored with the decoder's own copy of it, then as 32-bit float, then plane by plane.
        let stored = 2 * u64::from(decoder.color_type().bytes_per_pixel());
        let charge = window.reserve(PIXEL_BYTES + stored.max(PIXEL_BYTES), 0, memory)?;
        let mut values = DynamicImage::from_decoder(decoder).map_err(fault)?.into_rgb32f().into_raw();
        if curve == Curve::Linear {
            values.iter_mut().for_each(|value| *value = linear_from_srgb(*value));
        }
        let (pixels, _) = values.as_chunks();
        let image = Image::from_rgb(window, window, pixels);
        Ok((Image { metadata, precision: Precision::Integer, has_windows: false, ..image }, charge))
    }
}

/// The text that lookat writes before the pixels. The decoder does not give it. The caller rewinds the file.
fn png_metadata(input: impl BufRead + Seek, bytes: u64) -> Option<String> {
    let limits = png::Limits { bytes: usize::try_from(bytes).unwrap_or(usize::MAX) };
    // If the header is faulty, the decoder of the pixels says so.
    let reader = png::Decoder::new_with_limits(input, limits).read_info().ok()?;
    let mut texts = reader.info().uncompressed_latin1_text.iter();
    texts.find(|chunk| chunk.keyword == METADATA).map(|chunk| chunk.text.clone())
}

/// Three 32-bit floats.
const PIXEL_BYTES: u64 = 12;

/// Whether the end of a JPEG picture is among the last bytes of the file: its decoder makes up what is missing.
fn jpeg_is_ended(input: &mut (impl BufRead + Seek), length: u64) -> Result<bool, Fault> {
    /// Some programs add bytes of their own.
    const TAIL: u64 = 1 << 16;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let scan = jpeg_scan(input)?.unwrap_or(length);
    input.seek(SeekFrom::Start(scan.max(length.saturating_sub(TAIL))))?;
    let mut tail = Vec::new();
    input.take(TAIL).read_to_end(&mut tail)?;
    Ok(tail.windows(2).any(|bytes| bytes == END_OF_IMAGE))
}

/// Where the first scan of a JPEG picture begins: before it a small picture may stand, with an end of its own. `None`
/// where the file ends before it.
fn jpeg_scan(input: &mut (impl BufRead + Seek)) -> Result<Option<u64>, Fault> {
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
            // Filling.
            [0xff, 0xff, ..] => at += 1,
            [0xff, _, high, low] => at += 2 + u64::from(u16::from_be_bytes([high, low])),
            // The decoder knows what to say of it.
            _ => return Ok(Some(0)),
        }
    }
}

fn fault(error: ::image::ImageError) -> Fault {
    match error {
        ::image::ImageError::IoError(error) => error.into(),
        ::image::ImageError::Decoding(error) => {
            // The cause alone: the format is known.
            let cause = error.source().map_or_else(|| error.to_string(), ToString::to_string);
            Fault::Damaged(cause.trim_end().trim_end_matches('.').into())
        }
        ::image::ImageError::Limits(_) => Fault::Unfit("its metadata takes too much memory".into()),
        error => Fault::Unfit(error.to_string()),
    }
}

/// The inverse of the sRGB curve of IEC 61966-2-1, for any number.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    static OF_BYTES: LazyLock<[f32; 256]> =
        LazyLock::new(|| from_fn(|byte| inverse_curve(of_byte(byte as u8))));
    // Most values come from bytes.
    let byte = (encoded * 255.0 + 0.5) as u8;
    if of_byte(byte).to_bits() == encoded.to_bits() {
        OF_BYTES[usize::from(byte)]
    } else {
        inverse_curve(encoded)
    }
}

/// As decoders have it.
fn of_byte(byte: u8) -> f32 {
    f32::from(byte) / 255.0
}

/// By its formula.
fn inverse_curve(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
    linear as f32
}

#[cfg(test)]
mod tests {
    use ::image::ImageEncoder;

    use super::{inverse_curve, linear_from_srgb, of_byte};
    use crate::{Image, ImageError, MemoryBudget, PictureFile, Window};

    fn decode(name: &str, bytes: &[u8], memory: u64) -> Result<Image, ImageError> {
        let memory = MemoryBudget::new(memory);
        Ok(PictureFile::of_bytes(std::path::Path::new(name), bytes, &memory)?.read()?.0)
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
            assert!(matches!(error, ImageError::TooLarge { width: 64, height: 32, .. }), "{name}: {error}");
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
    fn bytes_are_as_linear_as_other_numbers() {
        let bytes = (0..=2550).map(|step| step as f32 / 2550.0).chain((0..=255).map(of_byte));
        for encoded in bytes.chain([-0.0, -1.0, 2.0, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN]) {
            assert_eq!(linear_from_srgb(encoded).to_bits(), inverse_curve(encoded).to_bits(), "{encoded}");
        }
        assert_eq!([0.0, 1.0].map(linear_from_srgb), [0.0, 1.0]);
        assert!((linear_from_srgb(0.5) - 0.214_041_14).abs() < 1e-7);
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.jpg", "a.tga", "a.hdr", "a.gif"] {
            for bytes in [&b""[..], b"x", b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR", b"\xff\xd8\xff\xe0"] {
                let path = directory.path().join(name);
                std::fs::write(&path, bytes).unwrap();
                let error: ImageError = Image::read(&path).unwrap_err();
                assert!(error.to_string().contains("a."), "{error}");
            }
        }
    }
}
