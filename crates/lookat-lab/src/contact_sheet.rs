//! All scenes of pbrt-scenes in one picture, and a list of what they show.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use lookat_image::{Encoded, Image};
use lookat_scene::Overrides;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use crate::pictures::{folder, render_plainly, says, scene};

/// What to run.
#[derive(Debug, Args)]
pub struct Options {
    /// Samples per pixel
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Where scenes.png and scenes.md go
    #[arg(short, long, default_value = "docs", value_name = "DIR")]
    output: PathBuf,
}

/// Pictures in a row.
const COLUMNS: usize = 6;
/// The largest width and height of a picture, and the height of its name, in pixels.
const CELL: [u32; 3] = [160, 120, 20];

/// A scene as the sheet shows it.
struct Shown {
    name: String,
    /// The first line of its file.
    says: String,
    size: [u32; 2],
    /// Red, green and blue, row by row.
    pixels: Vec<[u8; 3]>,
}

/// Renders the scenes, and writes both files.
pub fn run(options: &Options) {
    let shown: Vec<Shown> = names().iter().map(|name| show(name, options.spp)).collect();
    let list = list(&shown);
    std::fs::write(options.output.join("scenes.md"), list).expect("the list can be written");
    draw(&shown, &options.output.join("scenes.png")).expect("the sheet can be drawn");
    println!("{} scenes", shown.len());
}

/// All scenes, with their folders. Files that others include have no `WorldEnd`; the gallery has a page of its own.
fn names() -> Vec<String> {
    let mut folders = vec![folder()];
    let mut names = Vec::new();
    while let Some(inside) = folders.pop() {
        for entry in std::fs::read_dir(&inside).expect("pbrt-scenes can be read").flatten() {
            let path = entry.path();
            if path.ends_with("gallery") {
                continue;
            } else if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "pbrt") && is_whole(&path) {
                let name = path.strip_prefix(folder()).expect("it is inside").with_extension("");
                names.push(name.to_string_lossy().replace('\\', "/"));
            }
        }
    }
    // Those of the folder itself first.
    names.sort_by_key(|name| (name.contains('/'), name.clone()));
    names
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

fn is_whole(path: &Path) -> bool {
    text(path).lines().any(|line| line.starts_with("WorldEnd"))
}

/// Renders a scene to fit its cell.
fn show(name: &str, spp: u32) -> Shown {
    let size = scene(name, &Overrides::default(), &|text| text).view.film.resolution;
    let scale = (f64::from(CELL[0]) / f64::from(size[0])).min(f64::from(CELL[1]) / f64::from(size[1]));
    let resolution = size.map(|length| (f64::from(length) * scale).round().max(1.0) as u32);
    let overrides =
        Overrides { samples_per_pixel: Some(spp), resolution: Some(resolution), ..Overrides::default() };
    let image: Image = render_plainly(&scene(name, &overrides, &|text| text), 0, 0);
    let encoded = Encoded::from_linear(&image.rgb().expect("renders have colors"));
    let pixels = encoded.pixels.iter().map(|pixel| pixel.map(|x| (x * 255.0).round() as u8)).collect();
    let size = [image.data_window.width, image.data_window.height];
    Shown { name: name.to_owned(), says: says(name), size, pixels }
}

fn list(shown: &[Shown]) -> String {
    let mut text = String::from(
        "# Scenes\n\nTo see how to write a feature, open its scene. Each scene of `pbrt-scenes/` shows one part of the \
         format. Most have pbrt-v3's\nrender beside them (`.exr`), which the tests compare with.\n\n![All scenes](scenes.png)\n\n\
         `cargo run --release -p lookat-lab -- contact-sheet` writes this page.\n\n| scene | what it shows |\n|---|---|\n",
    );
    for Shown { name, says, .. } in shown {
        let _ = writeln!(text, "| [{name}](../pbrt-scenes/{name}.pbrt) | {says} |");
    }
    text
}

/// Draws the pictures row by row, each above its name.
fn draw(shown: &[Shown], file: &Path) -> Result<(), Box<dyn Error>> {
    register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular())
        .map_err(|_| "the font is damaged")?;
    let rows = shown.len().div_ceil(COLUMNS) as u32;
    let [width, height] = [CELL[0] + 8, CELL[1] + CELL[2] + 8];
    let size = [COLUMNS as u32 * width, rows * height];
    let mut sheet = vec![0xf4_u8; (size[0] * size[1] * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut sheet, (size[0], size[1])).into_drawing_area();
        area.fill(&RGBColor(0xf4, 0xf4, 0xf4))?;
        let style = ("sans-serif", 12).into_font().color(&BLACK).pos(Pos::new(HPos::Center, VPos::Bottom));
        for (number, picture) in shown.iter().enumerate() {
            let [x, y] = place(number).map(|corner| corner as i32);
            let at = (x + width as i32 / 2, y + height as i32 - 6);
            area.draw(&Text::new(picture.name.as_str(), at, style.clone()))?;
        }
        area.present()?;
    }
    for (number, picture) in shown.iter().enumerate() {
        paste(&mut sheet, size[0], place(number), picture);
    }
    let mut encoder = png::Encoder::new(std::fs::File::create(file)?, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    Ok(encoder.write_header()?.write_image_data(&sheet)?)
}

/// The corner of a cell.
fn place(number: usize) -> [u32; 2] {
    let (column, row) = ((number % COLUMNS) as u32, (number / COLUMNS) as u32);
    [column * (CELL[0] + 8), row * (CELL[1] + CELL[2] + 8)]
}

/// Copies a picture to the middle of its cell.
fn paste(sheet: &mut [u8], width: u32, [x, y]: [u32; 2], picture: &Shown) {
    let (x0, y0) = (
        x + 4 + (CELL[0] - picture.size[0].min(CELL[0])) / 2,
        y + 4 + (CELL[1] - picture.size[1].min(CELL[1])) / 2,
    );
    for (number, pixel) in picture.pixels.iter().enumerate() {
        let (column, row) = (number as u32 % picture.size[0], number as u32 / picture.size[0]);
        let at = ((y0 + row) * width + x0 + column) as usize * 3;
        sheet[at..at + 3].copy_from_slice(pixel);
    }
}
