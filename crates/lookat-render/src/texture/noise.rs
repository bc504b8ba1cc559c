//! Noise in space, and sums of it (PBR 10.6).

use glam::DVec3;
use lookat_image::floor;
use lookat_scene::{Octaves, Transform};

use super::TexturePoint;

/// The permutation of Perlin's "Improving Noise" (2002), which pbrt-v3 has too: its pictures are the same.
static PERMUTATION: [u8; 256] = [
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

/// The gradients of corners: directions to the edges of a cube, four of them twice.
static GRADIENTS: [DVec3; 16] = [
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(-1.0, -1.0, 0.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(-1.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(-1.0, 0.0, -1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, -1.0, 1.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(0.0, -1.0, -1.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(0.0, -1.0, -1.0),
];

/// Perlin's gradient noise with pbrt-v3's gradients: smooth, about -1..1, 0 at whole coordinates.
#[inline]
pub(super) fn noise(p: DVec3) -> f64 {
    noise_at(p.x, p.y, p.z)
}

/// Three numbers come in registers; a vector would come by way of memory, and wait there to be written.
fn noise_at(x: f64, y: f64, z: f64) -> f64 {
    let p = DVec3::new(x, y, z);
    let cell = p.to_array().map(floor);
    // Far beyond all digits, where no integer is near, any place in the cell will do.
    let d = (p - DVec3::from(cell.map(|x| x as f64))).clamp(DVec3::ZERO, DVec3::ONE);
    let weight = d * d * d * (d * (d * 6.0 - 15.0) + 10.0);
    let at = |x: u8, y: u8, z: u8| {
        let [i, j, k] = cell.map(|x| x as u8);
        let corner = [i.wrapping_add(x), j.wrapping_add(y), k.wrapping_add(z)];
        gradient(corner).dot(d - DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
    };
    let along_x = |y, z| lerp(at(0, y, z), at(1, y, z), weight.x);
    let along_y = |z| lerp(along_x(0, z), along_x(1, z), weight.y);
    lerp(along_y(0), along_y(1), weight.z)
}

/// That of a corner. The corners repeat after 256 cells.
fn gradient([x, y, z]: [u8; 3]) -> DVec3 {
    let permuted = |index: u8| PERMUTATION[usize::from(index)];
    let hash = permuted(permuted(permuted(x).wrapping_add(y)).wrapping_add(z));
    GRADIENTS[usize::from(hash & 15)]
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// A point in the space of a texture.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointInSpace {
    pub p: DVec3,
    /// The distance to its neighbors.
    pub spread: f64,
}

impl PointInSpace {
    pub fn new(at: &TexturePoint, texture_from_world: &Transform) -> Self {
        let [x, y] = at.footprint.dp.map(|dp| texture_from_world.vector(dp).length());
        PointInSpace { p: at.within(texture_from_world), spread: x.max(y) }
    }

    pub fn scaled(self, scale: f64) -> Self {
        PointInSpace { p: self.p * scale, spread: self.spread * scale.abs() }
    }

    /// The number of octaves that are not finer than the distance of neighbors, with the share of the last.
    fn octaves(&self, most: u32) -> (u32, f64) {
        // All where there are no neighbors; none where the distance is no number.
        let octaves = (-1.0 - self.spread.log2()).max(0.0).min(f64::from(most));
        let whole = octaves as u32;
        (whole, smooth_step(0.3, 0.7, octaves - f64::from(whole)))
    }
}

/// The factor of the frequency from one octave to the next: not quite 2, so that their zeros do not coincide.
const LACUNARITY: f64 = 1.99;

/// The sum of octaves of noise.
pub(super) fn fbm(at: &PointInSpace, most: u32, roughness: f64) -> f64 {
    let (count, share) = at.octaves(most);
    let mut sum = 0.0;
    let (mut frequency, mut height) = (1.0, 1.0);
    for _ in 0..count {
        sum += height * noise(at.p * frequency);
        frequency *= LACUNARITY;
        height *= roughness;
    }
    if share > 0.0 {
        sum += height * share * noise(at.p * frequency);
    }
    bounded(sum)
}

/// The mean of the absolute value of noise, about, in place of octaves that are too fine.
const MEAN: f64 = 0.2;

/// The sum of absolute values of octaves of noise.
pub(super) fn turbulence(at: &PointInSpace, most: u32, roughness: f64) -> f64 {
    let (count, share) = at.octaves(most);
    let mut sum = 0.0;
    let (mut frequency, mut height) = (1.0, 1.0);
    for _ in 0..count {
        sum += height * noise(at.p * frequency).abs();
        frequency *= LACUNARITY;
        height *= roughness;
    }
    let last = if share > 0.0 { lerp(MEAN, noise(at.p * frequency).abs(), share) } else { MEAN };
    sum += height * last;
    // As pbrt-v3 has it, with the octave that was just added counted once more.
    for _ in count..most {
        sum += height * MEAN;
        height *= roughness;
    }
    bounded(sum)
}

/// Waves, high where the wind is strong.
pub(super) fn windy(at: &PointInSpace) -> f64 {
    let strength = fbm(&at.scaled(0.1), 3, 0.5);
    strength.abs() * fbm(at, 6, 0.5)
}

pub(super) fn fbm_octaves(at: &TexturePoint, octaves: &Octaves) -> f64 {
    fbm(&PointInSpace::new(at, &octaves.texture_from_world), octaves.count, octaves.roughness)
}

pub(super) fn turbulence_octaves(at: &TexturePoint, octaves: &Octaves) -> f64 {
    turbulence(&PointInSpace::new(at, &octaves.texture_from_world), octaves.count, octaves.roughness)
}

/// A height that a color can hold, whatever the roughness.
fn bounded(height: f64) -> f64 {
    height.clamp(-1e18, 1e18)
}

/// 0 up to `low`, 1 from `high`, and a smooth way between.
fn smooth_step(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(p: DVec3, spread: f64) -> PointInSpace {
        PointInSpace { p, spread }
    }

    #[test]
    fn noise_is_0_at_whole_coordinates_and_has_its_gradient_there() {
        for (x, y, z) in [(0, 0, 0), (3, -5, 7), (255, 256, -1), (-1000, 12345, 99)] {
            let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            assert_eq!(noise(p), 0.0);
            let gradient = gradient([x, y, z].map(|x: i32| x.rem_euclid(256) as u8));
            for offset in [DVec3::X, DVec3::Y, -DVec3::Z, DVec3::ONE] {
                let slope = noise(p + offset * 1e-6) / 1e-6;
                assert!((slope - gradient.dot(offset)).abs() < 1e-4, "{p} {offset} {slope}");
            }
        }
    }

    /// Perlin's way to choose two components by the bits of the hash, and their signs.
    #[test]
    fn gradients_are_those_of_pbrt() {
        let offset = DVec3::new(0.3, -0.7, 0.11);
        for (hash, gradient) in GRADIENTS.iter().enumerate() {
            let u = if hash < 8 || hash == 12 || hash == 13 { offset.x } else { offset.y };
            let v = if hash < 4 || hash == 12 || hash == 13 { offset.y } else { offset.z };
            let expected = (if hash & 1 == 0 { u } else { -u }) + (if hash & 2 == 0 { v } else { -v });
            assert_eq!(gradient.dot(offset), expected, "{hash}");
        }
    }

    #[test]
    fn noise_is_smooth_and_bounded() {
        let along = DVec3::new(0.0123, 0.0231, -0.0077);
        let mut before = noise(DVec3::splat(-20.0));
        for i in 1..5000 {
            let next = noise(DVec3::splat(-20.0) + along * f64::from(i));
            assert!(next.abs() <= 1.0 && (next - before).abs() < 0.12, "{i}");
            before = next;
        }
    }

    #[test]
    fn octaves_finer_than_the_samples_are_left_out() {
        let p = DVec3::new(0.3, 1.7, -2.2);
        // One and a half octaves fit, of which the half counts half.
        let expected = noise(p) + 0.5 * 0.5 * noise(p * 1.99);
        assert!((fbm(&at(p, 0.5_f64.powf(2.5)), 8, 0.5) - expected).abs() < 1e-12);
        assert_eq!(fbm(&at(p, 4.0), 8, 0.5), 0.0);
        assert!((turbulence(&at(p, 4.0), 2, 0.5) - 0.2 * (1.0 + 1.0 + 0.5)).abs() < 1e-15);
        assert_ne!(fbm(&at(p, 0.0), 8, 0.5), fbm(&at(p, 0.0), 7, 0.5));
    }

    #[test]
    fn the_farthest_points_have_finite_values() {
        for p in [DVec3::splat(1e150), DVec3::new(-1e100, 1e17, 3e9), DVec3::splat(-9.3e18)] {
            for spread in [0.0, 1e-300, f64::INFINITY, f64::NAN] {
                for value in [fbm, turbulence].map(|sum| sum(&at(p, spread), 64, -1e4)) {
                    assert!(value.abs() <= 1e18, "{p} {spread} {value}");
                }
            }
        }
    }
}
