//! The scenes of pbrt-scenes/stability, whose pictures are known, and the command `lookat stability`.

use std::path::{Path, PathBuf};
use std::process::Command;

use lookat_image::Image;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes/stability")
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Renders a scene as users do.
fn picture(name: &str) -> Image {
    let directory = tempfile::tempdir().unwrap();
    let (scene, file) = (folder().join(name).with_extension("pbrt"), directory.path().join("a.exr"));
    let (status, _, err) = run(&["render", scene.to_str().unwrap(), "-q", "-o", file.to_str().unwrap()]);
    assert_eq!((status, err.as_str()), (0, ""), "{name}");
    Image::read(&file).unwrap()
}

/// The share of the white sky in each pixel, row by row.
fn sky(name: &str) -> Vec<Vec<f64>> {
    let image = picture(name);
    let width = image.data_window.width as usize;
    let pixels = image.rgb().unwrap();
    pixels.chunks(width).map(|row| row.iter().map(|pixel| f64::from(pixel[1])).collect()).collect()
}

fn black(rows: &[Vec<f64>]) -> f64 {
    rows.iter().flatten().map(|sky| 1.0 - sky).sum()
}

#[test]
fn no_hole_in_the_ground() {
    let rows = sky("horizon-quad");
    assert!(rows[..48].iter().flatten().all(|sky| *sky == 1.0));
    // A ten-thousandth of the first row is sky.
    assert!(rows[48].iter().all(|sky| *sky <= 1.0 / 64.0));
    assert!(rows[49..].iter().flatten().all(|sky| *sky == 0.0));
}

#[test]
fn the_horizon_of_a_planet_is_in_its_place() {
    let dip = (6.4e6_f64 / (6.4e6 + 1.7)).acos();
    let expected = 48.0 - 48.0 * dip.tan() / 0.1_f64.to_radians().tan();
    let found = black(&sky("horizon-planet")) / 96.0;
    assert!((found - expected).abs() < 0.01, "{found}, not {expected} rows");
}

#[test]
fn a_far_sphere_is_a_disk() {
    let rows = sky("silhouette");
    let radius = 48.0 * (1e-4_f64).asin().tan() / 0.01_f64.to_radians().tan();
    let found = (black(&rows) / std::f64::consts::PI).sqrt();
    assert!((found - radius).abs() < 0.01, "{found}, not {radius} pixels");
    // Round: the same in all directions.
    for (y, row) in rows.iter().enumerate() {
        for (x, sky) in row.iter().enumerate() {
            let distance = (x as f64 + 0.5 - 48.0).hypot(y as f64 + 0.5 - 48.0);
            assert!(
                (distance - radius).abs() < 0.75 || *sky == f64::from(u8::from(distance > radius)),
                "{x} {y}"
            );
        }
    }
}

#[test]
fn what_is_in_focus_is_sharp_far_from_the_origin() {
    for (y, row) in sky("in-focus").iter().enumerate() {
        for (x, sky) in row.iter().enumerate() {
            let inside = (20..60).contains(&x) && (20..60).contains(&y);
            assert_eq!(*sky, f64::from(u8::from(!inside)), "{x} {y}");
        }
    }
}

#[test]
fn a_small_triangle_far_away_is_seen() {
    let found = black(&sky("small-and-far"));
    assert!((found - 512.0).abs() < 1.0, "{found} pixels");
}

/// Moved or scaled, a scene gives the same picture, but for the last bit of single pixels.
#[test]
fn twins_are_alike() {
    let twin = picture("twin").rgb().unwrap();
    for name in ["twin-moved-1e6", "twin-moved-1e8", "twin-scaled-1e-6", "twin-scaled-1e6"] {
        let other = picture(name).rgb().unwrap();
        let pairs = || twin.as_flattened().iter().zip(other.as_flattened());
        let differing = pairs().filter(|(a, b)| a != b).count();
        assert!(differing * 1000 <= 3 * twin.len(), "{name}: {differing} values differ");
        assert!(pairs().all(|(a, b)| (a - b).abs() <= 4.0 * f32::EPSILON * a.abs()), "{name}");
    }
}

#[test]
fn all_cases_pass_and_are_written() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let (status, text, err) = run(&["stability", "--rays", "3000", "-o", out.to_str().unwrap()]);
    assert_eq!((status, err.as_str()), (0, ""), "{text}");
    let csv = std::fs::read_to_string(out.join("stability.csv")).unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("stability.json")).unwrap()).unwrap();
    for case in lookat_lab::stability::cases() {
        let verdict = if case.limit.is_finite() { "pass" } else { "measured" };
        assert!(text.contains(&format!("{} {}: {verdict}\n", case.id, case.name)), "{text}");
        assert!(csv.contains(&format!("\n{},{},\"lookat\",", case.id, case.name)));
        let found = json.as_array().unwrap().iter().find(|entry| entry["case"] == case.id).unwrap();
        assert!(
            found["passes"] == true && found["limit"].as_f64() == Some(case.limit).filter(|x| x.is_finite())
        );
    }
}

#[test]
fn cases_are_chosen_by_name() {
    let (status, out, _) = run(&["stability", "--case", "s9,up-parallel"]);
    assert_eq!(status, 0);
    assert!(
        out.contains("C7 up-parallel: pass") && out.contains("S9 ") && out.ends_with("2 of 2 cases pass\n"),
        "{out}"
    );
    let (status, out, err) = run(&["stability", "--case", "S77"]);
    assert!(
        status == 2
            && out.is_empty()
            && err.starts_with("error: unknown case `S77`; the cases are C1 tele, C2 "),
        "{err}"
    );
}
