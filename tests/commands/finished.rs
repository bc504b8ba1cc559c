//! Finished pictures stay, unless `--force` is given.

use super::*;

#[track_caller]
fn render(folder: &Folder, arguments: &[&str]) -> Run {
    folder.run(&[&["render", "fine.pbrt"], arguments].concat())
}

/// The file stays as it is, the message says why, and nothing else is written.
#[track_caller]
fn refused(folder: &Folder, file: &str, arguments: &[&str], why: &str) {
    let (names, before) = (folder.names(), std::fs::read(folder.path(file)).unwrap());
    let run = render(folder, &[&["-o", file], arguments].concat());
    let ways_out = "replace it with --force, or choose another name with -o";
    let expected = format!("error: {file} is not replaced: {why}; {ways_out}\n");
    assert_eq!((run.status, run.err), (2, expected));
    assert!(folder.names() == names && std::fs::read(folder.path(file)).unwrap() == before);
}

#[track_caller]
fn replaced(folder: &Folder, file: &str, arguments: &[&str]) {
    let before = std::fs::read(folder.path(file)).unwrap();
    let run = render(folder, &[&["-o", file], arguments].concat());
    assert_eq!(run.status, 0, "{}", run.err);
    assert_ne!(std::fs::read(folder.path(file)).unwrap(), before, "{file} {arguments:?}");
}

#[test]
fn larger_pictures_and_more_samples_stay() {
    for file in ["a.exr", "a.png"] {
        let folder = Folder::new();
        assert_eq!(render(&folder, &["-o", file, "--spp", "8"]).status, 0);
        refused(&folder, file, &["--spp", "7"], "it has 8 samples per pixel, and the new picture 7");
        refused(&folder, file, &[], "it has 8 samples per pixel, and the new picture 4");
        let larger = "it has 32 x 24 pixels, and the new picture 16 x 24";
        refused(&folder, file, &["--spp", "99", "--crop", "0", ".5", "0", "1"], larger);
        // The most that it can have.
        refused(
            &folder,
            file,
            &["--spp", "7", "--time", "9"],
            "it has 8 samples per pixel, and the new picture 7",
        );
        replaced(&folder, file, &["--spp", "8", "--seed", "1"]);
        replaced(&folder, file, &["--spp", "9", "--resolution", "40x20"]);
        // A draft under its own name is in nobody's way.
        assert_eq!(render(&folder, &["--quick"]).status, 0);
        replaced(&folder, file, &["--spp", "1", "--force"]);
        replaced(&folder, file, &["--spp", "2"]);
    }
}

#[test]
fn pictures_of_unknown_origin_stay() {
    let folder = Folder::new();
    for file in ["a.pfm", "a.tga"] {
        assert_eq!(render(&folder, &["-o", file]).status, 0);
        refused(&folder, file, &["--spp", "64"], &format!("a {} file stores no render settings", &file[2..]));
        replaced(&folder, file, &["--spp", "64", "--force"]);
    }
    // Without metadata, not even an EXR file.
    let mut image = folder.picture(&["--spp", "1"]);
    image.metadata = None;
    for file in ["b.exr", "b.png"] {
        image.write(&folder.path(file)).unwrap();
        refused(&folder, file, &[], "another program made it");
    }
    image.metadata = Some("{\"seed\": 1}".into());
    image.write(&folder.path("b.exr")).unwrap();
    refused(&folder, "b.exr", &[], "another program made it");
    folder.write("c.exr", "a diary");
    refused(&folder, "c.exr", &[], "c.exr is not in the EXR format");
    // An empty file holds no picture.
    for file in ["d.exr", "d.pfm"] {
        folder.write(file, "");
        replaced(&folder, file, &[]);
    }
}

#[test]
fn pictures_that_are_not_complete_are_replaced() {
    let folder = Folder::new();
    let mut image = folder.picture(&["--spp", "64"]);
    image.metadata = image.metadata.map(|text| text.replace("\"complete\":true", "\"complete\":false"));
    image.write(&folder.path("a.exr")).unwrap();
    replaced(&folder, "a.exr", &["--resolution", "8x8", "--spp", "1"]);
}

/// What a rendering reaches in a time is known at its end: then it goes beside the better picture.
#[test]
fn fewer_samples_than_expected_go_beside() {
    let folder = Folder::new();
    let mut image = folder.picture(&["--spp", "1"]);
    let metadata = image.metadata.unwrap();
    image.metadata = Some(metadata.replace("\"samples_per_pixel\":1.0", "\"samples_per_pixel\":1e9"));
    image.write(&folder.path("a.exr")).unwrap();
    folder.write("a.2.exr", "a diary");
    let before = std::fs::read(folder.path("a.exr")).unwrap();
    let time = ["-o", "a.exr", "--time", "0.2", "--spp", "1000000000"];
    let run = render(&folder, &time);
    assert_eq!(run.status, 0, "{}", run.err);
    let said = "a.exr is not replaced: it has 1000000000 samples per pixel, and the new picture ";
    assert!(run.err.contains(said) && run.err.contains("; the new picture is in a.3.exr\n"), "{}", run.err);
    assert_eq!(Image::read(&folder.path("a.3.exr")).unwrap().data_window.width, 32);
    let run = render(&folder, &[&time[..], &["--json"]].concat());
    assert!(json_lines(&run)[0]["picture"]["file"].as_str().unwrap().starts_with("a."));
    assert_eq!(std::fs::read(folder.path("a.exr")).unwrap(), before);
    // The number of adaptive samples depends on the noise, so that a few less are no reason.
    for how in [&["--adaptive", "--spp", "24"][..], &["--target-error", "0.1"]] {
        for seed in ["1", "2", "3"] {
            let run = render(&folder, &[&["-o", "noise.exr", "--force", "--seed", seed], how].concat());
            assert_eq!(run.status, 0, "{}", run.err);
        }
        assert_eq!(render(&folder, &[&["-o", "noise.exr"], how].concat()).status, 0);
        assert!(!folder.path("noise.2.exr").exists());
    }
}

/// An interrupted rendering takes the place of a partial picture only with as many samples.
#[cfg(unix)]
#[test]
fn an_interruption_keeps_a_better_partial_picture() {
    let folder = Folder::new();
    let mut image = folder.picture(&["--spp", "1"]);
    let metadata = image.metadata.unwrap().replace("\"complete\":true", "\"complete\":false");
    image.metadata = Some(metadata.replace("\"samples_per_pixel\":1.0", "\"samples_per_pixel\":1e9"));
    image.write(&folder.path("a.partial.exr")).unwrap();
    let before = std::fs::read(folder.path("a.partial.exr")).unwrap();
    // How soon it has samples depends on the machine.
    let said = [0.25, 1.0, 4.0, 16.0].into_iter().map(|seconds| {
        let mut command = folder.command(&["render", "fine.pbrt", "-o", "a.exr", "--spp", "100000000"]);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_secs_f32(seconds));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap()
    });
    let said = said.into_iter().find(|said| said.contains("a.partial.exr")).unwrap();
    assert!(said.contains("; the new picture is in a.partial.2.exr\n"), "{said}");
    assert!(folder.path("a.partial.2.exr").is_file() && !folder.path("a.exr").exists());
    assert_eq!(std::fs::read(folder.path("a.partial.exr")).unwrap(), before);
}
