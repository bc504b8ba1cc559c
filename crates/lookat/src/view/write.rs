//! Changes of the files of a scene: unsaved ones, with which the scene is read, and written ones, which can be reverted.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use lookat_image::{ImageError, change_file, has_text, io_reason, keep_aside};
use lookat_scene::Sources;
use lookat_scene::syntax::Fix;

use crate::failure::Failure;
use crate::output::is_among;
use crate::view::messages::ChangedLines;

/// The most bytes of texts that are kept to take changes back.
const MOST_KEPT: usize = 256 << 20;

/// A file before and after a change.
#[derive(Clone, PartialEq)]
pub struct FileChange {
    pub path: PathBuf,
    pub before: Bytes,
    pub after: Bytes,
}

/// The files that fixes change. Fails for a file that the scene includes twice: a change here would change both places.
pub fn changes(sources: &Sources, fixes: &[Fix]) -> Result<Vec<FileChange>, Failure> {
    let mut fixes: Vec<&Fix> = fixes.iter().collect();
    // Insertions at one place keep their order.
    fixes.sort_by_key(|fix| (fix.span.file.0, fix.span.start));
    fixes.chunk_by(|a, b| a.span.file == b.span.file).map(|fixes| change(sources, fixes)).collect()
}

/// What fixes of one file, in the order of their places, make of it.
fn change(sources: &Sources, fixes: &[&Fix]) -> Result<FileChange, Failure> {
    let source = sources.file(fixes[0].span.file);
    let path = source.path.clone();
    if sources.files.iter().filter(|other| is_among(&other.path, [&path])).count() > 1 {
        bail!("{} is included twice: change it by hand", path.display());
    }
    let before = source.text.clone();
    let mut after = Vec::with_capacity(before.len());
    let mut end = 0;
    for Fix { span, replacement } in fixes {
        after.extend_from_slice(&before[end..span.start as usize]);
        after.extend_from_slice(replacement.as_bytes());
        end = span.end as usize;
    }
    after.extend_from_slice(&before[end..]);
    Ok(FileChange { path, before, after: after.into() })
}

impl FileChange {
    /// The lines that differ.
    pub fn lines(&self) -> Vec<ChangedLines> {
        let [before, after] =
            [&self.before, &self.after].map(|text| text.split(|byte| *byte == b'\n').collect::<Vec<_>>());
        let same = |(a, b): &(&&[u8], &&[u8])| a == b;
        let first = before.iter().zip(&after).take_while(same).count();
        let rest = [&before[first..], &after[first..]];
        let last = rest[0].iter().rev().zip(rest[1].iter().rev()).take_while(same).count();
        let [before, after] = rest.map(|lines| &lines[..lines.len() - last]);
        let text =
            |lines: &[&[u8]]| lines.iter().map(|line| String::from_utf8_lossy(line).into_owned()).collect();
        let file = self.path.display().to_string();
        let changed = |line: usize, removed: &[&[u8]], added: &[&[u8]]| ChangedLines {
            file: file.clone(),
            line: first + line + 1,
            removed: text(removed),
            added: text(added),
        };
        if before.len() != after.len() {
            return vec![changed(0, before, after)];
        }
        let mut runs = Vec::new();
        let mut line = 0;
        while line < before.len() {
            let differing = before[line..].iter().zip(&after[line..]).take_while(|pair| !same(pair)).count();
            if differing > 0 {
                runs.push(changed(line, &before[line..line + differing], &after[line..line + differing]));
            }
            line += differing.max(1);
        }
        runs
    }

    fn reversed(&self) -> FileChange {
        FileChange { path: self.path.clone(), before: self.after.clone(), after: self.before.clone() }
    }
}

/// Changes of the files so far.
#[derive(Default)]
pub struct History {
    pub done: Vec<Vec<FileChange>>,
    pub undone: Vec<Vec<FileChange>>,
}

impl History {
    /// Changes files. Fails, and changes nothing, if one of them is not as it was before.
    pub fn write(&mut self, changes: Vec<FileChange>) -> Result<(), Failure> {
        put(&changes, &change_file)?;
        self.undone.clear();
        self.done.push(changes);
        forget_first(&mut self.done, |changes| changes);
        Ok(())
    }

    pub fn undo(&mut self) -> Result<(), Failure> {
        let changes = self.done.last().ok_or("there is nothing to undo")?;
        put(&changes.iter().map(FileChange::reversed).collect::<Vec<_>>(), &change_file)?;
        self.undone.extend(self.done.pop());
        Ok(())
    }

    pub fn redo(&mut self) -> Result<(), Failure> {
        put(self.undone.last().ok_or("there is nothing to redo")?, &change_file)?;
        self.done.extend(self.undone.pop());
        Ok(())
    }
}

/// Forgets the first steps, as long as all of them have too many bytes.
pub fn forget_first<T>(steps: &mut Vec<T>, changes: impl Fn(&T) -> &[FileChange]) {
    let bytes = |step: &T| -> usize {
        changes(step).iter().map(|change| change.before.len() + change.after.len()).sum()
    };
    while steps.len() > 1 && steps.iter().map(bytes).sum::<usize>() > MOST_KEPT {
        steps.remove(0);
    }
}

/// [`change_file`], or what a test puts in its place.
type ChangeFile<'a> = &'a dyn Fn(&Path, &[u8], &[u8]) -> Result<bool, ImageError>;

/// Writes all files or none. If it can do neither, the message names the files that stay changed.
fn put(changes: &[FileChange], change_file: ChangeFile) -> Result<(), Failure> {
    for FileChange { path, before, .. } in changes {
        match has_text(path, before) {
            Ok(true) => {}
            Ok(false) => return Err((changed_meanwhile(path) + NOTHING_WRITTEN).into()),
            Err(error) => bail!("{}: {}", path.display(), io_reason(&error)),
        }
        // Replacing a file needs no permission to write it.
        if std::fs::metadata(path).is_ok_and(|found| found.permissions().readonly()) {
            bail!("{} is write-protected", path.display());
        }
    }
    for (number, FileChange { path, before, after }) in changes.iter().enumerate() {
        let (reason, end) = match change_file(path, before, after) {
            Ok(true) => continue,
            Ok(false) => (changed_meanwhile(path), NOTHING_WRITTEN),
            Err(error) => (error.to_string(), ""),
        };
        let stay: Vec<String> =
            changes[..number].iter().filter_map(|change| take_back(change, change_file)).collect();
        let reason = if stay.is_empty() { reason + end } else { format!("{reason}; {}", stay.join("; ")) };
        return Err(reason.into());
    }
    Ok(())
}

/// Takes a change back. If the file stays changed, returns why, and where its previous text is.
fn take_back(FileChange { path, before, after }: &FileChange, change_file: ChangeFile) -> Option<String> {
    let reason = match change_file(path, after, before) {
        Ok(true) => return None,
        Ok(false) => "another program has saved it".into(),
        Err(error) => error.to_string(),
    };
    let kept = match keep_aside(path, before) {
        Ok(aside) => format!("its previous text is in {}", aside.display()),
        Err(error) => format!("its previous text cannot be kept: {}", io_reason(&error)),
    };
    Some(format!("{} stays changed ({reason}); {kept}", path.display()))
}

const NOTHING_WRITTEN: &str = ": nothing is written";

fn changed_meanwhile(path: &Path) -> String {
    format!("{} has changed meanwhile", path.display())
}

/// Exchanges the texts for the last ones of a list, and keeps them in another list. False if there are none.
fn step(
    files: &mut Vec<FileChange>,
    from: &mut Vec<(String, Vec<FileChange>)>,
    to: &mut Vec<(String, Vec<FileChange>)>,
) -> bool {
    let Some((what, others)) = from.pop() else { return false };
    to.push((what, std::mem::replace(files, others)));
    true
}

/// The changes that pages were shown last, and these pages.
#[derive(Default)]
pub struct Shown {
    pub changes: Vec<FileChange>,
    pub pages: BTreeSet<u32>,
}

/// The files on disk and their texts for the scene, with the states before and after.
#[derive(Default, Clone)]
pub struct Unsaved {
    pub files: Vec<FileChange>,
    /// The earlier states, and what was changed then.
    pub done: Vec<(String, Vec<FileChange>)>,
    pub undone: Vec<(String, Vec<FileChange>)>,
}

impl Unsaved {
    /// The text to read in place of a file.
    pub fn text(&self, path: &Path) -> Option<Bytes> {
        self.files.iter().find(|change| change.path == path).map(|change| change.after.clone())
    }

    /// Goes on from these texts. Changes of the same thing in a row are undone at once.
    pub fn add(&mut self, what: String, changes: Vec<FileChange>) {
        if self.done.last().is_none_or(|(before, _)| *before != what) {
            self.done.push((what, self.files.clone()));
            forget_first(&mut self.done, |(_, changes)| changes);
        }
        self.undone.clear();
        self.files = self.with(changes);
    }

    /// The changes from the files on disk to these texts and further `changes` of them.
    pub fn with(&self, changes: Vec<FileChange>) -> Vec<FileChange> {
        let mut all = self.files.clone();
        for change in changes {
            match all.iter_mut().find(|known| known.path == change.path) {
                Some(known) => known.after = change.after,
                None => all.push(change),
            }
        }
        all.retain(|change| change.before != change.after);
        all
    }

    /// Returns to the state before the last change. False if there is none.
    pub fn undo(&mut self) -> bool {
        step(&mut self.files, &mut self.done, &mut self.undone)
    }

    pub fn redo(&mut self) -> bool {
        step(&mut self.files, &mut self.undone, &mut self.done)
    }

    /// Forgets the changes of files that are no longer as they were, and the way to them. True if there were some that have not
    /// been written.
    pub fn forget_old(&mut self) -> bool {
        let has_now = |path: &Path, text: &[u8]| has_text(path, text).is_ok_and(|is_same| is_same);
        let is_old = |change: &FileChange| !has_now(&change.path, &change.before);
        let is_written = |change: &FileChange| has_now(&change.path, &change.after);
        let steps = || self.done.iter().chain(&self.undone).flat_map(|(_, changes)| changes);
        let is_lost = self.files.iter().any(|change| is_old(change) && !is_written(change));
        let has_old_steps = steps().any(is_old);
        self.files.retain(|change| !is_old(change));
        if is_lost || has_old_steps || (self.files.is_empty() && !self.done.is_empty()) {
            self.done.clear();
            self.undone.clear();
        }
        is_lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_differ_are_shown() {
        let lines = |before: &str, after: &str| -> Vec<_> {
            let changed = change(Path::new("a"), before, after).lines();
            changed.into_iter().map(|it| (it.line, it.removed.join("|"), it.added.join("|"))).collect()
        };
        let line = |line: usize, removed: &str, added: &str| (line, removed.to_owned(), added.to_owned());
        assert_eq!(lines("a\nb\nc\nd", "a\nB\nc\nD"), [line(2, "b", "B"), line(4, "d", "D")]);
        assert_eq!(lines("a\nb\nc\nd\n", "a\nbc\nd\n"), [line(2, "b|c", "bc")]);
        assert_eq!(lines("a\na\n", "a\na\na\n"), [line(3, "", "a")]);
        assert!(lines("a\n", "a\n").is_empty());
    }

    fn change(path: &Path, before: &str, after: &str) -> FileChange {
        let text = |text: &str| text.to_owned().into();
        FileChange { path: path.into(), before: text(before), after: text(after) }
    }

    #[test]
    fn changes_are_written_undone_and_done_again() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        let texts = || [&a, &b].map(|path| std::fs::read_to_string(path).unwrap());
        std::fs::write(&a, "1").unwrap();
        std::fs::write(&b, "2").unwrap();
        let mut history = History::default();
        assert!(history.undo().is_err() && history.redo().is_err());
        history.write(vec![change(&a, "1", "3"), change(&b, "2", "4")]).unwrap();
        history.write(vec![change(&a, "3", "5")]).unwrap();
        assert_eq!(texts(), ["5", "4"]);
        history.undo().unwrap();
        history.undo().unwrap();
        assert_eq!(texts(), ["1", "2"]);
        assert!(history.done.is_empty() && !history.undone.is_empty());
        history.redo().unwrap();
        assert_eq!(texts(), ["3", "4"]);
        // Another program changes one of the files.
        std::fs::write(&b, "mine").unwrap();
        let reason = history.undo().unwrap_err().to_string();
        assert!(reason.contains("has changed meanwhile"), "{reason}");
        assert_eq!(texts(), ["3", "mine"]);
        std::fs::remove_file(&b).unwrap();
        assert!(history.undo().is_err());
        // A new change forgets the ones that were undone.
        history.write(vec![change(&a, "3", "6")]).unwrap();
        assert!(history.undone.is_empty());
    }

    /// Another program saves the second file, and then maybe the first one, while both are written.
    #[test]
    fn files_that_stay_changed_are_named() {
        for is_saved_again in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
            std::fs::write(&a, "1").unwrap();
            std::fs::write(&b, "2").unwrap();
            let change_late = |path: &Path, before: &[u8], after: &[u8]| {
                if path == b {
                    std::fs::write(&b, "mine").unwrap();
                    if is_saved_again {
                        std::fs::write(&a, "also mine").unwrap();
                    }
                }
                change_file(path, before, after)
            };
            let reason =
                put(&[change(&a, "1", "3"), change(&b, "2", "4")], &change_late).unwrap_err().to_string();
            let texts = [&a, &b].map(|path| std::fs::read_to_string(path).unwrap());
            assert_eq!(texts, [if is_saved_again { "also mine" } else { "1" }, "mine"]);
            assert_eq!(reason.ends_with(NOTHING_WRITTEN), !is_saved_again, "{reason}");
            assert_eq!(
                reason.contains(&format!("{} stays changed", a.display())),
                is_saved_again,
                "{reason}"
            );
            let kept = reason
                .split_once("its previous text is in ")
                .map(|(_, path)| std::fs::read_to_string(path).unwrap());
            assert_eq!(kept.as_deref(), is_saved_again.then_some("1"));
        }
    }

    #[test]
    fn the_lines_that_differ_are_found() {
        let lines = |before, after| {
            let lines = change(Path::new("a"), before, after).lines();
            lines.into_iter().map(|it| (it.line, it.removed.concat(), it.added.concat())).collect::<Vec<_>>()
        };
        let told = |line, removed: &str, added: &str| (line, removed.to_owned(), added.to_owned());
        assert_eq!(lines("a\nb\nc\nd\n", "a\nB\nc\nD\n"), [told(2, "b", "B"), told(4, "d", "D")]);
        assert_eq!(lines("a\nb", "c\nd"), [told(1, "ab", "cd")]);
        assert_eq!(lines("a\r\n", "b\r\n"), [told(1, "a\r", "b\r")]);
        assert!(lines("a\n", "a\n").is_empty());
    }
}
