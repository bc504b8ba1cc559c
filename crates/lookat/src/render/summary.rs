//! The summary of a picture, as text and as JSON.

use lookat_render::glam::DVec2;
use lookat_render::{Prepared, Reached, Rendered, TargetError};
use lookat_scene::syntax::Span;
use lookat_scene::{Filter, Integrator, Primitive, Scene, Sources};
use lookat_sight::Numbered;
use serde::Serialize;

use crate::light::JsonLight;
use crate::readable::percent;
use crate::render::fireflies::Fireflies;
use crate::report;

#[derive(Serialize)]
pub struct JsonPicture {
    /// Its path.
    pub file: String,
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Mean number of samples per pixel.
    pub samples_per_pixel: f64,
    /// Fewest samples of a pixel.
    pub least_samples: u32,
    /// Most samples of a pixel.
    pub most_samples: u32,
    /// Time to render, without reading and preparing; after `lookat resume`, of all sittings.
    pub seconds: f64,
    /// Number of rays of all kinds.
    pub rays: u64,
    /// Infinite or NaN samples, which count as black.
    pub rejected_samples: u64,
    /// Samples too bright for the film's sums.
    pub clamped_samples: u64,
    /// False after Ctrl-C or [another signal](commands.md#render). With `--time`, true when the time is up.
    pub complete: bool,
    /// True if every pixel is black.
    pub black: bool,
    /// Its [brightness](commands.md#light-exposure-and-tone).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<JsonLight>,
    #[serde(flatten)]
    pub numbered: Numbered,
    /// From 1,024 samples on, without `maxsampleluminance`: pixels that one sample dominates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fireflies: Option<Fireflies>,
    /// With `--target-error`: numbers of pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<JsonTarget>,
}

/// The result of the target error, in numbers of pixels.
#[derive(Serialize)]
pub struct JsonTarget {
    /// The requested error.
    error: f64,
    /// The requested confidence.
    confidence: f64,
    #[serde(flatten)]
    reached: Reached,
}

/// Prints the summary.
pub fn summarize(picture: &JsonPicture, rendered: &Rendered) {
    let JsonPicture { file, width, height, seconds, rays, .. } = picture;
    let rate = *rays as f64 / seconds / 1e6;
    let samples = samples(picture);
    let part = if rendered.complete { "" } else { "; interrupted, partial picture" };
    say!("{file}: {width} x {height} pixels, {samples}, {seconds:.2} s, {rate:.2} million rays/s{part}");
    if let Some(target) = &picture.target {
        target.summarize(picture);
    }
    if picture.least_samples == 0 {
        crate::say(if rendered.complete {
            "the time was too short for one sample per pixel: pixels without samples are black"
        } else {
            "pixels without samples are black"
        });
    }
}

/// Why most of the picture is black, if the filter is the reason.
pub fn narrow_filter(rendered: &Rendered, filter: &Filter) -> Option<String> {
    let (unreached, all) = (rendered.statistics.unreached, rendered.image.data_window.area());
    let black = if unreached == all {
        "the picture is all black".into()
    } else {
        format!("{unreached} of {all} pixels are black")
    };
    let cause = if filter.radius.min_element() < 0.5 {
        "the PixelFilter is narrower than the gaps between samples; set xwidth and ywidth to at least 0.5"
    } else {
        "the PixelFilter falls to nothing within the gaps between samples; lower its alpha"
    };
    (2 * unreached > all).then(|| format!("{black}: {cause}"))
}

/// A picture with less than this share of the emitted radiance shows rounding: corners with a few digits tilt the triangles of a plane
/// towards each other.
const RESIDUE: f64 = 1e-9;

/// The largest luminance of a picture that shows rounding alone. 0 where not all light comes from shapes.
pub fn residue(scene: &Scene) -> f64 {
    let is_lit_otherwise = !scene.world.lights.is_empty()
        || matches!(scene.view.integrator, Integrator::AmbientOcclusion { .. });
    if is_lit_otherwise {
        return 0.0;
    }
    let radiance =
        scene.world.shapes().filter_map(|shape| shape.emission.as_ref()).map(|it| it.radiance.max_element());
    RESIDUE * f64::from(radiance.fold(0.0, f32::max)) * scene.view.film.scale
}

/// Prints the reason why a picture is black, all of it or where the filter leaves out samples.
pub fn explain_black(
    picture: &JsonPicture,
    rendered: &Rendered,
    scene: &Scene,
    prepared: &Prepared,
    sources: &Sources,
) {
    if !rendered.complete || picture.least_samples == 0 {
        // The summary says so.
    } else if let Some(reason) = narrow_filter(rendered, &scene.view.filter) {
        crate::say(&reason);
    } else if picture.black {
        let depth = match scene.view.integrator {
            Integrator::Path { max_depth, .. } | Integrator::DirectLighting { max_depth, .. } => max_depth,
            Integrator::AmbientOcclusion { .. } => 1,
        };
        // Without secondary rays, no surface scattered light.
        let is_alone = picture.rays == rendered.statistics.samples && depth > 0;
        if let Some(at) = is_alone.then(|| black_material(scene, prepared)).flatten() {
            let place = report::place(at, sources);
            say!(
                "the picture is all black: the camera sees the black material at {place}; give it a color above 0"
            );
        } else {
            let emits = scene.world.shapes().any(|shape| shape.emission.is_some());
            let reason = if is_alone {
                "no camera ray hits a surface that scatters light; check LookAt and fov"
            } else if depth == 0 {
                "with maxdepth 0, only lights are visible"
            } else if scene.world.lights.is_empty() && emits {
                "no visible surface receives light; area lights emit on the side of their normals only: check \"bool twosided\" and ReverseOrientation"
            } else {
                "no visible surface receives light"
            };
            say!("the picture is all black: {reason}");
        }
    }
    if rendered.statistics.rejected > 0 {
        let count = rendered.statistics.rejected;
        say!("{count} samples were infinite or NaN and count as black");
    }
    if rendered.statistics.clamped > 0 {
        let count = rendered.statistics.clamped;
        say!(
            "{count} samples were too bright for the film, about 2^31 times as bright as the picture, and are used as that bright; \
            set \"float maxsampleluminance\" of the Film"
        );
    }
}

/// The place of a black material that the camera sees.
fn black_material(scene: &Scene, prepared: &Prepared) -> Option<Span> {
    let is_black =
        |primitive: &Primitive| primitive.emission.is_none() && primitive.material.kind().is_black();
    if !scene.world.shapes().any(is_black) {
        return None;
    }
    let crop = scene.view.film.crop;
    // Few enough for an answer in a moment.
    let [across, down] = [crop.width(), crop.height()].map(|side| side.div_ceil(256) as usize);
    let pixels = (crop.y0..crop.y1)
        .step_by(down)
        .flat_map(|y| (crop.x0..crop.x1).step_by(across).map(move |x| [x, y]));
    pixels.into_iter().find_map(|[x, y]| {
        let picked = prepared.pick(&scene.view, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))?;
        picked.primitive.material.span.filter(|_| is_black(picked.primitive))
    })
}

/// The number of samples per pixel, in words.
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
        JsonTarget { error: target.relative, confidence: target.confidence, reached }
    }

    /// Prints the number of pixels that reached the target, and the limits of this claim.
    fn summarize(&self, picture: &JsonPicture) {
        let Reached { within, at_cap, out_of_time, outliers } = self.reached;
        let all = (within + at_cap + out_of_time) as f64;
        let pixels = |count: u64| {
            let share = percent(count as f64 / all, 2);
            format!("{count} {} ({share})", if count == 1 { "pixel" } else { "pixels" })
        };
        let [error, confidence] = [self.error, self.confidence].map(|share| (1e8 * share).round() / 1e6);
        say!(
            "{} within {error} % of the true brightness, per pixel at {confidence} % confidence, except light no sample hit",
            pixels(within)
        );
        if at_cap > 0 {
            let most = picture.most_samples;
            say!("{} above the target error after {most} samples", pixels(at_cap));
            if at_cap as f64 > 0.1 * all {
                say!(
                    "with so many pixels above the target error, others may be below it by chance: increase --spp or --target-error"
                );
            }
        }
        if out_of_time > 0 {
            say!("{} above the target error at the end", pixels(out_of_time));
        }
        if outliers > 0 {
            say!(
                "{} with a firefly, a sample over 20 times as bright as the pixels around it: neighboring pixels may miss this light; to limit fireflies, set maxsampleluminance of Film",
                pixels(outliers)
            );
        }
    }
}
