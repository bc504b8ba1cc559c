//! The value of a picture on a surface (PBR 10.4).

use lookat_scene::{ImageFilter, ImageMap, Value};

use super::TexturePoint;
use super::mapping::{changes, coordinates};

pub(super) fn value<T: Value>(image: &ImageMap<T>, at: &TexturePoint) -> T {
    let st = coordinates(&image.mapping, at);
    let [dst0, dst1] = changes(&image.mapping, at);
    T::from_texel(match image.filter {
        ImageFilter::Trilinear => {
            image.map.trilinear(st, dst0.abs().max_element().max(dst1.abs().max_element()))
        }
        ImageFilter::Ellipse { max_anisotropy } => image.map.ewa(st, dst0, dst1, max_anisotropy),
    })
}
