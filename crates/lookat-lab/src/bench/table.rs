//! What is measured, as plain data.

use std::time::Instant;

/// Measured numbers: a line for each thing, a column for each quantity.
#[derive(Debug, Clone)]
pub struct BenchTable {
    /// A word for programs.
    pub name: &'static str,
    /// What was done, for people.
    pub title: String,
    /// The quantities, with units.
    pub columns: Vec<&'static str>,
    /// The things.
    pub rows: Vec<BenchRow>,
}

/// A line of a table.
#[derive(Debug, Clone)]
pub struct BenchRow {
    /// What it is about.
    pub name: String,
    /// As many as there are columns.
    pub cells: Vec<Cell>,
}

/// A quantity over all rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Half of the rounds have less. Not a number where there is nothing to measure.
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
        let row = |(name, own): (String, &Vec<T>)| {
            let rounds = || own.iter().zip(&measured[0]);
            let cells =
                columns.iter().map(|(_, value)| Cell::of(rounds().map(|(own, first)| value(own, first))));
            BenchRow { name, cells: cells.collect() }
        };
        let rows = names.into_iter().zip(&measured).map(row).collect();
        BenchTable { name, title, columns: columns.iter().map(|column| column.0).collect(), rows }
    }
}

impl Cell {
    /// Of the values of all rounds, at least one.
    pub(super) fn of(values: impl IntoIterator<Item = f64>) -> Cell {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        let at = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
        Cell { median: 0.5 * (at(last / 2) + at(last.div_ceil(2))), low: at(0), high: at(last) }
    }

    /// Half the distance from the least to the most, as a share of the median.
    pub fn spread(&self) -> f64 {
        0.5 * (self.high - self.low) / self.median
    }
}

/// The machine that is measured.
#[derive(Debug, Clone)]
pub struct Machine {
    /// The name that the processor has for itself, or that of its architecture.
    pub processor: String,
    /// Threads that run side by side.
    pub threads: usize,
    /// The instructions that rays are traced with.
    pub simd: &'static str,
}

impl Machine {
    /// This one.
    pub fn here() -> Machine {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Machine { processor: processor(), threads, simd: lookat_render::simd() }
    }
}

/// As Linux says it; elsewhere the architecture.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or(std::env::consts::ARCH, |(_, name)| name.trim()).into()
}

/// For each thing what was measured in all rounds.
pub(super) fn in_turn<T>(rounds: usize, things: usize, mut measure: impl FnMut(usize) -> T) -> Vec<Vec<T>> {
    let mut values: Vec<Vec<T>> = (0..things).map(|_| Vec::with_capacity(rounds)).collect();
    for _ in 0..rounds.max(1) {
        values.iter_mut().enumerate().for_each(|(thing, values)| values.push(measure(thing)));
    }
    values
}

/// How long something takes, in seconds, and what it gives.
pub(super) fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let started = Instant::now();
    let result = std::hint::black_box(run());
    (started.elapsed().as_secs_f64(), result)
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
