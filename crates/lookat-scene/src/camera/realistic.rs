//! `Camera "realistic"`: a lens system from a file, in focus.

use std::sync::Arc;

use lookat_syntax::Text;

use super::lens_file::{LensRow, SMALLEST, lens_rows};
use super::lens_system::round_up;
use super::{
    Camera, Lens, LensElement, LensSystem, MILLIMETER, Projection, SHUTTER_CLOSE, SHUTTER_OPEN, ViewOverride,
    Weighting, shutter,
};
use crate::Film;
use crate::params::value::Name;
use crate::params::{ParamValue, Params};
use crate::schema::{Key, Keys, Range, Unit, number};
use crate::transform::Transform;

const LENS_FILE: Key<Name> =
    Key::string("lensfile", "the file that describes the surfaces of the lenses").required();
const APERTURE_DIAMETER: Key<f64> =
    Key::float("aperturediameter", 1.0, "the diameter of the aperture stop in millimeters")
        .within(Range::at_least(SMALLEST));
const FOCUS_DISTANCE: Key<f64> =
    Key::float("focusdistance", 10.0, "the distance from the film to the plane of focus")
        .within(Range::above(0.0))
        .unit(Unit::CameraSpace);
const SIMPLE_WEIGHTING: Key<bool> = Key::bool(
    "simpleweighting",
    true,
    "true gives nearly the brightness of other cameras, false the exposure of the film from shutteropen to shutterclose",
);
pub(super) const KEYS: Keys =
    &[&LENS_FILE, &APERTURE_DIAMETER, &FOCUS_DISTANCE, &SIMPLE_WEIGHTING, &SHUTTER_OPEN, &SHUTTER_CLOSE];

/// pbrt-v3's CreateRealisticCamera, at the origin.
pub(super) fn realistic(params: &mut Params, film: &Film, view: &ViewOverride) -> Option<Camera> {
    let aperture = params.take(&APERTURE_DIAMETER);
    let own = params.take(&FOCUS_DISTANCE);
    params.check_range(FOCUS_DISTANCE.name, &[own]);
    let focus = view.focal_distance.unwrap_or(own);
    let is_simple = params.take(&SIMPLE_WEIGHTING);
    let shutter = shutter(params);
    let time = shutter.close - shutter.open;
    if !is_simple && time == 0.0 {
        let help = "write a later shutterclose, or \"bool simpleweighting\" \"true\"";
        params.warn("", "the shutter opens and closes at once: the picture is black", help);
    }
    let weighting = if is_simple { Weighting::Simple } else { Weighting::Exposure { time } };
    let file = Name::take(&LENS_FILE, params);
    let help = "add \"string lensfile\" with the name of a file that describes the lenses";
    params.missing(LENS_FILE.name, "a realistic camera needs lensfile", help);
    let lenses = file.and_then(|file| lens_system(params, &file, aperture, weighting));
    let lenses = lenses.filter(|lenses| match view.focal_distance {
        Some(focus) => set_focus(params, lenses, focus),
        None => can_focus(params, lenses, own),
    });
    let is_usable = params.finish();
    let lenses = lenses.filter(|_| is_usable)?;
    let lens = Lens { radius: lenses.entrance_pupil().radius, focal_distance: focus };
    let projection = Projection::Realistic(Arc::new(lenses));
    Some(Camera { shutter, lens: Some(lens), ..Camera::new(Transform::IDENTITY, projection, film) })
}

/// Lenses that are shorter, in millimeters, are in other units.
const SHORTEST: f64 = 0.5;
/// Pictures of smaller apertures than this f-number are of nothing but diffraction; who writes one means meters.
const SMALLEST_APERTURE: f64 = 200.0;

/// The lens system of a file, with its stop at the aperture.
fn lens_system(params: &mut Params, file: &Text, aperture: f64, weighting: Weighting) -> Option<LensSystem> {
    let rows = lens_rows(params, file)?;
    let stops: Vec<&LensRow> = rows.iter().filter(|row| row.curvature_radius == 0.0).collect();
    let is_given = params.was_taken(APERTURE_DIAMETER.name);
    if stops.is_empty() && is_given {
        let message = "the lens file has no aperture stop: aperturediameter has no effect, as in pbrt-v3";
        let help = "in the lens file, write a line with radius 0 where the stop is, such as `0 2 1 10` for one of up to 10 mm";
        params.warn(APERTURE_DIAMETER.name, message, help);
    }
    if let Some(stop) = stops.iter().find(|stop| is_given && aperture > stop.aperture_diameter) {
        let most = number(stop.aperture_diameter);
        let message = format!(
            "aperturediameter is larger than the stop in line {} of the lens file: it is {most}, as in pbrt-v3",
            stop.line
        );
        params.warn(APERTURE_DIAMETER.name, &message, &format!("write at most {most}"));
    }
    let length: f64 = rows.iter().map(|row| row.thickness.abs()).sum();
    if length < SHORTEST {
        let rounded = number((length * 1e4).round() / 1e4);
        let message = format!("the lenses are {rounded} mm long: lens files are in millimeters");
        params.warn(
            LENS_FILE.name,
            &message,
            "multiply all lengths, if the file is in centimeters or meters",
        );
    }
    let element = |row: &LensRow| {
        let is_stop = row.curvature_radius == 0.0;
        let diameter = if is_stop { aperture.min(row.aperture_diameter) } else { row.aperture_diameter };
        LensElement {
            curvature_radius: row.curvature_radius * MILLIMETER,
            thickness: row.thickness.max(0.0) * MILLIMETER,
            eta: if row.eta == 0.0 { 1.0 } else { row.eta },
            aperture_radius: diameter * MILLIMETER / 2.0,
        }
    };
    let lenses = LensSystem { elements: rows.iter().map(element).collect(), weighting };
    if let Some(f_number) = lenses.f_number().filter(|it| *it > SMALLEST_APERTURE && length >= SHORTEST) {
        let message = format!("the aperture is f/{f_number:.0}: aperturediameter is in millimeters");
        params.warn(APERTURE_DIAMETER.name, &message, "multiply it by 1000, if it is in meters");
    }
    Some(lenses)
}

/// Reports a distance, which the caller has set, that the lens cannot focus on.
fn set_focus(params: &mut Params, lenses: &LensSystem, focus: f64) -> bool {
    let refused = lenses.refused_focus(focus);
    let can_focus = refused.is_none();
    params.report.override_error = params.report.override_error.take().or(refused);
    can_focus
}

/// Reports a lens that cannot focus on the distance of the scene.
fn can_focus(params: &mut Params, lenses: &LensSystem, focus: f64) -> bool {
    let Some(nearest) = lenses.nearest_focus() else {
        let message = "these lenses spread light: they cast no image on a film";
        let help = "write the surfaces from the scene to the film; a positive radius has its center on the side of the film";
        params.reject(LENS_FILE.name, message, Some(help));
        return false;
    };
    if lenses.film_distance(focus).is_some() {
        return true;
    }
    if focus < nearest {
        let help =
            format!("write a focusdistance of {} or more, in units of camera space", round_up(nearest));
        let message = format!("the lens cannot focus on a distance of {}", number(focus));
        params.reject(FOCUS_DISTANCE.name, message, Some(&help));
    } else {
        let message = format!("to focus on {}, the film would have to be inside the lens", number(focus));
        let help = "this lens casts its image between its surfaces: check the distances in its file";
        params.reject(LENS_FILE.name, message, Some(help));
    }
    false
}
