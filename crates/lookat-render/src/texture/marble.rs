//! The color of marble (PBR 10.6.7).

use glam::Vec3;
use lookat_scene::Marble;

use super::TexturePoint;
use super::noise::{PointInSpace, fbm};

const LIGHT: Vec3 = Vec3::new(0.58, 0.58, 0.6);

/// Points that guide the curves of color. pbrt-v3 has nine, and comes to the first five.
const COLORS: [Vec3; 5] = [LIGHT, LIGHT, LIGHT, Vec3::splat(0.5), Vec3::new(0.6, 0.59, 0.58)];

/// The number of curves that pbrt-v3 divides the way of color into.
const CURVES: f32 = 6.0;

/// A factor of pbrt-v3's, for colors that differ more.
const CONTRAST: f32 = 1.5;

pub(super) fn marble(at: &TexturePoint, marble: &Marble) -> Vec3 {
    let octaves = &marble.octaves;
    let at = PointInSpace::new(at, &octaves.texture_from_world).scaled(marble.scale);
    let layer = at.p.y + marble.variation * fbm(&at, octaves.count, octaves.roughness);
    color((0.5 + 0.5 * layer.sin()) as f32)
}

/// The color at a place from 0 to 1 along the way. As in pbrt-v3, the second curve goes on where others would follow.
fn color(place: f32) -> Vec3 {
    let first = if place * CURVES < 1.0 { 0 } else { 1 };
    let t = place * CURVES - first as f32;
    let mut points = [COLORS[first], COLORS[first + 1], COLORS[first + 2], COLORS[first + 3]];
    for level in (1..4).rev() {
        for i in 0..level {
            points[i] = (1.0 - t) * points[i] + t * points[i + 1];
        }
    }
    CONTRAST * points[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curves_pass_through_the_colors_of_pbrt() {
        assert!((color(0.0) - 1.5 * LIGHT).length() < 1e-6);
        // Where the first curve ends, at its last point; and where the second begins, at its first.
        assert!((color(1.0 / 6.0 - 1e-6) - Vec3::splat(0.75)).length() < 1e-4);
        assert!((color(1.0 / 6.0 + 1e-6) - 1.5 * LIGHT).length() < 1e-4);
        // pbrt-v3 in closed form at the end of the second curve, which goes on to t = 5.
        let bernstein = [-64.0, 240.0, -300.0, 125.0];
        let end: Vec3 = COLORS[1..].iter().zip(bernstein).map(|(color, weight)| *color * weight).sum();
        assert!((color(1.0) - 1.5 * end).length() < 1e-3, "{}", color(1.0));
    }
}
