//! Layers of a picture.

use lookat_image::{MemoryBudget, PictureFile};

use super::*;

const ALL: &str = "depth,position,normal,shading-normal,uv,albedo,shape,material,samples";

/// A named material on the ground, and the default one on a sphere.
fn scene(folder: &Folder) {
    let ground = "MakeNamedMaterial \"red\" \"string type\" \"mirror\"\nNamedMaterial \"red\"\nTranslate 0 -1 0\nRotate 90 1 0 0\nShape \"disk\" \"float radius\" 2";
    folder.write("two.pbrt", &FINE.replace("WorldEnd", &format!("{ground}\nWorldEnd")));
}

#[test]
fn layers_are_written_and_read_back() {
    let folder = Folder::new();
    scene(&folder);
    let render = |threads: &str| {
        let run = folder.run(&[
            "render",
            "two.pbrt",
            "--layers",
            ALL,
            "--threads",
            threads,
            "-o",
            "a.exr",
            "--json",
        ]);
        assert_eq!(run.status, 0, "{}", run.err);
        (std::fs::read(folder.path("a.exr")).unwrap(), serde_json::from_str::<Value>(&run.out).unwrap())
    };
    let (bytes, json) = render("1");
    assert_eq!(render("3").0, bytes);
    let read = |layer: &str| {
        let file = PictureFile::open_layer(&folder.path("a.exr"), layer, &MemoryBudget::default());
        file.unwrap().read().unwrap().0
    };
    let middle = 32 * 12 + 16;
    let [depth, samples] = ["Z", "count.samples"].map(|layer| read(layer).channel("Y").unwrap()[middle]);
    assert!((depth - 3.0).abs() < 0.01 && samples == 4.0, "{depth} {samples}");
    let [p, n, albedo] = ["P", "N", "albedo"].map(|layer| read(layer).rgb().unwrap()[middle]);
    assert!((p[2] + 1.0).abs() < 0.01 && (n[2] + 1.0).abs() < 0.01 && albedo == [0.5; 3], "{p:?} {n:?}");
    assert!(read("uv").channel("V").is_some());
    let found = |layer: &str, number: f32| read(layer).channel("Y").unwrap().contains(&number);
    assert!(["shape", "material"].iter().all(|layer| found(layer, 1.0) && found(layer, 2.0)));
    // Colors are those without layers.
    let plain = folder.run(&["render", "two.pbrt", "-o", "b.exr"]);
    assert_eq!(plain.status, 0);
    assert!(
        Image::read(&folder.path("a.exr")).unwrap().rgb()
            == Image::read(&folder.path("b.exr")).unwrap().rgb()
    );
    let run = folder.run(&["compare", "a.exr", "a.exr", "--layer", "Z", "--max", "mae=0"]);
    assert_eq!(run.status, 0, "{}", run.err);

    // Two numbers are no picture.
    for arguments in [
        &["compare", "a.exr", "a.exr", "--layer", "uv"][..],
        &["convert", "a.exr", "uv.png", "--layer", "uv"],
    ] {
        let run = folder.run(arguments);
        let expected = "error: a.exr: layer uv has several channels; choose one with --layer: uv.U, uv.V\n";
        assert_eq!((run.status, &run.err[..]), (2, expected));
    }
    assert_eq!(folder.run(&["convert", "a.exr", "uv.png", "--layer", "uv.U"]).status, 0);
    assert_eq!(folder.run(&["convert", "a.exr", "uv.exr", "--layer", "uv"]).status, 0);

    // What the numbers stand for.
    let expected = serde_json::json!([
        { "number": 1, "type": "sphere", "file": "two.pbrt", "line": 9, "column": 7 },
        { "number": 2, "type": "disk", "file": "two.pbrt", "line": 14, "column": 7 },
    ]);
    assert_eq!(json["picture"]["shapes"], expected);
    let expected = serde_json::json!([
        { "number": 1, "type": "matte" },
        { "number": 2, "type": "mirror", "name": "red", "file": "two.pbrt", "line": 10, "column": 39 },
    ]);
    assert_eq!(json["picture"]["materials"], expected);
    let metadata: Value = serde_json::from_str(&read("Z").metadata.unwrap()).unwrap();
    assert_eq!(metadata["materials"], expected);
}

#[test]
fn layers_that_cannot_be_are_refused() {
    let folder = Folder::new();
    for (arguments, message) in [
        (
            ["--layers", "depth", "-o", "a.png"],
            "a.png: only an .exr file can store layers; choose one with -o",
        ),
        (
            ["--layers", "depths", "-o", "a.exr"],
            "the layers are depth, position, normal, shading-normal, uv, albedo, shape, material, samples, denoise",
        ),
    ] {
        let run = folder.run(&[&["render", "fine.pbrt"], &arguments[..]].concat());
        assert!(run.status == 2 && run.err.contains(message), "{}", run.err);
    }
    let run = folder.run(&["render", "fine.pbrt", "--layers", "denoise", "--layers", "depth", "-o", "a.exr"]);
    assert_eq!(run.status, 0, "{}", run.err);
    let image = Image::read(&folder.path("a.exr")).unwrap();
    let names: Vec<&str> = image.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["B", "G", "Ns.X", "Ns.Y", "Ns.Z", "R", "Z", "albedo.B", "albedo.G", "albedo.R"]);
}
