//! `Film`: the size of the picture, and the name of its file.

use std::path::PathBuf;

use lookat_image::Format;
use lookat_syntax::ParamType;
use serde::{Deserialize, Serialize};

use crate::color;
use crate::params::Params;
use crate::params::value::{Edges, Name};
use crate::schema::{Key, Kind, Range, Unit};

/// The film.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Width and height of the full picture in pixels, from 1 to [`MAX_SIDE`] (`xresolution`, default 1280, and `yresolution`,
    /// default 720).
    pub resolution: [u32; 2],
    /// The pixels to render (`cropwindow`, default all). Never empty.
    pub crop: PixelBounds,
    /// The factor on every pixel (`scale`, default 1).
    pub scale: f64,
    /// The largest luminance of a sample. Brighter samples are scaled down (`maxsampleluminance`, default infinite).
    pub max_sample_luminance: f64,
    /// The diagonal of the film in millimeters, above 0, for a realistic camera (`diagonal`, default 35).
    #[serde(default = "default_diagonal")]
    pub diagonal: f64,
}

fn default_diagonal() -> f64 {
    DIAGONAL.default
}

/// The size and the crop window of the picture, where the caller sets them instead of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FilmOverride {
    /// Width and height of the full picture in pixels, each from 1 to [`MAX_SIDE`].
    pub resolution: Option<[u32; 2]>,
    /// Without `resolution`: a quarter of the scene's width and height, as with pbrt-v3's `--quick`. Default: false.
    pub quarter: bool,
    /// The crop window: xmin, xmax, ymin, ymax, from 0 to 1.
    pub crop: Option<[f64; 4]>,
}

/// A rectangle of pixels, y down: `x0 <= x < x1`, `y0 <= y < y1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

impl Film {
    /// True if its size, its crop window and its limits are in their ranges.
    pub fn is_valid(&self) -> bool {
        let (crop, [width, height]) = (self.crop, self.resolution);
        let has_pixels = crop.x0 < crop.x1 && crop.x1 <= width && crop.y0 < crop.y1 && crop.y1 <= height;
        has_pixels
            && width.max(height) <= MAX_SIDE
            && crop.area() <= MAX_PIXELS
            && SCALE_RANGE.contains(self.scale)
            && self.max_sample_luminance > 0.0
            && DIAGONAL_RANGE.contains(self.diagonal)
    }

    /// A film of this width and height in pixels, with the defaults of pbrt-v3.
    pub fn new(resolution: [u32; 2]) -> Film {
        let [x1, y1] = resolution;
        Film {
            resolution,
            crop: PixelBounds { x0: 0, y0: 0, x1, y1 },
            scale: 1.0,
            max_sample_luminance: f64::INFINITY,
            diagonal: DIAGONAL.default,
        }
    }
}

impl PixelBounds {
    /// The pixels between these fractions of a picture (xmin, xmax, ymin, ymax), as in pbrt-v3's Film: `ceil` in `f32` gives
    /// the same pixels.
    pub fn of_fractions([x0, x1, y0, y1]: [f64; 4], [width, height]: [u32; 2]) -> PixelBounds {
        let pixel = |edge: f64, side: u32| (side as f32 * edge.clamp(0.0, 1.0) as f32).ceil() as u32;
        PixelBounds {
            x0: pixel(x0.min(x1), width),
            x1: pixel(x0.max(x1), width),
            y0: pixel(y0.min(y1), height),
            y1: pixel(y0.max(y1), height),
        }
    }

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

/// The longest side of a film in pixels. A larger number is a typing mistake.
pub const MAX_SIDE: u32 = 1_000_000;
/// The most pixels of one run.
pub const MAX_PIXELS: u64 = 100_000_000;

const fn side(name: &'static str, default: i32, meaning: &'static str) -> Key<i32> {
    Key::integer(name, default, meaning).within(Range::from_to(1.0, MAX_SIDE as f64)).unit(Unit::Pixels)
}

const X_RESOLUTION: Key<i32> = side("xresolution", 1280, "the width of the full picture");
const Y_RESOLUTION: Key<i32> = side("yresolution", 720, "the height of the full picture");
const CROP_WINDOW: Key<Edges> = Key::new(
    "cropwindow",
    ParamType::Float,
    Edges,
    "the part to render as fractions of the picture, y down: xmin xmax ymin ymax",
)
.default_words("0 1 0 1");
const SCALE: Key<f64> = Key::float("scale", 1.0, "a factor of the picture").within(SCALE_RANGE);
pub(crate) const SCALE_RANGE: Range = Range::from_to(-color::LARGEST, color::LARGEST);
const MAX_SAMPLE_LUMINANCE: Key<f64> = Key::float(
    "maxsampleluminance",
    f64::INFINITY,
    "the largest luminance of a sample; brighter samples are dimmed to it",
)
.within(Range::above(0.0));
const DIAGONAL: Key<f64> =
    Key::float("diagonal", 35.0, "the diagonal of the film in millimeters, for a realistic camera")
        .within(DIAGONAL_RANGE);
pub(crate) const DIAGONAL_RANGE: Range = Range::from_to(1e-6, 1e6);
const FILE_NAME: Key<Name> =
    Key::string("filename", "the picture file, relative to the working folder").default_words("\"pbrt.exr\"");
/// The file of the picture if the scene names none.
pub(crate) const DEFAULT_OUTPUT: &str = "pbrt.exr";

pub(crate) const KINDS: &[Kind] = &[Kind::new(
    "image",
    "a picture file",
    &[&[&X_RESOLUTION, &Y_RESOLUTION, &CROP_WINDOW, &SCALE, &MAX_SAMPLE_LUMINANCE, &FILE_NAME, &DIAGONAL]],
)];

/// pbrt-v3's CreateFilm: the film, and the file of the picture. Reports invalid values and uses their defaults, so that
/// the camera gets the intended film.
pub(crate) fn film(params: &mut Params, film_override: &FilmOverride) -> (Film, PathBuf) {
    let known = params.is_known_kind(KINDS);
    if !known {
        params.reject_unknown_type::<()>(KINDS);
    }
    let own = [&X_RESOLUTION, &Y_RESOLUTION].map(|side| params.take(side) as u32);
    let resolution = match film_override.resolution {
        Some(resolution) => resolution,
        None if film_override.quarter => own.map(|side| (side / 4).max(1)),
        None => own,
    };
    let own_crop = own_crop(params, own, film_override);
    let crop = crop(params, film_override.crop.unwrap_or(own_crop), own, resolution, film_override);
    let scale = params.take(&SCALE);
    if scale <= 0.0 {
        let message = if scale == 0.0 {
            "scale is 0: the picture is all black"
        } else {
            "scale is negative: all pixel values become negative"
        };
        params.warn("scale", message, "scale multiplies the picture; the default is 1");
    }
    let max_sample_luminance = params.take(&MAX_SAMPLE_LUMINANCE);
    let diagonal = params.take(&DIAGONAL);
    let output = output(params);
    if known {
        params.finish();
    } else {
        params.ignore_rest();
    }
    (Film { resolution, crop, scale, max_sample_luminance, diagonal }, output)
}

/// The file of the picture. Warns about a name that lookat cannot use.
fn output(params: &mut Params) -> PathBuf {
    let file = params.take(&FILE_NAME).map_or(DEFAULT_OUTPUT.into(), |name| PathBuf::from(name.value));
    if Format::from_path(&file).is_none() {
        let message = format!("lookat cannot write a picture named \"{}\"", file.display());
        let help = format!(
            "lookat writes {}: change the extension to one of them, or render with -o",
            Format::NAMES
        );
        params.warn("filename", &message, &help);
    } else if cfg!(not(windows)) && file.as_os_str().as_encoded_bytes().contains(&b'\\') {
        let message = "a backslash in the file name does not separate folders here";
        params.warn("filename", message, "write / between folders, or render with -o");
    }
    file
}

const CROP_HELP: &str = "write cropwindow as xmin xmax ymin ymax, from 0 to 1";
const WHOLE: [f64; 4] = [0.0, 1.0, 0.0, 1.0];

/// The crop window of the Film. Checks its edges, unless the caller replaces them.
fn own_crop(params: &mut Params, resolution: [u32; 2], film_override: &FilmOverride) -> [f64; 4] {
    let Some(edges) = params.take(&CROP_WINDOW) else { return WHOLE };
    if film_override.crop.is_some() {
        return edges;
    }
    let [x0, x1, y0, y1] = edges;
    if PixelBounds::of_fractions(edges, resolution).area() == 0 {
        params.reject("cropwindow", "the crop window contains no pixel", Some(CROP_HELP));
        return WHOLE;
    }
    if x0 > x1 || y0 > y1 {
        let message = "the edges of the crop window are reversed: they are swapped, as in pbrt-v3";
        params.warn("cropwindow", message, CROP_HELP);
    } else if edges.iter().any(|edge| !(0.0..=1.0).contains(edge)) {
        let message = "the crop window is larger than the picture: it is clipped, as in pbrt-v3";
        params.warn("cropwindow", message, CROP_HELP);
    }
    edges
}

/// The pixels to render.
fn crop(
    params: &mut Params,
    edges: [f64; 4],
    own: [u32; 2],
    resolution: [u32; 2],
    film_override: &FilmOverride,
) -> PixelBounds {
    const ONE: PixelBounds = PixelBounds { x0: 0, y0: 0, x1: 1, y1: 1 };
    let bounds = PixelBounds::of_fractions(edges, resolution);
    let [width, height] = resolution;
    if width.max(height) > MAX_SIDE {
        params.report.override_error =
            Some(format!("{width} x {height} is too large; the limit is {MAX_SIDE} pixels on a side"));
        return ONE;
    }
    if bounds.area() == 0 {
        params.report.override_error =
            Some(format!("the crop window contains no pixel of {width} x {height}"));
        return ONE;
    }
    if bounds.area() > MAX_PIXELS {
        let message =
            format!("the picture has {} pixels; the limit for one run is {MAX_PIXELS}", bounds.area());
        if film_override.crop.is_none() && resolution == own {
            params.reject("xresolution", message, Some("render parts with cropwindow"));
        } else {
            params.report.override_error = Some(message);
        }
        return ONE;
    }
    bounds
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{LoadOptions, load};

    #[test]
    fn sides_have_a_limit_that_a_crop_window_does_not_lift() {
        let override_error = |width| {
            let film = FilmOverride {
                resolution: Some([width, 1]),
                crop: Some([0.0, 0.001, 0.0, 1.0]),
                ..FilmOverride::default()
            };
            let options = LoadOptions { film, ..LoadOptions::default() };
            let read = |_: &Path| Ok(b"WorldBegin Shape \"sphere\" WorldEnd".to_vec());
            load(Path::new("a.pbrt"), &read, &options).override_error
        };
        assert_eq!(override_error(MAX_SIDE), None);
        let message = "1000001 x 1 is too large; the limit is 1000000 pixels on a side";
        assert_eq!(override_error(MAX_SIDE + 1).as_deref(), Some(message));
    }
}
