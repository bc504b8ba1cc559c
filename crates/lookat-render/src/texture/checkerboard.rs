//! Checkerboards and dots (PBR 10.5).

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use lookat_scene::{Cells, Checkerboard, Dots};

use super::noise::noise;
use super::{TexturePoint, Values, changes, coordinates};
use crate::number::{V3, Vec2x8, vectorized};

#[inline(always)]
pub(super) fn checkerboard<S: Simd, T: Values<S>>(
    at: &TexturePoint<S>,
    board: &Checkerboard<T>,
    active: mask64x8<S>,
) -> T::Wide {
    let [even, odd] = &board.textures;
    let share = share_of_odd(at, &board.cells, active);
    let (is_even, is_odd) = (share.simd_eq(0.0), share.simd_eq(1.0));
    let (even, odd) = (at.value(even, active & !is_odd), at.value(odd, active & !is_even));
    T::keep_where(even, is_even, T::keep_where(odd, is_odd, T::blend(even, odd, share)))
}

/// The share of cells whose numbers have an odd sum.
#[inline(never)]
fn share_of_odd<S: Simd>(at: &TexturePoint<S>, cells: &Cells, active: mask64x8<S>) -> f64x8<S> {
    vectorized!(active.token(), {
        match cells {
            Cells::Plane { mapping, filtered } => {
                let st = coordinates(mapping, at, active);
                match at.footprint {
                    Some(footprint) if *filtered => {
                        // How far s and t change up to the neighbors, at most.
                        let [x, y] = changes(mapping, at, footprint, active);
                        filtered_share(st, [x[0].abs().max(y[0].abs()), x[1].abs().max(y[1].abs())])
                    }
                    _ => parity(&st),
                }
            }
            Cells::Space { texture_from_world } => {
                let p = at.within(texture_from_world);
                parity(&[p.x, p.y, p.z])
            }
        }
    })
}

/// 1 where the sum of the numbers of the cells is odd, else 0.
#[inline(always)]
fn parity<S: Simd>(p: &[f64x8<S>]) -> f64x8<S> {
    let mut odd = f64x8::splat(p[0].token(), 0.0);
    for x in p {
        // That of each number is 0 or 1; far away, where no integers are near, 0.
        let cell = x.floor();
        let own = cell - (cell * 0.5).floor() * 2.0;
        odd = own.simd_eq(1.0).select(1.0 - odd, odd);
    }
    odd
}

/// The share within a box around `st`.
#[inline(always)]
fn filtered_share<S: Simd>(st: Vec2x8<S>, reach: Vec2x8<S>) -> f64x8<S> {
    let (s, t) = (share(st[0], reach[0]), share(st[1], reach[1]));
    let half = f64x8::splat(s.token(), 0.5);
    reach[0].max(reach[1]).simd_gt(1.0).select(half, s + t - 2.0 * s * t)
}

/// The share of odd cells in `x - reach..x + reach`: 0 or 1 where that is within one.
#[inline(always)]
fn share<S: Simd>(x: f64x8<S>, reach: f64x8<S>) -> f64x8<S> {
    let (low, high) = (x - reach, x + reach);
    // Counted from the first cell, so that no digits cancel.
    let first = (low * 0.5).floor();
    let odd = odd_length(high * 0.5 - first) - odd_length(low * 0.5 - first);
    let share = (odd / (2.0 * reach)).max(0.0).min(1.0);
    low.floor().simd_eq(high.floor()).select(parity(&[x]), share)
}

/// The length of the odd cells among the first pairs of cells.
#[inline(always)]
fn odd_length<S: Simd>(pairs: f64x8<S>) -> f64x8<S> {
    let whole = pairs.floor();
    whole + 2.0 * (pairs - whole - 0.5).max(0.0)
}

const RADIUS: f64 = 0.35;

/// The largest distance of the middle of a dot from that of its cell.
const MOST_SHIFT: f64 = 0.5 - RADIUS;

#[inline(always)]
pub(super) fn dots<S: Simd, T: Values<S>>(
    at: &TexturePoint<S>,
    dots: &Dots<T>,
    active: mask64x8<S>,
) -> T::Wide {
    let in_dot = in_dot(coordinates(&dots.mapping, at, active), active);
    at.either(in_dot, [&dots.dots, &dots.around], active)
}

/// True if there is a dot in the cell of `st`, and `st` is in it. The places for noise are those of pbrt-v3.
#[inline(never)]
fn in_dot<S: Simd>([s, t]: Vec2x8<S>, active: mask64x8<S>) -> mask64x8<S> {
    let simd = active.token();
    vectorized!(simd, {
        let cell = [(s + 0.5).floor(), (t + 0.5).floor()];
        let random = |s: f64, t: f64| noise(V3 { x: cell[0] + s, y: cell[1] + t, z: 0.5.simd_into(simd) });
        let has_dot = random(0.5, 0.5).simd_gt(0.0) & active;
        if !has_dot.any_true() {
            return has_dot;
        }
        let (x, y) = (random(1.5, 2.8), random(4.5, 9.8));
        let (x, y) = (s - (cell[0] + MOST_SHIFT * x), t - (cell[1] + MOST_SHIFT * y));
        has_dot & (x * x + y * y).simd_lt(RADIUS * RADIUS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::bits;
    use crate::testing::baseline;
    use fearless_simd::f64x8;
    use glam::DVec2;
    use std::f64::consts::PI;

    fn parity_at(p: &[f64]) -> f64 {
        baseline!(simd => {
            let p: Vec<_> = p.iter().map(|x| f64x8::splat(simd, *x)).collect();
            parity(&p)[0]
        })
    }

    fn share_at(st: DVec2, reach: DVec2) -> f64 {
        baseline!(simd => {
            let of = |v: DVec2| v.to_array().map(|x| f64x8::splat(simd, x));
            filtered_share(of(st), of(reach))[0]
        })
    }

    /// The share by counting.
    fn counted(st: DVec2, reach: DVec2) -> f64 {
        let n = 400;
        let step = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let places = (0..n).flat_map(|i| (0..n).map(move |j| st + reach * DVec2::new(step(i), step(j))));
        places.map(|st| parity_at(&st.to_array())).sum::<f64>() / f64::from(n * n)
    }

    #[test]
    fn the_filtered_share_is_that_of_the_box() {
        let cases = [
            ([0.2, 0.3], [0.1, 0.1]),
            ([0.95, 0.3], [0.1, 0.1]),
            ([-0.05, 3.02], [0.5, 0.25]),
            ([-7.3, -2.98], [0.9, 1.0]),
            ([5.0, 1.5], [0.0, 0.7]),
            ([1.25, 2.0], [0.3, 0.0]),
        ];
        for (st, reach) in cases {
            let (st, reach) = (DVec2::from(st), DVec2::from(reach));
            let share = share_at(st, reach);
            assert!((share - counted(st, reach)).abs() < 0.01, "{st} {reach}: {share}");
        }
        assert_eq!(share_at(DVec2::new(0.5, 0.5), DVec2::new(1.01, 0.0)), 0.5);
    }

    #[test]
    fn far_cells_have_a_parity_too() {
        for x in [3e9, -3e9, 1e18, -1e50, 1e300] {
            let share = share_at(DVec2::new(x, 0.5), DVec2::splat(0.1));
            assert!((0.0..=1.0).contains(&share), "{x}: {share}");
        }
        assert_eq!(parity_at(&[3e9 + 1.5, 0.5]), 1.0);
        assert_eq!(parity_at(&[-0.5, 0.5, -2.5]), 0.0);
    }

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
