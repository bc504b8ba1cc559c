//! Files that are read.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens a file for reading.
///
/// # Errors
///
/// As [`File::open`], and for a folder, a pipe or a device: opening a pipe waits for a writer, and some devices never end.
pub fn open_file(path: &Path) -> io::Result<File> {
    // First, because opening a device can change it.
    check_kind(&std::fs::metadata(path)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // Another program may have put a pipe there since: then this does not wait.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
    );
    let file = match options.open(path) {
        // A file server has lent the file, and takes it back first.
        Err(error) if error.kind() == ErrorKind::WouldBlock => File::open(path)?,
        opened => opened?,
    };
    check_kind(&file.metadata()?)?;
    Ok(file)
}

/// Fails unless this is a file.
fn check_kind(found: &Metadata) -> io::Result<()> {
    match () {
        () if found.is_file() => Ok(()),
        () if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
        () => Err(io::Error::other("it is a pipe or a device, not a file")),
    }
}

/// True if a file has exactly this text. Takes no memory for a larger file.
///
/// # Errors
///
/// As [`open_file`], and if reading fails.
pub fn has_text(path: &Path, text: &[u8]) -> io::Result<bool> {
    has_rest(&open_file(path)?, text)
}

/// True if the rest of an open file is exactly this text.
pub(crate) fn has_rest(mut file: &File, text: &[u8]) -> io::Result<bool> {
    let mut buffer = vec![0; 1 << 16];
    let mut rest = text;
    loop {
        let read = match file.read(&mut buffer) {
            Ok(0) => return Ok(rest.is_empty()),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            read => read?,
        };
        match rest.strip_prefix(&buffer[..read]) {
            Some(left) => rest = left,
            None => return Ok(false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_compared_to_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let text = vec![7; 200_000];
        std::fs::write(&path, &text).unwrap();
        assert!(has_text(&path, &text).unwrap());
        assert!(!has_text(&path, &text[1..]).unwrap());
        assert!(!has_text(&path, &[&text[..], &[7]].concat()).unwrap());
        assert!(!has_text(&path, &[&text[1..], &[8]].concat()).unwrap());
        assert_eq!(has_text(folder.path(), &text).unwrap_err().kind(), ErrorKind::IsADirectory);
    }
}
