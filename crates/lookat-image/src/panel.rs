//! Two pictures and their difference side by side, for people to look at.

mod canvas;
mod colors;
mod exposure;
mod layout;
mod parts;
mod scale;
mod text;

use std::ops::Range;
use std::path::Path;

use self::canvas::Canvas;
pub use self::colors::{DIFFERENCE_COLORS, NOT_FINITE_COLOR, difference_color};
pub use self::exposure::suitable_exposure;
pub(crate) use self::exposure::{MOSTLY, suitable};
use self::layout::Layout;
pub use self::parts::box_means;
pub use self::scale::difference_limit;
use self::scale::{ColorScale, Tick};
use self::text::Font;
use crate::error::Fault;
use crate::{Aligned, Format, ImageError, write_file};

const BACKGROUND: [u8; 3] = [255, 255, 255];
const FRAME: [u8; 3] = [140, 140, 140];
const TITLE: [u8; 3] = [0, 0, 0];
const TEXT: [u8; 3] = [90, 90, 90];

/// What a figure says and how it shows the pictures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PanelOptions {
    /// Whence the actual picture is, such as the name of its file. Cut if it is long; may be empty.
    pub actual: String,
    /// The same for the expected one.
    pub expected: String,
    /// Linear values are shown times 2 to this power, which must be finite. `None` chooses a whole number by
    /// the expected picture.
    pub exposure: Option<f64>,
}

/// Draws a figure of three parts side by side, and writes it as a PNG file: the expected picture, the
/// difference in false color with its scale, and the actual picture. Both pictures have the same exposure.
///
/// The difference is actual - expected in linear values, of the channel that differs most; it has
/// [`DIFFERENCE_COLORS`]. Pixels that are not finite have [`NOT_FINITE_COLOR`]. Small pictures are magnified
/// and large ones reduced, so that the file has at most about 4000 x 1500 pixels.
///
/// # Errors
///
/// [`ImageError::Write`] if the path does not end in `.png`, the pair has no pixels, or the file system
/// refuses. The file appears whole or not at all, and what was there before stays until then.
pub fn write_panel(pair: &Aligned, options: &PanelOptions, path: &Path) -> Result<(), ImageError> {
    let encode = || {
        if Format::from_path(path) != Some(Format::Png) {
            return Err(Fault::Unfit("the name of the figure must end in .png".into()));
        }
        if pair.window.area() == 0 {
            return Err(Fault::Unfit("the picture is empty".into()));
        }
        let bytes = png(&draw(pair, options)).map_err(|error| Fault::Unfit(error.to_string()))?;
        Ok(bytes)
    };
    let bytes = encode().map_err(|fault| ImageError::writing(path, fault))?;
    write_file(path, &bytes[..])
}

fn png(canvas: &Canvas) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, canvas.width as u32, canvas.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    // A tenth larger and five times as fast as the usual.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(canvas.pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

fn draw(pair: &Aligned, options: &PanelOptions) -> Canvas {
    let [width, height] = [pair.window.width, pair.window.height].map(|size| size as usize);
    let layout = Layout::of(width, height);
    let [full_width, full_height] = layout.size();
    let mut canvas = Canvas::new(full_width, full_height, BACKGROUND);
    let stops = options.exposure.unwrap_or_else(|| suitable_exposure(&pair.expected));
    let differences = parts::differences(&pair.actual, &pair.expected);
    let scale = ColorScale::of(&differences);

    let down = layout.zoom.down;
    let shown = |pixels| parts::shown(pixels, width, down, stops.exp2());
    let difference = parts::false_color(&differences, width, down, scale);
    draw_part(&mut canvas, &layout, 0, ["expected", &options.expected], &shown(&pair.expected));
    draw_part(&mut canvas, &layout, 1, ["difference", "actual - expected"], &difference);
    draw_part(&mut canvas, &layout, 2, ["actual", &options.actual], &shown(&pair.actual));

    draw_captions(&mut canvas, &layout, 0, stops, &pair.expected);
    draw_captions(&mut canvas, &layout, 2, stops, &pair.actual);
    match scale {
        Some(scale) => draw_scale(&mut canvas, &layout, scale),
        None => {
            let equal = if differences.iter().any(|x| x.is_nan()) { "equal where finite" } else { "equal" };
            layout.text.draw(&mut canvas, [layout.left(1), layout.line(0)], equal, TITLE);
        }
    }
    canvas
}

/// The picture, in a frame, and what is above it.
fn draw_part(canvas: &mut Canvas, layout: &Layout, part: usize, [title, name]: [&str; 2], picture: &Canvas) {
    let (x, y) = (layout.left(part), layout.margin());
    layout.title.draw(canvas, [x, y], title, TITLE);
    let name = layout.text.fit(name, layout.column);
    layout.text.draw(canvas, [x, y + layout.title.height()], &name, TEXT);
    let [width, height] = layout.picture;
    canvas.fill([x - 1, layout.top() - 1], [width + 2, height + 2], FRAME);
    canvas.paste([x, layout.top()], picture, layout.zoom.up);
}

/// What is below a picture.
fn draw_captions(canvas: &mut Canvas, layout: &Layout, part: usize, stops: f64, pixels: &[[f32; 3]]) {
    let mut place = [layout.left(part), layout.line(0)];
    for caption in [Some(exposure::caption(stops)), layout.zoom.caption()].into_iter().flatten() {
        layout.text.draw(canvas, place, &caption, TEXT);
        place[1] += layout.text.height();
    }
    let caption = match pixels.iter().filter(|pixel| !parts::is_finite(pixel)).count() {
        0 => return,
        1 => "1 pixel is not finite".to_string(),
        count => format!("{count} pixels are not finite"),
    };
    let side = layout.text.height() / 2;
    canvas.fill([place[0], place[1] + side / 2], [side; 2], NOT_FINITE_COLOR);
    place[0] += side * 3 / 2;
    layout.text.draw(canvas, place, &caption, TEXT);
}

/// The colors from end to end, and what they stand for.
fn draw_scale(canvas: &mut Canvas, layout: &Layout, scale: ColorScale) {
    let (left, top, font) = (layout.left(1), layout.line(0), layout.text);
    let last = layout.column - 1;
    let height = font.height() * 5 / 8;
    let row: Vec<_> = (0..=last).map(|x| difference_color(2.0 * x as f64 / last as f64 - 1.0)).collect();
    canvas.fill([left - 1, top - 1], [layout.column + 2, height + 2], FRAME);
    canvas.paste([left, top], &Canvas { width: layout.column, pixels: row.repeat(height) }, 1);

    let fits = |ticks: &Vec<Tick>| {
        let spans: Vec<_> = ticks.iter().map(|tick| span(tick, font, layout.column)).collect();
        spans.windows(2).all(|pair| pair[0].end + font.width("  ") <= pair[1].start)
    };
    for tick in Some(scale.ticks(5)).filter(fits).unwrap_or_else(|| scale.ticks(3)) {
        let x = left + (tick.place * last as f64).round() as usize;
        canvas.fill([x, top + height + 1], [1, font.height() / 4], TEXT);
        let text = left + span(&tick, font, layout.column).start;
        font.draw(canvas, [text, layout.line(1)], &tick.text, TEXT);
    }

    let note = match layout.zoom.down {
        1 => "largest of 3 channels".to_string(),
        down => format!("largest of 3 channels, {down} x {down} pixels"),
    };
    font.draw(canvas, [left, layout.line(2)], &font.fit(&note, layout.column), TEXT);
}

/// The columns of the text of a tick: about its place, but within the bar.
fn span(tick: &Tick, font: Font, bar: usize) -> Range<usize> {
    let width = font.width(&tick.text);
    let start = (tick.place * bar as f64 - width as f64 / 2.0).max(0.0) as usize;
    let start = start.min(bar.saturating_sub(width));
    start..start + width
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Precision, Window};

    fn pair(width: u32, height: u32, pixel: impl Fn(usize) -> [[f32; 3]; 2]) -> Aligned {
        let window = Window { x: 3, y: -2, width, height };
        let (actual, expected) = (0..window.area() as usize).map(|i| pixel(i).into()).unzip();
        Aligned {
            window,
            actual,
            expected,
            actual_errors: None,
            expected_errors: None,
            precision: Precision::Single,
            left_out: 0,
            is_placed: [false; 2],
        }
    }

    /// The colors of the pixels of a pair in a part of its figure.
    fn part(pair: &Aligned, options: &PanelOptions, part: usize) -> Vec<[u8; 3]> {
        let width = pair.window.width as usize;
        let layout = Layout::of(width, pair.window.height as usize);
        let canvas = draw(pair, options);
        let up = layout.zoom.up;
        let color = |i: usize| {
            let (x, y) = (layout.left(part) + i % width * up, layout.top() + i / width * up);
            canvas.pixels[y * canvas.width + x]
        };
        (0..pair.actual.len()).map(color).collect()
    }

    #[test]
    fn each_pixel_has_its_color_in_each_part() {
        let values = |i| match i {
            0 => [[0.5; 3], [0.5; 3]],
            1 => [[0.25, 0.5, 0.6], [0.25, 1.5, 0.1]],
            2 => [[0.5, 0.5, 1.0], [0.5, 0.5, 0.0]],
            3 => [[0.5, f32::NAN, 0.5], [0.5; 3]],
            4 => [[0.5; 3], [f32::INFINITY, 0.5, 0.5]],
            _ => [[1.0, 0.5, 0.0], [0.5, 0.5, 0.0]],
        };
        let pair = pair(3, 2, values);
        let options = PanelOptions { exposure: Some(-1.0), ..Default::default() };
        let [end, center, start] = [32, 16, 0].map(|i| DIFFERENCE_COLORS[i]);
        let not = NOT_FINITE_COLOR;
        assert_eq!(part(&pair, &options, 1), [center, start, end, not, not, DIFFERENCE_COLORS[24]]);
        // Half of each value: 0.25 is 137 in sRGB, 0.5 is 188.
        let gray = [137; 3];
        let actual = [gray, [99, 137, 149], [137, 137, 188], not, gray, [188, 137, 0]];
        assert_eq!(part(&pair, &options, 2), actual);
        let expected = [gray, [99, 225, 63], [137, 137, 0], gray, not, [137, 137, 0]];
        assert_eq!(part(&pair, &options, 0), expected);
    }

    #[test]
    fn the_exposure_is_chosen_once_by_the_expected_picture() {
        let pair = pair(4, 4, |i| [[if i == 5 { 200.0 } else { 50.0 }; 3], [100.0; 3]]);
        let shown = |share: usize| part(&pair, &PanelOptions::default(), share);
        // -7 stops: 0.78125 and 0.390625.
        assert_eq!(shown(0), [[229; 3]; 16]);
        assert_eq!((shown(2)[0], shown(2)[5]), ([168; 3], [255; 3]));
    }

    #[test]
    fn values_beyond_the_scale_have_the_colors_of_its_ends() {
        let pair =
            pair(32, 32, |i| [[[0.01, -0.01, 500.0, -700.0][if i < 4 { i } else { i % 2 }]; 3], [0.0; 3]]);
        let [end, start] = [32, 0].map(|i| DIFFERENCE_COLORS[i]);
        assert_eq!(part(&pair, &PanelOptions::default(), 1)[..6], [end, start, end, start, end, start]);
    }

    /// Whether the line below the difference has a color of the scale.
    fn has_scale(pair: &Aligned) -> bool {
        let layout = Layout::of(pair.window.width as usize, pair.window.height as usize);
        let canvas = draw(pair, &PanelOptions::default());
        let start = layout.line(0) * canvas.width + layout.left(1);
        canvas.pixels[start] == DIFFERENCE_COLORS[0]
            && canvas.pixels[start + layout.column - 1] == DIFFERENCE_COLORS[32]
    }

    #[test]
    fn equal_pictures_need_no_scale() {
        assert!(has_scale(&pair(9, 9, |i| [[i as f32; 3], [1.0; 3]])));
        assert!(!has_scale(&pair(9, 9, |i| [[i as f32; 3]; 2])));
        assert!(!has_scale(&pair(9, 9, |i| [[f32::NAN, i as f32, 0.0]; 2])));
    }

    #[test]
    fn elongated_pictures_are_drawn() {
        let options = PanelOptions { actual: "x".repeat(10_000), ..Default::default() };
        for (width, height) in [(1, 50), (1, 5000), (5000, 1)] {
            let pair = pair(width, height, |_| [[1.25; 3], [1.0; 3]]);
            let canvas = draw(&pair, &options);
            let layout = Layout::of(width as usize, height as usize);
            assert_eq!([canvas.width, canvas.height()], layout.size());
            let (x, y) = (layout.left(1) + layout.picture[0] - 1, layout.top() + layout.picture[1] - 1);
            assert_eq!(canvas.pixels[y * canvas.width + x], difference_color(0.5), "{width} x {height}");
        }
    }

    #[test]
    fn a_png_file_is_written_or_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("figure.png");
        let options = PanelOptions { actual: "k\u{fc}che \u{1f600}.exr".into(), ..Default::default() };
        let pair = pair(2, 1, |i| [[i as f32; 3], [0.5; 3]]);
        write_panel(&pair, &options, &path).unwrap();
        let decoded = ::image::open(&path).unwrap().to_rgb8();
        let canvas = draw(&pair, &options);
        assert_eq!(decoded.dimensions(), (canvas.width as u32, canvas.height() as u32));
        assert_eq!(decoded.as_raw(), canvas.pixels.as_flattened());

        let other = directory.path().join("figure.exr");
        let error = write_panel(&pair, &options, &other).unwrap_err().to_string();
        assert!(error.ends_with("the name of the figure must end in .png"), "{error}");
        let none = directory.path().join("none").join("figure.png");
        let error = write_panel(&pair, &options, &none).unwrap_err().to_string();
        assert!(
            error.starts_with("cannot write ") && error.ends_with("there is no such file or folder"),
            "{error}"
        );
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }
}
