//! Lookups in a picture: `cargo bench -p lookat-image`.

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

#[divan::bench(args = [Wrap::Repeat, Wrap::Black, Wrap::Clamp])]
fn bilinear(bencher: Bencher, wrap: Wrap) {
    let map = map(wrap);
    means(bencher, |st| map.bilinear(st));
}
