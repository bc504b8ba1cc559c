//! Finds the intended file for the name of a missing one.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use lookat_syntax::{nearest, same_digits};

/// The most entries read from one folder, and from all folders.
const MOST_ENTRIES: usize = 10_000;
const MOST_IN_ALL: usize = 1_000_000;
/// The most components of a name.
const MOST_PARTS: usize = 16;

/// The entries of folders, each listed once.
#[derive(Default)]
pub(super) struct Folders {
    listed: HashMap<PathBuf, Vec<String>>,
    entries: usize,
}

/// A search for a component of a name among the entries of a folder.
type Find = fn(&str, &[String]) -> Option<String>;

impl Folders {
    /// The intended file below one of the folders, if one exists. The given name may differ in case or slashes, contain
    /// a typing mistake, or start with folders of another machine.
    pub fn meant(&mut self, name: &str, folders: &[PathBuf]) -> Option<String> {
        let name = name.replace('\\', "/");
        let parts: Vec<&str> = name.split('/').filter(|part| !matches!(*part, "" | ".")).collect();
        if parts.len() > MOST_PARTS {
            return None;
        }
        let mut below = |from: usize, find: Find| {
            folders.iter().find_map(|folder| self.file(folder, &parts[from..], find))
        };
        if let Some(found) = below(0, same).or_else(|| below(0, misspelled)) {
            return Some(found);
        }
        // An existing folder does not belong to another machine.
        let is_here = folders.iter().any(|folder| folder.join(parts.first().unwrap_or(&"")).is_dir());
        let is_absolute = name.starts_with('/');
        if is_here && !is_absolute { None } else { (1..parts.len()).find_map(|from| below(from, same)) }
    }

    /// Follows the components of a name.
    fn file(&mut self, folder: &Path, parts: &[&str], find: Find) -> Option<String> {
        let (mut path, mut found) = (folder.to_owned(), Vec::new());
        for part in parts {
            let entry = if *part == ".." { "..".to_owned() } else { find(part, self.entries(&path))? };
            path.push(&entry);
            found.push(entry);
        }
        path.is_file().then(|| found.join("/"))
    }

    /// The sorted names in a folder, without names that a scene cannot contain unescaped.
    fn entries(&mut self, folder: &Path) -> &[String] {
        let left = MOST_IN_ALL - self.entries.min(MOST_IN_ALL);
        self.listed.entry(folder.to_owned()).or_insert_with(|| {
            let path = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let entries = fs::read_dir(path).into_iter().flatten().take(MOST_ENTRIES.min(left)).flatten();
            let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
            let is_plain = |name: &String| !name.contains(|c: char| c.is_control() || c == '"' || c == '\\');
            let mut names: Vec<String> = names.filter(is_plain).collect();
            names.sort_unstable();
            self.entries += names.len();
            names
        })
    }
}

/// An entry with the same name, or one that differs in case.
fn same(part: &str, entries: &[String]) -> Option<String> {
    let exact = entries.iter().find(|entry| *entry == part);
    let lower = part.to_lowercase();
    exact.or_else(|| entries.iter().find(|entry| entry.to_lowercase() == lower)).cloned()
}

/// An entry with the same name, or a misspelled one. The digits and the extension must agree.
fn misspelled(part: &str, entries: &[String]) -> Option<String> {
    if let Some(entry) = same(part, entries) {
        return Some(entry);
    }
    let split = |name: &str| -> (String, String) {
        let name = name.to_lowercase();
        name.rsplit_once('.')
            .map_or((name.clone(), String::new()), |(stem, ending)| (stem.into(), ending.into()))
    };
    let is_near = |a: &str, b: &str| a == b || nearest(a, [b]).is_some();
    let (stem, ending) = split(part);
    let is_slip = |entry: &&str| {
        let (found, format) = split(entry);
        same_digits(entry, part) && !found.is_empty() && is_near(&stem, &found) && is_near(&ending, &format)
    };
    nearest(part, entries.iter().map(String::as_str).filter(is_slip)).map(str::to_owned)
}
