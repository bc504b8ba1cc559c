//! The parameters of `Camera`.

use lookat_syntax::ParamType;

use crate::schema::{DefaultValue, Edges, Effect, Key, Keys, Kind, Name, Range, Unit};

pub(super) const UNFOCUSED: f64 = 1e6;

pub(crate) const FOV: Key<f64> =
    Key::float("fov", 90.0, "the angle of view along the shorter side of the picture")
        .within(Range::between(0.0, 180.0))
        .unit(Unit::Degrees);
pub(super) const HALF_FOV: Key<f64> =
    Key::float("halffov", -1.0, "half the angle of view; if positive, it replaces fov")
        .default_words("none")
        .within(Range::below(90.0))
        .unit(Unit::Degrees);
pub(super) const FRAME_ASPECT_RATIO: Key<f64> =
    Key::float("frameaspectratio", 1.0, "the width of the screen window divided by its height")
        .default_words("the film's")
        .within(Range::from_to(1e-6, 1e6));
pub(super) const SCREEN_WINDOW: Key<Edges> = Key::new(
    "screenwindow",
    ParamType::Float,
    Edges,
    "the part of the screen on the film: xmin xmax ymin ymax",
)
.default_words("-1 to 1 along the shorter side");
pub(super) const LENS_RADIUS: Key<f64> =
    Key::float("lensradius", 0.0, "the radius of the aperture; 0 is a pinhole").unit(Unit::CameraSpace);
pub(crate) const FOCAL_DISTANCE: Key<f64> =
    Key::float("focaldistance", UNFOCUSED, "the distance to the plane of focus along the viewing direction")
        .within(Range::above(0.0))
        .unit(Unit::CameraSpace);
/// As an override; in a scene, a negative radius is a pinhole.
pub(crate) const LENS_RADIUS_RANGE: Range = Range::at_least(0.0);
pub(crate) const SCREEN_WINDOW_HELP: &str = "write the edges as xmin xmax ymin ymax";
pub(super) const SHUTTER_OPEN: Key<f64> =
    Key::float("shutteropen", 0.0, "the time when the shutter opens").effect(Effect::NoEffect);
pub(super) const SHUTTER_CLOSE: Key<f64> =
    Key::float("shutterclose", 1.0, "the time when the shutter closes").effect(Effect::NoEffect);
pub(super) const TELECENTRIC: Key<bool> = Key::bool(
    "telecentric",
    false,
    "true blurs around parallel rays, false gives pbrt-v3's perspective view",
)
.effect(Effect::Own);

const COMMON: Keys =
    &[&FRAME_ASPECT_RATIO, &SCREEN_WINDOW, &LENS_RADIUS, &FOCAL_DISTANCE, &SHUTTER_OPEN, &SHUTTER_CLOSE];

const fn of_realistic<T: DefaultValue>(key: Key<T>) -> Key<T> {
    key.effect(Effect::NotRendered)
}

pub(super) const LENS_FILE: Key<Name> =
    of_realistic(Key::string("lensfile", "the file that describes the lenses"));
const APERTURE_DIAMETER: Key<f64> =
    of_realistic(Key::float("aperturediameter", 1.0, "the diameter of the aperture in millimeters"));
const FOCUS_DISTANCE: Key<f64> = of_realistic(
    Key::float("focusdistance", 10.0, "the distance to the plane of focus").unit(Unit::CameraSpace),
);
const SIMPLE_WEIGHTING: Key<bool> =
    of_realistic(Key::bool("simpleweighting", true, "true weights rays as if the film were small"));
const REALISTIC: Keys =
    &[&LENS_FILE, &APERTURE_DIAMETER, &FOCUS_DISTANCE, &SIMPLE_WEIGHTING, &SHUTTER_OPEN, &SHUTTER_CLOSE];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("Camera", "perspective", "a pinhole or a thin lens", &[&[&FOV, &HALF_FOV], COMMON])
        .by_default(),
    Kind::new("Camera", "orthographic", "parallel rays along +z", &[COMMON, &[&TELECENTRIC]]),
    Kind::new("Camera", "environment", "all directions around a point", &[COMMON]),
    Kind::new("Camera", "realistic", "lenses from a file", &[REALISTIC])
        .instead("perspective, fov 90, default window, without a lens"),
];
