//! `lookat resume`: goes on with a rendering that was broken off.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser as _;

use crate::args::{Arguments, Command, Render, Resume};
use crate::failure::Failure;
use crate::part::Invocation;
use crate::readable::quoted;
use crate::render::{Resumed, render};

/// Runs the command.
pub fn resume(arguments: &Resume) -> ExitCode {
    match read(arguments) {
        Ok((arguments, resumed)) => render(&arguments, Some(resumed)),
        Err(failure) => crate::exit_code(Err(failure)),
    }
}

/// The command that was broken off, with the checkpoint. Goes to its folder, if this machine has it.
fn read(Resume { file, threads, force, quiet }: &Resume) -> Result<(Box<Render>, Resumed), Failure> {
    let absolute = std::path::absolute(file).map_err(|error| Failure::io("find", file, &error))?;
    let resumed = Resumed::read(&absolute)?;
    let Some(Invocation { folder, words }) = resumed.broken_off.as_ref().map(|it| it.invocation.clone())
    else {
        bail!("{} is no checkpoint", file.display());
    };
    let typed = std::iter::once("lookat").chain(words.iter().map(String::as_str));
    let mut render = match Arguments::try_parse_from(typed).map(|parsed| parsed.command) {
        Ok(Command::Render(render)) => render,
        _ => bail!("{} is damaged, or of another version of lookat", file.display()),
    };
    let folder = Path::new(&folder);
    render.checkpoint = Some(file.clone());
    if render.scenes.iter().all(|scene| folder.is_dir() && folder.join(scene).is_file()) {
        let here = std::env::current_dir().unwrap_or_default();
        std::env::set_current_dir(folder).map_err(|error| Failure::io("enter", folder, &error))?;
        if std::env::current_dir().unwrap_or_default() != here {
            render.checkpoint = Some(absolute);
        }
    } else if let Some(scene) = render.scenes.iter().find(|scene| !scene.is_file()) {
        bail!(
            "there is no scene {}, neither in {} nor here: go to the folder that has it, and resume there",
            scene.display(),
            folder.display()
        );
    }
    render.threads = threads.or(render.threads);
    render.quiet |= quiet;
    render.force |= force;
    if !render.quiet && !render.report.json {
        let words: Vec<String> = words.iter().map(|word| quoted(word.as_ref())).collect();
        say!("in {}: lookat {}", std::env::current_dir().unwrap_or_default().display(), words.join(" "));
    }
    Ok((render, resumed))
}
