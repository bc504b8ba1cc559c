//! Recovers from missing, surplus and wrong brackets of lists.

use crate::Diagnostic;
use crate::grammar::Reader;
use crate::token::{Fault, Input, Parsing, blank, is_blank, quoted, shown, word};
use crate::words::{is_declaration, is_keyword, unclosed};

impl<'a> Reader<'a> {
    /// Skips and reports a list of lists, which pbrt-v3 does not have. True if it found one.
    pub(crate) fn nested_list(&mut self, start: Input<'a>) -> Parsing<'a, bool> {
        let (inner, ()) = blank(&start[1..])?;
        if inner.first() != Some(&b'[') {
            return Ok((start, false));
        }
        let (rest, ()) = whole_list(start)?;
        let all = &start[..start.len() - rest.len()];
        self.report(Fault::new(all, "a list inside a list").help("put all values in one pair of brackets"));
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
        self.diagnostics.push(diagnostic);
    }

    /// Skips and reports a bracket or a comma before a declaration.
    pub(crate) fn after_stray(&mut self, input: Input<'a>) -> Input<'a> {
        let Some((stray @ (b']' | b','), rest)) = input.split_first() else { return input };
        let Ok((next, ())) = blank(rest) else { return input };
        if !is_declaration(next) {
            return input;
        }
        let fault = match stray {
            b']' => Fault::new(&input[..1], "unmatched `]`").help("delete it"),
            _ => Fault::new(&input[..1], "unexpected `,`").help("separate parameters by spaces only"),
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
        let fault = Fault::new(all, "a list takes square brackets");
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
        let fault = Fault::new(values, "the opening bracket of this list is missing");
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
