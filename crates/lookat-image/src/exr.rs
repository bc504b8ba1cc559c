//! OpenEXR files, by the `exr` crate.

mod blocks;
mod layers;
#[cfg(test)]
mod tests;

use std::io::{Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::lines::LineRefMut;
use ::exr::compression::Compression;
use ::exr::error::Error;
use ::exr::image::write::WritableImage;
use ::exr::image::write::samples::{SamplesWriter, WritableSamples};
use ::exr::image::{AnyChannel, AnyChannels, Encoding, Layer};
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, LevelMode, SampleType, Text};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::prelude::f16;

use crate::error::listed;
use crate::format::{METADATA, Opened};
use crate::image::{Pixels, Placement};
use crate::{Channel, Charge, Image, ImageFault, IntegerChannel, MemoryBudget, Precision, Window};

/// Reads the headers, and finds the layer with this name, or else the picture that the file shows first.
pub(crate) fn open<'a>(
    mut file: impl Read + Seek + 'a,
    layer: Option<&str>,
) -> Result<Opened<'a>, ImageFault> {
    let mut magic = Vec::new();
    file.by_ref().take(4).read_to_end(&mut magic)?;
    if magic != ::exr::meta::magic_number::BYTES {
        return Err(ImageFault::WrongFormat(None));
    }
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    guarded(|| {
        let meta = MetaData::read_from_buffered(&mut file, false).map_err(header_fault)?;
        let parts = &meta.headers;
        if parts.is_empty() {
            return Err(ImageFault::Damaged("it has no channels".into()));
        }
        let layers = layers::names(parts);
        let choice = match layer {
            None => layers::default(parts),
            Some(name) => layers::find(parts, name).ok_or_else(|| unknown(name, &layers))?,
        };
        let header = &parts[choice.part];
        check(header, length)?;
        let [data_window, display_window] =
            [header.data_window(), header.shared_attributes.display_window].map(window);
        let placement = Placement { data_window, display_window, has_windows: true };
        let metadata = match header.own_attributes.other.get(METADATA.as_bytes()) {
            Some(AttributeValue::Text(text)) => Some(words(text)),
            _ => None,
        };
        let read = move |memory: &MemoryBudget, _: bool| {
            let header = &meta.headers[choice.part];
            let channel_bytes = 4 * choice.channels.len() as u64;
            let charge = data_window.reserve(channel_bytes, blocks::bytes(header), memory)?;
            guarded(|| {
                let sources = sources(header, &choice.channels);
                let blank = |(_, name): &(usize, String)| Channel::blank(name, data_window.area() as usize);
                let mut channels = choice.channels.iter().map(blank).collect::<Result<Vec<_>, _>>()?;
                blocks::read(&mut file, length, &meta, choice.part, |bounds, numbers| {
                    copy(header, bounds, numbers, &sources, &mut channels);
                })?;
                let is_half = sources.iter().any(|(_, sample_type)| *sample_type == SampleType::F16);
                let precision = if is_half { Precision::Half } else { Precision::Single };
                let image = Image { layers, precision, ..Image::new(placement, channels) };
                Ok((Pixels::Values(image), charge))
            })
        };
        Ok(Opened { placement, metadata, channels_of_bytes: None, read: Box::new(read) })
    })
}

/// Reads the channels of 32-bit integers in the first part.
pub(crate) fn read_integers(
    mut file: impl Read + Seek,
    memory: &MemoryBudget,
) -> Result<(Vec<IntegerChannel>, Charge), ImageFault> {
    let length = file.seek(SeekFrom::End(0))?;
    file.rewind()?;
    guarded(|| {
        let meta = MetaData::read_from_buffered(&mut file, false).map_err(header_fault)?;
        let header = meta.headers.first().ok_or_else(|| ImageFault::Damaged("it has no channels".into()))?;
        check(header, length)?;
        let window = window(header.data_window());
        let chosen: Vec<(usize, String)> = (0..)
            .zip(&header.channels.list)
            .filter(|(_, channel)| channel.sample_type == SampleType::U32)
            .map(|(at, channel)| (at, words(&channel.name)))
            .collect();
        let charge = window.reserve(4 * chosen.len() as u64, blocks::bytes(header), memory)?;
        let sources = sources(header, &chosen);
        let blank = |(_, name): (usize, String)| {
            let mut samples = Vec::new();
            samples.try_reserve_exact(window.area() as usize).map_err(std::io::Error::from)?;
            samples.resize(window.area() as usize, 0);
            Ok(IntegerChannel { name, samples })
        };
        let mut channels = chosen.into_iter().map(blank).collect::<Result<Vec<_>, ImageFault>>()?;
        blocks::read(&mut file, length, &meta, 0, |bounds, numbers| {
            for_each_row(header, bounds, numbers, |row, bytes| {
                for (channel, (before, _)) in channels.iter_mut().zip(&sources) {
                    let own = &mut channel.samples[row.clone()];
                    convert(own, &bytes[row.len() * before..], u32::from_ne_bytes);
                }
            });
        })?;
        Ok((channels, charge))
    })
}

/// Damaged B44 data make the crate panic where overflow is checked, as in a debug build; nothing else is known to. It then
/// holds nothing but the file.
fn guarded<T>(read: impl FnOnce() -> Result<T, ImageFault>) -> Result<T, ImageFault> {
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(ImageFault::Damaged("its parts contradict each other".into())))
}

fn unknown(name: &str, layers: &[String]) -> ImageFault {
    ImageFault::Refused(match layers {
        [] => format!("it has no layers, so `{name}` does not exist"),
        _ => format!("it has no layer `{name}`; its layers are {}", listed(layers)),
    })
}

/// Fails if the part is none that can be read, or a file of this length cannot contain it.
fn check(header: &Header, length: u64) -> Result<(), ImageFault> {
    let unfit = |reason: &str| Err(ImageFault::Refused(reason.into()));
    if header.deep {
        return unfit("deep data is not supported");
    }
    if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(ImageFault::Refused(format!(
            "channel `{}` is subsampled",
            words(&channel.name).escape_debug()
        )));
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
    if bytes > length.saturating_mul(blocks::DENSEST as u64) {
        let Window { width, height, .. } = window;
        return Err(ImageFault::Damaged(format!("the file is too short for {width} x {height} pixels")));
    }
    Ok(())
}

/// For each channel of a choice, the bytes of a pixel before it, and its type.
fn sources(header: &Header, choice: &[(usize, String)]) -> Vec<(usize, SampleType)> {
    let mut end = 0;
    let mut all = Vec::new();
    for channel in &header.channels.list {
        all.push((end, channel.sample_type));
        end += channel.sample_type.bytes_per_sample();
    }
    choice.iter().map(|(at, _)| all[*at]).collect()
}

/// Calls `take` for each row of a block, with the indices of its pixels in the channels, and its bytes.
fn for_each_row(
    header: &Header,
    bounds: IntegerBounds,
    numbers: &[u8],
    mut take: impl FnMut(Range<usize>, &[u8]),
) {
    let width = bounds.size.0;
    let first = bounds.position.1 as usize * header.layer_size.0 + bounds.position.0 as usize;
    for (y, bytes) in numbers.chunks_exact(width * header.channels.bytes_per_pixel).enumerate() {
        let start = first + y * header.layer_size.0;
        take(start..start + width, bytes);
    }
}

/// Copies one block to its place in the channels.
fn copy(
    header: &Header,
    bounds: IntegerBounds,
    numbers: &[u8],
    sources: &[(usize, SampleType)],
    channels: &mut [Channel],
) {
    for_each_row(header, bounds, numbers, |own, bytes| {
        for (channel, (before, sample_type)) in channels.iter_mut().zip(sources) {
            let row = &mut channel.samples[own.clone()];
            let bytes = &bytes[own.len() * before..];
            match sample_type {
                SampleType::F16 => convert(row, bytes, |two| f16::from_ne_bytes(two).to_f32()),
                SampleType::F32 => convert(row, bytes, f32::from_ne_bytes),
                SampleType::U32 => convert(row, bytes, |four| u32::from_ne_bytes(four) as f32),
            }
        }
    });
}

fn convert<T, const N: usize>(row: &mut [T], bytes: &[u8], number: impl Fn([u8; N]) -> T) {
    for (sample, bytes) in row.iter_mut().zip(bytes.as_chunks().0) {
        *sample = number(*bytes);
    }
}

fn header_fault(error: Error) -> ImageFault {
    match error {
        Error::Io(error) => error.into(),
        Error::NotSupported(reason) => ImageFault::Refused(reason.into()),
        // Some words of the crate say less than is known.
        Error::Invalid(reason) if reason == "reference to missing bytes" => {
            ImageFault::Damaged("the file ends too early".into())
        }
        Error::Invalid(reason) if reason == "missing or invalid compression attribute" => {
            ImageFault::Refused("its compression is not supported".into())
        }
        Error::Invalid(reason) => ImageFault::Damaged(format!("its header is wrong ({reason})")),
        Error::Aborted => ImageFault::Damaged("reading was interrupted".into()),
    }
}

/// Writes all channels, in 32-bit float or as 32-bit integers.
pub(crate) fn write<'i>(
    image: &'i Image,
    is_compressed: bool,
    out: impl Write + Seek,
) -> Result<(), ImageFault> {
    let plane = |channel: &'i Channel| AnyChannel::new(text(&channel.name), Plane::F32(&channel.samples));
    let integers =
        |channel: &'i IntegerChannel| AnyChannel::new(text(&channel.name), Plane::U32(&channel.samples));
    let all = image.channels.iter().map(plane).chain(image.integers.iter().map(integers));
    let channels = AnyChannels::sort(all.collect());

    let data = bounds(image.data_window);
    let attributes = LayerAttributes { layer_position: data.position, ..LayerAttributes::default() };
    let encoding = if is_compressed { Encoding::SMALL_LOSSLESS } else { Encoding::UNCOMPRESSED };
    let layer = Layer::new(data.size, attributes, encoding, channels);

    let mut attributes = ImageAttributes::new(bounds(image.display_window));
    if let Some(metadata) = &image.metadata {
        attributes.other.insert(text(METADATA), AttributeValue::Text(text(metadata)));
    }
    let image = ::exr::image::Image::new(attributes, layer);
    // The crate starts threads of its own, where the process has one, for lack of memory or by choice.
    let writer = match rayon::current_num_threads() {
        1 => image.write().non_parallel(),
        _ => image.write(),
    };
    writer.to_buffered(out).map_err(|error| match error {
        Error::Io(error) => error.into(),
        Error::Invalid(reason) | Error::NotSupported(reason) => ImageFault::Refused(reason.into()),
        Error::Aborted => ImageFault::Refused("interrupted".into()),
    })
}

/// The values of a channel, where they are.
#[derive(Clone, Copy)]
enum Plane<'i> {
    F32(&'i [f32]),
    U32(&'i [u32]),
}

impl<'s, 'i: 's> WritableSamples<'s> for Plane<'i> {
    type Writer = PlaneWriter<'i>;

    fn sample_type(&self) -> SampleType {
        match self {
            Plane::F32(_) => SampleType::F32,
            Plane::U32(_) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'s self, header: &Header) -> PlaneWriter<'i> {
        PlaneWriter { plane: *self, width: header.layer_size.width() }
    }
}

/// Gives the lines of a channel.
struct PlaneWriter<'i> {
    plane: Plane<'i>,
    width: usize,
}

impl SamplesWriter for PlaneWriter<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let Vec2(x, y) = line.location.position;
        let first = y * self.width + x;
        let own = first..first + line.location.sample_count;
        match self.plane {
            Plane::F32(samples) => line.write_samples_from_slice(&samples[own]),
            Plane::U32(samples) => line.write_samples_from_slice(&samples[own]),
        }
        .expect("a line has room for its samples");
    }
}

/// UTF-8, of which the crate's own conversion would keep only Latin-1.
fn text(words: &str) -> Text {
    Text::from_slice_unchecked(words.as_bytes())
}

fn bounds(window: Window) -> IntegerBounds {
    IntegerBounds::new((window.x, window.y), (window.width as usize, window.height as usize))
}

fn words(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn window(bounds: IntegerBounds) -> Window {
    // The crate has checked that both corners are in the range of i32.
    let (Vec2(x, y), Vec2(width, height)) = (bounds.position, bounds.size);
    Window { x, y, width: width as u32, height: height as u32 }
}
