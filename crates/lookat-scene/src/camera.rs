//! `Camera`: the view of the scene.

use glam::DVec2;

use crate::params::Params;
use crate::{Film, Transform};

/// A camera. Camera space is left-handed: +x right, +y up, +z forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Its placement: pbrt's CameraToWorld, the inverse of the current transformation at `Camera`.
    pub world_from_camera: Transform,
    /// How points are projected to the screen.
    pub projection: Projection,
    /// The part of the screen that the film covers.
    pub screen: ScreenWindow,
    /// The thin lens; none is a pinhole.
    pub lens: Option<Lens>,
}

/// The projection from camera space to the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Towards the origin of camera space.
    Perspective {
        /// The angle that the screen from -1 to 1 subtends, in degrees, more than 0 and less than 180 (parameters `fov`,
        /// default 90, and `halffov`): in radians it would lose digits that wide angles need. The default screen window is
        /// this wide along the shorter axis.
        fov: f64,
    },
    /// Along +z.
    Orthographic {
        /// With a lens: every pixel looks along +z through its own part of the lens. Without, as in pbrt-v3, all lens
        /// rays start around the origin, which makes a perspective view (its issue 315). Default false.
        telecentric: bool,
    },
    /// All around the origin of camera space: from left to right the angle from +x towards +z, from top to bottom the angle
    /// to +y (PBR 6.3). There is no lens, and the screen counts for nothing.
    Environment,
}

/// A rectangle on the screen, in screen units. Reversed edges mirror the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenWindow {
    /// Left and bottom edge.
    pub min: DVec2,
    /// Right and top edge.
    pub max: DVec2,
}

/// A thin lens around the origin of camera space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Radius of the aperture, in camera space units, more than 0 (parameter `lensradius`, default 0: no lens).
    pub radius: f64,
    /// Distance along +z to the plane that is sharp, more than 0 (parameter `focaldistance`, default 1e6).
    pub focal_distance: f64,
}

impl Camera {
    /// What pbrt-v3 uses where there is no Camera.
    pub(crate) fn pbrt_default(world_from_camera: Transform, film: &Film) -> Self {
        let projection = Projection::Perspective { fov: 90.0 };
        let screen = ScreenWindow::of_aspect(film_aspect(film));
        Camera { world_from_camera, projection, screen, lens: None }
    }
}

impl ScreenWindow {
    /// From -1 to 1 along the shorter axis.
    fn of_aspect(aspect: f64) -> Self {
        let half = if aspect > 1.0 { DVec2::new(aspect, 1.0) } else { DVec2::new(1.0, 1.0 / aspect) };
        ScreenWindow { min: -half, max: half }
    }
}

fn film_aspect(film: &Film) -> f64 {
    f64::from(film.resolution[0]) / f64::from(film.resolution[1])
}

pub(crate) const NAMES: &[&str] = &["perspective", "orthographic", "environment", "realistic"];

/// pbrt-v3's CreatePerspectiveCamera, CreateOrthographicCamera and CreateEnvironmentCamera.
pub(crate) fn camera(params: &mut Params, world_from_camera: Transform, film: &Film) -> Option<Camera> {
    let projection = match params.kind() {
        "perspective" => perspective(params),
        "orthographic" => Projection::Orthographic { telecentric: false },
        "environment" => Projection::Environment,
        "realistic" => {
            params.unsupported("Camera \"realistic\" is not rendered; a pinhole stands in for it".into());
            if let Some(file) = params.string("lensfile") {
                params.warn_of_unread_path(&file);
            }
            params.ignore_rest();
            Projection::Perspective { fov: 90.0 }
        }
        _ => return params.unknown_kind(NAMES),
    };
    let screen = screen_window(params, film);
    let lens = lens(params);
    let projection = match projection {
        Projection::Orthographic { .. } => orthographic(params, lens.is_some()),
        other => other,
    };
    // pbrt-v3 reads the lens of such a camera, and makes nothing of it.
    let lens = lens.filter(|_| projection != Projection::Environment);
    // Nothing moves, so the shutter changes nothing.
    params.float("shutteropen", 0.0);
    params.float("shutterclose", 1.0);
    params.finish().then_some(Camera { world_from_camera, projection, screen, lens })
}

fn perspective(params: &mut Params) -> Projection {
    let fov = params.angle("fov", 90.0);
    let half = params.angle("halffov", -1.0);
    // pbrt-v3: a positive halffov replaces fov.
    if half <= 0.0 && params.was_taken("halffov") {
        params.warn(
            "halffov",
            "halffov is not more than 0: fov counts, as in pbrt-v3",
            "leave out one of the two",
        );
    }
    let (name, degrees) = if half > 0.0 { ("halffov", 2.0 * half) } else { ("fov", fov) };
    if !(degrees > 0.0 && degrees < 180.0) {
        let limit = if name == "fov" { 180 } else { 90 };
        params.reject(name, format!("{name} must be more than 0 and less than {limit} degrees"), None);
        return Projection::Perspective { fov: 90.0 };
    }
    Projection::Perspective { fov: degrees }
}

fn orthographic(params: &mut Params, lens: bool) -> Projection {
    // An addition of lookat: pbrt-v3 has no such parameter.
    let asked = params.given("telecentric");
    let telecentric = params.bool("telecentric", false);
    if lens && !asked {
        params.warn(
            "lensradius",
            "an orthographic camera with a lens is a perspective view in pbrt-v3 (a known defect, rendered alike here)",
            "add \"bool telecentric\" \"true\" for the true orthographic thin lens, or \"false\" to keep pbrt-v3's view",
        );
    }
    Projection::Orthographic { telecentric }
}

fn screen_window(params: &mut Params, film: &Film) -> ScreenWindow {
    let own = film_aspect(film);
    let mut aspect = params.float("frameaspectratio", own);
    if !(1e-6..=1e6).contains(&aspect) {
        params.reject("frameaspectratio", "frameaspectratio must be from 1e-6 to 1e6", None);
        aspect = own;
    }
    let default = ScreenWindow::of_aspect(aspect);
    match params.floats("screenwindow") {
        None => {
            if (aspect / own - 1.0).abs() > 0.01 {
                params.warn(
                    "frameaspectratio",
                    &format!(
                        "frameaspectratio {aspect} differs from the film's {own:.4}: pixels are not square"
                    ),
                    "choose xresolution and yresolution in the ratio of the frame",
                );
            }
            default
        }
        Some(edges) => match edges[..] {
            [x0, x1, y0, y1] if x0 != x1 && y0 != y1 => {
                params.check_range("screenwindow", &edges);
                ScreenWindow { min: DVec2::new(x0, y0), max: DVec2::new(x1, y1) }
            }
            [_, _, _, _] => {
                params.reject(
                    "screenwindow",
                    "screenwindow is empty",
                    Some("its edges are xmin xmax ymin ymax"),
                );
                default
            }
            _ => {
                let message = format!("screenwindow takes 4 values, not {}", edges.len());
                params.reject("screenwindow", message, Some("its edges are xmin xmax ymin ymax"));
                default
            }
        },
    }
}

fn lens(params: &mut Params) -> Option<Lens> {
    let radius = params.float("lensradius", 0.0);
    let focal_distance = params.float("focaldistance", 1e6);
    if radius < 0.0 {
        params.warn(
            "lensradius",
            "lensradius is negative: the camera is a pinhole, as in pbrt-v3",
            "give the radius of the aperture, or 0 for a pinhole",
        );
    }
    if radius <= 0.0 {
        return None;
    }
    if focal_distance <= 0.0 {
        params.reject("focaldistance", "focaldistance must be more than 0 with a lens", None);
    } else if !params.was_taken("focaldistance") {
        params.warn(
            "lensradius",
            "a lens without focaldistance is sharp at a distance of 1e6, and blurs what is nearer",
            "give the distance that is to be sharp, as in \"float focaldistance\" 5",
        );
    }
    Some(Lens { radius, focal_distance })
}
