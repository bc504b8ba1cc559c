//! Long lists of numbers: `cargo bench -p lookat-syntax`.

use std::fmt::Write;

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use lookat_syntax::{FileId, parse};

/// Numbers of a list.
const COUNT: u32 = 30_000;

fn main() {
    divan::main();
}

/// A shape with a list of so many numbers, each printed by `number`.
fn shape(name: &str, number: impl Fn(u32) -> String) -> String {
    let mut text = format!("Shape \"trianglemesh\" \"{name}\" [");
    for i in 0..COUNT {
        let _ = write!(text, "{} ", number(i));
    }
    text + "]"
}

fn parsed(bencher: Bencher, text: &str) {
    bencher.counter(BytesCount::of_str(text)).bench(|| parse(FileId(0), black_box(text.as_bytes())));
}

#[divan::bench]
fn indices(bencher: Bencher) {
    parsed(bencher, &shape("integer indices", |i| (i * 7 % 100_000).to_string()));
}

#[divan::bench]
fn decimals_of_7_digits(bencher: Bencher) {
    parsed(bencher, &shape("point P", |i| format!("{:.6}", f64::from(i).sin())));
}

#[divan::bench]
fn decimals_of_17_digits(bencher: Bencher) {
    parsed(bencher, &shape("point P", |i| f64::from(i).sin().to_string()));
}

#[divan::bench]
fn decimals_with_exponents(bencher: Bencher) {
    parsed(bencher, &shape("point P", |i| format!("{:e}", f64::from(i).sin() * 1e-9)));
}
