//! After an error: where reading continues.

use nom::bytes::complete::take_while1;

use crate::advice::V4_DIRECTIVES;
use crate::grammar::{MAX_UNKNOWN, Reader};
use crate::token::{Fault, Input, blank, is_blank, quoted};
use crate::words::is_keyword;

impl<'a> Reader<'a> {
    /// Reports a fault that ends the current statement, and returns the text from the next directive on.
    pub(crate) fn recover(&mut self, fault: Fault<'a>) -> Input<'a> {
        let from = &self.text[self.offset(fault.at)..];
        self.report(fault);
        let rest = next_directive(self.statement, from, self.unknown <= MAX_UNKNOWN);
        self.broken_end |= rest.is_empty();
        self.lost_include |= self.statement.starts_with(b"Include");
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
