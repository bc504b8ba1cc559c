//! The value of a picture on a surface (PBR 10.4).

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::DVec2;
use lookat_image::MipMap;
use lookat_scene::{ImageFilter, ImageMap, Value};

use super::{TexturePoint, Values};
use crate::number::{LANES, Vec2x8, set_lanes, to_f32, vectorized};
use crate::texture::{changes, coordinates};

/// With neighbors one by one, by the filter; else bilinear.
#[inline(never)]
pub(super) fn value<S: Simd, T: Values<S>>(
    image: &ImageMap<T>,
    at: &TexturePoint<S>,
    active: mask64x8<S>,
) -> T::Wide {
    vectorized!(active.token(), {
        let st = coordinates(&image.mapping, at, active);
        let Some(footprint) = &at.footprint else {
            return T::from_texels(bilinear::<S, T>(&image.map, st, active));
        };
        let [x, y] = changes(&image.mapping, at, footprint, active);
        let is_still = x[0].simd_eq(0.0) & x[1].simd_eq(0.0) & y[0].simd_eq(0.0) & y[1].simd_eq(0.0);
        let mut filtered = [T::Texel::default(); LANES];
        for lane in set_lanes(active & !is_still) {
            let of = |v: &Vec2x8<S>| DVec2::new(v[0][lane], v[1][lane]);
            filtered[lane] = one(image, of(&st), [of(&x), of(&y)]);
        }
        let filtered = T::from_texels(T::texels(active.token(), &filtered));
        if (active & is_still).any_true() {
            T::keep_where(T::from_texels(bilinear::<S, T>(&image.map, st, active)), is_still, filtered)
        } else {
            filtered
        }
    })
}

fn one<T: Value>(image: &ImageMap<T>, st: DVec2, [dst0, dst1]: [DVec2; 2]) -> T::Texel {
    match image.filter {
        ImageFilter::Trilinear => {
            image.map.trilinear(st, dst0.abs().max_element().max(dst1.abs().max_element()))
        }
        ImageFilter::Ellipse { max_anisotropy } => image.map.ewa(st, dst0, dst1, max_anisotropy),
    }
}

/// Bilinear lookups in eight lanes, like [`MipMap::bilinear`].
#[inline(always)]
pub(crate) fn bilinear<S: Simd, T: Values<S>>(
    map: &MipMap<T::Texel>,
    st: Vec2x8<S>,
    active: mask64x8<S>,
) -> T::Texels {
    let place = [st[0] * map.width() as f64 - 0.5, st[1] * map.height() as f64 - 0.5];
    let far = MipMap::<T::Texel>::FAR;
    let place = [place[0].max(-far).min(far), place[1].max(-far).min(far)];
    let (s, t) = (place[0].floor(), place[1].floor());
    let mut corners = [[T::Texel::default(); LANES]; 4];
    for lane in set_lanes(active) {
        let own = map.corners(s[lane] as i64, t[lane] as i64);
        for (corner, texel) in corners.iter_mut().zip(own) {
            corner[lane] = texel;
        }
    }
    let simd = active.token();
    let [a, b, c, d] = [
        T::texels(simd, &corners[0]),
        T::texels(simd, &corners[1]),
        T::texels(simd, &corners[2]),
        T::texels(simd, &corners[3]),
    ];
    let (x, y) = (to_f32(place[0] - s), to_f32(place[1] - t));
    lerp::<S, T>(y, lerp::<S, T>(x, a, b), lerp::<S, T>(x, c, d))
}

#[inline(always)]
fn lerp<S: Simd, T: Values<S>>(x: f32x8<S>, a: T::Texels, b: T::Texels) -> T::Texels {
    a * (1.0 - x) + b * x
}
