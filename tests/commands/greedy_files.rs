//! Small files that ask for much memory: each ends with a message, and never by a signal, a panic or the kernel.

use std::fs::File;
use std::io::{self, Read, Write};

use flate2::{Compression, write::ZlibEncoder};
use lookat_image::{Channel, Image, Window};

use super::{FINE, Folder, json_lines};

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

    /// A black JPEG picture: each block of 8 x 8 pixels is two zero bits.
    fn write_jpeg(&self, name: &str, width: u16, height: u16) {
        let ([w1, w0], [h1, h0]) = (width.to_be_bytes(), height.to_be_bytes());
        let table = |class: u8| {
            let counts = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
            [&[0xff, 0xc4, 0, 20, class][..], &counts, &[0]].concat()
        };
        let quantization = [&[0xff, 0xdb, 0, 67, 0][..], &[1; 64]].concat();
        let frame = [0xff, 0xc0, 0, 11, 8, h1, h0, w1, w0, 1, 1, 0x11, 0];
        let scan = [0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0];
        let blocks = usize::from(width.div_ceil(8)) * usize::from(height.div_ceil(8));
        let data = vec![0; blocks.div_ceil(4)];
        let start = [0xff, 0xd8];
        let parts = [&start[..], &quantization, &frame, &table(0), &table(0x10), &scan, &data, &[0xff, 0xd9]];
        std::fs::write(self.path(name), parts.concat()).unwrap();
    }

    /// A black EXR picture of one channel.
    fn write_exr(&self, name: &str, width: u32, height: u32) {
        let window = Window { x: 0, y: 0, width, height };
        let channel = Channel { name: "Y".into(), samples: vec![0.0; window.area() as usize] };
        let image = Image { channels: vec![channel], ..Image::from_rgb(window, window, &[]) };
        image.write(&self.path(name)).unwrap();
    }

    /// Pictures of 8000 pixels square, and others with one row less.
    fn write_large_pictures(&self) {
        for (name, height) in [("a", 8000_u32), ("b", 7999)] {
            self.write_png(&format!("{name}.png"), 8000, height);
            self.write_exr(&format!("{name}.exr"), 8000, height);
            self.write_jpeg(&format!("{name}.jpg"), 8000, height as u16);
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

const FORMATS: [&str; 6] = ["exr", "png", "jpg", "pfm", "hdr", "tga"];

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
            let expected = "comparing 8000 x 8000 pixels: 5.1 GB of memory are needed, and the limit is ";
            assert!(run.status == 2 && run.err.contains(expected), "{format}: {}", run.err);
        }
        let map = format!("Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"{name}\"\nShape");
        folder.write("texture.pbrt", &FINE.replacen("Shape", &map, 1));
        let run = folder.run_within("-v 300000", &["check", "texture.pbrt"]);
        // PFM and TGA files are too large themselves.
        let is_told = ["read", "use"].iter().any(|verb| run.err.contains(&format!("cannot {verb} {name}")))
            && run.err.contains("the limit is ");
        assert!(run.status == 1 && is_told, "{format}: {}", run.err);
    }
}

/// A color profile of 400 MB in a file of 2 x 2 pixels, and 1.5 GB before the end of a file of 8 x 8 pixels.
#[test]
fn decoders_take_no_more_than_the_limit() {
    let folder = Folder::new();
    let mut encoder = png::Encoder::new(File::create(folder.path("profile.png")).unwrap(), 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    let mut profile = ZlibEncoder::new(b"name\0\0".to_vec(), Compression::fast());
    io::copy(&mut io::repeat(0).take(400_000_000), &mut profile).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_chunk(png::chunk::iCCP, &profile.finish().unwrap()).unwrap();
    writer.write_image_data(&[0; 4]).unwrap();
    writer.finish().unwrap();
    folder.write_jpeg("long.jpg", 8, 8);
    let mut file = File::options().append(true).open(folder.path("long.jpg")).unwrap();
    file.set_len(1_500_000_000).unwrap();
    file.write_all(&[0xff, 0xd9]).unwrap();
    let run = |name| folder.run_within("-v 300000", &["compare", name, name]);
    // The decoder leaves out a profile that is too large.
    assert_eq!(run("profile.png").status, 0);
    let (long, expected) = (run("long.jpg"), "long.jpg: 1.5 GB of memory are needed, and the limit is ");
    assert!(long.status == 2 && long.err.contains(expected), "{}", long.err);
}

/// A texture is in memory in several forms one after the other: a limit that one of them fits is not enough.
#[test]
fn textures_end_with_a_message() {
    let folder = Folder::new();
    for side in (1000..3400).step_by(200) {
        folder.write_zeros("a.pfm", format!("PF\n{side} {side}\n-1\n").as_bytes(), 12 * side * side);
        let map = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"a.pfm\"\nShape";
        folder.write("texture.pbrt", &FINE.replacen("Shape", map, 1));
        let run = folder.run_within("-v 300000", &["check", "texture.pbrt"]);
        let is_told = run.status == 1 && run.err.contains("of memory are needed, and the limit is ");
        assert!(is_told || (side < 1800 && run.status == 0), "{side}: {} {}", run.status, run.err);
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
        ("nurbs", format!("Shape \"nurbs\" {square}").repeat(4000), "the scene is too large: "),
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
            let needed = ["rendering needs ", "of memory are needed, and the limit is "];
            let is_told = needed.iter().any(|words| run.err.contains(words));
            assert!(run.status == 1 && is_told, "{arguments:?}: {}", run.err);
        }
    }
    assert_eq!(folder.run_within("-v 600000", &["render", "fine.pbrt", "--threads", "2"]).status, 0);
}

/// 50,000 instances.
fn instances() -> String {
    // Side by side, so that rays miss most of them.
    let block = |at: u32| {
        format!("AttributeBegin Translate {} 0 {} ObjectInstance \"o\" AttributeEnd\n", at % 50, 3 * at)
    };
    let blocks: String = (0..50_000).map(block).collect();
    let world = format!("ObjectBegin \"o\" Shape \"sphere\" ObjectEnd {blocks}");
    FINE.replacen("Shape \"sphere\"", &world, 1)
}

#[test]
fn rendering_needs_what_inspect_says() {
    let folder = Folder::new();
    let points: String = (0..5_000).map(|at| format!("{} {} {at} ", at % 7, at % 5)).collect();
    let curve = format!("Shape \"curve\" \"string basis\" \"bspline\" \"point P\" [{points}]");
    folder.write("curve.pbrt", &FINE.replacen("Shape \"sphere\"", &curve, 1));
    folder.write("instances.pbrt", &instances());
    for file in ["curve.pbrt", "instances.pbrt"] {
        let needs = &json_lines(&folder.run(&["inspect", file, "--json"]))[0]["needs"];
        let bytes = needs["memory"]["render"].as_u64().unwrap();
        let render =
            |limit: u64| folder.run(&["render", file, "--force", "--max-memory", &limit.to_string()]);
        assert_eq!(render(bytes).status, 0, "{file}: {bytes}");
        let refused = render(bytes - 1);
        assert!(refused.status == 1 && refused.err.contains("error: rendering needs "), "{}", refused.err);
    }
}

/// What is left out after the limit may be most of the scene.
#[test]
fn keep_going_does_not_skip_the_end_of_a_scene() {
    let folder = Folder::new();
    folder.write("instances.pbrt", &instances());
    for command in ["render", "inspect", "check"] {
        let keep_going = if command == "check" { &[][..] } else { &["--keep-going"] };
        let limit = ["instances.pbrt", "--max-memory", "15M"];
        let run = folder.run(&[&[command], &limit[..], keep_going].concat());
        assert_eq!(run.status, 1, "{command}: {}", run.err);
        assert!(run.err.contains("up to here, it fills the memory limit, which is 15.0 MB"), "{}", run.err);
        assert!(
            !run.err.contains("use --keep-going") && !run.err.contains("ObjectInstance for"),
            "{}",
            run.err
        );
    }
    assert!(!folder.path("o.exr").exists());
}

#[test]
fn max_memory_is_a_size() {
    let folder = Folder::new();
    let run = folder.run(&["check", "fine.pbrt", "--max-memory", "2 G"]);
    let expected = "expected a size of at least 1M, as in 500M or 2G";
    assert!(run.status == 2 && run.err.contains(expected), "{}", run.err);
    assert_eq!(folder.run(&["check", "fine.pbrt", "--max-memory", "2G"]).status, 0);
}
