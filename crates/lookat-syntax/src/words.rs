//! What words and strings may be: directives, declarations, the end of a list.

use crate::Directive;
use crate::param::ParamType;
use crate::token::{Fault, Input, found, quoted};

pub(crate) fn is_keyword(word: Input) -> bool {
    Directive::KEYWORDS.iter().any(|keyword| keyword.as_bytes() == word)
}

/// Whether values cannot go on here: the file ends, or a bracket or a directive follows.
pub(crate) fn ends_list(word: Input) -> bool {
    word.is_empty() || matches!(word, b"[" | b"]") || is_keyword(word)
}

/// Whether a string such as `"float fov"` starts here.
pub(crate) fn is_declaration(input: Input) -> bool {
    let Ok((_, text)) = quoted(input) else { return false };
    let mut words = text.split_ascii_whitespace();
    words.next().is_some_and(|ty| ParamType::from_spelling(ty).is_some()) && words.count() == 1
}

/// The fault for a list that opens at `open`, whose bracket is missing before `rest`.
pub(crate) fn unclosed<'a>(open: Input<'a>, rest: Input<'a>) -> Fault<'a> {
    let (at, found) = found(rest);
    if at.is_empty() {
        return Fault::new(open, "the file ends inside this list").help("add the closing `]`");
    }
    Fault::new(open, "this list is not closed").help(format!("add `]` before {found}"))
}
