//! Changes a text file that other programs may save at the same time.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek, Write};
use std::path::Path;

use super::temporary::{HIDDEN, TemporaryFile, temporary};
use super::{attributes, fill, write_target};
use crate::error::{Fault, ImageError};
use crate::input::{has_rest, has_text};
use crate::io_reason;

/// Changes the contents of a file from `before` to `after`. False, and no change, if it has other contents: another program has
/// saved it. The file keeps its owner, permissions, extended attributes and hard links.
///
/// A new file takes its place, so that a crash leaves one text or the other. If the new file cannot have the attributes, or the old one
/// has several hard links, it is written in place. Until then, a copy of the old text, `lookat-before-...`, is beside it.
///
/// # Errors
///
/// [`ImageError::Write`] if the file cannot be read or written. It has the contents `before` then, or the error names the file that has
/// them.
pub fn change_file(path: &Path, before: &[u8], after: &[u8]) -> Result<bool, ImageError> {
    change(path, before, after).map_err(|fault| ImageError::writing(path, fault))
}

fn change(path: &Path, before: &[u8], after: &[u8]) -> Result<bool, Fault> {
    let (target, folder) = write_target(path).map_err(|error| Fault::Unfit(error.to_string()))?;
    if !has_text(&target, before)? {
        return Ok(false);
    }
    if attributes::links(&target)? == 1 {
        let mut new = TemporaryFile::new(&folder, HIDDEN)?;
        if attributes::copy(&target, &new.file).is_ok() {
            fill(&mut new.file, |out| Ok(out.write_all(after)?))?;
            return exchange(new, &target, before, after);
        }
    }
    overwrite(&target, &folder, before, after)
}

/// Puts a new file in the place of the old one. Other programs save meanwhile: what they have saved stays in place.
fn exchange(mut new: TemporaryFile, target: &Path, before: &[u8], after: &[u8]) -> Result<bool, Fault> {
    let no_exit = temporary();
    if !has_text(target, before)? {
        return Ok(false);
    }
    match swap(new.path(), target) {
        Ok(()) => {}
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
            // This file system cannot swap. The text was compared a moment ago.
            drop(no_exit);
            new.rename(target)?;
            return Ok(true);
        }
        Err(error) => return Err(error.into()),
    }
    let had = |text| has_text(new.path(), text).is_ok_and(|is_same| is_same);
    if had(before) {
        return Ok(true);
    }
    // Another program has saved between comparing and swapping: its file goes back. It may save once more before that, and then this
    // text goes back.
    let mut returned = swap(new.path(), target);
    if returned.is_ok() && !had(after) {
        returned = swap(new.path(), target);
    }
    if let Err(error) = returned {
        new.keep();
        let (path, reason) = (new.path().display(), io_reason(&error));
        return Err(Fault::Unfit(format!(
            "another program has saved it meanwhile, and its text is in {path}: {reason}"
        )));
    }
    Ok(false)
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

/// Writes into the file itself.
fn overwrite(target: &Path, folder: &Path, before: &[u8], after: &[u8]) -> Result<bool, Fault> {
    let mut file = OpenOptions::new().read(true).write(true).open(target)?;
    let _no_exit = temporary();
    let mut copy = tempfile::Builder::new().prefix("lookat-before-").tempfile_in(folder)?;
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
        return Err(Fault::Unfit(format!("{}; the previous text is in {path}", reasons.join("; "))));
    }
    copy.disable_cleanup(false);
    Ok(written.map(|()| true)?)
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
    use std::path::PathBuf;
    use std::sync::Barrier;
    use std::time::Duration;

    use super::*;

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
