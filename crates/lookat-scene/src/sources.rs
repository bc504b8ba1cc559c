//! The files that a scene was read from.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

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
    pub text: Arc<Vec<u8>>,
    /// The `Include` that names it; `None` for the scene file.
    pub included_at: Option<Span>,
    /// The starts of its lines, computed on first use.
    line_starts: OnceLock<Vec<usize>>,
    /// The characters before each [`BLOCK`] of bytes, computed on first use, because a line may be megabytes long.
    characters: OnceLock<Vec<usize>>,
}

/// The block size in bytes. Each lookup counts the characters of at most one block.
const BLOCK: usize = 4096;

impl Source {
    pub(crate) fn new(path: PathBuf, text: Arc<Vec<u8>>, included_at: Option<Span>) -> Self {
        Source { path, text, included_at, line_starts: OnceLock::new(), characters: OnceLock::new() }
    }

    fn line_starts(&self) -> &[usize] {
        self.line_starts.get_or_init(|| {
            let ends = self.text.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
            std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect()
        })
    }

    /// The number of characters before a byte. UTF-8 continuation bytes do not count.
    fn characters_before(&self, at: usize) -> usize {
        let count = |bytes: &[u8]| bytes.iter().filter(|byte| **byte & 0xC0 != 0x80).count();
        let blocks = self.characters.get_or_init(|| {
            let sums = self.text.chunks(BLOCK).scan(0, |sum, block| {
                *sum += count(block);
                Some(*sum)
            });
            std::iter::once(0).chain(sums).collect()
        });
        let block = at / BLOCK;
        blocks[block] + count(&self.text[block * BLOCK..at])
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
    /// The file of a span.
    pub fn file(&self, id: FileId) -> &Source {
        &self.files[id.0 as usize]
    }

    /// The line of the start of a span, from 1.
    pub(crate) fn line(&self, span: Span) -> usize {
        self.file(span.file).line_starts().partition_point(|start| *start <= span.start as usize)
    }

    /// The line and column of the start of a span.
    pub fn location(&self, span: Span) -> Location<'_> {
        let (source, line) = (self.file(span.file), self.line(span));
        let at = (span.start as usize).min(source.text.len());
        let start = source.line_starts()[line - 1];
        // A byte-order mark takes no column.
        let marks = usize::from(source.text[start..at].starts_with(b"\xEF\xBB\xBF"));
        let column = source.characters_before(at) - source.characters_before(start) - marks + 1;
        Location { path: &source.path, line, column }
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
        let text = "é\n".to_owned() + &"aé漢".repeat(BLOCK) + "\nb";
        let characters: Vec<(usize, char)> = text.char_indices().collect();
        let source = Source::new("a.pbrt".into(), Arc::new(text.clone().into_bytes()), None);
        let sources = Sources { files: vec![source] };
        for index in (0..characters.len()).step_by(997).chain([characters.len() - 1]) {
            let at = characters[index].0;
            let place = sources.location(Span { file: FileId(0), start: at as u32, end: at as u32 });
            let line = text[..at].rsplit('\n').next().unwrap_or_default();
            assert_eq!(place.column, line.chars().count() + 1, "{at}");
        }
    }
}
