//! The options `--exposure` and `--tone`.

use clap::Args;
use lookat_image::{Image, ToneCurve, ToneMapping};

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

fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    super::stops(text).map(Exposure::Stops).map_err(|reason| format!("{reason}, or auto"))
}

fn curve(text: &str) -> Result<ToneCurve, String> {
    let found = ToneCurve::ALL.into_iter().find(|(name, _)| *name == text);
    let names = || ToneCurve::ALL.map(|(name, _)| name).join(", ");
    found.map(|(_, curve)| curve).ok_or_else(|| format!("the tone curves are {}", names()))
}
