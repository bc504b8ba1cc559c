//! `lookat check`: the problems of scene files.

use std::process::ExitCode;

use lookat_scene::Overrides;
use serde::Serialize;

use crate::args::Check;
use crate::report::{self, JsonDiagnostic};
use crate::source::load_scene;

#[derive(Serialize)]
struct JsonResult<'a> {
    scene: String,
    diagnostics: Vec<JsonDiagnostic<'a>>,
}

/// Runs the command.
pub fn check(arguments: &Check) -> ExitCode {
    let overrides =
        Overrides { accept_part: true, max_memory: arguments.memory.limit(), ..Overrides::default() };
    let (mut status, mut lost) = (0, false);
    for path in &arguments.files {
        let loaded = load_scene(path, &overrides, arguments.report);
        if report::has_errors(&loaded) {
            status = status.max(report::failure(&loaded));
        }
        if arguments.report.json {
            let scene = path.display().to_string();
            lost |= crate::print_json(&JsonResult { scene, diagnostics: report::json(&loaded) }).is_err();
        } else {
            report::print(&loaded, arguments.quiet);
            if loaded.diagnostics.is_empty() && !arguments.quiet {
                crate::say(&format!("{}: fine", loaded.sources.files[0].path.display()));
            }
        }
    }
    ExitCode::from(if lost { crate::lost() } else { status })
}
