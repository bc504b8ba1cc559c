//! `Camera`: placement, projection and lens.

mod lens_file;
mod lens_system;
mod realistic;
mod view_override;

use std::sync::Arc;

use glam::DVec2;
use lookat_syntax::ParamType;
use serde::Serialize;

use crate::Film;
use crate::params::Params;
use crate::params::value::Edges;
use crate::schema::{Effect, Key, Keys, Kind, Range, Unit, number};
use crate::transform::{AnimatedTransform, Transform, TransformSet};

pub use crate::camera::lens_system::{
    EquivalentView, LensElement, LensSystem, MILLIMETER, Pupil, ThickLens, Weighting,
};
pub(crate) use crate::camera::view_override::look_at;
pub use crate::camera::view_override::{CameraPlacement, FileCamera, ViewOverride};

/// A camera. Camera space is left-handed: +x right, +y up, +z forward.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// World from camera space (pbrt's CameraToWorld): the inverse of the current transformation at `Camera`. Of a camera that moves, the
    /// one at the start time.
    pub world_from_camera: Transform,
    /// The way of a camera that moves.
    pub motion: Option<AnimatedTransform>,
    /// When it takes the picture. Only what moves depends on it.
    pub shutter: Shutter,
    /// The projection to the screen.
    pub projection: Projection,
    /// The screen rectangle of the film.
    pub screen: ScreenWindow,
    /// The thin lens; `None` for a pinhole. Of a lens system, the radius of the entrance pupil and the distance in focus.
    pub lens: Option<Lens>,
}

/// The time of a picture. It has any unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shutter {
    /// The time when the shutter opens (parameter `shutteropen`, default 0).
    pub open: f64,
    /// The time when the shutter closes, no earlier (parameter `shutterclose`, default 1).
    pub close: f64,
    /// The start time and the end time of all motion (directive `TransformTimes`, default 0 and 1), the earlier one first.
    pub transform_times: [f64; 2],
}

impl Shutter {
    /// The times of pbrt-v3 in a scene without any.
    pub const PBRT_DEFAULT: Shutter = Shutter { open: 0.0, close: 1.0, transform_times: [0.0, 1.0] };

    /// This shutter, open for an instant.
    pub fn at(self, time: f64) -> Shutter {
        Shutter { open: time, close: time, ..self }
    }

    /// The times when it opens and closes, as shares of the way from the start time of motion to its end time.
    pub fn shares(&self) -> [f64; 2] {
        let [start, end] = self.transform_times;
        // Far from all motion, the difference does not matter.
        [self.open, self.close].map(|time| ((time - start) / (end - start)).clamp(-1e50, 1e50))
    }
}

/// The projection from camera space to the screen.
#[derive(Debug, Clone, PartialEq)]
pub enum Projection {
    /// Perspective projection to the origin of camera space.
    Perspective {
        /// The angle of the screen from -1 to 1, in degrees, above 0 and below 180 (parameter `fov`, default 90, or
        /// `halffov`). It stays in degrees, because conversion to radians loses digits that wide angles need. The
        /// default screen window has this angle along the shorter axis.
        fov: f64,
    },
    /// Parallel projection along +z.
    Orthographic {
        /// If true, a lens blurs around each parallel ray. If false, all lens rays start near the origin, as in
        /// pbrt-v3, which gives a perspective view (pbrt-v3 issue 315). Default false.
        telecentric: bool,
    },
    /// All directions from the origin of camera space: x on the film is the angle from +x to +z, y the angle from +y
    /// (PBR 6.3). Lens and screen window have no effect.
    Environment,
    /// A film behind a system of lenses (PBR 6.4). The film is at the origin of camera space, and the screen window has its shape.
    Realistic(Arc<LensSystem>),
}

/// A rectangle in screen units. Reversed edges mirror the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenWindow {
    /// The left and bottom edge.
    pub min: DVec2,
    /// The right and top edge.
    pub max: DVec2,
}

/// A thin lens around the origin of camera space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lens {
    /// The aperture radius in camera space units, above 0 (parameter `lensradius`, default 0 for a pinhole).
    pub radius: f64,
    /// The distance along +z to the plane of focus in camera space units, above 0 (parameter `focaldistance`, default
    /// 1e6).
    pub focal_distance: f64,
}

impl Projection {
    /// The type of the camera in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Projection::Perspective { .. } => "perspective",
            Projection::Orthographic { .. } => "orthographic",
            Projection::Environment => "environment",
            Projection::Realistic(_) => "realistic",
        }
    }
}

impl Camera {
    /// A pinhole camera for a film, with square pixels and -1 to 1 on the screen along its shorter side. `camera_from_world` places
    /// it, as [`Transform::look_at`] does.
    pub fn new(camera_from_world: Transform, projection: Projection, film: &Film) -> Self {
        let screen = ScreenWindow::of_aspect(film_aspect(film));
        Camera {
            world_from_camera: camera_from_world.inverse(),
            motion: None,
            shutter: Shutter::PBRT_DEFAULT,
            projection,
            screen,
            lens: None,
        }
    }

    /// The angle of view, in degrees. `None` unless it is a perspective camera.
    pub fn fov(&self) -> Option<f64> {
        match self.projection {
            Projection::Perspective { fov } => Some(fov),
            Projection::Orthographic { .. } | Projection::Environment | Projection::Realistic(_) => None,
        }
    }

    /// The length on the film, in units of camera space, that a unit of the screen window of a realistic camera is.
    pub fn screen_unit(&self, film: &Film) -> f64 {
        0.5 * film.diagonal * MILLIMETER / self.screen.max.length()
    }

    /// The parameter of the distance in focus.
    pub fn focus_parameter(&self) -> &'static str {
        if self.lens_system().is_some() { "focusdistance" } else { FOCAL_DISTANCE.name }
    }

    /// The lens system of a realistic camera.
    pub fn lens_system(&self) -> Option<&LensSystem> {
        match &self.projection {
            Projection::Realistic(lenses) => Some(lenses),
            _ => None,
        }
    }

    /// This camera at another place, where it stands still.
    pub fn placed(self, world_from_camera: Transform) -> Self {
        Camera { world_from_camera, motion: None, ..self }
    }

    /// World from camera space in the middle of the time when the shutter is open.
    pub fn middle(&self) -> Transform {
        let [open, close] = self.shutter.shares();
        self.motion.map_or(self.world_from_camera, |motion| motion.at((open + close) / 2.0))
    }

    /// This camera with a thin lens.
    pub fn with_lens(self, lens: Lens) -> Self {
        Camera { lens: Some(lens), ..self }
    }
}

impl Projection {
    /// The projection of pbrt-v3 without a Camera directive.
    pub(crate) const PBRT_DEFAULT: Projection = Projection::Perspective { fov: 90.0 };
}

impl Lens {
    /// The focal distance of a lens without `focaldistance`.
    pub const UNFOCUSED: f64 = UNFOCUSED;
}

impl From<[f64; 4]> for ScreenWindow {
    /// The window with these edges: xmin, xmax, ymin, ymax.
    fn from([x0, x1, y0, y1]: [f64; 4]) -> Self {
        ScreenWindow { min: DVec2::new(x0, y0), max: DVec2::new(x1, y1) }
    }
}

impl ScreenWindow {
    /// The edges, in the order of the format: xmin, xmax, ymin, ymax.
    pub fn edges(&self) -> [f64; 4] {
        [self.min.x, self.max.x, self.min.y, self.max.y]
    }

    /// The default window of a film: from -1 to 1 along the shorter axis.
    pub fn of_film(film: &Film) -> Self {
        ScreenWindow::of_aspect(film_aspect(film))
    }

    /// The window from -1 to 1 along the shorter axis.
    fn of_aspect(aspect: f64) -> Self {
        let half = if aspect > 1.0 { DVec2::new(aspect, 1.0) } else { DVec2::new(1.0, 1.0 / aspect) };
        ScreenWindow { min: -half, max: half }
    }
}

fn film_aspect(film: &Film) -> f64 {
    f64::from(film.resolution[0]) / f64::from(film.resolution[1])
}

/// pbrt-v3's CreatePerspectiveCamera, CreateOrthographicCamera and CreateEnvironmentCamera.
pub(crate) fn camera(
    params: &mut Params,
    placed: &TransformSet,
    transform_times: [f64; 2],
    film: &Film,
    view: &ViewOverride,
) -> Option<Camera> {
    let motion = motion(params, placed);
    let camera = match params.kind() {
        "realistic" => realistic::realistic(params, film, view)?,
        _ => in_closed_form(params, film, view)?,
    };
    let shutter = Shutter { transform_times, ..camera.shutter };
    let shutter = view.time.map_or(shutter, |time| shutter.at(time));
    Some(Camera { world_from_camera: *placed.start, motion, shutter, ..camera })
}

/// A camera without a lens system, at the origin.
fn in_closed_form(params: &mut Params, film: &Film, view: &ViewOverride) -> Option<Camera> {
    let projection = match params.kind() {
        "perspective" => perspective(params, view.fov),
        "orthographic" => Projection::Orthographic { telecentric: false },
        "environment" => Projection::Environment,
        _ => return params.reject_unknown_type(KINDS),
    };
    let screen = screen_window(params, film, view.screen_window);
    let lens = if projection == Projection::Environment { no_lens(params) } else { lens(params, view) };
    let projection = match projection {
        Projection::Orthographic { .. } => orthographic(params, lens.is_some()),
        other => other,
    };
    let shutter = shutter(params);
    let is_usable = params.finish();
    is_usable.then(|| Camera { shutter, screen, lens, ..Camera::new(Transform::IDENTITY, projection, film) })
}

/// The times when the shutter opens and closes.
fn shutter(params: &mut Params) -> Shutter {
    let [open, close] = [params.take(&SHUTTER_OPEN), params.take(&SHUTTER_CLOSE)];
    params.check_range(SHUTTER_CLOSE.name, &[open, close]);
    if close < open {
        let message = "shutterclose is before shutteropen: they are exchanged, as in pbrt-v3";
        params.warn("shutterclose", message, "write the earlier time as shutteropen");
    }
    Shutter { open: open.min(close), close: open.max(close), ..Shutter::PBRT_DEFAULT }
}

fn motion(params: &mut Params, placed: &TransformSet) -> Option<AnimatedTransform> {
    if !placed.is_animated() {
        return None;
    }
    let motion = AnimatedTransform::new(*placed.start, *placed.end);
    if let Err(fault) = motion {
        let help = "scale by numbers of the same sign at both times";
        params.reject("", format!("this camera cannot move: {fault}"), Some(help));
    }
    motion.ok()
}

fn perspective(params: &mut Params, instead: Option<f64>) -> Projection {
    let (fov, half) = (params.take(&FOV), params.take(&HALF_FOV));
    // As in pbrt-v3, a positive halffov replaces fov.
    if half <= 0.0 && params.was_taken("halffov") && params.usable() {
        params.warn("halffov", "halffov is not above 0: fov is used, as in pbrt-v3", "delete halffov or fov");
    }
    if half > 0.0 {
        params.replaced_by("fov", &["halffov"]);
    }
    if let Some(fov) = instead {
        // At the type: the scene does not give this angle.
        params.doubt_angle("fov", "", fov);
        return Projection::Perspective { fov };
    }
    Projection::Perspective { fov: if half > 0.0 { 2.0 * half } else { fov } }
}

fn orthographic(params: &mut Params, lens: bool) -> Projection {
    // An extension: pbrt-v3 does not have this parameter.
    let is_given = params.given("telecentric");
    let telecentric = params.take(&TELECENTRIC);
    if lens && !is_given {
        params.warn(
            "lensradius",
            "an orthographic camera with a lens gives a perspective view in pbrt-v3 (a known defect); lookat renders the same",
            "add \"bool telecentric\" \"true\" for an orthographic thin lens, or \"false\" to keep the view of pbrt-v3",
        );
    }
    Projection::Orthographic { telecentric }
}

fn screen_window(params: &mut Params, film: &Film, instead: Option<[f64; 4]>) -> ScreenWindow {
    let own = film_aspect(film);
    let aspect = params.take(&Key { default: own, ..FRAME_ASPECT_RATIO });
    let default = ScreenWindow::of_aspect(aspect);
    let window = params.take(&SCREEN_WINDOW);
    match instead.or(window) {
        None => {
            if (aspect / own - 1.0).abs() > 0.01 {
                params.warn(
                    "frameaspectratio",
                    &format!(
                        "frameaspectratio {} differs from the film's {}: pixels are not square",
                        number(aspect),
                        number((own * 1e4).round() / 1e4)
                    ),
                    "choose xresolution and yresolution in the same ratio",
                );
            }
            default
        }
        Some([x0, x1, y0, y1]) if x0 != x1 && y0 != y1 => {
            params.check_range("screenwindow", &[x0, x1, y0, y1]);
            ScreenWindow::from([x0, x1, y0, y1])
        }
        Some(_) => {
            params.reject("screenwindow", "screenwindow is empty", Some(SCREEN_WINDOW_HELP));
            default
        }
    }
}

/// pbrt-v3 reads the lens of an environment camera and ignores it.
fn no_lens(params: &mut Params) -> Option<Lens> {
    let radius = params.take(&LENS_RADIUS);
    params.take(&Key { range: Range::ALL, ..FOCAL_DISTANCE });
    let reason = "an environment camera has no lens, and everything is sharp, as in pbrt-v3";
    if radius != 0.0 {
        params.unused("lensradius", reason, "delete lensradius");
    }
    params.unused("focaldistance", reason, "delete focaldistance");
    None
}

fn lens(params: &mut Params, view: &ViewOverride) -> Option<Lens> {
    let own = params.take(&LENS_RADIUS);
    let radius = view.lens_radius.unwrap_or(own);
    // Without a lens, it has no meaning.
    let range = if radius > 0.0 { FOCAL_DISTANCE.range } else { Range::ALL };
    let own = params.take(&Key { range, ..FOCAL_DISTANCE });
    let focal_distance = view.focal_distance.unwrap_or(own);
    if radius < 0.0 {
        params.warn(
            "lensradius",
            "lensradius is negative: the camera is a pinhole, as in pbrt-v3",
            "write the aperture radius, or 0 for a pinhole",
        );
    }
    if radius <= 0.0 {
        if !params.was_taken("lensradius") && view.lens_radius.is_none() {
            let reason = "without lensradius the camera is a pinhole, and everything is sharp";
            params.unused(
                "focaldistance",
                reason,
                "add \"float lensradius\" with the radius of the aperture",
            );
        }
        return None;
    }
    if !params.was_taken("focaldistance") && view.focal_distance.is_none() {
        params.warn(
            "lensradius",
            "the lens has no focaldistance: it focuses at 1e6 units, so everything nearer is blurred",
            "add the distance to the plane of focus, such as \"float focaldistance\" 5",
        );
    }
    Some(Lens { radius, focal_distance })
}

const UNFOCUSED: f64 = 1e6;

pub(crate) const FOV: Key<f64> =
    Key::float("fov", 90.0, "the angle of view along the shorter side of the picture")
        .within(Range::between(0.0, 180.0))
        .unit(Unit::Degrees);
const HALF_FOV: Key<f64> =
    Key::float("halffov", -1.0, "half the angle of view; if positive, it replaces fov")
        .default_words("none")
        .within(Range::below(90.0))
        .unit(Unit::Degrees);
const FRAME_ASPECT_RATIO: Key<f64> =
    Key::float("frameaspectratio", 1.0, "the width of the screen window divided by its height")
        .default_words("the film's")
        .within(Range::from_to(1e-6, 1e6));
const SCREEN_WINDOW: Key<Edges> = Key::new(
    "screenwindow",
    ParamType::Float,
    Edges,
    "the part of the screen on the film: xmin xmax ymin ymax",
)
.default_words("-1 to 1 along the shorter side");
const LENS_RADIUS: Key<f64> =
    Key::float("lensradius", 0.0, "the radius of the aperture; 0 is a pinhole").unit(Unit::CameraSpace);
const FOCAL_DISTANCE: Key<f64> =
    Key::float("focaldistance", UNFOCUSED, "the distance to the plane of focus along the viewing direction")
        .within(Range::above(0.0))
        .unit(Unit::CameraSpace);
/// As an override; in a scene, a negative radius is a pinhole.
const LENS_RADIUS_RANGE: Range = Range::at_least(0.0);
const SCREEN_WINDOW_HELP: &str = "write the edges as xmin xmax ymin ymax";
const SHUTTER_OPEN: Key<f64> = Key::float("shutteropen", 0.0, "the time when the shutter opens");
const SHUTTER_CLOSE: Key<f64> = Key::float("shutterclose", 1.0, "the time when the shutter closes");
const TELECENTRIC: Key<bool> = Key::bool(
    "telecentric",
    false,
    "true blurs around parallel rays, false gives pbrt-v3's perspective view",
)
.effect(Effect::Own);

const COMMON: Keys =
    &[&FRAME_ASPECT_RATIO, &SCREEN_WINDOW, &LENS_RADIUS, &FOCAL_DISTANCE, &SHUTTER_OPEN, &SHUTTER_CLOSE];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("perspective", "a pinhole or a thin lens", &[&[&FOV, &HALF_FOV], COMMON]).by_default(),
    Kind::new("orthographic", "parallel rays along +z", &[COMMON, &[&TELECENTRIC]]),
    Kind::new("environment", "all directions around a point", &[COMMON]),
    Kind::new("realistic", "lenses from a file", &[realistic::KEYS]),
];
