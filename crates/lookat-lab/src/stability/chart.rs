//! A case as a chart: wrong answers, or the largest error, along its axis; both axes logarithmic.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, LogCoord, WithKeyPoints};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use super::case::{Axis, Case, Found, LOOKAT, Row};

/// Width and height in pixels.
const SIZE: (u32, u32) = (960, 520);
/// Of that, the width of the list of methods.
const LIST: u32 = 220;
/// For text.
const FONT: &str = "sans-serif";
/// Colors that differ for all kinds of sight (Okabe and Ito, 2008). Black is for lookat.
const COLORS: [RGBColor; 8] = [
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x99, 0x99, 0x99),
    RGBColor(0xb5, 0xa6, 0x00),
];

/// A chart in two formats.
#[derive(Debug)]
pub struct Chart {
    /// An SVG file.
    pub svg: String,
    /// Red, green and blue, row by row.
    pub pixels: Vec<u8>,
    /// Width and height of `pixels`.
    pub size: (u32, u32),
}

/// What is drawn upwards.
struct Scale {
    label: String,
    range: Range<f64>,
    value: fn(&Row) -> Option<f64>,
}

impl Chart {
    /// Draws what a case has found; `None` where it has no axis.
    ///
    /// # Errors
    ///
    /// Those of the drawing library; none is known.
    pub fn new(case: &Case, found: &Found) -> Result<Option<Chart>, Box<dyn Error>> {
        let Axis::Of(axis) = case.axis else { return Ok(None) };
        let places: Vec<f64> = found.rows.iter().filter_map(|row| row.at).collect();
        let Some(places) = range(&places, 1.3) else { return Ok(None) };
        let scale = Scale::new(case, found);
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font is damaged")?;
        let mut svg = String::new();
        draw(
            SVGBackend::with_string(&mut svg, SIZE).into_drawing_area(),
            case,
            found,
            axis,
            &places,
            &scale,
        )?;
        let mut pixels = vec![0; (SIZE.0 * SIZE.1 * 3) as usize];
        let area = BitMapBackend::with_buffer(&mut pixels, SIZE).into_drawing_area();
        draw(area, case, found, axis, &places, &scale)?;
        Ok(Some(Chart { svg, pixels, size: SIZE }))
    }
}

impl Scale {
    /// Errors where all have them, else the share of wrong answers.
    fn new(case: &Case, found: &Found) -> Scale {
        let measured =
            |own: bool| found.rows.iter().any(|row| (row.method == LOOKAT) == own && row.worst.is_some());
        if measured(true) && measured(false) {
            let errors: Vec<f64> =
                found.rows.iter().filter_map(|row| row.worst).filter(|e| *e > 0.0).collect();
            let range = range(&errors, 3.0).unwrap_or(0.1..1.0);
            return Scale { label: case.error.into(), range, value: |row| row.worst };
        }
        let most = found.rows.iter().map(|row| row.tried).max().unwrap_or(1).max(10);
        Scale {
            label: "share of wrong answers".into(),
            range: 0.3 / most as f64..1.5,
            value: |row| Some(row.failed as f64 / row.tried as f64),
        }
    }
}

/// From the least to the most, with room at both ends.
fn range(values: &[f64], room: f64) -> Option<Range<f64>> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    (least > 0.0 && most.is_finite()).then(|| least / room..most * room)
}

fn draw<B: DrawingBackend>(
    area: DrawingArea<B, Shift>,
    case: &Case,
    found: &Found,
    axis: &str,
    places: &Range<f64>,
    scale: &Scale,
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    area.fill(&WHITE)?;
    let (left, list) = area.split_horizontally(SIZE.0 - LIST);
    let floor = scale.range.start;
    let mut chart = ChartBuilder::on(&left)
        .caption(format!("{} {}", case.id, case.name), (FONT, 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d(axis_of(places, None), axis_of(&scale.range, Some(floor)))?;
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(WHITE).label_style((FONT, 14)).x_desc(axis).y_desc(&scale.label);
    mesh.x_label_formatter(&|x| number(*x));
    mesh.y_label_formatter(&|y| if *y <= floor { "0".into() } else { number(*y) }).draw()?;
    let methods = methods(found);
    let mut kinds: Vec<&str> = methods.iter().map(|method| kind(method)).collect();
    kinds.dedup();
    for (index, method) in methods.iter().enumerate() {
        // lookat is drawn last, above the others.
        let own = *method == LOOKAT;
        let place = kinds.iter().position(|other| *other == kind(method)).unwrap_or(0);
        let color = if own { BLACK } else { COLORS[place % COLORS.len()] };
        let (style, dot) = (color.stroke_width(if own { 4 } else { 2 }), if own { 5 } else { 3 });
        // What is 0 lies on the axis.
        let points = points(found, method, |row| (scale.value)(row).map(|value| value.max(floor)));
        let gap = if method.ends_with(" f32") { 5 } else { 0 };
        let y = 60 + 24 * index as i32;
        if gap == 0 {
            chart.draw_series(LineSeries::new(points.clone(), style))?;
            list.draw(&PathElement::new([(0, y), (26, y)], style))?;
        } else {
            chart.draw_series(DashedLineSeries::new(points.clone(), 5, gap, style))?;
            for from in [0, 10, 20] {
                list.draw(&PathElement::new([(from, y), (from + 5, y)], style))?;
            }
        }
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, dot, color.filled())))?;
        list.draw(&Text::new(*method, (34, y - 7), (FONT, 14)))?;
    }
    area.present()?;
    Ok(())
}

/// A method without its precision: both precisions have the same color, and single precision is dashed.
fn kind(method: &str) -> &str {
    method.trim_end_matches(" f32").trim_end_matches(" f64")
}

/// A logarithmic axis with a mark at powers of ten, and one at `zero`. Those that the library chooses take forever over hundreds of
/// decades.
fn axis_of(range: &Range<f64>, zero: Option<f64>) -> WithKeyPoints<LogCoord<f64>> {
    let (first, last) = (range.start.log10().ceil() as i32, range.end.log10().floor() as i32);
    let step = ((last - first) / 9 + 1) as usize;
    let powers = (first..=last).step_by(step).filter_map(|exponent| format!("1e{exponent}").parse().ok());
    range.clone().log_scale().with_key_points(zero.into_iter().chain(powers).collect())
}

/// All methods, lookat last.
fn methods(found: &Found) -> Vec<&'static str> {
    let mut methods = found.methods();
    methods.sort_by_key(|method| (*method == LOOKAT, kind(method)));
    methods
}

fn points(found: &Found, method: &str, value: impl Fn(&Row) -> Option<f64>) -> Vec<(f64, f64)> {
    let own = found.rows.iter().filter(|row| row.method == method);
    let mut points: Vec<(f64, f64)> = own.filter_map(|row| Some((row.at?, value(row)?))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// As in 1e-7, 0.01, 10 and 1e6.
fn number(x: f64) -> String {
    if (0.01..10_000.0).contains(&x) { format!("{x}") } else { format!("{x:e}") }
}
