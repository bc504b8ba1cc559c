//! `lookat inspect`: what scenes need, and what they do without.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lookat")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// What `--json` says of a scene of the project, which people are told too.
fn needs(name: &str) -> Value {
    let scene =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes").join(name).with_extension("pbrt");
    let file = scene.to_str().unwrap();
    let (status, text, err) = run(&["inspect", file]);
    assert_eq!((status, err.as_str()), (0, ""), "{name}");
    let (status, out, err) = run(&["inspect", file, "--json"]);
    assert_eq!((status, err.as_str()), (0, ""), "{name}");
    let mut result: Value = serde_json::from_str(&out).unwrap();
    let needs = result["needs"].take();
    // Both say the same.
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for absent in needs["not_paid_for"].as_array().unwrap() {
        assert!(words(text.split_once("not used").unwrap().1).contains(absent.as_str().unwrap()), "{text}");
    }
    needs
}

/// Whether a scene does without.
fn lacks(needs: &Value, what: &str) -> bool {
    needs["not_paid_for"].as_array().unwrap().iter().any(|absent| absent == what)
}

#[test]
fn a_lens_and_instances_are_seen() {
    let first = needs("first");
    assert_eq!(first["film"]["samples"], 640 * 360 * 64);
    // In each pixel the sums of three channels and of weights, a count, and red, green and blue.
    assert_eq!(first["memory"]["film"], 640 * 360 * (4 * 16 + 4 + 3 * 4));
    assert_eq!(first["camera"]["lens"]["focal_distance"], 6.0);
    assert_eq!(first["world"]["triangles"], 2306);
    assert_eq!((&first["world"]["quadrics"], &first["world"]["instances"]), (&3.into(), &26.into()));
    assert_eq!((&first["objects"][0]["quadrics"], &first["objects"][0]["nodes"]), (&1.into(), &0.into()));
    assert_eq!(
        (&first["surfaces"]["kinds"], &first["surfaces"]["most_lobes"]),
        (&vec!["matte"; 6].into(), &1.into())
    );
    assert_eq!(first["lights"], Value::from(["quadric", "infinite"].as_slice()));
    // The film and the lens, and at each of four surfaces the choice of a light, a light and a direction.
    assert_eq!(first["numbers"]["most"], 2 + 2 + 4 * (1 + 2 + 2));
    assert!(
        !lacks(&first, "lens samples")
            && !lacks(&first, "a tree")
            && !lacks(&first, "samples of several pixels")
    );
    assert!(lacks(&first, "texture coordinates") && lacks(&first, "roulette") && lacks(&first, "holes"));
}

#[test]
fn lenses_are_measured_and_drawn() {
    let camera = &needs("cameras/realistic")["camera"];
    let number = |of: &Value| of.as_f64().unwrap();
    assert_eq!(
        (&camera["projection"], &camera["lens"]["focal_distance"]),
        (&"realistic".into(), &1.2.into())
    );
    let lens = &camera["lens_system"];
    assert_eq!(lens["surfaces"], 11);
    assert!(
        (number(&lens["focal_length"]) - 0.0504).abs() < 1e-4
            && (number(&lens["f_number"]) - 2.07).abs() < 0.01
    );
    let folder = tempfile::tempdir().unwrap();
    let drawn = folder.path().join("lens.svg");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes");
    let draw = |scene: &str| {
        run(&["inspect", scenes.join(scene).to_str().unwrap(), "--lens", drawn.to_str().unwrap()])
    };
    assert_eq!(draw("cameras/realistic.pbrt").0, 0);
    let svg = std::fs::read_to_string(&drawn).unwrap();
    let count = |what: &str| svg.matches(what).count();
    // Six pieces of glass; up to seven rays from three places; planes, focal points, stop, film and pupil have names.
    assert_eq!((count("<polygon"), count("<polyline")), (6, 21));
    for name in
        ["P", "P\u{2032}", "F", "F\u{2032}", "stop", "film", "exit pupil", "50.36 mm f/2.073, focused at 1.2"]
    {
        assert_eq!(count(&format!(">{name}</text>")), 1, "{name}");
    }
    // The page shows the same.
    let page = std::fs::read_to_string(scenes.join("../docs/double-gauss.svg")).unwrap();
    assert!(page == svg, "docs/double-gauss.svg is not what --lens draws");
    let (status, _, err) = draw("first.pbrt");
    assert_eq!((status, err.contains("this scene has a camera of type perspective")), (2, true), "{err}");
}

#[test]
fn lobes_and_roulette_are_seen() {
    let glossy = needs("cornell-glossy");
    assert_eq!((&glossy["surfaces"]["most_lobes"], &glossy["light_choice"]), (&3.into(), &"none".into()));
    // At five surfaces, the last of which would be the first with roulette.
    assert_eq!(glossy["numbers"]["most"], 2 + 5 * (2 + 2));
    assert!(lacks(&glossy, "lens samples") && lacks(&glossy, "light selection"));
    assert!(!lacks(&glossy, "lobe selection") && lacks(&glossy, "roulette"));
    let specular = needs("cornell-specular");
    assert_eq!(specular["integrator"]["depth"], 8);
    assert!(!lacks(&specular, "roulette"));
}

#[test]
fn textures_are_seen() {
    let textured = needs("textures-envmap");
    assert_eq!(
        (&textured["surfaces"]["coordinates"], &textured["surfaces"]["footprints"]),
        (&3.into(), &3.into())
    );
    assert_eq!(
        (&textured["memory"]["pictures"], &textured["lights"][0]),
        (&2.into(), &"infinite with a picture".into())
    );
    assert!(lacks(&textured, "lobe selection") && lacks(&textured, "bumps"));
    assert!(!lacks(&textured, "texture coordinates") && !lacks(&textured, "texture footprints"));
}

#[test]
fn lights_without_extent_take_no_numbers() {
    let lit = needs("delta-lights");
    assert_eq!((&lit["numbers"]["most"], &lit["light_choice"]), (&2.into(), &"all".into()));
    assert_eq!(lit["integrator"]["depth"], 1);
}

/// The triangles of a lamp that faces away are in one plane.
#[test]
fn a_lamp_does_not_light_its_back() {
    for name in ["back-of-a-lamp", "back-of-a-lamp-with-a-wall"] {
        let light = needs(&format!("../tests/views/{name}"))["view"]["lights"][0].take();
        assert_eq!((&light["irradiance"], &light["reaches"]), (&0.0.into(), &false.into()), "{name}");
    }
}

#[test]
fn a_scene_with_errors_is_told_as_by_check() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.pbrt");
    let text = "Film \"image\" Sampler \"sobol\" Camera \"perspective\" Integrator \"ambientocclusion\"
        WorldBegin Shape \"sphere\" Shape \"sphrere\" WorldEnd";
    std::fs::write(&path, text).unwrap();
    let file = path.to_str().unwrap();
    let (status, out, err) = run(&["inspect", file]);
    assert_eq!((status, out.as_str()), (1, ""));
    assert_eq!(err, run(&["check", file]).2);
    let (status, out, _) = run(&["inspect", file, "--json"]);
    let result: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (status, &result["needs"], &result["diagnostics"][0]["severity"]),
        (1, &Value::Null, &"error".into())
    );
    // Without what is in error there is a scene.
    let (status, out, err) = run(&["inspect", file, "--keep-going"]);
    assert!(status == 0 && err.contains("sphrere") && out.contains("1 quadric\n"), "{out}{err}");
    let (status, out, _) = run(&["inspect", file, "--keep-going", "--json"]);
    let result: Value = serde_json::from_str(&out).unwrap();
    // One leaf, and an integrator that asks for no material.
    assert!(status == 0 && lacks(&result["needs"], "a tree"), "{out}");
    assert!(lacks(&result["needs"], "materials, textures and lights"), "{out}");
    assert_eq!(result["needs"]["numbers"]["most"], 2 + 2 * 64);
    assert_eq!(run(&["inspect", "nothing.pbrt"]).0, 2);
    assert_eq!(run(&["inspect"]).0, 2);
}

#[test]
fn what_another_file_contains_is_listed_with_that_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "ball.pbrt",
        "\nTranslate 0 0 5\nShape \"sphere\"\nLightSource \"point\" \"point from\" [0 0 -5]\n",
    );
    write(
        "scene.pbrt",
        "Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 4 Film \"image\" Sampler \"sobol\"\n\
         Integrator \"path\" WorldBegin Include \"ball.pbrt\" LightSource \"infinite\" WorldEnd\n",
    );
    let scene = folder.path().join("scene.pbrt").display().to_string();
    let (status, text, err) = run(&["inspect", &scene]);
    assert_eq!((status, err.as_str()), (0, ""));
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("ball.pbrt, line 3)") && text.contains("ball.pbrt, line 4)"), "{text}");
    assert!(text.contains("infinite (line 2)"), "{text}");
    let (_, out, _) = run(&["inspect", &scene, "--json"]);
    let view = serde_json::from_str::<Value>(&out).unwrap()["needs"]["view"].take();
    let is_at = |at: &Value, file: &str, line: u64| {
        at["file"].as_str().unwrap().ends_with(file) && at["line"] == line
    };
    assert!(is_at(&view["shapes"][0], "ball.pbrt", 3) && is_at(&view["lights"][0], "ball.pbrt", 4), "{view}");
    assert!(is_at(&view["lights"][1], "scene.pbrt", 2), "{view}");
}

#[test]
fn meshes_and_pictures_in_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let leaf = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n-9 -9 5\n9 -9 5\n0 9 5\n3 0 1 2\n";
    write("leaf.ply", leaf.as_bytes());
    let sky = [1.0_f32; 6].map(f32::to_le_bytes);
    write("sky.pfm", &[b"PF\n2 1\n-1\n", sky.as_flattened()].concat());
    let scene = "Camera \"perspective\" \"float lensradius\" .1 \"float focaldistance\" 4 Film \"image\" Sampler \"sobol\"\n\
        Integrator \"path\" WorldBegin LightSource \"infinite\" \"string mapname\" \"sky.pfm\"\n\
        Shape \"plymesh\" \"string filename\" \"leaf.ply\" WorldEnd\n";
    write("scene.pbrt", scene.as_bytes());
    let scene = folder.path().join("scene.pbrt").display().to_string();
    let (status, text, err) = run(&["inspect", &scene]);
    assert_eq!(status, 0, "{err}");
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("plymesh leaf.ply (line 3)") && text.contains("infinite sky.pfm (line 2)"),
        "{text}"
    );
    let (_, out, _) = run(&["inspect", &scene, "--json"]);
    let view = serde_json::from_str::<Value>(&out).unwrap()["needs"]["view"].take();
    assert_eq!(
        (&view["shapes"][0]["data"], &view["lights"][0]["data"]),
        (&"leaf.ply".into(), &"sky.pfm".into())
    );
}
