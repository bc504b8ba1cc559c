//! What the report page shows of a scene.

use lookat_image::mean;

use super::page::{Figure, PageScene, Picture};
use super::{Outcome, SceneComparison};
use crate::metric::{Measured, Metric};

/// The metrics with a column. The others appear below.
const COLUMNS: [Metric; 4] = [Metric::Error, Metric::Rmse, Metric::Flip, Metric::NoiseP];

/// A scene of the page. It holds what it needs of the pictures.
pub fn scene(outcome: &Outcome) -> PageScene {
    PageScene {
        name: outcome.name.clone(),
        verdict: outcome.verdict,
        reason: outcome.reason.clone(),
        columns: columns(outcome),
        details: outcome.comparison.as_ref().map_or(Vec::new(), details),
        messages: outcome.diagnostics.text.clone(),
        pictures: pictures(outcome),
    }
}

/// The two pictures over each other, or each picture alone if they cannot be compared.
fn pictures(outcome: &Outcome) -> Vec<Picture> {
    if let Some(comparison) = &outcome.comparison {
        return vec![Picture::new(&comparison.pair)];
    }
    let render = outcome.render.as_ref().map(|render| &render.image);
    let both = [("expected", outcome.reference.as_ref()), ("actual", render)];
    both.into_iter().filter_map(|(role, image)| Picture::alone(image?, role)).collect()
}

fn columns(outcome: &Outcome) -> Vec<Figure> {
    let (Some(comparison), Some(render)) = (&outcome.comparison, &outcome.render) else { return Vec::new() };
    let metrics = &comparison.measurement.metrics;
    let mean = mean(&comparison.pair.expected);
    let metric = |metric: Metric| metrics.iter().find(|line| line.metric == metric);
    let mut columns: Vec<Figure> = COLUMNS
        .iter()
        .filter_map(|column| metric(*column))
        .map(|line| match line.metric {
            Metric::Error if mean != 0.0 => {
                Figure::percent("error", line.value / mean, "mean signed error, relative to the mean")
            }
            _ => figure(line),
        })
        .collect();
    if columns.is_empty() {
        return columns;
    }
    if let Some(bias) = comparison.detectable {
        let meaning = "smallest bias of the mean that would have shown";
        let figure = Figure::number("detectable", bias, meaning);
        let text = match mean {
            0.0 => figure.text,
            mean => format!("{:.3} %", 100.0 * bias / mean.abs()),
        };
        columns.insert(1, Figure { text, ..figure });
    }
    columns.push(Figure::number("samples", f64::from(render.samples_per_pixel), "samples per pixel"));
    columns.push(Figure::number("seconds", render.seconds, "time to render"));
    columns
}

fn details(comparison: &SceneComparison) -> Vec<Figure> {
    let others = comparison.measurement.metrics.iter().filter(|line| !COLUMNS.contains(&line.metric));
    others.map(figure).collect()
}

fn figure(line: &Measured) -> Figure {
    let meaning = match line.remark.as_str() {
        "" => line.metric.meaning().to_owned(),
        remark => format!("{}, {remark}", line.metric.meaning()),
    };
    let figure = if line.metric.is_likeness() { Figure::likeness } else { Figure::number };
    figure(line.metric.name(), line.value, &meaning)
}
