//! `lookat inspect`: the size, features and cost of a scene.

mod lens_figure;
mod lines;
pub mod needs;
mod shown;

use std::path::Path;
use std::process::ExitCode;

use lookat_image::write_file;
use lookat_scene::{LoadOptions, Loaded, Scene};

use crate::args::Inspect;
use crate::failure::Failure;
use crate::inspect::needs::Needs;
use crate::output::{check_folder, check_inputs};
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
        if let Some(file) = &arguments.lens {
            write_figure(file, scene, &loaded)?;
        }
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

/// Draws the lenses of the camera into a file.
fn write_figure(file: &Path, scene: &Scene, loaded: &Loaded) -> Result<(), Failure> {
    let figure = lens_figure::draw(&scene.view).ok_or_else(|| {
        let kind = scene.view.camera.projection.name();
        Failure::from(format!(
            "--lens draws the lenses of a realistic camera; this scene has a camera of type {kind}"
        ))
    })?;
    if !file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
        let name = visible(&file.display().to_string());
        return Err(
            format!("--lens draws a figure in SVG, not {name}: choose a name that ends with .svg").into()
        );
    }
    check_folder(file)?;
    check_inputs(file, &loaded.inputs)?;
    Ok(write_file(file, figure.as_bytes())?)
}
