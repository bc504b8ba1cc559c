//! Recovers from missing quotes and from words beside quoted strings.

use crate::grammar::Reader;
use crate::param::ParamType;
use crate::token::{Fault, Input, Parsing, blank, is_blank, quoted, shown, word};
use crate::words::{is_declaration, is_keyword};
use crate::{Spanned, Text};

/// The longest part of a line, in bytes, that is searched for quotes.
const LONGEST_LINE: usize = 1000;

impl<'a> Reader<'a> {
    /// Reads a string. If its closing quote is missing, the opening quote of the next string seems to close it: then
    /// this reports the missing quote and leaves the next string in the input.
    pub(crate) fn closed_string(&mut self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, text) = self.string(input)?;
        let string = &input[..input.len() - rest.len()];
        let inner = string[1..string.len() - 1].trim_ascii_end();
        if inner.len() + 2 == string.len() || !runs_on(rest) {
            return Ok((rest, text));
        }
        Ok(self.closed_early(input, 1 + inner.len()))
    }

    /// Reads a declaration in the same way. It ends after the name of the parameter.
    pub(crate) fn closed_declaration(&mut self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, text) = self.string(input)?;
        let string = &input[1..input.len() - rest.len()];
        let declared = declared(string).filter(|declared| declared + 1 < string.len() && runs_on(rest));
        Ok(declared.map_or((rest, text), |length| self.closed_early(input, 1 + length)))
    }

    /// Reports a string that should end after `length` bytes, including its opening quote.
    fn closed_early(&mut self, input: Input<'a>, length: usize) -> (Input<'a>, Text) {
        let (meant, rest) = input.split_at(length);
        let fault = quote_missing("closing", meant, &meant[1..]);
        (rest.trim_ascii_start(), self.mended(fault, &meant[1..]))
    }

    /// Reads and reports a string of one word without its opening quote.
    pub(crate) fn unopened_string(&mut self, input: Input<'a>) -> Option<(Input<'a>, Text)> {
        let fault = unopened(input)?;
        let (all, rest) = input.split_at(fault.at.len());
        Some((rest, self.mended(fault, &all[..all.len() - 1])))
    }

    /// Reads and reports a declaration without its opening quote.
    pub(crate) fn unopened_declaration(&mut self, input: Input<'a>) -> Option<(Input<'a>, Text)> {
        let length = declared(input).filter(|length| input[*length] == b'"')?;
        let (meant, rest) = input.split_at(length + 1);
        let fault = quote_missing("opening", meant, &meant[..length]);
        Some((rest, self.mended(fault, &meant[..length])))
    }

    /// Reports a missing quote and returns the intended string.
    fn mended(&mut self, fault: Fault<'a>, inner: Input<'a>) -> Text {
        let span = self.span(fault.at);
        self.report(fault);
        Spanned { value: String::from_utf8_lossy(inner).into_owned(), span }
    }

    /// Reports a surplus word before a string and returns the input at the string. `None` if the word is itself the
    /// string without its quotes.
    pub(crate) fn surplus_word(&mut self, input: Input<'a>, keyword: Input<'a>) -> Option<Input<'a>> {
        let (rest, word) = word(input).ok()?;
        let (next, ()) = blank(rest).ok()?;
        let is_beside = !rest[..rest.len() - next.len()].contains(&b'\n') && quoted(next).is_ok();
        // These directives take several strings.
        let is_of_several =
            matches!(keyword, b"Texture" | b"MediumInterface") || keyword.starts_with(b"the ");
        if !is_beside || is_of_several || is_keyword(word) || is_declaration(next) {
            return None;
        }
        let fault = Fault::new(word, format!("unexpected `{}` after {}", shown(word), shown(keyword)));
        self.report(fault.help("delete it"));
        Some(next)
    }
}

/// The fault of a word with a closing quote and no opening quote.
pub(crate) fn unopened(input: Input) -> Option<Fault> {
    let (rest, name) = word(input).ok()?;
    // A line may have megabytes; the quote is nearby.
    let near = &rest[..rest.len().min(LONGEST_LINE)];
    let line = near.split(|byte| *byte == b'\n').next()?;
    // Without this quote, the quotes of the line come in pairs.
    let quotes = line.iter().filter(|byte| **byte == b'"').count();
    if rest.first() != Some(&b'"') || quotes.is_multiple_of(2) {
        return None;
    }
    Some(quote_missing("opening", &input[..=name.len()], name))
}

/// The fault of a string at `at` that lacks a quote and should contain `inner`.
fn quote_missing<'a>(which: &str, at: Input<'a>, inner: Input<'a>) -> Fault<'a> {
    let fault = Fault::new(at, format!("the {which} quote is missing"));
    fault.help("add it").replace_with(format!("\"{}\"", String::from_utf8_lossy(inner)))
}

/// True if text follows a closing quote directly: then the quote probably opens a string.
fn runs_on(rest: Input) -> bool {
    rest.first().is_some_and(u8::is_ascii_alphabetic)
}

/// The length of a parameter type and a name at the start of a string.
fn declared(string: Input) -> Option<usize> {
    // No type has a longer name, and a file may have no blank at all.
    let name = string.iter().take(16).position(|byte| is_blank(*byte))?;
    ParamType::from_spelling(str::from_utf8(&string[..name]).ok()?)?;
    let start = name + string[name..].iter().position(|byte| !is_blank(*byte))?;
    let ends = |byte: &u8| is_blank(*byte) || matches!(byte, b'[' | b'"');
    Some(start + string[start..].iter().position(ends)?).filter(|end| *end > start)
}
