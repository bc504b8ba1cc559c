//! The grammar: bytes to statements. What cannot be read is reported and skipped up to the next directive, so one run
//! finds every mistake.

use nom::bytes::complete::take_while1;

use crate::token::{Fault, Input, Parsing, blank, found, is_blank, number, quoted, shown, word};
use crate::{
    ActiveTransform, Diagnostic, Directive, Entity, EntityKind, FileId, Span, Spanned, Statement, Text,
    nearest,
};

/// What [`parse`] read.
#[derive(Debug, Default)]
pub struct Parsed {
    /// The directives in the order of the file.
    pub statements: Vec<Statement>,
    /// What does not follow the grammar, in the order of the file.
    pub diagnostics: Vec<Diagnostic>,
}

/// Reads one file. `text` need not be UTF-8: pbrt looks at bytes, and comments are free.
///
/// Texts of 4 GiB and more are refused with a diagnostic.
pub fn parse(file: FileId, text: &[u8]) -> Parsed {
    let mut reader = Reader { file, text, diagnostics: Vec::new(), comma: None, faulty: false };
    let mut statements = Vec::new();
    if text.len() >= u32::MAX as usize {
        reader
            .diagnostics
            .push(Diagnostic::error(Span { file, start: 0, end: 0 }, "the file is larger than 4 GiB"));
    } else {
        reader.statements(&mut statements);
    }
    if let Some(at) = reader.comma {
        let warning = Diagnostic::warning(at, "commas between numbers")
            .help("the format separates numbers by blanks; pbrt-v3 reads only what stands before a comma");
        reader.diagnostics.push(warning);
    }
    reader.diagnostics.sort_by_key(|diagnostic| diagnostic.span().start);
    Parsed { statements, diagnostics: reader.diagnostics }
}

pub(crate) struct Reader<'a> {
    file: FileId,
    text: Input<'a>,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// The first comma between numbers.
    pub(crate) comma: Option<Span>,
    /// Part of the current statement could not be read.
    pub(crate) faulty: bool,
}

impl<'a> Reader<'a> {
    fn statements(&mut self, statements: &mut Vec<Statement>) {
        // A byte-order mark is no part of the text.
        let mut input = self.text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(self.text);
        while let Ok((start, ())) = blank(input)
            && !start.is_empty()
        {
            self.faulty = false;
            match self.statement(start) {
                Ok((rest, statement)) => {
                    statements.push(statement);
                    input = rest;
                }
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => {
                    let from = &start[self.offset(fault.at).saturating_sub(self.offset(start))..];
                    self.report(fault);
                    input = next_directive(start, from);
                }
                Err(nom::Err::Incomplete(_)) => break,
            }
        }
    }

    pub(crate) fn offset(&self, part: Input<'a>) -> usize {
        part.as_ptr() as usize - self.text.as_ptr() as usize
    }

    pub(crate) fn span(&self, part: Input<'a>) -> Span {
        let start = self.offset(part) as u32;
        Span { file: self.file, start, end: start + part.len() as u32 }
    }

    /// What lies between two positions of the input, without the blanks at its end.
    pub(crate) fn between(&self, start: Input<'a>, rest: Input<'a>) -> Span {
        self.span(start[..start.len() - rest.len()].trim_ascii_end())
    }

    pub(crate) fn report(&mut self, fault: Fault<'a>) {
        let span = self.span(fault.at);
        let mut diagnostic = Diagnostic::error(span, fault.message);
        diagnostic.help = fault.help;
        if let Some(replacement) = fault.replacement {
            diagnostic = diagnostic.fix(span, replacement);
        }
        self.diagnostics.push(diagnostic);
        self.faulty = true;
    }

    fn statement(&mut self, start: Input<'a>) -> Parsing<'a, Statement> {
        let Ok((input, keyword)) = word(start) else {
            let (at, found) = found(start);
            return Fault::new(at, format!("expected a directive, found {found}")).fail();
        };
        let (rest, directive) = match keyword {
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
                let (input, rest) = self.params(input)?;
                (input, Directive::Include { file, rest })
            }
            _ => match EntityKind::ALL.into_iter().find(|kind| kind.keyword().as_bytes() == keyword) {
                Some(kind) => {
                    let (rest, entity) = self.entity(input, keyword)?;
                    (rest, Directive::Entity(kind, entity))
                }
                None => return self.unknown_directive(keyword),
            },
        };
        let statement = Statement {
            directive,
            span: self.between(start, rest),
            keyword: self.span(keyword),
            faulty: self.faulty,
        };
        Ok((rest, statement))
    }

    fn unknown_directive<T>(&self, keyword: Input<'a>) -> Parsing<'a, T> {
        let name = shown(keyword);
        if matches!(keyword, b"Option" | b"ColorSpace" | b"Attribute") {
            return Fault::new(keyword, format!("`{name}` is a directive of pbrt-v4, not of pbrt-v3"))
                .help("this looks like a pbrt-v4 scene; lookat reads the pbrt-v3 format")
                .fail();
        }
        if number(keyword).is_ok() {
            return Fault::new(keyword, format!("expected a directive, found the number {name}"))
                .help("several values of one parameter stand in brackets: [1 2 3]")
                .fail();
        }
        let fault = Fault::new(keyword, format!("unknown directive `{name}`"));
        match nearest(&name, Directive::KEYWORDS) {
            Some(known) => fault.help(format!("did you mean `{known}`?")).replace_with(known).fail(),
            None => fault.fail(),
        }
    }

    /// The numbers of a transformation. Brackets belong around 16 of them; around fewer they are tolerated.
    fn numbers<const N: usize>(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, [f64; N]> {
        let (mut input, ()) = blank(input)?;
        let open = (input.first() == Some(&b'[')).then(|| &input[..1]);
        if let Some(open) = open {
            input = &input[open.len()..];
        } else if N == 16 {
            let (at, found) = found(input);
            let name = shown(keyword);
            return Fault::new(at, format!("expected `[` after {name}, found {found}"))
                .help(format!("{name} takes 16 numbers in brackets"))
                .fail();
        }
        let mut values = [0.0; N];
        for (index, value) in values.iter_mut().enumerate() {
            (input, _) = self.separator(input)?;
            (input, *value) = number(input).map_err(|error| {
                error.map(|fault| match fault.at.first() {
                    Some(b'0'..=b'9' | b'.' | b'-' | b'+' | b'n' | b'N' | b'i' | b'I') => fault,
                    _ => Fault {
                        message: format!("{} takes {N} numbers; {index} given", shown(keyword)),
                        help: fault.help.or(Some(fault.message)),
                        ..fault
                    },
                })
            })?;
        }
        if let Some(open) = open {
            (input, _) = self.separator(input)?;
            if input.first() != Some(&b']') {
                let (at, found) = found(input);
                let message =
                    format!("expected `]` after the {N} numbers of {}, found {found}", shown(keyword));
                return Fault::new(if at.is_empty() { open } else { at }, message).fail();
            }
            input = &input[1..];
        }
        Ok((input, values))
    }

    fn name(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Text> {
        let (input, ()) = blank(input)?;
        if input.first() == Some(&b'"') {
            return self.string(input);
        }
        let (at, found) = found(input);
        let fault = Fault::new(at, format!("expected a quoted name after {}, found {found}", shown(keyword)));
        // A bare word that is no directive is the name without its quotes.
        let text = shown(at);
        if at.first().is_some_and(u8::is_ascii_alphabetic) && !Directive::KEYWORDS.contains(&text.as_str()) {
            return fault.help("put it in quotes").replace_with(format!("\"{text}\"")).fail();
        }
        fault.fail()
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
        let (input, params) = self.params(input)?;
        Ok((input, Entity { name, params }))
    }
}

pub(crate) fn is_keyword(word: Input) -> bool {
    Directive::KEYWORDS.iter().any(|keyword| keyword.as_bytes() == word)
}

/// Where reading goes on after a fault at `from` in the statement that starts at `start`: at the next word that is a
/// directive and stands outside quotes.
fn next_directive<'a>(start: Input<'a>, from: Input<'a>) -> Input<'a> {
    let mut input = from;
    loop {
        let Ok((next, ())) = blank(input) else { return &[] };
        if next.is_empty() {
            return next;
        }
        input = match take_while1::<_, _, Fault>(|byte: u8| {
            !is_blank(byte) && !matches!(byte, b'"' | b'[' | b']')
        })(next)
        {
            Ok((_, word)) if is_keyword(word) && next.as_ptr() != start.as_ptr() => return next,
            Ok((rest, _)) => rest,
            Err(_) if next[0] == b'"' => match quoted(next) {
                Ok((rest, _)) => rest,
                // An open quote: go on after its line.
                Err(_) => next.iter().position(|byte| *byte == b'\n').map_or(&[], |end| &next[end..]),
            },
            Err(_) => &next[1..],
        };
    }
}
