//! Tokens: blanks, quoted strings, numbers and words, as nom parsers over bytes.

use nom::bytes::complete::{take_while, take_while1};
use nom::character::complete::char;
use nom::combinator::opt;
use nom::error::{ErrorKind, ParseError};
use nom::{IResult, Parser};

pub(crate) use crate::numbers::{Input, ends_number, is_blank, is_delimiter};
use crate::numbers::{decimal, number_of_any_size};
use crate::param::ParamType;
use crate::{Directive, Span};

pub(crate) type Parsing<'a, T> = IResult<Input<'a>, T, SyntaxError<'a>>;

/// A violation of the grammar. `at` is the part of the input to underline.
#[derive(Debug, PartialEq)]
pub(crate) struct SyntaxError<'a> {
    pub at: Input<'a>,
    pub message: String,
    pub help: Option<String>,
    pub replacement: Option<String>,
}

impl<'a> SyntaxError<'a> {
    pub fn new(at: Input<'a>, message: impl Into<String>) -> Self {
        SyntaxError { at, message: message.into(), help: None, replacement: None }
    }

    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub fn replace_with(mut self, replacement: impl Into<String>) -> Self {
        self.replacement = Some(replacement.into());
        self
    }

    /// Converts to a nom failure, after which no alternative is tried.
    pub fn fail<T>(self) -> Parsing<'a, T> {
        Err(nom::Err::Failure(self))
    }
}

impl<'a> ParseError<Input<'a>> for SyntaxError<'a> {
    fn from_error_kind(input: Input<'a>, _: ErrorKind) -> Self {
        SyntaxError::new(&input[..0], "unexpected text")
    }

    fn append(_: Input<'a>, _: ErrorKind, other: Self) -> Self {
        other
    }
}

/// Skips white space and comments.
pub(crate) fn blank(input: Input) -> Parsing<()> {
    let mut input = input;
    loop {
        (input, _) = take_while(is_blank)(input)?;
        if input.first() != Some(&b'#') {
            return Ok((input, ()));
        }
        (input, _) = take_while(|byte| byte != b'\n' && byte != b'\r')(input)?;
    }
}

/// Reads up to the next delimiter, at least one byte.
pub(crate) fn word(input: Input) -> Parsing<Input> {
    take_while1(|byte| !is_delimiter(byte))(input)
}

/// The next token: its bytes, and its description for "expected a number, found ...".
pub(crate) fn found(input: Input) -> (Input, String) {
    match input.first() {
        None => (input, "the end of the file".into()),
        Some(b'"') => match quoted(input) {
            Ok((rest, text)) => {
                (&input[..input.len() - rest.len()], format!("the string \"{}\"", shown(text.as_bytes())))
            }
            Err(_) => (&input[..1], "a quote".into()),
        },
        Some(b'[') => (&input[..1], "`[`".into()),
        Some(b']') => (&input[..1], "`]`".into()),
        Some(_) => {
            let word = word(input).map_or(&input[..1], |(_, word)| word);
            (word, format!("`{}`", shown(word)))
        }
    }
}

/// Bytes as text for a message: at most 40 bytes, then `...`. Escapes control characters.
pub fn shown(bytes: &[u8]) -> String {
    let cut = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned();
    let mut text = String::new();
    for c in cut.chars() {
        if c.is_control() || is_unseen(c) { text.extend(c.escape_default()) } else { text.push(c) }
    }
    if bytes.len() > 40 { text + "..." } else { text }
}

/// True for characters beyond ASCII that look like a space or are invisible. They come from copied web pages.
pub(crate) fn is_unseen(c: char) -> bool {
    !c.is_ascii() && c.is_whitespace()
        || matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}')
}

/// Reads a quoted string and decodes its escapes. A string ends on the line where it starts.
pub(crate) fn quoted(input: Input) -> Parsing<String> {
    let (inner, _) = char('"')(input)?;
    let mut bytes = Vec::new();
    let mut at = 0;
    loop {
        match inner.get(at) {
            None | Some(b'\n') => {
                let line = &input[..=at.min(inner.len())];
                let line = line.strip_suffix(b"\r").unwrap_or(line);
                return SyntaxError::new(line, "the string is not closed")
                    .help("add the closing quote on the same line")
                    .fail();
            }
            Some(b'"') => break,
            Some(b'\\') => {
                let Some(decoded) = inner.get(at + 1).and_then(|byte| unescape(*byte)) else {
                    return SyntaxError::new(&inner[at..inner.len().min(at + 2)], "unknown escape in a string")
                        .help(r#"the escapes are \" \\ \' \n \r \t \b \f; in a file name, write a backslash as / or \\"#)
                        .fail();
                };
                bytes.push(decoded);
                at += 1;
            }
            Some(byte) => bytes.push(*byte),
        }
        at += 1;
    }
    Ok((&inner[at + 1..], String::from_utf8_lossy(&bytes).into_owned()))
}

fn unescape(byte: u8) -> Option<u8> {
    Some(match byte {
        b'b' => 8,
        b'f' => 12,
        b'n' => b'\n',
        b'r' => b'\r',
        b't' => b'\t',
        b'\\' | b'\'' | b'"' => byte,
        _ => return None,
    })
}

/// Skips white space and commas between numbers. True if there was a comma.
pub(crate) fn separator(input: Input) -> Parsing<bool> {
    let (mut input, _) = blank(input)?;
    let mut comma = false;
    while input.first() == Some(&b',') {
        comma = true;
        (input, _) = blank(&input[1..])?;
    }
    Ok((input, comma))
}

/// Reads a finite decimal number (`1`, `-.5`, `1.`, `1e-3`, `1e+006`) to the nearest `f64`.
#[inline]
pub(crate) fn number(input: Input) -> Parsing<f64> {
    match decimal(input) {
        Some((value, length)) if ends_number(&input[length..]) => Ok((&input[length..], value)),
        _ => no_number(input),
    }
}

/// The number that a word means if its comma is a decimal comma. `None` if the word is no such number.
pub(crate) fn with_point(word: Input) -> Option<Vec<u8>> {
    let comma = word.iter().position(|byte| *byte == b',')?;
    let mut meant = word.to_vec();
    meant[comma] = b'.';
    let is_whole = |(value, length)| comma + 1 < word.len() && length == word.len() && f64::is_finite(value);
    decimal(&meant).is_some_and(is_whole).then_some(meant)
}

/// The fault of an unreadable number.
#[cold]
fn no_number<T>(input: Input) -> Parsing<T> {
    let is_word = input.iter().find(|byte| !b"+-".contains(byte)).is_some_and(u8::is_ascii_alphabetic);
    match number_of_any_size(input) {
        Some((_, length)) if !is_word && ends_number(&input[length..]) => {
            SyntaxError::new(&input[..length], "the number is too large")
                .help("the largest number is about 1.8e308")
                .fail()
        }
        _ => not_a_number(input),
    }
}

/// The fault of a word in the place of a number.
fn not_a_number<T>(input: Input) -> Parsing<T> {
    let (at, found) = found(input);
    let lower = String::from_utf8_lossy(at).to_lowercase();
    let bare = lower.trim_start_matches(['-', '+']);
    if bare.starts_with("nan") || bare.starts_with("inf") {
        return SyntaxError::new(at, format!("{found} is not a finite number"))
            .help("programs print nan and inf when a computation fails: correct the program that wrote this file")
            .fail();
    }
    if let Some(before) = at.strip_suffix(b";")
        && number(before).is_ok_and(|(rest, _)| rest.is_empty())
    {
        let fault = SyntaxError::new(at, format!("{found} is not a number"));
        return fault.help("delete the semicolon").replace_with(shown(before)).fail();
    }
    if bare.starts_with(|c: char| c.is_ascii_digit() || c == '.') && at.len() > 1 {
        return SyntaxError::new(at, format!("{found} is not a number"))
            .help(
                "write digits with an optional point and exponent, such as -1.5e-3, and a space after the number",
            )
            .fail();
    }
    let fault = SyntaxError::new(at, format!("expected a number, found {found}"));
    if let Some(meant) = with_point(at) {
        let help = "write the decimal separator as a point, not as a comma";
        return fault.help(help).replace_with(shown(&meant)).fail();
    }
    if let Some(size) = lower.strip_prefix(['\u{2212}', '\u{2013}', '\u{2014}']) {
        return fault.help("write the minus sign as a hyphen").replace_with(format!("-{size}")).fail();
    }
    if at == b"=" {
        return fault.help("delete the equals sign").replace_with("").fail();
    }
    match at.strip_prefix(b"\"").and_then(|at| at.strip_suffix(b"\"")) {
        Some(bare) if number(bare).is_ok_and(|(rest, _)| rest.is_empty()) => {
            fault.help("delete the quotes around the number").replace_with(shown(bare)).fail()
        }
        _ => fault.fail(),
    }
}

/// The place of the value at `index` in the list at `list` in `text`. Each number of a point or color counts.
///
/// Values do not store their places, to save memory in large meshes. This function reads the list again.
pub fn value_span(text: &[u8], list: Span, index: usize) -> Span {
    let whole = &text[(list.start as usize).min(text.len())..(list.end as usize).min(text.len())];
    let find = || -> Parsing<Input> {
        let (mut input, _) = (blank, opt(char('['))).parse(whole)?;
        for at in 0.. {
            (input, _) = separator(input)?;
            let before = input;
            if input.first() == Some(&b'"') {
                (input, _) = quoted(input)?;
            } else {
                (input, _) = take_while1(|byte| !is_delimiter(byte) && byte != b',')(input)?;
            }
            if at == index {
                return Ok((input, &before[..before.len() - input.len()]));
            }
        }
        Ok((input, input))
    };
    match find() {
        Ok((_, value)) => {
            let start = list.start + (value.as_ptr() as usize - whole.as_ptr() as usize) as u32;
            Span { file: list.file, start, end: start + value.len() as u32 }
        }
        Err(_) => list,
    }
}

pub(crate) fn is_keyword(word: Input) -> bool {
    Directive::KEYWORDS.iter().any(|keyword| keyword.as_bytes() == word)
}

/// True if no value can follow: at the end of the file, a bracket or a keyword.
pub(crate) fn ends_list(word: Input) -> bool {
    word.is_empty() || matches!(word, b"[" | b"]") || is_keyword(word)
}

/// True if the input starts with a parameter declaration such as `"float fov"`.
pub(crate) fn is_declaration(input: Input) -> bool {
    let Ok((_, text)) = quoted(input) else { return false };
    let mut words = text.split_ascii_whitespace();
    words.next().is_some_and(|ty| ParamType::from_spelling(ty).is_some()) && words.count() == 1
}

/// The fault of a list that opens at `open` and lacks its closing bracket before `rest`.
pub(crate) fn unclosed<'a>(open: Input<'a>, rest: Input<'a>) -> SyntaxError<'a> {
    let (at, found) = found(rest);
    if at.is_empty() {
        return SyntaxError::new(open, "the file ends inside this list").help("add the closing `]`");
    }
    SyntaxError::new(open, "this list is not closed").help(format!("add `]` before {found}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FileId;

    #[test]
    fn numbers_are_read_to_the_nearest_double() {
        for text in [
            "0",
            "-0",
            "1",
            ".5",
            "1.",
            "-.5",
            "+2",
            "1e-3",
            "1e+006",
            "1E5",
            "0.1",
            "123456789012345678901234567890",
            "3.4028235e38",
            "5e-324",
            "2.2250738585072011e-308",
            "0.000000000000000000000000000001",
            "1e308",
            "9007199254740993",
        ] {
            let (rest, value) = number(text.as_bytes()).unwrap();
            assert!(rest.is_empty(), "{text}");
            assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_refused() {
        for text in [
            "1x",
            "1.5abc",
            "nan",
            "-inf",
            "1e400",
            "1e",
            "-",
            ".",
            "1.2.3",
            "0x10",
            "1e999999999999",
            "1#2",
            "\"a\"",
        ] {
            assert!(number(text.as_bytes()).is_err(), "{text}");
        }
    }

    #[test]
    fn places_of_values_are_found_again() {
        let text = b"[ 1 2, # three\n 3]\"a b\"";
        let at = |start, end, index| value_span(text, Span { file: FileId(0), start, end }, index);
        assert_eq!((at(0, 18, 2).start, at(0, 18, 2).end), (16, 17));
        assert_eq!((at(18, 23, 0).start, at(18, 23, 0).end), (18, 23));
        assert_eq!((at(0, 18, 9).start, at(0, 18, 9).end), (0, 18));
    }
}
