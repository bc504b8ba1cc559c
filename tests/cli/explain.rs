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
    let text = explain(&["Film", "image", "diagonal"]).out;
    assert!(text.contains("no effect on the picture") && !text.contains("cropwindow"), "{text}");
}

#[test]
fn unknown_names_get_the_nearest() {
    for (words, advice) in [
        (&["Camra"][..], "there is no directive \"Camra\": did you mean Camera?"),
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
    assert!(explain(&["MakeNamedMedium"]).out.contains("not supported: lookat renders empty space"));
}
