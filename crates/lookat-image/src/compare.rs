//! Compares two pictures in the pixels that both have: metrics, tests against noise, and a figure of the difference.

mod agreement;
mod display;
mod flip;
mod metrics;
mod noise;
mod panel;
mod ssim;
#[cfg(test)]
mod tests;

use crate::error::listed;
use crate::{Image, PixelError, Placement, Precision, Window};

pub use agreement::{Agreement, PixelTest, Test, Untestable, agreement};
pub use display::{Encoded, Light, suitable_exposure};
pub use flip::{PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
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
    /// Where they lie.
    pub window: Window,
    /// Linear RGB of the first picture, row by row over `window`.
    pub actual: Vec<[f32; 3]>,
    /// Linear RGB of the second.
    pub expected: Vec<[f32; 3]>,
    /// How noisy the pixels of the first picture are, if it says so.
    pub actual_errors: Option<Vec<PixelError>>,
    /// The same of the second.
    pub expected_errors: Option<Vec<PixelError>>,
    /// Of the picture that is stored less finely.
    pub precision: Precision,
    /// How many pixels of either picture the other does not have.
    pub left_out: u64,
    /// Which of the pictures does not say where it lies, and is taken for the part that the other is.
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

/// The pixels that both pictures have, by their data windows. Alpha takes no part. A picture that does not say where it lies
/// is taken for the part of the other that has its size.
///
/// Fails if the full pictures differ in size, the data windows do not overlap, or a picture has no colors.
pub fn align(actual: &Image, expected: &Image) -> Result<Aligned, AlignError> {
    let placements = [actual.placement(), expected.placement()];
    let window = common_window(placements)?;
    let [a, b] = placed(placements).map(|placement| placement.data_window);
    let is_placed = [a != actual.data_window, b != expected.data_window];
    let left_out = a.area() + b.area() - 2 * window.area();
    let colors =
        |image: &Image, which| image.rgb().ok_or_else(|| AlignError::Channels(which, instead(image)));
    let errors = |image: &Image, data| image.errors().map(|errors| cut(errors, data, window));
    Ok(Aligned {
        window,
        actual_errors: errors(actual, a),
        expected_errors: errors(expected, b),
        actual: cut(colors(actual, "first")?, a, window),
        expected: cut(colors(expected, "second")?, b, window),
        precision: actual.precision.min(expected.precision),
        left_out,
        is_placed,
    })
}

/// The pixels that two pictures have in common, by their headers; fails as [`align`].
pub fn common_window(placements: [Placement; 2]) -> Result<Window, AlignError> {
    let [a, b] = placed(placements);
    if a.display_window.size() != b.display_window.size() {
        return Err(AlignError::Size(a.display_window.size(), b.display_window.size()));
    }
    common(a.data_window, b.data_window).ok_or(AlignError::Apart)
}

/// A picture that does not say where it lies takes the place of the other one, if it has its size.
fn placed([a, b]: [Placement; 2]) -> [Placement; 2] {
    let placed = |own: Placement, other: Placement| {
        let is_part = own.data_window.size() == other.data_window.size();
        if !own.has_windows && is_part { other } else { own }
    };
    [placed(a, b), placed(b, a)]
}

/// What a picture without colors has instead.
fn instead(image: &Image) -> String {
    if image.layers.is_empty() {
        let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
        format!("it has {}", listed(&names))
    } else {
        format!("it has the layers {}", listed(&image.layers))
    }
}

/// What both windows cover.
fn common(a: Window, b: Window) -> Option<Window> {
    let span = |a: i32, a_size: u32, b: i32, b_size: u32| {
        let start = i64::from(a.max(b));
        let end = (i64::from(a) + i64::from(a_size)).min(i64::from(b) + i64::from(b_size));
        u32::try_from(end - start).ok().filter(|size| *size > 0)
    };
    let (width, height) = (span(a.x, a.width, b.x, b.width)?, span(a.y, a.height, b.y, b.height)?);
    Some(Window { x: a.x.max(b.x), y: a.y.max(b.y), width, height })
}

/// The part of a picture that lies in `part`, which lies in `whole`.
fn cut<T: Copy>(pixels: Vec<T>, whole: Window, part: Window) -> Vec<T> {
    if whole == part {
        return pixels;
    }
    let (left, top) = ((part.x - whole.x) as usize, (part.y - whole.y) as usize);
    let rows = pixels.chunks_exact(whole.width as usize).skip(top).take(part.height as usize);
    rows.flat_map(|row| &row[left..left + part.width as usize]).copied().collect()
}
