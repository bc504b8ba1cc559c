//! The output rows of `lookat verify`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use lookat_image::mean;
use serde::Serialize;
use serde_json::Value;
use unicode_width::UnicodeWidthStr;

use crate::failure::Failure;
use crate::metric::{Metric, number};
use crate::readable::visible;
use crate::verify::{Outcome, SceneComparison, Verdict, scene_name};

/// Prints rows to standard output, as text or JSON.
pub struct Table {
    json: bool,
    /// Width of the column of names on a terminal. A longer name shifts the rest of its row.
    width: usize,
}

/// The metrics with a column.
const METRICS: [Metric; 3] = [Metric::Rmse, Metric::Flip, Metric::NoiseP];

/// The widest column of names.
const MOST_NAME: usize = 40;

impl Table {
    pub fn new(scenes: &[PathBuf], json: bool) -> Table {
        let width = |scene: &PathBuf| visible(&scene_name(scene)).width();
        let longest = scenes.iter().map(width).max().unwrap_or(0);
        Table { json, width: longest.clamp(5, MOST_NAME) }
    }

    pub fn header(&self) -> Result<(), Failure> {
        let names = ["error", "detectable"].into_iter().chain(METRICS.map(Metric::name));
        let line = format!("{:width$} verdict  {}", "scene", columns(names), width = self.width);
        if self.json { Ok(()) } else { print(&line) }
    }

    pub fn row(&self, outcome: &Outcome) -> Result<(), Failure> {
        if self.json {
            return crate::print_json(&Row::new(outcome));
        }
        let figures = outcome.comparison.as_ref().map_or(Default::default(), figures);
        let (name, reason) = (visible(&outcome.name), visible(&outcome.reason));
        let (verdict, figures) = (outcome.verdict.word(), columns(figures.iter().map(String::as_str)));
        // Some characters take two columns.
        let blanks = " ".repeat(self.width.saturating_sub(name.width()));
        print(&format!("{name}{blanks} {verdict:9}{figures}  {reason}"))
    }

    pub fn footer(&self, verdicts: &[Verdict]) -> Result<(), Failure> {
        let count = |verdict: &Verdict| match verdicts.iter().filter(|other| *other == verdict).count() {
            0 => None,
            count => Some(format!("{count} {}", verdict.word_for(count))),
        };
        let counts: Vec<String> = Verdict::ALL.iter().filter_map(count).collect();
        let scenes = if verdicts.len() == 1 { "scene" } else { "scenes" };
        let line = format!("{} {scenes}: {}", verdicts.len(), counts.join(", "));
        if self.json { Ok(()) } else { print(&line) }
    }
}

fn print(line: &str) -> Result<(), Failure> {
    crate::print(&format!("{line}\n"))
}

/// Texts in columns of ten characters, with a blank before each even where one is longer.
fn columns<'t>(texts: impl IntoIterator<Item = &'t str>) -> String {
    texts.into_iter().map(|text| format!(" {text:>10}")).collect()
}

/// The mean error, the detectable bias and some metrics. "-" for each that was not measured.
fn figures(comparison: &SceneComparison) -> [String; 5] {
    let value = |metric: Metric| comparison.measurement.value(metric);
    let mean = mean(&comparison.pair.expected);
    let error = value(Metric::Error).map(|error| relative(error, mean, "+"));
    let detectable = comparison.detectable.map(|bias| relative(bias, mean.abs(), ""));
    let [rmse, flip, noise] = METRICS.map(|metric| value(metric).map(short));
    [error, detectable, rmse, flip, noise].map(|text| text.unwrap_or("-".into()))
}

/// A value in percent of a mean, or as it is if the mean is zero. `plus` is the sign of positive values.
fn relative(value: f64, mean: f64, plus: &str) -> String {
    let plus = if value / mean >= 0.0 { plus } else { "" };
    match 100.0 * value / mean {
        _ if mean == 0.0 => format!("{plus}{value:.2e}"),
        percent if percent.abs() < 1000.0 => format!("{plus}{percent:.3} %"),
        percent => format!("{plus}{percent:.2e} %"),
    }
}

/// A number in at most ten characters, as long as it is not negative.
fn short(value: f64) -> String {
    let text = number(value);
    if text.len() > 10 { format!("{value:.3e}") } else { text }
}

/// The JSON of a scene.
#[derive(Serialize)]
struct Row<'a> {
    /// The file name without `.pbrt`.
    scene: &'a str,
    /// `agrees`, `differs`, `undecided`, `new` or `failed`.
    verdict: &'static str,
    /// Why, in words.
    reason: &'a str,
    /// True if the reference was written.
    updated: bool,
    /// The metrics by name.
    metrics: BTreeMap<&'static str, f64>,
    /// Smallest bias of the mean that the noise tests would find, in the picture's unit, or null.
    visible_in_mean: Option<f64>,
    /// Samples per pixel of the render, or null.
    samples_per_pixel: Option<u32>,
    /// The time to render, or null.
    seconds: Option<f64>,
    /// The messages of the scene file, as in `check`.
    diagnostics: &'a Value,
}

impl<'a> Row<'a> {
    fn new(outcome: &'a Outcome) -> Row<'a> {
        let (comparison, render) = (outcome.comparison.as_ref(), outcome.render.as_ref());
        let metrics = comparison.iter().flat_map(|comparison| &comparison.measurement.metrics);
        Row {
            scene: &outcome.name,
            verdict: outcome.verdict.word(),
            reason: &outcome.reason,
            updated: outcome.updated,
            metrics: metrics.map(|line| (line.metric.name(), line.value)).collect(),
            visible_in_mean: comparison.and_then(|comparison| comparison.detectable),
            samples_per_pixel: render.map(|render| render.samples_per_pixel),
            seconds: render.map(|render| render.seconds),
            diagnostics: &outcome.diagnostics.json,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of any magnitude fit in a column.
    #[test]
    fn figures_fit_in_their_columns() {
        let values =
            (-160..=39).flat_map(|power| [1.0, 1.509_547, 9.999_999_6].map(|m| m * 10_f64.powi(power)));
        for value in values.chain([0.0, 1.0, 100.0, 999_999.9]) {
            assert!(short(value).len() <= 10, "{}", short(value));
            for text in [relative(value, 1.0, "+"), relative(-value, 1.0, "+"), relative(value, 0.0, "+")] {
                assert!(text.len() <= 11, "{text}");
            }
        }
        assert_eq!(columns(["0.150954", "7.740e-147"]), "   0.150954 7.740e-147");
        assert_eq!(relative(-0.5, 2.0, "+"), "-25.000 %");
        assert_eq!(relative(0.5, 2.0, "+"), "+25.000 %");
        assert_eq!(relative(1e9, 1.0, "+"), "+1.00e11 %");
    }
}
