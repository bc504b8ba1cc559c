//! Options that several commands share: memory, tone and camera.

use clap::Args;
use lookat_image::{Image, MemoryBudget, OutOfMemory, ToneCurve, ToneMapping};
use lookat_scene::{Projection, Scene};

use crate::args::numbers::{named, stops};
use crate::failure::Failure;

/// The memory limit of a command.
#[derive(Debug, Clone, Copy, Args)]
pub struct Memory {
    /// Memory limit, such as 2G or 500M [default: three quarters of what the machine and its limits allow]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true, value_parser = size)]
    pub max_memory: Option<u64>,
}

impl Memory {
    /// The limit in bytes, at most the limit of the process. `None` if not given.
    pub fn limit(self) -> Option<u64> {
        let given = self.max_memory?;
        Some(given.min(MemoryBudget::process_limit().unwrap_or(u64::MAX)))
    }

    /// A new budget.
    pub fn budget(self) -> MemoryBudget {
        self.limit().map_or_else(MemoryBudget::default, MemoryBudget::new)
    }
}

/// The message about a shortage, with the way out.
pub fn way_out(shortage: OutOfMemory) -> String {
    format!("{shortage}; {RAISE}")
}

const RAISE: &str = "raise --max-memory, and ulimit -v if it is lower";

/// The way out of a limit.
pub fn raise_limit(limit: &str) -> String {
    format!("the limit is {limit}: {RAISE}")
}

/// Parses a size in bytes with an optional decimal unit k, M, G or T.
fn size(text: &str) -> Result<u64, Failure> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let factor = match text[number.len()..].to_ascii_uppercase().as_str() {
        "" => 1e0,
        "K" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        "T" => 1e12,
        _ => f64::NAN,
    };
    let bytes = number.parse().map_or(f64::NAN, |number: f64| number * factor);
    if !(1e6..=1e18).contains(&bytes) {
        bail!("expected a size of at least 1M, as in 500M or 2G");
    }
    Ok(bytes as u64)
}

/// How the values of a picture are fitted to an 8-bit file.
#[derive(Debug, Clone, Copy, Args)]
pub struct Tone {
    /// Exposure of a .png or .tga file in stops, or auto for the exposure that suits the picture [default: 0]
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = exposure)]
    pub exposure: Option<Exposure>,
    /// Tone curve of a .png or .tga file: none, reinhard, aces or neutral [default: none, which clips values above 1]
    #[arg(long, value_name = "CURVE", value_parser = curve)]
    pub tone: Option<ToneCurve>,
}

/// How a command writes its picture.
#[derive(Debug, Clone, Copy, Args)]
pub struct Writing {
    #[command(flatten)]
    pub tone: Tone,
    /// Replace a picture that is larger, has more samples, or comes from another program
    #[arg(long)]
    pub force: bool,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
    #[command(flatten)]
    pub memory: Memory,
}

/// The exposure of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exposure {
    /// The exposure that suits the picture.
    Auto,
    Stops(f64),
}

impl Tone {
    /// True if an option is given.
    pub fn is_given(self) -> bool {
        self.exposure.is_some() || self.tone.is_some()
    }

    /// The tone mapping for a linear picture.
    pub fn mapping(self, image: &Image) -> ToneMapping {
        let exposure = match self.exposure {
            None => 0.0,
            Some(Exposure::Stops(stops)) => stops,
            Some(Exposure::Auto) => image.suitable_exposure(),
        };
        ToneMapping { exposure, curve: self.tone.unwrap_or_default() }
    }
}

fn exposure(text: &str) -> Result<Exposure, Failure> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    stops(text).map(Exposure::Stops).map_err(|reason| format!("{reason}, or auto").into())
}

fn curve(text: &str) -> Result<ToneCurve, Failure> {
    let found = ToneCurve::ALL.into_iter().find(|(name, _)| *name == text).map(|(_, curve)| curve);
    named(found, "tone curves", ToneCurve::ALL.map(|(name, _)| name))
}

/// The options that replace the camera of the scene.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct ViewOverride {
    /// Eye, target and up vector, instead of the camera transformation
    #[arg(long = "lookat", value_name = "EX EY EZ LX LY LZ UX UY UZ", allow_hyphen_values = true, value_parser = checked(|text| numbers(text, "0 1 -5  0 1 0  0 1 0"), |view, points| view.look_at = Some(points)))]
    pub look_at: Option<[f64; 9]>,
    /// Angle of view along the shorter side, instead of fov
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = checked(number, |view, fov| view.fov = Some(fov)))]
    pub fov: Option<f64>,
    /// Radius of the aperture, instead of lensradius; 0 is a pinhole
    #[arg(long, visible_alias = "lensradius", value_name = "R", allow_negative_numbers = true, value_parser = checked(number, |view, radius| view.lens_radius = Some(radius)))]
    pub lens_radius: Option<f64>,
    /// Distance to the plane of focus, instead of focaldistance or focusdistance
    #[arg(long, visible_alias = "focaldistance", value_name = "D", allow_negative_numbers = true, value_parser = checked(number, |view, distance| view.focal_distance = Some(distance)))]
    pub focal_distance: Option<f64>,
    /// Part of the screen on the film, instead of screenwindow
    #[arg(long, visible_alias = "screenwindow", value_name = "X0 X1 Y0 Y1", allow_hyphen_values = true, value_parser = checked(|text| numbers(text, "-1.5 1.5 -1 1"), |view, edges| view.screen_window = Some(edges)))]
    pub screen_window: Option<[f64; 4]>,
    /// Instant of a scene that moves, in units of TransformTimes, instead of shutteropen to shutterclose
    #[arg(long, value_name = "T", allow_negative_numbers = true, value_parser = checked(number, |view, time| view.time = Some(time)))]
    pub time_at: Option<f64>,
}

impl ViewOverride {
    /// These options, as the loading of a scene takes them.
    pub fn options(&self) -> lookat_scene::ViewOverride {
        let ViewOverride { look_at, fov, lens_radius, focal_distance, screen_window, time_at } = *self;
        lookat_scene::ViewOverride { look_at, fov, lens_radius, focal_distance, screen_window, time: time_at }
    }

    /// Fails if the loaded camera cannot use one of the options.
    pub fn check_use(&self, scene: &Scene) -> Result<(), Failure> {
        let camera = &scene.view.camera;
        let is_environment = camera.projection == Projection::Environment;
        let given = [
            ("--lens-radius", self.lens_radius.is_some()),
            ("--focal-distance", self.focal_distance.is_some()),
            ("--screen-window", self.screen_window.is_some()),
        ];
        let idle = given.iter().find(|(_, is_given)| *is_given && is_environment);
        if self.fov.is_some() && matches!(camera.projection, Projection::Orthographic { .. }) {
            bail!("--fov has no effect on an orthographic camera; to see more or less, use --screen-window");
        }
        if self.fov.is_some() && is_environment {
            bail!("--fov has no effect on an environment camera, which sees all directions; remove it");
        }
        if let Some((option, _)) = idle {
            bail!("{option} has no effect on an environment camera; remove it");
        }
        if self.time_at.is_some() && !scene.has_motion() {
            bail!("--time-at has no effect: nothing in this scene moves; remove it");
        }
        let of_file = [
            (
                "--fov",
                self.fov.is_some(),
                "its angle of view comes from its lenses and from diagonal of Film",
            ),
            ("--lens-radius", self.lens_radius.is_some(), "its opening is aperturediameter in Camera"),
            ("--screen-window", self.screen_window.is_some(), "to show a part of the picture, use --crop"),
        ];
        let idle = of_file.iter().find(|(_, is_given, _)| *is_given && camera.lens_system().is_some());
        if let Some((option, _, instead)) = idle {
            bail!("{option} has no effect on a realistic camera: {instead}");
        }
        if self.focal_distance.is_some() && camera.lens.is_none() {
            bail!(
                "--focal-distance has no effect on a pinhole, which is sharp at all distances; add --lens-radius"
            );
        }
        Ok(())
    }
}

/// Parses numbers, separated by blanks or commas.
fn numbers<const N: usize>(text: &str, example: &str) -> Result<[f64; N], Failure> {
    let words = text.split([' ', '\t', '\n', ',']).filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| format!("expected {N} numbers in quotes, as in \"{example}\"").into())
}

fn number(text: &str) -> Result<f64, Failure> {
    text.parse().map_err(|_| "expected a number".into())
}

/// Parses an option, and checks it with the rules of the format.
fn checked<T: Copy + Send + Sync + 'static>(
    parse: fn(&str) -> Result<T, Failure>,
    set: fn(&mut lookat_scene::ViewOverride, T),
) -> impl Fn(&str) -> Result<T, Failure> + Clone {
    move |text| {
        let (value, mut view) = (parse(text)?, lookat_scene::ViewOverride::default());
        set(&mut view, value);
        view.check()?;
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_units() {
        let sizes = ["2G", "500M", "1.5GB", "2000000", "4000k", "1tb"].map(|text| size(text).unwrap());
        assert_eq!(
            sizes,
            [2_000_000_000, 500_000_000, 1_500_000_000, 2_000_000, 4_000_000, 1_000_000_000_000]
        );
        for text in ["", "G", "0", "-1G", "999k", "1MM", "2 G", "1e30", "nan", "inf", "2GBB", "1P"] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}
