//! Written files, read back; and files that are damaged or of other programs.

use super::*;
use ::exr::image::Blocks;
use ::exr::image::FlatSamples;
use std::io::Cursor;

fn sample() -> Image {
    let data_window = Window { x: -3, y: 7, width: 5, height: 40 };
    let display_window = Window { x: 0, y: 0, width: 64, height: 48 };
    let values = |seed: u32| (0..200).map(|i| f32::from_bits((i + seed).wrapping_mul(0x9e37_79b9))).collect();
    let channel = |(i, name): (usize, &&str)| Channel { name: name.to_string(), samples: values(i as u32) };
    let channels = ["B", "G", "R", "Tiefe \u{fc}", "albedo.R"].iter().enumerate().map(channel).collect();
    let metadata = Some("{\"scene\": \"K\u{fc}che \u{1f600}\"}".to_string());
    let nothing = Image::from_planes(data_window, display_window, Default::default());
    Image { channels, metadata, ..nothing }
}

fn read(file: impl Read + Seek, layer: Option<&str>) -> Result<Image, ImageFault> {
    let Opened { metadata, read, .. } = open(file, layer)?;
    Ok(Image { metadata, ..read(&MemoryBudget::new(1 << 32), false)?.0.into() })
}

fn bytes(image: &Image) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write(image, true, &mut out).unwrap();
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
    for encoding in [Encoding::UNCOMPRESSED, Encoding::SMALL_LOSSLESS, Encoding::FAST_LOSSLESS, tiles, piz] {
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
        assert_eq!(channels, [Channel { name: "Y".into(), samples: (0..200u8).map(f32::from).collect() }]);
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
            Err(ImageFault::Refused(reason)) => assert_eq!(reason, expected),
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
                    (..4, _, Err(ImageFault::WrongFormat(None))) | (4.., _, Err(ImageFault::Damaged(_))) => {}
                    (_, Some(_), Err(ImageFault::Refused(reason))) => assert!(reason.contains("no layer")),
                    // The first part may be whole without the second.
                    (_, None, Ok(image)) => assert_eq!(image.channels.len(), 1),
                    other => panic!("{other:?}"),
                }
            }
        }
    }
    assert!(matches!(read(Cursor::new(b"P6 1 1 255\n..."), None), Err(ImageFault::WrongFormat(None))));

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
    for (code, expected) in [(8, "DWA"), (9, "DWA"), (10, "HTJ2K"), (11, "HTJ2K"), (12, "not supported")] {
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
            assert!(matches!(result, Ok(_) | Err(ImageFault::Damaged(_))), "{result:?}");
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
