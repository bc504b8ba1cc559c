//! The chart: error over time, both axes logarithmic.

mod canvas;
mod label;
mod legend;

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::equal::round_numbers;
use super::results::Results;
use crate::plot::{Backend, Drawing, FONT, Plot, axis, plain, powers, range};
use canvas::{Canvas, Look, Stroke};
use label::Labels;

/// Width, and the least height; pixels are finer by `UNIT`.
const SIZE: (u32, u32) = (960, 560);
/// Pixels of a PNG for each unit of length.
const UNIT: u32 = 2;
/// Width of the list of methods.
const LIST: u32 = 260;
/// The front: a broad pale line behind the others.
const FRONT: Stroke = Stroke { color: RGBColor(0xff, 0xe3, 0x8a), width: 13, dashes: None };
/// What is there for comparison.
const GRAY: RGBColor = RGBColor(0x70, 0x70, 0x70);
/// The slope of independent samples.
const SLOPE: Stroke = Stroke { color: GRAY, width: 1, dashes: Some([6, 4]) };
/// The noise of the reference.
const NOISE: Stroke = Stroke { color: GRAY, width: 1, dashes: Some([2, 3]) };

/// What is drawn.
struct TimeChart<'a> {
    results: &'a Results,
    title: &'a str,
    /// The root mean squared noise of the reference, where it is known.
    noise: Option<f64>,
    seconds: Range<f64>,
    errors: Range<f64>,
}

/// Draws the results; `None` if there is no error to draw.
///
/// # Errors
///
/// Those of the drawing library; none is known.
pub fn draw(results: &Results, title: &str) -> Result<Option<Plot>, Box<dyn Error>> {
    let points = || results.measured.points.iter().flatten();
    let markers = || results.markers.iter();
    // One picture that was held up must not rule the chart: intervals of time may be cut.
    let seconds = points().map(|point| point.seconds.value).chain(markers().map(|marker| marker.seconds));
    let errors = points().flat_map(|point| [point.rmse.low, point.rmse.high]);
    let shown = |value: &f64| *value > 0.0 && value.is_finite();
    let seconds: Vec<f64> = seconds.filter(shown).collect();
    let mut errors: Vec<f64> =
        errors.chain(markers().map(|marker| marker.means.rmse)).filter(shown).collect();
    let noise = results.noise();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    // Noise far below everything is not worth the room.
    errors.extend(noise.filter(|noise| *noise > 0.1 * least));
    let (Some(seconds), Some(errors)) = (range(&seconds, 1.4), range(&errors, 1.4)) else { return Ok(None) };
    let size = (SIZE.0, SIZE.1.max(legend::height(results) + 10));
    Plot::new(&TimeChart { results, title, noise, seconds, errors }, size, UNIT).map(Some)
}

impl Drawing for TimeChart<'_> {
    fn draw<B: Backend>(&self, area: &DrawingArea<B, Shift>, unit: u32) -> Result<(), Box<dyn Error>> {
        area.fill(&WHITE)?;
        let (left, _) = area.split_horizontally((SIZE.0 - LIST) * unit);
        let font = |size: u32| (FONT, size * unit);
        let (across, up) =
            (axis(&self.seconds, marks(&self.seconds)), axis(&self.errors, marks(&self.errors)));
        let mut chart = ChartBuilder::on(&left)
            .caption(self.title, font(17))
            .margin(10 * unit)
            .x_label_area_size(44 * unit)
            .y_label_area_size(74 * unit)
            .build_cartesian_2d(across, up)?;
        chart
            .configure_mesh()
            .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4).stroke_width(unit))
            .light_line_style(WHITE)
            .axis_style(BLACK.stroke_width(unit))
            .label_style(font(14))
            .x_desc("seconds of rendering")
            .y_desc("root mean squared error")
            .x_label_formatter(&|x| plain(*x))
            .y_label_formatter(&|y| plain(*y))
            .draw()?;
        let plotting = chart.plotting_area();
        let place = |point: (f64, f64)| plotting.map_coordinate(&point);
        let (x, y) = plotting.get_pixel_range();
        let canvas = Canvas { area, unit: unit as i32, x: x.clone(), y: y.clone(), place: &place };
        self.background(&canvas)?;
        self.methods(&canvas)?;
        self.others(&canvas, Labels::new(x, y))?;
        legend::draw(&canvas, self.results, ((SIZE.0 - LIST) * unit) as i32)
    }
}

impl TimeChart<'_> {
    /// The front, the line of slope -1/2, and the noise of the reference.
    fn background<B: Backend>(&self, canvas: &Canvas<B>) -> Result<(), Box<dyn Error>> {
        let front: Vec<(f64, f64)> =
            self.results.front.iter().flat_map(|reign| reign.points.clone()).collect();
        canvas.line(&front, FRONT)?;
        if let Some(start) = self.results.curves.first().and_then(|curve| curve.0.first()) {
            canvas.line(&[*start, half_slope(*start, &self.seconds, &self.errors)], SLOPE)?;
        }
        if let Some(noise) = self.noise.filter(|noise| self.errors.contains(noise)) {
            let ends = [(self.seconds.start, noise), (self.seconds.end, noise)];
            canvas.line(&ends, NOISE)?;
            let points = self.results.curves.iter().flat_map(|curve| curve.0.iter().map(|point| point.1));
            let stars = self.results.markers.iter().map(|marker| marker.means.rmse);
            let is_hollow = points.chain(stars).any(|rmse| !self.results.is_clear(rmse));
            let more = if is_hollow { ", which dominates hollow points" } else { "" };
            let (x, y) = (canvas.place)(ends[0]);
            let at = (x + 6 * canvas.unit, y - 14 * canvas.unit);
            canvas.text(&format!("noise of the reference{more}"), at, 12, GRAY)?;
        }
        Ok(())
    }

    /// Lines, error bars and points. Points that the noise of the reference rules are hollow.
    fn methods<B: Backend>(&self, canvas: &Canvas<B>) -> Result<(), Box<dyn Error>> {
        for (method, curve) in self.results.curves.iter().enumerate() {
            canvas.line(&curve.0, Look::of(method).stroke)?;
        }
        for (method, points) in self.results.measured.points.iter().enumerate() {
            let look = Look::of(method);
            for point in points.iter().filter(|point| point.seconds.value > 0.0 && point.rmse.value > 0.0) {
                let at = (point.seconds.value, point.rmse.value);
                canvas.bar((point.seconds.low, at.1), (point.seconds.high, at.1), look.stroke.color)?;
                canvas.bar((at.0, point.rmse.low), (at.0, point.rmse.high), look.stroke.color)?;
                canvas.mark((canvas.place)(at), look, self.results.is_clear(at.1))?;
            }
        }
        Ok(())
    }

    /// Other renderers, with their names where there is room.
    fn others<B: Backend>(&self, canvas: &Canvas<B>, mut labels: Labels) -> Result<(), Box<dyn Error>> {
        let markers = || self.results.markers.iter().filter(|marker| marker.means.rmse > 0.0);
        let ours = self.results.curves.iter().flat_map(|curve| curve.0.iter().copied());
        for at in ours.chain(markers().map(|marker| (marker.seconds, marker.means.rmse))) {
            labels.avoid((canvas.place)(at), 7 * canvas.unit);
        }
        for marker in markers() {
            let at = (canvas.place)((marker.seconds, marker.means.rmse));
            canvas.mark(at, Look::OTHER, self.results.is_clear(marker.means.rmse))?;
            let size = canvas.text_size(&marker.name, 14)?;
            canvas.text(&marker.name, labels.place(at, size, 11 * canvas.unit), 14, BLACK)?;
        }
        Ok(())
    }
}

/// Where a line of slope -1/2 leaves the chart.
fn half_slope(start: (f64, f64), seconds: &Range<f64>, errors: &Range<f64>) -> (f64, f64) {
    let at_end = start.1 * (start.0 / seconds.end).sqrt();
    if at_end >= errors.start {
        return (seconds.end, at_end);
    }
    (start.0 * (start.1 / errors.start).powi(2), errors.start)
}

/// Marks at powers of ten; over less than three also at 2 and 5 times those.
fn marks(range: &Range<f64>) -> Vec<f64> {
    if range.end < 1000.0 * range.start {
        round_numbers(&(range.start..=range.end), 9)
    } else {
        powers(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_half_slope_ends_at_an_edge() {
        // From 1 at 1 s to 0.1 at 100 s.
        assert_eq!(half_slope((1.0, 1.0), &(1.0..100.0), &(0.01..1.0)), (100.0, 0.1));
        assert_eq!(half_slope((1.0, 1.0), &(1.0..1e4), &(0.1..1.0)), (100.0, 0.1));
    }
}
