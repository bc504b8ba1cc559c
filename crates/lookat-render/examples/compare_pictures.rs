//! Compares two pictures: mean errors, and where the largest difference is.
//!
//! ```text
//! cargo run --release -p lookat-render --example compare_pictures -- PICTURE EXPECTED
//! ```

use std::error::Error;
use std::path::Path;

use lookat_render::image::Image;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let files = arguments.next().zip(arguments.next()).ok_or("usage: compare_pictures PICTURE EXPECTED")?;
    let [picture, expected] = [&files.0, &files.1].map(|file| Image::read(Path::new(file)));
    let (picture, expected) = (picture?, expected?);
    if picture.data_window != expected.data_window {
        return Err("the pictures have different sizes".into());
    }
    let [a, b] = [&picture, &expected].map(|image| image.rgb().ok_or("a picture has no colors"));
    let (a, b) = (a?, b?);
    let errors = a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|channel| f64::from(a[channel] - b[channel])));
    let squares: Vec<f64> = errors.map(|error| error.iter().map(|x| x * x).sum::<f64>() / 3.0).collect();
    let worst = (0..squares.len()).max_by(|i, j| squares[*i].total_cmp(&squares[*j])).unwrap_or(0);
    let width = picture.data_window.width as usize;
    println!("root mean square error: {:.6}", (squares.iter().sum::<f64>() / squares.len() as f64).sqrt());
    println!(
        "largest difference: {:.6} at pixel {}, {}",
        squares[worst].sqrt(),
        worst % width,
        worst / width
    );
    Ok(())
}
