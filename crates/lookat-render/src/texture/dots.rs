//! The value of a texture of dots (PBR 10.5).

use glam::{DVec2, DVec3};
use lookat_image::floor;
use lookat_scene::{Dots, Value};

use super::noise::noise;
use super::{TexturePoint, mapping};

const RADIUS: f64 = 0.35;

/// How far the middle of a dot may be from that of its cell.
const MOST_SHIFT: f64 = 0.5 - RADIUS;

pub(super) fn dots<T: Value>(at: &TexturePoint, dots: &Dots<T>) -> T {
    let in_dot = in_dot(mapping::coordinates(&dots.mapping, at));
    at.value(if in_dot { &dots.dots } else { &dots.around })
}

/// Whether there is a dot in the cell of `st`, and `st` is in it. The places for noise are those of pbrt-v3.
fn in_dot(st: DVec2) -> bool {
    let cell = DVec2::new(floor(st.x + 0.5) as f64, floor(st.y + 0.5) as f64);
    let random = |s: f64, t: f64| noise(DVec3::new(cell.x + s, cell.y + t, 0.5));
    if random(0.5, 0.5) <= 0.0 {
        return false;
    }
    let middle = cell + MOST_SHIFT * DVec2::new(random(1.5, 2.8), random(4.5, 9.8));
    st.distance_squared(middle) < RADIUS * RADIUS
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn two_of_five_cells_have_a_dot_and_dots_stay_in_their_cell() {
        let n = 900;
        let step = 45.0 / f64::from(n);
        let places = (0..n).flat_map(|i| (0..n).map(move |j| DVec2::new(f64::from(i), f64::from(j)) * step));
        let share = places.filter(|st| in_dot(*st)).count() as f64 / f64::from(n * n);
        let full = PI * RADIUS * RADIUS;
        // Fewer than half: noise is often 0 in the middle of a cell.
        assert!((0.36..0.42).contains(&(share / full)), "{share}");
        assert!((0..1000).all(|i| !in_dot(DVec2::new(f64::from(i) * 0.1, 0.5))));
    }
}
