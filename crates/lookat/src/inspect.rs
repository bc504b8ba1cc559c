//! `lookat inspect`: the size, features and cost of a scene.

mod lines;
pub mod needs;
mod shown;

use std::process::ExitCode;

use lookat_scene::LoadOptions;

use crate::args::Inspect;
use crate::failure::Failure;
use crate::inspect::needs::Needs;
use crate::readable::visible;
use crate::report;
use crate::scene_result::SceneResult;
use crate::source::load_scene;

/// Runs the command.
pub fn inspect(arguments: &Inspect) -> ExitCode {
    let options = LoadOptions {
        view: arguments.view.options(),
        keep_going: arguments.keep_going,
        max_memory: arguments.memory.limit(),
        ..LoadOptions::default()
    };
    let loaded = load_scene(&arguments.scene, &options, arguments.report);
    let needs = loaded.scene.as_ref().map(|scene| {
        arguments.view.check_use(scene)?;
        Needs::new(scene, &loaded)
    });
    let needs = match needs.transpose() {
        Ok(needs) => needs,
        Err(failure) => return crate::exit_code(Err::<u8, Failure>(failure)),
    };
    let status = if needs.is_some() { 0 } else { report::failure(&loaded) };
    let printed = if arguments.report.json {
        let result = SceneResult { needs, ..SceneResult::new(&arguments.scene, &loaded) };
        crate::print_json(&result)
    } else {
        report::print(&loaded, false);
        let name = visible(&arguments.scene.display().to_string());
        needs.map_or(Ok(()), |needs| crate::print(&needs.text(&name)))
    };
    ExitCode::from(if printed.is_ok() { status } else { crate::lost() })
}
