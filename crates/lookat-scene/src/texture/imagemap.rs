//! `Texture "imagemap"`: a picture.

use std::path::Path;
use std::sync::Arc;

use lookat_image::{MipMap, Wrap};
use lookat_syntax::Text;

use super::{Mapping, Parameter, Texture, Value, Varying, mapping};
use crate::Transform;
use crate::cache::PictureSettings;
use crate::color::LARGEST;
use crate::params::Params;
use crate::params::value::Name;
use crate::picture::{Pictures, gray};
use crate::schema::{Key, Keys, Range};

/// A picture on a surface.
#[derive(Debug, Clone)]
pub struct ImageMap<T: Value> {
    /// The picture, with its lowest row first. Its values are linear and include `scale` (`filename`, `wrap`,
    /// `scale`, `gamma`).
    pub map: Arc<MipMap<T::Texel>>,
    /// The texture coordinate mapping.
    pub mapping: Mapping,
    /// The filter for minification.
    pub filter: ImageFilter,
}

/// The filter over the texture footprint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImageFilter {
    /// Isotropic (`trilinear`).
    Trilinear,
    /// Elliptical (EWA).
    Ellipse {
        /// The largest ratio of the axes, above 0, at most 1000 (`maxanisotropy`, default 8).
        max_anisotropy: f64,
    },
}

/// The largest ratio of the axes. Longer ellipses take too long.
const MOST_ANISOTROPY: f64 = 1000.0;

impl ImageFilter {
    pub(crate) const ANISOTROPY_RANGE: Range = Range::above_to(0.0, MOST_ANISOTROPY);
}

const FILE_NAME: Key<Name> =
    Key::string("filename", "the picture, as exr, pfm, png, tga, jpg or hdr").required();
const WRAP: Key<&[&str]> =
    Key::choice("wrap", &["repeat", "black", "clamp"], "how the picture continues outside its edges");
const TRILINEAR: Key<bool> =
    Key::bool("trilinear", false, "true filters isotropically, false along an ellipse (EWA)");
const MAX_ANISOTROPY: Key<f64> = Key::float(
    "maxanisotropy",
    8.0,
    "the largest ratio of the axes of the ellipse; over 1000 counts as 1000",
)
.within(Range::above(0.0));
const SCALE: Key<f64> =
    Key::float("scale", 1.0, "the factor of the values").within(Range::from_to(-LARGEST, LARGEST));
const GAMMA: Key<bool> =
    Key::bool("gamma", false, "true if the values of the file are sRGB, false if linear")
        .default_words("true for png, tga and jpg, otherwise false");

pub(super) const KEYS: Keys = &[&FILE_NAME, &WRAP, &TRILINEAR, &MAX_ANISOTROPY, &SCALE, &GAMMA];

/// pbrt-v3's CreateImageFloatTexture and CreateImageSpectrumTexture.
pub(super) fn imagemap<T: Parameter>(
    params: &mut Params,
    world_from_texture: Transform,
    pictures: &mut Pictures,
) -> Option<Texture<T>> {
    let filter = filter(params);
    let wrap = wrap(params);
    let scale = (params.take(&SCALE) as f32).to_bits();
    let file = params.take(&FILE_NAME);
    let gamma = params.take(&Key { default: file.as_ref().is_some_and(is_encoded), ..GAMMA });
    let mapping = mapping::mapping(params, world_from_texture);
    if matches!(mapping, Mapping::Spherical { .. } | Mapping::Cylindrical { .. }) {
        let message = "pbrt-v3 shows the mean of the whole picture along the seam of this mapping";
        params.warn("mapping", message, "use the \"uv\" mapping: on a mesh or sphere, it has no such seam");
    }
    let Some(file) = file else {
        params.finish();
        return None;
    };
    let settings = PictureSettings { wrap, gamma, scale, bottom_up: true, not_negative: false };
    let instead = "shows gray instead of this picture";
    let map =
        pictures.get(params, FILE_NAME.name, &file, settings, instead).unwrap_or_else(|| gray(&settings));
    let texture = Texture::varying(Varying::ImageMap(Box::new(ImageMap { map, mapping, filter })));
    if params.usable() {
        return Some(texture);
    }
    params.finish();
    None
}

/// True if the format stores sRGB values, as in pbrt-v3, which does not read jpg.
fn is_encoded(file: &Text) -> bool {
    let ending = Path::new(&file.value).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ["png", "tga", "jpg", "jpeg"].contains(&ending.to_ascii_lowercase().as_str()))
}

fn filter(params: &mut Params) -> ImageFilter {
    let max_anisotropy = params.take(&MAX_ANISOTROPY);
    if max_anisotropy > MOST_ANISOTROPY {
        let message = format!("maxanisotropy {max_anisotropy} is limited to {MOST_ANISOTROPY}");
        params.note(
            "maxanisotropy",
            &message,
            "a larger ratio makes no visible difference; the default is 8",
        );
    }
    if params.take(&TRILINEAR) {
        params.unused("maxanisotropy", "the filter is trilinear", "delete maxanisotropy or trilinear");
        ImageFilter::Trilinear
    } else {
        ImageFilter::Ellipse { max_anisotropy: max_anisotropy.min(MOST_ANISOTROPY) }
    }
}

fn wrap(params: &mut Params) -> Wrap {
    match params.take(&WRAP) {
        "black" => Wrap::Black,
        "clamp" => Wrap::Clamp,
        _ => Wrap::Repeat,
    }
}
