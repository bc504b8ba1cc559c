//! The promise of `--max-memory`, measured.

use std::process::Command;

use lookat_image::{Image, PixelError, Window};
use nix::sys::resource::{UsageWho, getrusage};

use crate::folder::Folder;

/// What the program takes besides its arrays: its code, its threads, and what the allocator keeps.
const PROGRAM: i64 = 25_000_000;

/// The greatest memory so far, in bytes: of any run, or of this process.
fn peak(who: UsageWho) -> i64 {
    1024 * getrusage(who).unwrap().max_rss()
}

/// Noise with known errors.
fn picture(side: u32, seed: u32) -> Image {
    let window = Window { x: 0, y: 0, width: side, height: side };
    let value = |at: u32| (at.wrapping_mul(2_654_435_761).wrapping_add(seed) >> 8) as f32 * 1e-8;
    let pixels: Vec<[f32; 3]> =
        (0..side * side).map(|at| [value(at), value(at + 1), value(at + 2)]).collect();
    let mut image = Image::from_rgb(window, window, &pixels);
    let error = PixelError { standard_error: [0.1; 3], samples: 64, replicates: 8, ..PixelError::default() };
    image.add_errors(&vec![error; pixels.len()]);
    image
}

fn scene(side: u32, world: &str) -> String {
    format!(
        "Film \"image\" \"integer xresolution\" {side} \"integer yresolution\" {side} \"string filename\" \"o.exr\"
Camera \"perspective\" Integrator \"path\" Sampler \"sobol\" \"integer pixelsamples\" 2
WorldBegin LightSource \"infinite\" {world} WorldEnd"
    )
}

/// The system tells the greatest memory of all children of a process, so these runs have a process without other tests.
#[test]
fn no_run_takes_more_than_its_limit() {
    let test = ["--exact", "memory::runs_within_limits", "--ignored"];
    let run = Command::new(std::env::current_exe().unwrap()).args(test).output().unwrap();
    let out = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && out.contains("1 passed"), "{out}");
}

/// Each command runs with growing limits until one is enough. The limits only grow, so that the greatest memory of all
/// runs so far is within the last.
#[test]
#[ignore = "it needs a process of its own, which the test above starts"]
fn runs_within_limits() {
    let folder = Folder::empty();
    for (name, seed) in [("a", 1), ("b", 2)] {
        let mut image = picture(800, seed);
        image.write(&folder.path(&format!("{name}.exr"))).unwrap();
        image.channels.truncate(3);
        image.write(&folder.path(&format!("{name}.png"))).unwrap();
    }
    let texture = "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"a.png\"
        Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
    let points: String = (0..20_000).map(|at| format!("{} {} {at} ", at % 7, at % 5)).collect();
    std::fs::create_dir(folder.path("scenes")).unwrap();
    let blocks: String = (0..50_000)
        .map(|at| format!("AttributeBegin Translate {} 0 {at} ObjectInstance \"o\" AttributeEnd\n", at % 50))
        .collect();
    for (name, text) in [
        ("instances", scene(10, &format!("ObjectBegin \"o\" Shape \"sphere\" ObjectEnd {blocks}"))),
        ("plain", scene(1200, "Shape \"sphere\"")),
        ("texture", scene(10, texture)),
        ("curve", scene(10, &format!("Shape \"curve\" \"string basis\" \"bspline\" \"point P\" [{points}]"))),
        (
            "heights",
            scene(
                10,
                &format!(
                    "Shape \"heightfield\" \"integer nu\" 600 \"integer nv\" 600 \"float Pz\" [{}]",
                    "0 ".repeat(360_000)
                ),
            ),
        ),
        ("scenes/noise", scene(800, "")),
    ] {
        folder.write(&format!("{name}.pbrt"), &text);
    }
    std::fs::copy(folder.path("a.exr"), folder.path("scenes/noise.exr")).unwrap();
    let mut commands = vec![
        "render plain.pbrt --force",
        "render plain.pbrt --error-layers --force",
        "render plain.pbrt --adaptive --spp 8 --force",
        "render texture.pbrt --force",
        "render curve.pbrt --force",
        "render heights.pbrt --force",
        "inspect heights.pbrt",
        "check instances.pbrt",
        "render instances.pbrt --force",
        "check texture.pbrt",
        "compare a.exr b.exr",
        "compare a.png b.png",
        "compare a.exr b.png --picture both.png",
        "convert a.exr c.exr --force",
        "convert a.exr c.png --force --exposure auto --tone aces",
        "convert a.png c.pfm --force",
        "verify scenes --max noise-p=0.01 --report report.html",
    ];
    let mut limit = 10_000_000;
    while !commands.is_empty() {
        assert!(limit < 2_000_000_000, "{commands:?} fail for all limits");
        commands.retain(|command| {
            let option = limit.to_string();
            let words: Vec<&str> = command.split(' ').chain(["--max-memory", &option]).collect();
            let run = folder.run(&words);
            let taken = peak(UsageWho::RUSAGE_CHILDREN);
            // Before a run begins, the memory of this process counts as its own.
            let most = (limit + PROGRAM).max(peak(UsageWho::RUSAGE_SELF));
            assert!(taken <= most, "{command} takes {taken} with a limit of {limit}");
            let short = ["of memory are needed", "for BVHs and lights", "it fills the memory limit"];
            let is_short = [&run.err, &run.out].iter().any(|text| short.iter().any(|it| text.contains(it)));
            // 1 is a difference.
            assert!(is_short || run.status < 2, "{command}: {}", run.err);
            is_short
        });
        limit += limit / 4;
    }
}

/// Directives are dropped when they are resolved: blocks without shapes and materials take hardly more than their text.
#[test]
fn blocks_take_little_memory() {
    let folder = Folder::empty();
    let block = "AttributeBegin Translate 0 0 1 ReverseOrientation ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] AttributeEnd\n";
    let world = block.repeat(50_000) + "Shape \"sphere\"";
    folder.write("blocks.pbrt", &scene(10, &world));
    let run = folder.run(&["check", "blocks.pbrt", "--max-memory", "25M"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(!run.err.contains("not closed"), "{}", run.err);
    let refused = folder.run(&["check", "blocks.pbrt", "--max-memory", "12M"]);
    assert_eq!(refused.status, 1, "{}", refused.err);
    assert!(refused.err.contains("the scene is too large"), "{}", refused.err);
    // The text after the limit may close the block.
    assert!(!refused.err.contains("not closed"), "{}", refused.err);
}
