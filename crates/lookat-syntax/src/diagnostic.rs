//! Problems of a file as data, and places in source text. The program decides how to print them.

/// The severity of a problem. `docs/architecture.md` has the rule that decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The picture is right: it equals the picture of pbrt-v3, except for noise.
    Note,
    /// The picture is probably not what the author meant, or it differs from the picture of pbrt-v3.
    Warning,
    /// No scene can be rendered.
    Error,
}

/// A place in the source and a remark about it. With an empty remark the place is only underlined.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Label {
    /// The bytes to underline.
    pub span: Span,
    /// A few words, lower case, without a full stop.
    pub text: String,
}

/// A replacement of source text that solves the problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// The bytes to replace.
    pub span: Span,
    /// The new text.
    pub replacement: String,
}

/// One problem of a scene file.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnostic {
    /// Error, warning or note.
    pub severity: Severity,
    /// The problem in the terms of the format: lower case, no full stop.
    pub message: String,
    /// The first label is the place of the problem; the others are related places.
    pub labels: Vec<Label>,
    /// The solution in words.
    pub help: Option<String>,
    /// The solution as an edit.
    pub fix: Option<Fix>,
    /// Other places with the same problem, each once, in reading order.
    pub places: Vec<Span>,
}

impl Diagnostic {
    /// An error at `span`.
    pub fn error(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, span, message)
    }

    /// A warning at `span`.
    pub fn warning(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, span, message)
    }

    /// A note at `span`. ([`Diagnostic::note`] is the text beside the underlined place.)
    pub fn note_at(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, span, message)
    }

    /// A problem at `span`.
    pub fn new(severity: Severity, span: Span, message: impl Into<String>) -> Self {
        let message = message.into();
        let labels = vec![Label { span, text: String::new() }];
        Diagnostic { severity, message, labels, help: None, fix: None, places: Vec::new() }
    }

    /// Adds a remark beside the underlined text.
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.labels[0].text = text.into();
        self
    }

    /// Underlines a related place.
    pub fn related(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds the solution in words.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Adds the solution as an edit.
    pub fn fix(mut self, span: Span, replacement: impl Into<String>) -> Self {
        self.fix = Some(Fix { span, replacement: replacement.into() });
        self
    }

    /// This problem as the failure of a function.
    pub fn fail<T>(self) -> Result<T, Box<Diagnostic>> {
        Err(Box::new(self))
    }

    /// The place of the problem.
    pub fn span(&self) -> Span {
        self.labels[0].span
    }

    /// All places with this problem, the first included.
    pub fn all_places(&self) -> impl Iterator<Item = Span> {
        std::iter::once(self.span()).chain(self.places.iter().copied())
    }
}

/// The file of a [`Span`]. The caller of [`crate::parse`] chooses the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FileId(pub u32);

/// A half-open range of bytes in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// Offset of the first byte.
    pub start: u32,
    /// Offset after the last byte.
    pub end: u32,
}

impl Span {
    /// From the start of `self` to the end of `other`, which lies in the same file.
    pub fn to(self, other: Span) -> Span {
        Span { file: self.file, start: self.start, end: other.end.max(self.start) }
    }
}

/// A value and its place in the source. Equality compares the values alone.
#[derive(Debug, Clone)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its place.
    pub span: Span,
}

impl<T: PartialEq> PartialEq for Spanned<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

/// A quoted string, without its quotes and with its escapes decoded. The span includes the quotes.
pub type Text = Spanned<String>;
