//! OpenEXR files, by the `exr` crate.

use std::collections::HashSet;
use std::io::{Read, Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::lines::LineRef;
use ::exr::block::reader::ChunksReader;
use ::exr::block::{self, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::error::{Error, UnitResult};
use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType, Text};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::prelude::f16;

use crate::error::{Fault, pixel_count};
use crate::{Channel, Image, Window};

/// The one custom attribute: the crate writes several of them in random order, so no two files would be
/// alike.
const METADATA: &str = "lookat";

/// Writes all channels in 32-bit float.
pub(crate) fn write(image: &Image, out: impl Write + Seek) -> Result<(), Fault> {
    let plane =
        |channel: &Channel| AnyChannel::new(text(&channel.name), FlatSamples::F32(channel.samples.clone()));
    let channels = AnyChannels::sort(image.channels.iter().map(plane).collect());

    let data = bounds(image.data_window);
    let attributes = LayerAttributes { layer_position: data.position, ..LayerAttributes::default() };
    let layer = Layer::new(data.size, attributes, Encoding::SMALL_LOSSLESS, channels);

    let mut attributes = ImageAttributes::new(bounds(image.display_window));
    if let Some(metadata) = &image.metadata {
        attributes.other.insert(text(METADATA), AttributeValue::Text(text(metadata)));
    }
    ::exr::image::Image::new(attributes, layer).write().to_buffered(out).map_err(|error| match error {
        Error::Io(error) => Fault::Io(error),
        Error::Invalid(reason) | Error::NotSupported(reason) => Fault::Unfit(reason.into()),
        Error::Aborted => Fault::Unfit("interrupted".into()),
    })
}

/// Reads the first layer that has a picture to show, or else the first.
pub(crate) fn read(mut file: impl Read + Seek) -> Result<Image, Fault> {
    let mut magic = Vec::new();
    file.by_ref().take(4).read_to_end(&mut magic)?;
    if magic != ::exr::meta::magic_number::BYTES {
        return Err(Fault::Foreign);
    }
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    // The crate panics on some damaged files; it then holds nothing but the file, which is dropped.
    catch_unwind(AssertUnwindSafe(|| decode(file, length)))
        .unwrap_or_else(|_| Err(Fault::Damaged("its parts contradict each other".into())))
}

fn decode(file: impl Read + Seek, length: u64) -> Result<Image, Fault> {
    let reader = block::read(file, false).map_err(fault)?;
    let layer = reader.headers().iter().position(has_color).unwrap_or(0);
    let header = reader.headers()[layer].clone();
    let pixels = check(&header, length)?;

    // The offsets are read before the memory is taken: a file without them is too short for its claims. Of a
    // picture with several resolutions only the full one is wanted.
    let chunks = reader
        .filter_chunks(true, |_, tile, block| block.layer == layer && tile.level_index == Vec2(0, 0))
        .map_err(fault)?;
    let mut image = blank(&header, pixels)?;

    // One thread, because a panic in a thread of the crate's own pool would end the program.
    let mut seen = HashSet::new();
    let insert = |_: &_, block: UncompressedBlock| {
        let Vec2(x, y) = block.index.pixel_position;
        if block.index.layer != layer || block.index.level != Vec2(0, 0) || !seen.insert((x, y)) {
            return Err(Error::Invalid("a part is stored twice and another is missing".into()));
        }
        copy(&header, &block, &mut image)
    };
    chunks.decompress_sequential(false, insert).map_err(fault)?;
    Ok(image)
}

/// Whether the layer has R, G and B, or Y.
fn has_color(header: &Header) -> bool {
    let has =
        |name: &str| header.channels.list.iter().any(|channel| channel.name.as_slice() == name.as_bytes());
    (has("R") && has("G") && has("B")) || has("Y")
}

/// The number of pixels, if the layer is one that can be held and a file of this length can contain it.
fn check(header: &Header, length: u64) -> Result<usize, Fault> {
    // No compression that is let through shrinks more; 1032 is the bound of ZIP, 1376 that of PXR24.
    const DENSEST: u64 = 2048;
    let Vec2(width, height) = header.layer_size;
    let pixels = pixel_count(width as u64, height as u64)?;
    if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(Fault::Unfit(format!("channel `{}` is subsampled", words(&channel.name))));
    }
    // The crate takes as much memory for these as the file says, without a check.
    if matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Err(Fault::Unfit("DWA compression is not supported".into()));
    }
    if (pixels * header.channels.bytes_per_pixel) as u64 > length.saturating_mul(DENSEST) {
        return Err(Fault::Damaged(format!("the file is too short for {width} x {height} pixels")));
    }
    Ok(pixels)
}

/// The image that the blocks are to fill.
fn blank(header: &Header, pixels: usize) -> Result<Image, Fault> {
    let mut channels = Vec::new();
    for channel in &header.channels.list {
        let mut samples = Vec::new();
        samples.try_reserve_exact(pixels).map_err(|_| Fault::Unfit("there is not enough memory".into()))?;
        samples.resize(pixels, 0.0);
        channels.push(Channel { name: words(&channel.name), samples });
    }
    let metadata = match header.own_attributes.other.get(METADATA.as_bytes()) {
        Some(AttributeValue::Text(text)) => Some(words(text)),
        _ => None,
    };
    let data_window = window(header.data_window());
    let display_window = window(header.shared_attributes.display_window);
    Ok(Image { data_window, display_window, channels, metadata })
}

/// Copies one block of rows, or one tile, to its place in the image.
fn copy(header: &Header, block: &UncompressedBlock, image: &mut Image) -> UnitResult {
    for line in block.lines(&header.channels) {
        let Vec2(x, y) = line.location.position;
        let start = y * header.layer_size.width() + x;
        let row =
            &mut image.channels[line.location.channel].samples[start..start + line.location.sample_count];
        match header.channels.list[line.location.channel].sample_type {
            SampleType::F16 => convert(line, row, f16::to_f32)?,
            SampleType::F32 => line.read_samples_into_slice(row)?,
            SampleType::U32 => convert(line, row, |value: u32| value as f32)?,
        }
    }
    Ok(())
}

fn convert<T: ::exr::io::Data>(line: LineRef<'_>, row: &mut [f32], to_f32: impl Fn(T) -> f32) -> UnitResult {
    for (sample, value) in row.iter_mut().zip(line.read_samples()) {
        *sample = to_f32(value?);
    }
    Ok(())
}

fn fault(error: Error) -> Fault {
    match error {
        Error::Io(error) => Fault::Io(error),
        Error::NotSupported(reason) => Fault::Unfit(reason.into()),
        // The crate's words for the end of the file.
        Error::Invalid(reason) if reason == "reference to missing bytes" => {
            Fault::Damaged("the file ends too early".into())
        }
        Error::Invalid(reason) => Fault::Damaged(format!("invalid {reason}")),
        Error::Aborted => Fault::Damaged("reading was interrupted".into()),
    }
}

/// UTF-8, of which the crate's own conversion would keep only Latin-1.
fn text(words: &str) -> Text {
    Text::from_slice_unchecked(words.as_bytes())
}

fn words(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn bounds(window: Window) -> IntegerBounds {
    IntegerBounds::new((window.x, window.y), (window.width as usize, window.height as usize))
}

fn window(bounds: IntegerBounds) -> Window {
    // The crate has checked that both corners are in the range of i32.
    let (Vec2(x, y), Vec2(width, height)) = (bounds.position, bounds.size);
    Window { x, y, width: width as u32, height: height as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::image::Blocks;
    use std::io::Cursor;

    fn sample() -> Image {
        let data_window = Window { x: -3, y: 7, width: 5, height: 40 };
        let display_window = Window { x: 0, y: 0, width: 64, height: 48 };
        let values =
            |seed: u32| (0..200).map(|i| f32::from_bits((i + seed).wrapping_mul(0x9e37_79b9))).collect();
        let channel =
            |(i, name): (usize, &&str)| Channel { name: name.to_string(), samples: values(i as u32) };
        let channels = ["B", "G", "R", "Tiefe \u{fc}", "albedo.R"].iter().enumerate().map(channel).collect();
        let metadata = Some("{\"scene\": \"K\u{fc}che \u{1f600}\"}".to_string());
        Image { data_window, display_window, channels, metadata }
    }

    fn bytes(image: &Image) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        write(image, &mut out).unwrap();
        out.into_inner()
    }

    fn bits(image: &Image) -> Vec<(&str, Vec<u32>)> {
        let bits = |channel: &Channel| channel.samples.iter().map(|sample| sample.to_bits()).collect();
        image.channels.iter().map(|channel| (channel.name.as_str(), bits(channel))).collect()
    }

    /// A file of two layers with one channel each, of 20 x 10 pixels, in the encoding.
    fn layers(encoding: Encoding, channels: [(&str, FlatSamples); 2]) -> Vec<u8> {
        let layer = |(i, (name, samples)): (usize, (&str, FlatSamples))| {
            let channels = AnyChannels::sort([AnyChannel::new(name, samples)].into_iter().collect());
            Layer::new((20, 10), LayerAttributes::named(format!("layer {i}").as_str()), encoding, channels)
        };
        let layers: Vec<_> = channels.into_iter().enumerate().map(layer).collect();
        let attributes = ImageAttributes::with_size((20, 10));
        let mut out = Cursor::new(Vec::new());
        ::exr::image::Image::from_layers(attributes, layers).write().to_buffered(&mut out).unwrap();
        out.into_inner()
    }

    #[test]
    fn keeps_every_bit_and_both_windows() {
        let image = sample();
        let read = read(Cursor::new(bytes(&image))).unwrap();
        assert_eq!(bits(&read), bits(&image));
        assert_eq!((read.data_window, read.display_window), (image.data_window, image.display_window));
        assert_eq!(read.metadata, image.metadata);
    }

    #[test]
    fn equal_pictures_give_equal_files() {
        let first = bytes(&sample());
        assert!((0..8).all(|_| bytes(&sample()) == first));
    }

    #[test]
    fn reads_each_kind_of_number_from_the_layer_with_color() {
        let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 4)), ..Encoding::SMALL_LOSSLESS };
        let piz = Encoding { compression: Compression::PIZ, ..Encoding::SMALL_LOSSLESS };
        for encoding in
            [Encoding::UNCOMPRESSED, Encoding::SMALL_LOSSLESS, Encoding::FAST_LOSSLESS, tiles, piz]
        {
            let half = FlatSamples::F16((0..200u8).map(f16::from).collect());
            let check = |name, first: &FlatSamples, second: &FlatSamples| {
                let file = layers(encoding, [("Z", first.clone()), (name, second.clone())]);
                read(Cursor::new(file)).unwrap().channels
            };
            let uint = FlatSamples::U32((1000..1200).collect());
            let halves: Vec<f32> = (0..200u8).map(f32::from).collect();
            let uints: Vec<f32> = (1000..1200u16).map(f32::from).collect();
            assert_eq!(check("Y", &uint, &half), [Channel { name: "Y".into(), samples: halves.clone() }]);
            assert_eq!(check("Y", &half, &uint), [Channel { name: "Y".into(), samples: uints }]);
            assert_eq!(check("id", &half, &uint), [Channel { name: "Z".into(), samples: halves }]);
        }
    }

    #[test]
    fn refuses_damaged_files() {
        let file = bytes(&sample());
        for end in 0..file.len() {
            let error = read(Cursor::new(&file[..end])).unwrap_err();
            assert!(matches!((end, error), (..4, Fault::Foreign) | (4.., Fault::Damaged(_))), "{end}");
        }
        assert!(matches!(read(Cursor::new(b"P6 1 1 255\n...")), Err(Fault::Foreign)));

        // The upper corner of the data window, as it stands in the file.
        let corner = file.windows(10).position(|bytes| bytes == b"dataWindow").unwrap() + 10 + 1 + 6 + 4 + 8;
        let check = |x: i32, y: i32, expected: &str| {
            let mut file = file.clone();
            file[corner..corner + 8].copy_from_slice(&[x.to_le_bytes(), y.to_le_bytes()].concat());
            let error = format!("{:?}", read(Cursor::new(file)).unwrap_err());
            assert!(error.contains(expected), "{x} {y}: {error}");
        };
        // The crate swaps corners that are the wrong way round; then the data do not fit.
        check(-100, 46, "Damaged");
        check(-4, 46, "Damaged");
        check(1, 1_000_000, "Damaged");
        check(1_000_000, 46, "too short");
        check(10_000_000, 46, "more than the 268435456");
        check(i32::MAX, i32::MAX, "Damaged");
        check(i32::MIN, i32::MIN, "Damaged");
    }
}
