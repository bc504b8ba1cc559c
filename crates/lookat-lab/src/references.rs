//! The scenes of pbrt-scenes against the references beside them, in two plain figures.

use clap::Args;
use lookat_image::{Image, Window};
use lookat_scene::Overrides;

use crate::pictures::{folder, names, render_plainly, scene};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// Samples per pixel
    #[arg(long, default_value_t = 256)]
    spp: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// Pixels on a side of a block.
const BLOCK: usize = 8;

/// Prints the table.
pub fn run(options: &Options) {
    println!("Against the references, {} samples per pixel", options.spp);
    println!("| scene | mean | 8x8 blocks, 95th percentile |");
    println!("|---|---|---|");
    let overrides = Overrides { samples_per_pixel: Some(options.spp), ..Overrides::default() };
    for name in names() {
        let Ok(expected) = Image::read(&folder().join(&name).with_extension("exr")) else { continue };
        let actual = render_plainly(&scene(&name, &overrides, &|text| text), options.seed, 0);
        assert_eq!(actual.data_window, expected.data_window, "{name}");
        let [mean, block] = differences(&actual, &expected);
        println!("| {name} | {mean:+.3} % | {block:.3} % |");
    }
}

/// The relative difference of the means, and the 95th percentile of that of the blocks, both in percent.
fn differences(actual: &Image, expected: &Image) -> [f64; 2] {
    let [a, b] = [actual, expected].map(|image| image.rgb().expect("renders and references have colors"));
    let Window { width, height, .. } = expected.data_window;
    let (width, height) = (width as usize, height as usize);
    let starts = |size: usize| (0..size).step_by(BLOCK);
    let blocks = starts(height).flat_map(|y| starts(width).map(move |x| [x, y]));
    let mut of_blocks: Vec<f64> = blocks
        .map(|[x0, y0]| {
            let rows = y0..(y0 + BLOCK).min(height);
            let places = rows.flat_map(|y| (x0..(x0 + BLOCK).min(width)).map(move |x| y * width + x));
            relative(&a, &b, places).abs()
        })
        .collect();
    of_blocks.sort_by(f64::total_cmp);
    [relative(&a, &b, 0..a.len()), of_blocks[of_blocks.len() * 95 / 100]]
}

/// The relative difference of the means over some pixels, in percent. Two black ones are alike.
fn relative(a: &[[f32; 3]], b: &[[f32; 3]], places: impl Iterator<Item = usize>) -> f64 {
    let sum = |pixel: [f32; 3]| pixel.iter().map(|value| f64::from(*value)).sum::<f64>();
    let (a, b) = places.fold((0.0, 0.0), |sums, at| (sums.0 + sum(a[at]), sums.1 + sum(b[at])));
    if a == b { 0.0 } else { 100.0 * (a - b) / b }
}
