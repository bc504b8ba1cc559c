//! `lookat farm`: prints a script that renders a scene in parts, as jobs of an engine, and merges them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser as _;
use lookat_image::Format;

use crate::args::{Arguments, Command, Engine, Farm, Render};
use crate::failure::{Failure, SCENE_FAULT};
use crate::output::{check_inputs, check_output, check_unfinished};
use crate::readable::quoted;
use crate::render::job::{load_options, numbered};
use crate::render::settings::{new_picture, settings};
use crate::source::{is_read_once, load_scene, replace_samples};
use crate::{report, usage};

/// Runs the command.
pub fn farm(arguments: &Farm) -> ExitCode {
    let render = match parse(arguments) {
        Ok(render) => render,
        Err(error) => return usage::explain(error),
    };
    crate::exit_code(run(arguments, &render))
}

/// The arguments of the rendering that the jobs share.
fn parse(Farm { scene, options, parts, .. }: &Farm) -> Result<Box<Render>, clap::Error> {
    let words = ["lookat".into(), "render".into(), scene.clone().into_os_string()];
    let options = options.iter().map(Into::into);
    // What does not go with parts is told now.
    let part = parts.map(|parts| format!("--part=0/{parts}").into());
    let parsed = Arguments::try_parse_from(words.into_iter().chain(options).chain(part))?;
    match parsed.command {
        Command::Render(render) => Ok(render),
        _ => unreachable!("the second word is render"),
    }
}

/// Checks what can be checked before any job starts, and prints the script.
fn run(arguments: &Farm, render: &Render) -> Result<u8, Failure> {
    let Farm { engine, scene, parts, output, options } = arguments;
    let frames = render.frames.is_used().then(|| render.frames.count());
    if is_read_once(scene) {
        bail!("{} can be read only once, and each job reads the scene: name a file", scene.display());
    }
    let [scene, output] = [absolute(scene)?, absolute(output)?];
    let live = &render.live;
    let is_shown = live.watch || live.show.is_some() || live.tev.is_some();
    if render.scenes.len() > 1 {
        bail!("a farm renders one scene; remove {}", render.scenes[1].display());
    }
    if is_shown || render.quick || render.checkpoint.is_some() || render.tone.is_given() {
        bail!(
            "a farm does not take lookat render --show, --tev, --quick, --checkpoint, --exposure or --tone; \
            `lookat convert` applies the last two to the picture"
        );
    }
    if render.output.is_some() || render.frames.only.is_some() {
        bail!("a farm shares out the parts or the pictures itself: it needs no lookat render -o or --only");
    }
    if parts.is_some() == frames.is_some() {
        bail!(
            "name the number of --parts of one picture, or the pictures by lookat render --turntable or --animate behind --, but not both"
        );
    }
    let mut loaded = load_scene(&scene, &load_options(render), render.report);
    report::print(&loaded, true);
    replace_samples(&mut loaded, render.spp);
    let Some(found) = &loaded.scene else { return Ok(SCENE_FAULT) };
    let samples = found.view.sampler.samples_per_pixel;
    if parts.is_some_and(|parts| parts > samples) {
        bail!(
            "{samples} samples per pixel make at most {samples} parts; write fewer, or increase lookat render --spp behind --"
        );
    }
    if !render.layers.is_empty() && Format::from_path(&output) != Some(Format::Exr) {
        bail!("{}: only an .exr file can store layers; choose one with -o", output.display());
    }
    let crop = found.view.film.crop;
    let files = frames.map_or_else(|| vec![output.clone()], |count| numbered(&output, count as usize));
    for file in &files {
        check_output(file, [crop.width(), crop.height()])?;
        check_inputs(file, &loaded.inputs)?;
        if !render.force {
            let whole = Render { part: None, ..render.clone() };
            let new = new_picture(found, &settings(&whole, file));
            check_unfinished(
                file,
                new,
                "choose another name with -o, or write lookat render --force behind --",
            )?;
        }
    }
    // The jobs have these anyway.
    let options = options.iter().filter(|option| !["--force", "--quiet", "-q"].contains(&option.as_str()));
    let options = options.map(|option| format!(" {}", quoted(option.as_ref()))).collect();
    let program =
        std::env::current_exe().map_err(|error| Failure::io("find", Path::new("lookat"), &error))?;
    let folder = output.with_extension("parts");
    let [program, scene, output, folder] =
        [program, scene, output, folder].map(|path| quoted(path.as_os_str()));
    let names = Names { program, scene, output, folder, options };
    crate::print(&match (engine, frames, *parts) {
        (Engine::Slurm, Some(frames), _) => slurm_frames(&names, frames),
        (Engine::Slurm, None, parts) => slurm_parts(&names, parts.unwrap_or(1)),
    })?;
    Ok(0)
}

/// Words of a script, quoted for the shell.
struct Names {
    program: String,
    scene: String,
    output: String,
    /// The folder of the parts.
    folder: String,
    /// The options of the rendering, each after a blank.
    options: String,
}

/// The most files that one job merges, unless there are as many times more parts.
const MERGED: u32 = 100;

/// A job array of Slurm, and jobs that merge what it renders: all parts in one job or, of many, some in each of a second array, whose results a
/// last job merges. An array task that is requeued writes its part again; the part appears whole or not at all.
fn slurm_parts(Names { program, scene, output, folder, options }: &Names, parts: u32) -> String {
    let (last, version) = (parts - 1, env!("CARGO_PKG_VERSION"));
    let script = format!(
        r#"#!/bin/sh
# {parts} parts of a rendering, and the jobs that merge them. Made by lookat {version}.
set -eu
mkdir -p {folder}
cd {folder}
parts=$(sbatch --parsable --job-name=lookat-part --array=0-{last} --requeue --output=part-%a.log <<'END'
#!/bin/sh
exec {program} render {scene}{options} --part "$SLURM_ARRAY_TASK_ID/{parts}" -o "part-$SLURM_ARRAY_TASK_ID.exr" --force --quiet
END
)
"#
    );
    // Merges the files of a name with the numbers from $1 to $2.
    let merge = |files: &str, output: &str, partial: &str| {
        format!(
            r#"set --
while [ "$first" -le "$last" ]; do
    set -- "$@" "{files}-$first.exr"
    first=$((first + 1))
done
exec {program} merge "$@" -o {output} --force{partial}
"#
        )
    };
    let submit = "sbatch --parsable --kill-on-invalid-dep=yes";
    if parts <= MERGED {
        let merge = merge("part", output, "");
        return format!(
            r#"{script}{submit} --job-name=lookat-merge --dependency="afterok:$parts" --output=merge.log <<'END'
#!/bin/sh
first=0 last={last}
{merge}END
"#
        );
    }
    let each = MERGED.max(parts.isqrt());
    let last_merge = parts.div_ceil(each) - 1;
    let [some, all] = [
        merge("part", r#""merged-$SLURM_ARRAY_TASK_ID.exr""#, " --partial --quiet"),
        merge("merged", output, ""),
    ];
    format!(
        r#"{script}some=$({submit} --job-name=lookat-merge-some --array=0-{last_merge} --requeue --dependency="afterok:$parts" --output=merge-%a.log <<'END'
#!/bin/sh
first=$((SLURM_ARRAY_TASK_ID * {each})) last=$((SLURM_ARRAY_TASK_ID * {each} + {each} - 1))
[ "$last" -le {last} ] || last={last}
{some}END
)
{submit} --job-name=lookat-merge --dependency="afterok:$some" --output=merge.log <<'END'
#!/bin/sh
first=0 last={last_merge}
{all}END
"#
    )
}

/// A job array of Slurm with a task for each picture of `--turntable` or `--animate`.
fn slurm_frames(Names { program, scene, output, options, .. }: &Names, frames: u32) -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!(
        r#"#!/bin/sh
# {frames} pictures of a scene. Made by lookat {version}.
set -eu
sbatch --parsable --job-name=lookat-picture --array=1-{frames} --requeue --output=picture-%a.log <<'END'
#!/bin/sh
exec {program} render {scene}{options} --only "$SLURM_ARRAY_TASK_ID" -o {output} --force --quiet
END
"#
    )
}

/// The full path: jobs start in other folders.
fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|error| Failure::io("find", path, &error))
}
