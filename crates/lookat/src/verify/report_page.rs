//! What the report says of a scene.

use lookat_image::mean;

use super::page::{Figure, PageScene, Picture};
use super::{Compared, Outcome};
use crate::metric::{Measured, Metric};

/// The metrics that have a column; all others stand below.
const COLUMNS: [Metric; 4] = [Metric::Error, Metric::Rmse, Metric::Flip, Metric::NoiseP];

/// A scene of the report. It holds what it needs of the pictures.
pub fn scene(outcome: &Outcome) -> PageScene {
    let compared = outcome.compared.as_ref();
    PageScene {
        name: outcome.name.clone(),
        verdict: outcome.verdict,
        reason: outcome.reason.clone(),
        columns: compared.map_or(Vec::new(), columns),
        details: compared.map_or(Vec::new(), details),
        picture: compared.map(|compared| Picture::new(&compared.pair)),
    }
}

fn columns(compared: &Compared) -> Vec<Figure> {
    let metrics = &compared.measurement.metrics;
    let mean = mean(&compared.pair.expected);
    let mut columns: Vec<Figure> = COLUMNS
        .iter()
        .filter_map(|column| metrics.iter().find(|line| line.metric == *column))
        .map(|line| match line.metric {
            Metric::Error if mean != 0.0 => {
                Figure::percent("error", line.value / mean, "mean signed error, by the mean")
            }
            _ => figure(line),
        })
        .collect();
    if !columns.is_empty() {
        let samples = f64::from(compared.samples_per_pixel);
        columns.push(Figure::number("samples", samples, "samples per pixel"));
        columns.push(Figure::number("seconds", compared.seconds, "time to render"));
    }
    columns
}

fn details(compared: &Compared) -> Vec<Figure> {
    let others = compared.measurement.metrics.iter().filter(|line| !COLUMNS.contains(&line.metric));
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
