//! The text output of `lookat chart`.

use std::fmt::Write;

use lookat_lab::chart::{Chart, EqualTable, Method, MethodResult, Origin, OtherResult, Plan, Reference};
use lookat_lab::estimate::Estimate;
use lookat_lab::table::{aligned, plain, significant};
use lookat_render::REPLICATES;

use crate::readable::visible;

/// The line above the chart.
pub fn title(chart: &Chart) -> String {
    let name = chart.setup.scene.rsplit(['/', '\\']).next().unwrap_or_default();
    let [width, height] = chart.setup.size;
    let threads =
        if chart.setup.threads == 1 { "1 thread".into() } else { format!("{} threads", chart.setup.threads) };
    format!("{}, {width} x {height} pixels, {threads}", visible(name))
}

/// The plan, before rendering.
pub fn plan(plan: &Plan, seconds: Option<f64>, methods: &[&Method]) -> String {
    let most = methods.iter().map(|method| plan.last(method)).max().unwrap_or(1);
    let mut text = format!("plan: 1 to {most} samples per pixel, {} seeds each", plan.seeds);
    if plan.renders_reference {
        let _ = write!(text, "; a reference of {}", plan.reference_samples(methods));
    }
    if let Some(seconds) = seconds {
        let _ = write!(text, "; about {} s", significant(seconds, 2));
    }
    text
}

/// All results.
pub fn results(chart: &Chart, reference: &Reference) -> String {
    let (parse, preparation) =
        (significant(chart.setup.parse_seconds, 2), significant(chart.setup.preparation_seconds, 2));
    let end = match (chart.complete, chart.interrupted) {
        (true, _) => "",
        (false, true) => "interrupted: the last points are missing\n",
        (false, false) => "the machine was slower than planned: the last points are missing\n",
    };
    let mut text = format!(
        "{}\nreading the scene took {parse} s, preparing it {preparation} s; the times below do not include this\n{}\n{end}\n{}",
        title(chart),
        of_reference(reference),
        methods(chart)
    );
    if !chart.others.is_empty() {
        let _ = write!(text, "\n{}", others(chart));
    }
    let mut front = vec![["Pareto front", "seconds", "RMSE"].map(String::from).to_vec()];
    front.extend(
        chart
            .front
            .iter()
            .map(|point| vec![point.name.clone(), significant(point.seconds, 3), significant(point.rmse, 3)]),
    );
    let _ = write!(text, "\n{}", aligned(&front));
    let first = chart.methods[0].name;
    let ratio = if chart.methods.len() > 1 { format!(" (relative to {first})") } else { String::new() };
    for (title, what, found) in [
        ("RMSE after equal times", "seconds", &chart.equal_time),
        ("seconds to equal RMSE", "RMSE", &chart.equal_error),
    ] {
        // A single point has no range.
        if !found.at.is_empty() {
            let _ = write!(text, "\n{title}{ratio}\n{}", comparison(what, &chart.methods, found));
        }
    }
    text
}

fn of_reference(reference: &Reference) -> String {
    let origin = match &reference.origin {
        Origin::Rendered { samples, seconds, .. } => format!(
            "{samples} samples per pixel by sobol, as {REPLICATES} pictures of {}, {} s",
            samples / REPLICATES,
            significant(*seconds, 2)
        ),
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
fn methods(chart: &Chart) -> String {
    let titles =
        ["method", "samples", "slope", "fitted", "seconds", "RMSE", "relative MSE", "mean error", ""];
    let mut rows = vec![titles.map(String::from).to_vec()];
    for method in &chart.methods {
        let Some(last) = method.points.last() else { continue };
        let (slope, fitted) = method.slope.map_or(("-".into(), "-".into()), |slope| {
            let [from, to] = [0, slope.points - 1].map(|at| samples(method.points[at].samples_taken));
            let half = 0.5 * (slope.interval[1] - slope.interval[0]);
            (format!("{:.3} ± {half:.3}", slope.slope), format!("{from} to {to}"))
        });
        let with_spread = |Estimate { value, interval: [low, high] }: Estimate, digits: usize| {
            format!("{} ± {}", significant(value, digits), significant(0.5 * (high - low), 2))
        };
        rows.push(vec![
            method.name.into(),
            samples(last.samples_taken),
            slope,
            fitted,
            significant(last.seconds.value, 3),
            with_spread(last.rmse, 3),
            significant(last.relative_mse.value, 3),
            with_spread(last.mean_error, 2),
            remarks(chart, method),
        ]);
    }
    aligned(&rows)
}

/// The reason why the error of a method stops falling.
fn remarks(chart: &Chart, method: &MethodResult) -> String {
    let level = method.levels_off_at.map(|level| {
        let cause = if chart.noise.is_some() { "its bias" } else { "bias or noise of the reference" };
        format!("levels off at {}: {cause}", significant(level, 2))
    });
    let is_noise = method.points.last().is_some_and(|last| !last.above_reference_noise);
    let noise = is_noise.then(|| "down to the noise of the reference".to_owned());
    level.into_iter().chain(noise).collect::<Vec<_>>().join("; ")
}

/// The other renderers, and the time that lookat needs to reach their errors.
fn others(chart: &Chart) -> String {
    let head = ["other", "seconds", "RMSE", "relative MSE", "mean error"].into_iter();
    let head = head.chain(chart.methods.iter().map(|method| method.name)).map(String::from).collect();
    let mut rows: Vec<Vec<String>> = vec![head];
    let mut notes = String::new();
    for other in &chart.others {
        let OtherResult { name, seconds, rmse, relative_mse, mean_error, .. } = other;
        let mut cells = vec![name.clone(), significant(*seconds, 3), significant(*rmse, 3)];
        cells.extend([significant(*relative_mse, 3), significant(*mean_error, 2)]);
        cells.extend(chart.methods.iter().map(|method| reach(other, method)));
        rows.push(cells);
        let mut note = |holds: bool, note: &str| {
            if holds {
                let _ = writeln!(notes, "the picture of {name} {note}");
            }
        };
        note(*rmse == 0.0, "equals the reference: it is not on the chart");
        let is_noise = *rmse > 0.0 && !chart.is_clear(*rmse);
        note(
            is_noise,
            "is about as exact as the reference; for a better reference, increase --spp or --budget",
        );
        note(other.stored_as_integers, "is rounded and clipped at white, which may cause its error");
    }
    format!(
        "other renderers, and the seconds that lookat needs for the same RMSE (in parentheses, their time divided by this)\n{}{notes}",
        aligned(&rows)
    )
}

/// The time of a method to reach the error of another renderer.
fn reach(other: &OtherResult, method: &MethodResult) -> String {
    let ratio = |seconds: f64| significant(other.seconds / seconds, 2);
    match (method.seconds_to(other.rmse), method.curve().first()) {
        (Some(seconds), _) => format!("{} ({})", significant(seconds, 3), ratio(seconds)),
        (None, Some((seconds, error))) if *error < other.rmse => {
            format!("<{} (>{})", significant(*seconds, 3), ratio(*seconds))
        }
        _ => "not reached".into(),
    }
}

/// A number of samples per pixel. For a target error it is a mean.
fn samples(count: f64) -> String {
    if count.fract() == 0.0 { count.to_string() } else { significant(count, 3) }
}

/// One row per method, one column per place. In parentheses, values over those of the first method.
fn comparison(what: &str, methods: &[MethodResult], found: &EqualTable) -> String {
    let mut rows =
        vec![std::iter::once(what.to_owned()).chain(found.at.iter().map(|at| plain(*at))).collect()];
    let first = &found.values[methods[0].name];
    for method in methods {
        let cells = found.values[method.name].iter().zip(first).map(|(value, first)| match (value, first) {
            (None, _) => "-".into(),
            (Some(value), Some(first)) if method.name != methods[0].name => {
                format!("{} ({})", significant(*value, 3), significant(value / first, 2))
            }
            (Some(value), _) => significant(*value, 3),
        });
        rows.push(std::iter::once(method.name.to_owned()).chain(cells).collect::<Vec<_>>());
    }
    aligned(&rows)
}
