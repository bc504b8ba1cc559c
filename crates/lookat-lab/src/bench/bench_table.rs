//! Tables of measured numbers.

use std::fmt::{Display, Formatter, Result};
use std::iter::once;

use serde::Serialize;

use crate::estimate::Estimate;
use crate::table::{aligned, significant};

/// A row for each measured thing, a column for each quantity.
#[derive(Debug, Clone, Serialize)]
pub(super) struct BenchTable {
    /// The name, for programs.
    pub name: &'static str,
    /// What was measured, for people.
    pub title: String,
    /// The quantities, with units.
    pub columns: Vec<&'static str>,
    /// The measured things.
    pub rows: Vec<BenchRow>,
}

/// A row of a table.
#[derive(Debug, Clone, Serialize)]
pub(super) struct BenchRow {
    /// The measured thing.
    pub name: String,
    /// One per column.
    pub cells: Vec<Cell>,
}

/// A quantity over all rounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Cell {
    /// The median; NaN without a measurement.
    pub median: f64,
    /// The least of all rounds.
    pub low: f64,
    /// The most of all rounds.
    pub high: f64,
}

/// A column of a table: the quantity with its unit, and its value by what was measured of a thing and, in the same round, of the
/// first thing.
pub(super) type Column<T> = (&'static str, fn(&T, &T) -> f64);

impl BenchTable {
    /// Measures things in turn, round by round; `measure` takes the number of one.
    pub(super) fn measured<T>(
        (name, title): (&'static str, String),
        columns: &[Column<T>],
        names: Vec<String>,
        rounds: usize,
        measure: impl FnMut(usize) -> T,
    ) -> BenchTable {
        let measured = in_turn(rounds, names.len(), measure);
        BenchTable::of((name, title), columns, names.into_iter().zip(measured).collect())
    }

    /// The table of what was measured of each thing, by its name, in all rounds.
    pub(super) fn of<T>(
        (name, title): (&'static str, String),
        columns: &[Column<T>],
        things: Vec<(String, Vec<T>)>,
    ) -> BenchTable {
        let row = |(name, own): &(String, Vec<T>)| {
            let rounds = || own.iter().zip(&things[0].1);
            let cell = |(_, value): &Column<T>| Cell::of(rounds().map(|(own, first)| value(own, first)));
            BenchRow { name: name.clone(), cells: columns.iter().map(cell).collect() }
        };
        let rows = things.iter().map(row).collect();
        BenchTable { name, title, columns: columns.iter().map(|column| column.0).collect(), rows }
    }
}

impl Cell {
    /// Of the values of all rounds, at least one.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Cell {
        let values: Vec<f64> = values.into_iter().collect();
        let Estimate { value: median, interval: [low, high] } = Estimate::median(&values);
        Cell { median, low, high }
    }

    /// Half the distance from the least to the most, as a share of the median.
    fn spread(&self) -> f64 {
        0.5 * (self.high - self.low) / self.median
    }

    /// Three digits and the spread; - without a measurement. If only other cells have a spread, pads to the same width.
    fn text(&self, is_spread: bool) -> String {
        let (digits, pad) = (significant(self.median, 3), if is_spread { "     " } else { "" });
        if self.median.is_nan() {
            format!("-{pad}")
        } else if self.low == self.high {
            format!("{digits}{pad}")
        } else {
            format!("{digits} ({:2.0})", 100.0 * self.spread())
        }
    }
}

/// The table with aligned columns.
impl Display for BenchTable {
    fn fmt(&self, f: &mut Formatter) -> Result {
        let is_spread = self.rows.iter().flat_map(|row| &row.cells).any(|cell| cell.low < cell.high);
        let mut lines = vec![once("").chain(self.columns.iter().copied()).map(String::from).collect()];
        lines.extend(self.rows.iter().map(|BenchRow { name, cells }| {
            once(name.clone()).chain(cells.iter().map(|cell| cell.text(is_spread))).collect()
        }));
        writeln!(f, "{}: {}", self.name, self.title)?;
        aligned(&lines).lines().try_for_each(|line| writeln!(f, "  {line}"))?;
        writeln!(f)
    }
}

/// The measured machine.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Machine {
    /// The name of the processor, or its architecture.
    pub processor: String,
    /// Hardware threads.
    pub threads: usize,
    /// The instruction set of packets of rays.
    pub simd: &'static str,
}

impl Machine {
    /// This one.
    pub fn here() -> Machine {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Machine { processor: processor(), threads, simd: lookat_render::simd() }
    }

    /// The heading of a report: version, machine and number of rounds.
    pub(super) fn head(&self, version: &str, rounds: u16) -> String {
        let Machine { processor, threads, simd } = self;
        let rounds = match rounds {
            1 => "one round".into(),
            _ => format!("medians of {rounds} rounds; in brackets, half the range in percent"),
        };
        format!("lookat {version}, {processor}, threads: {threads}, SIMD: {simd}\n{rounds}\n\n")
    }
}

/// The processor's name on Linux; elsewhere its architecture.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or(std::env::consts::ARCH, |(_, name)| name.trim()).into()
}

/// The measurements of each thing in all rounds.
pub(super) fn in_turn<T>(rounds: usize, things: usize, mut measure: impl FnMut(usize) -> T) -> Vec<Vec<T>> {
    let mut values: Vec<Vec<T>> = (0..things).map(|_| Vec::with_capacity(rounds)).collect();
    for _ in 0..rounds.max(1) {
        values.iter_mut().enumerate().for_each(|(thing, values)| values.push(measure(thing)));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        let odd = Cell::of([5.0, 1.0, 2.0]);
        assert_eq!((odd.median, odd.low, odd.high, odd.spread()), (2.0, 1.0, 5.0, 1.0));
        assert_eq!(Cell::of([4.0, 1.0, 2.0, 8.0]).median, 3.0);
        assert_eq!(Cell::of([7.0]), Cell { median: 7.0, low: 7.0, high: 7.0 });
    }

    #[test]
    fn rounds_go_over_all_things_in_turn() {
        let mut order = Vec::new();
        let values = in_turn(2, 3, |thing| {
            order.push(thing);
            10 * thing
        });
        assert_eq!(order, [0, 1, 2, 0, 1, 2]);
        assert_eq!(values, [[0, 0], [10, 10], [20, 20]]);
    }
}
