//! Ray against quadrics of revolution as pbrt-v3 has it (PBR 3.4 to 3.6), without its error bounds, which only move hits.

use super::{Vector, along};

/// A surface x² + y² = a (z - s)² + b z + c, cut.
#[derive(Debug, Clone, Copy)]
pub(in crate::stability) struct Round {
    /// a, s, b, c.
    pub profile: [f64; 4],
    /// Lowest and highest z.
    pub heights: [f64; 2],
    /// The sweep of 270 degrees starts at x = `start[0]`, y = `start[1]` z.
    pub start: [f64; 2],
}

/// A disk of radius 1 around the origin with a hole of radius 0.25, swept by 270 degrees.
pub(in crate::stability) fn pbrt_v3_disk(o: Vector<f32>, d: Vector<f32>) -> Option<f32> {
    if d[2] == 0.0 {
        return None;
    }
    let t = -o[2] / d[2];
    let p = along(o, d, t);
    let squared = p[0] * p[0] + p[1] * p[1];
    (t > 0.0 && (0.25 * 0.25..=1.0).contains(&squared) && angle(p[1], p[0]) <= SWEEP).then_some(t)
}

const SWEEP: f32 = 1.5 * std::f32::consts::PI;

fn angle(y: f32, x: f32) -> f32 {
    let angle = y.atan2(x);
    if angle < 0.0 { angle + 2.0 * std::f32::consts::PI } else { angle }
}

/// Coefficients in `f32`, their discriminant in `f64`.
pub(in crate::stability) fn pbrt_v3(form: &Round, o: Vector<f32>, d: Vector<f32>) -> Option<f32> {
    let [k, shift, slope, offset] = form.profile.map(|x| x as f32);
    let z = o[2] - shift;
    let a = d[0] * d[0] + d[1] * d[1] - k * d[2] * d[2];
    let b = 2.0 * (d[0] * o[0] + d[1] * o[1] - k * d[2] * z) - slope * d[2];
    let c = o[0] * o[0] + o[1] * o[1] - k * z * z - slope * o[2] - offset;
    let discriminant = f64::from(b) * f64::from(b) - 4.0 * f64::from(a) * f64::from(c);
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt() as f32;
    let q = if b < 0.0 { -0.5 * (b - root) } else { -0.5 * (b + root) };
    let (x, y) = (q / a, c / q);
    let has = |t: &f32| {
        let p = along(o, d, *t);
        let start = [form.start[0] as f32, form.start[1] as f32 * p[2]];
        let [low, high] = form.heights.map(|x| x as f32);
        let angle = angle(start[0] * p[1] - p[0] * start[1], p[0] * start[0] + p[1] * start[1]);
        *t > 0.0 && p[2] >= low && p[2] <= high && angle <= SWEEP
    };
    [x.min(y), x.max(y)].into_iter().find(has)
}
