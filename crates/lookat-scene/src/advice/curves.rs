//! Curves, which pbrt-v3 draws differently. `docs/differences.md` lists all differences.

use lookat_syntax::Diagnostic;

use super::{Evidence, warn};
use crate::report::Report;
use crate::{CurveKind, Shape};

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for primitive in &evidence.drawn {
        let (Shape::Curve(curve), Some(at)) = (&primitive.shape, primitive.span) else { continue };
        // A note: every curve has it, and no parameter makes both pictures equal.
        let message = "pbrt-v3 draws curves up to 5 % thinner where they bend, and omits shadows of surfaces closer than 3.5 curve widths";
        let help = "to reduce the difference in width, increase \"splitdepth\"";
        report.push(Diagnostic::note_at(at, message).help(help));
        if let CurveKind::Ribbon(normals) = &curve.kind
            && normals.windows(2).any(|pair| pair[0] == pair[1])
        {
            let message = "pbrt-v3 may abort or miss parts where successive normals of a ribbon are equal";
            warn(report, at, message, "rotate one of the two normals by a thousandth of a radian");
        }
    }
}
