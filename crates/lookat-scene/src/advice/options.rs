//! Options that are given twice or not at all.

use lookat_syntax::{Diagnostic, EntityKind, Severity};

use super::Evidence;
use crate::facts::Facts;
use crate::report::Report;

pub(super) fn advise(evidence: &Evidence, report: &mut Report) {
    for (kind, at, before) in &evidence.facts.replaced_options {
        let warning = Diagnostic::warning(*at, format!("a second {}: the last one is used", kind.keyword()));
        report.push(warning.related(*before, "this one is ignored"));
    }
    missing(evidence, report);
}

fn missing(evidence: &Evidence, report: &mut Report) {
    let Facts { missing_options, idle_transform, .. } = evidence.facts;
    // A transformation that waits for a Camera has its own warning.
    let is_told = |kind: &&EntityKind| **kind == EntityKind::Camera && idle_transform.is_some();
    let missing: Vec<&EntityKind> = missing_options.iter().filter(|kind| !is_told(kind)).collect();
    let Some(world_begin) = evidence.facts.world_begin.filter(|_| !missing.is_empty()) else { return };
    let names: Vec<_> = missing.iter().map(|kind| kind.keyword()).collect();
    let defaults: Vec<_> = missing.iter().map(|kind| default(**kind)).collect();
    // A scene needs its own view and size. It can use the default sampler and integrator of pbrt-v3.
    let severity = match missing.iter().any(|kind| matches!(kind, EntityKind::Camera | EntityKind::Film)) {
        true => Severity::Warning,
        false => Severity::Note,
    };
    let remark = Diagnostic::warning(world_begin, format!("no {} before WorldBegin", names.join(", no ")))
        .help(format!("the default applies: {}", defaults.join("; ")));
    report.push(Diagnostic { severity, ..remark });
}

fn default(kind: EntityKind) -> &'static str {
    match kind {
        EntityKind::Camera => "a perspective camera at the origin that looks along +z, fov 90",
        EntityKind::Film => "1280 x 720 pixels, written to pbrt.exr",
        EntityKind::Sampler => "halton with 16 samples",
        _ => "path with maxdepth 5",
    }
}
