//! A picture for a terminal.

use std::fmt::Display;
use std::io::Write;

use crate::args::Protocol;

/// A picture as it is drawn.
pub struct Drawing {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Columns and lines of the terminal.
    pub cells: [u32; 2],
    /// On the sRGB curve, row by row.
    pub pixels: Vec<[u8; 3]>,
    /// The number of the picture.
    pub id: u32,
    pub protocol: Protocol,
}

/// Appends a text.
pub fn put(out: &mut Vec<u8>, text: impl Display) {
    let _ = write!(out, "{text}");
}
