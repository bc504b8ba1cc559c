//! OpenEXR files, by the `exr` crate.

mod block;
mod layer;

use std::io::{Read, Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::compression::Compression;
use ::exr::error::Error;
use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType, Text};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::prelude::f16;

use crate::error::{Fault, listed};
use crate::image::{Placement, room};
use crate::{Channel, Charge, Image, MemoryBudget, Precision, Window};

use layer::Choice;

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

/// A file whose headers are read.
pub(crate) struct Opened<F> {
    file: F,
    length: u64,
    meta: MetaData,
    choice: Choice,
    layers: Vec<String>,
}

/// Reads the headers, and finds the layer with this name, or else what the file shows first.
pub(crate) fn open<F: Read + Seek>(mut file: F, layer: Option<&str>) -> Result<Opened<F>, Fault> {
    let mut magic = Vec::new();
    file.by_ref().take(4).read_to_end(&mut magic)?;
    if magic != ::exr::meta::magic_number::BYTES {
        return Err(Fault::Foreign(None));
    }
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    guarded(|| {
        let meta = MetaData::read_from_buffered(&mut file, false).map_err(header_fault)?;
        let parts = &meta.headers;
        if parts.is_empty() {
            return Err(Fault::Damaged("it has no channels".into()));
        }
        let layers = layer::names(parts);
        let choice = match layer {
            None => layer::default(parts),
            Some(name) => layer::find(parts, name).ok_or_else(|| unknown(name, &layers))?,
        };
        check(&parts[choice.part], length)?;
        Ok(Opened { file, length, meta, choice, layers })
    })
}

impl<F: Read + Seek> Opened<F> {
    pub fn placement(&self) -> Placement {
        let header = &self.meta.headers[self.choice.part];
        let [data_window, display_window] =
            [header.data_window(), header.shared_attributes.display_window].map(window);
        Placement { data_window, display_window, has_windows: true }
    }

    /// Reads the blocks.
    pub fn read(self, memory: &MemoryBudget) -> Result<(Image, Charge), Fault> {
        let Opened { mut file, length, meta, choice, layers } = self;
        let header = &meta.headers[choice.part];
        let window = window(header.data_window());
        let charge = window.reserve(4 * choice.channels.len() as u64, block::bytes(header), memory)?;
        guarded(|| {
            let mut image = Image { layers, ..blank(header, window.area() as usize, &choice)? };
            let sources = sources(header, &choice);
            block::read(&mut file, length, &meta, choice.part, |bounds, numbers| {
                copy(header, bounds, numbers, &sources, &mut image.channels);
            })?;
            Ok((image, charge))
        })
    }
}

/// Damaged B44 data make the crate panic where overflow is checked, as in a debug build; nothing else is known to. It then
/// holds nothing but the file.
fn guarded<T>(read: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(Fault::Damaged("its parts contradict each other".into())))
}

fn unknown(name: &str, layers: &[String]) -> Fault {
    Fault::Unfit(match layers {
        [] => format!("it has no layers, so `{name}` does not exist"),
        _ => format!("it has no layer `{name}`; its layers are {}", listed(layers)),
    })
}

/// Fails if the part is none that can be read, or a file of this length cannot contain it.
fn check(header: &Header, length: u64) -> Result<(), Fault> {
    let unfit = |reason: &str| Err(Fault::Unfit(reason.into()));
    if header.deep {
        return unfit("deep data is not supported");
    }
    if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(Fault::Unfit(format!("channel `{}` is subsampled", words(&channel.name).escape_debug())));
    }
    match header.compression {
        // The crate takes as much memory for these as the file says, without a check.
        Compression::DWAA(_) | Compression::DWAB(_) => return unfit("DWA compression is not supported"),
        Compression::HTJ2K32 | Compression::HTJ2K256 => return unfit("HTJ2K compression is not supported"),
        _ => {}
    }
    header.channels.validate(true, header.data_window(), true).map_err(header_fault)?;
    let window = window(header.data_window()).not_empty()?;
    let bytes = window.area().saturating_mul(header.channels.bytes_per_pixel as u64);
    if bytes > length.saturating_mul(block::DENSEST as u64) {
        let Window { width, height, .. } = window;
        return Err(Fault::Damaged(format!("the file is too short for {width} x {height} pixels")));
    }
    Ok(())
}

/// The image that the blocks are to fill.
fn blank(header: &Header, pixels: usize, choice: &Choice) -> Result<Image, Fault> {
    let blank = |(_, name): &(usize, String)| {
        let mut samples = room(pixels)?;
        samples.resize(pixels, 0.0);
        Ok(Channel { name: name.clone(), samples })
    };
    let channels = choice.channels.iter().map(blank).collect::<Result<_, Fault>>()?;
    let metadata = match header.own_attributes.other.get(METADATA.as_bytes()) {
        Some(AttributeValue::Text(text)) => Some(words(text)),
        _ => None,
    };
    let data_window = window(header.data_window());
    let display_window = window(header.shared_attributes.display_window);
    let is_half = sources(header, choice).iter().any(|(_, kind)| *kind == SampleType::F16);
    let precision = if is_half { Precision::Half } else { Precision::Single };
    Ok(Image {
        data_window,
        display_window,
        channels,
        metadata,
        layers: Vec::new(),
        precision,
        has_windows: true,
    })
}

/// For each channel of the choice, the bytes of a pixel before it, and its type.
fn sources(header: &Header, choice: &Choice) -> Vec<(usize, SampleType)> {
    let mut end = 0;
    let mut all = Vec::new();
    for channel in &header.channels.list {
        all.push((end, channel.sample_type));
        end += channel.sample_type.bytes_per_sample();
    }
    choice.channels.iter().map(|(at, _)| all[*at]).collect()
}

/// Copies one block to its place in the channels.
fn copy(
    header: &Header,
    bounds: IntegerBounds,
    numbers: &[u8],
    sources: &[(usize, SampleType)],
    channels: &mut [Channel],
) {
    let width = bounds.size.0;
    let first = bounds.position.1 as usize * header.layer_size.0 + bounds.position.0 as usize;
    for (y, bytes) in numbers.chunks_exact(width * header.channels.bytes_per_pixel).enumerate() {
        let start = first + y * header.layer_size.0;
        for (channel, (before, sample_type)) in channels.iter_mut().zip(sources) {
            let row = &mut channel.samples[start..start + width];
            let bytes = &bytes[width * before..];
            match sample_type {
                SampleType::F16 => convert(row, bytes, |two| f16::from_ne_bytes(two).to_f32()),
                SampleType::F32 => convert(row, bytes, f32::from_ne_bytes),
                SampleType::U32 => convert(row, bytes, |four| u32::from_ne_bytes(four) as f32),
            }
        }
    }
}

fn convert<const N: usize>(row: &mut [f32], bytes: &[u8], number: impl Fn([u8; N]) -> f32) {
    for (sample, bytes) in row.iter_mut().zip(bytes.as_chunks().0) {
        *sample = number(*bytes);
    }
}

fn header_fault(error: Error) -> Fault {
    match error {
        Error::Io(error) => error.into(),
        Error::NotSupported(reason) => Fault::Unfit(reason.into()),
        // Some words of the crate say less than is known.
        Error::Invalid(reason) if reason == "reference to missing bytes" => {
            Fault::Damaged("the file ends too early".into())
        }
        Error::Invalid(reason) if reason == "missing or invalid compression attribute" => {
            Fault::Unfit("its compression is not supported".into())
        }
        Error::Invalid(reason) => Fault::Damaged(format!("its header is wrong ({reason})")),
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
        let nothing = Image::from_planes(data_window, display_window, Default::default());
        Image { channels, metadata, ..nothing }
    }

    fn read(file: impl Read + Seek, layer: Option<&str>) -> Result<Image, Fault> {
        Ok(open(file, layer)?.read(&MemoryBudget::new(1 << 32))?.0)
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
        let read = read(Cursor::new(bytes(&image)), None).unwrap();
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
                read(Cursor::new(file), None).unwrap().channels
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
    fn reads_a_layer_by_its_name() {
        let image = sample();
        let one = read(Cursor::new(bytes(&image)), Some("albedo")).unwrap();
        assert_eq!(bits(&one), [("Y", bits(&image).pop().unwrap().1)]);
        assert_eq!((one.data_window, one.display_window), (image.data_window, image.display_window));
        assert_eq!(one.metadata, image.metadata);
        assert_eq!(one.layers, ["Tiefe \u{fc}", "albedo"]);

        let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 4)), ..Encoding::SMALL_LOSSLESS };
        let half = FlatSamples::F16((0..200u8).map(f16::from).collect());
        let file = layers(tiles, [("Z", FlatSamples::U32((0..200).collect())), ("n.Z", half)]);
        for name in ["layer 0", "Z", "layer 0.Z", "layer 1.n", "n", "n.Z"] {
            let channels = read(Cursor::new(&file), Some(name)).unwrap().channels;
            assert_eq!(
                channels,
                [Channel { name: "Y".into(), samples: (0..200u8).map(f32::from).collect() }]
            );
        }
    }

    #[test]
    fn names_the_layers_there_are() {
        let check = |names: &[String], expected: &str| {
            let channel = |name: &String| Channel { name: name.clone(), samples: vec![0.0] };
            let window = Window { x: 0, y: 0, width: 1, height: 1 };
            let mut image = Image::from_rgb(window, window, &[[0.0; 3]]);
            image.channels.extend(names.iter().map(channel));
            match read(Cursor::new(bytes(&image)), Some("x")) {
                Err(Fault::Unfit(reason)) => assert_eq!(reason, expected),
                other => panic!("{other:?}"),
            }
        };
        check(&[], "it has no layers, so `x` does not exist");
        check(&["b.Z".into(), "a\n.Z".into()], "it has no layer `x`; its layers are a\\n, b");
        let many: Vec<String> = (1000..6000).map(|i| format!("{i}.Z")).collect();
        let first = (1000..1020).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
        check(&many, &format!("it has no layer `x`; its layers are {first} and 4980 more"));
    }

    #[test]
    fn refuses_damaged_files() {
        let file = bytes(&sample());
        let numbers = FlatSamples::F32((0..200u8).map(f32::from).collect());
        let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 4)), ..Encoding::SMALL_LOSSLESS };
        let two = [("Y", numbers.clone()), ("n.Z", numbers)];
        for file in [&file, &layers(tiles, two.clone()), &layers(Encoding::UNCOMPRESSED, two)] {
            for end in 0..file.len() {
                for layer in [Some("n"), Some("albedo"), None] {
                    match (end, layer, read(Cursor::new(&file[..end]), layer)) {
                        (..4, _, Err(Fault::Foreign(None))) | (4.., _, Err(Fault::Damaged(_))) => {}
                        (_, Some(_), Err(Fault::Unfit(reason))) => assert!(reason.contains("no layer")),
                        // The first part may be whole without the second.
                        (_, None, Ok(image)) => assert_eq!(image.channels.len(), 1),
                        other => panic!("{other:?}"),
                    }
                }
            }
        }
        assert!(matches!(read(Cursor::new(b"P6 1 1 255\n..."), None), Err(Fault::Foreign(None))));

        // The upper corner of the data window, as it stands in the file.
        let corner = file.windows(10).position(|bytes| bytes == b"dataWindow").unwrap() + 10 + 1 + 6 + 4 + 8;
        let check = |x: i32, y: i32, expected: &str| {
            let mut file = file.clone();
            file[corner..corner + 8].copy_from_slice(&[x.to_le_bytes(), y.to_le_bytes()].concat());
            let error = format!("{:?}", read(Cursor::new(file), None).unwrap_err());
            assert!(error.contains(expected), "{x} {y}: {error}");
        };
        // The crate swaps corners that are the wrong way round; then the data do not fit.
        check(-100, 46, "Damaged");
        check(-4, 46, "Damaged");
        check(1, 1_000_000, "Damaged");
        check(1_000_000, 46, "too short");
        check(10_000_000, 46, "the file is too short");
        check(i32::MAX, i32::MAX, "Damaged");
        check(i32::MIN, i32::MIN, "Damaged");
    }

    /// The file with other bytes after the first place of the words, which end in NUL each.
    fn patched(file: &[u8], words: &str, at: usize, bytes: &[u8]) -> Vec<u8> {
        let words = words.replace(' ', "\0") + "\0";
        let place = file.windows(words.len()).position(|window| window == words.as_bytes()).unwrap();
        let start = place + words.len() + at;
        [&file[..start], bytes, &file[start + bytes.len()..]].concat()
    }

    fn refuses(file: Vec<u8>, expected: &str) {
        let error = format!("{:?}", read(Cursor::new(file), None).unwrap_err());
        assert!(error.contains(expected), "{error} instead of {expected}");
    }

    /// Two parts of tiles.
    fn tiled() -> Vec<u8> {
        let numbers = FlatSamples::F32((0..200u8).map(f32::from).collect());
        let tiles = Encoding { blocks: Blocks::Tiles(Vec2(8, 4)), ..Encoding::SMALL_LOSSLESS };
        layers(tiles, [("Y", numbers.clone()), ("Z", numbers)])
    }

    #[test]
    fn refuses_what_headers_claim() {
        let file = tiled();
        // An attribute is its name, its type, the length of its value, and its value.
        let patch = |attribute, at, number: i32| patched(&file, attribute, at, &number.to_le_bytes());
        for length in [i32::MAX, 1 << 30, 100_000] {
            refuses(patch("compression compression", 0, length), "the file ends too early");
        }
        refuses(patch("compression compression", 0, -1), "attribute size");
        for (code, expected) in [(8, "DWA"), (9, "DWA"), (10, "HTJ2K"), (11, "HTJ2K"), (12, "not supported")]
        {
            refuses(patched(&file, "compression compression", 4, &[code]), expected);
        }
        refuses(patched(&file, "channels chlist", 4, &[0]), "at least one channel");
        refuses(patch("channels chlist", 4 + 2 + 8, 2), "channel `Y` is subsampled");
        refuses(patch("tiles tiledesc", 4, 0), "tile size");
        refuses(patch("tiles tiledesc", 4, -1), "tile size");
        refuses(patch("tiles tiledesc", 4, (1 << 30) - 2), "Damaged");
        refuses(patch("tiles tiledesc", 8, (1 << 30) - 2), "Damaged");
        refuses(patch("tiles tiledesc", 4, 1), "Damaged");
        for number in [i32::MIN, -(1 << 30), 1 << 28, 1 << 29, 1 << 30, i32::MAX] {
            for corner in [4, 8, 12, 16] {
                refuses(patch("dataWindow box2i", corner, number), "");
                // No pixel depends on it.
                let result = read(Cursor::new(patch("displayWindow box2i", corner, number)), None);
                assert!(matches!(result, Ok(_) | Err(Fault::Damaged(_))), "{result:?}");
            }
        }
        let scan_lines = bytes(&sample());
        let at = scan_lines.windows(17).position(|window| window == b"\x0d\0\0\0scanlineimage").unwrap();
        let deep = [&scan_lines[..at], b"\x0c\0\0\0deepscanline", &scan_lines[at + 17..]].concat();
        refuses(deep, "deep data");
    }

    #[test]
    fn refuses_what_blocks_claim() {
        let file = tiled();
        let mut headers = Cursor::new(&file);
        MetaData::read_from_buffered(&mut headers, false).unwrap();
        let table = headers.position() as usize;
        let write = |at: usize, bytes: &[u8]| [&file[..at], bytes, &file[at + bytes.len()..]].concat();
        for (offset, expected) in [
            (0, "a block is missing"),
            (1, ""),
            (file.len() as u64 - 1, "the file ends too early"),
            (file.len() as u64, "the file ends too early"),
            (u64::MAX, "the file ends too early"),
        ] {
            refuses(write(table, &offset.to_le_bytes()), expected);
        }
        // Two times the same block.
        refuses(write(table, &file[table + 8..table + 16]), "a block is missing");

        // A block is its part, column, row, two levels and its length.
        let block = u64::from_le_bytes(file[table..table + 8].try_into().unwrap()) as usize;
        for (at, number, expected) in [
            (0, 1, "a block is missing"),
            (4, 3, "a block is missing"),
            (4, -1, "a block is missing"),
            (8, i32::MAX, "a block is missing"),
            (12, 1, "a block is missing"),
            (20, -1, "the file ends too early"),
            (20, i32::MAX, "the file ends too early"),
            (20, 8 * 4 * 4 + 1, "the length of a block is wrong"),
            (20, 0, "a block cannot be decompressed"),
            (24, 0, "a block cannot be decompressed"),
        ] {
            refuses(write(block + at, &i32::to_le_bytes(number)), expected);
        }
    }

    #[test]
    fn parts_need_no_names() {
        let mut file = tiled();
        for _ in 0..2 {
            let at = file.windows(12).position(|window| window == b"name\0string\0").unwrap();
            file[at] = b'g';
        }
        let image = read(Cursor::new(file), None).unwrap();
        assert_eq!(image.channels[0].name, "Y");
        assert_eq!(image.layers, ["Z"]);
    }
}
