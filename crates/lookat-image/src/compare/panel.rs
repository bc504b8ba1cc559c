//! Two pictures and their difference side by side, for people to look at.

mod canvas;
pub(crate) mod false_color;

use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use self::canvas::{Canvas, Font};
use self::false_color::{
    ColorScale, NOT_FINITE_COLOR, Tick, box_means, difference_color, differences, false_color,
};
use super::display::{Encoded, is_finite, suitable_exposure};
use crate::{Aligned, Format, ImageError, ImageFault, rgb_png, write_file};

const BACKGROUND: [u8; 3] = [255, 255, 255];
const FRAME: [u8; 3] = [140, 140, 140];
const TITLE: [u8; 3] = [0, 0, 0];
const TEXT: [u8; 3] = [90, 90, 90];

/// The captions and the exposure of a figure.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PanelOptions {
    /// The source of the actual picture, such as its file name. Shortened if it is long; may be empty.
    pub actual: String,
    /// The source of the expected picture.
    pub expected: String,
    /// The exposure of both pictures in stops, finite. `None` chooses the exposure that suits the expected picture.
    pub exposure: Option<f64>,
}

/// Draws a figure of three parts side by side, and writes it as a PNG file: the expected picture, the
/// difference in false color with its scale, and the actual picture. Both pictures have the same exposure.
///
/// The difference is actual - expected in linear values, of the channel that differs most; it has
/// [`DIFFERENCE_COLORS`](crate::DIFFERENCE_COLORS). Pixels that are not finite have [`NOT_FINITE_COLOR`]. Small pictures are magnified
/// and large ones reduced, so that the file has at most about 4000 x 1500 pixels.
///
/// # Errors
///
/// [`ImageFault::Refused`] if the path does not end in `.png`, the pair has no pixels, or the file system
/// refuses. The file appears whole or not at all, and what was there before stays until then.
pub fn write_panel(pair: &Aligned, options: &PanelOptions, path: &Path) -> Result<(), ImageError> {
    let refused = |reason: &str| Err(ImageError::writing(path, ImageFault::Refused(reason.into())));
    if Format::from_path(path) != Some(Format::Png) {
        return refused("the name of the figure must end in .png");
    }
    if pair.window.area() == 0 {
        return refused("the picture is empty");
    }
    let Canvas { width, pixels } = draw(pair, options);
    let bytes = rgb_png(width, pixels.as_flattened()).map_err(|error| ImageError::writing(path, error))?;
    write_file(path, &bytes[..])
}

fn draw(pair: &Aligned, options: &PanelOptions) -> Canvas {
    let [width, height] = [pair.window.width, pair.window.height].map(|size| size as usize);
    let layout = Layout::of(width, height);
    let [full_width, full_height] = layout.size();
    let mut canvas = Canvas::new(full_width, full_height, BACKGROUND);
    let stops = options.exposure.unwrap_or_else(|| suitable_exposure(&pair.expected));
    let differences = differences(&pair.actual, &pair.expected);
    let scale = ColorScale::of(&differences);

    let down = layout.zoom.down;
    let shown = |pixels| shown(pixels, width, down, stops.exp2());
    let difference = false_color(&differences, width, down, scale);
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

/// Draws a picture in a frame, and the lines above it.
fn draw_part(canvas: &mut Canvas, layout: &Layout, part: usize, [title, name]: [&str; 2], picture: &Canvas) {
    let (x, y) = (layout.left(part), layout.margin());
    layout.title.draw(canvas, [x, y], title, TITLE);
    let name = layout.text.fit(name, layout.column);
    layout.text.draw(canvas, [x, y + layout.title.height()], &name, TEXT);
    let [width, height] = layout.picture;
    canvas.fill([x - 1, layout.top() - 1], [width + 2, height + 2], FRAME);
    canvas.paste([x, layout.top()], picture, layout.zoom.up);
}

/// Draws the lines below a picture.
fn draw_captions(canvas: &mut Canvas, layout: &Layout, part: usize, stops: f64, pixels: &[[f32; 3]]) {
    let mut place = [layout.left(part), layout.line(0)];
    for caption in [Some(exposure_caption(stops)), layout.zoom.caption()].into_iter().flatten() {
        layout.text.draw(canvas, place, &caption, TEXT);
        place[1] += layout.text.height();
    }
    let caption = match pixels.iter().filter(|pixel| !is_finite(pixel)).count() {
        0 => return,
        1 => "1 pixel is not finite".to_string(),
        count => format!("{count} pixels are not finite"),
    };
    let side = layout.text.height() / 2;
    canvas.fill([place[0], place[1] + side / 2], [side; 2], NOT_FINITE_COLOR);
    place[0] += side * 3 / 2;
    layout.text.draw(canvas, place, &caption, TEXT);
}

/// Draws the color scale with its ticks.
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
        let x = left + (tick.position * last as f64).round() as usize;
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
    let start = (tick.position * bar as f64 - width as f64 / 2.0).max(0.0) as usize;
    let start = start.min(bar.saturating_sub(width));
    start..start + width
}

/// The exposure in words.
fn exposure_caption(stops: f64) -> String {
    match stops {
        0.0 => "exposure 0".into(),
        stops if stops.abs() == 1.0 => format!("exposure {stops:+} stop"),
        stops => format!("exposure {stops:+} stops"),
    }
}

/// A picture as a display shows it, times `gain`. A box of `down` x `down` pixels becomes their mean.
fn shown(pixels: &[[f32; 3]], width: usize, down: usize, gain: f64) -> Canvas {
    let means = box_means(pixels, width, down);
    let linear: Vec<[f32; 3]> =
        means.par_iter().map(|mean| mean.map(|x| (gain * f64::from(x)) as f32)).collect();
    let color = |(mean, encoded): (&[f32; 3], &[f32; 3])| {
        if is_finite(mean) { encoded.map(|x| (255.0 * x).round() as u8) } else { NOT_FINITE_COLOR }
    };
    let encoded = Encoded::from_linear(&linear).pixels;
    Canvas { width: width.div_ceil(down), pixels: means.par_iter().zip(&encoded).map(color).collect() }
}

/// The layout of a figure, in pixels. A part is a picture and the lines above and below it. Parts count from 0, from the left.
#[derive(Debug)]
struct Layout {
    zoom: Zoom,
    /// The displayed size of a picture.
    picture: [usize; 2],
    /// The width of a part, at least that of its picture.
    column: usize,
    title: Font,
    text: Font,
}

impl Layout {
    fn of(width: usize, height: usize) -> Layout {
        let zoom = Zoom::of(width, height);
        let picture = [width, height].map(|size| size.div_ceil(zoom.down) * zoom.up);
        let column = picture[0].max(LEAST);
        // A wide figure is made smaller to fit a page, and its letters too.
        let (title, text) = match column {
            0..480 => (20, 16),
            480..900 => (24, 20),
            _ => (32, 24),
        };
        Layout { zoom, picture, column, title: Font(title), text: Font(text) }
    }

    /// The space around the figure and between parts.
    fn margin(&self) -> usize {
        self.text.height() * 5 / 4
    }

    /// The left edge of a part.
    fn left(&self, part: usize) -> usize {
        self.margin() + part * (self.column + self.margin())
    }

    /// The top of the pictures, below two lines.
    fn top(&self) -> usize {
        self.margin() + self.title.height() + self.text.height() * 3 / 2
    }

    /// The top of a line below the pictures.
    fn line(&self, line: usize) -> usize {
        self.top() + self.picture[1] + self.text.height() / 2 + line * self.text.height()
    }

    /// The width and height of the figure.
    fn size(&self) -> [usize; 2] {
        [self.left(3), self.line(3) + self.margin()]
    }
}

/// The smallest width of a part, to which pictures are magnified, and the largest width and height, in pixels.
const LEAST: usize = 256;
const MOST: usize = 1280;

/// The scale of a picture: each pixel becomes `up` x `up` ones, or `down` x `down` pixels become one. Both are at least 1, and
/// one of them is 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Zoom {
    up: usize,
    down: usize,
}

impl Zoom {
    fn of(width: usize, height: usize) -> Zoom {
        let longer = width.max(height);
        let up = LEAST.div_ceil(width).min(MOST / longer).max(1);
        Zoom { up, down: longer.div_ceil(MOST) }
    }

    /// The scale in words; `None` at the original size.
    fn caption(self) -> Option<String> {
        match self {
            Zoom { up: 1, down: 1 } => None,
            Zoom { up: 1, down } => Some(format!("reduced to 1/{down}")),
            Zoom { up, .. } => Some(format!("magnified {up} times")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::false_color::DIFFERENCE_COLORS;
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
            assert_eq!([canvas.width, (canvas.pixels.len() / canvas.width)], layout.size());
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
        assert_eq!(decoded.dimensions(), (canvas.width as u32, (canvas.pixels.len() / canvas.width) as u32));
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

    #[test]
    fn no_figure_is_too_small_or_too_large() {
        let most = Layout::of(1280, 1280).size();
        assert_eq!(most, [3960, 1492]);
        let sizes =
            [(1, 1), (8, 6), (1281, 3), (1, 5000), (5000, 1), (1 << 28, 1), (1, 1 << 28), (16_384, 16_384)];
        for (width, height) in sizes {
            let size = Layout::of(width, height).size();
            assert!(
                size[0] >= 800 && size[0] <= most[0] && size[1] <= most[1],
                "{width} x {height}: {size:?}"
            );
        }
    }

    #[test]
    fn parts_are_side_by_side() {
        let layout = Layout::of(100, 50);
        assert_eq!((layout.picture, layout.column), ([300, 150], 300));
        assert_eq!([0, 1, 2].map(|part| layout.left(part)), [20, 340, 660]);
        assert_eq!(layout.size(), [980, 64 + 150 + 8 + 3 * 16 + 20]);
        // A narrow picture leaves room for the text.
        assert_eq!((Layout::of(1, 5000).picture, Layout::of(1, 5000).column), ([1, 1250], 256));
    }

    #[test]
    fn pictures_get_a_handy_size() {
        let check = |width, height, up, down| {
            assert_eq!(Zoom::of(width, height), Zoom { up, down }, "{width} x {height}");
        };
        check(8, 6, 32, 1);
        check(100, 80, 3, 1);
        check(256, 1, 1, 1);
        check(255, 100, 2, 1);
        check(1280, 1280, 1, 1);
        check(1281, 700, 1, 2);
        check(1920, 1080, 1, 2);
        check(3840, 2160, 1, 3);
        check(40, 600, 2, 1);
        check(1, 5000, 1, 4);
        check(1 << 28, 1, 1, 209_716);
        let captions =
            [(8, 6), (300, 200), (4000, 20)].map(|(width, height)| Zoom::of(width, height).caption());
        assert_eq!(captions, [Some("magnified 32 times".into()), None, Some("reduced to 1/4".into())]);
    }

    #[test]
    fn reduced_pictures_are_means_of_light() {
        // 3 x 3 pixels in boxes of 2 x 2: the last column and row make boxes of their own.
        let mut pixels = [[0.0; 3]; 9];
        pixels[0] = [1.0, 0.5, 4.0];
        pixels[2] = [1.0; 3];
        pixels[8] = [f32::INFINITY, 0.0, 0.0];
        let shown = shown(&pixels, 3, 2, 2.0);
        assert_eq!(shown.width, 2);
        // 0.5, 0.25, 2; 1; 0.
        assert_eq!(shown.pixels, [[188, 137, 255], [255; 3], [0; 3], NOT_FINITE_COLOR]);
    }

    #[test]
    fn captions_count_stops() {
        let captions = [0.0, 3.0, -1.0, 0.5].map(exposure_caption);
        assert_eq!(captions, ["exposure 0", "exposure +3 stops", "exposure -1 stop", "exposure +0.5 stops"]);
    }
}
