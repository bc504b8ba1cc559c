//! What all charts share: two file formats, a font, colors, and logarithmic axes.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, LogCoord, WithKeyPoints};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// For text.
pub(crate) const FONT: &str = "sans-serif";
/// Colors that differ for all kinds of sight (Okabe and Ito, 2008). Black is left for what matters most.
pub(crate) const COLORS: [u32; 8] =
    [0xd55e00, 0x0072b2, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9, 0x999999, 0xb5a600];

/// One of the colors; they repeat.
pub(crate) fn color(index: usize) -> RGBColor {
    let [_, r, g, b] = COLORS[index % COLORS.len()].to_be_bytes();
    RGBColor(r, g, b)
}

/// A picture of lines and text in two formats.
#[derive(Debug)]
pub struct Plot {
    /// An SVG file.
    pub svg: String,
    /// Red, green and blue, row by row.
    pixels: Vec<u8>,
    /// Width and height of `pixels`.
    size: (u32, u32),
}

/// A format, whose errors can be kept.
pub(crate) trait Backend: DrawingBackend<ErrorType: 'static> {}

impl<T: DrawingBackend<ErrorType: 'static>> Backend for T {}

/// What can be drawn in either format.
pub(crate) trait Drawing {
    /// Draws; all lengths times `unit`.
    fn draw<B: Backend>(&self, area: &DrawingArea<B, Shift>, unit: u32) -> Result<(), Box<dyn Error>>;
}

impl Plot {
    /// Draws in both formats: as SVG of this size, and as pixels of `unit` times that size.
    pub(crate) fn new(drawing: &impl Drawing, size: (u32, u32), unit: u32) -> Result<Plot, Box<dyn Error>> {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font is damaged")?;
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        drawing.draw(&area, 1)?;
        area.present()?;
        drop(area);
        let size = (size.0 * unit, size.1 * unit);
        let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        drawing.draw(&area, unit)?;
        area.present()?;
        drop(area);
        Ok(Plot { svg, pixels, size })
    }

    /// A PNG file.
    ///
    /// # Errors
    ///
    /// Those of the PNG library; none is known.
    pub fn png(&self) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.size.0, self.size.1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(&self.pixels)?;
        Ok(file)
    }
}

/// From the least to the most, with room at both ends. `None` if there is nothing that a logarithmic axis can show.
pub(crate) fn range(values: &[f64], room: f64) -> Option<Range<f64>> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    (least > 0.0 && least <= most && most.is_finite()).then(|| least / room..most * room)
}

/// Powers of ten within a range, at most about ten of them.
pub(crate) fn powers(range: &Range<f64>) -> Vec<f64> {
    let (first, last) = (range.start.log10().ceil() as i32, range.end.log10().floor() as i32);
    let step = ((last - first) / 9 + 1) as usize;
    (first..=last).step_by(step).filter_map(|exponent| format!("1e{exponent}").parse().ok()).collect()
}

/// A logarithmic axis with these marks. Those that the library chooses take forever over hundreds of decades.
pub(crate) fn axis(range: &Range<f64>, marks: Vec<f64>) -> WithKeyPoints<LogCoord<f64>> {
    range.clone().log_scale().with_key_points(marks)
}

/// As in 1e-7, 0.01, 10 and 1e6.
pub(crate) fn number(x: f64) -> String {
    if (0.01..10_000.0).contains(&x) { format!("{x}") } else { format!("{x:e}") }
}

/// A number as it is, as in 0.005, 20 and 1e-5.
pub fn plain(x: f64) -> String {
    if (1e-4..1e5).contains(&x) { format!("{x}") } else { format!("{x:e}") }
}

/// A number with so many significant digits.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    // Rounded first, since 9.99 becomes 10.
    let rounded: f64 = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    let magnitude = rounded.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        return format!("{rounded:e}");
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{rounded:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_those_of_logarithmic_axes() {
        assert_eq!(range(&[2.0, 8.0, 4.0], 2.0), Some(1.0..16.0));
        assert_eq!(
            [range(&[], 2.0), range(&[0.0, 1.0], 2.0), range(&[1.0, f64::INFINITY], 2.0)],
            [None, None, None]
        );
        assert_eq!(powers(&(0.02..300.0)), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!(powers(&(1e-200..1e200)).len(), 9);
    }

    #[test]
    fn numbers_have_the_digits_asked_for() {
        let cases =
            [(0.012345, "0.0123"), (9.999, "10.0"), (1234.5, "1230"), (0.5, "0.500"), (-2.0, "-2.00")];
        for (x, expected) in cases {
            assert_eq!(significant(x, 3), expected);
        }
        assert_eq!(significant(1.234e-7, 3), "1.23e-7");
        assert_eq!(significant(0.0, 3), "0");
    }
}
