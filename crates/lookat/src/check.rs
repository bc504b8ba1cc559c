//! `lookat check`: the problems of scene files.

use std::process::ExitCode;

use lookat_scene::syntax::Severity;
use lookat_scene::{LoadOptions, Loaded};

use crate::Failure;
use crate::args::Check;
use crate::readable::plural;
use crate::report;
use crate::scene_result::SceneResult;
use crate::source::{load_scene, prepare};

/// Runs the command.
pub fn check(arguments: &Check) -> ExitCode {
    let options = LoadOptions {
        accept_part: true,
        fast: arguments.fast,
        view: arguments.camera.options(),
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    };
    let (mut status, mut lost) = (0, false);
    for path in &arguments.files {
        let mut loaded = load_scene(path, &options, arguments.report);
        let looked = look(&mut loaded, arguments);
        if let Err(failure) = &looked {
            say!("error: {failure}");
            status = status.max(failure.status());
        }
        if report::has_errors(&loaded) {
            status = status.max(report::failure(&loaded));
        }
        if arguments.report.json {
            let unread = arguments.fast.then_some(loaded.unread);
            let result = SceneResult { unread, ..SceneResult::new(path, &loaded) };
            lost |= crate::print_json(&result).is_err();
        } else {
            report::print(&loaded, arguments.quiet);
            let remarks = if arguments.quiet { Vec::new() } else { remarks(&loaded, looked.is_ok()) };
            if !remarks.is_empty() {
                say!("{}: {}", loaded.sources.files[0].path.display(), remarks.join("; "));
            }
        }
    }
    ExitCode::from(if lost { crate::lost() } else { status })
}

/// Fails if the camera cannot use one of the options. With `--view`, adds warnings about what the scene shows; with
/// `--strict`, they are errors.
fn look(loaded: &mut Loaded, arguments: &Check) -> Result<(), Failure> {
    let Some(scene) = &loaded.scene else { return Ok(()) };
    arguments.camera.check_use(scene)?;
    if !arguments.view {
        return Ok(());
    }
    let mut prepared = prepare(loaded, scene)?;
    let mut advice = lookat_sight::advise(loaded, scene, &mut prepared);
    if arguments.report.strict {
        for warning in &mut advice {
            warning.severity = Severity::Error;
        }
    }
    loaded.diagnostics.extend(advice);
    Ok(())
}

/// What to say about a scene after its diagnostics.
fn remarks(loaded: &Loaded, is_fine: bool) -> Vec<String> {
    let fine = (is_fine && loaded.diagnostics.is_empty()).then(|| "fine".to_owned());
    let unread = plural(loaded.unread as u64, "mesh or picture", "meshes or pictures");
    let skipped = (loaded.unread > 0).then(|| format!("--fast skipped the contents of {unread}"));
    fine.into_iter().chain(skipped).collect()
}
