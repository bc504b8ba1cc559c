//! Results of other renderers.

use lookat_image::means;

/// What another renderer has reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// The wall time that it was given with, in seconds.
    pub seconds: f64,
    /// The root mean squared error of its picture.
    pub rmse: f64,
    /// The relative mean squared error.
    pub relative_mse: f64,
    /// The mean signed error.
    pub error: f64,
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
        let means = means(pixels, reference);
        Marker {
            name: name.into(),
            seconds,
            rmse: means.rmse,
            relative_mse: means.relative_mse,
            error: means.error,
            rounded,
        }
    }
}
