//! Writes OpenEXR files.

use std::io::{Seek, Write};

use ::exr::error::Error;
use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer};
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};

use super::METADATA;
use crate::error::Fault;
use crate::{Channel, Image, Window};

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
    let image = ::exr::image::Image::new(attributes, layer);
    // The crate starts threads of its own, where the process has one, for lack of memory or by choice.
    let writer = match rayon::current_num_threads() {
        1 => image.write().non_parallel(),
        _ => image.write(),
    };
    writer.to_buffered(out).map_err(|error| match error {
        Error::Io(error) => Fault::Io(error),
        Error::Invalid(reason) | Error::NotSupported(reason) => Fault::Unfit(reason.into()),
        Error::Aborted => Fault::Unfit("interrupted".into()),
    })
}

/// UTF-8, of which the crate's own conversion would keep only Latin-1.
fn text(words: &str) -> Text {
    Text::from_slice_unchecked(words.as_bytes())
}

fn bounds(window: Window) -> IntegerBounds {
    IntegerBounds::new((window.x, window.y), (window.width as usize, window.height as usize))
}
