//! Changes a text file that other programs may save at the same time.

use std::borrow::Cow;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::replace::{HIDDEN, TemporaryFile, copy_attributes, fill, has_rest, links, temporary};
use crate::{ImageError, ImageFault, has_text, io_reason, open_file, write_target};

/// The most swaps against a program that saves the file again and again.
const MOST_SWAPS: usize = 16;

/// Changes the contents of a file from `before` to `after`. False, and no change, if it has other contents: another program has
/// saved it. The file keeps its owner, permissions, extended attributes and hard links.
///
/// A new file takes its place, so that a crash leaves one text or the other. If the new file cannot have the attributes, or the old one
/// has several hard links, it is written in place. Until then, a copy of the old text, `lookat-before-...`, is beside it.
///
/// # Errors
///
/// [`ImageFault::Refused`] if the file cannot be read or written. It has the contents `before` then, or the error names the file that has
/// them.
pub fn change_file(path: &Path, before: &[u8], after: &[u8]) -> Result<bool, ImageError> {
    change(path, before, after).map_err(|fault| ImageError::writing(path, fault))
}

fn change(path: &Path, before: &[u8], after: &[u8]) -> Result<bool, ImageFault> {
    let (target, folder) = write_target(path)?;
    if !has_text(&target, before)? {
        return Ok(false);
    }
    let change = Change { target: &target, folder: &folder, before, after };
    if links(&target)? == 1 {
        let mut new = TemporaryFile::new(&folder, HIDDEN)?;
        if copy_attributes(&target, &new.file).is_ok() {
            fill(&mut new.file, |out| Ok(out.write_all(after)?))?;
            return change.exchange(new, swap);
        }
    }
    change.overwrite()
}

/// Writes a previous text of a file beside it, as `lookat-before-...`. Returns the path.
///
/// # Errors
///
/// The folder of the file accepts no file of this size.
pub fn keep_aside(path: &Path, text: &[u8]) -> io::Result<PathBuf> {
    let (_, folder) = write_target(path)?;
    let mut file = file_aside(&folder)?;
    file.write_all(text)?;
    file.as_file().sync_data()?;
    Ok(file.keep()?.1)
}

/// A file beside another one, for its previous text. Other processes leave it alone.
fn file_aside(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix("lookat-before-").tempfile_in(folder)
}

/// A change of a file.
#[derive(Clone, Copy)]
struct Change<'a> {
    target: &'a Path,
    folder: &'a Path,
    before: &'a [u8],
    after: &'a [u8],
}

impl Change<'_> {
    /// Puts a new file in the place of the old one. Other programs save meanwhile: what they have saved stays in place.
    fn exchange(
        self,
        mut new: TemporaryFile,
        swap: impl Fn(&Path, &Path) -> io::Result<()>,
    ) -> Result<bool, ImageFault> {
        let Change { target, folder, before, after } = self;
        let mut temporary = temporary();
        if !has_text(target, before)? {
            return Ok(false);
        }
        // The swap gives this name to the file of another program, and a temporary name would let a third program remove it.
        new.rename(file_aside(folder)?.into_temp_path(), &mut temporary)?;
        match swap(new.path(), target) {
            Ok(()) => {}
            Err(error)
                if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) =>
            {
                // This file system cannot swap. The text was compared a moment ago.
                std::fs::rename(new.path(), target)?;
                return Ok(true);
            }
            Err(error) => return Err(error.into()),
        }
        if has_text(new.path(), before).is_ok_and(|is_same| is_same) {
            return Ok(true);
        }
        // Another program has saved between comparing and swapping.
        if let Err(error) = give_back(new.path(), target, after, swap) {
            new.keep(&mut temporary);
            let (path, reason) = (new.path().display(), io_reason(&error));
            return Err(ImageFault::Refused(format!(
                "another program has saved it meanwhile, and its text is in {path}: {reason}"
            )));
        }
        Ok(false)
    }

    /// Writes into the file itself.
    fn overwrite(self) -> Result<bool, ImageFault> {
        let Change { target, folder, before, after } = self;
        let mut file = OpenOptions::new().read(true).write(true).open(target)?;
        let _no_exit = temporary();
        let mut copy = file_aside(folder)?;
        fill(copy.as_file_mut(), |out| Ok(out.write_all(before)?))?;
        if !has_rest(&file, before)? {
            return Ok(false);
        }
        copy.disable_cleanup(true);
        let written = put(&mut file, after);
        if let Err(error) = &written
            && let Err(again) = put(&mut file, before)
        {
            let (path, reasons) = (copy.path().display(), [error, &again].map(io_reason));
            return Err(ImageFault::Refused(format!(
                "{}; the previous text is in {path}",
                reasons.join("; ")
            )));
        }
        copy.disable_cleanup(false);
        Ok(written.map(|()| true)?)
    }
}

/// Puts the file of another program, `aside`, back in the place of a file with the text `placed`. The program may save once more before
/// that: then the last file that it saved takes the place.
fn give_back(
    aside: &Path,
    target: &Path,
    placed: &[u8],
    swap: impl Fn(&Path, &Path) -> io::Result<()>,
) -> io::Result<()> {
    let mut placed = Cow::Borrowed(placed);
    for _ in 0..MOST_SWAPS {
        let mut text = Vec::new();
        open_file(aside)?.read_to_end(&mut text)?;
        swap(aside, target)?;
        if has_text(aside, &placed)? {
            return Ok(());
        }
        placed = text.into();
    }
    Err(io::Error::other("other programs keep saving it"))
}

/// Swaps the names of two files.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn swap(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};

    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn swap(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Makes this the whole contents.
fn put(file: &mut File, text: &[u8]) -> io::Result<()> {
    file.rewind()?;
    file.write_all(text)?;
    file.set_len(text.len() as u64)?;
    file.sync_data()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::Barrier;
    use std::time::Duration;

    use super::*;
    use crate::replace::remove_abandoned;

    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    /// Saves 400 times at the same time as a change: the save stays, whichever was first.
    fn race(save: impl Fn(&Path, &[u8]) + Sync) {
        const ROUNDS: u64 = 400;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.pbrt");
        let [before, after] = ["before", "after"].map(|text| text.repeat(20_000).into_bytes());
        let begin = Barrier::new(2);
        let mut outcomes = [0; 2];
        for round in 0..ROUNDS {
            std::fs::write(&path, &before).unwrap();
            let mine = format!("mine {round}").into_bytes();
            let is_changed = std::thread::scope(|scope| {
                scope.spawn(|| {
                    begin.wait();
                    // Over all of the change: comparing, writing and renaming.
                    std::thread::sleep(Duration::from_micros(10 * round));
                    save(&path, &mine);
                });
                begin.wait();
                change_file(&path, &before, &after).unwrap()
            });
            assert_eq!(std::fs::read(&path).unwrap(), mine, "round {round}, is changed: {is_changed}");
            outcomes[usize::from(is_changed)] += 1;
        }
        // Some saves came first, and some last.
        assert!(outcomes.iter().all(|count| *count > 0), "{outcomes:?}");
        assert_eq!(names(folder.path()), ["scene.pbrt"]);
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    #[test]
    fn a_save_by_renaming_is_never_lost() {
        race(|path, text| {
            let other = path.with_extension("mine");
            std::fs::write(&other, text).unwrap();
            std::fs::rename(&other, path).unwrap();
        });
    }

    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    #[test]
    fn a_save_in_place_is_never_lost() {
        race(|path, text| std::fs::write(path, text).unwrap());
    }

    /// Another program saves so many times, each time just before the names are swapped. A third program then removes abandoned files.
    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    #[test]
    fn the_last_of_many_saves_stays() {
        for saves in [1, 2, 3, MOST_SWAPS + 2] {
            let folder = tempfile::tempdir().unwrap();
            let (folder, target) = (folder.path(), folder.path().join("scene.pbrt"));
            std::fs::write(&target, "before").unwrap();
            let swaps = Cell::new(0);
            let swap_late = |one: &Path, other: &Path| {
                swaps.set(swaps.get() + 1);
                if swaps.get() <= saves {
                    std::fs::write(folder.join("mine"), format!("mine {}", swaps.get())).unwrap();
                    std::fs::rename(folder.join("mine"), &target).unwrap();
                }
                swap(one, other).inspect(|()| remove_abandoned(folder, HIDDEN))
            };
            let change = Change { target: &target, folder, before: b"before", after: b"after" };
            let mut new = TemporaryFile::new(folder, HIDDEN).unwrap();
            new.file.write_all(b"after").unwrap();
            let changed = change.exchange(new, swap_late);
            let texts: Vec<_> = names(folder)
                .iter()
                .map(|name| std::fs::read_to_string(folder.join(name)).unwrap())
                .collect();
            let last = format!("mine {}", saves.min(MOST_SWAPS + 1));
            assert!(texts.contains(&last), "{texts:?}");
            // If there is no end to it, the message names the file.
            let is_over = saves <= MOST_SWAPS;
            assert_eq!(
                (changed.is_ok_and(|is_changed| !is_changed), texts.len()),
                (is_over, 2 - usize::from(is_over))
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_attributes_are_kept() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};

        let folder = tempfile::tempdir().unwrap();
        let [path, link]: [PathBuf; 2] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&path, "1").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
        let has_attributes = xattr::set(&path, "user.lookat", b"kept").is_ok();
        let check = |text: &str| {
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
            assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, 0o640);
            let kept = xattr::get(&path, "user.lookat").ok().flatten();
            assert_eq!(kept.as_deref(), has_attributes.then_some(&b"kept"[..]));
        };
        assert!(change_file(&path, b"1", b"2").unwrap());
        check("2");
        std::fs::hard_link(&path, &link).unwrap();
        assert!(change_file(&link, b"2", b"longer").unwrap());
        assert!(!change_file(&link, b"2", b"other").unwrap());
        check("longer");
        assert!(change_file(&path, b"longer", b"3").unwrap());
        check("3");
        assert_eq!(std::fs::metadata(&path).unwrap().nlink(), 2);
        let mut names = names(folder.path());
        names.sort();
        assert_eq!(names, ["a", "b"]);
    }

    /// As after `kill -9` in the middle of writing.
    #[cfg(unix)]
    #[test]
    fn files_of_processes_that_are_gone_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "1").unwrap();
        let living = TemporaryFile::new(folder.path(), HIDDEN).unwrap();
        let computer = living.path().file_name().unwrap().to_str().unwrap().rsplit_once('-').unwrap().0;
        let abandoned = folder.path().join(format!("{computer}-123456"));
        let elsewhere = folder.path().join(".lookat-another.computer-123456");
        for file in [&abandoned, &elsewhere] {
            std::fs::write(file, "half").unwrap();
        }
        assert!(change_file(&path, b"1", b"2").unwrap());
        assert!(!abandoned.exists() && elsewhere.exists() && living.path().exists());
        let path = living.path().to_owned();
        drop(living);
        assert!(!path.exists());
    }
}
