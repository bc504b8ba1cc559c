//! Names that are defined again, and media, which are not rendered.

use lookat_syntax::{Diagnostic, shown};

use super::Evidence;
use crate::report::Report;
use crate::symbols::SymbolKind;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for (kind, name, at) in &evidence.facts.redefined {
        let (what, name) = (short(*kind), shown(name.as_bytes()));
        let message = format!("{what} \"{name}\" is defined again: the new definition applies from here on");
        report.push(Diagnostic::note_at(*at, message));
    }
    let media = evidence.symbols.all().iter().filter(|symbol| symbol.kind == SymbolKind::Medium);
    for place in media.filter(|medium| medium.definition.is_some()).flat_map(|medium| &medium.uses) {
        let message = "lookat does not render participating media: it renders empty space instead";
        report.unsupported(*place, message.into());
    }
}

fn short(kind: SymbolKind) -> &'static str {
    match kind {
        SymbolKind::Material => "material",
        SymbolKind::FloatTexture | SymbolKind::SpectrumTexture => "texture",
        kind => kind.name(),
    }
}
