//! Pictures as messages.

use tungstenite::Message;

/// What a picture is.
#[derive(Debug, Clone, Copy)]
pub struct About {
    /// Counts the views.
    pub generation: u32,
    /// The number of the page's request that the view follows, or of the layer.
    pub number: u32,
    /// Samples of all pixels, done and in all.
    pub done: u64,
    pub total: u64,
    /// The time since this rendering began.
    pub seconds: f64,
    pub content: Content,
}

/// What the numbers of a picture stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Content {
    /// Colors of a picture that is not finished.
    Growing,
    /// Colors of the picture that `render` makes.
    Finished,
    Reference,
    Layer,
    Errors,
}

/// The bytes before the pixels of a picture: eight numbers.
const HEADER: usize = 64;

/// A picture as a message: width, height and `about` as `f64`, then three values of each pixel as `f32`, of colors linear red,
/// green and blue. Little-endian.
pub fn pixels([width, height]: [u32; 2], values: &[[f32; 3]], about: About) -> Message {
    let About { generation, number, done, total, seconds, content } = about;
    let header = [
        f64::from(width),
        f64::from(height),
        f64::from(generation),
        f64::from(number),
        done as f64,
        total as f64,
        seconds,
        f64::from(content as u8),
    ];
    let mut bytes = vec![0; HEADER + 12 * values.len()];
    let (head, body) = bytes.split_at_mut(HEADER);
    head.copy_from_slice(header.map(f64::to_le_bytes).as_flattened());
    for (place, value) in body.chunks_exact_mut(4).zip(values.as_flattened()) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    Message::binary(bytes)
}
