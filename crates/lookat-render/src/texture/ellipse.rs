//! Elliptically weighted averages of pictures, eight side by side (PBR 10.4.5; Heckbert, "Fundamentals of Texture Mapping and Image
//! Warping", 1989).

use fearless_simd::{Simd, f32x8, i32x8, mask32x8, mask64x8, prelude::*};
use lookat_image::{Level, MipMap, Wrap};

use super::Values;
use super::trilinear::{Versions, place, sizes};
use crate::number::{LANES, Vec2x8, narrow, splat_f32, to_f32, vectorized};

/// The weighted means over the ellipses around `st` with the axes `ends`. If an axis is more than `max_anisotropy` times as long
/// as the other, the other is made longer: more blur for less work. Also returns a mask of those without an ellipse.
#[inline(always)]
pub(super) fn means<S: Simd, T: Values<S>>(
    map: &MipMap<T::Texel>,
    st: Vec2x8<S>,
    ends: [Vec2x8<S>; 2],
    max_anisotropy: f64,
    active: mask64x8<S>,
) -> (T::Texels, mask32x8<S>) {
    let simd = active.token();
    let zero = splat_f32(simd, 0.0);
    let ends = ends.map(
        #[inline(always)]
        |[s, t]| [to_f32(s), to_f32(t)],
    );
    let squared = ends.map(
        #[inline(always)]
        |[s, t]| s * s + t * t,
    );
    let is_first = squared[0].simd_ge(squared[1]);
    let either = |a: f32x8<S>, b: f32x8<S>| [is_first.select(a, b), is_first.select(b, a)];
    let ([major_s, minor_s], [major_t, minor_t]) =
        (either(ends[0][0], ends[1][0]), either(ends[0][1], ends[1][1]));
    let [long, short] = either(squared[0].sqrt(), squared[1].sqrt());
    let least = long / max_anisotropy as f32;
    let is_thin = short.simd_gt(0.0) & short.simd_lt(least);
    let scale = is_thin.select(least / short, splat_f32(simd, 1.0));
    let short = is_thin.select(least, short);
    let is_point = short.simd_eq(0.0) & long.is_finite();
    let side = map.width().max(map.height()) as f32;
    let width = long.is_finite().select(short, splat_f32(simd, f32::INFINITY)) * side;
    let versions = Versions::new(width.max(1.0).min(2.0 * side));
    // Where there is no ellipse, the axes may be infinite.
    let has_ellipse = narrow(active) & !is_point & width.simd_lt(2.0 * side);
    let or_none = |x: f32x8<S>| has_ellipse.select(x, zero);
    let axes = [[or_none(major_s), or_none(major_t)], [or_none(minor_s * scale), or_none(minor_t * scale)]];
    let mean = versions.mean::<T>(
        #[inline(always)]
        |versions| mean::<S, T>(map, versions, st, axes),
    );
    (mean, is_point)
}

/// The means over ellipses of one version each.
#[inline(never)]
fn mean<S: Simd, T: Values<S>>(
    map: &MipMap<T::Texel>,
    versions: &[usize; LANES],
    st: Vec2x8<S>,
    [x, y]: [[f32x8<S>; 2]; 2],
) -> T::Texels {
    let simd = x[0].token();
    vectorized!(simd, {
        let last = map.levels().len() - 1;
        let levels: [&Level<T::Texel>; LANES] = versions.map(|version| &map.levels()[version.min(last)]);
        let [width, height] = sizes(simd, &levels);
        let (x, y) =
            ([x[0] * to_f32(width), x[1] * to_f32(height)], [y[0] * to_f32(width), y[1] * to_f32(height)]);
        // The parallelogram around the ellipse, with two sides along rows. It is wider than the axes by about a texel, so that there
        // are always texels inside.
        let squared_height = x[1] * x[1] + y[1] * y[1] + 1.0;
        let across = x[0] * y[1] - x[1] * y[0];
        let squared_area = across * across + (x[0] * x[0] + y[0] * y[0]) + squared_height;
        let shear = (x[0] * x[1] + y[0] * y[1]) / squared_height;
        let (half_height, half_width) = (squared_height.sqrt(), (squared_area / squared_height).sqrt());
        let (down, across) = (1.0 / half_height, 1.0 / half_width);

        // From the texel at or before the center.
        let [s, t] = place::<S, T>([st[0] * width, st[1] * height]);
        let (s_floor, t_floor) = (s.floor(), t.floor());
        let (s, t) = (to_f32(s - s_floor), to_f32(t - t_floor));
        let wrap = map.wrap();
        let start = |floor: f64, side: usize| match wrap {
            Wrap::Repeat => (floor as i64 & (side as i64 - 1)) as i32,
            _ => floor.clamp(-FAR, side as f64 + FAR) as i32,
        };
        let start_s: i32x8<S> = i32x8::from_fn(simd, |lane| start(s_floor[lane], levels[lane].width()));
        let start_t: [i32; LANES] = std::array::from_fn(|lane| start(t_floor[lane], levels[lane].height()));
        let end_s: i32x8<S> = i32x8::from_fn(simd, |lane| (levels[lane].width() - 1) as i32);
        let (zero, is_repeated) = (i32x8::splat(simd, 0), wrap == Wrap::Repeat);
        // The mean of all has no edges.
        let has_edges: [bool; LANES] = versions.map(|version| wrap == Wrap::Black && version <= last);

        // The rows and columns of each ellipse, so that a lookup does not depend on those beside it.
        let rows = [(t - half_height).ceil(), (t + half_height).floor()];
        let columns = (half_width * 2.0).floor() + 1.0;
        let (mut sum, mut total) = (T::texels(simd, &[T::Texel::default(); LANES]), splat_f32(simd, 0.0));
        for row in rows[0].reduce_min() as i32..=rows[1].reduce_max() as i32 {
            let dt = row as f32 - t;
            let middle = s + shear * dt;
            let first = (middle - half_width).ceil();
            let (mut ds, mut at) = (first - middle, i32x8::truncate_from(first) + start_s);
            let row_start: [usize; LANES] = std::array::from_fn(|lane| {
                let (t, end) = (start_t[lane].wrapping_add(row), (levels[lane].height() - 1) as i32);
                let wrapped = if is_repeated { t & end } else { t.clamp(0, end) };
                // A row that no picture has.
                if has_edges[lane] && wrapped != t {
                    usize::MAX / 2
                } else {
                    wrapped as usize * levels[lane].width()
                }
            });
            let y_squared = (dt * down) * (dt * down);
            let is_own = rows[0].simd_le(row as f32) & rows[1].simd_ge(row as f32);
            let columns = is_own.select(columns, splat_f32(simd, 0.0));
            for column in 0..columns.reduce_max() as i32 {
                let x = ds * across;
                let is_own = columns.simd_gt(column as f32);
                let weight = is_own.select(weight(x * x + y_squared), splat_f32(simd, 0.0));
                let wrapped = if is_repeated { at & end_s } else { at.max(zero).min(end_s) };
                let texels = std::array::from_fn(|lane| {
                    if has_edges[lane] && wrapped[lane] != at[lane] {
                        T::Texel::default()
                    } else {
                        levels[lane].texel(row_start[lane].wrapping_add(wrapped[lane] as usize))
                    }
                });
                sum = sum + T::texels(simd, &texels) * weight;
                total += weight;
                ds += 1.0;
                at += 1;
            }
        }
        sum * (1.0 / total)
    })
}

/// So far beyond the edges no ellipse reaches.
const FAR: f64 = 1e5;

/// exp(-2 r²) - exp(-2) to 3e-7, and 0 from a radius of 1: a Gaussian that comes to 0 at the edge.
#[inline(always)]
pub(super) fn weight<S: Simd>(squared_radius: f32x8<S>) -> f32x8<S> {
    let x = squared_radius.min(1.0);
    // exp(-x / 2) from 0 to 1.
    let root = ((((x * -0.000_203_341_45 + 0.002_542_826_8) * x - 0.020_802_25) * x + 0.124_992_82) * x
        - 0.499_999_4)
        * x
        + 1.0;
    let squared = root * root;
    // What comes of 1.
    (squared * squared - 0.135_335_3).max(0.0)
}
