//! `docs/supported.md` names every type and every parameter that the code asks for, under the right heading.

use std::collections::HashMap;
use std::path::Path;

/// The text of each section, by its heading.
fn sections() -> HashMap<String, String> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/supported.md");
    let text = std::fs::read_to_string(page).unwrap();
    let parts = text.split("\n## ").skip(1);
    parts.filter_map(|part| part.split_once('\n')).map(|(name, text)| (name.into(), text.into())).collect()
}

#[test]
fn the_page_names_all_types_and_parameters() {
    let sections = sections();
    let kinds = lookat_scene::kinds();
    assert!(kinds.len() > 70, "{}", kinds.len());
    let mut missing = Vec::new();
    for kind in kinds {
        let section = &sections[kind.directive];
        let mut look = |name: &str| {
            if !section.contains(&format!("`{name}`")) {
                missing.push(format!("{} \"{}\": `{name}`", kind.directive, kind.name));
            }
        };
        // The empty name is written as it stands in a scene.
        look(if kind.name.is_empty() { "\"\"" } else { kind.name });
        kind.parameters.iter().for_each(|parameter| look(parameter));
    }
    assert!(missing.is_empty(), "docs/supported.md lacks\n{}", missing.join("\n"));
}

#[test]
fn what_the_code_asks_for_is_found() {
    let kinds = lookat_scene::kinds();
    let parameters = |directive: &str, name: &str| {
        kinds.iter().find(|kind| kind.directive == directive && kind.name == name).unwrap().parameters.clone()
    };
    assert_eq!(parameters("Shape", "disk"), ["height", "radius", "innerradius", "phimax"]);
    assert_eq!(parameters("Material", "matte"), ["Kd", "sigma", "bumpmap"]);
}
