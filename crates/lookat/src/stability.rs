//! `lookat stability`: numerical tests of lookat and of other methods.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_image::write_file;
use lookat_lab::interval::interval;
use lookat_lab::stability::{Case, Effort, Found, LOOKAT, Row, as_csv, as_json, cases};
use lookat_scene::syntax::nearest;

use crate::args::Stability;
use crate::output::{Destination, check_folder, make_folder};

/// Runs the command.
pub fn stability(arguments: &Stability) -> ExitCode {
    crate::exit_code(run(arguments).map(|passes| u8::from(!passes)))
}

/// Runs the cases. True if all pass.
fn run(arguments: &Stability) -> Result<bool, crate::Failure> {
    let cases = chosen(&arguments.case)?;
    if let Some(folder) = &arguments.output {
        make_folder(folder)?;
        let charts = cases.iter().flat_map(|case| ["svg", "png"].map(|ending| chart_name(case, ending)));
        TABLES
            .map(String::from)
            .into_iter()
            .chain(charts)
            .try_for_each(|name| check_folder(&folder.join(name)))?;
    }
    let mut destination = arguments.output.as_deref().map(Destination::new);
    let effort = Effort { rays: arguments.rays };
    let mut results = Vec::new();
    for case in cases {
        let found = case.run(&effort);
        if !arguments.json {
            crate::print(&as_text(&case, &found))?;
        }
        if let Some(destination) = &mut destination {
            draw(&case, &found, destination)?;
        }
        results.push((case, found));
        if let Some(destination) = &mut destination {
            write_tables(&results, destination)?;
        }
    }
    let passes = results.iter().all(|(case, found)| found.passes(case));
    let printed = match arguments.json {
        true => crate::print_json(&as_json(&results)),
        false => crate::print(&totals(&results)),
    };
    printed?;
    destination.map_or(Ok(()), |destination| destination.result())?;
    Ok(passes)
}

/// The tables of all cases.
const TABLES: [&str; 2] = ["stability.csv", "stability.json"];

/// Writes the tables so far, so that an interrupted run leaves its results.
fn write_tables(results: &[(Case, Found)], destination: &mut Destination) -> Result<(), crate::Failure> {
    let texts = [as_csv(results), format!("{:#}\n", as_json(results))];
    TABLES.iter().zip(texts).try_for_each(|(name, text)| write(name, text.as_bytes(), destination))
}

/// The cases with these names or family letters. All cases without names.
fn chosen(names: &[String]) -> Result<Vec<Case>, crate::Failure> {
    let all = cases();
    let is = |case: &Case, name: &str| {
        let letter = name.len() == 1 && case.id.starts_with(&name.to_uppercase());
        letter || case.id.eq_ignore_ascii_case(name) || case.name.eq_ignore_ascii_case(name)
    };
    if let Some(unknown) = names.iter().find(|name| !all.iter().any(|case| is(case, name))) {
        if let Some(near) = nearest(unknown, all.iter().map(|case| case.name)) {
            return Err(format!("unknown case `{unknown}`; did you mean `{near}`?").into());
        }
        crate::say("the cases are");
        all.iter().for_each(|case| crate::say(&format!("    {:4} {}", case.id, case.name)));
        return Err(format!("unknown case `{unknown}`").into());
    }
    let wanted = |case: &Case| names.is_empty() || names.iter().any(|name| is(case, name));
    Ok(all.into_iter().filter(wanted).collect())
}

/// The last line: the number of cases that pass.
fn totals(results: &[(Case, Found)]) -> String {
    let judged: Vec<_> = results.iter().filter(|(case, _)| case.limit.is_finite()).collect();
    let passed = judged.iter().filter(|(case, found)| found.passes(case)).count();
    let measured = results.len() - judged.len();
    let rest = if measured > 0 { format!(", {measured} measured only") } else { String::new() };
    format!("{passed} of {} cases pass{rest}\n", judged.len())
}

/// One case as text.
fn as_text(case: &Case, found: &Found) -> String {
    let verdict = match (found.passes(case), case.limit.is_finite()) {
        (true, true) => "pass",
        (true, false) => "measured",
        (false, _) => "FAIL",
    };
    let mut text = format!("{} {}: {verdict}\n    {}\n", case.id, case.name, case.claim);
    let own: Vec<&Row> = found.rows.iter().filter(|row| row.method == LOOKAT).collect();
    let (tried, failed) = own.iter().fold((0, 0), |sum, row| (sum.0 + row.tried, sum.1 + row.failed));
    let _ = write!(text, "    lookat: {failed} of {tried} wrong");
    // A few fixed questions are not a random sample.
    if tried >= SAMPLE {
        let [low, high] = interval(failed, tried).map(share);
        let _ = write!(text, " (95 % interval {low} to {high})");
    }
    text.push('\n');
    let worst = own.iter().filter_map(|row| row.worst).fold(f64::NEG_INFINITY, f64::max);
    if worst.is_finite() {
        let limit =
            if case.limit.is_finite() { format!("limit {}", share(case.limit)) } else { "not judged".into() };
        let _ = writeln!(text, "    largest {}: {} ({limit})", case.error, share(worst));
    }
    let places = found.places();
    if places.len() > 1 || found.rows.iter().any(|row| row.method != LOOKAT) {
        let errors = own.iter().any(|row| row.worst.is_some())
            && found.rows.iter().any(|row| row.method != LOOKAT && row.worst.is_some());
        if !errors || found.rows.iter().any(|row| row.failed > 0) {
            matrix(&mut text, "fraction of wrong answers", case, found, &places, |row| {
                Some(row.failed as f64 / row.tried as f64)
            });
        }
        if errors {
            matrix(&mut text, case.error, case, found, &places, |row| row.worst);
        }
    }
    for remark in found.remarks.iter().take(MOST_REMARKS) {
        let _ = writeln!(text, "    {remark}");
    }
    text + "\n"
}

/// The fewest answers that count as a random sample.
const SAMPLE: u64 = 1000;
/// The most remarks printed for a case.
const MOST_REMARKS: usize = 10;

/// A table with a row per method and a column per place.
fn matrix(
    text: &mut String,
    title: &str,
    case: &Case,
    found: &Found,
    places: &[Option<f64>],
    value: impl Fn(&Row) -> Option<f64>,
) {
    let by = if case.axis.is_empty() { String::new() } else { format!(", by {}", case.axis) };
    let _ = writeln!(text, "    {title}{by}");
    let cells = |cell: &dyn Fn(&Option<f64>) -> String| {
        places.iter().map(|place| format!("{:>9}", cell(place))).collect::<String>()
    };
    let width = found.rows.iter().map(|row| row.method.chars().count()).max().unwrap_or(0) + 1;
    if places.len() > 1 {
        let _ = writeln!(text, "    {:width$}{}", "", cells(&|place| place.map_or("other".into(), share)));
    }
    for method in found.methods() {
        let at = |place: &Option<f64>| found.rows.iter().find(|row| row.method == method && row.at == *place);
        let line = cells(&|place| at(place).and_then(&value).map_or("-".into(), share));
        let _ = writeln!(text, "    {method:width$}{line}");
    }
}

/// Formats a number with two digits.
fn share(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        0.01..1000.0 | -1000.0..-0.01 => {
            let text = format!("{x:.3}");
            text.trim_end_matches('0').trim_end_matches('.').into()
        }
        _ => format!("{x:.1e}"),
    }
}

/// The file of a case's chart.
fn chart_name(case: &Case, ending: &str) -> String {
    format!("{}-{}.{ending}", case.id, case.name)
}

fn draw(case: &Case, found: &Found, destination: &mut Destination) -> Result<(), crate::Failure> {
    let cannot = |error| format!("cannot draw {}: {error}", case.id);
    let Some(plot) = lookat_lab::stability::draw(case, found).map_err(cannot)? else { return Ok(()) };
    write(&chart_name(case, "svg"), plot.svg.as_bytes(), destination)?;
    write(&chart_name(case, "png"), &plot.png().map_err(cannot)?, destination)
}

fn write(name: &str, bytes: &[u8], destination: &mut Destination) -> Result<(), crate::Failure> {
    destination.write(name.as_ref(), |path| write_file(path, bytes)).map(drop)
}
