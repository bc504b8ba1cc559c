//! Means of a picture: `cargo bench -p lookat-image`.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{DVec2, Vec3};
use lookat_image::{MipMap, Wrap};

/// Texels on each side of the picture.
const SIDE: usize = 128;
/// Means of one call.
const PLACES: u32 = 4096;

fn main() {
    divan::main();
}

fn map(wrap: Wrap) -> MipMap<Vec3> {
    let texel =
        |i: usize| Vec3::new((i * 37 % 101) as f32, (i * 59 % 97) as f32, (i * 83 % 89) as f32) * 0.01;
    MipMap::new(SIDE, SIDE, (0..SIDE * SIDE).map(texel).collect(), wrap)
}

/// All over the picture and beyond its edges.
fn places() -> Vec<DVec2> {
    let fraction = |i: u32, step: f64| (f64::from(i) * step).fract() * 3.0 - 1.0;
    (0..PLACES).map(|i| DVec2::new(fraction(i, 0.618_034), fraction(i, 0.754_878))).collect()
}

fn means(bencher: Bencher, mean: impl Fn(DVec2) -> Vec3) {
    let places = places();
    bencher
        .counter(ItemsCount::new(places.len()))
        .bench_local(|| places.iter().map(|st| mean(black_box(*st))).sum::<Vec3>());
}

/// Over ellipses three times as long as wide. A width of less than a texel is a picture seen enlarged.
#[divan::bench(args = [0.5, 1.5, 6.0])]
fn ellipse(bencher: Bencher, width_in_texels: f64) {
    let map = map(Wrap::Repeat);
    let minor = DVec2::new(0.8, -0.6) * width_in_texels / SIDE as f64;
    means(bencher, |st| map.ewa(st, minor.perp() * 3.0, minor, 8.0));
}

#[divan::bench(args = [Wrap::Repeat, Wrap::Black, Wrap::Clamp])]
fn bilinear(bencher: Bencher, wrap: Wrap) {
    let map = map(wrap);
    means(bencher, |st| map.bilinear(st));
}
