//! The chart: error over time, both axes logarithmic.

use std::error::Error;
use std::ops::Range;

use lookat_image::rgb_png;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::measure::Point;
use super::results::{Chart, MethodResult, round_numbers};
use crate::table::{plain, significant};

/// Width and height of the SVG.
const SIZE: (u32, u32) = (960, 560);
/// Pixels of the PNG per pixel of the SVG.
const SCALE: u32 = 2;
const FONT: &str = "sans-serif";
/// The colors of methods, for all kinds of color vision (Okabe and Ito, 2008, then Tol, 2021). They repeat after the eleventh.
const COLORS: [u32; 11] = [
    0xd55e00, 0x0072b2, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9, 0x999999, 0xb5a600, 0x332288, 0x882255,
    0x117733,
];
/// The Pareto front: a broad pale line behind the others.
const FRONT: RGBColor = RGBColor(0xff, 0xe3, 0x8a);
/// What is there for comparison.
const GRAY: RGBColor = RGBColor(0x70, 0x70, 0x70);

/// A chart as files.
#[derive(Debug)]
pub struct Plot {
    /// An SVG file.
    pub svg: String,
    /// A PNG file of twice the size.
    pub png: Vec<u8>,
}

/// Draws a chart. `None` without errors above 0.
///
/// # Errors
///
/// Those of the drawing library; none is known.
pub fn draw(chart: &Chart, title: &str) -> Result<Option<Plot>, Box<dyn Error>> {
    let points = || chart.methods.iter().flat_map(|method| &method.points);
    let seconds = points().map(|point| point.seconds.value);
    let errors =
        points().flat_map(|point| [point.rmse.value, point.rmse.interval[0], point.rmse.interval[1]]);
    let mut errors: Vec<f64> = errors.chain(chart.others.iter().map(|other| other.rmse)).collect();
    let least = errors.iter().copied().filter(|error| *error > 0.0).fold(f64::INFINITY, f64::min);
    // Noise far below all errors would only take room.
    errors.extend(chart.noise.filter(|noise| *noise > 0.1 * least));
    let seconds = range(seconds.chain(chart.others.iter().map(|other| other.seconds)));
    let (Some(seconds), Some(errors)) = (seconds, range(errors)) else { return Ok(None) };
    let drawing = Drawing { chart, title, seconds, errors };

    register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font is damaged")?;
    let mut svg = String::new();
    drawing.draw(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area(), 1)?;
    let (width, height) = (SIZE.0 * SCALE, SIZE.1 * SCALE);
    let mut pixels = vec![0; (width * height * 3) as usize];
    drawing.draw(&BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area(), SCALE)?;
    let png = rgb_png(width as usize, &pixels).map_err(|fault| format!("{fault:?}"))?;
    Ok(Some(Plot { svg, png }))
}

/// From the least to the largest positive number, with room at both ends.
fn range(values: impl IntoIterator<Item = f64>) -> Option<Range<f64>> {
    const ROOM: f64 = 1.4;
    let shown: Vec<f64> = values.into_iter().filter(|value| *value > 0.0 && value.is_finite()).collect();
    let least = shown.iter().copied().fold(f64::INFINITY, f64::min);
    let most = shown.iter().copied().fold(0.0, f64::max);
    (least <= most).then(|| least / ROOM..most * ROOM)
}

struct Drawing<'a> {
    chart: &'a Chart,
    title: &'a str,
    seconds: Range<f64>,
    errors: Range<f64>,
}

impl Drawing<'_> {
    /// Draws with all lengths times `scale`.
    fn draw<B: DrawingBackend<ErrorType: 'static>>(
        &self,
        area: &DrawingArea<B, Shift>,
        scale: u32,
    ) -> Result<(), Box<dyn Error>> {
        area.fill(&WHITE)?;
        let font = |size: u32| (FONT, size * scale);
        let length = |length: u32| (length * scale) as i32;
        let [across, up] = [&self.seconds, &self.errors]
            .map(|range| range.clone().log_scale().with_key_points(marks(range)));
        let mut plot = ChartBuilder::on(area)
            .caption(self.title, font(17))
            .margin(10 * scale)
            .x_label_area_size(44 * scale)
            .y_label_area_size(74 * scale)
            .build_cartesian_2d(across, up)?;
        plot.configure_mesh()
            .bold_line_style(RGBColor(0xe4, 0xe4, 0xe4).stroke_width(scale))
            .light_line_style(WHITE)
            .axis_style(BLACK.stroke_width(scale))
            .label_style(font(14))
            .x_desc("seconds of rendering")
            .y_desc("root mean squared error")
            .x_label_formatter(&|x| plain(*x))
            .y_label_formatter(&|y| plain(*y))
            .draw()?;
        let key = |style: ShapeStyle| {
            move |(x, y): (i32, i32)| PathElement::new([(x, y), (x + length(24), y)], style)
        };

        let front = FRONT.stroke_width(10 * scale);
        let places = self.chart.front.iter().map(|point| (point.seconds, point.rmse));
        plot.draw_series(LineSeries::new(places, front))?.label("Pareto front").legend(key(front));
        let gray = GRAY.stroke_width(scale);
        if let Some(start) = self.chart.methods.iter().find_map(|method| method.curve().first().copied()) {
            let ends = [start, half_slope(start, &self.seconds, &self.errors)];
            plot.draw_series(DashedLineSeries::new(ends, 6 * scale, 4 * scale, gray))?
                .label("slope \u{2212}1/2")
                .legend(key(gray));
        }
        if let Some(noise) = self.chart.noise.filter(|noise| self.errors.contains(noise)) {
            let ends = [(self.seconds.start, noise), (self.seconds.end, noise)];
            plot.draw_series(DashedLineSeries::new(ends, 2 * scale, 3 * scale, gray))?;
            let text = "noise of the reference, which dominates hollow points";
            let style = TextStyle::from(font(12)).color(&GRAY).pos(Pos::new(HPos::Left, VPos::Bottom));
            plot.draw_series([EmptyElement::at(ends[0]) + Text::new(text, (length(6), -length(3)), style)])?;
        }
        for (index, method) in self.chart.methods.iter().enumerate() {
            let [_, r, g, b] = COLORS[index % COLORS.len()].to_be_bytes();
            let color = RGBColor(r, g, b);
            let line = color.stroke_width(2 * scale);
            plot.draw_series(LineSeries::new(method.curve(), line))?.label(label(method)).legend(key(line));
            let shown = || {
                let is_shown = |point: &&Point| point.seconds.value > 0.0 && point.rmse.value > 0.0;
                method
                    .points
                    .iter()
                    .filter(is_shown)
                    .map(|point| (point, point.seconds.value, point.rmse.value))
            };
            let thin = color.stroke_width(scale);
            // One slow picture must not widen the chart: the bars of times are cut.
            let within = |x: f64, range: &Range<f64>| x.clamp(range.start, range.end);
            plot.draw_series(shown().map(|(point, x, y)| {
                let [low, high] = point.rmse.interval.map(|y| within(y, &self.errors));
                ErrorBar::new_vertical(x, low, y, high, thin, 6 * scale)
            }))?;
            plot.draw_series(shown().map(|(point, x, y)| {
                let [low, high] = point.seconds.interval.map(|x| within(x, &self.seconds));
                ErrorBar::new_horizontal(y, low, x, high, thin, 6 * scale)
            }))?;
            plot.draw_series(shown().map(|(_, x, y)| Circle::new((x, y), 4 * scale, color.filled())))?;
            let hollow = shown().filter(|(point, ..)| !point.above_reference_noise);
            plot.draw_series(hollow.map(|(_, x, y)| Circle::new((x, y), 2 * scale, WHITE.filled())))?;
        }
        let middle = (self.seconds.start * self.seconds.end).sqrt();
        for other in self.chart.others.iter().filter(|other| other.rmse > 0.0) {
            let is_left = other.seconds < middle;
            let (side, x) = if is_left { (HPos::Left, length(9)) } else { (HPos::Right, -length(9)) };
            let style = TextStyle::from(font(14)).pos(Pos::new(side, VPos::Center));
            let mark = BLACK.stroke_width(2 * scale);
            plot.draw_series([EmptyElement::at((other.seconds, other.rmse))
                + Cross::new((0, 0), 5 * scale, mark)
                + Text::new(other.name.clone(), (x, 0), style)])?;
        }
        plot.configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .margin(10 * scale)
            .legend_area_size(30 * scale)
            .background_style(WHITE.mix(0.8))
            .label_font(font(14))
            .draw()?;
        area.present()?;
        Ok(())
    }
}

/// The name of a method with its slope and its bias.
fn label(method: &MethodResult) -> String {
    let slope = method.slope.map(|slope| {
        let sign = if slope.slope < 0.0 { "\u{2212}" } else { "+" };
        let half = 0.5 * (slope.interval[1] - slope.interval[0]);
        format!(", slope {sign}{:.3} \u{b1} {half:.3}", slope.slope.abs())
    });
    let level = method.levels_off_at.map(|level| format!(", levels off at {}", significant(level, 2)));
    format!("{}{}{}", method.name, slope.unwrap_or_default(), level.unwrap_or_default())
}

/// Where a line of slope -1/2 leaves the chart.
fn half_slope(start: (f64, f64), seconds: &Range<f64>, errors: &Range<f64>) -> (f64, f64) {
    let at_end = start.1 * (start.0 / seconds.end).sqrt();
    if at_end >= errors.start {
        return (seconds.end, at_end);
    }
    (start.0 * (start.1 / errors.start).powi(2), errors.start)
}

/// Marks of a logarithmic axis: powers of ten; over fewer than three of them also 2 and 5 times these. The ones that the library
/// chooses take very long over hundreds of decades.
fn marks(range: &Range<f64>) -> Vec<f64> {
    if range.end < 1000.0 * range.start {
        return round_numbers(&(range.start..=range.end), 9);
    }
    let (first, last) = (range.start.log10().ceil() as i32, range.end.log10().floor() as i32);
    let step = ((last - first) / 9 + 1) as usize;
    (first..=last).step_by(step).map(|exponent| 10_f64.powi(exponent)).collect()
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

    #[test]
    fn ranges_and_marks_suit_logarithmic_axes() {
        assert_eq!(range([2.0, 0.0, 4.0, f64::INFINITY]), Some(2.0 / 1.4..4.0 * 1.4));
        assert_eq!(range([0.0]), None);
        assert_eq!(marks(&(0.02..300.0)), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!(marks(&(1e-200..1e200)).len(), 9);
    }
}
