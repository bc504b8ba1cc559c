//! `lookat compare`, as people and scripts meet it.

use std::path::{Path, PathBuf};
use std::process::Command;

use lookat_image::{Image, Window};
use serde_json::Value;
use tempfile::TempDir;

const WINDOW: Window = Window { x: 0, y: 0, width: 16, height: 12 };

/// A folder with a smooth picture, the same a little brighter, one with a fault, and a part of it.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        let smooth: Vec<[f32; 3]> = (0..192).map(|i| [i as f32 / 192.0, 0.25, 0.5]).collect();
        let brighter: Vec<[f32; 3]> = smooth.iter().map(|p| p.map(|x| x + 0.125)).collect();
        let mut broken = smooth.clone();
        broken[16 * 3 + 5][1] = f32::NAN;
        folder.write("smooth.exr", WINDOW, &smooth);
        folder.write("brighter.exr", WINDOW, &brighter);
        folder.write("broken.exr", WINDOW, &broken);
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
    assert_eq!(status(&["--max", "psnr=60"]), 1);
    assert_eq!(status(&["--max", "ssim=0.5"]), 0);
    assert_eq!(
        folder.compare(&["smooth.exr", "brighter.exr", "--max", "error=0.12"]).0,
        1,
        "the sign is not a matter"
    );
    let (_, out, _) = folder.compare(&[&pair[..], &["--max", "mae=0.1", "--only", "mae,max"]].concat());
    assert_eq!(out.lines().count(), 2, "{out}");
    assert!(out.starts_with("mae             0.125000") && out.contains("<- beyond --max"), "{out}");
}

#[test]
fn json_says_the_same() {
    let folder = Folder::new();
    let (status, out, err) = folder.compare(&["brighter.exr", "smooth.exr", "--json", "--max", "rmse=0.1"]);
    assert_eq!((status, err.as_str()), (1, ""));
    let result: Value = serde_json::from_str(&out).unwrap();
    assert!((result["metrics"]["rmse"].as_f64().unwrap() - 0.125).abs() < 1e-9);
    assert_eq!(result["metrics"].as_object().unwrap().len(), 13);
    assert_eq!(result["beyond_max"][0], "rmse");
    assert_eq!(result["pixels"], 192);
}

/// Other programs let a difference that is only NaN pass.
#[test]
fn pixels_that_are_no_number_differ_from_everything() {
    let folder = Folder::new();
    for pair in [["broken.exr", "smooth.exr"], ["smooth.exr", "broken.exr"], ["broken.exr", "broken.exr"]] {
        let (status, out, _) = folder.compare(&pair);
        assert_eq!(status, 1);
        assert!(out.contains("broken.exr: 1 pixel is infinite or not a number; first at x 5, y 3"), "{out}");
        assert!(!out.contains("rmse"), "{out}");
    }
}

#[test]
fn parts_are_compared_where_they_lie() {
    let folder = Folder::new();
    let (status, out, _) = folder.compare(&["part.exr", "smooth.exr", "--max", "max=0"]);
    assert_eq!(status, 0, "{out}");
    assert!(out.starts_with("160 pixels that only one of the pictures has are left out"), "{out}");
}

#[test]
fn what_cannot_be_compared_is_trouble() {
    let folder = Folder::new();
    let other = Window { width: 8, ..WINDOW };
    Image::from_rgb(other, other, &[[0.0; 3]; 96]).write(&folder.path("other.exr")).unwrap();
    let bytes = std::fs::read(folder.path("smooth.exr")).unwrap();
    std::fs::write(folder.path("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    std::fs::write(folder.path("text.exr"), "not a picture").unwrap();
    for (name, message) in [
        ("other.exr", "the sizes differ: 8x12 and 16x12"),
        ("cut.exr", "cut.exr is damaged"),
        ("text.exr", "text.exr is not what its ending says"),
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
