//! The color of marble (PBR 10.6.7).

use std::f64::consts::TAU;

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::Marble;

use super::TexturePoint;
use super::noise::{PointInSpace, Sum};
use crate::circle::at_turn;
use crate::number::{Colors, splat_f32, to_f32, vectorized};

const LIGHT: Vec3 = Vec3::new(0.58, 0.58, 0.6);

/// Points that guide the curves of color. pbrt-v3 has nine, and comes to the first five.
const COLORS: [Vec3; 5] = [LIGHT, LIGHT, LIGHT, Vec3::splat(0.5), Vec3::new(0.6, 0.59, 0.58)];

/// The number of curves that pbrt-v3 divides the way of color into.
const CURVES: f32 = 6.0;

/// A factor of pbrt-v3's, for colors that differ more.
const CONTRAST: f32 = 1.5;

#[inline(never)]
pub(super) fn marble<S: Simd>(at: &TexturePoint<S>, marble: &Marble, active: mask64x8<S>) -> Colors<S> {
    vectorized!(active.token(), {
        let octaves = &marble.octaves;
        let at = PointInSpace::new(at, &octaves.texture_from_world).scaled(marble.scale);
        let noise = at.sum(Sum::Fbm, (octaves.count, octaves.roughness), active);
        let layer = (at.p.y + marble.variation * noise) * (1.0 / TAU);
        let [_, sine] = at_turn(layer - layer.floor());
        color(to_f32(0.5 + 0.5 * sine))
    })
}

/// The color at a place from 0 to 1 along the way. As in pbrt-v3, the second curve goes on where others would follow.
#[inline(always)]
fn color<S: Simd>(place: f32x8<S>) -> Colors<S> {
    let (simd, along) = (place.token(), place * CURVES);
    let is_first = along.simd_lt(1.0);
    let t = is_first.select(along, along - 1.0);
    let mut points = [Colors::splat(simd, Vec3::ZERO); 4];
    for (i, point) in points.iter_mut().enumerate() {
        let [first, second] = [Colors::splat(simd, COLORS[i]), Colors::splat(simd, COLORS[i + 1])];
        *point = first.or(is_first, second);
    }
    for level in (1..4).rev() {
        for i in 0..level {
            points[i] = points[i] * (1.0 - t) + points[i + 1] * t;
        }
    }
    points[0] * splat_f32(simd, CONTRAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;

    fn color_at(place: f32) -> Vec3 {
        baseline!(simd => color(splat_f32(simd, place)).lane(0))
    }

    #[test]
    fn the_curves_pass_through_the_colors_of_pbrt() {
        assert!((color_at(0.0) - 1.5 * LIGHT).length() < 1e-6);
        // Where the first curve ends, at its last point; and where the second begins, at its first.
        assert!((color_at(1.0 / 6.0 - 1e-6) - Vec3::splat(0.75)).length() < 1e-4);
        assert!((color_at(1.0 / 6.0 + 1e-6) - 1.5 * LIGHT).length() < 1e-4);
        // pbrt-v3 in closed form at the end of the second curve, which goes on to t = 5.
        let bernstein = [-64.0, 240.0, -300.0, 125.0];
        let end: Vec3 = COLORS[1..].iter().zip(bernstein).map(|(color, weight)| *color * weight).sum();
        assert!((color_at(1.0) - 1.5 * end).length() < 1e-3, "{}", color_at(1.0));
    }
}
