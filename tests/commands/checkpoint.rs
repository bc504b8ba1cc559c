//! Renderings that are broken off and resumed.

use std::time::Duration;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::*;

/// A rendering of about half a second.
const LONG: &[&str] = &["render", "fine.pbrt", "--spp", "2000", "--threads", "2", "-q", "--force"];

/// Names of files, without those of scenes.
fn files(folder: &Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder.0.path()).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.retain(|name| !name.ends_with(".pbrt"));
    names.sort();
    names
}

/// Waits until a program has written a file.
fn wait_for(folder: &Folder, name: &str, child: &mut std::process::Child) {
    while !folder.path(name).exists() {
        assert_eq!(child.try_wait().unwrap(), None, "it ended without {name}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Killed at random moments and resumed until it is done, 200 times: the bits are those of a rendering without a break, no checkpoint is
/// unreadable, and no file is left.
#[test]
fn killed_renderings_go_on_to_the_same_bits() {
    let (mut random, folder) = (StdRng::seed_from_u64(1), Folder::new());
    folder.write("fine.pbrt", &FINE.replace("Integrator", "PixelFilter \"gaussian\" Integrator"));
    let kinds: [&[&str]; 5] = [
        &[],
        &["--error-layers"],
        &["--adaptive"],
        &["--target-error", "0.001"],
        &["--error-layers", "--part", "1/3"],
    ];
    let wholes = kinds.map(|kind| {
        folder.run(&[LONG, kind, &["-o", "whole.exr"]].concat());
        std::fs::read(folder.path("whole.exr")).unwrap()
    });
    let mut kills = 0;
    for round in 0..200 {
        let (threads, kind) = (["1", "2", "3"][round % 3], kinds[round % kinds.len()]);
        for attempt in 0.. {
            assert!(attempt < 100, "it gets nowhere");
            let has_checkpoint = ["a.exr", "a.previous.exr"].iter().any(|name| folder.path(name).exists());
            let mut child = if has_checkpoint {
                folder.command(&["resume", "a.exr", "-q", "--threads", threads])
            } else {
                let own = ["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.02"];
                folder.command(&[LONG, kind, &own].concat())
            };
            let mut child = child.stderr(Stdio::piped()).spawn().unwrap();
            // Longer and longer, for slow machines.
            std::thread::sleep(Duration::from_millis(random.random_range(20..400) + 20 * attempt));
            let _ = child.kill();
            let ended = child.wait_with_output().unwrap();
            let message = String::from_utf8_lossy(&ended.stderr).into_owned();
            // What is missing for a moment between two renamings is told of.
            assert!(message.is_empty() || message.contains("going on from"), "{message}");
            if ended.status.success() {
                break;
            }
            kills += 1;
        }
        let is_whole = std::fs::read(folder.path("b.exr")).unwrap() == wholes[round % kinds.len()];
        assert!(is_whole, "round {round}: {kind:?}");
        assert_eq!(files(&folder), ["b.exr", "whole.exr"]);
        std::fs::remove_file(folder.path("b.exr")).unwrap();
    }
    assert!(kills > 100, "{kills}");
}

/// An interruption writes a checkpoint and says how to go on; the checkpoint is a picture, and a part.
#[cfg(unix)]
#[test]
fn an_interruption_writes_a_checkpoint() {
    let folder = Folder::new();
    for (signal, part) in [("INT", "0/1"), ("TERM", "1/3")] {
        let long = ["render", "fine.pbrt", "--spp", "6000", "--layers", "depth,samples", "-o", "b.exr"];
        let long = [&long[..], &["--part", part, "--every", "0.05", "--checkpoint", "a b.exr"]].concat();
        let mut child = folder.command(&long).stderr(Stdio::piped()).spawn().unwrap();
        wait_for(&folder, "a b.exr", &mut child);
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        let signaled = std::time::Instant::now();
        assert!(sent.unwrap().success());
        let run = Run::of(child.wait_with_output().unwrap());
        assert!(signaled.elapsed() < Duration::from_secs(5), "{:?}", signaled.elapsed());
        assert_eq!(run.status, 130, "{}", run.err);
        assert_eq!(run.err.lines().last(), Some("to go on: lookat resume 'a b.exr'"), "{}", run.err);
        assert!(files(&folder).iter().all(|name| name == "a b.exr" || name == "a b.previous.exr"));
        let refused = folder.run(&["merge", "a b.exr", "-o", "c.exr"]);
        assert!(
            refused.err.contains("a b.exr is not finished: add up what there is with --partial, or finish it with `lookat resume"),
            "{}",
            refused.err
        );
        assert_eq!(folder.run(&["merge", "a b.exr", "--partial", "-q", "-o", "c.exr"]).status, 0);
        let [so_far, merged] = ["a b.exr", "c.exr"].map(|name| Image::read(&folder.path(name)).unwrap());
        assert_eq!(so_far.rgb(), merged.rgb());
        let again = folder.run(&long);
        assert!(again.err.contains("or go on with `lookat resume 'a b.exr'`"), "{}", again.err);
        // Finished, it has the bits of one that was never broken off, and its layers.
        let resume = folder.command(&["resume", "a b.exr", "--quiet"]).output().unwrap();
        assert!(resume.status.success(), "{}", String::from_utf8_lossy(&resume.stderr));
        let mut whole = long[..long.len() - 4].to_vec();
        *whole.iter_mut().find(|word| **word == "b.exr").unwrap() = "whole.exr";
        folder.run(&whole);
        let [resumed, whole] = ["b.exr", "whole.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
        assert!(resumed == whole, "{part}");
        for name in ["b.exr", "whole.exr", "c.exr"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
}

/// What focuses the lens is repeated, and finds the same place.
#[cfg(unix)]
#[test]
fn a_focused_rendering_is_resumed() {
    let folder = Folder::new();
    folder.write(
        "fine.pbrt",
        &FINE.replace("Camera \"perspective\"", "Camera \"perspective\" \"float lensradius\" 0.05"),
    );
    let long = ["render", "fine.pbrt", "--spp", "3000", "--focus", "0.5,0.5", "-q"];
    let mut child = folder
        .command(&[&long[..], &["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.05"]].concat())
        .spawn()
        .unwrap();
    wait_for(&folder, "a.exr", &mut child);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let resumed = folder.run(&["resume", "a.exr", "-q"]);
    assert_eq!(resumed.status, 0, "{}", resumed.err);
    folder.run(&[&long[..], &["-o", "whole.exr"]].concat());
    let [resumed, whole] = ["b.exr", "whole.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(resumed == whole);
}

/// Two programs do not write one checkpoint; and names that would cost a file are refused.
#[test]
fn checkpoints_destroy_nothing() {
    let folder = Folder::new();
    let own = ["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.05"];
    let longer: Vec<&str> = LONG.iter().map(|word| if *word == "2000" { "1000000" } else { word }).collect();
    let mut child = folder.command(&[&longer, &own[..]].concat()).spawn().unwrap();
    wait_for(&folder, "a.exr", &mut child);
    let expected = "another rendering writes a.exr";
    for arguments in [&["resume", "a.exr"][..], &[LONG, &own[..]].concat()] {
        let run = Run::of(folder.command(arguments).output().unwrap());
        assert!(run.status == 2 && run.err.contains(expected), "{arguments:?}: {}", run.err);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    for [picture, checkpoint] in
        [["a.exr", "x/../a.exr"], ["a.previous.exr", "a.exr"], ["c.exr", "c.partial.exr"]]
    {
        std::fs::create_dir_all(folder.path("x")).unwrap();
        let run = folder.run(&[LONG, &["-o", picture, "--checkpoint", checkpoint]].concat());
        assert!(
            run.status == 2 && run.err.contains("would be a picture and a checkpoint"),
            "{picture}: {}",
            run.err
        );
    }
    // Killed before it had a name again, in an older program.
    std::fs::rename(folder.path("a.exr"), folder.path("a.previous.exr")).unwrap();
    let run =
        folder.command(&["render", "fine.pbrt", "-o", "d.exr", "--checkpoint", "a.exr"]).output().unwrap();
    assert!(String::from_utf8_lossy(&run.stderr).contains("a.previous.exr is a checkpoint"));
    let bytes = std::fs::read(folder.path("a.previous.exr")).unwrap();
    // Any change of the sums is found.
    let mut random = StdRng::seed_from_u64(2);
    for _ in 0..20 {
        let mut bad = bytes.clone();
        let at = random.random_range(bytes.len() / 2..bytes.len());
        bad[at] ^= 1 << random.random_range(0..8);
        std::fs::write(folder.path("bad.exr"), &bad).unwrap();
        let merged = folder.run(&["merge", "bad.exr", "--partial", "-o", "m.exr", "--force", "-q"]);
        let is_in_colors = || {
            let [a, b] = [&bad, &bytes].map(|bytes| {
                std::fs::write(folder.path("x.exr"), bytes).unwrap();
                Image::read(&folder.path("x.exr")).ok()
            });
            a.is_some_and(|a| Some(a.rgb()) != b.map(|b| b.rgb()))
        };
        assert!(merged.status == 2 || is_in_colors(), "{at}");
    }
}

/// What cannot be resumed is refused, with the reason, and nothing is written.
#[test]
fn what_cannot_be_resumed_is_refused() {
    let folder = Folder::new();
    let child =
        folder.command(&[LONG, &["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.05"]].concat());
    let mut child = { child }.spawn().unwrap();
    wait_for(&folder, "a.exr", &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    let _ = std::fs::remove_file(folder.path("a.previous.exr"));
    let bytes = std::fs::read(folder.path("a.exr")).unwrap();
    let refused = |status: i32, expected: &str| {
        let run = folder.run(&["resume", "a.exr"]);
        assert_eq!(run.status, status, "{}", run.err);
        assert!(run.err.contains(expected), "{}", run.err);
        assert!(!folder.path("b.exr").exists());
    };
    folder.write("fine.pbrt", &FINE.replace("[3 4 -5]", "[3 4 -6]"));
    refused(2, "a.exr cannot be resumed: the file fine.pbrt of the scene differs");
    std::fs::remove_file(folder.path("fine.pbrt")).unwrap();
    refused(2, "there is no scene fine.pbrt, neither in");
    folder.write("fine.pbrt", FINE);
    for length in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(folder.path("a.exr"), &bytes[..length]).unwrap();
        refused(66, "a.exr");
    }
    folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--force"]);
    refused(2, "a.exr is no part of a rendering");
    folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--part", "0/2", "--force"]);
    refused(2, "a.exr is no checkpoint");
    // Nor does anything else take it for an interrupted picture.
    let mut bad = bytes.clone();
    let sums = bad.windows(8).position(|window| window == b"\"sums\":\"").unwrap();
    bad[sums + 8] = b'!';
    std::fs::write(folder.path("bad.exr"), bad).unwrap();
    let run = folder.run(&["merge", "bad.exr", "bad.exr", "--partial", "-o", "m.exr"]);
    assert_eq!((run.status, run.err.contains("bad.exr is damaged")), (2, true), "{}", run.err);
    // Elsewhere, with a copy of the scene.
    std::fs::write(folder.path("a.exr"), &bytes).unwrap();
    let other = Folder::new();
    std::fs::copy(folder.path("a.exr"), other.path("moved.exr")).unwrap();
    let home = folder.0.path().to_owned();
    folder.run(&[LONG, &["-o", "whole.exr"]].concat());
    let whole = std::fs::read(folder.path("whole.exr")).unwrap();
    drop(folder);
    assert!(!home.exists());
    let run = other.run(&["resume", "moved.exr", "-q"]);
    assert_eq!((run.status, &*run.err), (0, ""));
    assert!(std::fs::read(other.path("b.exr")).unwrap() == whole);
    assert_eq!(files(&other), ["b.exr"]);
}

/// A rendering of absolute paths, which are gone, and a checkpoint behind a link.
#[cfg(unix)]
#[test]
fn what_was_moved_is_found_where_it_is_resumed() {
    let folder = Folder::new();
    folder.run(&[LONG, &["-o", "whole.exr"]].concat());
    let whole = std::fs::read(folder.path("whole.exr")).unwrap();
    for output in [None, Some("named.exr")] {
        let old = Folder::new();
        let [scene, picture] = ["fine.pbrt", "b.exr"].map(|name| old.path(name).display().to_string());
        std::fs::create_dir(old.path("disk")).unwrap();
        std::os::unix::fs::symlink("disk/real.exr", old.path("a.exr")).unwrap();
        let begun =
            ["render", &scene, "--spp", "2000", "-o", &picture, "--checkpoint", "a.exr", "--every", "0.05"];
        let mut child =
            old.command(&[&begun[..], &["--force"]].concat()).stderr(Stdio::null()).spawn().unwrap();
        wait_for(&old, "disk/real.exr", &mut child);
        child.kill().unwrap();
        child.wait().unwrap();
        let new = Folder::new();
        std::fs::create_dir(new.path("disk")).unwrap();
        std::fs::copy(old.path("disk/real.exr"), new.path("disk/-real.exr")).unwrap();
        std::os::unix::fs::symlink("disk/-real.exr", new.path("a.exr")).unwrap();
        drop(old);
        let more: Vec<_> = output.iter().flat_map(|name| ["-o", *name]).collect();
        // The command's --force was for another file.
        let name = output.unwrap_or("b.exr");
        new.run(&["render", "fine.pbrt", "-q", "-o", name, "--spp", "3000"]);
        let run = new.run(&[&["resume", "a.exr"], &more[..]].concat());
        assert!(run.status == 2 && run.err.contains("is not replaced"), "{}", run.err);
        std::fs::remove_file(new.path(name)).unwrap();
        let run = new.run(&[&["resume", "a.exr"], &more[..]].concat());
        assert_eq!(run.status, 0, "{}", run.err);
        assert!(run.err.contains("going on with fine.pbrt here"), "{}", run.err);
        assert!(run.err.contains("the picture goes to ") && run.err.contains(name), "{}", run.err);
        assert!(std::fs::read(new.path(name)).unwrap() == whole);
        // The link stays, and what it led to is gone.
        let mut left = ["a.exr", name, "disk"];
        left.sort();
        assert_eq!(files(&new), left);
        assert_eq!(std::fs::read_dir(new.path("disk")).unwrap().count(), 0);
    }
}

/// Where nothing can be written any more, the last checkpoint stays, and the message says how to go on.
#[cfg(unix)]
#[test]
fn the_last_checkpoint_outlives_a_full_disk() {
    let folder = Folder::new();
    let long = ["render", "fine.pbrt", "--spp", "200", "--resolution", "100x80", "-q"];
    let own = ["-o", "b.exr", "--checkpoint=-a 1.exr", "--every", "0.05"];
    let mut child = folder.command(&[&long[..], &own].concat()).spawn().unwrap();
    wait_for(&folder, "-a 1.exr", &mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    let run = folder.run_within("-f 5", &["resume", "--force", "./-a 1.exr"]);
    let last = run.err.lines().last().unwrap_or_default();
    let command = last.split_once("; to go on from the last checkpoint: lookat ").map(|(_, command)| command);
    assert_eq!((run.status, command), (2, Some("resume './-a 1.exr'")), "{}", run.err);
    let run = folder.run(&["resume", "./-a 1.exr", "-q"]);
    assert_eq!((run.status, &*run.err), (0, ""));
    folder.run(&[&long[..], &["-o", "whole.exr"]].concat());
    let [resumed, whole] = ["b.exr", "whole.exr"].map(|name| std::fs::read(folder.path(name)).unwrap());
    assert!(resumed == whole);
}

#[test]
fn checkpoints_that_cannot_be_written_are_refused_before_rendering() {
    let folder = Folder::new();
    folder.run(&["render", "fine.pbrt", "-q", "-o", "picture.exr"]);
    folder.run(&["render", "fine.pbrt", "-q", "-o", "held.lock.exr"]);
    for (arguments, expected) in [
        (&["--checkpoint", "a.png"][..], "a.png: only an .exr file can store a checkpoint"),
        (&["--checkpoint", "none/a.exr"], "there is no folder"),
        (
            &["--checkpoint", "b.exr"],
            "b.exr would be a picture and a checkpoint: choose another name for the checkpoint",
        ),
        (&["--checkpoint", "picture.exr"], "picture.exr is no checkpoint: choose another name"),
        (
            &["--checkpoint", "held.exr"],
            "held.lock.exr is in the way: lookat locks it while it writes held.exr",
        ),
        (&["--checkpoint", "a.exr", "--time", "1"], "cannot be used with"),
        (&["--checkpoint", "a.exr", "warns.pbrt"], "--checkpoint takes one scene"),
        (&["--every", "5"], "--checkpoint <FILE>"),
    ] {
        let output: &[&str] = if arguments.contains(&"warns.pbrt") { &[] } else { &["-o", "b.exr"] };
        let run = folder.run(&[&["render", "fine.pbrt"], output, arguments].concat());
        assert_eq!(run.status, 2, "{arguments:?}: {}", run.err);
        assert!(run.err.contains(expected), "{arguments:?}: {}", run.err);
        assert_eq!(files(&folder), ["held.lock.exr", "picture.exr"]);
    }
}
