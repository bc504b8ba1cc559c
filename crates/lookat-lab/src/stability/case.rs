//! A case, its table, and its results.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::Serialize;

use super::messages::messages;
use crate::interval::interval;

/// One question with a known answer.
#[derive(Debug, Clone)]
pub struct Case {
    /// A letter and a number: C for cameras, S for spheres and quadrics, T for triangles, P for eyes and lights in a plane, V for
    /// BVHs, secondary rays, samples and pictures, B for BSDFs and lights.
    pub id: &'static str,
    /// A word or two, with hyphens.
    pub name: &'static str,
    /// What must hold, in one line.
    pub claim: &'static str,
    /// The quantity and unit of [`Row::at`]; empty for cases without an axis.
    pub axis: &'static str,
    /// The quantity and unit of [`Row::worst`]; empty if the case measures no error.
    pub error: &'static str,
    /// The largest allowed error. Infinite for a measurement without a limit.
    pub limit: f64,
    /// The seed of the first place. It counts up from place to place.
    seed: u64,
    /// The places on the axis. `None` is a question without a place.
    places: Vec<Option<f64>>,
    measure: Measure,
}

/// Measures lookat at one place.
pub(super) type Measure = fn(&Trial) -> Tally;

/// What a case measures at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    /// Random rays, above 0. Cases with a fixed number of questions ignore it.
    pub rays: u64,
    pub seed: u64,
    /// The place on the axis; NaN without one.
    pub at: f64,
}

/// How often lookat was asked and was wrong, and its largest error otherwise.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally {
    pub tried: u64,
    pub failed: u64,
    pub worst: Option<f64>,
    /// Failures and details in words.
    pub remarks: Vec<String>,
    /// Parts of the answers, by name.
    pub parts: Vec<(&'static str, Tally)>,
}

impl Tally {
    /// Counts an answer.
    pub fn answer(&mut self, is_right: bool) {
        self.tried += 1;
        self.failed += u64::from(!is_right);
    }

    /// Counts an answer with a remark if it is wrong.
    pub fn check(&mut self, is_right: bool, otherwise: impl FnOnce() -> String) {
        self.answer(is_right);
        if !is_right {
            self.remarks.push(otherwise());
        }
    }

    /// Counts a right answer with its error. NaN is a wrong answer.
    pub fn error(&mut self, error: f64) {
        self.answer(!error.is_nan());
        if !error.is_nan() {
            self.worsen(error);
        }
    }

    /// Adds an error of an answer that is already counted.
    pub fn worsen(&mut self, error: f64) {
        self.worst = Some(self.worst.map_or(error, |worst| worst.max(error)));
    }

    pub fn join(mut self, other: Tally) -> Tally {
        self.tried += other.tried;
        self.failed += other.failed;
        self.remarks.extend(other.remarks);
        self.parts.extend(other.parts);
        if let Some(error) = other.worst {
            self.worsen(error);
        }
        self
    }

    /// Adds a copy of some answers as a part.
    pub fn part(mut self, name: &'static str, part: &Tally) -> Tally {
        self.parts.push((name, part.clone()));
        self
    }
}

impl FromIterator<Tally> for Tally {
    fn from_iter<I: IntoIterator<Item = Tally>>(all: I) -> Tally {
        all.into_iter().fold(Tally::default(), Tally::join)
    }
}

/// Tries that share a stream of random numbers.
const CHUNK: u64 = 4096;

/// Calls `attempt` `tries` times with random numbers, on all threads, with the same result on any number of them. Each call of this
/// function needs a `seed` of its own.
pub(super) fn tally(tries: u64, seed: u64, attempt: impl Fn(&mut Pcg64Mcg, &mut Tally) + Sync) -> Tally {
    let chunk = |index: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed << 32 | index);
        let mut tally = Tally::default();
        for _ in 0..CHUNK.min(tries - index * CHUNK) {
            attempt(&mut random, &mut tally);
        }
        tally
    };
    (0..tries.div_ceil(CHUNK)).into_par_iter().map(chunk).reduce(Tally::default, Tally::join)
}

/// The part of all answers.
pub const ALL: &str = "lookat";

/// The answers at one place.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// [`ALL`], or a part of the answers.
    #[serde(rename = "method")]
    pub part: &'static str,
    /// The place on the axis.
    pub at: Option<f64>,
    /// The number of answers.
    pub tried: u64,
    /// The number of wrong answers.
    pub wrong: u64,
    /// The 95 % interval of the share of wrong answers.
    pub interval: [f64; 2],
    /// The largest error of the other answers, if measured.
    pub worst: Option<f64>,
}

/// A case with its results.
#[derive(Debug, Clone, Serialize)]
pub struct Found {
    /// The id of the case.
    pub case: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What must hold.
    pub claim: &'static str,
    /// The quantity of the places.
    pub axis: &'static str,
    /// The quantity of the errors.
    pub error: &'static str,
    /// The largest allowed error. JSON has null for a measurement without a limit.
    pub limit: f64,
    /// True if lookat is always right and as exact as the limit demands.
    pub passes: bool,
    /// One for each place and part.
    pub rows: Vec<Row>,
    /// Failures and details in words.
    pub remarks: Vec<String>,
}

impl Case {
    /// The case of a line of the table: id, name, claim, axis, error, limit, seed, places.
    ///
    /// # Panics
    ///
    /// If the line is malformed.
    pub(super) fn parse(line: &'static str, measure: impl Fn(&str) -> Measure) -> Case {
        let fields: Vec<&str> = line.split('\t').collect();
        let [id, name, claim, axis, error, limit, seed, places] = fields[..] else {
            panic!("not eight fields: {line}")
        };
        let number = |text: &str| text.parse().unwrap_or_else(|_| panic!("not a number: {text}"));
        let place = |text| if text == "-" { None } else { Some(number(text)) };
        let places = places.split(' ').map(place).collect();
        Case {
            id,
            name,
            claim,
            axis,
            error,
            limit: number(limit),
            seed: number(seed) as u64,
            places,
            measure: measure(id),
        }
    }

    /// Runs the case with so many random rays per place, at least 1.
    pub fn run(&self, rays: u64) -> Found {
        let (mut rows, mut remarks) = (Vec::new(), Vec::new());
        for (seed, at) in (self.seed..).zip(&self.places) {
            let answers = (self.measure)(&Trial { rays, seed, at: at.unwrap_or(f64::NAN) });
            // The messages of a case have no place.
            let all = if at.is_none() { messages(self.id).join(answers) } else { answers };
            let mut add = |part, Tally { tried, failed, worst, .. }: &Tally| {
                let interval = interval(*failed, *tried);
                rows.push(Row { part, at: *at, tried: *tried, wrong: *failed, interval, worst: *worst });
            };
            add(ALL, &all);
            all.parts.iter().for_each(|(name, part)| add(name, part));
            remarks.extend(all.remarks);
        }
        let is_right =
            |row: &Row| row.tried > 0 && row.wrong == 0 && row.worst.is_none_or(|worst| worst <= self.limit);
        let passes = rows.iter().filter(|row| row.part == ALL).all(is_right);
        let Case { id, name, claim, axis, error, limit, .. } = *self;
        Found { case: id, name, claim, axis, error, limit, passes, rows, remarks }
    }
}

/// All rows, after a line of names.
pub fn as_csv(results: &[Found]) -> String {
    let mut text =
        String::from("case,name,method,axis,at,tried,wrong,low,high,worst,error,limit,case_passes\n");
    for Found { case, name, axis, error, limit, passes, rows, .. } in results {
        for Row { part, at, tried, wrong, interval: [low, high], worst } in rows {
            let [at, worst] = [at, worst].map(|x| x.map_or(String::new(), |x| format!("{x:e}")));
            // Names have no quotes and no line breaks.
            text += &format!(
                "{case},{name},\"{part}\",\"{axis}\",{at},{tried},{wrong},{low:e},{high:e},{worst},\"{error}\",{limit:e},{passes}\n"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    #[test]
    fn counts_equal_on_any_number_of_threads() {
        let count = || tally(10_000, 7, |random, all| all.error(random.random::<f64>()));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (many, one) = (count(), pool.install(count));
        assert_eq!((many.tried, many.failed, many.worst), (10_000, 0, one.worst));
    }

    #[test]
    fn a_case_fails_if_one_place_does() {
        let run = |at: &'static str| {
            let line: &'static str = format!("X1\tx\tclaim\taxis\terror\t1e-2\t0\t{at}").leak();
            let measure: Measure = |trial| {
                let mut tally = Tally::default();
                tally.error(trial.at);
                tally
            };
            Case::parse(line, |_| measure).run(1)
        };
        assert!(run("0.001 0.01").passes && !run("0.001 0.02").passes);
        // NaN is a wrong answer.
        let without_place = run("-");
        assert!(
            !without_place.passes && without_place.rows[0].wrong == 1 && without_place.rows[0].at.is_none()
        );
    }
}
