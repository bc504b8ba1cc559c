//! Lens files: four numbers for each surface, from the scene to the film, and comments after `#`.

use lookat_syntax::{Diagnostic, Text};

use crate::params::Params;

/// The most surfaces of a lens.
const MOST_SURFACES: usize = 256;
/// The largest number: far above a flat surface, written as a large radius.
const LARGEST: f64 = 1e9;
/// The smallest opening, and the smallest radius that is not 0.
pub(super) const SMALLEST: f64 = 1e-6;

/// A surface in a lens file. Lengths are in millimeters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensRow {
    /// Positive if the center of curvature is on the side of the film. 0 is the aperture stop.
    pub curvature_radius: f64,
    /// The distance to the next surface.
    pub thickness: f64,
    /// The index of refraction between this surface and the next. 0 is air.
    pub eta: f64,
    /// The diameter of the opening.
    pub aperture_diameter: f64,
    /// The line in the file.
    pub line: usize,
}

/// A number and its line.
#[derive(Clone, Copy)]
struct Entry {
    number: f64,
    line: usize,
}

/// The surfaces in the lens file of a camera. Reports a file that is no lens and returns `None`.
pub(super) fn lens_rows(params: &mut Params, file: &Text) -> Option<Vec<LensRow>> {
    let (path, bytes) = params.file(file, |files, name, span| files.read_named(name, span))?;
    let text = String::from_utf8_lossy(&bytes);
    let place = |line: usize| format!("{} line {line}", path.display());
    match entries(&text).and_then(|entries| rows(&entries)) {
        Ok(rows) => Some(rows),
        Err(Fault { line, what, help }) => {
            params.error_surely(Diagnostic::error(file.span, format!("{}: {what}", place(line))).help(help));
            None
        }
    }
}

/// What is wrong with a lens file.
#[derive(Debug)]
struct Fault {
    line: usize,
    what: String,
    help: &'static str,
}

const FORM: &str = "a surface has 4 numbers: its radius of curvature, the distance to the next surface, the index of refraction behind it, \
    and the diameter of its opening";

/// The numbers of a file.
fn entries(text: &str) -> Result<Vec<Entry>, Fault> {
    let mut entries = Vec::new();
    for (line, text) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        for word in text.split('#').next().unwrap_or_default().split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.abs() <= LARGEST => entries.push(Entry { number, line }),
                Ok(_) => {
                    let what = format!("`{word}` is too large; the limit is {LARGEST:e}");
                    return Err(Fault { line, what, help: "lengths are in millimeters" });
                }
                Err(_) => {
                    let help = "write numbers with blanks between them, and comments after #";
                    return Err(Fault { line, what: format!("`{word}` is not a number"), help });
                }
            }
        }
    }
    Ok(entries)
}

/// The surfaces, with the numbers checked.
fn rows(entries: &[Entry]) -> Result<Vec<LensRow>, Fault> {
    let (fours, rest) = entries.as_chunks::<4>();
    if !rest.is_empty() || fours.is_empty() {
        let uneven = entries.chunk_by(|a, b| a.line == b.line).find(|line| line.len() != 4);
        let (line, found) = uneven.map_or((1, 0), |line| (line[0].line, line.len()));
        let what = match found {
            0 => "the lens has no surface".into(),
            1 => "1 number instead of 4".into(),
            found => format!("{found} numbers instead of 4"),
        };
        return Err(Fault { line, what, help: FORM });
    }
    if fours.len() > MOST_SURFACES {
        let what = format!("a lens has at most {MOST_SURFACES} surfaces");
        return Err(Fault {
            line: fours[MOST_SURFACES][0].line,
            what,
            help: "check that this is a lens file",
        });
    }
    let rows = fours.iter().map(|four| row(four, fours.len())).collect::<Result<Vec<_>, _>>()?;
    if let Some(LensRow { eta, line, .. }) = rows.last().filter(|last| last.eta > 1.0) {
        let what = format!("the index of refraction behind the last surface is {eta}");
        return Err(Fault { line: *line, what, help: "there is air before the film: write 1" });
    }
    Ok(rows)
}

fn row(four: &[Entry; 4], count: usize) -> Result<LensRow, Fault> {
    let [curvature_radius, thickness, eta, aperture_diameter] = four.map(|entry| entry.number);
    let fault = |at: usize, what: String, help| Err(Fault { line: four[at].line, what, help });
    // The camera moves the film: its distance in the file, after the last surface, does not count.
    if thickness < 0.0 && count > 1 {
        let help = "write the surfaces from the scene to the film, with distances of 0 or more";
        return fault(1, format!("the distance to the next surface is negative: {thickness}"), help);
    }
    if eta != 0.0 && !(1.0..=10.0).contains(&eta) {
        let help = "glass has an index of about 1.4 to 2, and air has 1";
        return fault(2, format!("the index of refraction is {eta}, not from 1 to 10"), help);
    }
    if curvature_radius != 0.0 && curvature_radius.abs() < SMALLEST {
        let help = "radii are in millimeters; 0 is the aperture stop";
        return fault(0, format!("the radius of curvature is too small: {curvature_radius}"), help);
    }
    if aperture_diameter < SMALLEST {
        let help = "the fourth number is the diameter of the surface's opening in millimeters, above 0";
        return fault(3, format!("the opening has a diameter of {aperture_diameter}: no light passes"), help);
    }
    Ok(LensRow { curvature_radius, thickness, eta, aperture_diameter, line: four[0].line })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Vec<LensRow>, Fault> {
        entries(text).and_then(|entries| rows(&entries))
    }

    #[test]
    fn surfaces_are_read_with_their_lines() {
        let text =
            "\u{feff}# radius distance eta opening\n\n 30 4 1.5 20 # front\n\t-3e1 0 1\r\n20 0 2 0 5\n";
        let rows = parsed(text).unwrap();
        let front =
            LensRow { curvature_radius: 30.0, thickness: 4.0, eta: 1.5, aperture_diameter: 20.0, line: 3 };
        let back = LensRow { curvature_radius: -30.0, thickness: 0.0, eta: 1.0, line: 4, ..front };
        let stop =
            LensRow { curvature_radius: 0.0, thickness: 2.0, eta: 0.0, aperture_diameter: 5.0, line: 5 };
        assert_eq!(rows, [front, back, stop]);
    }

    #[test]
    fn files_that_are_no_lens_are_refused_at_a_line() {
        for (text, line, what) in [
            ("", 1, "the lens has no surface"),
            ("# none\n", 1, "the lens has no surface"),
            ("1 2 1.5 4\n1 2 1.5\n", 2, "3 numbers instead of 4"),
            ("1 2 1.5 4\n\n1 2 1.5 4 5\n", 3, "5 numbers instead of 4"),
            ("1 2 1.5 4\n1 2 glass 4", 2, "`glass` is not a number"),
            ("1,0 2 1.5 4", 1, "`1,0` is not a number"),
            ("1 nan 1.5 4", 1, "`nan` is too large; the limit is 1e9"),
            ("1 2 1.5 1e10", 1, "`1e10` is too large; the limit is 1e9"),
            ("1 2 1.5 0", 1, "the opening has a diameter of 0: no light passes"),
            ("1e-9 2 1.5 4", 1, "the radius of curvature is too small: 0.000000001"),
            ("1 2 1.5 -4", 1, "the opening has a diameter of -4: no light passes"),
            ("1 2 1.5 4\n1 -2 1 4", 2, "the distance to the next surface is negative: -2"),
            ("1 2 1.5 4\n1 2 1.33 4", 2, "the index of refraction behind the last surface is 1.33"),
            ("1 2 0.5 4", 1, "the index of refraction is 0.5, not from 1 to 10"),
        ] {
            let fault = parsed(text).unwrap_err();
            assert_eq!((fault.line, &fault.what[..]), (line, what), "{text}");
        }
        let many = parsed(&"1 2 1.5 4\n".repeat(MOST_SURFACES + 1)).unwrap_err();
        assert_eq!((many.line, &many.what[..]), (MOST_SURFACES + 1, "a lens has at most 256 surfaces"));
    }
}
