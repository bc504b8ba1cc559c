//! Classifies words and strings: keywords, parameter declarations, ends of lists.

use crate::Directive;
use crate::param::ParamType;
use crate::token::{Fault, Input, found, quoted};

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
pub(crate) fn unclosed<'a>(open: Input<'a>, rest: Input<'a>) -> Fault<'a> {
    let (at, found) = found(rest);
    if at.is_empty() {
        return Fault::new(open, "the file ends inside this list").help("add the closing `]`");
    }
    Fault::new(open, "this list is not closed").help(format!("add `]` before {found}"))
}
