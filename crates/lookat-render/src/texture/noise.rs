//! Perlin noise, its sums, and marble (PBR 10.6).

use std::array::from_fn;
use std::f64::consts::TAU;

use fearless_simd::{Simd, f32x8, f64x8, i32x8, mask64x8, prelude::*, u32x8};
use glam::Vec3;
use lookat_scene::{Marble, Octaves, Transform};

use super::{TexturePoint, within};
use crate::number::{
    LANES, V3, Vec3fx8, Vec3x8, log2, set_lanes, splat_f32, to_f32, to_f64, vectorized, widen,
};
use crate::warp::at_turn;

/// The permutation of Perlin's "Improving Noise" (2002), which pbrt-v3 has too: its pictures are the same.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99,
    37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27,
    166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244,
    102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130,
    116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147,
    118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119,
    248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110,
    79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179,
    162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204, 176,
    115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78,
    66, 215, 61, 156, 180,
];

/// The number at each index of the permutation and the one after it: 8 bits each.
static PAIRS: [u16; 256] = {
    let (mut pairs, mut index) = ([0; 256], 0);
    while index < 256 {
        pairs[index] = u16::from_le_bytes([PERMUTATION[index], PERMUTATION[(index + 1) % 256]]);
        index += 1;
    }
    pairs
};

/// Perlin's gradient noise with pbrt-v3's gradients: smooth, about -1..1, 0 at whole coordinates.
#[inline(never)]
pub(super) fn noise<S: Simd>(p: Vec3x8<S>) -> f64x8<S> {
    let simd = p.x.token();
    vectorized!(simd, {
        let (x, y, z) = (in_cell(p.x), in_cell(p.y), in_cell(p.z));
        let hashes: u32x8<S> = hashes([x.0, y.0, z.0]).simd_into(simd);
        let (tx, ty, tz) = (fade(x.1), fade(y.1), fade(z.1));
        let mut corners = [f64x8::splat(simd, 0.0); 8];
        for (corner, value) in corners.iter_mut().enumerate() {
            let [dx, dy, dz] = [x.1, y.1, z.1];
            let dx = if corner & 1 == 0 { dx } else { dx - 1.0 };
            let dy = if corner & 2 == 0 { dy } else { dy - 1.0 };
            let dz = if corner & 4 == 0 { dz } else { dz - 1.0 };
            *value = gradient(hashes >> (4 * corner as u32) & 15, V3 { x: dx, y: dy, z: dz });
        }
        let [a, b, c, d, e, f, g, h] = corners;
        let low = lerp(lerp(a, b, tx), lerp(c, d, tx), ty);
        let high = lerp(lerp(e, f, tx), lerp(g, h, tx), ty);
        lerp(low, high, tz)
    })
}

/// The numbers of cells along an axis, which repeat after 256, and the places in them.
#[inline(always)]
fn in_cell<S: Simd>(x: f64x8<S>) -> ([i32; LANES], f64x8<S>) {
    let cell = x.floor();
    let number = i32x8::truncate_from(to_f32(cell - (cell * (1.0 / 256.0)).floor() * 256.0));
    // Far beyond all digits, where no integer is near, any place in the cell will do.
    let (d, zero) = (x - cell, f64x8::splat(x.token(), 0.0));
    (number.into(), d.simd_gt(0.0).select(d, zero).min(1.0))
}

#[inline(always)]
fn fade<S: Simd>(d: f64x8<S>) -> f64x8<S> {
    d * d * d * (d * (d * 6.0 - 15.0) + 10.0)
}

/// Hashes that choose the gradients at the eight corners of cells, four bits for each corner.
#[inline(always)]
fn hashes([x, y, z]: [[i32; LANES]; 3]) -> [u32; LANES] {
    let both = |first: u8, index: i32| PAIRS[usize::from(first.wrapping_add(index as u8))];
    from_fn(
        #[inline(always)]
        |lane| {
            let mut hash = 0;
            for (i, x) in both(0, x[lane]).to_le_bytes().into_iter().enumerate() {
                for (j, y) in both(x, y[lane]).to_le_bytes().into_iter().enumerate() {
                    let [near, far] = both(y, z[lane]).to_le_bytes().map(|z| u32::from(z & 15));
                    hash |= (near | far << 16) << (4 * (i + 2 * j));
                }
            }
            hash
        },
    )
}

/// The product of gradients and vectors `d`. Gradients are directions to the edges of a cube, four of them twice.
#[inline(always)]
fn gradient<S: Simd>(hash: u32x8<S>, d: Vec3x8<S>) -> f64x8<S> {
    let is_twice = hash.simd_eq(12) | hash.simd_eq(13);
    let u = widen(hash.simd_lt(8) | is_twice).select(d.x, d.y);
    let v = widen(hash.simd_lt(4) | is_twice).select(d.y, d.z);
    let is_set = |bit: u32| widen((hash & bit).simd_eq(bit));
    is_set(1).select(-u, u) + is_set(2).select(-v, v)
}

#[inline(always)]
fn lerp<S: Simd>(a: f64x8<S>, b: f64x8<S>, t: f64x8<S>) -> f64x8<S> {
    (1.0 - t) * a + t * b
}

/// Points in the space of a texture.
#[derive(Clone, Copy)]
pub(super) struct PointInSpace<S: Simd> {
    pub p: Vec3x8<S>,
    /// The distances to their neighbors.
    pub spread: Option<f64x8<S>>,
}

impl<S: Simd> PointInSpace<S> {
    #[inline(never)]
    pub fn new(at: &TexturePoint<S>, texture_from_world: &Transform) -> Self {
        vectorized!(at.p.x.token(), {
            let spread = at.footprint.map(
                #[inline(always)]
                |footprint| {
                    let [x, y] = footprint.dp;
                    let (x, y) = (within(texture_from_world, x), within(texture_from_world, y));
                    x.length_squared().max(y.length_squared()).sqrt()
                },
            );
            PointInSpace { p: at.within(texture_from_world), spread }
        })
    }

    #[inline(always)]
    pub fn scaled(self, scale: f64) -> Self {
        let spread = self.spread.map(
            #[inline(always)]
            |spread| spread * scale.abs(),
        );
        PointInSpace { p: self.p * f64x8::splat(self.p.x.token(), scale), spread }
    }

    /// The number of octaves that are not finer than the distance of neighbors, with the share of the last.
    #[inline(always)]
    fn octaves(&self, most: u32) -> [f64x8<S>; 2] {
        // All where there are no neighbors; none where the distance is no number.
        let mut octaves = f64x8::splat(self.p.x.token(), f64::from(most));
        if let Some(spread) = self.spread {
            let (whole, rest) = log2(to_f32(spread));
            let whole: f64x8<S> = whole.map(f64::from).simd_into(octaves.token());
            let log2 = whole + to_f64(rest);
            octaves = (-1.0 - log2).max(0.0).min(octaves);
        }
        let whole = octaves.floor();
        [whole, smooth_step(0.3, 0.7, octaves - whole)]
    }

    /// The sum of octaves, of which there are so many at most, each so high by the one before.
    #[inline(never)]
    pub fn sum(&self, sum: OctaveSum, (most, roughness): (u32, f64), active: mask64x8<S>) -> f64x8<S> {
        vectorized!(active.token(), {
            let all = |x: f64| f64x8::splat(active.token(), x);
            let [whole, last] = self.octaves(most);
            let (mut heights, mut frequency, mut height) = (all(0.0), 1.0, 1.0);
            for i in 0..most {
                let i = f64::from(i);
                let share = whole.simd_gt(i).select(all(1.0), whole.simd_eq(i).select(last, all(0.0)));
                let open = active & share.simd_gt(0.0);
                let noise = if open.any_true() { noise(self.p * all(frequency)) } else { all(0.0) };
                heights += height
                    * match sum {
                        OctaveSum::Fbm => noise * share,
                        OctaveSum::Turbulence => lerp(all(MEAN), noise.abs(), share),
                    };
                frequency *= LACUNARITY;
                height *= roughness;
            }
            if let OctaveSum::Turbulence = sum {
                // As pbrt-v3 has it, with the last octave counted once more.
                for lane in set_lanes(active) {
                    heights[lane] += MEAN * roughness.powi(whole[lane] as i32);
                }
            }
            // The limit of colors: a large roughness gives more.
            heights.max(-1e18).min(1e18)
        })
    }

    /// Waves, high where the wind is strong.
    #[inline(always)]
    pub fn windy(&self, active: mask64x8<S>) -> f64x8<S> {
        let strength = self.scaled(0.1).sum(OctaveSum::Fbm, (3, 0.5), active);
        strength.abs() * self.sum(OctaveSum::Fbm, (6, 0.5), active)
    }
}

/// The summand of a sum of octaves.
#[derive(Clone, Copy)]
pub(super) enum OctaveSum {
    /// Noise.
    Fbm,
    /// Absolute values of noise.
    Turbulence,
}

/// The factor of the frequency from one octave to the next: not quite 2, so that their zeros do not coincide.
const LACUNARITY: f64 = 1.99;

/// The mean of the absolute value of noise, about, in place of octaves that are too fine.
const MEAN: f64 = 0.2;

#[inline(always)]
pub(super) fn octaves<S: Simd>(
    at: &TexturePoint<S>,
    sum: OctaveSum,
    octaves: &Octaves,
    active: mask64x8<S>,
) -> f64x8<S> {
    let at = PointInSpace::new(at, &octaves.texture_from_world);
    at.sum(sum, (octaves.count, octaves.roughness), active)
}

/// 0 up to `low`, 1 from `high`, and a smooth way between.
#[inline(always)]
fn smooth_step<S: Simd>(low: f64, high: f64, x: f64x8<S>) -> f64x8<S> {
    let t = ((x - low) / (high - low)).max(0.0).min(1.0);
    t * t * (3.0 - 2.0 * t)
}

const LIGHT: Vec3 = Vec3::new(0.58, 0.58, 0.6);

/// Points that guide the curves of color. pbrt-v3 has nine, and comes to the first five.
const COLORS: [Vec3; 5] = [LIGHT, LIGHT, LIGHT, Vec3::splat(0.5), Vec3::new(0.6, 0.59, 0.58)];

/// The number of curves that pbrt-v3 divides the way of color into.
const CURVES: f32 = 6.0;

/// A factor of pbrt-v3's, for colors that differ more.
const CONTRAST: f32 = 1.5;

#[inline(never)]
pub(super) fn marble<S: Simd>(at: &TexturePoint<S>, marble: &Marble, active: mask64x8<S>) -> Vec3fx8<S> {
    vectorized!(active.token(), {
        let octaves = &marble.octaves;
        let at = PointInSpace::new(at, &octaves.texture_from_world).scaled(marble.scale);
        let noise = at.sum(OctaveSum::Fbm, (octaves.count, octaves.roughness), active);
        let layer = (at.p.y + marble.variation * noise) * (1.0 / TAU);
        let [_, sine] = at_turn(layer - layer.floor());
        color(to_f32(0.5 + 0.5 * sine))
    })
}

/// The color at a place from 0 to 1 along the way. As in pbrt-v3, the second curve goes on where others would follow.
#[inline(always)]
fn color<S: Simd>(place: f32x8<S>) -> Vec3fx8<S> {
    let (simd, along) = (place.token(), place * CURVES);
    let is_first = along.simd_lt(1.0);
    let t = is_first.select(along, along - 1.0);
    let mut points = [Vec3fx8::splat(simd, Vec3::ZERO); 4];
    for (i, point) in points.iter_mut().enumerate() {
        let [first, second] = [Vec3fx8::splat(simd, COLORS[i]), Vec3fx8::splat(simd, COLORS[i + 1])];
        *point = first.keep_where(is_first, second);
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
    use crate::number::bits;
    use crate::testing::baseline;
    use glam::DVec3;

    fn noise_at(p: DVec3) -> f64 {
        baseline!(simd => noise(Vec3x8::splat(simd, p))[0])
    }

    /// The sum at a point with neighbors at distance `spread`.
    fn sum_at(sum: OctaveSum, p: DVec3, spread: f64, octaves: (u32, f64)) -> f64 {
        baseline!(simd => {
            let spread = Some(f64x8::splat(simd, spread));
            PointInSpace { p: Vec3x8::splat(simd, p), spread }.sum(sum, octaves, bits(simd, 2))[1]
        })
    }

    fn gradient_at(corner: [i32; 3], d: DVec3) -> f64 {
        baseline!(simd => {
            let hashes: u32x8<_> = hashes(corner.map(|x| [x; LANES])).simd_into(simd);
            gradient(hashes & 15, Vec3x8::splat(simd, d))[0]
        })
    }

    #[test]
    fn noise_is_0_at_whole_coordinates_and_has_its_gradient_there() {
        for (x, y, z) in [(0, 0, 0), (3, -5, 7), (255, 256, -1), (-1000, 12345, 99)] {
            let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            assert_eq!(noise_at(p), 0.0);
            for offset in [DVec3::X, DVec3::Y, -DVec3::Z, DVec3::ONE] {
                let slope = noise_at(p + offset * 1e-6) / 1e-6;
                let gradient = gradient_at([x, y, z].map(|x: i32| x.rem_euclid(256)), offset);
                assert!((slope - gradient).abs() < 1e-4, "{p} {offset} {slope}");
            }
        }
    }

    /// Compares with the formula of pbrt-v3.
    #[test]
    fn hashes_are_those_of_pbrt() {
        let permuted = |index: i32| i32::from(PERMUTATION[index as usize & 255]);
        for [x, y, z] in [[0, 0, 0], [255, 3, 255], [17, 255, 200]] {
            let found = hashes([[x; LANES], [y; LANES], [z; LANES]]);
            for corner in 0..8 {
                let step = |axis: usize| corner >> axis & 1;
                let (x, y, z) = ((x + step(0)) & 255, (y + step(1)) & 255, (z + step(2)) & 255);
                assert_eq!(
                    permuted(permuted(permuted(x) + y) + z) & 15,
                    (found[5] >> (4 * corner) & 15) as i32
                );
            }
        }
    }

    /// The vectors to the edges of a cube in the order of pbrt-v3, four of them once more.
    #[test]
    fn gradients_are_those_of_pbrt() {
        let (x, y, z) = (0.3, -0.7, 0.11);
        let expected = [
            x + y,
            -x + y,
            x - y,
            -x - y,
            x + z,
            -x + z,
            x - z,
            -x - z,
            y + z,
            -y + z,
            y - z,
            -y - z,
            x + y,
            -x + y,
            y - z,
            -y - z,
        ];
        for (hash, expected) in (0..).zip(expected) {
            let d = DVec3::new(x, y, z);
            let found = baseline!(simd => gradient(u32x8::splat(simd, hash), Vec3x8::splat(simd, d))[0]);
            assert_eq!(found, expected, "{hash}");
        }
    }

    #[test]
    fn noise_is_smooth_and_bounded() {
        let along = DVec3::new(0.0123, 0.0231, -0.0077);
        let mut before = noise_at(DVec3::splat(-20.0));
        for i in 1..5000 {
            let next = noise_at(DVec3::splat(-20.0) + along * f64::from(i));
            assert!(next.abs() <= 1.0 && (next - before).abs() < 0.12, "{i}");
            before = next;
        }
    }

    #[test]
    fn octaves_finer_than_the_samples_are_left_out() {
        let p = DVec3::new(0.3, 1.7, -2.2);
        // One and a half octaves fit, of which the half counts half.
        let expected = noise_at(p) + 0.5 * 0.5 * noise_at(p * 1.99);
        let fbm = |spread, most| sum_at(OctaveSum::Fbm, p, spread, (most, 0.5));
        // The logarithm is off by 2e-7 at most, which the slope of the smooth step, 1.875, and the weight of the octave, a half, hardly change.
        assert!((fbm(0.5_f64.powf(2.5), 8) - expected).abs() < 1e-6);
        assert_eq!(fbm(4.0, 8), 0.0);
        let turbulence = |spread, most| sum_at(OctaveSum::Turbulence, p, spread, (most, 0.5));
        assert!((turbulence(4.0, 2) - 0.2 * (1.0 + 1.0 + 0.5)).abs() < 1e-15);
        let all = noise_at(p).abs() + 0.5 * noise_at(p * 1.99).abs() + 0.25 * 0.2;
        assert!((turbulence(0.0, 2) - all).abs() < 1e-15);
        assert_ne!(fbm(0.0, 8), fbm(0.0, 7));
    }

    #[test]
    fn the_farthest_points_have_finite_values() {
        for p in [DVec3::splat(1e150), DVec3::new(-1e100, 1e17, 3e9), DVec3::splat(-9.3e18)] {
            for spread in [0.0, 1e-300, f64::INFINITY, f64::NAN] {
                for sum in [OctaveSum::Fbm, OctaveSum::Turbulence] {
                    let value = sum_at(sum, p, spread, (64, -1e4));
                    assert!(value.abs() <= 1e18, "{p} {spread} {value}");
                }
            }
        }
    }

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
