//! Results of other renderers.

use lookat_image::{Means, means};

/// What another renderer has reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// The wall time that it was given with, in seconds.
    pub seconds: f64,
    /// The errors of its picture.
    pub means: Means,
    /// Its picture is stored as integers: rounded, and cut to what a display shows.
    pub rounded: bool,
}

impl Marker {
    /// Measures a picture.
    pub fn new(
        name: &str,
        seconds: f64,
        pixels: &[[f32; 3]],
        rounded: bool,
        reference: &[[f32; 3]],
    ) -> Marker {
        Marker { name: name.into(), seconds, means: means(pixels, reference), rounded }
    }
}
