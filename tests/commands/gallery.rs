//! The scenes of pbrt-scenes/gallery: each is free of problems and looks like its small reference in tests/gallery. The pages of docs list
//! all scenes.

use std::path::Path;

use crate::folder::{Folder, compare_pictures};
use crate::project;

/// `UPDATE_EXPECTED=1` writes the pictures.
#[test]
fn every_scene_is_fine_and_looks_like_its_reference() {
    let folder = Folder::empty();
    let mut count = 0;
    for entry in std::fs::read_dir(project().join("pbrt-scenes/gallery")).unwrap() {
        let scene = entry.unwrap().path();
        if scene.extension().is_none_or(|ending| ending != "pbrt") {
            continue;
        }
        let name = scene.to_str().unwrap();
        let options = ["--force", "--strict", "--resolution", "60x40", "--spp", "8", "-o", "a.png"];
        let run = folder.run(&[&["render", name], &options[..]].concat());
        assert_eq!(run.status, 0, "{name}: {}", run.err);
        let reference = project().join("tests/gallery").join(scene.file_name().unwrap());
        compare_pictures(&folder.path("a.png"), &reference.with_extension("png"));
        count += 1;
    }
    assert!(count >= 6);
}

/// The scenes below a folder of pbrt-scenes: name and first comment. Files that others include have no `WorldEnd`.
fn scenes(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            scenes(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "pbrt") {
            let text = std::fs::read_to_string(&path).unwrap();
            if text.lines().any(|line| line.starts_with("WorldEnd")) {
                let name = path.strip_prefix(project().join("pbrt-scenes")).unwrap().with_extension("");
                let says = text.lines().next().unwrap_or_default().trim_start_matches("# ");
                found.push((name.to_str().unwrap().replace('\\', "/"), says.into()));
            }
        }
    }
}

#[test]
fn the_pages_show_every_scene() {
    let mut all = Vec::new();
    scenes(&project().join("pbrt-scenes"), &mut all);
    let docs = project().join("docs");
    let [gallery, list] =
        ["gallery.md", "scenes.md"].map(|page| std::fs::read_to_string(docs.join(page)).unwrap());
    let listed = |name: &str, says: &str| format!("- [{name}](../pbrt-scenes/{name}.pbrt): {says}\n");
    let (own, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|(name, _)| name.starts_with("gallery/"));
    for (name, says) in &others {
        assert!(list.contains(&listed(name, says)), "docs/scenes.md has no line {}", listed(name, says));
    }
    assert_eq!(list.matches("](../pbrt-scenes/").count(), others.len());
    // The gallery has a few of the others, too.
    let of_tests = others.iter().filter(|(name, _)| gallery.contains(&format!("/{name}.pbrt)")));
    for (name, says) in own.iter().chain(of_tests) {
        let short = name.rsplit('/').next().unwrap();
        let file = format!("gallery/{short}.png");
        let shown = format!("\n{says}\n\n[![{short}]({file})](../pbrt-scenes/{name}.pbrt)\n");
        assert!(gallery.contains(&shown), "docs/gallery.md does not show {name}: {shown}");
        assert!(docs.join(&file).is_file(), "no picture of {name}");
    }
}
