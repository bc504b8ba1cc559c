//! The files that a scene was read from.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use lookat_syntax::{FileId, Span, value_span};

/// All files of a scene, in the order in which they were read. A file that is included twice is listed twice.
#[derive(Debug, Default)]
pub struct Sources {
    /// The files; a [`FileId`] is an index into them.
    pub files: Vec<Source>,
}

/// One file.
#[derive(Debug)]
pub struct Source {
    /// Its path, as it was opened.
    pub path: PathBuf,
    /// What it holds.
    pub text: Arc<Vec<u8>>,
    /// The `Include` that named it; none for the scene file itself.
    pub included_at: Option<Span>,
    /// Where its lines start, once somebody has asked.
    line_starts: OnceLock<Vec<usize>>,
}

impl Source {
    pub(crate) fn new(path: PathBuf, text: Arc<Vec<u8>>, included_at: Option<Span>) -> Self {
        Source { path, text, included_at, line_starts: OnceLock::new() }
    }

    fn line_starts(&self) -> &[usize] {
        self.line_starts.get_or_init(|| {
            let ends = self.text.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
            std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect()
        })
    }
}

/// A place as people read it.
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

    /// The line that a span begins in, from 1.
    pub(crate) fn line(&self, span: Span) -> usize {
        self.file(span.file).line_starts().partition_point(|start| *start <= span.start as usize)
    }

    /// Line and column of the first byte of a span.
    pub fn location(&self, span: Span) -> Location<'_> {
        let (source, line) = (self.file(span.file), self.line(span));
        let at = (span.start as usize).min(source.text.len());
        let before = &source.text[source.line_starts()[line - 1]..at];
        // Bytes that continue a UTF-8 character start no column; nor does a byte-order mark.
        let text = before.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(before);
        let column = text.iter().filter(|byte| **byte & 0xC0 != 0x80).count() + 1;
        Location { path: &source.path, line, column }
    }

    /// What stands there.
    pub(crate) fn text(&self, span: Span) -> &[u8] {
        self.file(span.file).text.get(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// The place of one number or string of a list of values.
    pub(crate) fn value_span(&self, list: Span, index: usize) -> Span {
        value_span(&self.file(list.file).text, list, index)
    }

    /// Sorts in the order in which the scene is read: a place in an included file comes at its `Include`.
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
