//! Parts of a rendering, and what `merge` makes of them.

use rand::rngs::StdRng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};

use super::*;

/// Scenes with every kind of sampler, filter and integrator.
fn scenes() -> Vec<String> {
    let samplers = [
        "\"sobol\" \"integer pixelsamples\" 13",
        "\"random\" \"integer pixelsamples\" 13",
        "\"halton\" \"integer pixelsamples\" 16",
        "\"stratified\" \"integer xsamples\" 4 \"integer ysamples\" 3",
    ];
    let filters = ["\"box\"", "\"gaussian\"", "\"mitchell\"", "\"sinc\"", "\"triangle\""];
    let integrators = [
        "\"path\"",
        "\"directlighting\"",
        "\"ambientocclusion\"",
        "\"volpath\"",
        "\"directlighting\" \"string strategy\" \"one\"",
    ];
    let of = |at: usize| {
        FINE.replace("\"sobol\" \"integer pixelsamples\" 4", samplers[at % samplers.len()])
            .replace("Integrator \"path\"", &format!("Integrator {}", integrators[at % integrators.len()]))
            .replace("WorldBegin", &format!("PixelFilter {} WorldBegin", filters[(at + 1) % filters.len()]))
    };
    (0..20).map(of).collect()
}

/// Any number of parts, merged in any order, some of them first with each other, gives the file of one rendering.
#[test]
fn parts_add_up_to_the_file_of_one_rendering() {
    let mut random = StdRng::seed_from_u64(1);
    for (number, scene) in scenes().iter().enumerate() {
        let folder = Folder::new();
        folder.write("fine.pbrt", scene);
        let layers: &[&str] = match number % 3 {
            0 => &["--layers", "depth,shape,material,albedo,samples"],
            1 => &["--error-layers", "--layers", "normal,samples"],
            _ => &[],
        };
        let render = |more: &[&str]| {
            let run =
                folder.run(&[&["render", "fine.pbrt", "-q", "--resolution", "12x9"], layers, more].concat());
            assert_eq!((run.status, &*run.err), (0, ""), "{scene}");
        };
        render(&["-o", "whole.exr"]);
        let count = random.random_range(1..=12);
        let mut parts: Vec<String> = (0..count).map(|part| format!("{part}.exr")).collect();
        for (at, part) in parts.iter().enumerate() {
            render(&["--part", &format!("{at}/{count}"), "-o", part]);
        }
        parts.shuffle(&mut random);
        let merge = |files: &[String], more: &[&str]| {
            let files: Vec<&str> = files.iter().map(String::as_str).collect();
            let run = folder.run(&[&["merge"], &files[..], more].concat());
            assert_eq!(run.status, 0, "{scene} {files:?}: {}", run.err);
        };
        let some = random.random_range(0..parts.len());
        if some > 0 {
            merge(&parts[..some], &["--partial", "-o", "some.exr"]);
            parts.splice(..some, ["some.exr".to_owned()]);
        }
        merge(&parts, &["-o", "merged.exr"]);
        let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert!(read("merged.exr") == read("whole.exr"), "{scene}: {count} parts, {parts:?}");
    }
}

/// A part is a picture, with the mean of its own samples.
#[test]
fn a_part_is_a_picture() {
    let folder = Folder::new();
    folder.run(&["render", "fine.pbrt", "--spp", "64", "--part", "1/4", "-q", "-o", "part.exr"]);
    folder.run(&["render", "fine.pbrt", "--spp", "64", "-q", "-o", "whole.exr"]);
    let run = folder.run(&["compare", "part.exr", "whole.exr", "--max", "rmse=0.05"]);
    assert_eq!(run.status, 0, "{}{}", run.out, run.err);
    assert_eq!(folder.run(&["convert", "part.exr", "part.png"]).status, 0);
    // Again: it is a picture of lookat.
    assert_eq!(folder.run(&["convert", "part.exr", "part.png"]).status, 0);
    // Converted, it is a picture and no part.
    assert_eq!(folder.run(&["convert", "part.exr", "copy.exr"]).status, 0);
    let copy = Image::read(&folder.path("copy.exr")).unwrap();
    assert_eq!(copy.channels.len(), 3);
    assert!(folder.run(&["merge", "copy.exr", "-o", "x.exr"]).err.contains("copy.exr is no part"));
    // Each has a name of its own.
    folder.run(&["render", "fine.pbrt", "--part", "1/2", "-q"]);
    assert!(folder.path("fine.part-1-of-2.exr").exists());
}

#[test]
fn what_does_not_add_up_is_refused() {
    let folder = Folder::new();
    let render = |part: &str, more: &[&str], name: &str| {
        let run = folder.run(&[&["render", "fine.pbrt", "-q", "--part", part, "-o", name], more].concat());
        assert_eq!(run.status, 0, "{}", run.err);
    };
    render("0/4", &[], "a.exr");
    render("1/4", &[], "b.exr");
    render("2/4", &[], "c.exr");
    render("1/2", &[], "half.exr");
    render("3/4", &["--seed", "1"], "seed.exr");
    render("3/4", &["--spp", "8"], "more.exr");
    render("3/4", &["--fov", "41"], "view.exr");
    render("3/4", &["--resolution", "16x12"], "small.exr");
    folder.run(&["render", "fine.pbrt", "-q", "-o", "picture.exr"]);
    folder.write("fine.pbrt", &FINE.replace("[3 4 -5]", "[3 4 -6]"));
    render("3/4", &[], "changed.exr");
    folder.write("text.exr", "no picture");
    let bytes = std::fs::read(folder.path("b.exr")).unwrap();
    std::fs::write(folder.path("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    for (files, expected) in [
        (
            &["a.exr", "b.exr", "c.exr"][..],
            "error: part 3/4 is missing; to add up what there is, use --partial",
        ),
        (&["b.exr"], "error: the parts 0/4, 2/4, 3/4 are missing; to add up what there is, use --partial"),
        (&["a.exr", "b.exr", "a.exr"], "error: a.exr is named twice"),
        (
            &["a.exr", "b.exr", "c.exr", "half.exr"],
            "error: c.exr and half.exr overlap: both have sample 2 of each pixel; leave one out",
        ),
        (
            &["a.exr", "seed.exr"],
            "error: a.exr and seed.exr are no parts of one rendering: the seeds 0 and 1 differ",
        ),
        (
            &["a.exr", "more.exr"],
            "error: a.exr and more.exr are no parts of one rendering: their pictures have 4 and 8 samples per pixel",
        ),
        (
            &["a.exr", "view.exr"],
            "error: a.exr and view.exr are no parts of one rendering: the cameras differ",
        ),
        (
            &["a.exr", "small.exr"],
            "error: a.exr and small.exr are no parts of one rendering: the films differ",
        ),
        (
            &["a.exr", "changed.exr"],
            "error: a.exr and changed.exr are no parts of one rendering: the file fine.pbrt of the scene differs",
        ),
        (
            &["a.exr", "picture.exr"],
            "error: picture.exr is no part of a rendering: only `lookat render --part`, `lookat render --checkpoint` and `lookat merge --partial` write parts",
        ),
        (&["a.exr", "none.exr"], "error: cannot read none.exr: there is no such file or folder"),
    ] {
        let run = folder.run(&[&["merge"], files, &["-o", "merged.exr"]].concat());
        assert_eq!((run.status, run.err.trim_end()), (2, expected), "{files:?}");
        assert!(!folder.path("merged.exr").exists());
    }
    for damaged in ["text.exr", "cut.exr"] {
        let run = folder.run(&["merge", "a.exr", damaged, "--partial", "-o", "merged.exr"]);
        assert!(run.status == 2 && run.err.contains(damaged), "{}", run.err);
        assert!(!folder.path("merged.exr").exists());
    }
    for (option, expected) in [
        (["--part", "4/4"], "of 4, the last one is 3/4"),
        (["--part", "1"], "expected I/N"),
        (["--part", "0/5"], "4 samples per pixel make at most 4 parts"),
    ] {
        let run = folder.run(&[&["render", "fine.pbrt", "-o", "x.exr"], &option[..]].concat());
        assert!(run.status == 2 && run.err.contains(expected), "{option:?}: {}", run.err);
    }
    let run = folder.run(&["render", "fine.pbrt", "--part", "0/2", "-o", "x.png"]);
    assert!(run.err.contains("only an .exr file can store a part"), "{}", run.err);
}

/// Runs a script of `farm`, in which the stand-ins of the folder are programs.
#[cfg(unix)]
fn submit(folder: &Folder, script: &str) {
    let path = format!("{}:{}", folder.path("").display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    shell.env("PATH", path).current_dir(folder.0.path()).stdin(Stdio::piped());
    let mut shell = shell.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    shell.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    let ended = shell.wait_with_output().unwrap();
    assert!(ended.status.success(), "{script}\n{}", String::from_utf8_lossy(&ended.stderr));
}

#[cfg(unix)]
const WINDOW: lookat_image::Window = lookat_image::Window { x: 0, y: 0, width: 8, height: 8 };

/// The script for Slurm, with stand-ins for its program that run the jobs one after the other.
#[cfg(unix)]
#[test]
fn the_script_for_slurm_renders_and_merges() {
    use std::os::unix::fs::PermissionsExt;

    let folder = Folder::new();
    folder.write(
        "sbatch",
        r#"#!/bin/sh
job=$(cat)
case "$*" in
*-merge*--dependency=afterok:17*) ;;
*-merge*) exit 1 ;;
esac
case "$*" in
*--array=*)
    range=${*#*--array=} range=${range%% *}
    for SLURM_ARRAY_TASK_ID in $(seq "${range%-*}" "${range#*-}" | sort -r); do
        export SLURM_ARRAY_TASK_ID
        echo "$job" | sh || exit 1
    done ;;
*) echo "$job" | sh || exit 1 ;;
esac
echo 17
"#,
    );
    std::fs::set_permissions(folder.path("sbatch"), PermissionsExt::from_mode(0o755)).unwrap();
    folder.write("a scene's.pbrt", FINE);
    let small = ["--resolution", "8x6", "--spp", "120"];
    let farm = |arguments: &[&str]| {
        let run = folder.run(&[&["farm", "slurm", "a scene's.pbrt"], arguments, &["--"], &small].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        submit(&folder, &run.out);
    };
    folder.run(&[&["render", "a scene's.pbrt", "-q", "-o", "whole.exr"], &small[..]].concat());
    // The metadata have the path that jobs use.
    let pixels = |name: &str| Image::read(&folder.path(name)).unwrap().rgb();
    // Merged at once, and of so many in two steps.
    for parts in ["4", "120"] {
        farm(&["--parts", parts, "-o", "the picture.exr"]);
        assert_eq!(pixels("the picture.exr"), pixels("whole.exr"), "{parts}");
        std::fs::remove_file(folder.path("the picture.exr")).unwrap();
    }
    // What the jobs have anyway is no mistake, and replaces a picture of another program.
    Image::from_rgb(WINDOW, WINDOW, &[[1.0; 3]; 64]).write(&folder.path("other.exr")).unwrap();
    let run =
        folder.run(&["farm", "slurm", "fine.pbrt", "--parts", "2", "-o", "other.exr", "--", "--force", "-q"]);
    assert_eq!((run.status, run.out.matches("--force").count()), (0, 2), "{}", run.err);
    let frames = ["--turntable", "3"];
    let run = folder
        .run(&[&["farm", "slurm", "a scene's.pbrt", "-o", "frame.exr", "--"][..], &small, &frames].concat());
    submit(&folder, &run.out);
    folder.run(&[&["render", "a scene's.pbrt", "-q", "-o", "own.exr"], &small[..], &frames].concat());
    for number in 1..=3 {
        assert_eq!(
            pixels(&format!("frame.000{number}.exr")),
            pixels(&format!("own.000{number}.exr")),
            "{number}"
        );
    }
    for (arguments, expected) in [
        (&["fine.pbrt", "--parts", "5", "-o", "a.exr"][..], "4 samples per pixel make at most 4 parts"),
        (
            &["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "--show"],
            "a farm does not take lookat render --show",
        ),
        (&["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "--watch"], "cannot be used with"),
        (
            &["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "-o", "b.exr"],
            "it needs no lookat render -o or --only",
        ),
        (&["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "--adaptive"], "cannot be used with"),
        (&["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "warns.pbrt"], "a farm renders one scene"),
        (&["fine.pbrt", "-o", "a.exr"], "name the number of --parts of one picture, or the pictures"),
        (&["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "--turntable", "4"], "but not both"),
        (&["fine.pbrt", "--parts", "2", "-o", "a.exr", "--", "--ssp", "8"], "'--ssp'"),
        (&["fine.pbrt", "--parts", "2", "-o", "other.exr"], "other.exr is not replaced"),
        (
            &["fine.pbrt", "-o", "frame.exr", "--", "--turntable", "3", "--spp", "64", "--resolution", "8x6"],
            "frame.0001.exr is not replaced: it has 120 samples per pixel, and the new picture 64",
        ),
        (&["-", "--parts", "2", "-o", "a.exr"], "- can be read only once, and each job reads the scene"),
        (&["fine.pbrt", "--parts", "2", "-o", "none/a.exr"], "there is no folder"),
        (&["none.pbrt", "--parts", "2", "-o", "a.exr"], "none.pbrt"),
    ] {
        let run = folder.run(&[&["farm", "slurm"], arguments].concat());
        assert!(
            run.status != 0 && run.out.is_empty() && run.err.contains(expected),
            "{arguments:?}: {}",
            run.err
        );
    }
}

/// Slurm itself renders the parts, one of which is killed and requeued, and merges them. Skipped where there is no Slurm: `.ci/slurm`
/// installs it.
#[cfg(unix)]
#[test]
fn slurm_renders_and_merges() {
    let is_there = |program: &str| {
        let folders = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&folders).any(|folder| folder.join(program).exists())
    };
    if let Some(missing) = ["slurmctld", "slurmd", "munged", "sbatch"].into_iter().find(|it| !is_there(it)) {
        println!("skipped: there is no {missing}; .ci/slurm installs it and runs this test");
        return;
    }
    let as_root = Command::new("sh").args(["-c", "[ $(id -u) = 0 ] || sudo -n true 2>/dev/null"]).status();
    if !as_root.is_ok_and(|status| status.success()) {
        println!("skipped: only root can start the daemons of Slurm");
        return;
    }
    let run = Command::new(project().join(".ci/slurm"))
        .env("LOOKAT", env!("CARGO_BIN_EXE_lookat"))
        .output()
        .unwrap();
    let [out, err] = [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(run.status.success(), "{out}\n{err}");
    assert!(out.contains("four parts by Slurm have the bits of one rendering"), "{out}");
}

/// 64 samples and then 64 more are the bits of 128, for patterns without a fixed number of samples, also with a checkpoint in between.
#[test]
fn more_samples_are_added_to_a_picture() {
    for sampler in ["\"sobol\"", "\"random\"", "\"halton\""] {
        let folder = Folder::new();
        let texture = "Texture \"t\" \"color\" \"checkerboard\" \"float uscale\" 40 \"float vscale\" 40
            Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"";
        let scene = FINE.replace("\"sobol\"", sampler).replace("Shape \"sphere\"", texture);
        folder.write("fine.pbrt", &scene.replace("Integrator", "PixelFilter \"mitchell\" Integrator"));
        let render = |arguments: &[&str]| {
            let run = folder.run(
                &[&["render", "fine.pbrt", "-q", "--layers", "depth,normal,samples"], arguments].concat(),
            );
            assert_eq!((run.status, &*run.err), (0, ""), "{sampler} {arguments:?}");
        };
        render(&["--spp", "37", "--keep-sums", "-o", "whole.exr"]);
        render(&["--spp", "5", "--keep-sums", "-o", "a.exr"]);
        render(&["--more", "12", "-o", "a.exr"]);
        render(&["--more", "20", "-o", "a.exr", "--checkpoint", "c.exr", "--every", "0.001"]);
        let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert!(read("a.exr") == read("whole.exr"), "{sampler}");
        assert!(!folder.path("c.exr").exists());
        // After whole rounds, where noise decides.
        for (option, [first, more, all]) in [
            (&["--error-layers"][..], ["16", "48", "64"]),
            (&["--adaptive"], ["16", "48", "64"]),
            (&["--target-error", "0.05"], ["64", "192", "256"]),
        ] {
            render(&[option, &["--spp", all, "--keep-sums", "-o", "whole.exr", "--force"]].concat());
            render(&[option, &["--spp", first, "--keep-sums", "-o", "a.exr", "--force"]].concat());
            render(&[option, &["--more", more, "-o", "a.exr"]].concat());
            assert!(read("a.exr") == read("whole.exr"), "{sampler} {option:?}");
        }
    }
}

/// Of two renderings that add samples to one picture, the second does not begin.
#[test]
fn samples_are_added_by_one_rendering_at_a_time() {
    let folder = Folder::new();
    folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--keep-sums"]);
    let more = ["render", "fine.pbrt", "-q", "-o", "a.exr", "--more", "100000"];
    let kept = [&more[..], &["--checkpoint", "c.exr", "--every", "0.05"]].concat();
    for (command, appears) in [(&kept[..], "c.exr"), (&["resume", "c.exr", "-q"], "c.lock.exr")] {
        let mut child = folder.command(command).spawn().unwrap();
        while !["a.lock.exr", appears].iter().all(|name| folder.path(name).exists()) {
            assert_eq!(child.try_wait().unwrap(), None);
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let run = folder.run(&more);
        assert_eq!((run.status, &*run.err), (2, "error: another rendering writes a.exr\n"));
        child.kill().unwrap();
        child.wait().unwrap();
        for name in ["a.lock.exr", "c.lock.exr"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
    let run = folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--more", "4"]);
    assert_eq!((run.status, &*run.err), (0, ""));
    assert!(!folder.path("a.lock.exr").exists());
}

/// What an interruption left of a part is no part, and does not stop `merge part-*.exr`.
#[test]
fn interrupted_parts_are_left_out() {
    let folder = Folder::new();
    for part in ["0", "1"] {
        let (name, part) = (format!("part-{part}.exr"), format!("{part}/2"));
        folder.run(&["render", "fine.pbrt", "-q", "-o", &name, "--part", &part]);
    }
    // Without its sums, it is such a picture.
    folder.run(&["convert", "part-0.exr", "part-0.partial.exr"]);
    let run = folder.run(&["merge", "part-0.exr", "part-0.partial.exr", "part-1.exr", "-o", "a.exr"]);
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(run.err.contains("part-0.partial.exr is left out: it is not finished"), "{}", run.err);
    folder.run(&["render", "fine.pbrt", "-q", "-o", "whole.exr"]);
    let [merged, whole] = ["a.exr", "whole.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(merged == whole);
}

#[test]
fn what_cannot_have_more_samples_is_refused() {
    let folder = Folder::new();
    folder.write("grid.pbrt", &FINE.replace("\"sobol\" \"integer pixelsamples\" 4", "\"stratified\""));
    folder.run(&["render", "fine.pbrt", "-q", "-o", "plain.exr"]);
    folder.run(&["render", "fine.pbrt", "-q", "-o", "part.exr", "--part", "0/2"]);
    folder.run(&["render", "fine.pbrt", "-q", "-o", "kept.exr", "--keep-sums"]);
    let kept = std::fs::read(folder.path("kept.exr")).unwrap();
    for (arguments, expected) in [
        (&["fine.pbrt", "-o", "plain.exr", "--more", "4"][..], "nothing can be added to plain.exr"),
        (&["fine.pbrt", "-o", "part.exr", "--more", "4"], "nothing can be added to part.exr"),
        (&["fine.pbrt", "-o", "none.exr", "--more", "4"], "there is no picture none.exr to add samples to"),
        (
            &["fine.pbrt", "-o", "kept.exr", "--more", "4", "--fov", "41"],
            "nothing can be added to kept.exr: the cameras differ; repeat the options of its rendering",
        ),
        (&["fine.pbrt", "-o", "kept.exr", "--more", "4", "--seed", "1"], "the seeds 1 and 0 differ"),
        (
            &["warns.pbrt", "-o", "kept.exr", "--more", "4"],
            "their scenes have the files warns.pbrt and fine.pbrt",
        ),
        (
            &["fine.pbrt", "-o", "kept.exr", "--more", "1073741824"],
            "a picture has at most 1073741824 samples",
        ),
        (&["fine.pbrt", "-o", "kept.exr", "--more", "4", "--spp", "8"], "cannot be used with"),
        (
            &["fine.pbrt", "-o", "kept.exr", "--more", "12", "--adaptive"],
            "one is rendered with --adaptive, and one without --error-layers, --adaptive and --target-error",
        ),
        (
            &["fine.pbrt", "-o", "a.exr", "--keep-sums", "--adaptive", "--spp", "24"],
            "pictures of 16, 32, 64, 128 and so on samples per pixel, and this one would have 24: write such a number",
        ),
        (
            &["fine.pbrt", "-o", "kept.exr", "--more", "4", "--target-error", "0.1"],
            "one is rendered with --target-error 0.1 --confidence 0.95, and one without",
        ),
        (
            &["fine.pbrt", "-o", "kept.exr", "--more", "3", "--error-layers"],
            "one is rendered with --error-layers, and one without",
        ),
        (&["fine.pbrt", "-o", "kept.exr"], "kept.exr is not replaced: it has the sums of other samples"),
        (&["fine.pbrt", "-o", "kept.exr", "--part", "0/2"], "kept.exr is not replaced"),
        (
            &["-", "-o", "a.exr", "--part", "0/2"],
            "standard input can be read only once: with --part, name a file",
        ),
        (&["fine.pbrt", "-o", "a.png", "--keep-sums"], "only an .exr file can keep sums"),
        (&["grid.pbrt", "-o", "a.exr", "--keep-sums"], "nothing can be added to stratified samples"),
    ] {
        let run = folder.run(&[&["render"], arguments].concat());
        assert!(run.status == 2 && run.err.contains(expected), "{arguments:?}: {}", run.err);
        assert!(std::fs::read(folder.path("kept.exr")).unwrap() == kept);
    }
}
