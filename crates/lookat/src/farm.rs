//! `lookat farm`: prints a script that renders a scene in parts, as jobs of an engine, and merges them.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser as _;

use crate::args::{Arguments, Command, Engine, Farm, Render};
use crate::failure::{Failure, SCENE_FAULT};
use crate::output::{check_inputs, check_output};
use crate::readable::quoted;
use crate::render::job::load_options;
use crate::source::{load_scene, replace_samples};
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
fn parse(Farm { scene, options, .. }: &Farm) -> Result<Box<Render>, clap::Error> {
    let words = ["lookat".into(), "render".into(), scene.clone().into_os_string()];
    let options = options.iter().map(Into::into);
    let parsed = Arguments::try_parse_from(words.into_iter().chain(options))?;
    match parsed.command {
        Command::Render(render) => Ok(render),
        _ => unreachable!("the second word is render"),
    }
}

/// Checks what can be checked before any job starts, and prints the script.
fn run(arguments: &Farm, render: &Render) -> Result<u8, Failure> {
    let Farm { engine, scene, parts, output, options } = arguments;
    let [scene, output] = [absolute(scene)?, absolute(output)?];
    if render.output.is_some() || render.part.is_some() || render.frames.is_used() || render.live.watch {
        bail!(
            "a farm renders the parts of one picture: it needs no lookat render -o, --part, --watch, --turntable or --animate"
        );
    }
    let mut loaded = load_scene(&scene, &load_options(render), render.report);
    report::print(&loaded, true);
    replace_samples(&mut loaded, render.spp);
    let Some(found) = &loaded.scene else { return Ok(SCENE_FAULT) };
    let samples = found.view.sampler.samples_per_pixel;
    if *parts > samples {
        bail!(
            "{samples} samples per pixel make at most {samples} parts; write fewer, or increase lookat render --spp behind --"
        );
    }
    let crop = found.view.film.crop;
    check_output(&output, [crop.width(), crop.height()])?;
    check_inputs(&output, &loaded.inputs)?;
    let options: Vec<String> = options.iter().map(|option| quoted(option.as_ref())).collect();
    let program =
        std::env::current_exe().map_err(|error| Failure::io("find", Path::new("lookat"), &error))?;
    let folder = output.with_extension("parts");
    let [program, scene, output, folder] =
        [program, scene, output, folder].map(|path| quoted(path.as_os_str()));
    let names = Names { program, scene, output, folder, options: options.join(" ") };
    crate::print(&match engine {
        Engine::Slurm => slurm(&names, *parts),
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
    /// The options of the rendering.
    options: String,
}

/// A job array of Slurm, and a job that depends on it. An array task that is requeued writes its part again; the part appears whole or not at all.
fn slurm(Names { program, scene, output, folder, options }: &Names, parts: u32) -> String {
    let (last, version) = (parts - 1, env!("CARGO_PKG_VERSION"));
    let options = if options.is_empty() { String::new() } else { format!(" {options}") };
    format!(
        r#"#!/bin/sh
# {parts} parts of a rendering, and the job that merges them. Made by lookat {version}.
set -eu
mkdir -p {folder}
cd {folder}
parts=$(sbatch --parsable --job-name=lookat-part --array=0-{last} --requeue --output=part-%a.log <<'END'
#!/bin/sh
exec {program} render {scene}{options} --part "$SLURM_ARRAY_TASK_ID/{parts}" -o "part-$SLURM_ARRAY_TASK_ID.exr" --force --quiet
END
)
sbatch --job-name=lookat-merge --dependency="afterok:$parts" --kill-on-invalid-dep=yes --output=merge.log <<'END'
#!/bin/sh
set --
part=0
while [ "$part" -lt {parts} ]; do
    set -- "$@" "part-$part.exr"
    part=$((part + 1))
done
exec {program} merge "$@" -o {output} --force
END
"#
    )
}

/// The full path: jobs start in other folders.
fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|error| Failure::io("find", path, &error))
}
