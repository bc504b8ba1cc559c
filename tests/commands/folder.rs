//! A folder in which the program runs, and what comes of that.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use lookat_image::Image;
use tempfile::TempDir;

/// A folder with scenes.
pub struct Folder(pub TempDir);

/// How a run of the program ended.
pub struct Run {
    pub status: i32,
    pub out: String,
    pub err: String,
}

impl Folder {
    pub fn empty() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// The program, to be run here.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lookat"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        let run = Run::of(self.command(arguments).output().unwrap());
        assert_options_exist(arguments, &run.err);
        run
    }
}

/// A message names only options that the command has, or the command that has them, as in `lookat render --spp`.
fn assert_options_exist(arguments: &[&str], message: &str) {
    // The parser of the command line repeats what was typed.
    if message.contains("Usage: ") || message.contains("try '--help'") {
        return;
    }
    for line in message.lines().filter(|line| !line.contains(" | ")) {
        let mut command = arguments.first().copied().unwrap_or_default();
        let is_part = |c: char| c.is_alphanumeric() || "-./".contains(c);
        let words: Vec<&str> = line.split(|c| !is_part(c)).map(|word| word.trim_end_matches('.')).collect();
        for (at, word) in words.iter().enumerate() {
            let is_option = match word.strip_prefix('-') {
                Some(rest) if rest.len() == 1 => rest.chars().all(char::is_alphabetic),
                Some(rest) => rest.starts_with('-') && rest.len() > 2,
                None => false,
            };
            let is_other = at > 0 && words[at - 1] == "lookat" && !help(word).is_empty();
            if is_other {
                command = word;
            }
            // The option of bash, and a name that the user chose.
            let is_foreign = at > 0 && words[at - 1] == "ulimit" || arguments.contains(word);
            let is_known = || help(command).split(|c| !is_part(c)).any(|known| known == *word);
            assert!(!is_option || is_foreign || is_known(), "{command} has no {word}: {message}");
        }
    }
}

/// The help of a command. Empty if there is no such command.
fn help(command: &str) -> String {
    static HELP: Mutex<Option<HashMap<String, String>>> = Mutex::new(None);
    let mut known = HELP.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    let read = || {
        let run = Command::new(env!("CARGO_BIN_EXE_lookat")).args([command, "--help"]).output().unwrap();
        if run.status.success() { Run::of(run).out } else { String::new() }
    };
    known.entry(command.into()).or_insert_with(read).clone()
}

impl Run {
    pub fn of(output: std::process::Output) -> Run {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run { status: output.status.code().unwrap(), out: text(output.stdout), err: text(output.stderr) }
    }
}

/// True if expected results are written instead of compared.
pub fn updates() -> bool {
    std::env::var_os("UPDATE_EXPECTED").is_some()
}

/// Checks that a picture looks like an expected one, or replaces the expected one.
#[track_caller]
pub fn compare_pictures(made: &Path, expected: &Path) {
    if updates() {
        std::fs::create_dir_all(expected.parent().unwrap()).unwrap();
        std::fs::copy(made, expected).unwrap();
    }
    let name = expected.display();
    let [a, b] = [made, expected].map(|file| Image::read(file).unwrap());
    assert_eq!(a.data_window, b.data_window, "{name}");
    let [a, b] = [a, b].map(|image| image.rgb().unwrap().concat());
    let difference: f32 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
    let brightness: f32 = b.iter().sum();
    assert!(difference < 0.02 * brightness, "{name} differs by {}", difference / brightness);
}
