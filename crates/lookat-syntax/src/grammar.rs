//! The grammar: bytes to statements. After an error, reading continues at the next directive, so that one run finds
//! every mistake.

use crate::advice::{V4_DIRECTIVES, advice, surplus};
use crate::commas::Commas;
use crate::synonyms::directive_advice;
use crate::token::{Fault, Input, Parsing, blank, found, number, shown, word};
use crate::words::is_keyword;
use crate::{Diagnostic, Directive, FileId, ParamType, Span, Statement, Values, nearest};

/// The result of [`parse`].
#[derive(Debug, Default)]
pub struct Parsed {
    /// The directives in the order of the file.
    pub statements: Vec<Statement>,
    /// Violations of the grammar in the order of the file.
    pub diagnostics: Vec<Diagnostic>,
    /// Keywords of directives that only pbrt-v4 has. Each is also reported.
    pub v4_marks: Vec<Span>,
    /// True if the last directive is incomplete, as after an open list: it swallows the text that follows this file.
    pub broken_end: bool,
    /// True if an Include could not be read, so that its contents are unknown.
    pub lost_include: bool,
    /// The approximate memory of the statements, without lists of numbers; see [`number_bytes`].
    pub bytes: u64,
    /// The place where `bytes` reached its limit. The rest of the file is not read.
    pub exhausted: Option<Span>,
    /// The long lists of numbers without mistakes and commas, in the order of the file.
    pub lists: Vec<LongList>,
}

/// A list of at least [`LongList::BYTES`] bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LongList {
    /// The declared type.
    pub ty: ParamType,
    /// Its place, with its brackets.
    pub span: Span,
}

impl LongList {
    /// The fewest bytes of a long list.
    pub const BYTES: usize = 1024;
}

/// Tells the length of a list that the caller knows already, from its declared type and the place of its bracket. It has the bytes of a
/// list of [`Parsed::lists`] of that type.
pub type KnownList<'a> = dyn FnMut(ParamType, usize) -> Option<usize> + 'a;

/// The most bytes of memory for the numbers of a text.
pub fn number_bytes(text: &[u8]) -> u64 {
    let is_inside = |byte: u8| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte);
    let starts = text.windows(2).filter(|pair| !is_inside(pair[0]) && is_inside(pair[1])).count();
    8 * (starts as u64 + 1)
}

/// The memory of a statement and of its data in the scene, without lists, in bytes.
const STATEMENT_BYTES: u64 = 512;
/// The memory of a parameter with one value, in bytes.
const PARAM_BYTES: u64 = 256;
/// The memory of a string in a list, in bytes.
const STRING_BYTES: u64 = 64;

/// Parses one file. `text` may contain any bytes; it need not be UTF-8.
///
/// A text of 4 GiB or more gives one error and no statements.
pub fn parse(file: FileId, text: &[u8]) -> Parsed {
    parse_within(file, text, u64::MAX)
}

/// Like [`parse`], but stops before [`Parsed::bytes`] exceeds `most_bytes`.
pub fn parse_within(file: FileId, text: &[u8], most_bytes: u64) -> Parsed {
    parse_again(file, text, most_bytes, &mut |_, _| None)
}

/// Like [`parse_within`], but leaves out the values of lists that are known: [`Param::is_read`](crate::Param::is_read) is false there.
pub fn parse_again(file: FileId, text: &[u8], most_bytes: u64, known: &mut KnownList) -> Parsed {
    read(Reader { most_bytes, ..Reader::new(file, text, known) }, 0)
}

/// Like [`parse`], from a byte on.
pub(crate) fn parse_from(file: FileId, text: &[u8], start: usize) -> Parsed {
    read(Reader::new(file, text, &mut |_, _| None), start)
}

fn read(mut reader: Reader, start: usize) -> Parsed {
    let (file, text) = (reader.file, reader.text);
    let mut statements = Vec::new();
    if text.len() >= u32::MAX as usize {
        reader
            .diagnostics
            .push(Diagnostic::error(Span { file, start: 0, end: 0 }, "the file is larger than 4 GiB"));
    } else {
        reader.statements(start, &mut statements);
    }
    if let Some(at) = reader.comma {
        let warning = Diagnostic::warning(at, "commas separate these numbers")
            .help("separate numbers by spaces, and use a decimal point; pbrt-v3 ignores the comma and the rest of the word");
        reader.diagnostics.push(warning);
    }
    reader.diagnostics.extend(reader.decimal_comma.take());
    reader.diagnostics.sort_by_key(|diagnostic| diagnostic.span().start);
    let Reader { diagnostics, v4_marks, broken_end, lost_include, bytes, exhausted, lists, .. } = reader;
    Parsed { statements, diagnostics, v4_marks, broken_end, lost_include, bytes, exhausted, lists }
}

/// The values of a list of [`Parsed::lists`].
pub fn read_list(ty: ParamType, text: &[u8]) -> Values {
    let mut known = |_, _| None;
    Reader::new(FileId(0), text, &mut known).values(ty)
}

/// After this many unknown directives, the parser looks for known directives only: the file is probably not a scene.
pub(crate) const MAX_UNKNOWN: usize = 20;

pub(crate) struct Reader<'a> {
    /// Unknown directives so far.
    pub(crate) unknown: usize,
    file: FileId,
    pub(crate) text: Input<'a>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    v4_marks: Vec<Span>,
    pub(crate) broken_end: bool,
    pub(crate) lost_include: bool,
    /// The commas of the current list.
    pub(crate) commas: Commas<'a>,
    /// The first comma that separates numbers.
    pub(crate) comma: Option<Span>,
    /// The error of all lists with decimal commas.
    pub(crate) decimal_comma: Option<Diagnostic>,
    /// The text from the keyword of the current statement on.
    pub(crate) statement: Input<'a>,
    /// Part of the current statement could not be read.
    pub(crate) faulty: bool,
    /// A fraction among the integers of the current parameter has been reported.
    pub(crate) fraction: bool,
    /// The memory of all statements so far and its limit, in bytes; see [`Parsed::bytes`].
    bytes: u64,
    most_bytes: u64,
    exhausted: Option<Span>,
    pub(crate) known: &'a mut KnownList<'a>,
    pub(crate) lists: Vec<LongList>,
}

impl<'a> Reader<'a> {
    fn new(file: FileId, text: Input<'a>, known: &'a mut KnownList<'a>) -> Self {
        Reader {
            unknown: 0,
            file,
            text,
            diagnostics: Vec::new(),
            v4_marks: Vec::new(),
            broken_end: false,
            lost_include: false,
            commas: Commas::default(),
            comma: None,
            decimal_comma: None,
            statement: &[],
            faulty: false,
            fraction: false,
            bytes: 0,
            most_bytes: u64::MAX,
            exhausted: None,
            known,
            lists: Vec::new(),
        }
    }

    fn statements(&mut self, start: usize, statements: &mut Vec<Statement>) {
        let mut input = &self.text[start..];
        // Skip a byte-order mark.
        input = input.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(input);
        while let Ok((start, ())) = blank(input)
            && !start.is_empty()
        {
            (self.statement, self.faulty) = (start, false);
            if self.exhausts(STATEMENT_BYTES, start) {
                break;
            }
            match self.statement(start, statements.last()) {
                // The memory limit is reached, so this statement lacks parameters.
                Ok(_) if self.exhausted.is_some() => break,
                Ok((rest, statement)) => {
                    statements.push(statement);
                    input = rest;
                }
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => {
                    input = self.recover(fault);
                }
                Err(nom::Err::Incomplete(_)) => break,
            }
        }
    }

    /// Counts a parameter. True if it exceeds the memory limit.
    pub(crate) fn exhausts_param(&mut self, at: Input<'a>) -> bool {
        self.exhausts(PARAM_BYTES, at)
    }

    /// Counts a string of a list. True if it exceeds the memory limit.
    pub(crate) fn exhausts_string(&mut self, at: Input<'a>) -> bool {
        self.exhausts(STRING_BYTES, at)
    }

    fn exhausts(&mut self, bytes: u64, at: Input<'a>) -> bool {
        if self.bytes + bytes > self.most_bytes {
            self.broken_end = true;
            self.exhausted.get_or_insert(self.span(&at[..at.len().min(1)]));
            return true;
        }
        self.bytes += bytes;
        false
    }

    pub(crate) fn offset(&self, part: Input<'a>) -> usize {
        part.as_ptr() as usize - self.text.as_ptr() as usize
    }

    pub(crate) fn span(&self, part: Input<'a>) -> Span {
        let start = self.offset(part) as u32;
        Span { file: self.file, start, end: start + part.len() as u32 }
    }

    /// The span between two positions of the input, without trailing white space.
    pub(crate) fn between(&self, start: Input<'a>, rest: Input<'a>) -> Span {
        self.span(start[..start.len() - rest.len()].trim_ascii_end())
    }

    pub(crate) fn report(&mut self, fault: Fault<'a>) {
        // After the memory limit, a fault is only a consequence of unread text.
        if self.exhausted.is_some() {
            return;
        }
        let span = self.span(fault.at);
        let mut diagnostic = Diagnostic::error(span, fault.message);
        diagnostic.help = fault.help;
        if let Some(replacement) = fault.replacement {
            diagnostic = diagnostic.fix(span, replacement);
        }
        self.diagnostics.push(diagnostic);
        self.faulty = true;
    }

    fn statement(&mut self, start: Input<'a>, before: Option<&Statement>) -> Parsing<'a, Statement> {
        let Ok((input, keyword)) = word(start) else { return self.stray(start, before).fail() };
        let (rest, directive) = if is_keyword(keyword) {
            self.directive(input, keyword)?
        } else if number(keyword).is_ok() {
            return self.stray(start, before).fail();
        } else {
            self.misspelled(input, keyword)?
        };
        let statement = Statement {
            directive,
            span: self.between(start, rest),
            keyword: self.span(keyword),
            faulty: self.faulty,
        };
        Ok((rest, statement))
    }

    /// The fault of a value in the place of a directive.
    fn stray(&self, start: Input<'a>, before: Option<&Statement>) -> Fault<'a> {
        let (at, found) = found(start);
        let is_number = number(at).is_ok();
        let found = if is_number { format!("the number {}", shown(at)) } else { found };
        let fault = Fault::new(at, format!("expected a directive, found {found}"));
        // A value on a later line does not belong to that directive.
        let is_beside = |before: &&Statement| {
            let between = &self.text[before.span.end as usize..self.offset(start)];
            !between.contains(&b'\n')
        };
        match before.filter(is_beside).and_then(|before| surplus(&before.directive)) {
            _ if at == b"]" => fault.help("no list is open here: delete it"),
            _ if at == b"[" => fault.help("write the parameter before its list: \"rgb Kd\" [.5 .5 .5]"),
            Some(advice) => fault.help(advice),
            None if is_number => fault.help("put several values of one parameter in brackets: [1 2 3]"),
            None if at.contains(&b' ') => fault.help("write a parameter after its directive"),
            None => fault,
        }
    }

    /// Reports an unknown keyword, and reads it as the nearest known one: a misspelled WorldBegin is one error, not one
    /// for each following directive.
    fn misspelled(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        let fault = self.unknown_directive(keyword);
        let known =
            fault.replacement.as_deref().and_then(|known| Directive::KEYWORDS.iter().find(|k| **k == known));
        match known.map(|known| self.directive(input, known.as_bytes())) {
            Some(Ok(read)) => {
                self.report(fault);
                Ok(read)
            }
            _ => fault.fail(),
        }
    }

    pub(crate) fn unknown_directive(&mut self, keyword: Input<'a>) -> Fault<'a> {
        let name = shown(keyword);
        if V4_DIRECTIVES.contains(&name.as_str()) {
            self.v4_marks.push(self.span(keyword));
            return Fault::new(keyword, format!("{name} is a directive of pbrt-v4, not of pbrt-v3"))
                .help("lookat reads the pbrt-v3 format only");
        }
        self.unknown += 1;
        let fault = Fault::new(keyword, format!("unknown directive `{name}`"));
        if self.unknown > MAX_UNKNOWN {
            return fault.help("further unknown directives are not reported; is this a pbrt-v3 scene?");
        }
        if directive_advice(&name).is_none()
            && let Some(known) = nearest(&name, Directive::KEYWORDS)
        {
            return fault.help(format!("did you mean `{known}`?")).replace_with(known);
        }
        match advice(keyword) {
            Some(advice) => fault.help(advice),
            None => fault,
        }
    }
}
