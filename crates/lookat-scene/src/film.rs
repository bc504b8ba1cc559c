//! `Film`: the size of the picture and where it goes.

use std::path::PathBuf;

use lookat_image::Format;

use crate::color;
use crate::overrides::Overrides;
use crate::params::Params;

/// The film.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Width and height of the full picture in pixels, at least 1 (`xresolution`, default 1280, and `yresolution`,
    /// default 720).
    pub resolution: [u32; 2],
    /// The pixels that are rendered (`cropwindow`, default all), never empty.
    pub crop: PixelBounds,
    /// Factor on every pixel (`scale`, default 1).
    pub scale: f64,
    /// Samples brighter than this luminance are dimmed to it (`maxsampleluminance`, default infinite).
    pub max_sample_luminance: f64,
    /// Where the picture goes (`filename`, default `pbrt.exr`).
    pub file: PathBuf,
}

/// A rectangle of pixels, y down: `x0 <= x < x1`, `y0 <= y < y1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelBounds {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// The column after the last.
    pub x1: u32,
    /// The row after the last.
    pub y1: u32,
}

impl PixelBounds {
    /// Columns.
    pub fn width(self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    pub fn height(self) -> u32 {
        self.y1 - self.y0
    }

    /// Pixels.
    pub fn area(self) -> u64 {
        u64::from(self.width()) * u64::from(self.height())
    }
}

/// The longest side of a film. Beyond it lies a slip, not a picture.
const MAX_SIDE: i32 = 1_000_000;
/// The most pixels that one run renders: about 7 GB of sums and picture, 21 with error layers.
pub const MAX_PIXELS: u64 = 100_000_000;

pub(crate) const NAMES: &[&str] = &["image"];

/// pbrt-v3's CreateFilm. What is wrong is reported and has its default; the rest counts, so that the camera sees the
/// film that was meant.
pub(crate) fn film(params: &mut Params, overrides: &Overrides) -> Film {
    let known = NAMES.contains(&params.kind());
    if !known {
        params.unknown_kind::<()>(NAMES);
    }
    let resolution = resolution(params, overrides);
    let crop = crop(params, overrides, resolution);
    let mut scale = params.float("scale", 1.0);
    if scale.abs() > f64::from(color::LARGEST) {
        params.reject("scale", format!("scale is at most {:e}", color::LARGEST), None);
        scale = 1.0;
    }
    if scale <= 0.0 {
        let message = if scale == 0.0 {
            "scale is 0: the picture is all black"
        } else {
            "scale is below 0: so is the picture"
        };
        params.warn("scale", message, "light is multiplied by it; without it, by 1");
    }
    let mut max_sample_luminance = params.float("maxsampleluminance", f64::INFINITY);
    if max_sample_luminance <= 0.0 {
        params.reject("maxsampleluminance", "maxsampleluminance must be more than 0", None);
        max_sample_luminance = f64::INFINITY;
    }
    // Only the realistic camera asks for the size of the sensor.
    params.float("diagonal", 35.0);
    let file = params.string("filename").map_or_else(|| "pbrt.exr".into(), |name| PathBuf::from(name.value));
    if Format::from_path(&file).is_none() {
        let message = format!("lookat cannot write a picture named \"{}\"", file.display());
        let help = format!("the endings {} choose the format; or render with -o", Format::NAMES);
        params.warn("filename", &message, &help);
    }
    if known {
        params.finish();
    } else {
        params.ignore_rest();
    }
    Film { resolution, crop, scale, max_sample_luminance, file }
}

fn resolution(params: &mut Params, overrides: &Overrides) -> [u32; 2] {
    let mut side = |name: &'static str, default: i32| {
        let pixels = params.integer(name, default);
        if (1..=MAX_SIDE).contains(&pixels) {
            return pixels as u32;
        }
        params.reject(name, format!("{name} must be from 1 to {MAX_SIDE} pixels"), None);
        default as u32
    };
    let own = [side("xresolution", 1280), side("yresolution", 720)];
    match overrides.resolution {
        Some(resolution) => resolution,
        None if overrides.quick => own.map(|side| (side / 4).max(1)),
        None => own,
    }
}

const CROP_HELP: &str = "cropwindow is xmin xmax ymin ymax, from 0 to 1";

/// The bounds of pbrt-v3's Film, by `ceil` in `f32`, so that they are the same pixels.
fn crop(params: &mut Params, overrides: &Overrides, resolution: [u32; 2]) -> PixelBounds {
    let given = params.floats("cropwindow");
    let mut edges = [0.0, 1.0, 0.0, 1.0];
    if let Some(given) = given {
        match <[f64; 4]>::try_from(given) {
            Ok(four) => edges = four,
            Err(other) => {
                let message = format!("cropwindow takes 4 values, not {}", other.len());
                params.reject("cropwindow", message, Some(CROP_HELP));
            }
        }
    }
    let edges = overrides.crop.unwrap_or(edges);
    let pixel = |edge: f64, side: u32| (side as f32 * edge.clamp(0.0, 1.0) as f32).ceil() as u32;
    let [x0, x1, y0, y1] = edges;
    let mut bounds = PixelBounds {
        x0: pixel(x0.min(x1), resolution[0]),
        x1: pixel(x0.max(x1), resolution[0]),
        y0: pixel(y0.min(y1), resolution[1]),
        y1: pixel(y0.max(y1), resolution[1]),
    };
    let is_outside = edges.iter().any(|edge| !(0.0..=1.0).contains(edge));
    let is_reversed = x0 > x1 || y0 > y1;
    if bounds.area() == 0 {
        params.reject("cropwindow", "the crop window holds no pixel", Some(CROP_HELP));
        bounds = PixelBounds { x0: 0, y0: 0, x1: 1, y1: 1 };
    } else if overrides.crop.is_none() && is_reversed {
        let message = "the edges of the crop window are in reverse; they are swapped, as in pbrt-v3";
        params.warn("cropwindow", message, CROP_HELP);
    } else if overrides.crop.is_none() && is_outside {
        let message = "the crop window reaches beyond the picture, and is cut there, as in pbrt-v3";
        params.warn("cropwindow", message, CROP_HELP);
    }
    if bounds.area() > MAX_PIXELS {
        let message = format!("a picture of {} pixels; one run renders at most {MAX_PIXELS}", bounds.area());
        params.reject("xresolution", message, Some("render parts of it with cropwindow"));
        bounds = PixelBounds { x0: 0, y0: 0, x1: 1, y1: 1 };
    }
    bounds
}
