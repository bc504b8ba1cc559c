//! `lookat resume`: goes on with a rendering that was broken off.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser as _;

use crate::args::{Arguments, Command, Render, Resume};
use crate::failure::Failure;
use crate::part::Invocation;
use crate::readable::quoted;
use crate::render::{Resumed, linked, render};

/// Runs the command.
pub fn resume(arguments: &Resume) -> ExitCode {
    match read(arguments) {
        Ok((arguments, resumed)) => render(&arguments, Some(resumed)),
        Err(failure) => crate::exit_code(Err(failure)),
    }
}

/// The command that was broken off, with the checkpoint. Goes to its folder, if the scene is there.
fn read(arguments: &Resume) -> Result<(Box<Render>, Resumed), Failure> {
    let Resume { file, output, threads, force, quiet } = arguments;
    let full = |file: &Path| std::path::absolute(file).map_err(|error| Failure::io("find", file, &error));
    let checkpoint = full(file)?;
    let named_output = output.as_deref().map(full).transpose()?;
    let mut resumed = Resumed::read(&linked(&checkpoint)?)?;
    let Some(Invocation { folder, words, output }) = resumed.broken_off.as_mut().map(|it| &mut it.invocation)
    else {
        bail!("{} is no checkpoint", file.display());
    };
    let typed = std::iter::once("lookat").chain(words.iter().map(String::as_str));
    let Ok(Command::Render(mut render)) = Arguments::try_parse_from(typed).map(|parsed| parsed.command)
    else {
        let message = format!("{} is damaged, or of another version of lookat", file.display());
        return Err(Failure::NoCheckpoint(message));
    };
    render.threads = threads.or(render.threads);
    render.quiet |= quiet;
    let is_told = !render.quiet && !render.report.json;
    let recorded = render.output.clone();
    render.output = output.as_ref().map(PathBuf::from).or(render.output);
    let (folder, here) = (Path::new(folder), std::env::current_dir().unwrap_or_default());
    render.checkpoint = Some(file.clone());
    if folder.is_dir() && folder.join(&render.scenes[0]).is_file() {
        std::env::set_current_dir(folder).map_err(|error| Failure::io("enter", folder, &error))?;
        if std::env::current_dir().unwrap_or_default() != here {
            render.checkpoint = Some(checkpoint);
        }
    } else {
        let scene = &mut render.scenes[0];
        if !scene.is_file() {
            let own = named(scene);
            if !own.is_file() {
                bail!(
                    "there is no scene {}, neither in {} nor here: go to the folder that has it, and resume there",
                    scene.display(),
                    folder.display()
                );
            }
            if is_told {
                say!("there is no {}: going on with {} here", scene.display(), own.display());
            }
            *scene = own;
        }
        if let Some(output) = &mut render.output {
            let has_folder = output.parent().is_none_or(|it| it == Path::new("") || it.is_dir());
            if !has_folder {
                *output = named(output);
            }
        }
    }
    if is_told {
        let words: Vec<String> = words.iter().map(|word| quoted(word.as_ref())).collect();
        say!("in {}: lookat {}", std::env::current_dir().unwrap_or_default().display(), words.join(" "));
    }
    render.output = named_output.or(render.output);
    if render.output != recorded {
        let picture = render.output.as_deref().unwrap_or(Path::new(""));
        if is_told {
            say!("the picture goes to {}", picture.display());
        }
        // Also after the next break.
        *output = full(picture)?.to_str().map(String::from);
        // That of the command was for another file.
        render.force = false;
    }
    render.force |= force;
    Ok((render, resumed))
}

/// A file of this name in the working folder.
fn named(file: &Path) -> PathBuf {
    file.file_name().unwrap_or_default().into()
}
