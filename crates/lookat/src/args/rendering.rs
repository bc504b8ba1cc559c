//! The arguments of `lookat render` that make several pictures, show them, and focus the lens.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use lookat_scene::glam::DVec2;

use crate::args::numbers::whole;
use crate::args::options::ViewOverride;
use crate::failure::Failure;

/// The most pictures of one run.
const MOST: u32 = 100_000;

/// Pictures of one scene by a moving camera.
#[derive(Debug, Clone, Default, Args)]
pub struct Frames {
    /// Write N numbered pictures while the camera turns once around the point that it looks at
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(1, MOST))]
    pub turntable: Option<u32>,
    /// Write numbered pictures while a parameter goes from A to B: fov, lens-radius, focal-distance, time-at,
    /// eye.x, eye.y, eye.z, look.x, look.y or look.z
    #[arg(long, value_name = "PARAMETER=A..B", requires = "frames", conflicts_with = "turntable")]
    pub animate: Option<Animation>,
    /// Render only the K-th of these pictures, counted from 1
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = whole(1, MOST))]
    pub only: Option<u32>,
    /// Number of pictures of --animate
    #[arg(long, value_name = "N", requires = "animate", allow_negative_numbers = true, value_parser = whole(2, MOST))]
    pub frames: Option<u32>,
}

/// A parameter that goes from one value to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Animation {
    pub parameter: Parameter,
    pub from: f64,
    pub to: f64,
}

/// A parameter of the view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    Fov,
    LensRadius,
    FocalDistance,
    /// The instant of a scene that moves.
    Time,
    /// A number of `LookAt`.
    LookAt(usize),
}

const PARAMETERS: [(&str, Parameter); 10] = [
    ("fov", Parameter::Fov),
    ("lens-radius", Parameter::LensRadius),
    ("focal-distance", Parameter::FocalDistance),
    ("time-at", Parameter::Time),
    ("eye.x", Parameter::LookAt(0)),
    ("eye.y", Parameter::LookAt(1)),
    ("eye.z", Parameter::LookAt(2)),
    ("look.x", Parameter::LookAt(3)),
    ("look.y", Parameter::LookAt(4)),
    ("look.z", Parameter::LookAt(5)),
];

impl Animation {
    /// The value of a picture, from 0 to `last`.
    pub fn value(&self, number: u32, last: u32) -> f64 {
        if number == last {
            self.to
        } else {
            self.from + (self.to - self.from) * (f64::from(number) / f64::from(last))
        }
    }
}

impl FromStr for Animation {
    type Err = Failure;

    fn from_str(text: &str) -> Result<Animation, Failure> {
        const EXPECTED: &str = "expected PARAMETER=A..B, as in fov=20..60";
        let (name, range) = text.split_once('=').ok_or(EXPECTED)?;
        let (from, to) = range.split_once("..").ok_or(EXPECTED)?;
        let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
        let (from, to) = number(from).zip(number(to)).ok_or(EXPECTED)?;
        let found = PARAMETERS.into_iter().find(|(known, _)| *known == name);
        let Some((_, parameter)) = found else {
            bail!("the parameters are {}", PARAMETERS.map(|(name, _)| name).join(", "));
        };
        for value in [from, to] {
            let mut view = ViewOverride::default();
            parameter.set(value, &mut view);
            view.options().check().map_err(|reason| format!("{name} cannot be {value}: {reason}"))?;
        }
        Ok(Animation { parameter, from, to })
    }
}

impl Parameter {
    /// The name in the command line.
    pub fn name(self) -> &'static str {
        PARAMETERS.into_iter().find(|(_, parameter)| *parameter == self).map_or("", |(name, _)| name)
    }

    /// True if an override has a value. A number of `LookAt` replaces one of the nine, and needs the others.
    pub fn is_set(self, view: &ViewOverride) -> bool {
        match self {
            Parameter::Fov => view.fov.is_some(),
            Parameter::LensRadius => view.lens_radius.is_some(),
            Parameter::FocalDistance => view.focal_distance.is_some(),
            Parameter::Time => view.time_at.is_some(),
            Parameter::LookAt(_) => false,
        }
    }

    /// Sets the value in an override. A number of `LookAt` alone is none.
    pub fn set(self, value: f64, view: &mut ViewOverride) {
        match self {
            Parameter::Fov => view.fov = Some(value),
            Parameter::LensRadius => view.lens_radius = Some(value),
            Parameter::FocalDistance => view.focal_distance = Some(value),
            Parameter::Time => view.time_at = Some(value),
            Parameter::LookAt(_) => {}
        }
    }
}

impl Frames {
    /// The number of pictures.
    pub fn count(&self) -> u32 {
        self.turntable.or(self.frames).unwrap_or(1)
    }

    /// True if a scene gives several pictures.
    pub fn is_used(&self) -> bool {
        self.turntable.is_some() || self.animate.is_some()
    }
}

/// Where to show the picture while it is rendered.
#[derive(Debug, Clone, Default, Args)]
pub struct LiveView {
    /// Draw the picture in the terminal as it grows
    #[arg(long, value_name = "PROTOCOL", num_args = 0..=1, require_equals = true, default_missing_value = "auto")]
    pub show: Option<Protocol>,
    /// Stream the picture to the viewer tev as it grows; tev listens at 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT", value_parser = address)]
    pub tev: Option<String>,
    /// Render again whenever the scene or a file that it uses is saved; end with Ctrl-C
    #[arg(long, conflicts_with_all = ["turntable", "animate"])]
    pub watch: bool,
}

/// How to draw a picture in a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// The best protocol that the terminal supports
    Auto,
    Kitty,
    Iterm,
    Sixel,
    /// Two pixels per character
    Blocks,
}

fn address(text: &str) -> Result<String, Failure> {
    let is_address =
        text.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok());
    if is_address { Ok(text.into()) } else { Err("expected a host and a port, as in 127.0.0.1:14158".into()) }
}

/// A place of the full picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FocusPlace {
    /// A pixel, counted from the top left corner.
    Pixel(DVec2),
    /// Fractions of the width and the height, from the top left corner.
    Fractions(DVec2),
}

/// Parses X,Y: whole numbers are a pixel, numbers with a point are fractions.
pub fn focus_place(text: &str) -> Result<FocusPlace, Failure> {
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
