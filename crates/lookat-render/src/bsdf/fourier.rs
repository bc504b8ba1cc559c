//! Tables of scattering as Fourier series (PBR 8.6 and 14.1.4; FourierBSDF in core/reflection.cpp). Surfaces are computed one by one, eight
//! coefficients side by side.

use std::array::from_fn;
use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, prelude::*};
use glam::Vec3;
use lookat_scene::{FourierTable, Series};
use smallvec::SmallVec;

use crate::number::{LANES, V3, Vec3fx8, set_lanes, splat_f32, to_f64, vectorized, widen};

/// A table of the world. Equal to itself only.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table<'m>(pub &'m FourierTable);

impl PartialEq for Table<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Table<'_> {}

/// Four neighboring cosines, by number, and their weights in a Catmull-Rom spline.
#[derive(Clone, Copy)]
struct Neighbors {
    at: [usize; 4],
    weight: [f32; 4],
}

impl Neighbors {
    /// `None` outside of the cosines.
    fn new(cosines: &[f32], x: f32) -> Option<Self> {
        let last = cosines.len() - 1;
        // Directions have a length of one, and the ends of tables are 1, except for rounding.
        let x = if x.abs() > 1.0 - 1e-5 { x.clamp(cosines[0], cosines[last]) } else { x };
        if !(x >= cosines[0] && x <= cosines[last]) {
            return None;
        }
        let first = (cosines.partition_point(|cosine| *cosine <= x) - 1).min(last - 1);
        let (x0, x1) = (cosines[first], cosines[first + 1]);
        let width = x1 - x0;
        let t = (x - x0) / width;
        let (t2, t3) = (t * t, t * t * t);
        // Hermite's basis: the values at the ends, and the slopes there.
        let [from, to] = [2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3];
        let [slope_from, slope_to] = [t3 - 2.0 * t2 + t, t3 - t2];
        let mut weight = [0.0, from, to, 0.0];
        if first > 0 {
            let share = slope_from * width / (x1 - cosines[first - 1]);
            (weight[0], weight[2]) = (-share, weight[2] + share);
        } else {
            (weight[1], weight[2]) = (weight[1] - slope_from, weight[2] + slope_from);
        }
        if first + 2 <= last {
            let share = slope_to * width / (cosines[first + 2] - x0);
            (weight[1], weight[3]) = (weight[1] - share, share);
        } else {
            (weight[1], weight[2]) = (weight[1] - slope_to, weight[2] + slope_to);
        }
        // The neighbors that are not there have no weight.
        let at = [first.saturating_sub(1), first, first + 1, (first + 2).min(last)];
        Some(Neighbors { at, weight })
    }

    /// Those with a weight.
    fn all(self) -> impl Iterator<Item = (usize, f32)> {
        (0..4).map(move |at| (self.at[at], self.weight[at])).filter(|(_, weight)| *weight != 0.0)
    }

    fn mean(self, of: impl Fn(usize) -> f32) -> f64 {
        self.all().map(|(at, weight)| f64::from(weight) * f64::from(of(at))).sum()
    }
}

/// The series near a pair of cosines, with their weights.
struct Mixed<'m> {
    coefficients: &'m [f32],
    series: SmallVec<[(f32, Series); 16]>,
    /// The number of coefficients of the longest one.
    most: usize,
}

/// Which of eight coefficients there are, by their count.
const PRESENT: [[f32; LANES]; LANES + 1] = {
    let (mut all, mut count) = ([[0.0; LANES]; LANES + 1], 1);
    while count <= LANES {
        all[count] = all[count - 1];
        all[count][count - 1] = 1.0;
        count += 1;
    }
    all
};

impl<'m> Mixed<'m> {
    fn new(table: &'m FourierTable, viewer: Neighbors, light: Neighbors) -> Self {
        let mut mixed = Mixed { coefficients: table.coefficients(), series: SmallVec::new(), most: 0 };
        for (o, weight_o) in viewer.all() {
            for (i, weight_i) in light.all() {
                let series = table.series(o, i);
                if series.count > 0 {
                    mixed.most = mixed.most.max(series.count as usize);
                    mixed.series.push((weight_o * weight_i, series));
                }
            }
        }
        mixed
    }

    /// Eight coefficients of some channels, from `first` on.
    #[inline(always)]
    fn eights<S: Simd, const CHANNELS: usize>(&self, simd: S, first: usize) -> [f32x8<S>; CHANNELS] {
        let mut sums = [splat_f32(simd, 0.0); CHANNELS];
        for (weight, Series { first: start, count }) in &self.series {
            let (start, count) = (*start as usize, *count as usize);
            if first >= count {
                continue;
            }
            let present: f32x8<S> = PRESENT[(count - first).min(LANES)].simd_into(simd);
            let weight = present * *weight;
            for (channel, sum) in sums.iter_mut().enumerate() {
                let eight = self.coefficients[start + channel * count + first..].first_chunk();
                let eight: f32x8<S> = (*eight.expect("zeros follow the coefficients")).simd_into(simd);
                *sum += eight * weight;
            }
        }
        sums
    }
}

/// Cosines or sines of the multiples of an angle, eight at a time.
struct Multiples<S: Simd> {
    before: f64x8<S>,
    now: f64x8<S>,
    /// Twice the cosine of eight times the angle.
    factor: f64,
}

impl<S: Simd> Multiples<S> {
    /// Cosines (and, by the sine of the angle, sines) from 0 times the angle on.
    #[inline(always)]
    fn new(simd: S, cos: f64, sin: f64) -> [Self; 2] {
        let mut cosines = [1.0; LANES + 1];
        let mut sines = [0.0; LANES + 1];
        (cosines[1], sines[1]) = (cos, sin);
        for at in 2..=LANES {
            cosines[at] = 2.0 * cos * cosines[at - 1] - cosines[at - 2];
            sines[at] = 2.0 * cos * sines[at - 1] - sines[at - 2];
        }
        let factor = 2.0 * cosines[LANES];
        let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = cosines;
        let [s0, s1, s2, s3, s4, s5, s6, s7, s8] = sines;
        let eight = |numbers: [f64; LANES]| numbers.simd_into(simd);
        [
            Multiples {
                before: eight([c8, c7, c6, c5, c4, c3, c2, c1]),
                now: eight([c0, c1, c2, c3, c4, c5, c6, c7]),
                factor,
            },
            Multiples {
                before: -eight([s8, s7, s6, s5, s4, s3, s2, s1]),
                now: eight([s0, s1, s2, s3, s4, s5, s6, s7]),
                factor,
            },
        ]
    }

    #[inline(always)]
    fn next(&mut self) {
        (self.before, self.now) = (self.now, self.now * self.factor - self.before);
    }
}

/// The sum of eight numbers, in pairs.
fn sum<S: Simd>(numbers: f64x8<S>) -> f64 {
    let [a, b, c, d, e, f, g, h] = numbers.to_array();
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// The value of the BSDF, and the density of [`sample`], where there are surfaces.
#[inline(never)]
pub(super) fn f_pdf<S: Simd>(
    table: &FourierTable,
    wo: Vec3fx8<S>,
    wi: Vec3fx8<S>,
    own: mask32x8<S>,
) -> (Vec3fx8<S>, f32x8<S>) {
    let simd = own.token();
    vectorized!(simd, {
        let (mut f, mut pdf) = (Vec3fx8::splat(simd, Vec3::ZERO), splat_f32(simd, 0.0));
        for lane in set_lanes(widen(own)) {
            if let Some((value, density)) = one(simd, table, wo.lane(lane), -wi.lane(lane)) {
                f.set_lane(lane, value);
                pdf[lane] = density;
            }
        }
        (f, pdf)
    })
}

/// The value at one surface, and the density. `wi`: the direction in which the light travels.
#[inline(always)]
fn one<S: Simd>(simd: S, table: &FourierTable, wo: Vec3, wi: Vec3) -> Option<(Vec3, f32)> {
    let [viewer, light] = [wo.z, wi.z].map(|cosine| Neighbors::new(table.cosines(), cosine));
    let (viewer, light) = (viewer?, light?);
    let mixed = Mixed::new(table, viewer, light);
    let across = f64::from(wo.truncate().length()) * f64::from(wi.truncate().length());
    let cos = f64::from(wo.truncate().dot(wi.truncate())) / across;
    let cos = if across > 0.0 { cos.clamp(-1.0, 1.0) } else { 1.0 };
    let [mut cosines, _] = Multiples::new(simd, cos, 0.0);
    let mut sums = [f64x8::splat(simd, 0.0); 3];
    for first in (0..mixed.most).step_by(LANES) {
        if table.channels() == 1 {
            let [y] = mixed.eights(simd, first);
            sums[0] += to_f64(y) * cosines.now;
        } else {
            let eights: [f32x8<S>; 3] = mixed.eights(simd, first);
            for (sum, eight) in sums.iter_mut().zip(eights) {
                *sum += to_f64(eight) * cosines.now;
            }
        }
        cosines.next();
    }
    let [y, red, blue] = [sum(sums[0]), sum(sums[1]), sum(sums[2])];
    let all = TAU * viewer.mean(|o| *table.sums(o).last().expect("a table has at least 2 cosines"));
    let pdf = if all > 0.0 && y > 0.0 { y / all } else { 0.0 };
    let y = y.max(0.0);
    let color = match table.channels() {
        1 => [y; 3],
        // The matrix of pbrt-v3.
        _ => [red, 1.39829 * y - 0.100913 * blue - 0.297375 * red, blue],
    };
    let mut scale = if wi.z == 0.0 { 0.0 } else { 1.0 / f64::from(wi.z.abs()) };
    if wi.z * wo.z > 0.0 {
        // Radiance is denser where the index is larger.
        let eta = f64::from(table.eta());
        let ratio = if wi.z > 0.0 { 1.0 / eta } else { eta };
        scale *= ratio * ratio;
    }
    let [x, y, z] = color.map(|channel| (channel.max(0.0) * scale) as f32);
    Some((Vec3::new(x, y, z), pdf as f32))
}

/// Directions, and where there are some.
#[inline(never)]
pub(super) fn sample<S: Simd>(
    table: &FourierTable,
    wo: Vec3fx8<S>,
    [u, v]: [f32x8<S>; 2],
    own: mask32x8<S>,
) -> (Vec3fx8<S>, mask32x8<S>) {
    let simd = own.token();
    vectorized!(simd, {
        let (mut all, mut is_valid) = (wo, 0);
        for lane in set_lanes(widen(own)) {
            if let Some(wi) = sample_one(simd, table, wo.lane(lane), [u[lane], v[lane]].map(f64::from)) {
                all.set_lane(lane, wi);
                is_valid |= 1 << lane;
            }
        }
        (all, mask32x8::from_bitmask(simd, is_valid))
    })
}

#[inline(always)]
fn sample_one<S: Simd>(simd: S, table: &FourierTable, wo: Vec3, [u, v]: [f64; 2]) -> Option<Vec3> {
    let viewer = Neighbors::new(table.cosines(), wo.z)?;
    let cos = sample_cosine(table, viewer, v)?;
    let light = Neighbors::new(table.cosines(), cos)?;
    let mixed = Mixed::new(table, viewer, light);
    let mut series: SmallVec<[SeriesBlock<S>; 8]> = SmallVec::new();
    for first in (0..mixed.most).step_by(LANES) {
        let [eight] = mixed.eights(simd, first);
        let orders: [f64; LANES] = from_fn(|at| (first + at).max(1) as f64);
        let (of_value, orders): (_, f64x8<S>) = (to_f64(eight), orders.simd_into(simd));
        series.push(SeriesBlock { of_value, of_integral: of_value / orders });
    }
    let phi = sample_azimuth(simd, &series, u)?;
    let (sin_phi, cos_phi) = libm::sincos(phi);
    let sin = f64::from(1.0 - cos * cos).max(0.0).sqrt();
    let [x, y] = [wo.x, wo.y].map(f64::from);
    let across = (x * x + y * y).sqrt();
    let [x, y] = if across > 0.0 { [x / across, y / across] } else { [1.0, 0.0] };
    let [x, y] = [cos_phi * x - sin_phi * y, sin_phi * x + cos_phi * y].map(|along| (-sin * along) as f32);
    Some(Vec3::new(x, y, -cos).normalize())
}

/// Eight coefficients of a series, and of its integral: over their orders.
struct SeriesBlock<S: Simd> {
    of_value: f64x8<S>,
    of_integral: f64x8<S>,
}

/// The cosine of light, in proportion to the mean over the azimuth (PBR, SampleCatmullRom2D). `None` without light.
fn sample_cosine(table: &FourierTable, viewer: Neighbors, u: f64) -> Option<f32> {
    let x = table.cosines();
    let last = x.len() - 1;
    let sum = |at: usize| viewer.mean(|o| table.sums(o)[at]);
    let f = |at: usize| viewer.mean(|o| table.mean(o, at));
    let all = sum(last);
    if all <= 0.0 || all.is_nan() {
        return None;
    }
    let u = u * all;
    // The last cosine, but one, whose sum is not above `u`.
    let (mut first, mut end) = (0, last);
    while end - first > 1 {
        let middle = (first + end) / 2;
        if sum(middle) <= u { first = middle } else { end = middle }
    }
    let [x0, x1] = [x[first], x[first + 1]].map(f64::from);
    let (f0, f1, width) = (f(first), f(first + 1), x1 - x0);
    let slope = |from: usize, to: usize| width * (f(to) - f(from)) / f64::from(x[to] - x[from]);
    let before = if first > 0 { slope(first - 1, first + 1) } else { f1 - f0 };
    let after = if first + 2 <= last { slope(first, first + 2) } else { f1 - f0 };
    let u = (u - sum(first)) / width;
    // The integral and its derivative.
    let integral = |t: f64| {
        let cubic = (-2.0 * before - after) / 3.0 + f1 - f0;
        let quartic = 0.25 * (before + after) + 0.5 * (f0 - f1);
        t * (f0 + t * (0.5 * before + t * (cubic + t * quartic)))
    };
    let value = |t: f64| {
        let quadratic = -2.0 * before - after + 3.0 * (f1 - f0);
        f0 + t * (before + t * (quadratic + t * (before + after + 2.0 * (f0 - f1))))
    };
    let t = root([0.0, 1.0], 1e-7 * (f0.abs() + f1.abs()), |t| (integral(t) - u, value(t)));
    Some((x0 + width * t) as f32)
}

/// An azimuth, in proportion to a series (PBR, SampleFourier). `None` without light.
#[inline(always)]
fn sample_azimuth<S: Simd>(simd: S, series: &[SeriesBlock<S>], u: f64) -> Option<f64> {
    let mean = series.first()?.of_value[0];
    if mean <= 0.0 || mean.is_nan() {
        return None;
    }
    // It is symmetrical.
    let (is_back, u) = if u < 0.5 { (false, 2.0 * u) } else { (true, 2.0 - 2.0 * u) };
    let phi = root(
        [0.0, PI],
        1e-6 * mean,
        #[inline(always)]
        |phi| {
            let (sin, cos) = libm::sincos(phi);
            let [mut cosines, mut sines] = Multiples::new(simd, cos, sin);
            let (mut value, mut integral) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 0.0));
            for block in series {
                // The sine of 0 leaves out the constant, which has another integral.
                value += block.of_value * cosines.now;
                integral += block.of_integral * sines.now;
                cosines.next();
                sines.next();
            }
            (sum(integral) + mean * phi - u * mean * PI, sum(value))
        },
    );
    Some(if is_back { TAU - phi } else { phi })
}

/// Where a function that increases is 0, by Newton's method and bisection, after 100 steps at most. `of`: the function and its
/// derivative.
#[inline(always)]
fn root([mut low, mut high]: [f64; 2], tolerance: f64, of: impl Fn(f64) -> (f64, f64)) -> f64 {
    let narrow = 1e-8 * (high - low);
    let mut x = 0.5 * (low + high);
    for _ in 0..100 {
        let (value, slope) = of(x);
        if value > 0.0 {
            high = x
        } else {
            low = x
        }
        if value.abs() <= tolerance || high - low < narrow {
            break;
        }
        x -= value / slope;
        if !(x > low && x < high) {
            x = 0.5 * (low + high);
        }
    }
    x
}

/// About what surfaces scatter of light, by the cosine towards the viewer.
pub(super) fn albedo<S: Simd>(table: &FourierTable, cos_o: f32x8<S>) -> Vec3fx8<S> {
    let of = |cosine: f32| {
        let viewer = Neighbors::new(table.cosines(), cosine);
        viewer.map_or(0.0, |viewer| TAU * viewer.mean(|o| table.sums(o).last().copied().unwrap_or(0.0)))
            as f32
    };
    let all: f32x8<S> = cos_o.to_array().map(of).simd_into(cos_o.token());
    V3 { x: all, y: all, z: all }
}
