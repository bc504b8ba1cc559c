//! `--focus`: focuses the lens on what is seen at a place.

use lookat_render::Prepared;
use lookat_scene::View;
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

/// Focuses the lens of a view, and returns the line to write into the scene. Fails without a lens, or where nothing is.
pub fn focus(prepared: &Prepared, view: &mut View, place: FocusPlace) -> Result<String, String> {
    if view.camera.lens.is_none() {
        let message = "--focus needs a lens: add \"float lensradius\" to Camera, or use --lens-radius";
        return Err(message.into());
    }
    let [width, height] = view.film.resolution;
    let size = DVec2::new(f64::from(width), f64::from(height));
    let film = match place {
        FocusPlace::Pixel(at) => at + 0.5,
        FocusPlace::Fractions(at) => at * size,
    };
    if film.x > size.x || film.y > size.y {
        return Err(format!("--focus: the picture has only {width} x {height} pixels"));
    }
    let at = format!("{}, {}", film.x.floor(), film.y.floor());
    let Some(depth) = prepared.pick(view, film).map(|picked| picked.depth).filter(|depth| *depth > 0.0)
    else {
        return Err(format!("--focus: there is nothing to focus on at pixel {at}; choose another place"));
    };
    // Six digits, so that the line is short and gives the same picture.
    let depth = format!("{depth:.5e}").parse().unwrap_or(depth);
    if let Some(lens) = &mut view.camera.lens {
        lens.focal_distance = depth;
    }
    Ok(format!("focused on pixel {at}; to keep this, write \"float focaldistance\" {depth} in Camera"))
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
