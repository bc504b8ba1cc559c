//! The value of a texture of dots (PBR 10.5).

use fearless_simd::{Simd, mask64x8, prelude::*};
use lookat_scene::Dots;

use super::noise::noise;
use super::{TexturePoint, Values, mapping};
use crate::number::{V3, Vec2x8, vectorized};

const RADIUS: f64 = 0.35;

/// How far the middle of a dot may be from that of its cell.
const MOST_SHIFT: f64 = 0.5 - RADIUS;

#[inline(always)]
pub(super) fn dots<S: Simd, T: Values<S>>(
    at: &TexturePoint<S>,
    dots: &Dots<T>,
    active: mask64x8<S>,
) -> T::Wide {
    let in_dot = in_dot(mapping::coordinates(&dots.mapping, at, active), active);
    at.either(in_dot, [&dots.dots, &dots.around], active)
}

/// Whether there is a dot in the cell of `st`, and `st` is in it. The places for noise are those of pbrt-v3.
#[inline(never)]
fn in_dot<S: Simd>([s, t]: Vec2x8<S>, active: mask64x8<S>) -> mask64x8<S> {
    let simd = active.token();
    vectorized!(simd, {
        let cell = [(s + 0.5).floor(), (t + 0.5).floor()];
        let random = |s: f64, t: f64, active| {
            noise(V3 { x: cell[0] + s, y: cell[1] + t, z: 0.5.simd_into(simd) }, active)
        };
        let has_dot = random(0.5, 0.5, active).simd_gt(0.0) & active;
        if !has_dot.any_true() {
            return has_dot;
        }
        let (x, y) = (random(1.5, 2.8, has_dot), random(4.5, 9.8, has_dot));
        let (x, y) = (s - (cell[0] + MOST_SHIFT * x), t - (cell[1] + MOST_SHIFT * y));
        has_dot & (x * x + y * y).simd_lt(RADIUS * RADIUS)
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use fearless_simd::f64x8;
    use glam::DVec2;

    use super::*;
    use crate::number::bits;
    use crate::testing::baseline;

    fn is_in_dot(st: DVec2) -> bool {
        baseline!(simd => {
            in_dot(st.to_array().map(|x| f64x8::splat(simd, x)), bits(simd, 1)).to_bitmask() & 1 == 1
        })
    }

    #[test]
    fn two_of_five_cells_have_a_dot_and_dots_stay_in_their_cell() {
        let n = 900;
        let step = 45.0 / f64::from(n);
        let places = (0..n).flat_map(|i| (0..n).map(move |j| DVec2::new(f64::from(i), f64::from(j)) * step));
        let share = places.filter(|st| is_in_dot(*st)).count() as f64 / f64::from(n * n);
        let full = PI * RADIUS * RADIUS;
        // Fewer than half: noise is often 0 in the middle of a cell.
        assert!((0.36..0.42).contains(&(share / full)), "{share}");
        assert!((0..1000).all(|i| !is_in_dot(DVec2::new(f64::from(i) * 0.1, 0.5))));
    }
}
