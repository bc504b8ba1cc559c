//! The output rows of `lookat verify`.

use std::path::PathBuf;

use unicode_width::UnicodeWidthStr;

use lookat_image::{Metric, number, value_of};

use crate::failure::Failure;
use crate::readable::visible;
use crate::verify::files::scene_name;
use crate::verify::outcome::{Outcome, Verdict, summary};

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
            return crate::print_json(outcome);
        }
        let figures = outcome.mean.map_or(Default::default(), |mean| figures(outcome, mean));
        let (name, reason) = (visible(&outcome.scene), visible(&outcome.reason));
        let (verdict, figures) = (outcome.verdict.word(), columns(figures.iter().map(String::as_str)));
        // Some characters take two columns.
        let blanks = " ".repeat(self.width.saturating_sub(name.width()));
        print(&format!("{name}{blanks} {verdict:9}{figures}  {reason}"))
    }

    pub fn footer(&self, verdicts: &[Verdict]) -> Result<(), Failure> {
        let line = summary(verdicts, |_, words| words);
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
fn figures(outcome: &Outcome, mean: f64) -> [String; 5] {
    let value = |metric: Metric| value_of(&outcome.metrics, metric);
    let error = value(Metric::Error).map(|error| relative(error, mean, "+"));
    let detectable = outcome.visible_in_mean.map(|bias| relative(bias, mean.abs(), ""));
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
