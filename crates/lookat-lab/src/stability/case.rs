//! A case, its table, and its results.

use serde::Serialize;

use super::messages::messages;
use super::tally::{Measure, Tally, Trial};
use crate::estimate::interval;

/// One question with a known answer.
#[derive(Debug, Clone, Serialize)]
pub struct Case {
    /// A letter and a number: C for cameras, S for spheres and quadrics, T for triangles, P for eyes and lights in a plane, V for
    /// BVHs, secondary rays, samples and pictures, B for BSDFs and lights.
    #[serde(rename = "case")]
    pub id: &'static str,
    /// A word or two, with hyphens.
    pub name: &'static str,
    /// What must hold, in one line.
    pub claim: &'static str,
    /// The quantity and unit of [`Row::at`]; empty for cases without an axis.
    pub axis: &'static str,
    /// The quantity and unit of [`Row::worst`]; empty if the case measures no error.
    pub error: &'static str,
    /// The largest allowed error. Infinite for a measurement without a limit, for which JSON has null.
    pub limit: f64,
    /// The seed of the first place. It counts up from place to place.
    #[serde(skip)]
    seed: u64,
    /// The places on the axis. `None` is a question without a place.
    #[serde(skip)]
    places: Vec<Option<f64>>,
    #[serde(skip)]
    measure: Measure,
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
pub struct CaseResult {
    /// The case.
    #[serde(flatten)]
    pub case: Case,
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
    pub fn run(&self, rays: u64) -> CaseResult {
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
        CaseResult { case: self.clone(), passes, rows, remarks }
    }
}

/// All rows, after a line of names.
pub fn as_csv(results: &[CaseResult]) -> String {
    let mut text =
        String::from("case,name,method,axis,at,tried,wrong,low,high,worst,error,limit,case_passes\n");
    for CaseResult { case: Case { id, name, axis, error, limit, .. }, passes, rows, .. } in results {
        for Row { part, at, tried, wrong, interval: [low, high], worst } in rows {
            let [at, worst] = [at, worst].map(|x| x.map_or(String::new(), |x| format!("{x:e}")));
            // Names have no quotes and no line breaks.
            text += &format!(
                "{id},{name},\"{part}\",\"{axis}\",{at},{tried},{wrong},{low:e},{high:e},{worst},\"{error}\",{limit:e},{passes}\n"
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

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
