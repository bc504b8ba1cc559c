//! Prints the diagnostics of a scene.

use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Patch, Renderer, Snippet};
use anstream::adapter::strip_str;
use lookat_scene::syntax::{Diagnostic, Severity, Span};
use lookat_scene::{Loaded, Sources};

use crate::readable::{count, is_active, plural, stand_in, visible, visible_lines};
use crate::standard_error;

/// The most diagnostics of a scene that are printed as text.
const MAX_SHOWN: usize = 100;

/// True if a scene has errors.
pub fn has_errors(loaded: &Loaded) -> bool {
    loaded.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
}

/// The exit status for a scene with errors, or for an unreadable file.
pub fn failure(loaded: &Loaded) -> u8 {
    if loaded.inputs.is_empty() { crate::TROUBLE } else { crate::failure::SCENE_FAULT }
}

/// Prints the diagnostics of a scene to standard error. `quiet` leaves warnings and notes out.
pub fn print(loaded: &Loaded, quiet: bool) {
    let mut out = Vec::new();
    write(&mut out, loaded, quiet, &renderer());
    standard_error::write(out);
}

/// In colors if standard error is a terminal.
fn renderer() -> Renderer {
    if std::io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() }
}

/// Prints diagnostics to standard error.
pub fn print_each(diagnostics: &[Diagnostic], sources: &Sources) {
    let renderer = renderer();
    let mut out = Vec::new();
    for diagnostic in diagnostics {
        let _ = writeln!(out, "{}\n", render(diagnostic, sources, &renderer));
    }
    standard_error::write(out);
}

/// The diagnostics of a scene, as [`print()`] shows them without colors.
pub fn text(loaded: &Loaded) -> String {
    let mut text = Vec::new();
    write(&mut text, loaded, false, &Renderer::plain());
    String::from_utf8_lossy(&text).into_owned()
}

fn write(out: &mut dyn Write, loaded: &Loaded, quiet: bool, renderer: &Renderer) {
    let is_error = |diagnostic: &&Diagnostic| diagnostic.severity == Severity::Error;
    let errors = loaded.diagnostics.iter().filter(is_error).count();
    // Errors come first. Warnings and notes get the remaining room.
    let mut room = [MAX_SHOWN, if quiet { 0 } else { MAX_SHOWN.saturating_sub(errors) }];
    let mut hidden = 0;
    for diagnostic in loaded.diagnostics.iter().filter(|diagnostic| !quiet || is_error(diagnostic)) {
        let room = &mut room[usize::from(!is_error(&diagnostic))];
        if *room == 0 {
            hidden += 1;
            continue;
        }
        *room -= 1;
        let _ = writeln!(out, "{}\n", render(diagnostic, &loaded.sources, renderer));
    }
    if hidden > 0 {
        let more = plural(hidden, "more message", "more messages");
        let _ = writeln!(out, "... and {more}; lookat check --json prints all\n");
    }
    let summary = summary(&loaded.diagnostics, quiet);
    if !summary.is_empty() {
        let _ = writeln!(out, "{}: {summary}", shown_path(&loaded.sources.files[0].path));
    }
}

/// The number of diagnostics, such as "2 errors, 1 warning, 3 notes".
fn summary(diagnostics: &[Diagnostic], quiet: bool) -> String {
    let count = |severity, noun: &str| {
        let alike = diagnostics.iter().filter(|diagnostic| diagnostic.severity == severity).count();
        (alike > 0).then(|| count(alike as u64, noun))
    };
    let errors = count(Severity::Error, "error");
    let others = [(Severity::Warning, "warning"), (Severity::Note, "note")];
    let others = others.into_iter().filter(|_| !quiet).filter_map(|(severity, noun)| count(severity, noun));
    errors.into_iter().chain(others).collect::<Vec<_>>().join(", ")
}

/// A path as printable text.
pub fn shown_path(path: &Path) -> String {
    visible(&path.display().to_string())
}

/// A place as file:line:column.
pub fn place(span: Span, sources: &Sources) -> String {
    let at = sources.location(span);
    format!("{}:{}:{}", shown_path(at.path), at.line, at.column)
}

/// The most other places in the text output. `--json` prints all.
const MOST_PLACES: usize = 10;

/// The other places with the same problem, as file:line:column.
fn other_places(places: &[Span], sources: &Sources) -> Option<String> {
    let listed =
        places.iter().take(MOST_PLACES).map(|span| place(*span, sources)).collect::<Vec<_>>().join(", ");
    let left = match places.len().saturating_sub(MOST_PLACES) {
        0 => String::new(),
        left => format!(", and {left} more"),
    };
    let others = count(places.len() as u64, "other place");
    (!places.is_empty()).then(|| format!("also at {others}: {listed}{left}"))
}

/// One diagnostic with its source lines, in the styles of the renderer. Control characters in foreign text become
/// visible.
fn render(diagnostic: &Diagnostic, sources: &Sources, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let windows: Vec<Window> =
        diagnostic.labels.iter().map(|label| Window::around(label.span, sources)).collect();
    let mut group = Group::with_title(level.primary_title(visible(&diagnostic.message)));
    // Labels in one window share a snippet. The first label is the place of the problem.
    let mut done: Vec<&Window> = Vec::new();
    for window in &windows {
        if done.contains(&window) {
            continue;
        }
        if window.is_empty {
            group = group.element(Origin::path(window.path.as_str()));
            continue;
        }
        done.push(window);
        let mut snippet = window.snippet();
        if window.is_cut {
            // The snippet lacks the start of its line, so it cannot give the right column.
            let first = diagnostic.labels.iter().zip(&windows).find(|(_, w)| *w == window);
            let column = first.map_or(1, |(label, _)| sources.location(label.span).column);
            let origin = Origin::path(window.path.as_str()).line(window.line).char_column(column);
            group = group.element(origin);
        } else {
            snippet = snippet.path(window.path.as_str());
        }
        for (index, (label, _)) in
            diagnostic.labels.iter().zip(&windows).enumerate().filter(|(_, (_, w))| *w == window)
        {
            let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
            let annotation = kind.span(window.range(label.span));
            let text = (!label.text.is_empty()).then(|| visible(&label.text));
            snippet = snippet.annotation(annotation.label(text));
        }
        group = group.element(snippet);
    }
    if let Some(places) = other_places(&diagnostic.places, sources) {
        group = group.element(Level::NOTE.message(places));
    }
    let help = diagnostic.help.as_deref().map(visible);
    let title = || help.clone().unwrap_or_else(|| "write it like this".into());
    let fix_window = diagnostic.fix.as_ref().map(|fix| (fix, Window::around(fix.span, sources)));
    let rendered = match &fix_window {
        // A window shows one line.
        Some((fix, _)) if sources.word(fix.span).contains('\n') => {
            let text = match fix.replacement.as_str() {
                "" => title(),
                replacement => format!("{}: {}", title(), visible(replacement)),
            };
            renderer.render(&[group.element(Level::HELP.message(text))])
        }
        Some((fix, window)) if window.text.len() <= LONGEST_MENDED => {
            let patch = Patch::new(window.range(fix.span), visible_lines(&fix.replacement));
            let help = Group::with_title(Level::HELP.secondary_title(title()));
            renderer.render(&[group, help.element(window.snippet().path(window.path.as_str()).patch(patch))])
        }
        _ => renderer.render(&[match help {
            Some(help) => group.element(Level::HELP.message(help)),
            None => group,
        }]),
    };
    if !windows.iter().any(|window| window.is_cut) {
        return rendered;
    }
    // If a place is not in its snippet, the renderer marks the snippet as another file.
    let is_mark = |line: &&str| strip_str(line).to_string().trim() == ":::";
    rendered.lines().filter(|line| !is_mark(line)).collect::<Vec<_>>().join("\n")
}

/// The longest line that is printed again with its fix, in bytes. The renderer prints all of it.
const LONGEST_MENDED: usize = 400;

/// The readable part of the lines around a span. Files may have lines of megabytes.
#[derive(PartialEq)]
struct Window {
    path: String,
    /// The offset of the text in the file.
    start: usize,
    line: usize,
    text: String,
    /// The offset in `text` for each byte of the window, and for its end.
    places: Vec<usize>,
    /// True if the file is empty or unreadable.
    is_empty: bool,
    /// True if the text starts inside a line.
    is_cut: bool,
}

/// The most bytes of a line before and after the start of a span. The renderer prints fewer.
const BEFORE: usize = 1 << 16;
const AFTER: usize = 160;

impl Window {
    fn around(span: Span, sources: &Sources) -> Self {
        let source = sources.file(span.file);
        let text = &source.text;
        let at = (span.start as usize).min(text.len());
        let is_end = |byte: &u8| *byte == b'\n';
        let earliest = at.saturating_sub(BEFORE);
        let newline = text[earliest..at].iter().rposition(is_end);
        let start = newline.map_or(earliest, |newline| earliest + newline + 1);
        let latest = text.len().min(at + AFTER);
        let end = text[at..latest].iter().position(is_end).map_or(latest, |newline| at + newline);
        let path = shown_path(&source.path);
        // The line of a Windows file ends before its carriage return.
        let line = text[start..end].strip_suffix(b"\r").unwrap_or(&text[start..end]);
        let (shown, places) = readable(line);
        Window {
            path,
            start,
            line: sources.location(span).line,
            text: shown,
            places,
            is_empty: source.text.is_empty(),
            is_cut: start > 0 && !is_end(&text[start - 1]),
        }
    }

    fn snippet<'w, T: Clone>(&'w self) -> Snippet<'w, T> {
        Snippet::source(self.text.as_str()).line_start(self.line)
    }

    /// Converts a span of the file to a range of the text.
    fn range(&self, span: Span) -> Range<usize> {
        let place = |at: u32| {
            let byte = (at as usize).saturating_sub(self.start).min(self.places.len() - 1);
            self.places[byte]
        };
        place(span.start)..place(span.end)
    }
}

/// Bytes as printable text, and the offset of each byte in it.
fn readable(bytes: &[u8]) -> (String, Vec<usize>) {
    let (mut text, mut places) = (String::new(), Vec::new());
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            places.extend(std::iter::repeat_n(text.len(), c.len_utf8()));
            text.push(if is_active(c) && c != '\t' { stand_in(c) } else { c });
        }
        for _ in chunk.invalid() {
            places.push(text.len());
            text.push('\u{fffd}');
        }
    }
    places.push(text.len());
    (text, places)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lookat_scene::{LoadOptions, load};

    use super::*;

    /// The printed diagnostics of a scene, without styles.
    fn printed(text: &str) -> String {
        let loaded = load(Path::new("a.pbrt"), &|_| Ok(text.into()), &LoadOptions::default());
        let render = |diagnostic| render(diagnostic, &loaded.sources, &Renderer::styled());
        strip_str(&loaded.diagnostics.iter().map(render).collect::<String>()).to_string()
    }

    /// The output for a cut line omits only the mark of another file.
    #[test]
    fn cut_lines_are_shown() {
        let blanks = " ".repeat(BEFORE);
        let printed = printed(&format!("WorldBegin{blanks} Shaep \"sphere\" # end :::"));
        let source = |line: &&str| line.starts_with("1 |") && line.ends_with("Shaep \"sphere\" # end :::");
        assert!(printed.lines().any(|line| source(&line)), "{printed}");
        assert!(!printed.lines().any(|line| line.trim() == ":::"), "{printed}");
        assert!(printed.contains(&format!("a.pbrt:1:{}", "WorldBegin".len() + BEFORE + 2)), "{printed}");
    }
}
