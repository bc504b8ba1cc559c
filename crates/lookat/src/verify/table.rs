//! The rows that `lookat verify` prints.

use std::path::{Path, PathBuf};

use lookat_image::mean;
use serde_json::{Map, Value, json};

use super::{Compared, Outcome, Verdict, name};
use crate::metric::Metric;
use crate::visible::visible;

/// Prints to standard output, for people or as JSON.
pub struct Table {
    json: bool,
    /// The longest name.
    width: usize,
}

/// The metrics that have a column.
const COLUMNS: [Metric; 3] = [Metric::Rmse, Metric::Flip, Metric::NoiseP];

impl Table {
    pub fn new(scenes: &[PathBuf], json: bool) -> Table {
        let length = |scene: &PathBuf| name(Path::new(scene)).chars().count();
        Table { json, width: scenes.iter().map(length).max().unwrap_or(0).max(5) }
    }

    pub fn header(&self) -> Result<(), String> {
        let columns = COLUMNS.map(|metric| format!("{:>10}", metric.name())).concat();
        let line = format!("{:width$} verdict {:>10}{columns}  ", "scene", "error", width = self.width);
        if self.json { Ok(()) } else { print(line.trim_end()) }
    }

    pub fn row(&self, outcome: &Outcome) -> Result<(), String> {
        if self.json {
            return crate::print_json(&as_json(outcome));
        }
        let columns = outcome.compared.as_ref().map_or(String::new(), columns);
        let (name, verdict, reason) =
            (visible(&outcome.name), outcome.verdict.word(), visible(&outcome.reason));
        print(&format!("{name:width$} {verdict:7} {columns:40}  {reason}", width = self.width))
    }

    pub fn footer(&self, verdicts: &[Verdict]) -> Result<(), String> {
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

fn print(line: &str) -> Result<(), String> {
    crate::print(&format!("{line}\n"))
}

/// The mean error, in percent if it can be, and some metrics.
fn columns(compared: &Compared) -> String {
    let value = |metric: Metric| compared.measurement.value(metric);
    let percent = value(Metric::Error).map(|error| match mean(&compared.pair.expected) {
        0.0 => format!("{error:+.2e}"),
        mean => format!("{:+.3} %", 100.0 * error / mean),
    });
    let others = COLUMNS.iter().map(|metric| value(*metric).map(crate::metric::number));
    std::iter::once(percent).chain(others).map(|text| format!("{:>10}", text.unwrap_or("-".into()))).collect()
}

fn as_json(outcome: &Outcome) -> Value {
    let metrics = outcome.compared.iter().flat_map(|compared| &compared.measurement.metrics);
    let metrics: Map<String, Value> =
        metrics.map(|line| (line.metric.name().into(), json!(line.value))).collect();
    let compared = outcome.compared.as_ref();
    json!({
        "scene": outcome.name,
        "verdict": outcome.verdict.word(),
        "reason": outcome.reason,
        "updated": outcome.updated,
        "metrics": metrics,
        "samples_per_pixel": compared.map(|compared| compared.samples_per_pixel),
        "seconds": compared.map(|compared| compared.seconds),
    })
}
