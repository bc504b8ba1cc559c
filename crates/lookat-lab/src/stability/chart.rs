//! A case as a chart: wrong answers, or the largest error, along its axis; both axes logarithmic.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::case::{Case, Found, LOOKAT, Row};
use crate::plot::{self, Backend, Drawing, FONT, Plot, axis, number, powers, range};

/// Width and height in pixels.
const SIZE: (u32, u32) = (960, 520);
/// Of that, the width of the list of methods.
const LIST: u32 = 220;

/// A case that can be drawn.
struct CaseChart<'a> {
    case: &'a Case,
    found: &'a Found,
    places: Range<f64>,
    /// What is drawn upwards, and its name.
    value: fn(&Row) -> Option<f64>,
    label: &'a str,
    values: Range<f64>,
}

/// Draws what a case has found; `None` where it has no axis. Errors where all have them, else the share of wrong answers.
///
/// # Errors
///
/// Those of the drawing library; none is known.
pub fn draw(case: &Case, found: &Found) -> Result<Option<Plot>, Box<dyn Error>> {
    let rows = || found.rows.iter();
    let places: Vec<f64> = rows().filter_map(|row| row.at).collect();
    let Some(places) = range(&places, 1.3) else { return Ok(None) };
    let measured = |own: bool| rows().any(|row| (row.method == LOOKAT) == own && row.worst.is_some());
    let chart = if measured(true) && measured(false) {
        let errors: Vec<f64> = rows().filter_map(|row| row.worst).filter(|e| *e > 0.0).collect();
        let values = range(&errors, 3.0).unwrap_or(0.1..1.0);
        CaseChart { case, found, places, value: |row| row.worst, label: case.error, values }
    } else {
        let most = rows().map(|row| row.tried).max().unwrap_or(1).max(10);
        let value = |row: &Row| Some(row.failed as f64 / row.tried as f64);
        let label = "fraction of wrong answers";
        CaseChart { case, found, places, value, label, values: 0.3 / most as f64..1.5 }
    };
    Plot::new(&chart, SIZE, 1).map(Some)
}

impl Drawing for CaseChart<'_> {
    fn draw<B: Backend>(&self, area: &DrawingArea<B, Shift>, _: u32) -> Result<(), Box<dyn Error>> {
        let CaseChart { case, found, places, value, label, values } = self;
        area.fill(&WHITE)?;
        let (left, list) = area.split_horizontally(SIZE.0 - LIST);
        let floor = values.start;
        let upwards = std::iter::once(floor).chain(powers(values)).collect();
        let mut chart = ChartBuilder::on(&left)
            .caption(format!("{} {}", case.id, case.name), (FONT, 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(axis(places, powers(places)), axis(values, upwards))?;
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(WHITE).label_style((FONT, 14)).x_desc(case.axis).y_desc(*label);
        mesh.x_label_formatter(&|x| number(*x));
        mesh.y_label_formatter(&|y| if *y <= floor { "0".into() } else { number(*y) }).draw()?;
        let methods = methods(found);
        let mut kinds: Vec<&str> = methods.iter().map(|method| kind(method)).collect();
        kinds.dedup();
        for (index, method) in methods.iter().enumerate() {
            // lookat is drawn last, above the others.
            let own = *method == LOOKAT;
            let place = kinds.iter().position(|other| *other == kind(method)).unwrap_or(0);
            let color = if own { BLACK } else { plot::color(place) };
            let (style, dot) = (color.stroke_width(if own { 4 } else { 2 }), if own { 5 } else { 3 });
            // What is 0 lies on the axis.
            let points = points(found, method, |row| value(row).map(|value| value.max(floor)));
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
        Ok(())
    }
}

/// A method without its precision: both precisions have the same color, and single precision is dashed.
fn kind(method: &str) -> &str {
    method.trim_end_matches(" f32").trim_end_matches(" f64")
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
