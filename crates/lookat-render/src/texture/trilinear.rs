//! Linear lookups in pictures, between texels and between versions, eight side by side (PBR 10.4.4).

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};
use lookat_image::{Level, MipMap};

use super::Values;
use crate::number::{LANES, Vec2x8, log2, set_lanes, to_f32};

/// Two versions of a picture for each of eight lookups.
pub(super) struct Versions<S: Simd> {
    finer: [usize; LANES],
    /// The share of the coarser version, the one after.
    share: f32x8<S>,
}

impl<S: Simd> Versions<S> {
    /// The versions whose texels are as wide as so many of the finest: at least 1.
    #[inline(always)]
    pub fn new(widths: f32x8<S>) -> Self {
        let (exponents, share) = log2(widths);
        Versions { finer: exponents.map(|exponent| exponent as usize), share }
    }

    /// The means between both versions.
    #[inline(always)]
    pub fn mean<T: Values<S>>(&self, of: impl Fn(&[usize; LANES]) -> T::Texels) -> T::Texels {
        let finer = of(&self.finer);
        // It is 0 everywhere in an enlarged picture.
        if self.share.simd_eq(0.0).all_true() {
            return finer;
        }
        lerp::<S, T>(self.share, finer, of(&self.finer.map(|version| version + 1)))
    }
}

/// The means around `st` over about `width`: linear between texels and between versions (PBR 10.4.4).
#[inline(always)]
pub(super) fn trilinear<S: Simd, T: Values<S>>(
    map: &MipMap<T::Texel>,
    st: Vec2x8<S>,
    width: f64x8<S>,
    active: mask64x8<S>,
) -> T::Texels {
    let (side, levels) = (map.width().max(map.height()) as f64, map.levels());
    let mut versions = Versions::new(to_f32((width * side).max(1.0).min(side)));
    // Over all of the picture, it is the mean, even where it is dark beyond the edges.
    versions.finer =
        versions.finer.map(|version| if version + 1 == levels.len() { version + 1 } else { version });
    versions.mean::<T>(
        #[inline(always)]
        |versions| {
            let own = versions.map(|version| &levels[version.min(levels.len() - 1)]);
            let [width, height] = sizes(active.token(), &own);
            between_texels::<S, T>([st[0] * width, st[1] * height], active, |lane, s, t| {
                if versions[lane] < levels.len() {
                    own[lane].corners(s, t, map.wrap())
                } else {
                    [map.mean(); 4]
                }
            })
        },
    )
}

/// Columns and rows.
#[inline(always)]
pub(super) fn sizes<S: Simd, T>(simd: S, levels: &[&Level<T>; LANES]) -> Vec2x8<S>
where
    T: lookat_image::Texel,
{
    [
        f64x8::from_fn(simd, |lane| levels[lane].width() as f64),
        f64x8::from_fn(simd, |lane| levels[lane].height() as f64),
    ]
}

/// Bilinear lookups in eight lanes, like [`MipMap::bilinear`].
#[inline(always)]
pub(crate) fn bilinear<S: Simd, T: Values<S>>(
    map: &MipMap<T::Texel>,
    st: Vec2x8<S>,
    active: mask64x8<S>,
) -> T::Texels {
    let place = [st[0] * map.width() as f64, st[1] * map.height() as f64];
    between_texels::<S, T>(place, active, |_, s, t| map.levels()[0].corners(s, t, map.wrap()))
}

/// Places in texels, from the center of the first.
#[inline(always)]
pub(super) fn place<S: Simd, T: Values<S>>([s, t]: Vec2x8<S>) -> Vec2x8<S> {
    let far = MipMap::<T::Texel>::FAR;
    [(s - 0.5).max(-far).min(far), (t - 0.5).max(-far).min(far)]
}

/// Linear between the centers of the texels around places, in texels.
#[inline(always)]
fn between_texels<S: Simd, T: Values<S>>(
    st: Vec2x8<S>,
    active: mask64x8<S>,
    corners_at: impl Fn(usize, i64, i64) -> [T::Texel; 4],
) -> T::Texels {
    let place = place::<S, T>(st);
    let (s, t) = (place[0].floor(), place[1].floor());
    let mut corners = [[T::Texel::default(); LANES]; 4];
    for lane in set_lanes(active) {
        let own = corners_at(lane, s[lane] as i64, t[lane] as i64);
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
