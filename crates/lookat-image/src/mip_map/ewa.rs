//! Elliptically weighted averages (PBR 10.4.5; Heckbert, "Fundamentals of Texture Mapping and Image Warping", 1989).

use std::ops::Range;
use std::sync::LazyLock;

use glam::DVec2;

use super::{Level, MipMap, Texel, Wrap, lerp, texel};
use crate::floor;

/// Steps of the squared radius in the table of weights, as in pbrt-v3.
const STEPS: usize = 128;

/// A Gaussian that comes to 0 at radius 1: the last weight is 0.
static WEIGHTS: LazyLock<[f32; STEPS]> = LazyLock::new(|| {
    const ALPHA: f64 = 2.0;
    std::array::from_fn(|i| {
        let squared_radius = i as f64 / (STEPS - 1) as f64;
        (libm::exp(-ALPHA * squared_radius) - libm::exp(-ALPHA)) as f32
    })
});

/// The insides of an ellipse around the origin: `a s^2 + b s t + c t^2 < 1`, in texels.
struct Ellipse {
    a: f64,
    b: f64,
    c: f64,
    /// Of a parallelogram that touches it on all four sides, two of which are along rows.
    half_height: f64,
    /// Half the length of those sides.
    half_width: f64,
    /// How far the middle of a row of the parallelogram is from that of the row before.
    shear: f64,
}

impl<T: Texel> MipMap<T> {
    /// The weighted mean over the ellipse around `st` with the axes `dst0` and `dst1`. If one is more than
    /// `max_anisotropy` times as long as the other, the other is made longer: more blur for less work.
    pub fn ewa(&self, st: DVec2, dst0: DVec2, dst1: DVec2, max_anisotropy: f64) -> T {
        let (major, mut minor) =
            if dst0.length_squared() < dst1.length_squared() { (dst1, dst0) } else { (dst0, dst1) };
        let (major_length, mut minor_length) = (major.length(), minor.length());
        if !major_length.is_finite() {
            return self.mean();
        }
        if minor_length * max_anisotropy < major_length && minor_length > 0.0 {
            let scale = major_length / (minor_length * max_anisotropy);
            minor *= scale;
            minor_length *= scale;
        }
        if minor_length == 0.0 {
            return self.bilinear(st);
        }
        let last = self.levels.len() - 1;
        let level = (last as f64 + libm::log2(minor_length)).max(0.0);
        if level >= last as f64 + 1.0 {
            return self.mean();
        }
        let finer = level as usize;
        let at = |level| self.ewa_at(level, st, major, minor);
        match (level - finer as f64) as f32 {
            // As it is all over a picture that is seen enlarged.
            0.0 => at(finer),
            share => lerp(share, at(finer), at(finer + 1)),
        }
    }

    fn ewa_at(&self, level: usize, st: DVec2, dst0: DVec2, dst1: DVec2) -> T {
        let Some(level) = self.levels.get(level) else { return self.mean() };
        let size = DVec2::new(level.width as f64, level.height as f64);
        Ellipse::new(dst0 * size, dst1 * size).mean(level, level.place(st), self.wrap)
    }
}

impl Ellipse {
    /// With the given axes, made wider by about one texel, so that there are always texels inside.
    fn new(x: DVec2, y: DVec2) -> Self {
        let a = x.y * x.y + y.y * y.y + 1.0;
        let b = -2.0 * (x.x * x.y + y.x * y.y);
        let c = x.x * x.x + y.x * y.x + 1.0;
        let f = a * c - b * b * 0.25;
        let (half_height, half_width) = (a.sqrt(), (f / a).sqrt());
        Ellipse { a: a / f, b: b / f, c: c / f, half_height, half_width, shear: -0.5 * b / a }
    }

    fn mean<T: Texel>(&self, level: &Level<T>, center: DVec2, wrap: Wrap) -> T {
        let weights = &*WEIGHTS;
        let (mut sum, mut total) = (T::default(), 0.0);
        for t in whole(center.y, self.half_height) {
            let row = level.row(t, wrap);
            let dt = t as f64 - center.y;
            for s in whole(center.x + self.shear * dt, self.half_width) {
                let ds = s as f64 - center.x;
                let squared_radius = self.a * ds * ds + self.b * ds * dt + self.c * dt * dt;
                // Outside it is the last one.
                let weight = weights[((squared_radius * STEPS as f64) as i32 as usize).min(STEPS - 1)];
                sum = sum + texel(row, s, wrap) * weight;
                total += weight;
            }
        }
        if total > 0.0 { sum * (1.0 / total) } else { level.texel(center.x as i64, center.y as i64, wrap) }
    }
}

/// The whole numbers that are not farther than `reach` from `middle`.
fn whole(middle: f64, reach: f64) -> Range<i64> {
    -floor(reach - middle)..floor(middle + reach) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> MipMap<f32> {
        let texels = (0..64 * 32).map(|i| (i * 7919 % 251) as f32).collect();
        MipMap::new(64, 32, texels, Wrap::Repeat)
    }

    /// pbrt-v3's loop over the box around the ellipse finds the same texels as the loop over rows.
    #[test]
    fn the_mean_is_that_over_the_whole_box() {
        let map = map();
        let level = &map.levels[0];
        for (x, y) in [((3.0, 1.0), (-0.5, 1.5)), ((0.2, 0.1), (0.0, 0.3)), ((9.0, 8.0), (1.0, -1.0))] {
            let ellipse = Ellipse::new(x.into(), y.into());
            let center = DVec2::new(17.3, 11.8);
            let (mut sum, mut total) = (0.0, 0.0);
            for t in -30..60 {
                for s in -30..60 {
                    let (ds, dt) = (f64::from(s) - center.x, f64::from(t) - center.y);
                    let squared_radius = ellipse.a * ds * ds + ellipse.b * ds * dt + ellipse.c * dt * dt;
                    if squared_radius < 1.0 {
                        let weight = WEIGHTS[(squared_radius * 128.0) as usize];
                        sum += level.texel(s.into(), t.into(), Wrap::Repeat) * weight;
                        total += weight;
                    }
                }
            }
            assert!((ellipse.mean(level, center, Wrap::Repeat) - sum / total).abs() < 1e-3);
        }
    }

    #[test]
    fn a_point_is_the_finest_version_and_all_is_the_mean() {
        let map = map();
        let st = DVec2::new(0.3, 0.7);
        assert_eq!(map.ewa(st, DVec2::ZERO, DVec2::ZERO, 8.0), map.bilinear(st));
        assert_eq!(map.ewa(st, DVec2::X, DVec2::ZERO, 8.0), map.bilinear(st));
        assert_eq!(map.ewa(st, DVec2::X * 2.0, DVec2::Y * 3.0, 8.0), map.mean());
        assert_eq!(map.ewa(st, DVec2::X * f64::INFINITY, DVec2::Y, 8.0), map.mean());
        // Either axis may be the longer one.
        let (x, y) = (DVec2::new(0.1, 0.02), DVec2::new(0.0, 0.05));
        assert_eq!(map.ewa(st, x, y, 8.0), map.ewa(st, y, x, 8.0));
    }

    /// Of a ramp the mean over any ellipse is the value at its center.
    #[test]
    fn a_ramp_stays() {
        let ramp = MipMap::new(64, 64, (0..64 * 64).map(|i| (i % 64) as f32).collect(), Wrap::Clamp);
        for (x, y) in [((0.05, 0.02), (0.0, 0.03)), ((0.01, 0.0), (0.1, 0.1))] {
            let value = ramp.ewa(DVec2::new(0.5, 0.5), DVec2::from(x), DVec2::from(y), 8.0);
            assert!((value - 31.5).abs() < 0.3, "{value}");
        }
    }

    /// A thin ellipse is widened: across, then, it covers more.
    #[test]
    fn anisotropy_is_limited() {
        let stripes = MipMap::new(64, 64, (0..64 * 64).map(|i| (i / 64 % 2) as f32).collect(), Wrap::Repeat);
        let at = |limit| stripes.ewa(DVec2::new(0.5, 0.5078125), DVec2::X * 0.9, DVec2::Y * 0.001, limit);
        assert!((at(4.0) - 0.5).abs() < 0.01 && (at(1e4) - 0.5).abs() > 0.1);
    }
}
