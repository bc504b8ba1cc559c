//! Texts without a right picture must be refused, or warned of, by a message that tells what and where: C7, C8, C11, C15,
//! C19 and C20.

use std::panic::catch_unwind;

use lookat_scene::syntax::Severity;

use super::text;
use crate::stability::prelude::*;

/// Options that need a message: see its first line.
const REFUSED: &str = include_str!("refused.tsv");

/// Checks that each text of a case gets one message, with the right words and place; and that there is a scene exactly if the
/// message is a warning.
pub(super) fn refused(case: &str) -> Found {
    let mut found = Found::default();
    for line in REFUSED.lines() {
        let fields: Vec<&str> = line.split('\t').collect();
        if let [id, severity, options, says, at] = fields[..]
            && id == case
        {
            let severity = if severity == "warning" { Severity::Warning } else { Severity::Error };
            let options = options.replace("\\n", "\n");
            let answer = catch_unwind(|| problem(severity, &options, says, at));
            let problem = answer.unwrap_or_else(|_| Some("panics".into()));
            found.check(problem.is_none(), || format!("{options}: {}", problem.unwrap_or_default()));
        }
    }
    found
}

/// What is wrong with the answer to a text.
fn problem(severity: Severity, options: &str, says: &str, at: &str) -> Option<String> {
    let text = text(&format!("Film \"image\"\n{options}"));
    let loaded = load(&text);
    let [problem] = &loaded.diagnostics[..] else {
        let messages: Vec<&str> = loaded.diagnostics.iter().map(|problem| problem.message.as_str()).collect();
        return Some(format!("not one message but {}: {}", messages.len(), messages.join("; ")));
    };
    let span = problem.span();
    let underlined = text.get(span.start as usize..span.end as usize).unwrap_or_default();
    let line = 1 + text[..text.find(at)?].matches('\n').count();
    let is_right = problem.severity == severity
        && problem.message.contains(says)
        && underlined == at
        && loaded.sources.location(span).line == line
        && loaded.scene.is_some() == (severity == Severity::Warning);
    (!is_right).then(|| format!("{:?} `{}` at `{underlined}`", problem.severity, problem.message))
}

/// A reversed window turns the picture.
pub(super) fn screen_window(_: &Effort) -> Found {
    let mut found = refused("C15");
    for kind in ["perspective", "orthographic"] {
        let views = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            scene(&text(&format!(
                "Camera \"{kind}\" \"float screenwindow\" {edges}
                 Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 48"
            )))
        });
        let [plain, reversed] = views.each_ref().map(Probe::new);
        for film in [DVec2::new(0.0, 0.0), DVec2::new(5.0, 40.0), DVec2::new(63.5, 1.25)] {
            let u = DVec2::splat(0.5);
            let (a, b) = (plain.camera_ray(film, u), reversed.camera_ray(DVec2::new(64.0, 48.0) - film, u));
            let is_mirrored = (a.d - b.d).length().max((a.o - b.o).length()) < 1e-15;
            found.check(is_mirrored, || format!("{kind}, reversed window: {a:?} is not {b:?}"));
        }
    }
    found
}

/// Decimal numbers are read as the nearest number with 53 bits.
pub(super) fn numbers(_: &Effort) -> Found {
    let mut found = refused("C19");
    let exact = [
        ("100000000000000000000", 1e20),
        ("-9223372036854775809", -9223372036854775808.0),
        ("9007199254740993", 9007199254740992.0),
        ("9007199254740993.00000000000000000001", 9007199254740994.0),
        (".1", f64::from_bits(0x3FB9_9999_9999_999A)),
        ("+1.25e-3", 0.00125),
        ("16777217", 16777217.0),
        ("1E+22", 1e22),
    ];
    for (number, value) in exact {
        let scene = scene(&text(&format!("Translate {number} 0 0\nCamera \"perspective\"")));
        let read = -scene.view.camera.world_from_camera.matrix().w_axis.x;
        found.check(read == value, || format!("{number} is read as {read:?}, not {value:?}"));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_is_not_as_expected_is_seen() {
        let options = "Translate 1 2 3\nCamera \"perspective\"\n\"float fov\" 180";
        let (error, warning) = (Severity::Error, Severity::Warning);
        assert_eq!(problem(error, options, "fov must be above 0", "180"), None);
        assert!(problem(error, options, "fov must be above 1", "180").is_some());
        assert!(problem(error, options, "fov must be above 0", "fov").is_some());
        assert!(problem(warning, options, "fov must be above 0", "180").is_some());
        assert!(problem(error, "Camera \"perspective\"", "fov", "Camera").is_some());
    }

    #[test]
    fn every_line_belongs_to_a_case() {
        let count = |id: &str| refused(id).rows.first().map_or(0, |row| row.tried);
        let cases = ["C7", "C8", "C11", "C12", "C13", "C15", "C19", "C20"];
        assert_eq!(cases.map(count).iter().sum::<u64>() as usize, REFUSED.lines().count() - 1);
    }
}
