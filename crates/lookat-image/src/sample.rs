//! Test pictures by formula, in operations that are exact or rounded once, so that any program makes the same.

/// A pair of linear pictures.
pub(crate) struct Sample {
    pub(crate) actual: Vec<[f32; 3]>,
    pub(crate) expected: Vec<[f32; 3]>,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

/// Gradients, a disk, stripes and single bright pixels in mostly 0..1.2, and the same with noise and with the
/// disk moved by a pixel.
pub(crate) fn shown(width: usize, height: usize) -> Sample {
    let pixel = |x: usize, y: usize, shift: f32, noise: f32| -> [f32; 3] {
        let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let (dx, dy) = (u - 0.5 - shift / width as f32, v - 0.4);
        let base = match () {
            () if dx * dx + dy * dy < 0.04 => [0.9, 0.2 + 0.5 * u, 0.1],
            () if v > 0.8 => [[0.02, 0.7][x / 3 % 2]; 3],
            () if hash(x, y, 7).is_multiple_of(97) => [1.2, 1.1, 0.3],
            () => [u, 0.5 * v, 0.25 + 0.5 * u * v],
        };
        std::array::from_fn(|i| (base[i] + noise * unit(x, y, i)).max(0.0))
    };
    sample(width, height, |x, y| (pixel(x, y, 1.0, 0.08), pixel(x, y, 0.0, 0.0)))
}

/// Radiance over many orders of magnitude, and the same with noise in proportion and with fireflies.
pub(crate) fn radiance(width: usize, height: usize) -> Sample {
    let pixel = |x: usize, y: usize| -> [f32; 3] {
        let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let (dx, dy) = (u - 0.7, v - 0.3);
        let lamp = 0.05 / (dx * dx + dy * dy + 0.0005);
        let shade = if u + v < 0.6 { 0.01 } else { 0.6 };
        [shade * u + lamp, shade * v + 0.8 * lamp, shade * 0.3 + 0.5 * lamp]
    };
    sample(width, height, |x, y| {
        let expected = pixel(x, y);
        let factor = if hash(x, y, 11).is_multiple_of(499) { 40.0 } else { 1.0 };
        let actual = |i| (expected[i] * (1.0 + 0.5 * unit(x, y, i)) * factor).max(0.0);
        (std::array::from_fn(actual), expected)
    })
}

fn sample(width: usize, height: usize, pair: impl Fn(usize, usize) -> ([f32; 3], [f32; 3])) -> Sample {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let (actual, expected) = places.map(|(x, y)| pair(x, y)).unzip();
    Sample { actual, expected, width, height }
}

/// A multiple of 2^-22 in -1..1.
fn unit(x: usize, y: usize, i: usize) -> f32 {
    (hash(x, y, i) >> 9) as f32 / (1 << 22) as f32 - 1.0
}

fn hash(x: usize, y: usize, i: usize) -> u32 {
    let mut bits = x as u32 ^ (y as u32).wrapping_mul(0x9e37_79b9) ^ (i as u32).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
    bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}
