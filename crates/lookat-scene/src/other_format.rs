//! Files of other formats, by their first bytes.

/// The start of a Git LFS pointer, which replaces a file in a repository.
pub(crate) const LFS_POINTER: &[u8] = b"version https://git-lfs";
pub(crate) const LFS_REASON: &str = "this is a Git LFS pointer: `git lfs pull` fetches the file";

/// The format of a file that is not a scene, by its first bytes.
pub(crate) fn other_format(bytes: &[u8]) -> Option<&'static str> {
    let known: [(&[u8], &str); 10] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xFF\xD8\xFF", "a JPEG picture"),
        (b"\x76\x2F\x31\x01", "an OpenEXR picture"),
        (b"\x1F\x8B", "gzip: unpack it first"),
        (b"PK\x03\x04", "a ZIP archive: unpack it first"),
        (b"\xFF\xFE", "UTF-16 text: save it as UTF-8"),
        (b"\xFE\xFF", "UTF-16 text: save it as UTF-8"),
        (b"ply", "a PLY mesh, which Shape \"plymesh\" names"),
        (b"<", "XML or HTML"),
        (LFS_POINTER, "a Git LFS pointer: `git lfs pull` fetches the file"),
    ];
    let by_magic = known.iter().find(|(magic, _)| bytes.starts_with(magic)).map(|(_, name)| *name);
    // In UTF-16, every other byte of ASCII text is zero.
    let is_utf16 = |pair: &[u8; 2]| matches!(pair, [0, letter] | [letter, 0] if !matches!(letter, 0 | 128..));
    let (pairs, _) = bytes.as_chunks();
    by_magic.or(match bytes {
        [0, 0, ..] => Some("no text"),
        _ if pairs.len() >= 8 && pairs[..8].iter().all(is_utf16) => Some("UTF-16 text: save it as UTF-8"),
        _ => None,
    })
}
