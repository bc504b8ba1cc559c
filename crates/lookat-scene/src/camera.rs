//! `Camera`: placement, projection and lens, and what the caller sets instead of the scene.

use glam::{DVec2, DVec3};
use lookat_syntax::{ParamType, Span};
use serde::{Deserialize, Serialize};

use crate::Film;
use crate::params::Params;
use crate::params::value::{Edges, Name};
use crate::schema::{Effect, Key, Keys, Kind, Range, Unit, number};
use crate::transform::{AnimatedTransform, LookAtError, Transform, TransformSet, in_range};

/// A camera. Camera space is left-handed: +x right, +y up, +z forward.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// The thin lens; `None` for a pinhole.
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
        [self.open, self.close].map(|time| (time - start) / (end - start))
    }
}

/// The projection from camera space to the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    pub fn name(self) -> &'static str {
        match self {
            Projection::Perspective { .. } => "perspective",
            Projection::Orthographic { .. } => "orthographic",
            Projection::Environment => "environment",
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
            Projection::Orthographic { .. } | Projection::Environment => None,
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
    let projection = match params.kind() {
        "perspective" => perspective(params, view.fov),
        "orthographic" => Projection::Orthographic { telecentric: false },
        "environment" => Projection::Environment,
        "realistic" => {
            params.unsupported(
                "lookat does not support Camera \"realistic\"; it uses a pinhole camera instead".into(),
            );
            if let Some(file) = params.take(&LENS_FILE)
                && let Ok((path, _)) = params.files.open_named(&file.value, file.span)
            {
                params.warn_of_path(&file, &path);
            }
            params.ignore_rest();
            Projection::Perspective { fov: view.fov.unwrap_or(90.0) }
        }
        _ => return params.reject_unknown_type(KINDS),
    };
    let screen = screen_window(params, film, view.screen_window);
    let lens = if projection == Projection::Environment { no_lens(params) } else { lens(params, view) };
    let projection = match projection {
        Projection::Orthographic { .. } => orthographic(params, lens.is_some()),
        other => other,
    };
    let [open, close] = shutter(params);
    let shutter = Shutter { open, close, transform_times };
    let shutter = view.time.map_or(shutter, |time| shutter.at(time));
    let motion = motion(params, placed);
    params.finish().then_some(Camera {
        world_from_camera: *placed.start,
        motion,
        shutter,
        projection,
        screen,
        lens,
    })
}

/// The times when the shutter opens and closes.
fn shutter(params: &mut Params) -> [f64; 2] {
    let [open, close] = [params.take(&SHUTTER_OPEN), params.take(&SHUTTER_CLOSE)];
    if close < open {
        let message = "shutterclose is before shutteropen: they are exchanged, as in pbrt-v3";
        params.warn("shutterclose", message, "write the earlier time as shutteropen");
        return [close, open];
    }
    [open, close]
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

const LENS_FILE: Key<Name> = Key::string("lensfile", "the file that describes the lenses").not_rendered();
const REALISTIC: Keys = &[
    &LENS_FILE,
    &Key::float("aperturediameter", 1.0, "the diameter of the aperture in millimeters").not_rendered(),
    &Key::float("focusdistance", 10.0, "the distance to the plane of focus")
        .unit(Unit::CameraSpace)
        .not_rendered(),
    &Key::bool("simpleweighting", true, "true weights rays as if the film were small").not_rendered(),
    &SHUTTER_OPEN,
    &SHUTTER_CLOSE,
];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("perspective", "a pinhole or a thin lens", &[&[&FOV, &HALF_FOV], COMMON]).by_default(),
    Kind::new("orthographic", "parallel rays along +z", &[COMMON, &[&TELECENTRIC]]),
    Kind::new("environment", "all directions around a point", &[COMMON]),
    Kind::new("realistic", "lenses from a file", &[REALISTIC])
        .instead("perspective, fov 90, default window, without a lens"),
];

/// Settings that replace the placement and the parameters of the camera in the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ViewOverride {
    /// Eye, target and up vector of a `LookAt`. It replaces the whole camera transformation.
    pub look_at: Option<[f64; 9]>,
    /// The angle of view in degrees, above 0 and below 180. Only a perspective camera uses it.
    pub fov: Option<f64>,
    /// The radius of the aperture in units of camera space; 0 is a pinhole.
    pub lens_radius: Option<f64>,
    /// The distance to the plane of focus in units of camera space, above 0. Only a lens uses it.
    pub focal_distance: Option<f64>,
    /// The part of the screen on the film: xmin, xmax, ymin, ymax. Reversed edges mirror the picture.
    pub screen_window: Option<[f64; 4]>,
    /// An instant that replaces the time when the shutter is open, in units of `TransformTimes`.
    pub time: Option<f64>,
}

/// A camera that a `LookAt` places: `before`, the `LookAt` and `after` make the camera transformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPlacement {
    /// The `LookAt` in the text. `None` if the caller gives it.
    pub span: Option<Span>,
    /// The transformation before the `LookAt`, such as a mirroring `Scale -1 1 1`.
    pub before: Transform,
    /// Eye, target and up vector, in the space that `after` makes of the world.
    pub points: [f64; 9],
    /// The transformation after the `LookAt`, such as a rotation of the world.
    pub after: Transform,
}

impl ViewOverride {
    /// Fails if a value is out of range for every scene. The error is the reason.
    pub fn check(&self) -> Result<(), String> {
        let given = [
            self.look_at.as_ref().map(<[f64; 9]>::as_slice),
            self.screen_window.as_ref().map(<[f64; 4]>::as_slice),
        ];
        if !given.iter().flatten().all(|values| in_range(values)) {
            return Err("a number is too large".into());
        }
        if let Some(points) = self.look_at {
            CameraPlacement::new(points).world_from_camera().map_err(|fault| fault.to_string())?;
        }
        if let Some([x0, x1, y0, y1]) = self.screen_window
            && (x0 == x1 || y0 == y1)
        {
            return Err(format!("the window is empty: {SCREEN_WINDOW_HELP}"));
        }
        let within = |value: Option<f64>, range: Range, name: &str, unit: &str| match value {
            Some(value) if !range.contains(value) => Err(format!("{name} must be {}{unit}", range.words())),
            Some(value) if !in_range(&[value]) => Err(format!("{name} is too large")),
            _ => Ok(()),
        };
        within(self.time, Range::ALL, "the time", "")?;
        within(self.fov, FOV.range, "the angle", " degrees")?;
        within(self.lens_radius, LENS_RADIUS_RANGE, "the radius", "")?;
        within(self.focal_distance, FOCAL_DISTANCE.range, "the distance", "")
    }

    /// The camera transformation, if it is set and valid.
    pub(crate) fn world_from_camera(&self) -> Option<Transform> {
        self.placement()?.world_from_camera().ok()
    }

    /// The placement of the camera, if it is set.
    pub(crate) fn placement(&self) -> Option<CameraPlacement> {
        self.look_at.map(CameraPlacement::new)
    }
}

impl CameraPlacement {
    /// The placement by eye, target and up vector alone.
    pub fn new(points: [f64; 9]) -> Self {
        CameraPlacement { span: None, before: Transform::IDENTITY, points, after: Transform::IDENTITY }
    }

    /// The placement of a camera by points of the caller's choice. `before` is the rest of the transformation, such as mirroring the picture.
    pub fn of(world_from_camera: Transform, points: [f64; 9]) -> Result<Self, LookAtError> {
        let looking = CameraPlacement::new(points);
        let before = world_from_camera.inverse() * looking.world_from_camera()?;
        Ok(CameraPlacement { before, ..looking })
    }

    /// World from camera space for this placement.
    pub fn world_from_camera(&self) -> Result<Transform, LookAtError> {
        let placed = (self.before * look_at(self.points)? * self.after).inverse();
        placed.in_range().then_some(placed).ok_or(LookAtError::OutOfRange)
    }

    /// True if the `LookAt` alone places the camera.
    pub fn is_plain(&self) -> bool {
        self.before == Transform::IDENTITY && self.after == Transform::IDENTITY
    }
}

/// The viewing transformation of eye, target and up vector.
pub(crate) fn look_at(points: [f64; 9]) -> Result<Transform, LookAtError> {
    let [eye, look, up] = [0, 3, 6].map(|at| DVec3::from_slice(&points[at..at + 3]));
    Transform::look_at(eye, look, up)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{LoadOptions, Loaded, Projection, load};

    const CAMERA: &str = "Scale -1 1 1 LookAt 0 0 -4 0 0 0 0 1 0 Camera \"perspective\" \"float halffov\" 10";

    fn loaded(camera: &str, view: ViewOverride) -> Loaded {
        let text = format!(
            "{camera} Film \"image\" Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\" \
            CoordSysTransform \"camera\" Shape \"sphere\" WorldEnd"
        );
        let options = LoadOptions { view, ..LoadOptions::default() };
        load(Path::new("a.pbrt"), &|_: &Path| Ok(text.clone().into()), &options)
    }

    /// An override gives the scene that its directive or parameter gives.
    #[test]
    fn an_override_acts_like_the_scene() {
        let none = ViewOverride::default();
        let moved = "LookAt 1 2 3 4 5 6 0 0 1";
        for (view, scene) in [
            (ViewOverride { fov: Some(50.0), ..none }, CAMERA.replace("halffov\" 10", "fov\" 50")),
            (ViewOverride { lens_radius: Some(0.5), ..none }, format!("{CAMERA} \"float lensradius\" .5")),
            (
                ViewOverride { lens_radius: Some(0.5), focal_distance: Some(3.0), ..none },
                format!("{CAMERA} \"float lensradius\" .5 \"float focaldistance\" 3"),
            ),
            (
                ViewOverride { screen_window: Some([-1.0, 2.0, 3.0, -4.0]), ..none },
                format!("{CAMERA} \"float screenwindow\" [-1 2 3 -4]"),
            ),
            (
                ViewOverride { look_at: Some([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 1.0]), ..none },
                CAMERA.replace("Scale -1 1 1 LookAt 0 0 -4 0 0 0 0 1 0", moved),
            ),
        ] {
            let (found, expected) = (loaded(CAMERA, view), loaded(&scene, none));
            let messages =
                |loaded: &Loaded| loaded.diagnostics.iter().map(|it| it.message.clone()).collect::<Vec<_>>();
            assert_eq!(messages(&found), messages(&expected), "{scene}");
            let (found, expected) = (found.scene.unwrap(), expected.scene.unwrap());
            assert_eq!(found.view.camera, expected.view.camera, "{scene}");
            // What the camera carries moves with it.
            assert_eq!(
                format!("{:?}", found.world.primitives[0].shape),
                format!("{:?}", expected.world.primitives[0].shape)
            );
        }
        let pinhole = ViewOverride { lens_radius: Some(0.0), ..none };
        let found = loaded(&format!("{CAMERA} \"float lensradius\" .5 \"float focaldistance\" 3"), pinhole);
        assert!(found.scene.unwrap().view.camera.lens.is_none() && found.diagnostics.is_empty());
    }

    #[test]
    fn values_out_of_range_do_not_fit() {
        let none = ViewOverride::default();
        for (view, reason) in [
            (ViewOverride { fov: Some(180.0), ..none }, "the angle must be above 0 and below 180 degrees"),
            (ViewOverride { lens_radius: Some(-1.0), ..none }, "the radius must be at least 0"),
            (ViewOverride { focal_distance: Some(0.0), ..none }, "the distance must be above 0"),
            (ViewOverride { focal_distance: Some(1e60), ..none }, "the distance is too large"),
            (ViewOverride { look_at: Some([f64::NAN; 9]), ..none }, "a number is too large"),
            (
                ViewOverride { look_at: Some([1e50, 1e50, -1e50, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), ..none },
                "the transformation or its inverse has entries above 1e50",
            ),
            (
                ViewOverride { look_at: Some([1.0; 9]), ..none },
                "the eye and the target of LookAt are the same point",
            ),
            (
                ViewOverride { screen_window: Some([1.0, 1.0, 0.0, 1.0]), ..none },
                "the window is empty: write the edges as xmin xmax ymin ymax",
            ),
        ] {
            let found = loaded(CAMERA, view);
            assert_eq!(found.override_error.as_deref(), Some(reason));
            assert!(found.scene.is_none());
        }
    }

    #[test]
    fn a_placement_gives_the_camera_again() {
        let found = loaded(CAMERA, ViewOverride::default());
        let camera = found.scene.unwrap().view.camera;
        assert!(matches!(camera.projection, Projection::Perspective { fov: 20.0 }));
        assert_eq!(found.placement.unwrap().world_from_camera(), Ok(camera.world_from_camera));
        assert!(found.world_follows_camera);
        for other in [
            "Translate 1 2 3",
            &CAMERA.replace(" Camera", " Identity Camera"),
            &CAMERA.replace("LookAt", "ActiveTransform EndTime LookAt"),
        ] {
            assert_eq!(loaded(other, ViewOverride::default()).placement, None);
        }
    }

    #[test]
    fn a_placement_knows_what_is_around_its_look_at() {
        let text = CAMERA.replace(
            " Camera",
            " Rotate 3 0 0 1 ActiveTransform EndTime Scale 2 2 2 ActiveTransform All Translate 1 2 3 Camera",
        );
        let found = loaded(&text, ViewOverride::default());
        let placement = found.placement.unwrap();
        assert!(!placement.is_plain() && placement.before.vector(DVec3::ONE) == DVec3::new(-1.0, 1.0, 1.0));
        let [made, own] =
            [placement.world_from_camera().unwrap(), found.scene.unwrap().view.camera.world_from_camera]
                .map(|transform| transform.matrix());
        assert!(made.abs_diff_eq(own, 1e-12), "{made} {own}");
    }
}
