//! `lookat verify`: compares scenes with the pictures beside them.

pub mod files;
mod outcome;
mod page;
mod scene;
mod table;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lookat_scene::LoadOptions;

use crate::args::{Report, Verify};
use crate::failure::Failure;
use crate::output::{check_folder, check_inputs};
use crate::readable::repeated_command;
use crate::source::load_scene;
use crate::verify::files::{beside, scene_files, why_unreadable};
use crate::verify::outcome::Verdict;

/// Runs the command.
pub fn verify(arguments: &Verify) -> ExitCode {
    crate::exit_code(run(arguments))
}

/// Verifies all scenes of the folder. Returns the exit status.
fn run(arguments: &Verify) -> Result<u8, Failure> {
    let scenes = scene_files(&arguments.folder)?;
    if !arguments.update
        && scenes.iter().all(|scene| why_unreadable(scene).is_none() && beside(scene).next().is_none())
    {
        let folder = arguments.folder.display();
        bail!("no scene in {folder} has a reference picture; --update writes references");
    }
    let inputs = inputs(arguments, &scenes);
    if let Some(file) = &arguments.report {
        check_report(file)?;
        check_inputs(file, &inputs)?;
    }
    let table = table::Table::new(&scenes, arguments.json);
    table.header()?;
    let (mut verdicts, mut updated) = (Vec::new(), false);
    let mut page = arguments.report.as_ref().map(|_| page::Page::new()).transpose()?;
    for scene in &scenes {
        let outcome = scene::verify(arguments, scene, &inputs);
        table.row(&outcome)?;
        verdicts.push(outcome.verdict);
        updated |= outcome.updated;
        if let Some(page) = &mut page {
            page.add(outcome)?;
        }
    }
    table.footer(&verdicts)?;
    if let (Some(file), Some(page)) = (&arguments.report, page) {
        let title = format!("lookat verify {}", arguments.folder.display());
        page.write(file, &title, &repeated_command())?;
    }
    let has = |verdict| verdicts.contains(&verdict);
    let is_trouble = has(Verdict::Failed) || has(Verdict::Undecided);
    Ok(if is_trouble { crate::TROUBLE } else { u8::from(updated || has(Verdict::Differs)) })
}

/// The files that the scenes read, as far as a result could replace them. Reads the texts of the scenes, no meshes and no pictures.
fn inputs(arguments: &Verify, scenes: &[PathBuf]) -> BTreeSet<PathBuf> {
    if !arguments.update && arguments.report.as_ref().is_none_or(|report| !report.exists()) {
        return BTreeSet::new();
    }
    let options = LoadOptions { fast: true, max_memory: arguments.memory.limit(), ..LoadOptions::default() };
    let readable = scenes.iter().filter(|scene| why_unreadable(scene).is_none());
    let loaded = readable.map(|scene| load_scene(scene, &options, Report::default()));
    loaded.flat_map(|loaded| loaded.inputs).collect()
}

/// Fails if the report cannot be written, before hours of rendering.
fn check_report(file: &Path) -> Result<(), Failure> {
    let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !["html", "htm"].contains(&ending) || file.is_dir() {
        bail!("{}: --report writes a web page; its name must end in .html", file.display());
    }
    check_folder(file)
}
