//! The scenes of pbrt-scenes/gallery: each is free of problems and shows something.

use std::path::Path;
use std::process::Command;

use lookat_image::Image;

#[test]
fn every_scene_is_fine_and_not_black() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pbrt-scenes/gallery");
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.pfm");
    let mut count = 0;
    for entry in std::fs::read_dir(scenes).unwrap() {
        let scene = entry.unwrap().path();
        if scene.extension().is_none_or(|ending| ending != "pbrt") {
            continue;
        }
        let name = scene.display();
        let mut command = Command::new(env!("CARGO_BIN_EXE_lookat"));
        command.args(["render", "--strict", "--resolution", "24x16", "--spp", "1"]);
        let run = command.arg(&scene).arg("-o").arg(&picture).output().unwrap();
        assert_eq!(run.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&run.stderr));
        let pixels = Image::read(&picture).unwrap().rgb().unwrap().concat();
        assert!(pixels.iter().sum::<f32>() > 0.01 * pixels.len() as f32, "{name} is black");
        count += 1;
    }
    assert!(count >= 6);
}
