//! Objects without an instance.

use std::collections::BTreeMap;

use lookat_syntax::shown;

use super::{Evidence, warn};
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    let symbols = evidence.facts.objects.iter().map(|(at, symbol)| (*at, evidence.symbols.get(*symbol)));
    // A note says where a name is defined again.
    let last: BTreeMap<&str, _> = symbols.map(|(at, symbol)| (&symbol.name[..], (at, symbol))).collect();
    for (name, (at, _)) in last.into_iter().filter(|(_, (_, symbol))| symbol.uses.is_empty()) {
        let message = format!("object \"{}\" is defined and never used", shown(name.as_bytes()));
        warn(report, at, message, "place it with ObjectInstance");
    }
}
