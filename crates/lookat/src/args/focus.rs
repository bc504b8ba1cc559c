//! The place of `--focus`.

use lookat_scene::glam::DVec2;

/// A place of the full picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FocusPlace {
    /// A pixel, counted from the top left corner.
    Pixel(DVec2),
    /// Fractions of the width and the height, from the top left corner.
    Fractions(DVec2),
}

/// Parses X,Y: whole numbers are a pixel, numbers with a point are fractions.
pub fn focus_place(text: &str) -> Result<FocusPlace, String> {
    let numbers = text
        .split_once(',')
        .and_then(|(x, y)| Some(DVec2::new(x.trim().parse().ok()?, y.trim().parse().ok()?)));
    match numbers {
        Some(at) if text.contains('.') && at.min_element() >= 0.0 && at.max_element() <= 1.0 => {
            Ok(FocusPlace::Fractions(at))
        }
        Some(at) if !text.contains('.') && at.min_element() >= 0.0 && at.fract() == DVec2::ZERO => {
            Ok(FocusPlace::Pixel(at))
        }
        _ => Err("expected a pixel, as in 120,80, or fractions of the width and the height from 0 to 1, as in 0.5,0.5".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_pixels_or_fractions() {
        assert_eq!(focus_place("120,80"), Ok(FocusPlace::Pixel(DVec2::new(120.0, 80.0))));
        assert_eq!(focus_place("0.5, .25"), Ok(FocusPlace::Fractions(DVec2::new(0.5, 0.25))));
        assert_eq!(focus_place("0,0"), Ok(FocusPlace::Pixel(DVec2::ZERO)));
        for wrong in ["", "1", "1;2", "1.5,0.5", "-1,2", "0.5,nan", "a,b", "1e400,2", "0.5,0.5,0.5"] {
            assert!(focus_place(wrong).is_err(), "{wrong}");
        }
    }
}
