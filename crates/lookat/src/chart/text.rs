//! The text output of `lookat chart`.

use std::fmt::Write;

use lookat_lab::chart::{
    Curve, End, EqualValues, Estimate, Header, Marker, Method, Origin, Plan, Point, Reference, Results,
};
use lookat_lab::plot::{plain, significant};
use lookat_render::REPLICATES;

use crate::readable::visible;

/// The line above the chart.
pub fn title(header: &Header) -> String {
    let name = header.scene.rsplit(['/', '\\']).next().unwrap_or_default();
    let [width, height] = header.size;
    format!("{}, {width} x {height} pixels, {}", visible(name), count(header.threads, "thread"))
}

/// The plan, before rendering.
pub fn plan(plan: &Plan, methods: &[&Method], is_fixed: bool) -> String {
    let tops: Vec<u32> =
        plan.rungs.iter().zip(&plan.costs).map(|(rungs, cost)| cost.first << (rungs - 1)).collect();
    let most = tops.iter().copied().max().unwrap_or(1);
    let less = methods.iter().zip(&tops).filter(|(_, top)| **top < most);
    let less: Vec<String> = less.map(|(method, top)| format!("{} {top}", method.name)).collect();
    let less = if less.is_empty() { String::new() } else { format!(" ({})", less.join(", ")) };
    let mut text =
        format!("plan: 1 to {most} samples per pixel{less}, {} each", count(plan.seeds as usize, "seed"));
    if plan.reference > 0 {
        let _ = write!(text, "; a reference of {}", plan.reference);
    }
    if !is_fixed {
        let _ = write!(text, "; about {} s", significant(plan.seconds, 2));
    }
    text
}

/// All results.
pub fn results(header: &Header, reference: &Reference, results: &Results) -> String {
    let mut text = title(header) + "\n";
    let (parse, preparation) = (significant(header.parse, 2), significant(header.preparation, 2));
    let _ = writeln!(
        text,
        "reading the scene took {parse} s, preparing it {preparation} s; the times below do not include this"
    );
    let _ = writeln!(text, "{}", of_reference(reference));
    text += match results.measured.end {
        End::Whole => "",
        End::Late => "the machine was slower than planned: the last points are missing\n",
        End::Interrupted => "interrupted: the last points are missing\n",
    };
    let _ = write!(text, "\n{}", methods(results));
    if !results.markers.is_empty() {
        let _ = write!(text, "\n{}", others(results));
    }
    let _ = write!(text, "\n{}", front(results));
    let first = results.name(0).to_owned();
    let ratio = if results.curves.len() > 1 { format!(" (relative to {first})") } else { String::new() };
    for (title, what, found) in [
        ("RMSE after equal times", "seconds", &results.equal_times),
        ("seconds to equal RMSE", "RMSE", &results.equal_errors),
    ] {
        // Single points have no common range.
        if !found.at.is_empty() {
            let _ = write!(text, "\n{title}{ratio}\n{}", comparison(what, results, found));
        }
    }
    text
}

fn of_reference(reference: &Reference) -> String {
    let origin = match &reference.origin {
        Origin::Rendered { samples, seconds, .. } => {
            let each = samples / REPLICATES;
            format!(
                "{samples} samples per pixel by sobol, as {REPLICATES} pictures of {each}, {} s",
                significant(*seconds, 2)
            )
        }
        Origin::File { path, rounded } => {
            let rounding =
                if *rounded { ", 8 or 16 bits per channel: rounded, and clipped at white" } else { "" };
            format!("{}{rounding}", visible(&path.display().to_string()))
        }
    };
    let noise = match reference.noise {
        Some(noise) => format!("its noise is {} RMSE, which all errors below include", significant(noise, 2)),
        None => "its noise is unknown, and all errors below include it".into(),
    };
    format!("reference: {origin}; {noise}")
}

/// One line per method: the slope of its error, and its last point.
fn methods(results: &Results) -> String {
    let titles =
        ["method", "samples", "slope", "fitted", "seconds", "RMSE", "relative MSE", "mean error", ""];
    let mut rows = vec![row(titles)];
    for (i, points) in results.measured.points.iter().enumerate() {
        let Some(last) = points.last() else { continue };
        let (slope, fitted) = results.fits[i].map_or(("-".into(), "-".into()), |fit| {
            let [from, to] = [0, fit.rungs - 1].map(|at| samples(points[at].samples));
            (format!("{:.3} ± {:.3}", fit.slope, fit.half_width), format!("{from} to {to}"))
        });
        let with_spread = |estimate: &Estimate, digits: usize| {
            let half = 0.5 * (estimate.high - estimate.low);
            format!("{} ± {}", significant(estimate.value, digits), significant(half, 2))
        };
        rows.push(vec![
            results.name(i).into(),
            samples(last.samples),
            slope,
            fitted,
            significant(last.seconds.value, 3),
            with_spread(&last.rmse, 3),
            significant(last.relative_mse.value, 3),
            with_spread(&last.error, 2),
            remarks(results, i, last),
        ]);
    }
    table(&rows)
}

/// The reason why the error of a method stops falling.
fn remarks(results: &Results, method: usize, last: &Point) -> String {
    let level = results.levels[method].map(|level| {
        let cause = if results.noise().is_some() { "its bias" } else { "bias or noise of the reference" };
        format!("levels off at {}: {cause}", significant(level, 2))
    });
    let is_clear = results.is_clear(last.rmse.value);
    let noise = (!is_clear).then(|| "down to the noise of the reference".to_owned());
    level.into_iter().chain(noise).collect::<Vec<_>>().join("; ")
}

/// The Pareto front: the methods that no other method beats.
fn front(results: &Results) -> String {
    let mut rows = vec![row(["Pareto front", "from", "to", "RMSE from", "to", ""])];
    for reign in &results.front {
        let (first, last) = (reign.points[0], reign.points[reign.points.len() - 1]);
        let ties: Vec<&str> = reign.ties.iter().map(|who| results.name(*who)).collect();
        let ties = if ties.is_empty() { String::new() } else { format!("as good: {}", ties.join(", ")) };
        rows.push(vec![
            results.name(reign.who).into(),
            format!("{} s", significant(first.0, 3)),
            reign.until.map_or(String::new(), |until| format!("{} s", significant(until, 3))),
            significant(first.1, 3),
            significant(last.1, 3),
            ties,
        ]);
    }
    table(&rows)
}

/// The other renderers, and the time that lookat needs to reach their errors.
fn others(results: &Results) -> String {
    let mut text = String::new();
    let names = results.measured.methods.iter().map(|method| method.name.to_owned());
    let head = ["other", "seconds", "RMSE", "relative MSE", "mean error"].map(String::from);
    let mut rows = vec![head.into_iter().chain(names).collect::<Vec<_>>()];
    for marker in &results.markers {
        let ours = results.curves.iter().map(|curve| reach(marker, curve));
        let own = [
            marker.name.clone(),
            significant(marker.seconds, 3),
            significant(marker.means.rmse, 3),
            significant(marker.means.relative_mse, 3),
            significant(marker.means.error, 2),
        ];
        rows.push(own.into_iter().chain(ours).collect());
    }
    let _ = writeln!(
        text,
        "other renderers, and the seconds that lookat needs for the same RMSE (in parentheses, their time divided by this)"
    );
    text += &table(&rows);
    for marker in results.markers.iter().filter(|marker| marker.means.rmse == 0.0) {
        let _ = writeln!(text, "the picture of {} equals the reference: it is not on the chart", marker.name);
    }
    let unclear = |marker: &&Marker| marker.means.rmse > 0.0 && !results.is_clear(marker.means.rmse);
    for marker in results.markers.iter().filter(unclear) {
        let _ = writeln!(
            text,
            "the error of {} is mostly the noise of the reference; for a better reference, increase --spp or --budget",
            marker.name
        );
    }
    for marker in results.markers.iter().filter(|marker| marker.rounded) {
        let _ = writeln!(
            text,
            "the picture of {} is rounded and clipped at white, which may cause its error",
            marker.name
        );
    }
    text
}

/// A number of samples per pixel. For a target error it is a mean.
fn samples(count: f64) -> String {
    if count.fract() == 0.0 { count.to_string() } else { significant(count, 3) }
}

/// The time of a method to reach the error of another renderer.
fn reach(marker: &Marker, curve: &Curve) -> String {
    let ratio = |seconds: f64| significant(marker.seconds / seconds, 2);
    if let Some(seconds) = curve.seconds_to(marker.means.rmse) {
        return format!("{} ({})", significant(seconds, 3), ratio(seconds));
    }
    match curve.first() {
        Some((seconds, error)) if error < marker.means.rmse => {
            format!("<{} (>{})", significant(seconds, 3), ratio(seconds))
        }
        _ => "not reached".into(),
    }
}

/// A comparison as a table: one row per method, one column per place.
fn comparison(what: &str, results: &Results, comparison: &EqualValues) -> String {
    let places = comparison.at.iter().map(|at| plain(*at));
    let mut rows = vec![std::iter::once(what.to_owned()).chain(places).collect::<Vec<_>>()];
    for (i, values) in comparison.values.iter().enumerate() {
        let cell = |(column, value): (usize, &Option<f64>)| match (value, comparison.values[0][column]) {
            (None, _) => "-".into(),
            (Some(value), Some(first)) if i > 0 => {
                format!("{} ({})", significant(*value, 3), significant(value / first, 2))
            }
            (Some(value), _) => significant(*value, 3),
        };
        let cells = values.iter().enumerate().map(cell);
        rows.push(std::iter::once(results.name(i).to_owned()).chain(cells).collect());
    }
    table(&rows)
}

/// Aligned columns: the first one left-aligned, the others right-aligned. A last column without a title is not padded.
/// All rows have the length of the first row.
fn table(rows: &[Vec<String>]) -> String {
    let Some(titles) = rows.first() else { return String::new() };
    let width = |i: usize| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..titles.len()).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (i, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let _ = match i {
                0 => write!(line, "{cell:width$}"),
                _ if titles[i].is_empty() => write!(line, "  {cell}"),
                _ => write!(line, "  {cell:>width$}"),
            };
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(String::from).to_vec()
}

fn count(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned() {
        let rows = [row(["a", "long", ""]), row(["name", "1", "said"]), row(["b", "123456", ""])];
        assert_eq!(table(&rows), "a       long\nname       1  said\nb     123456\n");
    }
}
