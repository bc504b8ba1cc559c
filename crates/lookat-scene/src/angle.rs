//! Angles, which are in degrees throughout the format.

/// Common parts of a turn, in degrees.
const COMMON: [f64; 9] = [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// What to say of an angle that is one of them in radians, if only to three digits: a message and help.
pub(crate) fn doubt(name: &str, given: f64) -> Option<(String, String)> {
    let is_meant = |degrees: &f64| (given.abs() / degrees.to_radians() - 1.0).abs() < 6e-4;
    let degrees = COMMON.into_iter().find(is_meant)?.copysign(given);
    let message = format!("{name} is {given} degrees: are radians meant?");
    Some((message, format!("angles are in degrees; {given} radians are {degrees} degrees")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radians_are_doubted() {
        for given in [0.785, 0.7854, -1.57, std::f64::consts::PI, 6.28318, 1.0472] {
            assert!(doubt("fov", given).is_some(), "{given}");
        }
        for given in [0.0, 0.8, 1.0, 1.5, 3.0, 3.1, 5.0, 30.0, 45.0, 90.0, 180.0, 360.0, f64::NAN] {
            assert_eq!(doubt("fov", given), None);
        }
        let (message, help) = doubt("the angle", -1.5708).unwrap();
        assert_eq!(message, "the angle is -1.5708 degrees: are radians meant?");
        assert_eq!(help, "angles are in degrees; -1.5708 radians are -90 degrees");
    }
}
