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
fn read(Resume { file, threads, quiet }: &Resume) -> Result<(Box<Render>, Resumed), Failure> {
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
    if render.scenes.iter().all(|scene| folder.is_dir() && folder.join(scene).is_file()) {
        std::env::set_current_dir(folder).map_err(|error| Failure::io("enter", folder, &error))?;
    } else if let Some(scene) = render.scenes.iter().find(|scene| !scene.is_file()) {
        bail!(
            "there is no scene {}, neither in {} nor here: go to the folder that has it, and resume there",
            scene.display(),
            folder.display()
        );
    }
    render.checkpoint = Some(shortest(&absolute));
    render.threads = threads.or(render.threads);
    render.quiet |= quiet;
    if !render.quiet && !render.report.json {
        let words: Vec<String> = words.iter().map(|word| quoted(word.as_ref())).collect();
        say!("in {}: lookat {}", std::env::current_dir().unwrap_or_default().display(), words.join(" "));
    }
    Ok((render, resumed))
}

/// The name of a file in the working folder, or its whole path.
fn shortest(file: &Path) -> std::path::PathBuf {
    let folder = std::env::current_dir().unwrap_or_default();
    file.strip_prefix(folder).unwrap_or(file).into()
}
