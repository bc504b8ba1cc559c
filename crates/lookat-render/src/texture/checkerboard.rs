//! The value of a checkerboard (PBR 10.5).

use glam::DVec2;
use lookat_image::floor;
use lookat_scene::{Cells, Checkerboard, Mapping, Value};

use super::{TexturePoint, mapping};

pub(super) fn checkerboard<T: Value>(at: &TexturePoint, board: &Checkerboard<T>) -> T {
    let [even, odd] = &board.textures;
    match share_of_odd(at, &board.cells) {
        0.0 => at.value(even),
        1.0 => at.value(odd),
        share => T::mix(at.value(even), at.value(odd), share),
    }
}

/// The share of cells whose numbers have an odd sum.
fn share_of_odd(at: &TexturePoint, cells: &Cells) -> f64 {
    match cells {
        Cells::Plane { mapping, filtered } => {
            let st = mapping::coordinates(mapping, at);
            if *filtered { filtered_share(st, reach(mapping, at)) } else { parity(&st.to_array()) }
        }
        Cells::Space { texture_from_world } => parity(&at.within(texture_from_world).to_array()),
    }
}

/// 1 where the sum of the numbers of the cells is odd, else 0.
fn parity(p: &[f64]) -> f64 {
    p.iter().fold(0.0, |odd, x| if is_odd(*x) { 1.0 - odd } else { odd })
}

fn is_odd(x: f64) -> bool {
    floor(x) & 1 == 1
}

/// How far s and t change up to the neighbors, at most.
fn reach(mapping: &Mapping, at: &TexturePoint) -> DVec2 {
    let [x, y] = mapping::changes(mapping, at);
    x.abs().max(y.abs())
}

/// The share within a box around `st`.
fn filtered_share(st: DVec2, reach: DVec2) -> f64 {
    if reach.max_element() > 1.0 {
        return 0.5;
    }
    let (s, t) = (share(st.x, reach.x), share(st.y, reach.y));
    s + t - 2.0 * s * t
}

fn within_cell(x: f64, reach: f64) -> bool {
    floor(x - reach) == floor(x + reach)
}

/// The share of odd cells in `x - reach..x + reach`: 0 or 1 where that is within one.
fn share(x: f64, reach: f64) -> f64 {
    if within_cell(x, reach) {
        return parity(&[x]);
    }
    // The length of odd cells up to x, halved; counted from the first cell, so that no digits cancel.
    let first = floor((x - reach) * 0.5) as f64;
    let up_to = |x: f64| {
        let pairs = x * 0.5 - first;
        let whole = floor(pairs) as f64;
        whole + 2.0 * (pairs - whole - 0.5).max(0.0)
    };
    ((up_to(x + reach) - up_to(x - reach)) / (2.0 * reach)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share by counting.
    fn counted(st: DVec2, reach: DVec2) -> f64 {
        let n = 400;
        let step = |i: i32| (f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0;
        let places = (0..n).flat_map(|i| (0..n).map(move |j| st + reach * DVec2::new(step(i), step(j))));
        places.map(|st| parity(&st.to_array())).sum::<f64>() / f64::from(n * n)
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
            let share = filtered_share(st, reach);
            assert!((share - counted(st, reach)).abs() < 0.01, "{st} {reach}: {share}");
        }
        assert_eq!(filtered_share(DVec2::new(0.5, 0.5), DVec2::new(1.01, 0.0)), 0.5);
    }

    #[test]
    fn far_cells_have_a_parity_too() {
        for x in [3e9, -3e9, 1e18, -1e50, 1e300] {
            let share = filtered_share(DVec2::new(x, 0.5), DVec2::splat(0.1));
            assert!((0.0..=1.0).contains(&share), "{x}: {share}");
        }
        assert_eq!(parity(&[3e9 + 1.5, 0.5]), 1.0);
        assert_eq!(parity(&[-0.5, 0.5, -2.5]), 0.0);
    }
}
