//! Opens places in the editor, and the page in the browser.

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use lookat_image::{TemporaryFile, TemporaryName, io_reason};

use crate::args;
use crate::failure::Failure;

/// How editors take the place, by the names of their programs.
const PLACES: [(&[&str], &[&str]); 5] = [
    (&["code", "code-insiders", "codium", "cursor", "windsurf"], &["--goto", "{file}:{line}:{column}"]),
    (&["subl", "zed", "hx", "helix", "mate"], &["{file}:{line}:{column}"]),
    (
        &["vi", "vim", "nvim", "gvim", "nano", "micro", "kak", "emacs", "emacsclient", "gedit"],
        &["+{line}", "{file}"],
    ),
    (&["kate", "kwrite", "idea", "clion", "rustrover", "pycharm"], &["--line", "{line}", "{file}"]),
    (&["notepad++"], &["-n{line}", "{file}"]),
];
/// The editors that need the terminal.
const IN_TERMINAL: [&str; 8] = ["vi", "vim", "nvim", "nano", "micro", "kak", "hx", "helix"];

/// An editor: a program and its arguments, with `{file}`, `{line}` and `{column}`.
#[derive(Debug)]
pub struct Editor {
    words: Vec<String>,
    /// Whether one runs.
    is_open: Arc<AtomicBool>,
}

impl Editor {
    /// The editor of `--editor`, or else of the environment. Fails if the option names none.
    pub fn new(arguments: &args::View) -> Result<Option<Editor>, Failure> {
        if let Some(words) = &arguments.editor {
            return Editor::parse(words)
                .map(Some)
                .ok_or_else(|| format!("--editor {words:?} names no program").into());
        }
        let named = ["VISUAL", "EDITOR"].into_iter().filter_map(|name| std::env::var(name).ok());
        Ok(named
            .filter_map(|words| Editor::parse(&words))
            .find(|editor| !editor.is_in_terminal() || std::io::stdin().is_terminal()))
    }

    fn parse(words: &str) -> Option<Editor> {
        let mut words = shlex::split(words).filter(|words| !words.is_empty())?;
        if !words.iter().any(|word| word.contains("{file}")) {
            let program = Path::new(&words[0]).file_stem()?.to_str()?;
            let known = PLACES.iter().find(|(programs, _)| programs.contains(&program));
            words
                .extend(known.map_or(&["{file}"][..], |(_, place)| *place).iter().map(|word| (*word).into()));
        }
        Some(Editor { words, is_open: Arc::default() })
    }

    fn is_in_terminal(&self) -> bool {
        let program = Path::new(&self.words[0]).file_stem().and_then(|stem| stem.to_str());
        program.is_some_and(|program| IN_TERMINAL.contains(&program))
    }

    /// Opens a place, and does not wait for the editor to end.
    pub fn open(&self, path: &Path, line: usize, column: usize) -> Result<(), Failure> {
        if self.is_in_terminal() && self.is_open.load(Ordering::Relaxed) {
            bail!("the editor is already open in the terminal");
        }
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        let mut words = self.words(&path.display().to_string(), line, column).into_iter();
        let program = words.next().unwrap_or_default();
        let mut editor = Command::new(&program)
            .args(words)
            .spawn()
            .map_err(|error| format!("cannot start the editor {program}: {}", io_reason(&error)))?;
        let is_open = self.is_open.clone();
        is_open.store(true, Ordering::Relaxed);
        std::thread::spawn(move || {
            let _ = editor.wait();
            is_open.store(false, Ordering::Relaxed);
        });
        Ok(())
    }

    fn words(&self, path: &str, line: usize, column: usize) -> Vec<String> {
        let numbers =
            |word: &str| word.replace("{line}", &line.to_string()).replace("{column}", &column.to_string());
        // The path comes last: it may contain braces.
        self.words.iter().map(|word| numbers(word).replace("{file}", path)).collect()
    }
}

/// How long a browser may take to start.
const UNTIL_READ: Duration = Duration::from_secs(30);

/// The file that leads to the address.
const PAGE: TemporaryName = TemporaryName { prefix: "lookat-", suffix: ".html", is_private: true };

/// Opens an address in the browser, and waits until it has read it. The browser gets a file that leads there, because others on this computer can
/// see the command line, and the address is a secret.
pub fn open_in_browser(address: &str) -> Result<(), Failure> {
    let page = format!(
        "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url={address}\"><title>lookat</title>"
    );
    let mut file = TemporaryFile::new(&std::env::temp_dir(), PAGE).map_err(|error| io_reason(&error))?;
    file.file.write_all(page.as_bytes()).map_err(|error| io_reason(&error))?;
    let quiet = Stdio::null;
    match Command::new(OPENER).arg(file.path()).stdin(quiet()).stdout(quiet()).stderr(quiet()).status() {
        // The explorer of Windows always fails.
        Ok(status) if status.success() || cfg!(windows) => {}
        Ok(status) => bail!("{OPENER}: {status}"),
        Err(error) => bail!("{OPENER}: {}", io_reason(&error)),
    }
    // The browser may read it after its program has ended. The end of this function removes it, and so does the end of the program.
    std::thread::sleep(UNTIL_READ);
    Ok(())
}

/// The program that opens a file in the program of its type.
const OPENER: &str = if cfg!(target_os = "macos") {
    "open"
} else if cfg!(windows) {
    "explorer"
} else {
    "xdg-open"
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn editors_get_the_place() {
        let words = |editor: &str| Editor::parse(editor).unwrap().words("/a {line}/b.pbrt", 7, 3).join("|");
        for (editor, expected) in [
            ("code -w", "code|-w|--goto|/a {line}/b.pbrt:7:3"),
            ("/usr/bin/vim", "/usr/bin/vim|+7|/a {line}/b.pbrt"),
            ("hx", "hx|/a {line}/b.pbrt:7:3"),
            ("kate", "kate|--line|7|/a {line}/b.pbrt"),
            ("ed", "ed|/a {line}/b.pbrt"),
            ("mine -l{line} -c {column} '{file}'", "mine|-l7|-c|3|/a {line}/b.pbrt"),
        ] {
            assert_eq!(words(editor), expected);
        }
        assert!(["", "  ", "'open"].iter().all(|words| Editor::parse(words).is_none()));
    }
}
