//! What a file has beside its name and its contents.

use std::fs::File;
use std::io;
use std::path::Path;

/// Gives a new file the permissions of an old one, its owner and its extended attributes. Fails if the system refuses some of them; the
/// new file has the others then.
#[cfg(unix)]
pub fn copy(old: &Path, new: &File) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};

    let (before, now) = (std::fs::metadata(old)?, new.metadata()?);
    let mut results = Vec::new();
    if before.uid() != now.uid() {
        results.push(fchown(new, Some(before.uid()), None));
    }
    if before.gid() != now.gid() {
        results.push(fchown(new, None, Some(before.gid())));
    }
    // Access control lists are attributes, too.
    results.push(copy_extended(old, new));
    // Last, because a new owner takes some of them away.
    results.push(new.set_permissions(before.permissions()));
    results.into_iter().collect()
}

#[cfg(not(unix))]
pub fn copy(old: &Path, new: &File) -> io::Result<()> {
    new.set_permissions(std::fs::metadata(old)?.permissions())
}

#[cfg(unix)]
fn copy_extended(old: &Path, new: &File) -> io::Result<()> {
    use std::collections::BTreeMap;
    use std::ffi::OsString;

    use xattr::FileExt;

    // A file system without attributes has nothing to keep.
    let names = xattr::list_deref(old).into_iter().flatten();
    let wanted = names.filter_map(|name| Some((xattr::get_deref(old, &name).transpose()?, name)));
    let wanted = wanted.map(|(value, name)| Ok((name, value?)));
    let wanted = wanted.collect::<io::Result<BTreeMap<OsString, Vec<u8>>>>()?;
    for name in new.list_xattr().into_iter().flatten().filter(|name| !wanted.contains_key(name)) {
        new.remove_xattr(&name)?;
    }
    for (name, value) in wanted {
        if new.get_xattr(&name)?.as_ref() != Some(&value) {
            new.set_xattr(&name, &value)?;
        }
    }
    Ok(())
}

/// How many names a file has.
#[cfg(unix)]
pub fn links(file: &Path) -> io::Result<u64> {
    Ok(std::os::unix::fs::MetadataExt::nlink(&std::fs::metadata(file)?))
}

/// Where nobody tells, one.
#[cfg(not(unix))]
pub fn links(file: &Path) -> io::Result<u64> {
    std::fs::metadata(file).map(|_| 1)
}
