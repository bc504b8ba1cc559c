//! Several scenes, one after the other, and one scene again and again.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use lookat_scene::LoadOptions;

use crate::args::{Render, Report};
use crate::failure::Failure;
use crate::interrupt;
use crate::live::{Live, Watch};
use crate::output::{check_inputs, check_new_folder, make_folder, marked, place};
use crate::render::checkpoint::linked;
use crate::render::job::{Job, load_options, render_scene};
use crate::source::{is_read_once, load_scene};
use crate::usage::tip_for_render;

/// The scenes, each with its arguments. Fails if they do not fit together.
pub fn jobs(arguments: &Render) -> Result<Vec<Job>, Failure> {
    let scenes = &arguments.scenes;
    let file_options = [
        ("--checkpoint", arguments.checkpoint.is_some()),
        ("--part", arguments.part.is_some()),
        ("--keep-sums", arguments.keep_sums),
        ("--more", arguments.more.is_some()),
    ];
    let file_option = file_options.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name);
    if let Some(scene) = scenes.iter().find(|scene| is_read_once(scene))
        && (scenes.len() > 1 || arguments.live.watch || file_option.is_some())
    {
        let name =
            if scene == Path::new("-") { "standard input".into() } else { scene.display().to_string() };
        match file_option.or(arguments.live.watch.then_some("--watch")) {
            Some(option) => bail!("{name} can be read only once: with {option}, name a file"),
            None => bail!("{name} can be read only once: render it alone"),
        }
    }
    if let [scene] = &scenes[..] {
        // A file may still appear, but not in a folder that nobody watches.
        if arguments.live.watch
            && let Some(folder) = scene.parent().filter(|folder| *folder != Path::new("") && !folder.is_dir())
        {
            bail!("cannot watch {}: there is no folder {}", scene.display(), folder.display());
        }
        let checkpoint = arguments.checkpoint.as_deref().map(linked).transpose()?;
        let arguments = Render { checkpoint, ..arguments.clone() };
        return Ok(vec![Job { arguments, inputs: Rc::default(), resumed: None }]);
    }
    if arguments.live.watch {
        bail!("--watch takes one scene");
    }
    if arguments.checkpoint.is_some() {
        bail!("--checkpoint takes one scene");
    }
    if let Some(folder) = arguments.output.as_ref().filter(|folder| !folder.is_dir()) {
        let tip = tip_for_render();
        if folder.extension().is_some() || folder.exists() || !tip.is_empty() {
            bail!(
                "-o {} names one picture, and there are {} scenes: name a folder, or remove -o{tip}",
                folder.display(),
                scenes.len(),
            );
        }
        check_new_folder(folder)?;
    }
    let mut inputs = BTreeSet::new();
    let files: Vec<PathBuf> = scenes.iter().map(|scene| picture_of(arguments, scene, &mut inputs)).collect();
    let places: Vec<_> = files.iter().map(|file| place(file)).collect();
    for (at, place) in places.iter().enumerate() {
        if let Some(before) = places[..at].iter().position(|other| other == place) {
            let [one, other] = [before, at].map(|at| scenes[at].display());
            let file = files[at].display();
            bail!(
                "{one} and {other} both write {file}: change the filename of one Film, or render them one by one with -o"
            );
        }
    }
    // Before the first of them is rendered.
    files.iter().try_for_each(|file| check_inputs(file, &inputs))?;
    if let Some(folder) = &arguments.output {
        make_folder(folder)?;
    }
    let inputs = Rc::new(inputs);
    let job = |(scene, file): (&PathBuf, PathBuf)| {
        let output = arguments.output.is_some().then_some(file);
        let arguments = Render { scenes: vec![scene.clone()], output, ..arguments.clone() };
        Job { arguments, inputs: inputs.clone(), resumed: None }
    };
    Ok(scenes.iter().zip(files).map(job).collect())
}

/// The picture file of a scene among several. Adds what the scene reads. Reads the text of the scene, no meshes and no pictures.
fn picture_of(arguments: &Render, scene: &Path, inputs: &mut BTreeSet<PathBuf>) -> PathBuf {
    let options = LoadOptions { fast: true, ..load_options(arguments) };
    let loaded = load_scene(scene, &options, Report::default());
    inputs.extend(loaded.inputs);
    let output = loaded.output;
    let output = if arguments.quick { marked(&output, "quick") } else { output };
    match (&arguments.output, output.file_name()) {
        (Some(folder), Some(name)) => folder.join(name),
        _ => output,
    }
}

/// Renders the scenes. Returns the worst exit status.
pub fn render_each(jobs: &[Job], live: &Live) -> u8 {
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
pub fn render_again(mut job: Job, live: &Live, watch: &Watch) -> u8 {
    loop {
        watch.restart();
        // Nothing was rendered when it was asked for.
        interrupt::takes_picture();
        // From then on the picture is its own.
        job.arguments.force |= render_scene(&job, live) == 0;
        if !live.is_outdated() && !job.arguments.quiet && !job.arguments.report.json {
            say!("watching for changes; end with Ctrl-C");
        }
        interrupt::stop_in_order(None, || true);
        watch.wait(|| interrupt::flow().is_continue());
        if interrupt::flow().is_break() {
            return interrupt::STATUS;
        }
    }
}
