//! Angles, which are always in degrees in scene files.

use lookat_syntax::Severity;

/// Common angles in degrees.
const COMMON: [f64; 9] = [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// Fields of view that are rare in degrees, and common in radians.
const NARROW: std::ops::Range<f64> = 0.25..2.0;

/// The severity, message and help for an angle that may be in radians. A common angle in radians, rounded or not, gives
/// a warning. Another narrow field of view gives a note.
pub(crate) fn doubt(name: &str, given: f64) -> Option<(Severity, String, String)> {
    let is_meant = |degrees: &f64| (given.abs() / degrees.to_radians() - 1.0).abs() < 6e-4;
    let common = COMMON.into_iter().find(is_meant).map(|degrees| degrees.copysign(given));
    let is_narrow = name == "fov" && NARROW.contains(&given);
    let narrow = is_narrow.then(|| (given.to_degrees() * 10.0).round() / 10.0);
    let (severity, message) = match common {
        Some(_) => (Severity::Warning, format!("{name} is {given} degrees: this looks like radians")),
        None => (Severity::Note, format!("{name} {given} is a very narrow view")),
    };
    let degrees = common.or(narrow)?;
    Some((severity, message, format!("angles are in degrees: {given} rad is {degrees} degrees")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radians_are_doubted() {
        for degrees in COMMON {
            let rounded = (degrees.to_radians() * 1e4).round() / 1e4;
            assert!(doubt("fov", degrees.to_radians()).is_some() && doubt("fov", -rounded).is_some());
            assert_eq!(doubt("fov", degrees), None);
        }
        for shorter in ["0.785", "1.57", "3.14", "6.28"] {
            assert!(doubt("fov", shorter.parse().unwrap()).is_some(), "{shorter}");
        }
        let is_note = |given| doubt("fov", given).is_some_and(|(severity, ..)| severity == Severity::Note);
        assert!(is_note(1.0) && is_note(0.3) && !is_note(0.785));
        for given in [0.0, 0.8, 1.0, 1.5, 3.0, 3.1, 5.0, f64::INFINITY, f64::NAN] {
            assert_eq!(doubt("the angle", given), None);
        }
        assert!(doubt("fov", 0.7).unwrap().2.ends_with("0.7 rad is 40.1 degrees"));
        assert_eq!(doubt("fov", 2.0), None);
        let (_, message, help) = doubt("the angle", -90_f64.to_radians()).unwrap();
        assert!(
            message.starts_with("the angle is -1.57")
                && message.ends_with(" degrees: this looks like radians")
        );
        assert!(help.starts_with("angles are in degrees: -1.57") && help.ends_with(" rad is -90 degrees"));
    }
}
