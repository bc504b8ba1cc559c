//! `Texture "imagemap"`: a picture.
//!
//! - `filename`: the picture, as exr, pfm, png, tga, jpg or hdr
//! - `wrap`: the values outside the picture: `repeat` (default), `black` or `clamp`
//! - `trilinear`: isotropic trilinear filter; default false, for an elliptical filter (EWA)
//! - `maxanisotropy`: the largest ratio of the axes of the ellipse, default 8
//! - `scale`: the factor on the values, default 1
//! - `gamma`: convert from sRGB to linear; default true for png, tga and jpg
//! - the parameters of [`Mapping`]

use std::path::Path;
use std::sync::Arc;

use lookat_image::{MipMap, Wrap};
use lookat_syntax::Text;

use super::{Mapping, Parameter, Texture, Value, Varying, mapping};
use crate::Transform;
use crate::params::Params;
use crate::picture::{Pictures, Settings};

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

/// pbrt-v3's CreateImageFloatTexture and CreateImageSpectrumTexture.
pub(super) fn imagemap<T: Parameter>(
    params: &mut Params,
    world_from_texture: Transform,
    pictures: &mut Pictures,
) -> Option<Texture<T>> {
    let filter = filter(params);
    let wrap = wrap(params);
    let scale = params.float("scale", 1.0) as f32;
    let file = params.string("filename");
    let gamma = params.bool("gamma", file.as_ref().is_some_and(is_encoded));
    let mapping = mapping::mapping(params, world_from_texture);
    if matches!(mapping, Mapping::Spherical { .. } | Mapping::Cylindrical { .. }) {
        let message = "pbrt-v3 shows the mean of the whole picture along the seam of this mapping";
        params.warn("mapping", message, "use the \"uv\" mapping: on a mesh or sphere, it has no such seam");
    }
    let Some(file) = file else {
        let help = "add \"string filename\" with the name of a picture";
        params.missing("filename", "Texture \"imagemap\" has no filename", help);
        params.finish();
        return None;
    };
    let settings = Settings { wrap, gamma, scale, bottom_up: true, not_negative: false };
    let map =
        T::cache(pictures).get(params, "filename", &file, settings, "shows gray instead of this picture");
    let Some(map) = map.filter(|_| params.usable()) else {
        params.finish();
        return None;
    };
    Some(Texture::varying(Varying::ImageMap(Box::new(ImageMap { map, mapping, filter }))))
}

/// True if the format stores sRGB values, as in pbrt-v3, which does not read jpg.
fn is_encoded(file: &Text) -> bool {
    let ending = Path::new(&file.value).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ["png", "tga", "jpg", "jpeg"].contains(&ending.to_ascii_lowercase().as_str()))
}

fn filter(params: &mut Params) -> ImageFilter {
    let max_anisotropy = params.float("maxanisotropy", 8.0);
    if max_anisotropy <= 0.0 {
        params.reject("maxanisotropy", "maxanisotropy must be above 0", None);
    } else if max_anisotropy > MOST_ANISOTROPY {
        let message = format!("maxanisotropy {max_anisotropy} is limited to {MOST_ANISOTROPY}");
        params.note("maxanisotropy", &message, "more makes no visible difference; the default is 8");
    }
    match params.bool("trilinear", false) {
        true => ImageFilter::Trilinear,
        false => ImageFilter::Ellipse { max_anisotropy: max_anisotropy.min(MOST_ANISOTROPY) },
    }
}

fn wrap(params: &mut Params) -> Wrap {
    match params.choice("wrap", &["repeat", "black", "clamp"]) {
        "black" => Wrap::Black,
        "clamp" => Wrap::Clamp,
        _ => Wrap::Repeat,
    }
}
