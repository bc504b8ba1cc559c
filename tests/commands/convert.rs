//! Pictures in other formats.

use super::*;

#[track_caller]
fn convert(folder: &Folder, arguments: &[&str]) -> Run {
    let run = folder.run(&[&["convert"], arguments].concat());
    assert_eq!(run.status, 0, "{arguments:?}: {}", run.err);
    run
}

#[test]
fn all_formats_are_read_and_written() {
    let folder = Folder::new();
    let image = folder.picture(&[]);
    let read = |name: &str| Image::read(&folder.path(name)).unwrap();
    // The same picture as the renderer writes, and the same light.
    for ending in ["exr", "pfm", "png", "tga"] {
        let (rendered, converted) = (format!("rendered.{ending}"), format!("converted.{ending}"));
        let light = |err: String| err.lines().filter(|line| line.starts_with("light: ")).collect::<String>();
        let said = light(folder.run(&["render", "fine.pbrt", "-o", &rendered]).err);
        let run = convert(&folder, &["picture.exr", &converted]);
        assert!(run.err.starts_with(&format!("{converted}: 32 x 24 pixels\n")), "{}", run.err);
        assert_eq!(light(run.err), said);
        assert!(read(&converted) == read(&rendered), "{ending}");
        // And on to linear values, which hold what the file holds.
        let back = format!("{ending}.exr");
        assert_eq!(convert(&folder, &[&converted, &back, "--quiet"]).err, "");
        assert!(read(&back).rgb() == read(&converted).rgb(), "{ending}");
    }
    assert_eq!(read("converted.exr").metadata, image.metadata);
    assert_eq!(read("png.exr").metadata, image.metadata);
    // These are only read, and say nothing of how they were made.
    let sky = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/diagnostics/departure/parts/sky.hdr");
    convert(&folder, &[sky.to_str().unwrap(), "sky.exr"]);
    assert!(read("sky.exr").rgb() == Image::read(&sky).unwrap().rgb());
}

#[test]
fn crop_windows_keep_their_place() {
    let folder = Folder::new();
    let window = ["--crop", ".25", ".75", ".5", "1"];
    let crop = folder.picture(&window);
    std::fs::rename(folder.path("picture.exr"), folder.path("crop.exr")).unwrap();
    folder.picture(&[]);
    convert(&folder, &[&["picture.exr", "a.exr"], &window[..]].concat());
    assert!(Image::read(&folder.path("a.exr")).unwrap() == crop);
    // The fractions are of the full picture also where a part is there alone.
    convert(&folder, &["crop.exr", "b.exr", "--crop", "0", ".5", "0", "1"]);
    let part = Image::read(&folder.path("b.exr")).unwrap();
    assert_eq!((part.data_window.x, part.data_window.width, part.data_window.y), (8, 8, 12));
    assert_eq!(part.display_window.width, 32);
    let run = folder.run(&["convert", "crop.exr", "c.exr", "--crop", "0", "1", "0", ".25"]);
    assert_eq!(run.err, "error: the crop window contains no pixel of 32 x 24\n");
}

#[test]
fn layers_are_chosen_by_name() {
    let folder = Folder::new();
    let image = folder.picture(&["--error-layers", "--spp", "16"]);
    let mut several = image.clone();
    for (channel, name) in several.channels.iter_mut().zip(["N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z"]) {
        channel.name = name.into();
    }
    several.channels.truncate(6);
    several.write(&folder.path("several.exr")).unwrap();
    let run = folder.run(&["convert", "several.exr", "a.png"]);
    assert_eq!(run.err, "error: several.exr has several layers; choose one with --layer: N, P\n");
    convert(&folder, &["several.exr", "a.exr", "--layer", "P"]);
    assert!(Image::read(&folder.path("a.exr")).unwrap().channel("R") == several.channel("P.X"));
    convert(&folder, &["several.exr", "a.png", "--layer", "N.Y", "--exposure", "auto"]);
    // All channels of a picture go into an EXR file.
    convert(&folder, &["picture.exr", "all.exr"]);
    assert!(Image::read(&folder.path("all.exr")).unwrap() == image);
    // The names of `render --layers`.
    let names = "depth,position,normal,shading-normal,uv,albedo,shape,material,samples";
    folder.picture(&["--layers", names]);
    let own = "Z P N Ns uv albedo shape material count.samples";
    for (name, own) in names.split(',').zip(own.split(' ')) {
        convert(&folder, &["picture.exr", "a.exr", "--layer", name, "--force"]);
        convert(&folder, &["picture.exr", "own.exr", "--layer", own, "--force"]);
        let read = |file: &str| std::fs::read(folder.path(file)).unwrap();
        assert!(read("a.exr") == read("own.exr"), "{name}");
        let run = folder.run(&["compare", "picture.exr", "picture.exr", "--layer", name, "--max", "max=0"]);
        assert!(run.status == 0 || name == "uv", "{name}: {}", run.err);
    }
    let run = folder.run(&["convert", "picture.exr", "b.exr", "--layer", "nothing"]);
    assert!(run.status == 2 && run.err.contains("it has no layer `nothing`"), "{}", run.err);
    let run = folder.run(&["convert", "a.png", "b.exr", "--layer", "nothing"]);
    assert!(run.status == 2 && run.err.contains("only EXR files have layers"), "{}", run.err);
}

/// What renders may replace, conversions may.
#[test]
fn finished_pictures_stay() {
    let folder = Folder::new();
    folder.picture(&["--spp", "8"]);
    convert(&folder, &["picture.exr", "a.png"]);
    convert(&folder, &["picture.exr", "a.png", "--exposure", "1"]);
    folder.picture(&["--spp", "4"]);
    let run = folder.run(&["convert", "picture.exr", "a.png"]);
    let message = "error: a.png is not replaced: it has 8 samples per pixel, and the new picture 4; replace it with --force, or choose another name\n";
    assert_eq!((run.status, run.err.as_str()), (2, message));
    convert(&folder, &["picture.exr", "a.png", "--force"]);
    convert(&folder, &["picture.exr", "a.pfm"]);
    assert_eq!(folder.run(&["convert", "picture.exr", "a.pfm"]).status, 2);
}

#[test]
fn what_cannot_be_converted_leaves_nothing_behind() {
    let folder = Folder::new();
    folder.picture(&[]);
    folder.write("a.exr", "a diary");
    let before = folder.names();
    for (arguments, message) in [
        (&["none.exr", "b.png"][..], "cannot read none.exr: there is no such file or folder"),
        (&["a.exr", "b.png"], "a.exr is not in the EXR format"),
        (&["fine.pbrt", "b.png"], "lookat reads exr, pfm, png, tga, jpg and hdr"),
        (&["-", "b.png"], "convert does not read standard input"),
        (&["picture.exr", "b.jpg"], "lookat writes exr, png, pfm and tga"),
        (&["picture.exr", "none/b.png"], "there is no folder none"),
        (&["picture.exr", "./picture.exr"], "this file is an input; choose another name"),
        (&["picture.exr", "b.png", "--crop", "1", "0", "0", "1"], "--crop takes the left, right, top"),
        (&["picture.exr"], "<OUT>"),
    ] {
        let run = folder.run(&[&["convert"], arguments].concat());
        assert!(run.status == 2 && run.err.contains(message), "{arguments:?}: {}", run.err);
        assert_eq!(folder.names(), before);
    }
    let wide = lookat_image::Window { x: 0, y: 0, width: 1000, height: 1000 };
    Image::from_rgb(wide, wide, &vec![[0.5; 3]; 1_000_000]).write(&folder.path("wide.exr")).unwrap();
    let run = folder.run(&["convert", "wide.exr", "b.png", "--max-memory", "20M"]);
    assert!(run.status == 2 && run.err.contains("raise --max-memory"), "{}", run.err);
    assert!(!folder.path("b.png").exists());
}
