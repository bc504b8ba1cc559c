//! Blocks without an end, and ends in another order than starts.

use lookat_syntax::Diagnostic;

use super::{Evidence, warn};
use crate::facts::{Crossed, Opened};
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    // Unread text may contain the missing ends.
    let unclosed = if report.incomplete_end { &[] } else { &evidence.facts.unclosed[..] };
    for Opened { keywords: (begin, end), at } in unclosed {
        let help = format!("add {end} before the end of the world block");
        warn(report, *at, format!("this {begin} is not closed"), help);
    }
    for Crossed { keyword, at, inner: Opened { keywords: (begin, end), at: opened } } in
        &evidence.facts.crossed
    {
        let warning = Diagnostic::warning(*at, format!("{keyword} inside the block of {begin}"))
            .related(*opened, "the block opens here")
            .help(format!("as in pbrt-v3, this closes the outer block and leaves the inner block open: write {end} before this directive"));
        report.push(warning);
    }
}
