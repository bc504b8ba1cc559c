//! Several scenes, one after the other, and one scene again and again.

use std::path::{Path, PathBuf};

use lookat_scene::LoadOptions;

use super::{load_options, render_scene};
use crate::args::{Render, Report};
use crate::finished::marked;
use crate::interrupt;
use crate::live::{Live, Watch};
use crate::source::load_scene;
use crate::usage::tip_for_render;

/// The arguments for each scene alone. Fails if they do not fit together.
pub fn jobs(arguments: &Render) -> Result<Vec<Render>, String> {
    let scenes = &arguments.scenes;
    if scenes.iter().any(|scene| scene == Path::new("-")) && (scenes.len() > 1 || arguments.live.watch) {
        let option = if arguments.live.watch { "with --watch, name a file" } else { "render it alone" };
        return Err(format!("standard input can be read once: {option}"));
    }
    if let [_] = scenes[..] {
        return Ok(vec![arguments.clone()]);
    }
    if arguments.live.watch {
        return Err("--watch takes one scene".into());
    }
    if let Some(file) = arguments.output.as_ref().filter(|file| !file.is_dir()) {
        return Err(format!(
            "-o {} names one picture, and there are {} scenes: name an existing folder, or leave out -o{}",
            file.display(),
            scenes.len(),
            tip_for_render()
        ));
    }
    let files: Vec<PathBuf> = scenes.iter().map(|scene| picture_of(arguments, scene)).collect();
    let places: Vec<PathBuf> = files.iter().map(|file| place(file)).collect();
    for (at, place) in places.iter().enumerate() {
        if let Some(before) = places[..at].iter().position(|other| other == place) {
            let [one, other] = [before, at].map(|at| scenes[at].display());
            let file = files[at].display();
            return Err(format!(
                "{one} and {other} both write {file}: change the filename of one Film, or render them one by one with -o"
            ));
        }
    }
    let job = |(scene, file): (&PathBuf, PathBuf)| {
        let output = arguments.output.is_some().then_some(file);
        Render { scenes: vec![scene.clone()], output, ..arguments.clone() }
    };
    Ok(scenes.iter().zip(files).map(job).collect())
}

/// The picture file of a scene among several. Reads the text of the scene, no meshes and no pictures.
fn picture_of(arguments: &Render, scene: &Path) -> PathBuf {
    let options = LoadOptions { fast: true, ..load_options(arguments) };
    let output = load_scene(scene, &options, Report { strict: false, json: false }).output;
    let output = if arguments.quick { marked(&output, "quick") } else { output };
    match (&arguments.output, output.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => output,
    }
}

/// The file under the name that it has for all paths to it.
fn place(file: &Path) -> PathBuf {
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let there = || Some(folder.canonicalize().ok()?.join(file.file_name()?));
    file.canonicalize().ok().or_else(there).unwrap_or_else(|| file.into())
}

/// Renders the scenes. Returns the worst exit status.
pub fn render_each(jobs: &[Render], live: &Live) -> u8 {
    let mut status = 0;
    for job in jobs {
        if interrupt::flow().is_break() {
            return interrupt::STATUS;
        }
        status = status.max(render_scene(job, live));
    }
    status
}

/// Renders a scene again whenever one of its files changes, until a signal.
pub fn render_again(job: &Render, live: &Live, watch: &Watch) -> u8 {
    let mut job = job.clone();
    loop {
        watch.restart();
        // From then on the picture is its own.
        job.force |= render_scene(&job, live) == 0;
        if !live.is_outdated() && !job.quiet && !job.report.json {
            crate::say("watching for changes; end with Ctrl-C");
        }
        interrupt::stop_in_order(None, || true);
        watch.wait(|| interrupt::flow().is_continue());
        if interrupt::flow().is_break() {
            return interrupt::STATUS;
        }
    }
}
