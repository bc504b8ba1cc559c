//! `--focus`: focuses the lens on what is seen at a place.

use lookat_render::Prepared;
use lookat_scene::View;
use lookat_scene::glam::DVec2;

use crate::args::FocusPlace;

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
