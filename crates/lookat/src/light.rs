//! Tone mapping of 8-bit files, and the line about the light of a picture.

use std::path::Path;

use lookat_image::{Format, Image, Light, ToneCurve, ToneMapping};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::args::Tone;
use crate::readable::{percent, plural, quoted_file};
use lookat_sight::digits;

/// The light of a picture and its tone mapping, as JSON.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct JsonLight {
    /// Median luminance, without exposure.
    median: f32,
    /// Largest luminance, without exposure.
    largest: f32,
    /// Share of black pixels.
    black: f64,
    /// Share of the pixels with a channel above 1 after exposure and tone curve.
    clipped: f64,
    /// Number of infinite or NaN pixels.
    not_finite_pixels: u64,
    /// Exposure of this file, in stops.
    exposure: f64,
    /// A better exposure, if the picture is nearly black or overexposed.
    #[serde(skip_serializing_if = "Option::is_none")]
    advised_exposure: Option<f64>,
}

fn is_eight_bit(file: &Path) -> bool {
    Format::from_path(file).is_some_and(Format::is_eight_bit)
}

/// Says that options have no effect on a linear file.
pub fn note_linear(file: &Path, tone: Tone) {
    if tone.is_given() && !is_eight_bit(file) {
        let file = file.display();
        say!("{file}: --exposure and --tone change only .png and .tga files; this file stays linear");
    }
}

/// Maps the tones of a picture for this file, if it has 8 bits, and records the mapping in the metadata. Returns the light
/// before, or `None` for a picture without colors.
pub fn map_tones(image: &mut Image, file: &Path, tone: Tone) -> Option<JsonLight> {
    let mapping = if is_eight_bit(file) { tone.mapping(image) } else { ToneMapping::default() };
    let light = Light::of(image, mapping);
    mapping.apply(image);
    if mapping != ToneMapping::default() {
        image.metadata = recorded(image.metadata.take(), mapping);
    }
    let Light { median, largest, black, clipped, not_finite, advised_exposure } = light?;
    let exposure = mapping.exposure;
    Some(JsonLight {
        median,
        largest,
        black,
        clipped,
        not_finite_pixels: not_finite,
        exposure,
        advised_exposure,
    })
}

/// The metadata with the mapping. The exposures of a picture that was exposed before add up.
fn recorded(metadata: Option<String>, mapping: ToneMapping) -> Option<String> {
    let text = metadata.unwrap_or_else(|| "{}".into());
    let Ok(mut members) = serde_json::from_str::<Map<String, Value>>(&text) else { return Some(text) };
    let before = members.get("exposure").and_then(Value::as_f64).unwrap_or(0.0);
    members.insert("exposure".into(), (before + mapping.exposure).into());
    if let Some((name, _)) =
        ToneCurve::ALL.iter().find(|(_, curve)| *curve == mapping.curve && *curve != ToneCurve::None)
    {
        members.insert("tone".into(), (*name).into());
    }
    Some(Value::Object(members).to_string())
}

impl JsonLight {
    /// True if the picture is black: nothing is brighter than `residue`, which is the largest luminance that rounding makes.
    pub fn is_black(&self, residue: f64) -> bool {
        self.black == 1.0 || self.not_finite_pixels == 0 && f64::from(self.largest) <= residue
    }

    /// Prints the line about light. With `advise`, also the exposure that shows a picture that is nearly black or mostly
    /// clipped.
    pub fn print(&self, file: &Path, advise: bool) {
        let [median, largest] = [self.median, self.largest].map(|it| digits(it.into(), 2));
        let [black, clipped] = [self.black, self.clipped].map(|share| percent(share, 1));
        let not_finite = match self.not_finite_pixels {
            0 => String::new(),
            count => format!("; {} not finite", plural(count, "pixel is", "pixels are")),
        };
        let exposed = match self.exposure {
            0.0 => String::new(),
            stops => format!(" with exposure {stops}"),
        };
        say!(
            "light: median {median}, largest {largest}; {black} of pixels black, {clipped} clip in an 8-bit file{exposed}{not_finite}"
        );
        let Some(stops) = self.advised_exposure.filter(|_| advise) else { return };
        let state = if stops > self.exposure { "nearly black" } else { "overexposed" };
        crate::say(&if is_eight_bit(file) {
            format!("the picture is {state}: try --exposure {stops}")
        } else {
            let [from, to] = [file, &file.with_extension("png")].map(quoted_file);
            format!(
                "saved unchanged; the picture is {state}: try lookat convert {from} {to} --exposure {stops}"
            )
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_keeps_what_it_has() {
        let mapping = ToneMapping { exposure: 2.0, curve: ToneCurve::Aces };
        let record = |text: Option<&str>| recorded(text.map(String::from), mapping).unwrap();
        assert_eq!(record(None), r#"{"exposure":2.0,"tone":"aces"}"#);
        assert_eq!(
            record(Some(r#"{"exposure":-0.5,"seed":3}"#)),
            r#"{"exposure":1.5,"seed":3,"tone":"aces"}"#
        );
        assert_eq!(record(Some("not JSON")), "not JSON");
    }
}
