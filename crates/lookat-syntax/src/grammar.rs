//! The grammar: bytes to statements. After an error, reading continues at the next directive, so that one run finds
//! every mistake.

use crate::advice::{V4_DIRECTIVES, advice, surplus, synonym};
use crate::token::{Input, Parsing, SyntaxError, blank, found, is_keyword, number, shown, word};
use crate::{Diagnostic, Directive, FileId, ParamType, Span, Statement, Values, nearest};

/// The result of [`parse`], or one block of a [`Parser`].
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
    /// The approximate memory of what the statements add to the scene, without lists of numbers; see [`number_bytes`].
    pub bytes: u64,
    /// The place where `bytes` reached its limit. The rest of the file is not read.
    pub exhausted: Option<Span>,
    /// The long lists of numbers without mistakes and commas, in the order of the file.
    pub lists: Vec<LongList>,
    /// True if the file ends after these statements.
    pub is_last: bool,
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

/// The memory of a parameter with one value, in bytes.
pub(crate) const PARAM_BYTES: u64 = 256;
/// The memory of a string in a list, in bytes.
pub(crate) const STRING_BYTES: u64 = 64;

/// The memory of what a directive adds to the scene, without parameters, in bytes.
fn scene_bytes(directive: &Directive) -> u64 {
    match directive {
        // A transformation and its inverse.
        Directive::ObjectInstance(_) => 304,
        Directive::CoordinateSystem(_)
        | Directive::ObjectBegin(_)
        | Directive::Texture { .. }
        | Directive::Entity(..)
        | Directive::Include { .. } => 512,
        Directive::Rotate(_) => 64,
        // They change the graphics state, which blocks save and restore. Their places may be kept.
        _ => 16,
    }
}

/// Parses one file. `text` may contain any bytes; it need not be UTF-8.
///
/// A text of 4 GiB or more gives one error and no statements.
pub fn parse(file: FileId, text: &[u8]) -> Parsed {
    parse_from(file, text, 0)
}

/// Like [`parse`], from a byte on.
pub(crate) fn parse_from(file: FileId, text: &[u8], start: usize) -> Parsed {
    Parser::from(Reader::new(file, text, &mut |_, _| None), start)
        .next_block(usize::MAX, u64::MAX)
        .unwrap_or_default()
}

/// Reads a file block by block, so that the statements of one block are in memory at a time.
pub struct Parser<'a> {
    reader: Reader<'a>,
    /// The text from the next statement on.
    rest: Input<'a>,
    /// The last statement that was read. The next block begins with it, because the text after it may add to it.
    last: Option<Statement>,
    has_ended: bool,
}

impl<'a> Parser<'a> {
    /// `known` tells which lists to leave out: [`Param::is_read`](crate::Param::is_read) is false there.
    pub fn new(file: FileId, text: &'a [u8], known: &'a mut KnownList<'a>) -> Self {
        Parser::from(Reader::new(file, text, known), 0)
    }

    fn from(mut reader: Reader<'a>, start: usize) -> Self {
        let mut rest = &reader.text[start..];
        if reader.text.len() >= u32::MAX as usize {
            let start = Span { file: reader.file, start: 0, end: 0 };
            reader.parsed.diagnostics.push(Diagnostic::error(start, "the file is larger than 4 GiB"));
            rest = &[];
        }
        // Skip a byte-order mark.
        rest = rest.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(rest);
        Parser { reader, rest, last: None, has_ended: false }
    }

    /// The next statements, `most` or fewer, and what was found with them. `None` after the last block. Stops before [`Parsed::bytes`]
    /// exceeds `most_bytes`, and then ends.
    pub fn next_block(&mut self, most: usize, most_bytes: u64) -> Option<Parsed> {
        if self.has_ended {
            return None;
        }
        let reader = &mut self.reader;
        reader.most_bytes = most_bytes;
        let mut statements: Vec<Statement> = self.last.take().into_iter().collect();
        while statements.len() <= most && !self.has_ended {
            match reader.next_statement(self.rest, statements.last()) {
                Some((rest, statement)) => {
                    statements.extend(statement);
                    self.rest = rest;
                }
                None => self.has_ended = true,
            }
        }
        self.has_ended |= reader.parsed.exhausted.is_some();
        reader.report_commas(self.has_ended);
        if !self.has_ended {
            self.last = statements.pop();
        }
        let mut parsed = std::mem::take(&mut reader.parsed);
        parsed.diagnostics.sort_by_key(|diagnostic| diagnostic.span().start);
        Some(Parsed { statements, is_last: self.has_ended, ..parsed })
    }
}

/// The values of a list of [`Parsed::lists`].
pub fn read_list(ty: ParamType, text: &[u8]) -> Values {
    let mut known = |_, _| None;
    Reader::new(FileId(0), text, &mut known).values(ty)
}

/// After this many unknown directives, the parser looks for known directives only: the file is probably not a scene.
pub(crate) const MAX_UNKNOWN: usize = 20;

/// The commas of one list.
#[derive(Default)]
pub(crate) struct Commas<'a> {
    pub first: Option<Input<'a>>,
    /// The first word that may be one number with a decimal comma, such as `-1,25`.
    pub decimal: Option<Input<'a>>,
    /// The last one.
    pub last_decimal: Option<Input<'a>>,
    /// True if a comma can only separate values, as in `1, 2` and `1,2,3`.
    pub separates: bool,
}

pub(crate) struct Reader<'a> {
    /// Unknown directives so far.
    pub(crate) unknown: usize,
    file: FileId,
    pub(crate) text: Input<'a>,
    /// What was found in the current block, besides its statements.
    pub(crate) parsed: Parsed,
    /// The commas of the current list.
    pub(crate) commas: Commas<'a>,
    /// The first comma that separates numbers.
    pub(crate) comma: Option<Span>,
    /// The lists with decimal commas that are not reported yet.
    pub(crate) decimal_commas: Vec<Span>,
    /// The error of the first one.
    pub(crate) decimal_comma: Option<Diagnostic>,
    /// The text from the keyword of the current statement on.
    pub(crate) statement: Input<'a>,
    /// Part of the current statement could not be read.
    pub(crate) faulty: bool,
    /// A fraction among the integers of the current parameter has been reported.
    pub(crate) fraction: bool,
    /// The limit of [`Parsed::bytes`].
    most_bytes: u64,
    pub(crate) known: &'a mut KnownList<'a>,
}

impl<'a> Reader<'a> {
    fn new(file: FileId, text: Input<'a>, known: &'a mut KnownList<'a>) -> Self {
        Reader {
            unknown: 0,
            file,
            text,
            parsed: Parsed::default(),
            commas: Commas::default(),
            comma: None,
            decimal_commas: Vec::new(),
            decimal_comma: None,
            statement: &[],
            faulty: false,
            fraction: false,
            most_bytes: u64::MAX,
            known,
        }
    }

    /// The statement at the start of the input, and the rest. No statement if it is unreadable. `None` at the end.
    fn next_statement(
        &mut self,
        input: Input<'a>,
        before: Option<&Statement>,
    ) -> Option<(Input<'a>, Option<Statement>)> {
        let (start, ()) = blank(input).ok().filter(|(start, ())| !start.is_empty())?;
        (self.statement, self.faulty) = (start, false);
        match self.statement(start, before) {
            // The memory limit is reached, so this statement lacks parameters.
            Ok(_) if self.parsed.exhausted.is_some() => None,
            Ok((rest, statement)) => {
                if self.exhausts(scene_bytes(&statement.directive), start) {
                    return None;
                }
                Some((rest, Some(statement)))
            }
            Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => Some((self.recover(fault), None)),
            Err(nom::Err::Incomplete(_)) => None,
        }
    }

    /// Counts the bytes that a part of the text adds to the scene. True if they exceed the memory limit.
    pub(crate) fn exhausts(&mut self, bytes: u64, at: Input<'a>) -> bool {
        if self.parsed.bytes + bytes > self.most_bytes {
            self.parsed.broken_end = true;
            self.parsed.exhausted = self.parsed.exhausted.or(Some(self.span(&at[..at.len().min(1)])));
            return true;
        }
        self.parsed.bytes += bytes;
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

    pub(crate) fn report(&mut self, fault: SyntaxError<'a>) {
        // After the memory limit, a fault is only a consequence of unread text.
        if self.parsed.exhausted.is_some() {
            return;
        }
        let span = self.span(fault.at);
        let mut diagnostic = Diagnostic::error(span, fault.message);
        diagnostic.help = fault.help;
        if let Some(replacement) = fault.replacement {
            diagnostic = diagnostic.fix(span, replacement);
        }
        self.parsed.diagnostics.push(diagnostic);
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
    fn stray(&self, start: Input<'a>, before: Option<&Statement>) -> SyntaxError<'a> {
        let (at, found) = found(start);
        let is_number = number(at).is_ok();
        let found = if is_number { format!("the number {}", shown(at)) } else { found };
        let fault = SyntaxError::new(at, format!("expected a directive, found {found}"));
        // A value on a later line does not belong to that directive.
        let is_beside = |before: &&Statement| {
            let between = &self.text[before.span.end as usize..self.offset(start)];
            !between.contains(&b'\n')
        };
        match before.filter(is_beside).and_then(|before| surplus(&before.directive)) {
            _ if at == b"]" => fault.help("unmatched `]`: delete it"),
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
            // Directives of older versions that pbrt-v3 does not have.
            None if matches!(keyword, b"Renderer" | b"VolumeIntegrator" | b"SearchPath") => {
                let reported = self.parsed.diagnostics.len();
                let (rest, _) = self.entity(input, keyword)?;
                self.parsed.diagnostics.truncate(reported);
                let all = &self.statement[..self.statement.len() - rest.len()];
                SyntaxError { at: all.trim_ascii_end(), ..fault }.replace_with("").fail()
            }
            _ => fault.fail(),
        }
    }

    pub(crate) fn unknown_directive(&mut self, keyword: Input<'a>) -> SyntaxError<'a> {
        let name = shown(keyword);
        if V4_DIRECTIVES.contains(&name.as_str()) {
            self.parsed.v4_marks.push(self.span(keyword));
            return SyntaxError::new(keyword, format!("{name} is a directive of pbrt-v4, not of pbrt-v3"))
                .help("lookat reads the pbrt-v3 format only");
        }
        let fault = SyntaxError::new(keyword, format!("unknown directive `{name}`"));
        // In other languages it ends a statement, or starts a comment.
        let after = &self.text[self.offset(keyword) + keyword.len()..];
        if keyword == b";" && !after.iter().take_while(|byte| **byte != b'\n').any(u8::is_ascii_graphic) {
            return SyntaxError::new(keyword, "unexpected `;`").help("delete the semicolon").replace_with("");
        }
        self.unknown += 1;
        if self.unknown > MAX_UNKNOWN {
            return fault.help("further unknown directives are not reported; is this a pbrt-v3 scene?");
        }
        if let Some(synonym) = synonym(&name) {
            let error = fault.help(synonym.advice);
            // The type and the parameters stay.
            let is_renamed = !synonym.directive.is_empty();
            return if is_renamed { error.replace_with(synonym.directive) } else { error };
        }
        if let Some(known) = nearest(&name, Directive::KEYWORDS) {
            return fault.help(format!("did you mean `{known}`?")).replace_with(known);
        }
        match advice(keyword) {
            Some(advice) => fault.help(advice),
            None => fault,
        }
    }
}

/// The bytes to read on each side of the place; the larger ones only for a long directive.
const REACHES: [usize; 4] = [1 << 12, 1 << 16, 1 << 20, u32::MAX as usize];

/// The directive at a place of a text. Reads the lines around it alone. `None` where there is none, and for one that
/// cannot be read in full.
pub fn statement_at(text: &[u8], at: Span) -> Option<Statement> {
    REACHES.iter().find_map(|reach| {
        let before = text.get(..(at.start as usize).saturating_sub(*reach))?;
        // No comment goes on in another line.
        let start = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let end = (at.end as usize).saturating_add(*reach).min(text.len());
        let statements = parse_from(at.file, &text[..end], start).statements;
        let holds = |found: &Statement| found.span.start <= at.start && at.end <= found.span.end;
        let number = statements.iter().position(holds)?;
        // The last one may go on behind the end.
        let is_whole = number + 1 < statements.len() || end == text.len();
        statements.into_iter().nth(number).filter(|found| is_whole && !found.faulty)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FileId, parse};

    #[test]
    fn a_part_of_the_text_gives_the_same_directives_as_all_of_it() {
        let numbers = "0.25 1 ".repeat(3000);
        let mesh = format!("Shape \"trianglemesh\" \"point P\" [ {numbers}\n{numbers} ]");
        let text = format!(
            "\u{feff}LookAt 0 0 1 0 0 0 0 1 0 # Material \"no\n{mesh}\n\
             Material \"matte\" # plain\n  \"rgb Kd\" [1 0 0] {mesh} Shape \"sphere\"\n\
             MakeNamedMaterial \"a\" \"string type\" \"glass\" {}LightSource \"point\"",
            "# more\n".repeat(100_000),
        );
        let parsed = parse(FileId(3), text.as_bytes());
        assert!(parsed.diagnostics.is_empty() && parsed.statements.len() == 7);
        for statement in &parsed.statements {
            for at in [statement.keyword, statement.span] {
                let found = statement_at(text.as_bytes(), at).unwrap();
                assert_eq!((&found, found.span), (statement, statement.span));
            }
        }
        let comment = text.find("Material \"no").unwrap() as u32;
        assert_eq!(
            statement_at(text.as_bytes(), Span { file: FileId(3), start: comment, end: comment + 1 }),
            None
        );
        let faulty = b"Material \"matte\" \"rgb Kd\" [1 0 LightSource \"point\"";
        assert_eq!(statement_at(faulty, Span { file: FileId(0), start: 0, end: 4 }), None);
        assert_eq!(statement_at(b"", Span { file: FileId(0), start: 7, end: 9 }), None);
    }
}
