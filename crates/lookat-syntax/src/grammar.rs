//! The grammar: bytes to statements. After an error, reading continues at the next directive, so that one run finds
//! every mistake.

use nom::bytes::complete::take_while1;

use crate::advice::{V4_DIRECTIVES, advice, quoted_after, surplus};
use crate::synonyms::directive_advice;
use crate::token::{Fault, Input, Parsing, blank, found, is_blank, number, quoted, shown, word};
use crate::words::{ends_list, is_declaration, is_keyword, unclosed};
use crate::{
    ActiveTransform, Diagnostic, Directive, Entity, EntityKind, FileId, Span, Spanned, Statement, Text,
    nearest,
};

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
}

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
    let mut reader = Reader {
        unknown: 0,
        file,
        text,
        diagnostics: Vec::new(),
        v4_marks: Vec::new(),
        broken_end: false,
        lost_include: false,
        comma: None,
        statement: &[],
        faulty: false,
        fraction: false,
        bytes: 0,
        most_bytes,
        exhausted: None,
    };
    let mut statements = Vec::new();
    if text.len() >= u32::MAX as usize {
        reader
            .diagnostics
            .push(Diagnostic::error(Span { file, start: 0, end: 0 }, "the file is larger than 4 GiB"));
    } else {
        reader.statements(&mut statements);
    }
    if let Some(at) = reader.comma {
        let warning = Diagnostic::warning(at, "commas separate these numbers")
            .help("separate numbers by spaces, and use a decimal point; pbrt-v3 ignores the comma and the rest of the word");
        reader.diagnostics.push(warning);
    }
    reader.diagnostics.sort_by_key(|diagnostic| diagnostic.span().start);
    let Reader { diagnostics, v4_marks, broken_end, lost_include, bytes, exhausted, .. } = reader;
    Parsed { statements, diagnostics, v4_marks, broken_end, lost_include, bytes, exhausted }
}

/// After this many unknown directives, the parser looks for known directives only: the file is probably not a scene.
const MAX_UNKNOWN: usize = 20;

pub(crate) struct Reader<'a> {
    /// Unknown directives so far.
    unknown: usize,
    file: FileId,
    pub(crate) text: Input<'a>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    v4_marks: Vec<Span>,
    broken_end: bool,
    lost_include: bool,
    /// The first comma between numbers.
    pub(crate) comma: Option<Span>,
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
}

impl<'a> Reader<'a> {
    fn statements(&mut self, statements: &mut Vec<Statement>) {
        // Skip a byte-order mark.
        let mut input = self.text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(self.text);
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

    /// Reports a fault that ends the current statement, and returns the text from the next directive on.
    pub(crate) fn recover(&mut self, fault: Fault<'a>) -> Input<'a> {
        let from = &self.text[self.offset(fault.at)..];
        self.report(fault);
        let rest = next_directive(self.statement, from, self.unknown <= MAX_UNKNOWN);
        self.broken_end |= rest.is_empty();
        self.lost_include |= self.statement.starts_with(b"Include");
        rest
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

    /// Reads the arguments of a keyword.
    fn directive(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        Ok(match keyword {
            b"Identity" => (input, Directive::Identity),
            b"TransformBegin" => (input, Directive::TransformBegin),
            b"TransformEnd" => (input, Directive::TransformEnd),
            b"AttributeBegin" => (input, Directive::AttributeBegin),
            b"AttributeEnd" => (input, Directive::AttributeEnd),
            b"ObjectEnd" => (input, Directive::ObjectEnd),
            b"ReverseOrientation" => (input, Directive::ReverseOrientation),
            b"WorldBegin" => (input, Directive::WorldBegin),
            b"WorldEnd" => (input, Directive::WorldEnd),
            b"Translate" => self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::Translate(n)))?,
            b"Scale" => self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::Scale(n)))?,
            b"Rotate" => self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::Rotate(n)))?,
            b"LookAt" => self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::LookAt(n)))?,
            b"Transform" => self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::Transform(n)))?,
            b"ConcatTransform" => {
                self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::ConcatTransform(n)))?
            }
            b"TransformTimes" => {
                self.numbers(input, keyword).map(|(rest, n)| (rest, Directive::TransformTimes(n)))?
            }
            b"CoordinateSystem" => {
                self.name(input, keyword).map(|(rest, n)| (rest, Directive::CoordinateSystem(n)))?
            }
            b"CoordSysTransform" => {
                self.name(input, keyword).map(|(rest, n)| (rest, Directive::CoordSysTransform(n)))?
            }
            b"ObjectBegin" => self.name(input, keyword).map(|(rest, n)| (rest, Directive::ObjectBegin(n)))?,
            b"ObjectInstance" => {
                self.name(input, keyword).map(|(rest, n)| (rest, Directive::ObjectInstance(n)))?
            }
            b"NamedMaterial" => {
                self.name(input, keyword).map(|(rest, n)| (rest, Directive::NamedMaterial(n)))?
            }
            b"ActiveTransform" => self.active_transform(input)?,
            b"MediumInterface" => self.medium_interface(input, keyword)?,
            b"Texture" => self.texture(input, keyword)?,
            b"Include" => {
                let (input, file) = self.name(input, keyword)?;
                let (input, rest) = self.params(input);
                (input, Directive::Include { file, rest })
            }
            _ => match EntityKind::ALL.into_iter().find(|kind| kind.keyword().as_bytes() == keyword) {
                Some(kind) => {
                    let (rest, entity) = self.entity(input, keyword)?;
                    (rest, Directive::Entity(kind, entity))
                }
                None => return self.unknown_directive(keyword).fail(),
            },
        })
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

    fn unknown_directive(&mut self, keyword: Input<'a>) -> Fault<'a> {
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

    /// Reads the numbers of a transformation. A matrix of 16 numbers needs brackets; fewer numbers need none.
    fn numbers<const N: usize>(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, [f64; N]> {
        let (start, ()) = blank(input)?;
        let open = start.first() == Some(&b'[');
        let mut input = &start[usize::from(open)..];
        let mut values = [0.0; N];
        for (index, value) in values.iter_mut().enumerate() {
            let before = input;
            (input, _) = self.separator(input)?;
            let new_line = before[..before.len() - input.len()].contains(&b'\n');
            (input, *value) = match number(input) {
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault))
                    if ends_list(fault.at) || index > 0 && new_line && is_word(fault.at) =>
                {
                    let at = &self.statement[..self.statement.len() - before.len()];
                    return self.miscounted(at, keyword, N, index).fail();
                }
                read => read?,
            };
        }
        let numbers = &start[usize::from(open)..start.len() - input.len()];
        let (rest, more) = self.more_numbers(input)?;
        if more > 0 {
            let (surplus, ()) = blank(input)?;
            let fault = self.miscounted(&surplus[..surplus.len() - rest.len()], keyword, N, N + more);
            self.report(fault);
            input = rest;
        }
        if open {
            (input, _) = self.separator(input)?;
            if input.first() != Some(&b']') {
                return unclosed(&start[..1], input).fail();
            }
            input = &input[1..];
        }
        if open != (N == 16) {
            let all = &start[..start.len() - input.len()];
            self.misbracketed(all, numbers, keyword, open);
        }
        Ok((input, values))
    }

    fn miscounted(&self, at: Input<'a>, keyword: Input<'a>, wanted: usize, given: usize) -> Fault<'a> {
        let fault = Fault::new(at, format!("{} takes {wanted} numbers; {given} given", shown(keyword)));
        fault.help(match keyword {
            b"Translate" => "write the distances along x, y and z: Translate 0 0 1",
            b"Scale" => "write the factors along x, y and z: Scale 1 1 1",
            b"Rotate" => "write the angle in degrees and the axis: Rotate 45 0 1 0",
            b"LookAt" => "write the eye, the point to look at and the up vector, three numbers each",
            b"TransformTimes" => "write the start time and the end time",
            _ => "write the matrix column by column",
        })
    }

    /// Skips and counts the following numbers.
    pub(crate) fn more_numbers(&mut self, input: Input<'a>) -> Parsing<'a, usize> {
        let (mut input, mut count) = (input, 0);
        loop {
            let (next, ()) = self.separator(input)?;
            let Ok((rest, _)) = number(next) else { return Ok((input, count)) };
            (input, count) = (rest, count + 1);
        }
    }

    fn name(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Text> {
        let (input, ()) = blank(input)?;
        let (what, example) = quoted_after(keyword);
        // The keyword as written, which may be misspelled.
        let (_, here) = word(self.statement)?;
        let missing = || {
            Fault::new(here, format!("a quoted {what} is missing after {}", shown(keyword)))
                .help(format!("write it like {example}"))
        };
        if what == "type" && is_declaration(input) {
            return missing().fail();
        }
        if input.first() == Some(&b'"') {
            return self.closed_string(input);
        }
        if let Some(read) = self.unopened_string(input) {
            return Ok(read);
        }
        if let Some(next) = self.surplus_word(input, keyword) {
            return self.closed_string(next);
        }
        let (at, found) = found(input);
        if is_keyword(at) {
            if keyword != b"ObjectBegin" {
                return missing().fail();
            }
            // The following directives still belong to the object.
            self.report(missing());
            return Ok((input, Spanned { value: String::new(), span: self.span(here) }));
        }
        let fault =
            Fault::new(at, format!("expected a quoted {what} after {}, found {found}", shown(keyword)));
        // A bare word that is not a keyword is a name without its quotes.
        let text = shown(at);
        if at.first().is_some_and(u8::is_ascii_alphabetic) {
            self.report(fault.help("put it in quotes").replace_with(format!("\"{text}\"")));
            return Ok((&input[at.len()..], Spanned { value: text, span: self.span(at) }));
        }
        match advice(at) {
            Some(advice) => fault.help(advice).fail(),
            None => fault.help(format!("write it like {example}")).fail(),
        }
    }

    pub(crate) fn string(&self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, value) = quoted(input)?;
        Ok((rest, Spanned { value, span: self.span(&input[..input.len() - rest.len()]) }))
    }

    fn active_transform(&mut self, input: Input<'a>) -> Parsing<'a, Directive> {
        let (input, ()) = blank(input)?;
        let (at, found) = found(input);
        let which = match at {
            b"All" => ActiveTransform::All,
            b"StartTime" => ActiveTransform::StartTime,
            b"EndTime" => ActiveTransform::EndTime,
            _ => {
                let message =
                    format!("expected All, StartTime or EndTime after ActiveTransform, found {found}");
                return Fault::new(at, message).fail();
            }
        };
        Ok((&input[at.len()..], Directive::ActiveTransform(which)))
    }

    fn medium_interface(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        let (input, inside) = self.name(input, keyword)?;
        let (next, ()) = blank(input)?;
        if next.first() != Some(&b'"') {
            return Ok((input, Directive::MediumInterface { inside, outside: None }));
        }
        let (input, outside) = self.string(next)?;
        Ok((input, Directive::MediumInterface { inside, outside: Some(outside) }))
    }

    fn texture(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        let (input, name) = self.name(input, keyword)?;
        let (input, value) = self.name(input, b"the name of a Texture")?;
        let (input, entity) = self.entity(input, b"the value type of a Texture")?;
        Ok((input, Directive::Texture { name, value, entity }))
    }

    fn entity(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Entity> {
        let (input, name) = self.name(input, keyword)?;
        let (input, params) = self.params(input);
        Ok((input, Entity { name, params }))
    }
}

/// True for a word, such as a misspelled directive, that is not meant as a number.
fn is_word(at: Input) -> bool {
    let lower = at.to_ascii_lowercase();
    at.first().is_some_and(u8::is_ascii_alphabetic)
        && !lower.starts_with(b"nan")
        && !lower.starts_with(b"inf")
}

/// True if a word at the start of a line can be a directive: it is text, and does not continue a list of numbers.
fn may_be_directive(word: Input) -> bool {
    !word[0].is_ascii_digit() && !matches!(word[0], b'+' | b'-' | b'.' | b',') && str::from_utf8(word).is_ok()
}

fn starts_directive(word: Input) -> bool {
    is_keyword(word) || V4_DIRECTIVES.iter().any(|keyword| keyword.as_bytes() == word)
}

/// The next directive outside quotes after a fault at `from`, in the statement that starts at `start`.
fn next_directive<'a>(start: Input<'a>, from: Input<'a>, at_lines: bool) -> Input<'a> {
    let mut input = from;
    loop {
        let Ok((next, ())) = blank(input) else { return &[] };
        // A word at the start of a line is probably a directive.
        let skipped = &input[..input.len() - next.len()];
        let line_starts = at_lines && skipped.contains(&b'\n');
        if next.is_empty() {
            return next;
        }
        input = match take_while1::<_, _, Fault>(|byte: u8| {
            !is_blank(byte) && !matches!(byte, b'"' | b'[' | b']')
        })(next)
        {
            Ok((_, word))
                if (starts_directive(word) || line_starts && may_be_directive(word))
                    && next.as_ptr() != start.as_ptr() =>
            {
                return next;
            }
            Ok((rest, _)) => rest,
            Err(_) if next[0] == b'"' => match quoted(next) {
                Ok((rest, _)) => rest,
                // An open quote: continue after its line.
                Err(_) => next.iter().position(|byte| *byte == b'\n').map_or(&[], |end| &next[end..]),
            },
            Err(_) => &next[1..],
        };
    }
}
