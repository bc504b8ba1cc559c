//! Where pictures go, and what is there already.

use super::*;

const TEXTURED: &str = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.png\" Material \"matte\" \"texture Kd\" \"t\"";

/// No result replaces what it is made from, by whatever name it goes.
#[test]
fn nothing_is_written_over_its_inputs() {
    let folder = Folder::new();
    let scene = FINE.replace("Shape", &format!("{TEXTURED} Include \"part.pfm\" Shape"));
    folder.write("wood.pbrt", &scene.replace("fine.pfm", "wood.png"));
    folder.write("part.pfm", "Rotate 20 0 1 0");
    let run = folder.run(&["render", "fine.pbrt", "-o", "wood.png"]);
    assert_eq!(run.status, 0, "{}", run.err);
    std::fs::copy(folder.path("wood.pbrt"), folder.path("scene.tga")).unwrap();
    let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
    let before = ["wood.png", "part.pfm", "scene.tga"].map(bytes);
    // The Film names the texture.
    for arguments in [
        &["render", "wood.pbrt"][..],
        &["render", "wood.pbrt", "-o", "./wood.png"],
        &["render", "wood.pbrt", "-o", "part.pfm"],
        &["render", "scene.tga", "-o", "scene.tga"],
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.status, 2, "{arguments:?} {}", run.err);
        assert!(run.err.contains("the result is made from what is there"), "{}", run.err);
    }
    // Nor is a picture that a scene shows one of the scene.
    let row = |arguments: &[&str]| {
        let out = folder.run(&[&["verify", "."], arguments].concat()).out;
        out.lines().find(|line| line.starts_with("wood ")).unwrap_or_default().to_owned()
    };
    assert_eq!(folder.run(&["render", "fine.pbrt", "-o", "fine.exr"]).status, 0);
    assert!(row(&[]).contains("no picture beside it except one that it shows"), "{}", row(&[]));
    assert!(row(&["--update"]).contains("wrote ./wood.exr"));
    assert!(row(&[]).contains("agrees"), "{}", row(&[]));
    // Not even where there is no other name for it.
    std::fs::copy(folder.path("wood.exr"), folder.path("sky.exr")).unwrap();
    folder.write("sky.pbrt", &scene.replace("wood.png", "sky.exr"));
    let sky = bytes("sky.exr");
    let out = folder.run(&["verify", ".", "--update"]).out;
    assert!(out.contains("cannot write ./sky.exr: the result is made from what is there"), "{out}");
    assert_eq!(bytes("sky.exr"), sky);
    assert_eq!(["wood.png", "part.pfm", "scene.tga"].map(bytes), before);
}

/// Who may read a picture may read what replaces it.
#[cfg(unix)]
#[test]
fn permissions_stay() {
    use std::os::unix::fs::PermissionsExt;

    let folder = Folder::new();
    let path = folder.path("picture.exr");
    let mode = || std::fs::metadata(&path).unwrap().permissions().mode() & 0o777;
    folder.picture(&[]);
    let usual = mode();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
    folder.picture(&[]);
    assert_eq!((mode(), usual & 0o600), (0o600, 0o600));
}

#[test]
fn a_scene_file_that_is_not_there_may_be_another() {
    let folder = Folder::new();
    for (asked, meant) in [("Fine.pbrt", "fine.pbrt"), ("fine", "fine.pbrt"), ("fne.pbrt", "fine.pbrt")] {
        let run = folder.run(&["check", asked]);
        assert_eq!(run.status, 2, "{asked}");
        assert!(run.err.contains(&format!("did you mean {meant}?")), "{}", run.err);
    }
    assert!(!folder.run(&["check", "other.pbrt"]).err.contains("did you mean"));
}
