//! `lookat compare`, as people and scripts meet it.

use std::path::{Path, PathBuf};
use std::process::Command;

use lookat_image::{Image, PixelError, Window};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;
use tempfile::TempDir;

const WINDOW: Window = Window { x: 0, y: 0, width: 16, height: 12 };

fn smooth() -> Vec<[f32; 3]> {
    (0..192).map(|i| [i as f32 / 192.0, 0.25, 0.5]).collect()
}

/// A folder with a smooth picture, the same a little brighter, one with a fault, and a part of it.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        let smooth = smooth();
        let brighter: Vec<[f32; 3]> = smooth.iter().map(|p| p.map(|x| x + 0.125)).collect();
        folder.write("smooth.exr", WINDOW, &smooth);
        folder.write("brighter.exr", WINDOW, &brighter);
        folder.break_pixel(f32::NAN);
        let part: Vec<[f32; 3]> = (4..8).flat_map(|y| smooth[y * 16 + 2..y * 16 + 10].to_vec()).collect();
        folder.write("part.exr", Window { x: 2, y: 4, width: 8, height: 4 }, &part);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, window: Window, pixels: &[[f32; 3]]) {
        Image::from_rgb(window, WINDOW, pixels).write(&self.path(name)).unwrap();
    }

    /// Writes a picture with one value that is no number.
    fn break_pixel(&self, value: f32) {
        let mut broken = smooth();
        broken[16 * 3 + 5][1] = value;
        self.write("broken.exr", WINDOW, &broken);
    }

    /// Writes a smooth picture that is `more` brighter, with noise of 0.01, and that says so.
    fn write_noisy(&self, name: &str, seed: u64, more: f32) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        // A standard deviation of 1.
        let mut noise = || 3_f32.sqrt() * (2.0 * random.random::<f32>() - 1.0);
        let pixels: Vec<[f32; 3]> =
            smooth().iter().map(|pixel| pixel.map(|value| value + more + 0.01 * noise())).collect();
        let mut image = Image::from_rgb(WINDOW, WINDOW, &pixels);
        let error =
            PixelError { standard_error: [0.01; 3], samples: 64, replicates: 16, ..PixelError::default() };
        image.add_errors(&[error; 192]);
        image.write(&self.path(name)).unwrap();
    }

    /// Exit status, standard output, standard error.
    fn compare(&self, arguments: &[&str]) -> (i32, String, String) {
        let program = Path::new(env!("CARGO_BIN_EXE_lookat"));
        let output =
            Command::new(program).arg("compare").args(arguments).current_dir(self.0.path()).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }
}

#[test]
fn metrics_are_held_to_their_limits() {
    let folder = Folder::new();
    let pair = ["brighter.exr", "smooth.exr"];
    let status = |limits: &[&str]| folder.compare(&[&pair[..], limits].concat()).0;
    assert_eq!(status(&[]), 0);
    assert_eq!(status(&["--max", "rmse=0.13", "--max", "error=0.126"]), 0);
    assert_eq!(status(&["--max", "rmse=0.12"]), 1);
    assert_eq!(status(&["--max", "rmse=-1"]), 2);
    assert_eq!(status(&["--max", "psnr=60"]), 1);
    assert_eq!(status(&["--max", "ssim=0.5"]), 0);
    assert_eq!(
        folder.compare(&["smooth.exr", "brighter.exr", "--max", "error=0.12"]).0,
        1,
        "the sign is not a matter"
    );
    let (_, out, _) = folder.compare(&[&pair[..], &["--max", "mae=0.1", "--only", "mae,max"]].concat());
    assert_eq!(out.lines().count(), 2, "{out}");
    assert!(out.starts_with("mae             0.125000") && out.contains("<- exceeds --max"), "{out}");
    let (_, out, _) = folder.compare(&[&pair[..], &["--max", "psnr=60", "--only", "psnr"]].concat());
    assert!(out.contains("<- below the minimum") && !out.contains("exceeds"), "{out}");
}

#[test]
fn json_says_the_same() {
    let folder = Folder::new();
    let (status, out, err) = folder.compare(&["brighter.exr", "smooth.exr", "--json", "--max", "rmse=0.1"]);
    assert_eq!((status, err.as_str()), (1, ""));
    let result: Value = serde_json::from_str(&out).unwrap();
    assert!((result["metrics"]["rmse"].as_f64().unwrap() - 0.125).abs() < 1e-9);
    assert_eq!(result["metrics"].as_object().unwrap().len(), 13);
    assert!(result["noise"].is_null());
    assert_eq!(result["beyond_max"][0], "rmse");
    assert_eq!(result["pixels"], 192);
}

/// Other programs let a difference that is only NaN pass.
#[test]
fn pixels_that_are_no_number_differ_from_everything() {
    let folder = Folder::new();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        folder.break_pixel(value);
        for pair in [["broken.exr", "smooth.exr"], ["smooth.exr", "broken.exr"], ["broken.exr", "broken.exr"]]
        {
            let (status, out, _) = folder.compare(&pair);
            assert_eq!(status, 1);
            assert!(
                out.contains("broken.exr: 1 pixel is infinite or not a number; first at x 5, y 3"),
                "{out}"
            );
            assert!(!out.contains("rmse"), "{out}");
        }
    }
}

#[test]
fn parts_are_compared_where_they_lie() {
    let folder = Folder::new();
    let (status, out, _) = folder.compare(&["part.exr", "smooth.exr", "--max", "max=0"]);
    assert_eq!(status, 0, "{out}");
    assert!(out.starts_with("160 pixels are in only one of the pictures and are ignored"), "{out}");
}

#[test]
fn what_cannot_be_compared_is_trouble() {
    let folder = Folder::new();
    let other = Window { width: 8, ..WINDOW };
    Image::from_rgb(other, other, &[[0.0; 3]; 96]).write(&folder.path("other.exr")).unwrap();
    let bytes = std::fs::read(folder.path("smooth.exr")).unwrap();
    std::fs::write(folder.path("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(folder.path("text.exr"), "not a picture").unwrap();
    // The upper corner of the data window, as it stands in the file.
    let corner = bytes.windows(10).position(|part| part == b"dataWindow").unwrap() + 10 + 1 + 6 + 4 + 8;
    let mut huge = bytes.clone();
    huge[corner..corner + 8].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
    std::fs::write(folder.path("huge.exr"), huge).unwrap();
    let mut red = Image::from_rgb(WINDOW, WINDOW, &smooth());
    red.channels.truncate(1);
    red.write(&folder.path("red.exr")).unwrap();
    for (name, message) in [
        ("other.exr", "the sizes differ: 8x12 and 16x12"),
        ("cut.exr", "cut.exr is damaged"),
        ("text.exr", "text.exr is not in the EXR format"),
        ("huge.exr", "huge.exr is damaged"),
        (
            "red.exr",
            "the first picture has neither the channels R, G and B nor Y: it has the layers R; choose one with --layer",
        ),
        ("nothing.exr", "cannot read nothing.exr"),
        ("smooth.gif", "cannot read smooth.gif"),
    ] {
        let (status, out, err) = folder.compare(&[name, "smooth.exr"]);
        assert_eq!((status, out.as_str()), (2, ""), "{name}");
        assert!(err.contains(message), "{err}");
    }
    let (status, _, err) = folder.compare(&["smooth.exr", "smooth.exr", "--max", "rsme=1"]);
    assert!(status == 2 && err.contains("the metrics are error, mae, rmse"), "{err}");
}

#[test]
fn noise_is_told_from_bias() {
    let folder = Folder::new();
    folder.write_noisy("a.exr", 1, 0.0);
    folder.write_noisy("b.exr", 2, 0.001);
    folder.write_noisy("c.exr", 3, 0.01);
    let noise = |arguments: &[&str]| folder.compare(arguments);
    // The mean of 192 pixels is known to 0.01 * sqrt(2 / 192) = 0.001.
    let (status, out, _) = noise(&["a.exr", "b.exr", "--max", "noise-p=0.01"]);
    assert!(status == 0 && out.contains("noise           agree"), "{out}");
    let (status, out, _) = noise(&["a.exr", "c.exr", "--max", "noise-p=0.01"]);
    assert!(status == 1 && out.contains("noise           differ"), "{out}");
    assert!(out.contains("mean: ") && out.contains("standard error 1.0e-3"), "{out}");
    assert!(out.contains("tiles: 1 of 1 differ; worst at x 0, y 0"), "{out}");
    let (_, out, _) = noise(&["a.exr", "c.exr", "--json"]);
    let result: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(result["noise"]["agree"], false);
    assert_eq!(result["noise"]["p"], result["metrics"]["noise-p"]);
    // Without the layers it says so, and how to get them.
    let (status, out, _) = noise(&["a.exr", "smooth.exr"]);
    assert!(
        status == 0 && out.contains("the expected picture has no error layers: its noise is estimated"),
        "{out}"
    );
    let (status, out, _) = noise(&["smooth.exr", "a.exr"]);
    assert!(
        status == 0
            && out.contains(
                "cannot be distinguished from bias: the actual picture has no error layers; `lookat render"
            ),
        "{out}"
    );
    let (status, out, _) = noise(&["a.exr", "a.exr"]);
    assert!(status == 0 && out.contains("agree: the pictures are identical"), "{out}");
    let (status, _, err) = noise(&["smooth.exr", "a.exr", "--max", "noise-p=0.01"]);
    assert!(
        status == 2 && err.contains("there is no noise-p: the actual picture has no error layers"),
        "{err}"
    );
}

/// Bright pixels of a reference without error layers may be light that the render has missed.
#[test]
fn rare_light_is_undecided() {
    let folder = Folder::new();
    let window = Window { x: 0, y: 0, width: 64, height: 48 };
    let mut pixels = vec![[0.5; 3]; 64 * 48];
    let mut image = Image::from_rgb(window, window, &pixels);
    image.add_errors(
        &[PixelError { standard_error: [0.01; 3], samples: 64, replicates: 16, ..PixelError::default() };
            64 * 48],
    );
    image.write(&folder.path("flat.exr")).unwrap();
    let plain = pixels.clone();
    pixels[..16 * 64].iter_mut().step_by(67).for_each(|pixel| *pixel = [30.0; 3]);
    Image::from_rgb(window, window, &pixels).write(&folder.path("rare.exr")).unwrap();
    // A lamp of as many pixels that the render lacks is no rare light.
    let lamp = |i: usize| if i % 64 < 4 && i / 64 < 4 { [30.0; 3] } else { plain[i] };
    let pixels: Vec<_> = (0..plain.len()).map(lamp).collect();
    Image::from_rgb(window, window, &pixels).write(&folder.path("lamp.exr")).unwrap();
    let (status, out, _) = folder.compare(&["flat.exr", "lamp.exr", "--max", "noise-p=0.01"]);
    assert!(status == 1 && out.contains("noise           differ: "), "{out}");
    let noise = |more: &[&str]| folder.compare(&[&["flat.exr", "rare.exr"], more].concat());
    let (status, out, _) = noise(&["--max", "noise-p=0.01"]);
    assert!(status == 2 && out.contains("noise           undecided: only a few pixels"), "{out}");
    assert!(out.contains("noise only, tail index 0.") && !out.contains("exceeds --max"), "{out}");
    assert_eq!(noise(&[]).0, 0);
    assert_eq!(noise(&["--max", "noise-p=0.01", "--max", "max=1"]).0, 1);
    let (_, out, _) = noise(&["--json", "--max", "noise-p=0.01"]);
    let result: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&result["noise"]["agree"], &result["differs"]), (&Value::Null, &false.into()));
    assert!(result["noise"]["means"][0]["tail_index"].as_f64().unwrap() < 1.0);
    assert!(result["noise"]["p"].as_f64().unwrap() < 0.01, "{out}");
    assert!(result["noise"]["p_without_rare"].as_f64().unwrap() > 0.01, "{out}");
}

#[test]
fn the_picture_shows_both_and_their_difference() {
    let folder = Folder::new();
    let (status, _, err) = folder.compare(&["brighter.exr", "smooth.exr", "--picture", "out.png"]);
    assert_eq!((status, err.as_str()), (0, ""));
    let drawn = Image::read(&folder.path("out.png")).unwrap();
    assert!(drawn.data_window.width > 3 * 256, "{:?}", drawn.data_window);
    // Also where a pixel is no number, to show where.
    assert_eq!(folder.compare(&["broken.exr", "smooth.exr", "--picture", "broken.png"]).0, 1);
    let magenta = |pixel: &[f32; 3]| *pixel == [1.0, 0.0, 1.0];
    assert!(Image::read(&folder.path("broken.png")).unwrap().rgb().unwrap().iter().any(magenta));
    let (status, _, err) = folder.compare(&["brighter.exr", "smooth.exr", "--picture", "none/out.png"]);
    assert!(status == 2 && err.contains("none/out.png"), "{err}");
}

/// A layer of an EXR file, against another file's or a picture of its own.
#[test]
fn layers_are_chosen_by_name() {
    let folder = Folder::new();
    folder.write_noisy("a.exr", 1, 0.0);
    folder.write("error.exr", WINDOW, &[[0.01; 3]; 192]);
    Image::read(&folder.path("error.exr")).unwrap().write(&folder.path("error.pfm")).unwrap();
    let compare = |pair: [&str; 2], layer: &str| {
        folder.compare(&[&pair[..], &["--layer", layer, "--max", "max=0"]].concat())
    };
    assert_eq!(compare(["a.exr", "a.exr"], "stderr").0, 0);
    assert_eq!(compare(["a.exr", "error.pfm"], "stderr").0, 0);
    assert_eq!(compare(["a.exr", "error.pfm"], "stderr.G").0, 0);
    assert_eq!(compare(["a.exr", "error.pfm"], "count.samples").0, 1);
    let (status, _, err) = compare(["a.exr", "error.pfm"], "albedo");
    assert_eq!(status, 2);
    assert!(
        err.contains(
            "a.exr: it has no layer `albedo`; its layers are count.replicates, count.samples, stderr"
        ),
        "{err}"
    );
}

/// A file of integers cannot be as bright as the other picture: that is no fault of the render.
#[test]
fn clipped_pixels_are_told() {
    let folder = Folder::new();
    let mut bright = smooth();
    bright[3] = [0.5, 4.0, 0.5];
    for file in ["bright.png", "bright.exr"] {
        Image::from_rgb(WINDOW, WINDOW, &bright).write(&folder.path(file)).unwrap();
    }
    let (_, out, _) = folder.compare(&["bright.png", "bright.exr"]);
    assert!(out.contains("bright.png: 1 pixel is clipped at 1"), "{out}");
    let (_, out, _) = folder.compare(&["bright.png", "bright.png"]);
    assert!(!out.contains("clipped at 1"), "{out}");
}

/// Formats other than .exr hold the crop window alone.
#[test]
fn a_picture_of_a_crop_window_is_held_against_that_part() {
    let folder = Folder::new();
    let part = Window { x: 2, y: 1, width: 3, height: 2 };
    let image = Image::from_rgb(part, WINDOW, &[[0.5; 3]; 6]);
    image.write(&folder.path("crop.exr")).unwrap();
    image.write(&folder.path("crop.pfm")).unwrap();
    for pictures in [["crop.exr", "crop.pfm"], ["crop.pfm", "crop.exr"], ["crop.pfm", "crop.pfm"]] {
        let (status, out, err) = folder.compare(&[&pictures[..], &["--max", "max=0"]].concat());
        assert_eq!((status, err.as_str()), (0, ""), "{pictures:?} {out}");
        let is_told = out.starts_with("crop.pfm is compared with the 3 x 2 pixels that start at x 2, y 1\n");
        assert_eq!(is_told, pictures.contains(&"crop.exr"), "{out}");
    }
}

/// A limit that cannot be held to anything is not kept.
#[test]
fn limits_of_what_cannot_be_measured_are_trouble() {
    let folder = Folder::new();
    let tiny = Window { x: 0, y: 0, width: 8, height: 8 };
    Image::from_rgb(tiny, tiny, &[[0.5; 3]; 64]).write(&folder.path("tiny.exr")).unwrap();
    let (status, _, err) = folder.compare(&["tiny.exr", "tiny.exr", "--max", "ssim=0.9"]);
    assert!(status == 2 && err.contains("there is no ssim: the pictures are less than 11 pixels"), "{err}");
    let (status, out, _) = folder.compare(&["tiny.exr", "tiny.exr", "--only", "ssim"]);
    assert!(
        status == 0 && out.starts_with("there is no ssim: the pictures are less than 11 pixels"),
        "{out}"
    );
    // As a render leaves them that is interrupted early.
    let mut image = Image::from_rgb(WINDOW, WINDOW, &smooth());
    let error =
        PixelError { standard_error: [f32::INFINITY; 3], samples: 4, replicates: 1, ..PixelError::default() };
    let mut errors =
        [PixelError { standard_error: [0.1; 3], samples: 32, replicates: 16, ..PixelError::default() }; 192];
    errors[7] = error;
    image.add_errors(&errors);
    image.write(&folder.path("partial.exr")).unwrap();
    let (status, _, err) = folder.compare(&["partial.exr", "smooth.exr", "--max", "noise-p=0.01"]);
    assert!(
        status == 2
            && err.contains("there is no noise-p: the actual picture has pixels with fewer than 32 samples"),
        "{err}"
    );
    // Nor does a picture replace what it shows.
    let (status, _, err) = folder.compare(&["tiny.exr", "smooth.exr", "--picture", "./smooth.exr"]);
    assert_eq!(status, 2, "{err}");
    let before = std::fs::read(folder.path("smooth.exr")).unwrap();
    let (status, _, err) = folder.compare(&["brighter.exr", "smooth.exr", "--picture", "./smooth.exr"]);
    assert!(status == 2 && err.contains("cannot write ./smooth.exr: this file is an input"), "{err}");
    assert_eq!(std::fs::read(folder.path("smooth.exr")).unwrap(), before);
}
