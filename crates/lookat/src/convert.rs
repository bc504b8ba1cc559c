//! `lookat convert`: writes a picture in another format.

use std::path::Path;
use std::process::ExitCode;

use lookat_image::{Format, Image, ImageError, MemoryBudget, PictureFile, Placement, Window};
use lookat_render::FilmSums;
use lookat_scene::PixelBounds;
use serde_json::Value;

use crate::args::{Convert, Writing, crop_edges, way_out};
use crate::failure::Failure;
use crate::light::{map_tones, note_linear};
use crate::output::{check_inputs, check_output, check_replaced, write_result};
use crate::part::PartMetadata;
use crate::source::{open_layer, several_channels};

/// Runs the command.
pub fn convert(arguments: &Convert) -> ExitCode {
    crate::exit_code(run(arguments).map(|()| 0))
}

fn run(arguments: &Convert) -> Result<(), Failure> {
    let Convert { input, output, writing, .. } = arguments;
    let Writing { tone, force, quiet, memory } = *writing;
    if input == Path::new("-") {
        bail!("convert does not read standard input: give the name of a file");
    }
    let edges = crop_edges(arguments.crop.as_deref())?;
    let told = |error: ImageError| error.to_string();
    let memory = &memory.budget();
    let file = match &arguments.layer {
        Some(layer) => open_layer(input, layer, memory),
        None => PictureFile::open(input, memory),
    };
    let file = file.map_err(told)?;
    let window = match edges {
        Some(edges) => cropped(file.placement(), edges)?,
        None => file.placement().data_window,
    };
    check_output(output, window.size())?;
    check_inputs(output, [input])?;
    if !force {
        check_replaced(output, window.size(), file.metadata().as_deref().and_then(samples_per_pixel))?;
    }
    if !quiet {
        note_linear(output, tone);
    }
    let (mut image, _charge) = file.read().map_err(told)?;
    drop_sums(&mut image);
    let _copy = charge_copy(&image, memory)?;
    crop(&mut image, window);
    let light = map_tones(&mut image, output, tone);
    if light.is_none() && Format::from_path(output) != Some(Format::Exr) {
        return Err(several_channels(input, &image, arguments.layer.as_deref()).into());
    }
    write_result(output, |path| image.write(path))?;
    if !quiet {
        let Window { width, height, .. } = window;
        say!("{}: {width} x {height} pixels", output.display());
        // Other layers are no light.
        light.filter(|_| arguments.layer.is_none()).inspect(|light| light.print(output, true));
    }
    Ok(())
}

/// The samples per pixel in the metadata of a picture that lookat rendered.
fn samples_per_pixel(metadata: &str) -> Option<f64> {
    serde_json::from_str::<Value>(metadata).ok()?.get("samples_per_pixel")?.as_f64()
}

/// Charges a copy of the picture, which cropping and writing take.
fn charge_copy(image: &Image, memory: &MemoryBudget) -> Result<lookat_image::Charge, Failure> {
    let Window { width, height, .. } = image.data_window;
    let refused = |shortage| format!("converting {width} x {height} pixels: {}", way_out(shortage));
    Ok(memory.reserve(image.bytes()).map_err(refused)?)
}

/// The part of the data window in the given part of the display window.
fn cropped(placement: Placement, edges: [f64; 4]) -> Result<Window, Failure> {
    let Placement { data_window: data, display_window: full, .. } = placement;
    let bounds = PixelBounds::of_fractions(edges, full.size());
    let (width, height) = (bounds.width(), bounds.height());
    let (x, y) = (full.x.saturating_add_unsigned(bounds.x0), full.y.saturating_add_unsigned(bounds.y0));
    data.intersection(Window { x, y, width, height }).ok_or_else(|| {
        let Window { width, height, .. } = full;
        format!("the crop window contains no pixel of {width} x {height}").into()
    })
}

/// Makes a picture of a part: as float, sums are of no use.
fn drop_sums(image: &mut Image) {
    let part = image.metadata.as_deref().and_then(|text| serde_json::from_str::<PartMetadata>(text).ok());
    if let Some(part) = part {
        image.channels.retain(|channel| !FilmSums::is_channel(&channel.name));
        image.metadata = part.of_picture();
    }
}

/// Leaves the pixels of a window inside the data window.
fn crop(image: &mut Image, window: Window) {
    for channel in &mut image.channels {
        channel.samples = image.data_window.cut(std::mem::take(&mut channel.samples), window);
    }
    image.data_window = window;
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Window = Window { x: 0, y: 0, width: 8, height: 4 };
    const DATA: Window = Window { x: 2, y: 1, width: 4, height: 3 };

    #[test]
    fn fractions_are_of_the_full_picture() {
        let check = |data_window, edges, expected: Result<[i64; 4], &str>| {
            let placement = Placement { data_window, display_window: FULL, has_windows: true };
            let found = cropped(placement, edges);
            let sides = |Window { x, y, width, height }| [x.into(), y.into(), width.into(), height.into()];
            assert_eq!(found.map(sides), expected.map_err(Failure::from));
        };
        check(FULL, [0.25, 0.75, 0.5, 1.0], Ok([2, 2, 4, 2]));
        check(DATA, [0.0, 0.5, 0.0, 0.5], Ok([2, 1, 2, 1]));
        check(DATA, [0.0, 1.0, 0.0, 1.0], Ok([2, 1, 4, 3]));
        check(DATA, [0.75, 1.0, 0.0, 1.0], Err("the crop window contains no pixel of 8 x 4"));
        check(FULL, [0.01, 0.02, 0.0, 1.0], Err("the crop window contains no pixel of 8 x 4"));
    }

    #[test]
    fn pixels_stay_in_their_places() {
        let pixels: Vec<[f32; 3]> = (0..12_u8).map(|i| [f32::from(i); 3]).collect();
        let mut image = Image::from_rgb(DATA, FULL, &pixels);
        crop(&mut image, Window { x: 3, y: 2, width: 2, height: 2 });
        assert_eq!(image.channels[1].samples, [5.0, 6.0, 9.0, 10.0]);
        assert_eq!((image.data_window.x, image.display_window), (3, FULL));
    }
}
