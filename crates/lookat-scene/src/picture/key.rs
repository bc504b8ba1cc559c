//! The key of a decoded picture: its file and its settings.

use std::path::PathBuf;

use lookat_image::Wrap;

/// The settings for decoding a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub wrap: Wrap,
    /// True to convert from sRGB to linear.
    pub gamma: bool,
    /// The factor on the linear values.
    pub scale: f32,
    /// True if the first row is the bottom row, as in texture coordinates.
    pub bottom_up: bool,
    /// True to clamp negative values to 0, for pictures of light.
    pub not_negative: bool,
}

/// The file and its settings. Floats are stored as bits, for comparison.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    pub path: PathBuf,
    wrap: Wrap,
    gamma: bool,
    bottom_up: bool,
    not_negative: bool,
    scale: u32,
}

impl Key {
    pub fn new(path: PathBuf, settings: &Settings) -> Self {
        let Settings { wrap, gamma, scale, bottom_up, not_negative } = *settings;
        Key { path, wrap, gamma, bottom_up, not_negative, scale: scale.to_bits() }
    }
}
