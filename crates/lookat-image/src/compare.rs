//! Compares two pictures in the pixels that both have: metrics, tests against noise, and a figure of the difference.

mod agreement;
mod comparison;
mod display;
mod flip;
mod metric;
mod metrics;
mod noise;
mod panel;
mod ssim;
#[cfg(test)]
mod tests;

use crate::error::listed;
use crate::{Image, PixelError, Placement, Precision, Window};

pub use agreement::{Agreement, PixelTest, Test, Untestable, agreement};
pub use comparison::{
    Comparison, Noise, NoiseTest, NotFinite, PixelNoise, Rules, SIGNIFICANCE, differences, significance,
    undecided,
};
pub use display::{Encoded, Light, suitable_exposure};
pub use flip::{PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
pub use metric::{
    COLORS, Limit, Measured, Measurement, Metric, THRESHOLD, measure, not_finite, number, place, value_of,
    why_not,
};
pub use metrics::{
    Largest, Means, largest_difference, mean, means, percentile_difference, psnr, relative_mse_trimmed, rmse,
    share_above,
};
pub use panel::false_color::{
    DIFFERENCE_COLORS, NOT_FINITE_COLOR, box_means, difference_color, difference_limit,
};
pub use panel::{PanelOptions, write_panel};
pub use ssim::ssim;

/// The pixels that two pictures share.
#[derive(Debug, Clone)]
pub struct Aligned {
    /// The common window.
    pub window: Window,
    /// Linear RGB of the first picture, row by row over `window`.
    pub actual: Vec<[f32; 3]>,
    /// Linear RGB of the second picture, row by row over `window`.
    pub expected: Vec<[f32; 3]>,
    /// The noise of the first picture, if it has error layers.
    pub actual_errors: Option<Vec<PixelError>>,
    /// The noise of the second picture, if it has error layers.
    pub expected_errors: Option<Vec<PixelError>>,
    /// The lower precision of both pictures.
    pub precision: Precision,
    /// The number of pixels that only one picture has.
    pub left_out: u64,
    /// For each picture: true if it has no windows of its own, and was placed at the window of the other one.
    pub is_placed: [bool; 2],
}

/// Why two pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AlignError {
    /// The full pictures are not of one size.
    #[error("the sizes differ: {}x{} and {}x{}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// The data windows do not overlap.
    #[error("the data windows of the two pictures have no pixel in common")]
    Apart,
    /// A picture has neither R, G and B nor Y. Says which of the two, and what there is instead.
    #[error("the {0} picture has neither the channels R, G and B nor Y: {1}")]
    Channels(&'static str, String),
}

/// Cuts two pictures to the pixels that both have, by their data windows. Alpha is ignored. A picture without windows of its own is
/// placed at the data window of the other one, if both have the same size.
///
/// # Errors
///
/// The full pictures differ in size, the data windows do not overlap, or a picture has no colors.
pub fn align(actual: &Image, expected: &Image) -> Result<Aligned, AlignError> {
    let placements = [actual.placement(), expected.placement()];
    let window = common_window(placements)?;
    let [a, b] = placed(placements).map(|placement| placement.data_window);
    let is_placed = [a != actual.data_window, b != expected.data_window];
    let left_out = a.area() + b.area() - 2 * window.area();
    let colors =
        |image: &Image, which| image.rgb().ok_or_else(|| AlignError::Channels(which, contents(image)));
    let errors = |image: &Image, data: Window| image.errors().map(|errors| data.cut(errors, window));
    Ok(Aligned {
        window,
        actual_errors: errors(actual, a),
        expected_errors: errors(expected, b),
        actual: a.cut(colors(actual, "first")?, window),
        expected: b.cut(colors(expected, "second")?, window),
        precision: actual.precision.min(expected.precision),
        left_out,
        is_placed,
    })
}

/// The pixels that two pictures have in common, by their headers.
///
/// # Errors
///
/// The full pictures differ in size, or the data windows do not overlap.
pub fn common_window(placements: [Placement; 2]) -> Result<Window, AlignError> {
    let [a, b] = placed(placements);
    if a.display_window.size() != b.display_window.size() {
        return Err(AlignError::Size(a.display_window.size(), b.display_window.size()));
    }
    a.data_window.intersection(b.data_window).ok_or(AlignError::Apart)
}

/// Places a picture without windows of its own at the data window of the other one, if both have the same size.
fn placed([a, b]: [Placement; 2]) -> [Placement; 2] {
    let placed = |own: Placement, other: Placement| {
        let is_part = own.data_window.size() == other.data_window.size();
        if !own.has_windows && is_part { other } else { own }
    };
    [placed(a, b), placed(b, a)]
}

/// The channels or layers of a picture without colors.
fn contents(image: &Image) -> String {
    if image.layers.is_empty() {
        let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
        format!("it has {}", listed(&names))
    } else {
        format!("it has the layers {}", listed(&image.layers))
    }
}
