//! Options that replace the camera of the scene.

use clap::Args;
use lookat_scene::{Projection, Scene};

/// What to use instead of the camera of the scene.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct ViewOverride {
    /// Eye, target and up vector, instead of the camera transformation
    #[arg(long, value_name = "EX EY EZ LX LY LZ UX UY UZ", allow_hyphen_values = true, value_parser = look_at)]
    pub lookat: Option<[f64; 9]>,
    /// Angle of view along the shorter side, instead of fov
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = fov)]
    pub fov: Option<f64>,
    /// Radius of the aperture, instead of lensradius; 0 is a pinhole
    #[arg(long, visible_alias = "lensradius", value_name = "R", allow_negative_numbers = true, value_parser = lens_radius)]
    pub lens_radius: Option<f64>,
    /// Distance to the plane of focus, instead of focaldistance
    #[arg(long, visible_alias = "focaldistance", value_name = "D", allow_negative_numbers = true, value_parser = focal_distance)]
    pub focal_distance: Option<f64>,
    /// Part of the screen on the film, instead of screenwindow
    #[arg(long, visible_alias = "screenwindow", value_name = "X0 X1 Y0 Y1", allow_hyphen_values = true, value_parser = screen_window)]
    pub screen_window: Option<[f64; 4]>,
}

impl ViewOverride {
    /// The same for loading a scene.
    pub fn options(&self) -> lookat_scene::ViewOverride {
        let ViewOverride { lookat: look_at, fov, lens_radius, focal_distance, screen_window } = *self;
        lookat_scene::ViewOverride { look_at, fov, lens_radius, focal_distance, screen_window }
    }

    /// Fails if the loaded camera cannot use one of the options.
    pub fn check_use(&self, scene: &Scene) -> Result<(), String> {
        let camera = &scene.view.camera;
        let kind = match camera.projection {
            Projection::Perspective { .. } => "a perspective",
            Projection::Orthographic { .. } => "an orthographic",
            Projection::Environment => "an environment",
        };
        let given = [
            ("--lens-radius", self.lens_radius.is_some()),
            ("--focal-distance", self.focal_distance.is_some()),
            ("--screen-window", self.screen_window.is_some()),
        ];
        let idle =
            given.iter().find(|(_, is_given)| *is_given && camera.projection == Projection::Environment);
        match (self.fov, camera.projection, idle) {
            (Some(_), Projection::Orthographic { .. }, _) => Err(format!(
                "--fov has no effect on {kind} camera; to see more or less, use --screen-window"
            )),
            (Some(_), Projection::Environment, _) => {
                Err(format!("--fov has no effect on {kind} camera, which sees all directions; remove it"))
            }
            (_, _, Some((option, _))) => Err(format!("{option} has no effect on {kind} camera; remove it")),
            _ if self.focal_distance.is_some() && camera.lens.is_none() => Err(
                "--focal-distance has no effect on a pinhole, which is sharp at all distances; add --lens-radius".into(),
            ),
            _ => Ok(()),
        }
    }
}

/// Numbers, separated by blanks or commas.
fn numbers<const N: usize>(text: &str, example: &str) -> Result<[f64; N], String> {
    let words = text.split([' ', '\t', '\n', ',']).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| format!("expected {N} numbers in quotes, as in \"{example}\""))
}

/// Checks one option with the rules of the format.
fn checked<T>(value: T, view: lookat_scene::ViewOverride) -> Result<T, String> {
    view.check().map(|()| value)
}

fn look_at(text: &str) -> Result<[f64; 9], String> {
    let points = numbers(text, "0 1 -5  0 1 0  0 1 0")?;
    checked(points, lookat_scene::ViewOverride { look_at: Some(points), ..Default::default() })
}

fn screen_window(text: &str) -> Result<[f64; 4], String> {
    let edges = numbers(text, "-1.5 1.5 -1 1")?;
    checked(edges, lookat_scene::ViewOverride { screen_window: Some(edges), ..Default::default() })
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

fn fov(text: &str) -> Result<f64, String> {
    let fov = number(text)?;
    checked(fov, lookat_scene::ViewOverride { fov: Some(fov), ..Default::default() })
}

fn lens_radius(text: &str) -> Result<f64, String> {
    let radius = number(text)?;
    checked(radius, lookat_scene::ViewOverride { lens_radius: Some(radius), ..Default::default() })
}

fn focal_distance(text: &str) -> Result<f64, String> {
    let distance = number(text)?;
    checked(distance, lookat_scene::ViewOverride { focal_distance: Some(distance), ..Default::default() })
}
