//! Lines, marks and text at places of the chart.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use crate::plot::{Backend, COLORS, FONT, color};

/// Where things are drawn. Sizes and offsets are in units, places in seconds and error.
pub(super) struct Canvas<'a, B: Backend> {
    pub area: &'a DrawingArea<B, Shift>,
    /// Pixels for each unit.
    pub unit: i32,
    /// The pixels that show places.
    pub x: Range<i32>,
    /// The same upwards.
    pub y: Range<i32>,
    /// The pixel of a place.
    pub place: &'a dyn Fn((f64, f64)) -> (i32, i32),
}

/// How a line looks. Lengths are in units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub color: RGBColor,
    pub width: u32,
    /// The lengths of a dash and of a gap; `None` if the line is solid.
    pub dashes: Option<[i32; 2]>,
}

/// How a method looks: its points by color and form, since either may not be seen, and its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub stroke: Stroke,
    form: &'static [(f64, f64)],
}

/// Lines differ by color first. Where colors repeat, they differ by these.
const DASHES: [Option<[i32; 2]>; 3] = [None, Some([6, 4]), Some([2, 3])];
/// The width of lines of methods.
const WIDTH: u32 = 2;

/// Forms about the middle, each of about the same area.
const FORMS: [&[(f64, f64)]; 6] = [
    // Nearly a circle.
    &[(1.0, 0.4), (0.4, 1.0), (-0.4, 1.0), (-1.0, 0.4), (-1.0, -0.4), (-0.4, -1.0), (0.4, -1.0), (1.0, -0.4)],
    &[(0.9, 0.9), (-0.9, 0.9), (-0.9, -0.9), (0.9, -0.9)],
    &[(0.0, -1.3), (1.15, 0.8), (-1.15, 0.8)],
    &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
    &[(0.0, 1.3), (-1.15, -0.8), (1.15, -0.8)],
    &[(0.0, -1.2), (1.15, -0.35), (0.7, 1.0), (-0.7, 1.0), (-1.15, -0.35)],
];
/// For other renderers: a star.
const STAR: &[(f64, f64)] = &[
    (0.0, -1.9),
    (0.45, -0.6),
    (1.8, -0.6),
    (0.72, 0.25),
    (1.1, 1.55),
    (0.0, 0.75),
    (-1.1, 1.55),
    (-0.72, 0.25),
    (-1.8, -0.6),
    (-0.45, -0.6),
];
/// Half the width of a mark.
const MARK: f64 = 4.0;

impl Look {
    /// That of other renderers.
    pub const OTHER: Look = Look { stroke: Stroke { color: BLACK, width: WIDTH, dashes: None }, form: STAR };

    /// That of a method.
    pub fn of(method: usize) -> Look {
        let dashes = DASHES[method / COLORS.len() % DASHES.len()];
        Look {
            stroke: Stroke { color: color(method), width: WIDTH, dashes },
            form: FORMS[method % FORMS.len()],
        }
    }
}

impl<B: Backend> Canvas<'_, B> {
    /// A line through places.
    pub fn line(&self, places: &[(f64, f64)], stroke: Stroke) -> Result<(), Box<dyn Error>> {
        self.line_at(places.iter().map(|at| (self.place)(*at)).collect(), stroke)
    }

    /// The same through pixels. A single one is drawn as a dot.
    pub fn line_at(&self, pixels: Vec<(i32, i32)>, stroke: Stroke) -> Result<(), Box<dyn Error>> {
        let style = stroke.color.stroke_width(stroke.width * self.unit as u32);
        if let [only] = pixels[..] {
            let radius = stroke.width as i32 * self.unit / 2;
            self.area.draw(&Circle::new(only, radius, stroke.color.filled()))?;
        }
        match stroke.dashes.map(|lengths| lengths.map(|length| length * self.unit)) {
            Some([dash, gap]) => self.area.draw(&DashedPathElement::new(pixels, dash, gap, style))?,
            None => self.area.draw(&PathElement::new(pixels, style))?,
        }
        Ok(())
    }

    /// An interval, as far as it is in the chart, with caps where it ends within and is wider than a mark.
    pub fn bar(&self, low: (f64, f64), high: (f64, f64), color: RGBColor) -> Result<(), Box<dyn Error>> {
        if !(low.0 > 0.0 && low.1 > 0.0) {
            return Ok(());
        }
        let within =
            |(x, y): (i32, i32)| (x.clamp(self.x.start, self.x.end), y.clamp(self.y.start, self.y.end));
        let ends = [(self.place)(low), (self.place)(high)];
        let [from, to] = ends.map(within);
        let style = color.stroke_width(self.unit as u32);
        self.area.draw(&PathElement::new([from, to], style))?;
        let cap = 3 * self.unit;
        let (dx, dy) = if from.0 == to.0 { (cap, 0) } else { (0, cap) };
        let is_wide = (to.0 - from.0).abs() + (to.1 - from.1).abs() > 2 * cap;
        for (x, y) in ends.into_iter().filter(|end| is_wide && within(*end) == *end) {
            self.area.draw(&PathElement::new([(x - dx, y - dy), (x + dx, y + dy)], style))?;
        }
        Ok(())
    }

    /// A mark around a pixel; hollow unless it is `filled`.
    pub fn mark(&self, at: (i32, i32), look: Look, filled: bool) -> Result<(), Box<dyn Error>> {
        let outline = |size: f64| {
            let scale = size * f64::from(self.unit);
            let pixel =
                |(x, y): &(f64, f64)| (at.0 + (x * scale).round() as i32, at.1 + (y * scale).round() as i32);
            look.form.iter().map(pixel).collect::<Vec<_>>()
        };
        self.area.draw(&Polygon::new(outline(MARK), look.stroke.color.filled()))?;
        if !filled {
            self.area.draw(&Polygon::new(outline(0.55 * MARK), WHITE.filled()))?;
        }
        Ok(())
    }

    /// Text whose upper left corner is a pixel.
    pub fn text(&self, text: &str, at: (i32, i32), size: u32, color: RGBColor) -> Result<(), Box<dyn Error>> {
        let style = TextStyle::from((FONT, size * self.unit as u32)).color(&color);
        self.area.draw(&Text::new(text, at, style))?;
        Ok(())
    }

    /// Width and height in pixels.
    pub fn text_size(&self, text: &str, size: u32) -> Result<(i32, i32), Box<dyn Error>> {
        let style = TextStyle::from((FONT, size * self.unit as u32));
        let (width, height) = self.area.estimate_text_size(text, &style)?;
        Ok((width as i32, height as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::method::METHODS;
    use super::*;

    #[test]
    fn all_methods_differ_by_line_and_by_mark() {
        let looks: Vec<Look> = (0..METHODS.len()).map(Look::of).collect();
        for (i, a) in looks.iter().enumerate() {
            for b in &looks[..i] {
                assert_ne!(a.stroke, b.stroke);
                assert!((a.stroke.color, a.form) != (b.stroke.color, b.form), "{a:?} {b:?}");
            }
        }
    }
}
