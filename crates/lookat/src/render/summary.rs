//! What is said of a picture when it is done: in lines, as JSON, and in the picture itself.

use std::path::Path;

use lookat_render::{Reached, Rendered, Settings, TargetError};
use lookat_scene::Scene;
use serde::Serialize;

use crate::report::JsonDiagnostic;

/// What `--json` prints.
#[derive(Serialize)]
pub(super) struct JsonResult<'a> {
    pub scene: String,
    pub diagnostics: Vec<JsonDiagnostic<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<JsonPicture>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

#[derive(Serialize)]
pub(super) struct JsonPicture {
    pub file: String,
    pub width: u32,
    pub height: u32,
    pub samples_per_pixel: f64,
    pub least_samples: u32,
    pub most_samples: u32,
    pub seconds: f64,
    pub rays: u64,
    pub rejected_samples: u64,
    pub complete: bool,
    /// No light has come to the camera.
    pub black: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<JsonTarget>,
}

/// What became of the target error: numbers of pixels.
#[derive(Serialize)]
pub(super) struct JsonTarget {
    error: f64,
    confidence: f64,
    within: u64,
    at_cap: u64,
    out_of_time: u64,
    outliers: u64,
}

/// What a picture says of its making. It must not change from run to run.
#[derive(Serialize)]
pub struct Metadata {
    program: &'static str,
    version: &'static str,
    scene: String,
    seed: u64,
    samples_per_pixel: f64,
    complete: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    adaptive: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    target_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<f64>,
}

impl Metadata {
    pub fn new(scene: &Path, seed: u64, samples_per_pixel: f64, complete: bool) -> Metadata {
        let (program, version) = ("lookat", env!("CARGO_PKG_VERSION"));
        Metadata {
            program,
            version,
            scene: scene.display().to_string(),
            seed,
            samples_per_pixel,
            complete,
            adaptive: false,
            target_error: None,
            confidence: None,
        }
    }

    /// With what decided how often each pixel was sampled.
    pub(super) fn with_settings(self, settings: &Settings) -> Metadata {
        let target = settings.target_error;
        let (relative, confidence) =
            (target.map(|target| target.relative), target.map(|target| target.confidence));
        Metadata { adaptive: settings.adaptive, target_error: relative, confidence, ..self }
    }

    pub fn as_json(&self) -> Option<String> {
        serde_json::to_string(self).ok()
    }
}

/// The lines at the end.
pub(super) fn summarize(picture: &JsonPicture, rendered: &Rendered) {
    let JsonPicture { file, width, height, seconds, rays, .. } = picture;
    let rate = *rays as f64 / seconds / 1e6;
    let samples = samples(picture);
    let part = if rendered.complete { "" } else { "; interrupted, a partial picture" };
    crate::say(&format!(
        "{file}: {width} x {height} pixels, {samples}, {seconds:.2} s, {rate:.2} million rays/s{part}"
    ));
    if let Some(target) = &picture.target {
        target.summarize(picture);
    }
    if picture.least_samples == 0 {
        crate::say(match rendered.complete {
            true => "the time was too short for a sample of each pixel; those without one are black",
            false => "some pixels have no sample yet; they are black",
        });
    }
}

/// Says why a picture is all black.
pub(super) fn explain_black(picture: &JsonPicture, rendered: &Rendered, scene: &Scene) {
    if picture.black && rendered.complete && picture.least_samples > 0 {
        // Where light could come from, a second ray would have asked.
        let is_alone = picture.rays == rendered.statistics.samples;
        crate::say(match is_alone {
            true => {
                "the picture is all black: no ray from the camera meets a surface that scatters light; see LookAt and fov"
            }
            false if scene.lights.is_empty() && scene.shapes().any(|shape| shape.emission.is_some()) => {
                "the picture is all black: no light comes to the camera from what it sees; a shape glows on the side of its normals alone; see \"bool twosided\" and ReverseOrientation"
            }
            false => "the picture is all black: no light comes to the camera from what it sees",
        });
    }
    if rendered.statistics.rejected > 0 {
        let count = rendered.statistics.rejected;
        crate::say(&format!("{count} samples were infinite or not a number, and count as black"));
    }
}

/// How many samples the pixels have.
fn samples(picture: &JsonPicture) -> String {
    let JsonPicture { samples_per_pixel: mean, least_samples: least, most_samples: most, .. } = picture;
    match (least, most) {
        (1, 1) => "1 sample each".into(),
        (least, most) if least == most => format!("{most} samples each"),
        (least, most) => format!("{least} to {most} samples each, {mean:.1} on average"),
    }
}

impl JsonTarget {
    pub fn new(target: TargetError, reached: Reached) -> JsonTarget {
        let Reached { within, at_cap, out_of_time, outliers } = reached;
        let TargetError { relative: error, confidence } = target;
        JsonTarget { error, confidence, within, at_cap, out_of_time, outliers }
    }

    /// How many pixels are as exact as they should be, and what is not promised.
    fn summarize(&self, picture: &JsonPicture) {
        let all = (self.within + self.at_cap + self.out_of_time) as f64;
        let pixels = |count: u64| {
            let share = 100.0 * count as f64 / all;
            // Rounded, some must not become none or all.
            let share = if count as f64 == all { share } else { share.min(99.99) };
            let least =
                if count > 0 && share < 0.01 { "under 0.01".to_owned() } else { format!("{share:.2}") };
            format!("{count} {} ({least} %)", if count == 1 { "pixel" } else { "pixels" })
        };
        let [error, confidence] = [self.error, self.confidence].map(|share| (1e8 * share).round() / 1e6);
        crate::say(&format!(
            "{} taken to be within {error} % of the true brightness, each with {confidence} % confidence; light that no sample has met is not known of",
            pixels(self.within)
        ));
        if self.at_cap > 0 {
            let most = picture.most_samples;
            crate::say(&format!(
                "{} not shown to be so exact after {most} samples: nothing is claimed there",
                pixels(self.at_cap)
            ));
            if self.at_cap as f64 > 0.1 * all {
                crate::say(
                    "with so many, those that did reach it may partly be lucky: raise --spp or the target",
                );
            }
        }
        if self.out_of_time > 0 {
            crate::say(&format!(
                "{} not shown to be so exact by the end: nothing is claimed there",
                pixels(self.out_of_time)
            ));
        }
        if self.outliers > 0 {
            crate::say(&format!(
                "{} with a sample over 20 times as bright as all around: around them, pixels may be off by light that they have not seen; maxsampleluminance of the Film limits it",
                pixels(self.outliers)
            ));
        }
    }
}
