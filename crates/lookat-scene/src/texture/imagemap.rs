//! `Texture "imagemap"`: a picture.
//!
//! - `filename`: the picture, as exr, pfm, png, tga, jpg or hdr
//! - `wrap`: what lies beyond its edges, `repeat` (the default), `black` or `clamp`
//! - `trilinear`: filtered alike in all directions; default false, by ellipses
//! - `maxanisotropy`: the longest ellipse by its width, default 8
//! - `scale`: a factor of the values, default 1
//! - `gamma`: the values are on the sRGB curve; default true for png, tga and jpg
//! - those of the mapping (`mapping.rs`)

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
    /// The picture, its first row the lowest; `scale` is multiplied in, and the values are linear (`filename`, `wrap`,
    /// `scale`, `gamma`).
    pub map: Arc<MipMap<T::Texel>>,
    /// Where on the picture a point of the surface lies.
    pub mapping: Mapping,
    /// How it is averaged where it is small.
    pub filter: ImageFilter,
}

/// How a picture is averaged over what one camera ray stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImageFilter {
    /// Over a square (`trilinear`).
    Trilinear,
    /// Over an ellipse.
    Ellipse {
        /// The most that it is longer than wide, more than 0, at most 1000 (`maxanisotropy`, default 8).
        max_anisotropy: f64,
    },
}

/// Longer ellipses take too long.
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
        params.warn("mapping", message, "\"uv\" mapping of a mesh or sphere has no such line");
    }
    let Some(file) = file else {
        let help = "\"string filename\" names the picture";
        params.missing("filename", "Texture \"imagemap\" has no filename", help);
        params.finish();
        return None;
    };
    let settings = Settings { wrap, gamma, scale, bottom_up: true, not_negative: false };
    let map = T::cache(pictures).get(params, "filename", &file, settings);
    let Some(map) = map.filter(|_| params.usable()) else {
        params.finish();
        return None;
    };
    Some(Texture::varying(Varying::ImageMap(Box::new(ImageMap { map, mapping, filter }))))
}

/// pbrt-v3 reads no jpg; the others are as there.
fn is_encoded(file: &Text) -> bool {
    let ending = Path::new(&file.value).extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ["png", "tga", "jpg", "jpeg"].contains(&ending.to_ascii_lowercase().as_str()))
}

fn filter(params: &mut Params) -> ImageFilter {
    let max_anisotropy = params.float("maxanisotropy", 8.0);
    if max_anisotropy <= 0.0 {
        params.reject("maxanisotropy", "maxanisotropy must be more than 0", None);
    } else if max_anisotropy > MOST_ANISOTROPY {
        let message = format!("maxanisotropy {max_anisotropy} is taken as {MOST_ANISOTROPY}");
        params.note(
            "maxanisotropy",
            &message,
            "more makes no difference that could be seen; 8 is the default",
        );
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
