//! Random numbers, directions and points.

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A number between two others.
pub(crate) fn between(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// A number in `0..n`.
pub(super) fn below(random: &mut Pcg64Mcg, n: usize) -> usize {
    ((random.random::<f64>() * n as f64) as usize).min(n - 1)
}

/// True with this probability.
pub(super) fn chance(random: &mut Pcg64Mcg, probability: f64) -> bool {
    random.random::<f64>() < probability
}

/// Ten to a power between two numbers.
pub(super) fn magnitude(random: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    10_f64.powf(between(random, low, high))
}

/// A uniform direction.
pub(crate) fn direction(random: &mut Pcg64Mcg) -> DVec3 {
    let z = between(random, -1.0, 1.0);
    let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// A point of the cube from -1 to 1.
pub(super) fn in_cube(random: &mut Pcg64Mcg) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| between(random, -1.0, 1.0)))
}

/// A point of a triangle.
pub(super) fn in_triangle(random: &mut Pcg64Mcg, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v) = (random.random::<f64>(), random.random::<f64>());
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    a + (b - a) * u + (c - a) * v
}

/// A direction on the side of the unit vector `n`. For three in ten, the cosine with `n` is between 10 to the powers of
/// `grazing`.
pub(super) fn leaving(random: &mut Pcg64Mcg, n: DVec3, grazing: [f64; 2]) -> DVec3 {
    let d = direction(random);
    let d = if d.dot(n) < 0.0 { -d } else { d };
    if !chance(random, 0.3) {
        return d;
    }
    let along = d - n * d.dot(n);
    let cos = magnitude(random, grazing[0], grazing[1]);
    (along.normalize_or(n.any_orthonormal_vector()) + n * cos).normalize()
}
