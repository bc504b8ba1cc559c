//! Tests of alignment; and test pictures by formula, in operations that are exact or rounded once, so that any program makes the
//! same.

use super::*;

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

fn picture(window: Window) -> Image {
    let display = Window { x: 0, y: 0, width: 8, height: 8 };
    let (columns, rows) =
        (window.x..window.x + window.width as i32, window.y..window.y + window.height as i32);
    let pixels: Vec<[f32; 3]> =
        rows.flat_map(|y| columns.clone().map(move |x| [x as f32, y as f32, 0.0])).collect();
    Image::from_rgb(window, display, &pixels)
}

#[test]
fn pixels_keep_their_places() {
    let a = picture(Window { x: 0, y: 1, width: 5, height: 4 });
    let b = picture(Window { x: 2, y: -1, width: 6, height: 4 });
    let aligned = align(&a, &b).unwrap();
    assert_eq!(aligned.window, Window { x: 2, y: 1, width: 3, height: 2 });
    assert_eq!(aligned.left_out, 20 + 24 - 12);
    assert_eq!(aligned.actual, aligned.expected);
    assert_eq!(aligned.actual[4], [3.0, 2.0, 0.0]);
}

/// A .png of a crop window is held against an .exr file of it; but not an .exr file of the same size.
#[test]
fn a_picture_without_windows_is_taken_for_the_part_of_its_size() {
    let part = picture(Window { x: 2, y: 1, width: 3, height: 2 });
    let whole = Window { x: 0, y: 0, width: 3, height: 2 };
    let colors: Vec<[f32; 3]> = (0..6).map(|i| [2.0 + (i % 3) as f32, 1.0 + (i / 3) as f32, 0.0]).collect();
    let mut plain = Image::from_rgb(whole, whole, &colors);
    assert_eq!(align(&part, &plain).unwrap_err(), AlignError::Size([8, 8], [3, 2]));
    plain.has_windows = false;
    for (a, b) in [(&part, &plain), (&plain, &part)] {
        let aligned = align(a, b).unwrap();
        assert_eq!((aligned.window, aligned.left_out), (part.data_window, 0));
        assert_eq!(aligned.actual, aligned.expected);
        assert_eq!(aligned.is_placed, [!a.has_windows, !b.has_windows]);
    }
    let other = picture(Window { x: 2, y: 1, width: 4, height: 2 });
    assert_eq!(align(&other, &plain).unwrap_err(), AlignError::Size([8, 8], [3, 2]));
}

#[test]
fn pictures_that_do_not_belong_together_are_told_apart() {
    let a = picture(Window { x: 0, y: 0, width: 2, height: 2 });
    let b = picture(Window { x: 2, y: 0, width: 2, height: 2 });
    assert_eq!(align(&a, &b).unwrap_err(), AlignError::Apart);
    let mut c = a.clone();
    c.display_window.width = 9;
    assert_eq!(align(&a, &c).unwrap_err().to_string(), "the sizes differ: 8x8 and 9x8");
    let mut d = a.clone();
    d.channels.iter_mut().for_each(|channel| channel.name += "2");
    assert!(align(&d, &a).unwrap_err().to_string().contains("it has R2, G2, B2"));
    d.layers = vec!["albedo".into(), "N.X".into()];
    let error = align(&a, &d).unwrap_err().to_string();
    assert!(error.ends_with("neither the channels R, G and B nor Y: it has the layers albedo, N.X"));
}
