//! The list beside the chart: what its lines and marks are, and what is read off them.

use std::error::Error;

use plotters::prelude::*;

use super::super::front::Reign;
use super::super::results::Results;
use super::canvas::{Canvas, Look, Stroke};
use super::{FRONT, GRAY, SLOPE};
use crate::plot::{Backend, significant};

/// Stretches of the front that are listed.
const MOST_REIGNS: usize = 6;

/// Where the list begins, and how much lower its lines are than the one before: of a method's name, of what is said of it,
/// of other entries, and of stretches of the front.
const TOP: i32 = 52;
const METHOD: i32 = 21;
const READING: i32 = 17;
const ENTRY: i32 = 24;
const REIGN: i32 = 16;

/// The height of the list in units.
pub(super) fn height(results: &Results) -> u32 {
    let entries = 2 + i32::from(!results.markers.is_empty());
    let methods = results.measured.methods.len() as i32 * (METHOD + READING);
    (TOP + methods + entries * ENTRY + reigns(results).len() as i32 * REIGN) as u32
}

/// Draws the list, from this column on.
pub(super) fn draw<B: Backend>(
    canvas: &Canvas<B>,
    results: &Results,
    left: i32,
) -> Result<(), Box<dyn Error>> {
    let unit = canvas.unit;
    let mut y = TOP * unit;
    // The middle of letters is lower than that of their box.
    let text = |text: &str, y: i32, size: i32, color: RGBColor| {
        canvas.text(text, (left + 36 * unit, y - (size / 2 - 3) * unit), size as u32, color)
    };
    let line = |y: i32, stroke: Stroke| canvas.line_at(vec![(left, y), (left + 28 * unit, y)], stroke);
    for (method, of_method) in results.measured.methods.iter().enumerate() {
        line(y, Look::of(method).stroke)?;
        canvas.mark((left + 14 * unit, y), Look::of(method), true)?;
        text(of_method.name, y, 14, BLACK)?;
        text(&reading(results, method), y + READING * unit, 12, GRAY)?;
        y += (READING + METHOD) * unit;
    }
    if !results.markers.is_empty() {
        canvas.mark((left + 14 * unit, y), Look::OTHER, true)?;
        text("other renderers", y, 14, BLACK)?;
        y += ENTRY * unit;
    }
    line(y, SLOPE)?;
    text("slope \u{2212}1/2", y, 14, BLACK)?;
    y += ENTRY * unit;
    line(y, FRONT)?;
    text("Pareto front", y, 14, BLACK)?;
    let lines = reigns(results);
    lines.iter().zip(1..).try_for_each(|(line, i)| text(line, y + i * REIGN * unit, 12, GRAY))
}

/// What is said of a method: its slope, and where it levels off.
fn reading(results: &Results, method: usize) -> String {
    let slope = results.fits[method].map(|fit| {
        let sign = if fit.slope < 0.0 { "\u{2212}" } else { "+" };
        format!("slope {sign}{:.3} \u{b1} {:.3}", fit.slope.abs(), fit.half_width)
    });
    let level = results.levels[method].map(|level| format!("levels off at {}", significant(level, 2)));
    match (slope, level) {
        (None, None) => "no slope: too few clear points".into(),
        (slope, level) => slope.into_iter().chain(level).collect::<Vec<_>>().join(", "),
    }
}

/// Who is on the front, and from when on.
fn reigns(results: &Results) -> Vec<String> {
    let line = |(i, reign): (usize, &Reign)| {
        let name = shortened(results.name(reign.who));
        if i == 0 { name } else { format!("{name} from {} s", significant(reign.points[0].0, 2)) }
    };
    let mut lines: Vec<String> = results.front.iter().take(MOST_REIGNS).enumerate().map(line).collect();
    if results.front.len() > MOST_REIGNS {
        lines.push("...".into());
    }
    lines
}

/// The name, so that a time beside it has room in the legend.
fn shortened(name: &str) -> String {
    const MOST: usize = 24;
    match name.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &name[..end]),
        None => name.into(),
    }
}
