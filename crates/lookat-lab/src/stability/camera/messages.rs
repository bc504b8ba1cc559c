//! Texts without a right picture must be refused, or warned of, by a message that tells what and where: C7, C8, C11, C15,
//! C19 and C20.

use std::panic::catch_unwind;

use glam::DVec2;
use lookat_render::Probe;
use lookat_scene::syntax::Severity;

use super::{case, text};
use crate::stability::case::{Case, Effort, Found};
use crate::text_scene::{load, scene};

pub(super) fn cases() -> Vec<Case> {
    vec![
        case(
            "C7",
            "up-parallel",
            "a LookAt whose up vector is parallel to the view, or zero, is an error",
            up_parallel,
        ),
        case("C8", "eye-at-look", "a LookAt whose eye equals its target is an error", eye_at_look),
        case(
            "C11",
            "focal-not-positive",
            "a lens with a focal distance of 0 or less is an error",
            focal_not_positive,
        ),
        case(
            "C15",
            "screen-window",
            "a screen window may be reversed, but needs 4 edges and an area",
            screen_window,
        ),
        case("C19", "numbers", "a number is read exactly, or is an error", numbers),
        case("C20", "singular", "singular transformations are errors", singular),
    ]
}

/// Options that must be spoken of.
pub(super) struct Trouble<'a> {
    options: &'a str,
    severity: Severity,
    /// A part of the message.
    says: &'a str,
    /// The text that it must underline; its first place in the options.
    at: &'a str,
}

impl<'a> Trouble<'a> {
    pub fn error(options: &'a str, says: &'a str, at: &'a str) -> Self {
        Trouble { options, severity: Severity::Error, says, at }
    }

    pub fn warning(options: &'a str, says: &'a str, at: &'a str) -> Self {
        Trouble { severity: Severity::Warning, ..Trouble::error(options, says, at) }
    }
}

/// Checks that a text is spoken of: once, by name, in its place; and that there is a scene exactly if it is no error.
pub(super) fn expect(found: &mut Found, trouble: &Trouble) {
    let answer = catch_unwind(|| answer(trouble)).unwrap_or_else(|_| Some("panics".into()));
    found.check(answer.is_none(), || format!("{}: {}", trouble.options, answer.unwrap_or_default()));
}

/// What is wrong with the answer to a text.
fn answer(trouble: &Trouble) -> Option<String> {
    let text = text(&format!("Film \"image\"\n{}", trouble.options));
    let loaded = load(&text);
    let [problem] = &loaded.diagnostics[..] else {
        let messages: Vec<&str> = loaded.diagnostics.iter().map(|problem| problem.message.as_str()).collect();
        return Some(format!("not one message but {}: {}", messages.len(), messages.join("; ")));
    };
    let span = problem.span();
    let underlined = text.get(span.start as usize..span.end as usize).unwrap_or_default();
    let line = 1 + text[..text.find(trouble.at)?].matches('\n').count();
    let is_line = loaded.sources.location(span).line == line;
    let is_right = problem.severity == trouble.severity
        && problem.message.contains(trouble.says)
        && underlined == trouble.at
        && is_line
        && loaded.scene.is_some() == (trouble.severity == Severity::Warning);
    (!is_right).then(|| format!("{:?} `{}` at `{underlined}`", problem.severity, problem.message))
}

fn errors(troubles: &[[&str; 3]]) -> Found {
    let mut found = Found::default();
    for [options, says, at] in troubles {
        expect(&mut found, &Trouble::error(options, says, at));
    }
    found
}

fn up_parallel(_: &Effort) -> Found {
    errors(&[
        ["LookAt 1 2 3 4 5 6 3 3 3", "up vector of LookAt is parallel", "LookAt 1 2 3 4 5 6 3 3 3"],
        ["LookAt 0 0 0 0 0 5 0 0 -1", "up vector of LookAt is parallel", "LookAt 0 0 0 0 0 5 0 0 -1"],
        ["LookAt 0 0 0 .1 .2 .3 1 2 3", "up vector of LookAt is parallel", "LookAt 0 0 0 .1 .2 .3 1 2 3"],
        [
            "Translate 0 0 1\nLookAt 1 2 3 4 5 6 0 0 0",
            "up vector of LookAt is zero",
            "LookAt 1 2 3 4 5 6 0 0 0",
        ],
    ])
}

fn eye_at_look(_: &Effort) -> Found {
    errors(&[
        [
            "LookAt 1 2 3 1 2 3 0 0 1",
            "the eye and the target of LookAt are the same point",
            "LookAt 1 2 3 1 2 3 0 0 1",
        ],
        [
            "Scale 2 2 2\nLookAt 0 0 0 0 0 -0 0 0 1",
            "the eye and the target of LookAt are",
            "LookAt 0 0 0 0 0 -0 0 0 1",
        ],
        // The numbers differ, but not in 53 bits.
        [
            "LookAt 1e17 0 0 100000000000000001 0 0 0 0 1",
            "the eye and the target of LookAt",
            "LookAt 1e17 0 0 100000000000000001 0 0 0 0 1",
        ],
    ])
}

fn focal_not_positive(_: &Effort) -> Found {
    let kinds = ["perspective", "orthographic\" \"bool telecentric\" \"true"];
    let mut found = Found::default();
    for kind in kinds {
        for distance in ["0", "-1", "-0.0", "-1e30"] {
            let options =
                format!("Camera \"{kind}\" \"float lensradius\" [5]\n  \"float focaldistance\" [{distance}]");
            let at = format!("[{distance}]");
            expect(&mut found, &Trouble::error(&options, "focaldistance must be above 0", &at));
        }
    }
    found
}

fn screen_window(_: &Effort) -> Found {
    let window = |kind: &str, edges: &str| format!("Camera \"{kind}\"\n\"float screenwindow\" {edges}");
    let mut found = Found::default();
    for kind in ["perspective", "orthographic"] {
        let mut refused = |edges: &str, says: &str| {
            expect(&mut found, &Trouble::error(&window(kind, edges), says, edges));
        };
        refused("[-1 1 -1]", "screenwindow takes 4 values, not 3");
        refused("[-1 1 -1 1 1]", "screenwindow takes 4 values, not 5");
        refused("[0 0 0 1]", "screenwindow is empty");
        refused("[0 1 2 2]", "screenwindow is empty");
        let views = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            scene(&text(&format!(
                "{}\nFilm \"image\" \"integer xresolution\" 64 \"integer yresolution\" 48",
                window(kind, edges)
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

fn numbers(_: &Effort) -> Found {
    let mut found = Found::default();
    let refused = [
        ("1.5abc", "`1.5abc` is not a number"),
        ("nan", "`nan` is not a finite number"),
        ("inf", "`inf` is not a finite number"),
        ("1e400", "the number is too large"),
        ("-1e400", "the number is too large"),
        ("1.2.3", "`1.2.3` is not a number"),
    ];
    for (number, says) in refused {
        for options in [
            format!("Camera \"perspective\"\n  \"float fov\" {number}"),
            format!("Camera \"perspective\"\n  \"float screenwindow\" [-1 1 -1 {number}]"),
            format!("Translate 1 2\n  {number}\n"),
        ] {
            expect(&mut found, &Trouble::error(&options, says, number));
        }
    }
    // Decimal numbers, and the nearest number with 53 bits.
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
        let read = -scene.view.camera.world_from_camera.m.w_axis.x;
        found.check(read == value, || format!("{number} is read as {read:?}, not {value:?}"));
    }
    found
}

fn singular(_: &Effort) -> Found {
    let zeros = "[0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0]";
    let flat = "[1 2 3 0 2 4 6 0 0 0 1 0 0 0 0 1]";
    let nothing = "[0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1]";
    let mut found = errors(&[
        ["Scale 1 0 1", "Scale by 0", "Scale 1 0 1"],
        ["Rotate 10 0 0 0", "the axis of Rotate has length 0", "Rotate 10 0 0 0"],
    ]);
    for keyword in ["Transform", "ConcatTransform"] {
        for (matrix, says) in [(zeros, "is not affine"), (flat, "is singular"), (nothing, "is singular")] {
            let directive = format!("{keyword} {matrix}");
            let says = format!("the matrix of {keyword} {says}");
            expect(&mut found, &Trouble::error(&format!("Translate 1 2 3\n{directive}"), &says, &directive));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_is_not_as_expected_is_seen() {
        let options = "Translate 1 2 3\nCamera \"perspective\"\n\"float fov\" 180";
        assert_eq!(answer(&Trouble::error(options, "fov must be above 0", "180")), None);
        assert!(answer(&Trouble::error(options, "fov must be above 1", "180")).is_some());
        assert!(answer(&Trouble::error(options, "fov must be above 0", "fov")).is_some());
        assert!(answer(&Trouble::warning(options, "fov must be above 0", "180")).is_some());
        assert!(answer(&Trouble::error("Camera \"perspective\"", "fov", "Camera")).is_some());
        let mut found = Found::default();
        expect(&mut found, &Trouble::error(options, "nothing", "180"));
        assert_eq!((found.rows[0].tried, found.rows[0].failed, found.remarks.len()), (1, 1, 1));
    }
}
