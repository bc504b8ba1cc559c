//! Options that render several pictures of one scene.

use std::str::FromStr;

use clap::Args;

use super::{Render, ViewOverride, whole};

/// The most pictures of one run.
const MOST: u32 = 100_000;

/// Pictures of one scene by a moving camera.
#[derive(Debug, Clone, Default, Args)]
pub struct Frames {
    /// Write N numbered pictures while the camera turns once around the point that it looks at
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole(1, MOST))]
    pub turntable: Option<u32>,
    /// Write numbered pictures while a parameter goes from A to B: fov, lens-radius, focal-distance, eye.x, eye.y,
    /// eye.z, look.x, look.y or look.z
    #[arg(long, value_name = "PARAMETER=A..B", requires = "frames", conflicts_with = "turntable")]
    pub animate: Option<Animation>,
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
    /// A number of `LookAt`.
    LookAt(usize),
}

const PARAMETERS: [(&str, Parameter); 9] = [
    ("fov", Parameter::Fov),
    ("lens-radius", Parameter::LensRadius),
    ("focal-distance", Parameter::FocalDistance),
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
        match number == last {
            true => self.to,
            false => self.from + (self.to - self.from) * (f64::from(number) / f64::from(last)),
        }
    }
}

impl FromStr for Animation {
    type Err = String;

    fn from_str(text: &str) -> Result<Animation, String> {
        const EXPECTED: &str = "expected PARAMETER=A..B, as in fov=20..60";
        let (name, range) = text.split_once('=').ok_or(EXPECTED)?;
        let (from, to) = range.split_once("..").ok_or(EXPECTED)?;
        let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
        let (from, to) = number(from).zip(number(to)).ok_or(EXPECTED)?;
        let found = PARAMETERS.into_iter().find(|(known, _)| *known == name);
        let Some((_, parameter)) = found else {
            return Err(format!("the parameters are {}", PARAMETERS.map(|(name, _)| name).join(", ")));
        };
        for value in [from, to] {
            let view = parameter.set(value);
            view.check().map_err(|reason| format!("{name} cannot be {value}: {reason}"))?;
        }
        Ok(Animation { parameter, from, to })
    }
}

impl Parameter {
    /// The name in the command line.
    pub fn name(self) -> &'static str {
        PARAMETERS.into_iter().find(|(_, parameter)| *parameter == self).map_or("", |(name, _)| name)
    }

    /// The override with this value. A number of `LookAt` alone is none.
    fn set(self, value: f64) -> lookat_scene::ViewOverride {
        let mut view = ViewOverride::default();
        match self {
            Parameter::Fov => view.fov = Some(value),
            Parameter::LensRadius => view.lens_radius = Some(value),
            Parameter::FocalDistance => view.focal_distance = Some(value),
            Parameter::LookAt(_) => {}
        }
        view.options()
    }
}

impl Render {
    /// The view of the first picture. An animated radius is at its largest here, because a pinhole has no focal distance.
    pub fn first_view(&self) -> ViewOverride {
        let mut view = self.view;
        match self.frames.animate {
            Some(Animation { parameter: Parameter::Fov, from, .. }) => view.fov = Some(from),
            Some(Animation { parameter: Parameter::LensRadius, from, to }) => {
                view.lens_radius = Some(from.max(to))
            }
            Some(Animation { parameter: Parameter::FocalDistance, from, .. }) => {
                view.focal_distance = Some(from)
            }
            _ => {}
        }
        view
    }
}

impl Frames {
    /// True if a scene gives several pictures.
    pub fn is_used(&self) -> bool {
        self.turntable.is_some() || self.animate.is_some()
    }
}
