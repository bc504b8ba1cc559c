//! Small files that ask for much memory: each ends with a message, and never by a signal, a panic or the kernel.

use std::fs::File;
use std::io::Write;

use super::{FINE, Folder};

impl Folder {
    /// A file that begins with `head` and goes on with zeros, which take no room on the disk.
    fn write_zeros(&self, name: &str, head: &[u8], zeros: u64) {
        let mut file = File::create(self.path(name)).unwrap();
        file.write_all(head).unwrap();
        file.set_len(head.len() as u64 + zeros).unwrap();
    }

    /// A black picture of one bit for each pixel.
    fn write_png(&self, name: &str, width: u32, height: u32) {
        let mut encoder = png::Encoder::new(File::create(self.path(name)).unwrap(), width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::One);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&vec![0; width.div_ceil(8) as usize * height as usize]).unwrap();
    }

    /// Pictures of 8000 pixels square, and others with one row less.
    fn write_large_pictures(&self) {
        for (name, height) in [("a", 8000_u32), ("b", 7999)] {
            self.write_png(&format!("{name}.png"), 8000, height);
            let pixels = 8000 * u64::from(height);
            let head = format!("PF\n8000 {height}\n-1\n");
            self.write_zeros(&format!("{name}.pfm"), head.as_bytes(), 12 * pixels);
            let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X 8000\n");
            self.write_zeros(&format!("{name}.hdr"), head.as_bytes(), 4 * pixels);
            let [low, high] = (height as u16).to_le_bytes();
            let head = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40, 0x1f, low, high, 24, 0];
            self.write_zeros(&format!("{name}.tga"), &head, 3 * pixels);
        }
    }
}

const FORMATS: [&str; 4] = ["png", "pfm", "hdr", "tga"];

#[test]
fn sizes_of_pictures_are_compared_before_pixels_are_read() {
    let folder = Folder::new();
    folder.write_large_pictures();
    for format in FORMATS {
        let names = ["a", "b"].map(|name| format!("{name}.{format}"));
        let run = folder.run_within("-v 300000", &["compare", &names[0], &names[1]]);
        let expected = "the sizes differ: 8000x8000 and 8000x7999";
        assert!(run.status == 2 && run.err.contains(expected), "{format}: {}", run.err);
    }
}

#[test]
fn pictures_that_do_not_fit_are_not_read() {
    let folder = Folder::new();
    folder.write_large_pictures();
    for format in FORMATS {
        let name = format!("a.{format}");
        for run in [
            folder.run_within("-v 300000", &["compare", &name, &name]),
            folder.run(&["compare", "--max-memory", "230.4M", &name, &name]),
        ] {
            let expected =
                "comparing 8000 x 8000 pixels: 5.1 GB of memory are needed, and --max-memory allows ";
            assert!(run.status == 2 && run.err.contains(expected), "{format}: {}", run.err);
        }
        let map = format!("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"{name}\"\nShape");
        folder.write("texture.pbrt", &FINE.replacen("Shape", &map, 1));
        let run = folder.run_within("-v 300000", &["check", "texture.pbrt"]);
        // PFM and TGA files are too large themselves.
        let is_told =
            run.err.contains(&format!("cannot read {name}")) && run.err.contains("--max-memory allows ");
        assert!(run.status == 1 && is_told, "{format}: {}", run.err);
    }
}

#[test]
fn shapes_that_do_not_fit_are_not_made() {
    let folder = Folder::new();
    let triangle = "\"integer indices\" [0 1 2] \"point P\" [0 0 0  1 0 0  0 1 0]";
    let square = "\"integer nu\" 2 \"integer nv\" 2 \"integer uorder\" 2 \"integer vorder\" 2
        \"float uknots\" [0 0 1 1] \"float vknots\" [0 0 1 1] \"point P\" [0 0 0 1 0 0 0 1 0 1 1 0]\n";
    let head =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 9000000\nproperty float x\nproperty float y
property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    folder.write_zeros("zeros.ply", head, 9_000_000 * 12 + 1);
    let heights = "0 ".repeat(4_000_000);
    let (ones, empty, zeros) =
        ("\"float a\"1".repeat(2_000_000), "\"\"".repeat(6_000_000), "0 ".repeat(40_000_000));
    for (name, shapes, expected) in [
        (
            "loop",
            format!("Shape \"loopsubdiv\" \"integer nlevels\" 12 {triangle}"),
            "12 levels make 16777216 triangles from 1: 1.3 GB",
        ),
        ("nurbs", format!("Shape \"nurbs\" {square}").repeat(4000), "the nurbs is too large: "),
        (
            "heights",
            format!("Shape \"heightfield\" \"integer nu\" 2000 \"integer nv\" 2000 \"float Pz\" [{heights}]"),
            "the heightfield is too large: ",
        ),
        ("ply", "Shape \"plymesh\" \"string filename\" \"zeros.ply\"".into(), "the mesh is too large: "),
        ("directives", "Shape\"\"".repeat(1_000_000), "the scene is too large: "),
        ("params", format!("Shape \"sphere\" {ones}"), "the scene is too large: "),
        ("strings", format!("Shape \"sphere\" \"string a\" [{empty}]"), "the scene is too large: "),
        ("numbers", format!("Shape \"sphere\" \"float a\" [{zeros}]"), "the scene is too large: "),
    ] {
        let file = format!("{name}.pbrt");
        folder.write(&file, &FINE.replacen("Shape \"sphere\"", &shapes, 1));
        let run = folder.run_within("-v 300000", &["check", &file]);
        let end = &run.err[run.err.len().saturating_sub(2000)..];
        assert!(run.status == 1 && run.err.contains(expected), "{name}: {end}");
        assert!(run.err.contains(&format!("--> {file}:")), "{name} has no place: {end}");
    }
}

#[test]
fn what_is_made_of_the_scene_counts_too() {
    let folder = Folder::new();
    let points: String = (0..100_000).map(|at| format!("{} {} {at} ", at % 7, at % 5)).collect();
    let curve = format!("Shape \"curve\" \"string basis\" \"bspline\" \"point P\" [{points}]");
    folder.write("curve.pbrt", &FINE.replacen("Shape \"sphere\"", &curve, 1));
    let film = ["render", "fine.pbrt", "--resolution", "9000x9000"];
    let target = ["render", "fine.pbrt", "--resolution", "1000x1000", "--target-error", "0.1"];
    for arguments in [&["render", "curve.pbrt"][..], &["inspect", "curve.pbrt"], &film, &target] {
        for run in [
            folder.run_within("-v 300000", arguments),
            // Beyond the limits of the process, too.
            folder.run_within("-v 300000", &[arguments, &["--max-memory", "20G"]].concat()),
        ] {
            let expected = "of memory are needed, and --max-memory allows ";
            assert!(run.status == 2 && run.err.contains(expected), "{arguments:?}: {}", run.err);
        }
    }
    assert_eq!(folder.run_within("-v 600000", &["render", "fine.pbrt", "--threads", "2"]).status, 0);
}

#[test]
fn max_memory_is_a_size() {
    let folder = Folder::new();
    let run = folder.run(&["check", "fine.pbrt", "--max-memory", "2 G"]);
    let expected = "expected a size of at least 1M, as in 500M or 2G";
    assert!(run.status == 2 && run.err.contains(expected), "{}", run.err);
    assert_eq!(folder.run(&["check", "fine.pbrt", "--max-memory", "2G"]).status, 0);
}
