//! The files that a scene was read from.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use bytes::Bytes;
use lookat_syntax::{FileId, Span, value_span};

/// The text files of a scene in reading order. A file that is included twice appears twice.
#[derive(Debug, Default)]
pub struct Sources {
    /// The files; a [`FileId`] is an index into them.
    pub files: Vec<Source>,
}

/// One file.
#[derive(Debug)]
pub struct Source {
    /// The path used to open it.
    pub path: PathBuf,
    /// Its contents.
    pub text: Bytes,
    /// The `Include` that names it; `None` for the scene file.
    pub included_at: Option<Span>,
    /// The lines and characters before each [`BLOCK`] of bytes, as far as a place has been looked up: a text has millions of lines, and a
    /// line may be megabytes long.
    counts: Mutex<Vec<Counts>>,
}

/// Ends of lines, and characters.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    lines: usize,
    characters: usize,
}

/// The block size in bytes. Each lookup counts in at most one block.
const BLOCK: usize = 4096;

impl Counts {
    /// UTF-8 continuation bytes are no characters.
    fn of(bytes: &[u8]) -> Counts {
        let count = |is_one: fn(&&u8) -> bool| bytes.iter().filter(is_one).count();
        Counts { lines: count(|byte| **byte == b'\n'), characters: count(|byte| **byte & 0xC0 != 0x80) }
    }

    fn and(self, other: Counts) -> Counts {
        Counts { lines: self.lines + other.lines, characters: self.characters + other.characters }
    }
}

impl Source {
    pub(crate) fn new(path: PathBuf, text: Bytes, included_at: Option<Span>) -> Self {
        Source { path, text, included_at, counts: Mutex::default() }
    }

    /// The lines and characters before a byte.
    fn before(&self, at: usize) -> Counts {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        let block = at / BLOCK;
        while counts.len() <= block {
            let last = counts.last().copied().unwrap_or_default();
            let next =
                counts.len().checked_sub(1).map(|last| Counts::of(&self.text[last * BLOCK..][..BLOCK]));
            counts.push(last.and(next.unwrap_or_default()));
        }
        counts[block].and(Counts::of(&self.text[block * BLOCK..at]))
    }

    /// The first byte of a line, from 0, before a byte that has been looked up.
    fn line_start(&self, line: usize) -> usize {
        let counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        // The block with the end of the line before.
        let Some(block) = counts.partition_point(|counts| counts.lines < line).checked_sub(1) else {
            return 0;
        };
        let mut ends = (block * BLOCK..).zip(&self.text[block * BLOCK..]).filter(|(_, byte)| **byte == b'\n');
        ends.nth(line - counts[block].lines - 1).map_or(0, |(end, _)| end + 1)
    }
}

/// A place for people to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location<'a> {
    /// The file.
    pub path: &'a Path,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Sources {
    /// The word at a place, without its quotation marks.
    pub fn word(&self, span: Span) -> String {
        let text = self.file(span.file).text.get(span.start as usize..span.end as usize);
        String::from_utf8_lossy(text.unwrap_or_default()).trim_matches('"').to_owned()
    }

    /// The file of a span.
    pub fn file(&self, id: FileId) -> &Source {
        &self.files[id.0 as usize]
    }

    /// The line of the start of a span, from 1.
    pub(crate) fn line(&self, span: Span) -> usize {
        let source = self.file(span.file);
        source.before((span.start as usize).min(source.text.len())).lines + 1
    }

    /// The line and column of the start of a span.
    pub fn location(&self, span: Span) -> Location<'_> {
        let source = self.file(span.file);
        let at = (span.start as usize).min(source.text.len());
        let before = source.before(at);
        let start = source.line_start(before.lines);
        let line = source.before(start);
        // A byte-order mark takes no column.
        let marks = usize::from(source.text[start..at].starts_with(b"\xEF\xBB\xBF"));
        let column = before.characters - line.characters - marks + 1;
        Location { path: &source.path, line: before.lines + 1, column }
    }

    /// The end of a file.
    pub(crate) fn end(&self, file: FileId) -> Span {
        let end = self.file(file).text.len() as u32;
        Span { file, start: end, end }
    }

    /// The bytes of a span.
    pub(crate) fn text(&self, span: Span) -> &[u8] {
        self.file(span.file).text.get(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// The place of one value in a list.
    pub(crate) fn value_span(&self, list: Span, index: usize) -> Span {
        value_span(&self.file(list.file).text, list, index)
    }

    /// The sort key of reading order: a place in an included file sorts at its `Include`.
    pub(crate) fn reading_order(&self, span: Span) -> Vec<u32> {
        let mut key = vec![span.start];
        let mut at = self.file(span.file).included_at;
        while let Some(include) = at {
            key.push(include.start);
            at = self.file(include.file).included_at;
        }
        key.reverse();
        key
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters_of_long_lines() {
        let text = "é\n".to_owned() + &"aé漢".repeat(BLOCK) + "\nb" + &"c\n\nd".repeat(BLOCK);
        let characters: Vec<(usize, char)> = text.char_indices().collect();
        let source = Source::new("a.pbrt".into(), text.clone().into(), None);
        let sources = Sources { files: vec![source] };
        for index in (0..characters.len()).step_by(997).chain([characters.len() - 1]) {
            let at = characters[index].0;
            let place = sources.location(Span { file: FileId(0), start: at as u32, end: at as u32 });
            let line = text[..at].rsplit('\n').next().unwrap_or_default();
            assert_eq!(place.column, line.chars().count() + 1, "{at}");
            assert_eq!(place.line, text[..at].split('\n').count(), "{at}");
        }
    }
}
