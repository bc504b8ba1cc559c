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

/// Killed at random moments and resumed until it is done, 200 times: the bits are those of a rendering without a break, no checkpoint is
/// unreadable, and no file is left.
#[test]
fn killed_renderings_go_on_to_the_same_bits() {
    let (mut random, folder) = (StdRng::seed_from_u64(1), Folder::new());
    folder.write("fine.pbrt", &FINE.replace("Integrator", "PixelFilter \"gaussian\" Integrator"));
    folder.run(&[LONG, &["-o", "whole.exr"]].concat());
    let whole = std::fs::read(folder.path("whole.exr")).unwrap();
    let mut kills = 0;
    for round in 0..200 {
        let threads = ["1", "2", "3"][round % 3];
        for attempt in 0.. {
            assert!(attempt < 100, "it gets nowhere");
            let has_checkpoint = ["a.exr", "a.previous.exr"].iter().any(|name| folder.path(name).exists());
            let mut child = if has_checkpoint {
                folder.command(&["resume", "a.exr", "-q", "--threads", threads])
            } else {
                folder.command(&[LONG, &["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.02"]].concat())
            };
            let mut child = child.stderr(Stdio::piped()).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(random.random_range(20..400)));
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
        assert!(std::fs::read(folder.path("b.exr")).unwrap() == whole, "round {round}");
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
        let long = ["render", "fine.pbrt", "--spp", "60000", "--layers", "depth,samples", "-o", "b.exr"];
        let long = [&long[..], &["--part", part, "--every", "0.05", "--checkpoint", "a b.exr"]].concat();
        let child = folder.command(&long).stderr(Stdio::piped()).spawn().unwrap();
        while !folder.path("a b.exr").exists() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        let signaled = std::time::Instant::now();
        assert!(sent.unwrap().success());
        let run = Run::of(child.wait_with_output().unwrap());
        assert!(signaled.elapsed() < Duration::from_secs(5), "{:?}", signaled.elapsed());
        assert_eq!(run.status, 130, "{}", run.err);
        assert_eq!(run.err.lines().last(), Some("to go on: lookat resume 'a b.exr'"), "{}", run.err);
        assert_eq!(files(&folder), ["a b.exr", "a b.previous.exr"]);
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
        assert!(again.err.contains("or go on with `lookat resume a b.exr`"), "{}", again.err);
        for name in ["a b.exr", "a b.previous.exr", "c.exr"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
}

/// What cannot be resumed is refused, with the reason, and nothing is written.
#[test]
fn what_cannot_be_resumed_is_refused() {
    let folder = Folder::new();
    let child =
        folder.command(&[LONG, &["-o", "b.exr", "--checkpoint", "a.exr", "--every", "0.05"]].concat());
    let mut child = { child }.spawn().unwrap();
    while !folder.path("a.exr").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let _ = std::fs::remove_file(folder.path("a.previous.exr"));
    let bytes = std::fs::read(folder.path("a.exr")).unwrap();
    let refused = |expected: &str| {
        let run = folder.run(&["resume", "a.exr"]);
        assert_eq!(run.status, 2, "{}", run.err);
        assert!(run.err.contains(expected), "{}", run.err);
        assert!(!folder.path("b.exr").exists());
    };
    folder.write("fine.pbrt", &FINE.replace("[3 4 -5]", "[3 4 -6]"));
    refused("a.exr cannot be resumed: the file fine.pbrt of the scene differs");
    std::fs::remove_file(folder.path("fine.pbrt")).unwrap();
    refused("there is no scene fine.pbrt, neither in");
    folder.write("fine.pbrt", FINE);
    for length in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(folder.path("a.exr"), &bytes[..length]).unwrap();
        refused("a.exr");
    }
    folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--force"]);
    refused("a.exr is no part of a rendering");
    folder.run(&["render", "fine.pbrt", "-q", "-o", "a.exr", "--part", "0/2", "--force"]);
    refused("a.exr is no checkpoint");
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

#[test]
fn checkpoints_that_cannot_be_written_are_refused_before_rendering() {
    let folder = Folder::new();
    folder.run(&["render", "fine.pbrt", "-q", "-o", "picture.exr"]);
    for (arguments, expected) in [
        (&["--checkpoint", "a.png"][..], "a.png: only an .exr file can store a checkpoint"),
        (&["--checkpoint", "none/a.exr"], "there is no folder"),
        (&["--checkpoint", "b.exr"], "b.exr is the picture: choose another name for the checkpoint"),
        (&["--checkpoint", "picture.exr"], "picture.exr is no checkpoint: choose another name"),
        (&["--checkpoint", "a.exr", "--target-error", "0.1"], "cannot be used with"),
        (&["--checkpoint", "a.exr", "warns.pbrt"], "--checkpoint takes one scene"),
        (&["--every", "5"], "--checkpoint <FILE>"),
    ] {
        let output: &[&str] = if arguments.contains(&"warns.pbrt") { &[] } else { &["-o", "b.exr"] };
        let run = folder.run(&[&["render", "fine.pbrt"], output, arguments].concat());
        assert_eq!(run.status, 2, "{arguments:?}: {}", run.err);
        assert!(run.err.contains(expected), "{arguments:?}: {}", run.err);
        assert_eq!(files(&folder), ["picture.exr"]);
    }
}
