//! Eight triangles: which of them a ray may meet is told in `f32`, before `f64` decides.

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2;

use std::array::from_fn;
use std::mem::offset_of;

use fearless_simd::{Simd, f32x8, prelude::*};

use super::{Axis, ShearedRay, Triangle};
use crate::bvh::WIDTH;
use crate::lanes::splat_f32;
use crate::prefetch::{LINE, prefetch};
use crate::ray::{Hit, Ray};

/// Up to eight triangles, and in `f32` their corners, and how far these are to be trusted.
///
/// All in one piece of memory: what decides about a triangle then comes at the same time as what leaves it in.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// By corner, axis and triangle.
    corners: [[[f32; WIDTH]; 3]; 3],
    /// The largest coordinate.
    magnitude: f32,
    /// The longest side of the box of any of the triangles.
    extent: f32,
    count: usize,
    /// After the first `count` come copies of the last.
    triangles: [Triangle; WIDTH],
}

impl Block {
    /// Of one to eight triangles, with finite corners.
    pub fn new(triangles: &[Triangle]) -> Self {
        let last = triangles.len() - 1;
        debug_assert!(
            last < WIDTH && triangles.iter().flat_map(|triangle| triangle.corners).all(|p| p.is_finite())
        );
        let mut block = Block {
            corners: [[[0.0; WIDTH]; 3]; 3],
            magnitude: 0.0,
            extent: 0.0,
            count: triangles.len(),
            triangles: from_fn(|lane| triangles[lane.min(last)]),
        };
        for (lane, triangle) in triangles.iter().enumerate() {
            for (corner, p) in triangle.corners.iter().enumerate() {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = p[axis] as f32;
                }
                block.magnitude = block.magnitude.max(p.abs().max_element() as f32);
            }
            let [p, q, r] = &triangle.corners;
            let sides = p.max(*q).max(*r) - p.min(*q).min(*r);
            block.extent = block.extent.max(sides.max_element() as f32);
        }
        block
    }

    /// A bit for each triangle.
    #[inline(always)]
    pub fn all(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// A corner of a triangle.
    #[inline(always)]
    pub fn corner(&self, corner: usize, lane: usize) -> [f32; 3] {
        let [x, y, z] = &self.corners[corner];
        [x[lane % WIDTH], y[lane % WIDTH], z[lane % WIDTH]]
    }

    /// The least and the greatest coordinates of the triangles along each axis, wider by what rounding has taken.
    #[inline(always)]
    pub fn boxes<S: Simd>(&self, simd: S) -> [[f32x8<S>; 3]; 2] {
        let rounding = f32::EPSILON * self.magnitude + f32::MIN_POSITIVE;
        let mut boxes = [[splat_f32(simd, 0.0); 3]; 2];
        let [a, b, c] = &self.corners;
        for axis in 0..3 {
            let (a, b): (f32x8<S>, f32x8<S>) = (a[axis].simd_into(simd), b[axis].simd_into(simd));
            let c: f32x8<S> = c[axis].simd_into(simd);
            boxes[0][axis] = a.min(b).min(c) - rounding;
            boxes[1][axis] = a.max(b).max(c) + rounding;
        }
        boxes
    }

    /// What rounding may do to rays whose origins have no larger coordinates than `magnitude`.
    #[inline(always)]
    pub fn tolerance(&self, magnitude: f32) -> Tolerance {
        let error = 12.0 * UNIT * (self.magnitude + magnitude) + f32::MIN_POSITIVE;
        let size = 2.0 * (self.extent + error);
        let is_safe = (1e-15..1e18).contains(&size);
        let side = if is_safe { 4.0 * size * (error + UNIT * size) } else { f32::INFINITY };
        Tolerance { error, size, side }
    }

    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles[..self.count]
    }

    /// The triangle of a bit.
    #[inline(always)]
    pub fn triangle(&self, lane: u32) -> &Triangle {
        &self.triangles[lane as usize % WIDTH]
    }

    /// Asks for what the filter needs.
    #[inline(always)]
    pub fn prefetch_filter(&self) {
        prefetch(self, 0..TRIANGLES);
    }

    /// Asks for the triangles: mostly one is needed as soon as the filter is done, and its place is not known before.
    #[inline(always)]
    pub fn prefetch_triangles(&self) {
        prefetch(self, TRIANGLES..size_of::<Block>() / LINE);
    }
}

/// The line from which on a block has triangles only.
const TRIANGLES: usize = offset_of!(Block, triangles).div_ceil(LINE);

/// The place of a triangle among all blocks: the number of its block, and its bit there. Less than [`Hit::NO_PLACE`].
#[inline(always)]
pub(crate) fn place(block: usize, lane: u32) -> u32 {
    debug_assert!(block < of_place(Hit::NO_PLACE).0);
    block as u32 * WIDTH as u32 + lane
}

/// The block of a place, and the bit there.
#[inline(always)]
pub(crate) fn of_place(place: u32) -> (usize, u32) {
    ((place / WIDTH as u32) as usize, place % WIDTH as u32)
}

/// A ray turned to run along z, as [`ShearedRay`], in `f32`: each number as often as `Lanes` has room for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilterRay<Lanes> {
    /// The origin along each of `axes`.
    turned: [Lanes; 3],
    axes: [Axis; 3],
    shear: [Lanes; 2],
    /// The sign of the direction along the last axis.
    sign: Lanes,
    scale: Scale,
}

/// What rounding may do to triangles, seen from a ray that runs along z from the origin.
///
/// Corners and origin are rounded, and their difference, and its product with the shear: a corner moves by less than
/// `error`. Where the ray passes the box of a triangle, its corners are not farther from it than `size`. The cross
/// product of two of them then moves by less than `side`. Where products overflow or vanish, nothing is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tolerance {
    pub error: f32,
    size: f32,
    pub side: f32,
}

/// What the rounding of a ray is in proportion to.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// The size of the direction along the last axis.
    length: f64,
    /// The largest coordinate of the origin.
    magnitude: f32,
}

/// What rounding may do to the sides of a triangle, and the depths between which it has to lie.
#[derive(Debug, Clone, Copy)]
struct Limits {
    side: f32,
    /// `side` holds for corners that are no farther from the ray than this, along each of the first two axes.
    size: f32,
    nearest: f32,
    farthest: f32,
    /// What lies between these does lie between the origin and the end of the ray.
    surely: [f32; 2],
}

/// A triangle as a ray passes it, or several.
#[derive(Debug, Clone, Copy)]
struct Sides<Lanes> {
    /// On which sides of its edges: in proportion to the areas between these and the ray.
    least: Lanes,
    greatest: Lanes,
    /// Between which depths it is.
    front: Lanes,
    back: Lanes,
    /// How far its corners are from the ray, along either of the first two axes.
    away: Lanes,
}

/// The rounding of one operation, relative to its result.
const UNIT: f32 = f32::EPSILON / 2.0;

impl Scale {
    #[inline(always)]
    fn limits(&self, block: &Block, t_max: f64) -> Limits {
        let Tolerance { error, size, side } = block.tolerance(self.magnitude);
        // A product in f32 may overflow to infinity, which is a limit too.
        let end = (t_max * self.length) as f32;
        let farthest = end * (1.0 + 4.0 * UNIT) + error;
        let surely = [error, end * (1.0 - 4.0 * UNIT) - 2.0 * error];
        Limits { side, size, nearest: -error, farthest, surely }
    }
}

impl<Lanes> FilterRay<Lanes> {
    /// `splat` gives lanes that all hold one number.
    #[inline(always)]
    pub fn new(ray: &Ray, sheared: &ShearedRay, splat: impl Fn(f32) -> Lanes) -> Self {
        let ShearedRay { turned: [x, y, z], axes, shear, .. } = *sheared;
        let along = axes[2].of(ray.d.as_ref());
        // Of directions so short or long, one over which may vanish or overflow, nothing is known.
        let is_safe = (1e-100..1e100).contains(&along.abs());
        let magnitude = if is_safe { ray.o.abs().max_element() as f32 } else { f32::INFINITY };
        FilterRay {
            turned: [splat(x as f32), splat(y as f32), splat(z as f32)],
            axes,
            shear: [splat(shear.x as f32), splat(shear.y as f32)],
            sign: splat(along.signum() as f32),
            scale: Scale { length: along.abs(), magnitude },
        }
    }
}

impl FilterRay<f32> {
    /// Which triangles of a block the ray may meet before `t_max`, as bits: all that it does meet, and few others.
    ///
    /// It misses where it certainly passes one edge on the one side, and another edge on the other.
    #[inline(always)]
    pub fn may_meet(&self, block: &Block, t_max: f64) -> u32 {
        let limits = self.scale.limits(block, t_max);
        let bit = |lane: usize| {
            let Sides { least, greatest, front, back, .. } = self.sides(block, lane);
            let passes = least < -limits.side && greatest > limits.side;
            let is_out = passes || front > limits.farthest || back < limits.nearest;
            u32::from(!is_out) << lane
        };
        (0..WIDTH).map(bit).sum::<u32>() & block.all()
    }

    /// Those that it certainly meets: most of what it does meet.
    ///
    /// It passes all edges on the same side, all corners are between its origin and its end, and none is far from it.
    #[inline(always)]
    pub fn surely_meets(&self, block: &Block, t_max: f64) -> u32 {
        let limits = self.scale.limits(block, t_max);
        let bit = |lane: usize| {
            let Sides { least, greatest, front, back, away } = self.sides(block, lane);
            let is_between = front > limits.surely[0] && back < limits.surely[1];
            let is_one_side = least > limits.side || greatest < -limits.side;
            u32::from(is_between && is_one_side && away <= limits.size) << lane
        };
        (0..WIDTH).map(bit).sum::<u32>() & block.all()
    }

    #[inline(always)]
    fn sides(&self, block: &Block, lane: usize) -> Sides<f32> {
        let sheared = |corner: &[[f32; WIDTH]; 3]| {
            let [x, y, z] = [0, 1, 2].map(|k| self.axes[k].of(corner)[lane] - self.turned[k]);
            [x - self.shear[0] * z, y - self.shear[1] * z, z * self.sign]
        };
        let [a, b, c] = [0, 1, 2].map(|corner| sheared(&block.corners[corner]));
        let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
        Sides {
            least: u.min(v).min(w),
            greatest: u.max(v).max(w),
            front: a[2].min(b[2]).min(c[2]),
            back: a[2].max(b[2]).max(c[2]),
            away: [a, b, c].iter().fold(0.0, |away: f32, p| away.max(p[0].abs()).max(p[1].abs())),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::arithmetic::{Simd, SimdKind};
    use crate::testing::noise;

    fn block(triangles: &[[DVec3; 3]]) -> Block {
        let triangles: Vec<Triangle> = triangles.iter().copied().map(Triangle::of_corners).collect();
        Block::new(&triangles)
    }

    /// Triangles near and far, small and large, and rays at their edges: whatever `f64` meets, the filter lets through,
    /// and little else.
    #[test]
    fn no_triangle_that_is_met_is_left_out() {
        let (mut met, mut extra) = (0, 0);
        for case in 0..40_000 {
            let (size, away) = (10_f64.powi(case as i32 % 9 - 4), 10_f64.powi(case as i32 % 7 - 1));
            let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
            let place = point(7.0) * away;
            let triangles = [1.0, 2.0, 3.0, 4.0, 5.0]
                .map(|k| [0.0, 0.3, 0.6].map(|corner| place + point(k + corner) * size));
            let block = block(&triangles);
            let [p, q, _] = triangles[case % 5];
            let o = place + point(8.0) * size * 3.0;
            // At an edge, or at random.
            let target =
                if case % 2 == 0 { p + (q - p) * noise(case, 9.0).abs() } else { place + point(9.0) * size };
            let ray = Ray::new(o, (target - o).normalize());
            let sheared = ShearedRay::new(&ray);
            let t_max = if case % 3 == 0 { size } else { f64::INFINITY };
            let hits = |triangle| sheared.intersect(triangle).is_some_and(|(t, _)| t <= t_max);
            let exact: u32 =
                triangles.iter().zip(0..).map(|(triangle, lane)| u32::from(hits(triangle)) << lane).sum();
            let filter = FilterRay::new(&ray, &sheared, |x| x);
            let may = filter.may_meet(&block, t_max);
            assert_eq!(exact & !may, 0, "{ray:?} {triangles:?}");
            met += exact.count_ones();
            // Where all is far larger than the triangles, f32 cannot tell.
            extra += if away <= size * 10.0 { (may & !exact).count_ones() } else { 0 };
            #[cfg(target_arch = "x86_64")]
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the processor has what the functions ask for.
                #[allow(unsafe_code)]
                let wide = unsafe { avx2::filter_ray(&ray, &sheared).may_meet(&block, t_max) };
                assert_eq!(exact & !wide, 0, "{ray:?} {triangles:?}");
            }
        }
        assert!(met > 10_000 && extra < met, "{met} {extra}");
    }

    /// Triangles of all sizes, flat ones and points, near the ray and far from it, which ends before them, in them, at their
    /// hit or a corner but for the rounding of `f32`, or beyond; and its direction has any length. What `f32` is sure of,
    /// `f64` meets, with any instructions.
    #[test]
    fn what_is_surely_met_is_met() {
        let (mut met, mut sure) = (0, [0; 2]);
        for case in 0..60_000 {
            let (size, away) = (10_f64.powi(case as i32 % 9 - 6), 10_f64.powi(case as i32 % 7 - 1));
            let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
            let place = point(7.0) * away;
            let aside = if case % 5 == 0 { point(5.0) * away } else { DVec3::ZERO };
            // Some in a plane, which the ray runs straight at, sometimes from almost there.
            let is_flat = case % 3 == 0;
            let flat = if is_flat { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
            let triangles = [1.0, 2.0, 3.0, 4.0]
                .map(|k| [0.0, 0.3, 0.6].map(|corner| place + aside + flat * point(k + corner) * size));
            let block = block(&triangles);
            let target = place + flat * point(9.0) * size * 0.5;
            let back = if is_flat { point(8.0) * DVec3::new(0.1, 0.1, 1.0) } else { point(8.0) };
            let d = -back.normalize() * 10_f64.powi(case as i32 % 13 - 6);
            let distance =
                if case % 2 == 0 { away.max(size) } else { noise(case, 4.3) * 1e-7 * place.length() };
            let o = target + back * 2.0 * distance;
            let ray = Ray::new(o, d);
            let sheared = ShearedRay::new(&ray);
            let near = 1.0 + 2e-7 * noise(case, 6.1);
            let corner = (triangles[case % 4][case % 3] - o).dot(d) / d.length_squared();
            let hit =
                triangles.iter().find_map(|triangle| sheared.intersect(triangle)).map_or(1.0, |hit| hit.0);
            for t_max in [hit * near, corner * near, hit * 0.999, hit * 1.001, 0.0, -1.0, f64::INFINITY] {
                let hits = |triangle| sheared.intersect(triangle).is_some_and(|(t, _)| t > 0.0 && t <= t_max);
                let bit = |(triangle, lane)| u32::from(hits(triangle)) << lane;
                let exact: u32 = triangles.iter().zip(0..).map(bit).sum();
                let surely = FilterRay::new(&ray, &sheared, |x| x).surely_meets(&block, t_max);
                assert_eq!(surely & !exact, 0, "{ray:?} {t_max} {triangles:?}");
                met += exact.count_ones();
                sure[0] += surely.count_ones();
                #[cfg(target_arch = "x86_64")]
                if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                    // SAFETY: as above.
                    #[allow(unsafe_code)]
                    let wide = unsafe { avx2::filter_ray(&ray, &sheared).surely_meets(&block, t_max) };
                    assert_eq!(wide & !exact, 0, "{ray:?} {t_max} {triangles:?}");
                    sure[1] += wide.count_ones();
                }
            }
        }
        let is_wide = cfg!(target_arch = "x86_64") && Simd::best().kind() != SimdKind::Portable;
        assert!(met > 50_000 && sure[0] > 10_000 && (!is_wide || sure[1] > 10_000), "{met} {sure:?}");
    }

    /// Nor where directions are beyond what `f64` can turn.
    #[test]
    fn directions_of_any_length_pass() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| (p + DVec3::Z) * 1e-3);
        let block = block(&[triangle]);
        for length in [1e-310, 1e-200, 1e-101, 1e101, 1e200, 1e290, 1e300] {
            let ray = Ray::new(DVec3::new(2e-4, 2e-4, 0.0), DVec3::Z * length);
            let filter = FilterRay::new(&ray, &ShearedRay::new(&ray), |x| x);
            for t_max in [f64::INFINITY, 1.0 / length] {
                let (may, surely) = (filter.may_meet(&block, t_max), filter.surely_meets(&block, t_max));
                assert_eq!((may, surely), (1, 0), "{length} {t_max}");
            }
        }
    }

    /// Where `f32` overflows, vanishes or is not a number, `f64` decides.
    #[test]
    fn numbers_beyond_f32_pass() {
        for size in [1e-100, 1e-45, 1e-30, 1e19, 1e30, 1e39, 1e100] {
            let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| (p + DVec3::Z) * size);
            let block = block(&[triangle]);
            let ray = Ray::new(DVec3::new(0.25, 0.25, 0.0) * size, DVec3::Z);
            let sheared = ShearedRay::new(&ray);
            assert!(sheared.intersect(&triangle).is_some(), "{size}");
            let filter = FilterRay::new(&ray, &sheared, |x| x);
            for t_max in [f64::INFINITY, size] {
                let (may, surely) = (filter.may_meet(&block, t_max), filter.surely_meets(&block, t_max));
                assert_eq!((may, surely), (1, 0), "{size} {t_max}");
            }
        }
    }
}
