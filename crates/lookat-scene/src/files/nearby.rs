//! The file that was meant by a name that leads nowhere.

use std::fs;
use std::path::{Path, PathBuf};

use lookat_syntax::nearest;

/// Of a folder at most so many entries are looked at.
const MOST_ENTRIES: usize = 10_000;

/// The name of a file below one of the folders: that of other case, with other slashes, without the folders of another
/// machine before it, or misspelt.
pub(super) fn meant(name: &str, folders: &[PathBuf]) -> Option<String> {
    let name = name.replace('\\', "/");
    let parts: Vec<&str> = name.split('/').filter(|part| !matches!(*part, "" | ".")).collect();
    let below = |from: usize| folders.iter().find_map(|folder| file(folder, &parts[from..], same));
    (0..parts.len())
        .find_map(below)
        .or_else(|| folders.iter().find_map(|folder| file(folder, &parts, misspelt)))
}

/// How the last part of a name is found among the entries of a folder.
type Find = fn(&str, &[String]) -> Option<String>;

/// Follows the parts of a name from entry to entry.
fn file(folder: &Path, parts: &[&str], find_last: Find) -> Option<String> {
    let (last, before) = parts.split_last()?;
    let (mut path, mut found) = (folder.to_owned(), Vec::new());
    for part in before {
        let entry = if *part == ".." { "..".to_owned() } else { same(part, &entries(&path))? };
        path.push(&entry);
        found.push(entry);
    }
    let entry = find_last(last, &entries(&path))?;
    path.push(&entry);
    found.push(entry);
    path.is_file().then(|| found.join("/"))
}

/// As it is written, or but for upper and lower case.
fn same(part: &str, entries: &[String]) -> Option<String> {
    let exact = entries.iter().find(|entry| *entry == part);
    let lower = part.to_lowercase();
    exact.or_else(|| entries.iter().find(|entry| entry.to_lowercase() == lower)).cloned()
}

/// Of files that are numbered, another number is no slip.
fn misspelt(part: &str, entries: &[String]) -> Option<String> {
    let digits = |name: &str| name.chars().filter(char::is_ascii_digit).collect::<String>();
    let number = digits(part);
    let others = entries.iter().map(String::as_str).filter(|entry| digits(entry) == number);
    nearest(part, others).map(str::to_owned)
}

/// The names in a folder, in order.
fn entries(folder: &Path) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.take(MOST_ENTRIES).collect();
    names.sort_unstable();
    names
}
