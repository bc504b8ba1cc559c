//! `lookat stability`: numerical tests of lookat.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_image::write_file;
use lookat_lab::estimate::interval;
use lookat_lab::stability::{ALL, Case, CaseResult, Row, as_csv, cases};
use lookat_scene::syntax::nearest;

use crate::args::Stability;
use crate::failure::Failure;
use crate::output::{Destination, check_folder, make_folder};
use lookat_sight::digits;

/// Runs the command.
pub fn stability(arguments: &Stability) -> ExitCode {
    crate::exit_code(run(arguments).map(|passes| u8::from(!passes)))
}

/// Runs the cases. True if all pass.
fn run(arguments: &Stability) -> Result<bool, Failure> {
    let cases = chosen(&arguments.case)?;
    if let Some(folder) = &arguments.output {
        make_folder(folder)?;
        TABLES.iter().try_for_each(|name| check_folder(&folder.join(name)))?;
    }
    let mut destination = arguments.output.as_deref().map(Destination::new);
    let mut results = Vec::new();
    for case in cases {
        let found = case.run(arguments.rays);
        if !arguments.json {
            crate::print(&as_text(&found))?;
        }
        results.push(found);
        // After each case, so that an interrupted run leaves its results.
        if let Some(destination) = &mut destination {
            write_tables(&results, destination)?;
        }
    }
    if arguments.json { crate::print_json(&results) } else { crate::print(&totals(&results)) }?;
    destination.map_or(Ok(()), |destination| destination.result())?;
    Ok(results.iter().all(|found| found.passes))
}

/// The tables of all cases.
const TABLES: [&str; 2] = ["stability.csv", "stability.json"];

fn write_tables(results: &[CaseResult], destination: &mut Destination) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(results).map_err(|error| error.to_string())?;
    TABLES.iter().zip([as_csv(results), json + "\n"]).try_for_each(|(name, text)| {
        destination.write(name.as_ref(), |path| write_file(path, text.as_bytes())).map(drop)
    })
}

/// The cases with these names or family letters. All cases without names.
fn chosen(names: &[String]) -> Result<Vec<Case>, Failure> {
    let all = cases();
    let is = |case: &Case, name: &str| {
        let letter = name.len() == 1 && case.id.starts_with(&name.to_uppercase());
        letter || case.id.eq_ignore_ascii_case(name) || case.name.eq_ignore_ascii_case(name)
    };
    if let Some(unknown) = names.iter().find(|name| !all.iter().any(|case| is(case, name))) {
        if let Some(near) = nearest(unknown, all.iter().map(|case| case.name)) {
            bail!("unknown case `{unknown}`; did you mean `{near}`?");
        }
        let list: Vec<String> = all.iter().map(|case| format!("{} {}", case.id, case.name)).collect();
        bail!("unknown case `{unknown}`; the cases are {}", list.join(", "));
    }
    let wanted = |case: &Case| names.is_empty() || names.iter().any(|name| is(case, name));
    Ok(all.into_iter().filter(wanted).collect())
}

/// The last line: the number of cases that pass.
fn totals(results: &[CaseResult]) -> String {
    let judged: Vec<&CaseResult> = results.iter().filter(|found| found.case.limit.is_finite()).collect();
    let passed = judged.iter().filter(|found| found.passes).count();
    let measured = results.len() - judged.len();
    let rest = if measured > 0 { format!(", {measured} measured only") } else { String::new() };
    format!("{passed} of {} cases pass{rest}\n", judged.len())
}

/// The fewest answers that count as a random sample.
const SAMPLE: u64 = 1000;
/// The most remarks printed for a case.
const MOST_REMARKS: usize = 10;

/// One case as text.
fn as_text(found: &CaseResult) -> String {
    let verdict = match (found.passes, found.case.limit.is_finite()) {
        (true, true) => "pass",
        (true, false) => "measured",
        (false, _) => "FAIL",
    };
    let mut text = format!("{} {}: {verdict}\n    {}\n", found.case.id, found.case.name, found.case.claim);
    let all: Vec<&Row> = found.rows.iter().filter(|row| row.part == ALL).collect();
    let (tried, wrong) = all.iter().fold((0, 0), |sum, row| (sum.0 + row.tried, sum.1 + row.wrong));
    let _ = write!(text, "    {wrong} of {tried} wrong");
    // A few fixed questions are not a random sample.
    if tried >= SAMPLE {
        let [low, high] = interval(wrong, tried).map(short);
        let _ = write!(text, " (95 % interval {low} to {high})");
    }
    text.push('\n');
    if let Some(worst) = all.iter().filter_map(|row| row.worst).reduce(f64::max) {
        let limit = if found.case.limit.is_finite() {
            format!("limit {}", short(found.case.limit))
        } else {
            "no limit".into()
        };
        let _ = writeln!(text, "    largest {}: {} ({limit})", found.case.error, short(worst));
    }
    let is_wrong = |row: &&&Row| row.wrong > 0 || row.worst.is_some_and(|worst| worst > found.case.limit);
    for Row { at, tried, wrong, worst, .. } in all.iter().filter(is_wrong) {
        let place = at.map_or(String::new(), |at| format!(" at {} {}", found.case.axis, short(at)));
        let worst = worst.map_or(String::new(), |worst| format!(", largest error {}", short(worst)));
        let _ = writeln!(text, "    {wrong} of {tried} wrong{place}{worst}");
    }
    for remark in found.remarks.iter().take(MOST_REMARKS) {
        let _ = writeln!(text, "    {remark}");
    }
    text + "\n"
}

/// A number with three digits.
fn short(x: f64) -> String {
    digits(x, 3)
}
