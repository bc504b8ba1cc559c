//! Pages that a reader follows step by step: their scenes, their commands, the output and the pictures.
//!
//! A block of `pbrt` or `diff` is about `scene.pbrt`, or about the file that it names. `UPDATE_EXPECTED=1` writes output and pictures
//! into the pages, and fails all the same: look at `git diff`.

use std::path::{Path, PathBuf};

use crate::folder::{Folder, Run, compare_pictures, updates};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// What the reader has: a folder with the scenes, and the last picture there.
struct Reader {
    folder: Folder,
    picture: String,
}

impl Reader {
    /// Applies a diff to a scene: replaces the lines that it keeps or removes, which must be there once.
    fn edit(&self, scene: &str, diff: &str) {
        let side = |sign: char| -> String {
            let lines = diff.lines().filter(|line| line.starts_with([' ', sign]));
            lines.map(|line| format!("{}\n", &line[1..])).collect()
        };
        let (before, after) = (side('-'), side('+'));
        let text = std::fs::read_to_string(self.folder.path(scene)).unwrap();
        assert_eq!(text.matches(&before).count(), 1, "{before}\nin\n{text}");
        self.folder.write(scene, &text.replace(&before, &after));
    }

    /// Runs the commands of a block. The block as it should be.
    fn run(&mut self, block: &str) -> String {
        let mut printed = String::new();
        for line in block.lines() {
            let Some(command) = line.strip_prefix("$ ") else { continue };
            let words = shlex::split(command).unwrap();
            let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
            assert_eq!(arguments[0], "lookat", "{command}");
            let Run { status, out, err } = self.folder.run(&arguments[1..]);
            assert_eq!(status, 0, "{command}\n{err}");
            let result = err.lines().find(|line| line.contains(" pixels"));
            if let Some((file, _)) = result.and_then(|line| line.split_once(": ")) {
                self.picture = file.to_owned();
            }
            // How far a command is after a second depends on the machine.
            let messages = err.lines().filter(|line| !line.ends_with(" left"));
            let messages: String = messages.map(|line| format!("{line}\n")).collect();
            printed += &format!("{line}\n{messages}{out}");
        }
        printed
    }
}

/// Lines of output without what depends on the machine: times, instructions, and counts of noisy pixels.
fn without_machine(block: &str) -> String {
    let mut lines = String::new();
    for line in block.lines() {
        let end = line.find(" s, ").and_then(|end| line[..end].rfind(", "));
        let line = end.map_or(line, |end| &line[..end]);
        lines += &match line.trim_start() {
            start if start.starts_with("arithmetic") => "arithmetic".to_owned(),
            _ if line.contains(" pixels (") => line.replace(|digit: char| digit.is_ascii_digit(), ""),
            _ => line.to_owned(),
        };
        lines.push('\n');
    }
    lines
}

#[test]
fn getting_started() {
    follow("getting-started.md", 5);
}

#[test]
fn authoring() {
    follow("authoring.md", 7);
}

/// Does each step of a page, and compares what happens with what the page shows.
fn follow(page: &str, expected_pictures: usize) {
    let file = docs().join(page);
    let page = std::fs::read_to_string(&file).unwrap();
    let mut reader = Reader { folder: Folder::empty(), picture: String::new() };
    let (mut made, mut pictures, mut rest) = (String::new(), 0, page.as_str());
    while let Some((text, fenced)) = rest.split_once("```") {
        for image in text.split("](").skip(1).filter_map(|link| link.split(')').next()) {
            if image.ends_with(".png") {
                compare_pictures(&reader.folder.path(&reader.picture), &docs().join(image));
                pictures += 1;
            }
        }
        let (block, after) = fenced.split_once("```\n").expect("the block ends");
        let (kind, body) = block.split_once('\n').unwrap();
        let (language, scene) = kind.split_once(' ').unwrap_or((kind, "scene.pbrt"));
        let mut body = body.to_owned();
        match language {
            "pbrt" => reader.folder.write(scene, &body),
            "diff" => reader.edit(scene, &body),
            "console" => body = reader.run(&body),
            _ => {}
        }
        made += &format!("{text}```{kind}\n{body}```\n");
        rest = after;
    }
    made += rest;
    assert_eq!(pictures, expected_pictures);
    if without_machine(&made) != without_machine(&page) {
        if updates() {
            std::fs::write(&file, &made).unwrap();
        }
        let (made, page) = (without_machine(&made), without_machine(&page));
        let differing = made.lines().zip(page.lines()).find(|(made, page)| made != page);
        panic!("run with UPDATE_EXPECTED=1, then read git diff; the first lines that differ: {differing:?}");
    }
}
