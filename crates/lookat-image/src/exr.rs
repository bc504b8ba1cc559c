//! OpenEXR files, by the `exr` crate.

mod block;
mod layer;
#[cfg(test)]
mod tests;
#[cfg(feature = "write")]
pub(crate) mod write;

use std::io::{Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::compression::Compression;
use ::exr::error::Error;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::f16;

use crate::error::{Fault, listed};
use crate::image::{Placement, room};
use crate::{Channel, Charge, Image, MemoryBudget, Precision, Window};

use layer::Choice;

/// The one custom attribute, and the keyword of the text in a PNG file: the crate writes several attributes in random
/// order, so no two files would be alike.
pub(crate) const METADATA: &str = "lookat";

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

    pub fn metadata(&self) -> Option<String> {
        metadata(&self.meta.headers[self.choice.part])
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
    let data_window = window(header.data_window());
    let display_window = window(header.shared_attributes.display_window);
    let is_half = sources(header, choice).iter().any(|(_, kind)| *kind == SampleType::F16);
    let precision = if is_half { Precision::Half } else { Precision::Single };
    Ok(Image {
        data_window,
        display_window,
        channels,
        metadata: metadata(header),
        layers: Vec::new(),
        precision,
        has_windows: true,
    })
}

fn metadata(header: &Header) -> Option<String> {
    match header.own_attributes.other.get(METADATA.as_bytes()) {
        Some(AttributeValue::Text(text)) => Some(words(text)),
        _ => None,
    }
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

fn words(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn window(bounds: IntegerBounds) -> Window {
    // The crate has checked that both corners are in the range of i32.
    let (Vec2(x, y), Vec2(width, height)) = (bounds.position, bounds.size);
    Window { x, y, width: width as u32, height: height as u32 }
}
