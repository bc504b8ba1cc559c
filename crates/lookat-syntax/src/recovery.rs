//! Recovers from mistakes: where reading continues after an error, and missing or wrong brackets, commas and quotes.

use nom::bytes::complete::take_while1;

use crate::advice::V4_DIRECTIVES;
use crate::grammar::{MAX_UNKNOWN, Reader};
use crate::param::{ParamType, Values};
use crate::token::{
    Input, Parsing, SyntaxError, blank, is_blank, is_declaration, is_delimiter, is_keyword, quoted,
    separator, shown, unclosed, with_point, word,
};
use crate::{Diagnostic, Span, Spanned, Text};

impl<'a> Reader<'a> {
    /// Reports a fault that ends the current statement, and returns the text from the next directive on.
    pub(crate) fn recover(&mut self, fault: SyntaxError<'a>) -> Input<'a> {
        let from = &self.text[self.offset(fault.at)..];
        self.report(fault);
        let rest = next_directive(self.statement, from, self.unknown <= MAX_UNKNOWN);
        self.parsed.broken_end |= rest.is_empty();
        self.parsed.lost_include |= self.statement.starts_with(b"Include");
        rest
    }
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
        input = match take_while1::<_, _, SyntaxError>(|byte: u8| {
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

impl<'a> Reader<'a> {
    /// Skips and reports a list of lists, which pbrt-v3 does not have. True if it found one.
    pub(crate) fn nested_list(&mut self, start: Input<'a>) -> Parsing<'a, bool> {
        let (inner, ()) = blank(&start[1..])?;
        if inner.first() != Some(&b'[') {
            return Ok((start, false));
        }
        let (rest, ()) = whole_list(start)?;
        let all = &start[..start.len() - rest.len()];
        self.report(
            SyntaxError::new(all, "a list inside a list").help("put all values in one pair of brackets"),
        );
        Ok((rest, true))
    }

    /// Reports wrong brackets: pbrt-v3 requires them around the 16 numbers of a matrix and forbids them around fewer.
    pub(crate) fn misbracketed(
        &mut self,
        all: Input<'a>,
        numbers: Input<'a>,
        keyword: Input<'a>,
        open: bool,
    ) {
        let (span, keyword, numbers) = (self.span(all), shown(keyword), String::from_utf8_lossy(numbers));
        let diagnostic = if open {
            Diagnostic::warning(
                span,
                format!("{keyword} takes numbers without brackets; pbrt-v3 stops with an error here"),
            )
            .help("delete the brackets")
            .fix(span, numbers.trim())
        } else {
            self.faulty = true;
            Diagnostic::error(span, format!("{keyword} takes numbers in brackets"))
                .help("put them in brackets")
                .fix(span, format!("[{numbers}]"))
        };
        self.parsed.diagnostics.push(diagnostic);
    }

    /// Skips and reports a bracket or a comma before a declaration.
    pub(crate) fn after_stray(&mut self, input: Input<'a>) -> Input<'a> {
        let Some((stray @ (b']' | b','), rest)) = input.split_first() else { return input };
        let Ok((next, ())) = blank(rest) else { return input };
        if !is_declaration(next) {
            return input;
        }
        let fault = match stray {
            b']' => SyntaxError::new(&input[..1], "unmatched `]`").help("delete it"),
            _ => SyntaxError::new(&input[..1], "unexpected `,`").help("separate parameters by spaces only"),
        };
        self.report(fault);
        next
    }

    /// Skips surplus numbers after a value, and a list on the same line. True if it found a list.
    pub(crate) fn after_values(&mut self, input: Input<'a>) -> Parsing<'a, bool> {
        let (end, _) = self.more_numbers(input)?;
        let (next, ()) = blank(end)?;
        if next.first() != Some(&b'[') || end[..end.len() - next.len()].contains(&b'\n') {
            return Ok((end, false));
        }
        Ok((whole_list(next)?.0, true))
    }

    /// Skips and reports a list in parentheses or braces. `None` if there is none.
    pub(crate) fn list_in_others(&mut self, start: Input<'a>) -> Option<Input<'a>> {
        let close = match start.first()? {
            b'(' => b')',
            b'{' => b'}',
            _ => return None,
        };
        let end = start.iter().position(|byte| *byte == close || *byte == b'"')?;
        let (all, rest) = start.split_at_checked(end + 1).filter(|_| start[end] == close)?;
        let is_number = |byte: &u8| is_blank(*byte) || byte.is_ascii_digit() || b"+-.,eE".contains(byte);
        // Other text is a placeholder that a program should have replaced.
        if !all[1..end].iter().all(is_number) {
            return None;
        }
        let values = String::from_utf8_lossy(&all[1..end]);
        let fault = SyntaxError::new(all, "a list takes square brackets");
        self.report(fault.help("use square brackets").replace_with(format!("[{values}]")));
        Some(rest)
    }

    /// Skips and reports a closing bracket whose opening bracket is missing. True if it found one.
    pub(crate) fn unopened_list(&mut self, start: Input<'a>, end: Input<'a>) -> Parsing<'a, bool> {
        let (close, ()) = blank(end)?;
        if close.first() != Some(&b']') {
            return Ok((end, false));
        }
        let values = &start[..start.len() - end.len()];
        let replacement = format!("[{}", String::from_utf8_lossy(values));
        let fault = SyntaxError::new(values, "the opening bracket of this list is missing");
        self.report(fault.help("add `[`").replace_with(replacement));
        Ok((&close[1..], true))
    }
}

/// Skips a list and the lists inside it.
fn whole_list(start: Input) -> Parsing<()> {
    let (mut input, mut depth) = (start, 0);
    loop {
        (input, ()) = blank(input)?;
        input = match input.first() {
            None => return unclosed(&start[..1], input).fail(),
            Some(b'"') => quoted(input)?.0,
            Some(b'[') => {
                depth += 1;
                &input[1..]
            }
            Some(b']') => {
                depth -= 1;
                &input[1..]
            }
            Some(_) => match word(input)? {
                (_, word) if is_keyword(word) => return unclosed(&start[..1], input).fail(),
                (rest, _) => rest,
            },
        };
        if depth == 0 {
            return Ok((input, ()));
        }
    }
}

impl<'a> Reader<'a> {
    /// Skips white space and commas between values.
    pub(crate) fn separator(&mut self, input: Input<'a>) -> Parsing<'a, ()> {
        let (rest, has_comma) = separator(input)?;
        // A word with many commas is read once: it separates values.
        if has_comma && !self.commas.separates {
            let at = self.offset(input) + input.iter().position(|byte| *byte == b',').unwrap_or(0);
            self.commas.first.get_or_insert(&self.text[at..=at]);
            let word = word_around(self.text, at);
            match with_point(word) {
                Some(_) => {
                    self.commas.decimal.get_or_insert(word);
                    self.commas.last_decimal = Some(word);
                }
                None => {
                    self.commas.separates = true;
                    self.warn_of_commas();
                }
            }
        }
        Ok((rest, ()))
    }

    /// Reports the decimal commas since the last call, and at the end of the file that commas separate numbers.
    pub(crate) fn report_commas(&mut self, is_at_end: bool) {
        if let Some((first, others)) = std::mem::take(&mut self.decimal_commas).split_first() {
            // All have the words of the first error of the file, which makes them one problem.
            let error = self.decimal_comma.clone().map(|mut error| {
                error.labels[0].span = *first;
                error.places = others.to_vec();
                error
            });
            self.parsed.diagnostics.extend(error);
        }
        let comma = self.comma.filter(|_| is_at_end);
        self.parsed.diagnostics.extend(comma.map(|at| {
            Diagnostic::warning(at, "commas separate these numbers")
                .help("separate numbers by spaces, and use a decimal point; pbrt-v3 ignores the comma and the rest of the word")
        }));
    }

    fn warn_of_commas(&mut self) {
        self.comma = self.comma.or(self.commas.first.map(|comma| self.span(comma)));
    }

    /// Reports the decimal commas of the current list, after its values are read. True if there are any.
    pub(crate) fn has_decimal_commas(&mut self, values: &Values) -> bool {
        let decimal = self.commas.decimal.filter(|_| !self.commas.separates);
        let Some((word, meant)) = decimal.and_then(|word| Some((word, with_point(word)?))) else {
            return false;
        };
        if matches!(values, Values::Integers(_)) {
            self.warn_of_commas();
            return false;
        }
        self.faulty = true;
        let at = self.span(word);
        self.decimal_commas.push(at);
        if self.decimal_comma.is_some() {
            return true;
        }
        let last = self.commas.last_decimal.unwrap_or(word);
        let (all, points) = self.with_points(word, last, &meant);
        let (word, one) = (shown(word), shown(&meant));
        let two = word.replace(',', " ");
        let error = Diagnostic::error(at, format!("`{word}` may be one number or two"))
            .help(format!("write one number with a point: {one}; write two with a space: {}", two.trim()));
        // Points of a plane are pairs in other formats, such as `0,1 1,1` in SVG.
        let are_pairs = matches!(values, Values::Pairs(_));
        self.decimal_comma = Some(if are_pairs { error } else { error.fix(all, points) });
        true
    }

    /// The words of a list from the first with a decimal comma to the last, and the text with points. Only the first, as
    /// `meant`, if the last is far away.
    fn with_points(&self, first: Input<'a>, last: Input<'a>, meant: &[u8]) -> (Span, String) {
        let (start, end) = (self.offset(first), self.offset(last) + last.len());
        let text = &self.text[start..end];
        if text.len() > LONGEST_FIX || text.iter().any(|byte| matches!(byte, b'#' | b'\n')) {
            return (self.span(first), shown(meant));
        }
        (self.span(text), String::from_utf8_lossy(text).replace(',', "."))
    }
}

/// The longest text, in bytes, whose decimal commas one fix replaces.
const LONGEST_FIX: usize = 200;

/// The word around a byte.
fn word_around(text: Input, at: usize) -> Input {
    let is_outside = |byte: &u8| is_delimiter(*byte);
    let start = text[..at].iter().rposition(is_outside).map_or(0, |before| before + 1);
    let end = text[at..].iter().position(is_outside).map_or(text.len(), |length| at + length);
    &text[start..end]
}

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
    fn mended(&mut self, fault: SyntaxError<'a>, inner: Input<'a>) -> Text {
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
        let fault = SyntaxError::new(word, format!("unexpected `{}` after {}", shown(word), shown(keyword)));
        self.report(fault.help("delete it"));
        Some(next)
    }
}

/// The fault of a word with a closing quote and no opening quote.
pub(crate) fn unopened(input: Input) -> Option<SyntaxError> {
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
fn quote_missing<'a>(which: &str, at: Input<'a>, inner: Input<'a>) -> SyntaxError<'a> {
    let fault = SyntaxError::new(at, format!("the {which} quote is missing"));
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
