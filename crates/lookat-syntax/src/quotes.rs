//! Quotes that are missing, and words that stand beside them.

use crate::grammar::Reader;
use crate::param::ParamType;
use crate::token::{Fault, Input, Parsing, blank, is_blank, quoted, shown, word};
use crate::words::{is_declaration, is_keyword};
use crate::{Spanned, Text};

/// More of a line is not looked through for quotes.
const LONGEST_LINE: usize = 1000;

impl<'a> Reader<'a> {
    /// A string. Where its closing quote is missing, so that the one that opens the next string seems to close it, that is
    /// reported, and the next one is still to be read.
    pub(crate) fn closed_string(&mut self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, text) = self.string(input)?;
        let string = &input[..input.len() - rest.len()];
        let inner = string[1..string.len() - 1].trim_ascii_end();
        if inner.len() + 2 == string.len() || !runs_on(rest) {
            return Ok((rest, text));
        }
        Ok(self.closed_early(input, 1 + inner.len()))
    }

    /// A declaration, likewise: it ends after the name of the parameter.
    pub(crate) fn closed_declaration(&mut self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, text) = self.string(input)?;
        let string = &input[1..input.len() - rest.len()];
        let declared = declared(string).filter(|declared| declared + 1 < string.len() && runs_on(rest));
        Ok(declared.map_or((rest, text), |length| self.closed_early(input, 1 + length)))
    }

    /// A string that was meant to end after so many bytes, the opening quote among them.
    fn closed_early(&mut self, input: Input<'a>, length: usize) -> (Input<'a>, Text) {
        let (meant, rest) = input.split_at(length);
        let fault = quote_missing("closing", meant, &meant[1..]);
        (rest.trim_ascii_start(), self.mended(fault, &meant[1..]))
    }

    /// A string of one word whose opening quote is missing, which is reported.
    pub(crate) fn unopened_string(&mut self, input: Input<'a>) -> Option<(Input<'a>, Text)> {
        let fault = unopened(input)?;
        let (all, rest) = input.split_at(fault.at.len());
        Some((rest, self.mended(fault, &all[..all.len() - 1])))
    }

    /// A declaration whose opening quote is missing, which is reported.
    pub(crate) fn unopened_declaration(&mut self, input: Input<'a>) -> Option<(Input<'a>, Text)> {
        let length = declared(input).filter(|length| input[*length] == b'"')?;
        let (meant, rest) = input.split_at(length + 1);
        let fault = quote_missing("opening", meant, &meant[..length]);
        Some((rest, self.mended(fault, &meant[..length])))
    }

    /// Reports a quote that is missing, and gives the string as it was meant.
    fn mended(&mut self, fault: Fault<'a>, inner: Input<'a>) -> Text {
        let span = self.span(fault.at);
        self.report(fault);
        Spanned { value: String::from_utf8_lossy(inner).into_owned(), span }
    }

    /// The string behind a word that is none, which is reported. `None` where the word is the string without its quotes.
    pub(crate) fn surplus_word(&mut self, input: Input<'a>, keyword: Input<'a>) -> Option<Input<'a>> {
        let (rest, word) = word(input).ok()?;
        let (next, ()) = blank(rest).ok()?;
        let is_beside = !rest[..rest.len() - next.len()].contains(&b'\n') && quoted(next).is_ok();
        // Of these, more strings than one belong to the directive.
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

/// The fault of a word that a quote ends and none begins.
pub(crate) fn unopened(input: Input) -> Option<Fault> {
    let (rest, name) = word(input).ok()?;
    // Of a line without end, as far as a slip reaches.
    let near = &rest[..rest.len().min(LONGEST_LINE)];
    let line = near.split(|byte| *byte == b'\n').next()?;
    // All quotes of the line but this one come in pairs.
    let quotes = line.iter().filter(|byte| **byte == b'"').count();
    if rest.first() != Some(&b'"') || quotes.is_multiple_of(2) {
        return None;
    }
    Some(quote_missing("opening", &input[..=name.len()], name))
}

/// The fault of a string at `at`, meant to hold `inner`, that lacks a quote.
fn quote_missing<'a>(which: &str, at: Input<'a>, inner: Input<'a>) -> Fault<'a> {
    let fault = Fault::new(at, format!("the {which} quote is missing"));
    fault.help("add it").replace_with(format!("\"{}\"", String::from_utf8_lossy(inner)))
}

/// Whether text follows a closing quote at once, as where the quote was meant to open a string.
fn runs_on(rest: Input) -> bool {
    rest.first().is_some_and(u8::is_ascii_alphabetic)
}

/// The length of a type of parameters and a name at the beginning of a string.
fn declared(string: Input) -> Option<usize> {
    let name = string.iter().position(|byte| is_blank(*byte))?;
    ParamType::from_spelling(str::from_utf8(&string[..name]).ok()?)?;
    let start = name + string[name..].iter().position(|byte| !is_blank(*byte))?;
    let ends = |byte: &u8| is_blank(*byte) || matches!(byte, b'[' | b'"');
    Some(start + string[start..].iter().position(ends)?).filter(|end| *end > start)
}
