//! Where pictures go, and what is there already.

use super::*;

const TEXTURED: &str = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.png\" Material \"matte\" \"texture Kd\" \"t\"";

/// No result replaces what it is made from, by whatever name it goes.
#[test]
fn nothing_is_written_over_its_inputs() {
    let folder = Folder::new();
    let scene = FINE.replace("Shape", &format!("{TEXTURED} Include \"part.pfm\" Shape"));
    folder.write("wood.pbrt", &scene.replace("fine.exr", "wood.png"));
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
        assert!(run.err.contains("this file is an input"), "{}", run.err);
    }
    // Nor is a picture that a scene shows one of the scene.
    let row = |arguments: &[&str]| {
        let out = folder.run(&[&["verify", "."], arguments].concat()).out;
        out.lines().find(|line| line.starts_with("wood ")).unwrap_or_default().to_owned()
    };
    assert_eq!(folder.run(&["render", "fine.pbrt", "-o", "fine.exr"]).status, 0);
    assert!(
        row(&[]).contains("no reference beside the scene, except a picture that the scene uses"),
        "{}",
        row(&[])
    );
    assert!(row(&["--update"]).contains("wrote ./wood.exr"));
    assert!(row(&[]).contains("agrees"), "{}", row(&[]));
    // Not even where there is no other name for it.
    std::fs::copy(folder.path("wood.exr"), folder.path("sky.exr")).unwrap();
    folder.write("sky.pbrt", &scene.replace("wood.png", "sky.exr"));
    let sky = bytes("sky.exr");
    let out = folder.run(&["verify", ".", "--update"]).out;
    assert!(out.contains("cannot write ./sky.exr: this file is an input"), "{out}");
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

/// What cannot be written is refused before the first sample, of which there are too many to wait for.
#[test]
fn outputs_that_cannot_be_written_are_refused_before_rendering() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder.exr")).unwrap();
    let before = folder.names();
    let long = format!("{}.exr", "n".repeat(252));
    for (file, reason) in [
        ("o.exr/", "it ends in a separator; write o.exr"),
        ("o.exr/.", "it ends in a separator; write o.exr"),
        ("folder.exr", "it is a folder"),
        (&long, "the name is too long"),
        ("none/o.exr", "there is no folder none"),
        ("fine.pbrt/o.exr", "fine.pbrt is a file, not a folder"),
    ] {
        let run = folder.run(&["render", "fine.pbrt", "--spp", "1000000000", "-o", file]);
        assert_eq!((run.status, run.err.lines().count()), (2, 1), "{file}: {}", run.err);
        assert!(run.err.contains(&format!("cannot write {file}: {reason}")), "{}", run.err);
        assert_eq!(folder.names(), before);
    }
    folder.write(
        "long.pbrt",
        &FINE.replace("fine.exr", &long).replace("pixelsamples\" 4", "pixelsamples\" 1000000"),
    );
    let run = folder.run(&["render", "long.pbrt"]);
    assert!(run.status == 2 && run.err.contains("the name is too long"), "{}", run.err);
    // The same for other commands, before they begin.
    folder.picture(&[]);
    for (arguments, reason) in [
        (&["compare", "picture.exr", "picture.exr", "--picture", "o.png/"][..], "write o.png"),
        (&["verify", ".", "--update", "--report", "o.html/"], "write o.html"),
        (&["chart", "fine.pbrt", "--spp", "65536", "-o", "fine.pbrt"], "fine.pbrt is a file"),
        (&["stability", "--rays", "1e9", "-o", "out"], "stability.csv: it is a folder"),
    ] {
        std::fs::create_dir_all(folder.path("out/stability.csv")).unwrap();
        let run = folder.run(arguments);
        assert!(
            run.status == 2 && run.out.is_empty() && run.err.contains(reason),
            "{arguments:?} {}",
            run.err
        );
    }
}

/// A name that is as long as it may be leaves no room for `.partial`, or for `.quick`.
#[test]
fn long_names_are_cut_for_marks() {
    let folder = Folder::new();
    let name = |count, ending| format!("{}{ending}", "é".repeat(count));
    folder.write("long.pbrt", &FINE.replace("fine.exr", &name(125, ".exr")));
    let run = folder.run(&["render", "long.pbrt", "--quick"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(folder.path(&name(122, ".quick.exr")).is_file());
}

#[test]
fn a_draft_replaces_no_finished_picture() {
    let folder = Folder::new();
    folder.write("fine.exr", "finished");
    let run = folder.run(&["render", "fine.pbrt", "--quick"]);
    assert!(run.status == 0 && run.err.contains("fine.quick.exr: 8 x 6 pixels"), "{}", run.err);
    assert_eq!(std::fs::read(folder.path("fine.exr")).unwrap(), b"finished");
    assert_eq!(Image::read(&folder.path("fine.quick.exr")).unwrap().data_window.width, 8);
    // An explicit name is obeyed.
    assert_eq!(folder.run(&["render", "fine.pbrt", "--quick", "-o", "a.exr"]).status, 0);
    assert!(folder.path("a.exr").is_file() && !folder.path("a.quick.exr").exists());
}

#[cfg(target_os = "linux")]
mod lost_folders {
    use std::process::{Child, Command};
    use std::time::Duration;

    use super::*;

    /// A rendering into `out/`, once it takes samples; what else it is given comes last.
    fn begun(folder: &Folder, arguments: &[&str], temporary: &Path) -> Child {
        std::fs::create_dir(folder.path("out")).unwrap();
        let mut command = folder.command(&[&["render", "fine.pbrt", "-o", "out/a.exr"], arguments].concat());
        command.env("TMPDIR", temporary).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        // What a process has used is in its fourteenth field, in hundredths of a second.
        let used = || -> u64 {
            let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
            stat.split_whitespace().nth(13).unwrap().parse().unwrap()
        };
        // Reading the scene takes less than a tenth of a second.
        let is_begun = (0..6000).any(|_| {
            std::thread::sleep(Duration::from_millis(10));
            used() >= 10
        });
        assert!(is_begun);
        child
    }

    fn interrupt(child: &Child) {
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    }

    /// The only folder that a picture was rescued to.
    fn rescued(place: &Path) -> std::path::PathBuf {
        let entries = place.read_dir().unwrap().map(|entry| entry.unwrap().path());
        let found: Vec<_> =
            entries.filter(|path| path.to_string_lossy().contains("lookat-rescued-")).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].clone()
    }

    /// A finished picture is not thrown away: it goes to the working folder.
    #[test]
    fn a_removed_folder_costs_no_picture() {
        let folder = Folder::new();
        let child = begun(&folder, &["--time", "4", "--json"], folder.0.path());
        std::fs::remove_dir_all(folder.path("out")).unwrap();
        let run = Run::of(child.wait_with_output().unwrap());
        let found = rescued(folder.0.path()).join("a.exr");
        assert_eq!(run.status, 2, "{}", run.err);
        assert!(
            run.err.contains("cannot write out/a.exr: there is no such file or folder; the result is in "),
            "{}",
            run.err
        );
        assert_eq!(Image::read(&found).unwrap().data_window.width, 32);
        // A program learns it, too.
        let result = &json_lines(&run)[0];
        assert!(result["error"].as_str().unwrap().contains("cannot write out/a.exr"));
        let told = folder.path(result["picture"]["file"].as_str().unwrap());
        assert_eq!(told.canonicalize().unwrap(), found.canonicalize().unwrap());
    }

    /// Nor is one that was broken off, even where the working folder takes no files either.
    #[test]
    fn a_partial_picture_goes_to_the_temporary_folder_at_last() {
        let (folder, temporary) = (Folder::new(), tempfile::tempdir().unwrap());
        let child = begun(&folder, &["--spp", "100000000"], temporary.path());
        std::fs::remove_dir_all(folder.0.path()).unwrap();
        interrupt(&child);
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!(run.status, 2, "{}", run.err);
        let found = rescued(temporary.path()).join("a.partial.exr");
        assert!(
            run.err.contains(&format!("the result is in {} instead", found.parent().unwrap().display())),
            "{}",
            run.err
        );
        assert_eq!(Image::read(&found).unwrap().data_window.width, 32);
    }

    /// Where every place is full, nothing half-written is left, and the program says that the picture is lost.
    #[test]
    fn a_full_disk_leaves_nothing_half_written() {
        let folder = Folder::new();
        let before = folder.names();
        let run = |blocks: u32, size: &str| {
            let program = env!("CARGO_BIN_EXE_lookat");
            let line =
                format!("ulimit -f {blocks}; exec {program} render fine.pbrt -o a.pfm --resolution {size}");
            let mut command = Command::new("bash");
            command.args(["-c", &line]).current_dir(folder.0.path()).env("TMPDIR", folder.0.path());
            Run::of(command.output().unwrap())
        };
        // 30 kB of picture, and 16 kB of room: known at the end.
        let full = run(16, "50x50");
        assert_eq!(full.status, 2, "{}", full.err);
        assert!(
            full.err.contains("cannot write a.pfm: it is larger than a file may be (see ulimit -f)"),
            "{}",
            full.err
        );
        assert!(full.err.contains("the result is lost"), "{}", full.err);
        assert_eq!(folder.names(), before);
        // No room at all: known before.
        let full = run(0, "50x50");
        assert!(full.status == 2 && !full.err.contains("lost"), "{}", full.err);
        assert_eq!(folder.names(), before);
    }

    /// The second signal ends the program while it writes a picture that takes a while; no temporary file stays.
    #[test]
    fn no_temporary_file_outlives_the_program() {
        let folder = Folder::new();
        let before = folder.names();
        let size = ["--resolution", "4000x3000", "--spp", "1", "-o", "a.exr"];
        // How long each part takes depends on the machine; some of these stop it while it writes.
        for milliseconds in [400, 700, 1000, 1300, 1600, 2000, 3000] {
            let mut command = folder.command(&[&["render", "fine.pbrt"], &size[..]].concat());
            let child = command.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(milliseconds));
            interrupt(&child);
            std::thread::sleep(Duration::from_millis(150));
            interrupt(&child);
            child.wait_with_output().unwrap();
            for name in
                ["a.exr", "a.partial.exr"].map(|name| folder.path(name)).iter().filter(|name| name.exists())
            {
                assert_eq!(Image::read(name).unwrap().data_window.width, 4000);
                std::fs::remove_file(name).unwrap();
            }
            assert_eq!(folder.names(), before, "after {milliseconds} ms");
        }
    }
}
