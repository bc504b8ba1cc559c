//! The world block: its start, its end, and directives outside it.

use lookat_syntax::{Diagnostic, Span};

use super::{Evidence, warn};
use crate::facts::Block;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for at in &evidence.facts.after_end {
        let message = "lookat ignores directives after WorldEnd: it renders one picture per file";
        report.unsupported(*at, message.into());
    }
    match (evidence.facts.part, evidence.facts.world_begin) {
        (Some((block, first)), None) => part(evidence, block, first, report),
        (None, None) => no_world(evidence, report),
        (_, Some(_)) => {}
    }
    // pbrt-v4 has no WorldEnd.
    let is_excused = report.is_v4(evidence.sources) || report.incomplete || report.incomplete_end;
    if let Some(end) = evidence.facts.missing_end.filter(|_| !is_excused) {
        let help = "add WorldEnd: without it, pbrt-v3 renders nothing";
        warn(report, end, "the file ends without WorldEnd", help);
    }
}

fn part(evidence: &Evidence, block: Block, first: Span, report: &mut Report) {
    let without = match block {
        Block::Options => "WorldBegin",
        _ => "Camera, Film or WorldBegin",
    };
    let message = format!("this file is a part of a scene: it has no {without}");
    report.push(match evidence.accept_part {
        true => Diagnostic::note_at(first, message)
            .help("the scene that includes it may define the missing names"),
        false => Diagnostic::error(first, message).help("check or render the scene that includes it"),
    });
}

fn no_world(evidence: &Evidence, report: &mut Report) {
    if report.incomplete {
        return;
    }
    report.push(match evidence.facts.early.first() {
        None => Diagnostic::error(evidence.end, "the file has no WorldBegin: there is nothing to render")
            .help("put the lights and shapes between WorldBegin and WorldEnd; if another scene includes this file, check that scene"),
        Some((keyword, at)) => {
            let before = Span { end: at.start, ..*at };
            Diagnostic::error(*at, format!("{keyword} without WorldBegin"))
                .help("put the lights and shapes between WorldBegin and WorldEnd")
                .fix(before, "WorldBegin\n")
        }
    });
}
