//! `lookat explain`.

use super::{Folder, Run, Value};

fn explain(words: &[&str]) -> Run {
    Folder::empty().run(&[&["explain"], words].concat())
}

#[test]
fn a_type_has_its_parameters() {
    let run = explain(&["Camera", "perspective"]);
    assert_eq!((run.status, run.err.as_str()), (0, ""));
    let names = ["fov", "halffov", "frameaspectratio", "screenwindow"];
    let more = ["lensradius", "focaldistance", "shutteropen", "shutterclose"];
    for name in names.into_iter().chain(more) {
        assert!(run.out.contains(&format!("\"float {name}\"")), "{name}: {}", run.out);
    }
    let fov = "  \"float fov\", default 90, above 0 and below 180, in degrees\n      the angle of view";
    assert!(run.out.contains(fov), "{}", run.out);
}

#[test]
fn each_directive_has_its_types() {
    let all = explain(&[]);
    for name in ["Camera \"perspective\"", "Film \"image\"", "Sampler \"stratified\"", "Integrator \"path\""]
    {
        assert!(all.out.lines().any(|line| line.starts_with(name)), "{name}: {}", all.out);
    }
    let sampler = explain(&["Sampler"]);
    assert!(sampler.out.lines().all(|line| line.starts_with("Sampler \"")), "{}", sampler.out);
    assert!(
        sampler.out.contains("\"maxmindist\"") && sampler.out.contains("not supported: lookat renders sobol")
    );
}

#[test]
fn a_parameter_is_explained_alone() {
    let run = explain(&["Film", "image", "cropwindow", "--json"]);
    let value: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(
        (&value["name"], &value["count"], &value["effect"]),
        (&"cropwindow".into(), &4.into(), &"rendered".into())
    );
    let text = explain(&["Shape", "loopsubdiv", "scheme"]).out;
    assert!(text.contains("no effect on the picture") && !text.contains("levels"), "{text}");
}

#[test]
fn unknown_names_get_the_nearest() {
    for (words, advice) in [
        (&["Camra"][..], "nothing is called \"Camra\": did you mean Camera?"),
        (&["Camera", "perspectiv"], "Camera has no type \"perspectiv\": did you mean perspective?"),
        (&["Camera", "perspective", "fv"], "did you mean fov?"),
        (&["Camera", "environment", "fov"], "Camera \"environment\" has no parameter \"fov\": choose from"),
    ] {
        let run = explain(words);
        assert!(run.status == 2 && run.out.is_empty() && run.err.contains(advice), "{}", run.err);
    }
}

#[test]
fn words_of_other_programs_lead_to_parameters() {
    let lens = explain(&["Camera", "perspective", "aperture"]).out;
    assert!(
        lens.starts_with("\"aperture\" is \"lensradius\" in pbrt: lensradius is half the diameter"),
        "{lens}"
    );
    assert!(
        lens.contains("  \"float lensradius\", default 0") && lens.contains("elsewhere: aperture"),
        "{lens}"
    );
    let albedo = explain(&["MakeNamedMaterial", "matte", "albedo"]).out;
    assert!(albedo.starts_with("\"albedo\" is \"Kd\" in pbrt\n  \"rgb Kd\""), "{albedo}");
    let size = explain(&["Film", "image", "resolution"]);
    assert!(
        size.status == 2 && size.err.contains("has no parameter \"resolution\": write \"integer xres"),
        "{}",
        size.err
    );
}

#[test]
fn what_is_not_rendered_is_explained_too() {
    assert!(explain(&["Accelerator", "bvh"]).out.contains("\"string splitmethod\", default \"sah\""));
    assert!(explain(&["Integrator", "mlt"]).out.contains("not supported: lookat renders"));
}

#[test]
fn the_readme_shows_what_is_printed() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md")).unwrap();
    let fov = explain(&["Camera", "perspective", "fov"]).out;
    assert!(readme.contains(&format!("$ lookat explain Camera perspective fov\n{fov}```")), "{fov}");
}

#[test]
fn directives_without_types_are_explained() {
    let look = explain(&["LookAt"]).out;
    assert!(look.starts_with("LookAt ex ey ez lx ly lz ux uy uz  places the camera"), "{look}");
    for word in ["WorldBegin", "Include", "Transform", "ObjectInstance", "MediumInterface", "NamedMaterial"] {
        let run = explain(&[word]);
        assert!(run.status == 0 && run.out.starts_with(word) && run.out.lines().count() == 1, "{}", run.out);
        let (written, meaning) = run.out.trim_end().split_once("  ").unwrap();
        let is_listed = |line: &str| line.starts_with(written) && line.ends_with(meaning);
        assert!(explain(&[]).out.lines().any(is_listed), "{word}");
    }
    let value: Value = serde_json::from_str(&explain(&["Include", "--json"]).out).unwrap();
    assert_eq!((&value[0]["type"], &value[0]["arguments"]), (&Value::Null, &"\"file\"".into()));
    assert!(explain(&["Scale", "x"]).err.contains("Scale has no types: write Scale x y z"));
}

#[test]
fn the_type_of_a_named_material_is_a_parameter() {
    for words in [&["MakeNamedMaterial", "matte", "type"], &["MakeNamedMedium", "homogeneous", "type"]] {
        assert!(explain(words).out.starts_with("  \"string type\", required\n"), "{}", explain(words).err);
    }
}

#[test]
fn shapes_override_parameters_of_materials() {
    let kd = explain(&["Shape", "sphere", "Kd"]).out;
    assert!(kd.starts_with("a shape can override \"Kd\" of its material:\nMaterial matte Kd"), "{kd}");
    assert!(explain(&["Shape", "sphere", "radius"]).out.contains("the radius of the sphere"));
}

#[test]
fn default_types_are_marked() {
    for (directive, name) in
        [("Camera", "perspective"), ("PixelFilter", "box"), ("Sampler", "halton"), ("Integrator", "path")]
    {
        let out = explain(&[directive]).out;
        let marked: Vec<&str> = out.lines().filter(|line| line.ends_with("; the default")).collect();
        assert!(marked.len() == 1 && marked[0].contains(&format!("{directive} \"{name}\"")), "{out}");
    }
}

#[test]
fn the_empty_type_is_written_with_quotes() {
    let err = explain(&["Material", "wood"]).err;
    assert!(err.trim_end().ends_with("fourier, none, \"\""), "{err}");
    let err = explain(&["Material", "none", "bumpmap"]).err;
    assert!(err.contains("Material \"none\" has no parameter \"bumpmap\": it takes no parameters"), "{err}");
}

#[test]
fn words_of_other_programs_lead_to_types() {
    for (directive, word, name) in [
        ("Material", "lambert", "matte"),
        ("Material", "dielectric", "glass"),
        ("Material", "principled", "disney"),
        ("Shape", "obj", "plymesh"),
        ("Shape", "mesh", "trianglemesh"),
        ("LightSource", "sun", "distant"),
        ("LightSource", "envmap", "infinite"),
        ("Camera", "pinhole", "perspective"),
        ("Texture", "bitmap", "imagemap"),
        ("PixelFilter", "lanczos", "sinc"),
    ] {
        let out = explain(&[directive, word]).out;
        assert!(out.starts_with(&format!("\"{word}\" is \"{name}\" in pbrt")), "{out}");
        assert!(out.contains(&format!("\n{directive} \"{name}\": ")), "{out}");
        assert!(explain(&[word]).out.contains(&format!("{directive} {name} ")), "{word}");
    }
    assert!(explain(&["Shape", "cube"]).out.starts_with("Shape  pbrt-v3 has no such shape: write it as"));
    for (word, advice) in [
        ("Filter", "write PixelFilter"),
        ("Light", "write LightSource \"point\""),
        ("AreaLight", "this is a directive of an older pbrt; in pbrt-v3 it is AreaLightSource"),
        ("SurfaceIntegrator", "this is a directive of an older pbrt; in pbrt-v3 it is Integrator"),
    ] {
        assert!(explain(&[word]).out.starts_with(advice), "{word}: {}", explain(&[word]).out);
    }
}

#[test]
fn a_word_alone_leads_to_parameters() {
    for (words, line) in [
        (&["fov"][..], "Camera perspective fov "),
        (&["aperture"], "Camera environment lensradius "),
        (&["focus"], "Camera perspective focaldistance "),
        (&["resolution"], "write \"integer xresolution\" and \"integer yresolution\""),
        (&["albedo"], "Material mirror Kr "),
        (&["ior"], "Material uber eta "),
        (&["roughness"], "Material plastic roughness "),
        (&["roughness"], "Material matte                  the roughness of matte is \"float sigma\""),
        (&["emission"], "LightSource point I "),
        (&["kd"], "Material matte Kd "),
        (&["sphere"], "Shape sphere "),
        (&["Camera", "aperture"], "Camera orthographic lensradius "),
        (&["Material", "ior"], "Material glass eta "),
    ] {
        let run = explain(words);
        assert!(run.status == 0 && run.out.contains(line), "{words:?}: {}{}", run.out, run.err);
        let value: Value = serde_json::from_str(&explain(&[words, &["--json"]].concat()).out).unwrap();
        assert!(!value["found"].as_array().unwrap().is_empty(), "{words:?}");
    }
    assert!(!explain(&["Camera", "aperture"]).out.contains("Film"));
    assert!(explain(&["sphre"]).err.contains("did you mean sphere?"));
}

#[test]
fn advice_is_in_json_too() {
    let run = explain(&["Camra", "--json"]);
    let value: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(run.status, 2);
    assert_eq!(value["error"], "nothing is called \"Camra\": did you mean Camera?");
    let value: Value = serde_json::from_str(&explain(&["Shape", "obj", "--json"]).out).unwrap();
    assert!(value[0]["remark"].as_str().unwrap().contains("convert the mesh to PLY"));
}

#[test]
fn transformations_say_what_they_do_before_camera() {
    for word in ["Translate", "Rotate", "Scale", "Transform", "ConcatTransform", "LookAt"] {
        let Run { out, .. } = explain(&[word]);
        assert!(out.contains("before Camera"), "{out}");
    }
    assert!(explain(&["Translate"]).out.contains("moves the world, not the camera"));
}

#[test]
fn every_usual_word_leads_somewhere() {
    for (words, line) in [
        (&["camera"][..], "Camera \"perspective\""),
        (&["CAMERA", "Perspective", "FOV"], "\"float fov\""),
        (&["lookat"], "LookAt ex ey ez"),
        (&["depth", "of", "field"], "Camera perspective lensradius"),
        (&["bokeh"], "Camera perspective lensradius"),
        (&["gold"], "gold has \"rgb eta\""),
        (&["Au"], "gold has \"rgb eta\""),
        (&["water"], "water has \"float eta\" 1.33"),
        (&["ketchup"], "Material subsurface name"),
        (&["Fog"], "MakeNamedMedium"),
        (&["motion", "blur"], "ActiveTransform"),
        (&["zoom"], "\"float fov\" is the angle of view"),
        (&["blackbody"], "temperature in kelvin and a scale"),
        (&["glass"], "\nMakeNamedMaterial glass"),
        (&["glass", "eta"], "Material glass eta"),
        (&["Integrator", "direct"], "\"direct\" is \"directlighting\" in pbrt"),
    ] {
        let run = explain(words);
        assert!(run.status == 0 && run.out.contains(line), "{words:?}: {}{}", run.out, run.err);
    }
    let run = explain(&["teapot", "of", "clay"]);
    assert!(run.status == 2 && run.err.contains("\"teapot of clay\""), "{}", run.err);
}
