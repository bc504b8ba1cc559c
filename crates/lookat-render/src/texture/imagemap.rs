//! The value of a picture on a surface (PBR 10.4).

use fearless_simd::{Simd, mask64x8, prelude::*};
use lookat_scene::{ImageFilter, ImageMap};

use super::trilinear::{bilinear, trilinear};
use super::{TexturePoint, Values, changes, coordinates, ellipse};
use crate::number::{vectorized, widen};

/// With neighbors by the filter; else bilinear.
#[inline(never)]
pub(super) fn value<S: Simd, T: Values<S>>(
    image: &ImageMap<T>,
    at: &TexturePoint<S>,
    active: mask64x8<S>,
) -> T::Wide {
    vectorized!(active.token(), {
        let (map, st) = (&*image.map, coordinates(&image.mapping, at, active));
        let Some(footprint) = at.footprint else {
            return T::from_texels(bilinear::<S, T>(map, st, active));
        };
        let ends @ [x, y] = changes(&image.mapping, at, footprint, active);
        match image.filter {
            ImageFilter::Trilinear => {
                let width = x[0].abs().max(x[1].abs()).max(y[0].abs().max(y[1].abs()));
                T::from_texels(trilinear::<S, T>(map, st, width, active))
            }
            ImageFilter::Ellipse { max_anisotropy } => {
                let (means, is_point) = ellipse::means::<S, T>(map, st, ends, max_anisotropy, active);
                let (means, is_point) = (T::from_texels(means), widen(is_point) & active);
                if is_point.any_true() {
                    T::keep_where(T::from_texels(bilinear::<S, T>(map, st, is_point)), is_point, means)
                } else {
                    means
                }
            }
        }
    })
}

#[cfg(test)]
mod tests;
