//! The contents of files, and the formats of files that are not scenes.

use std::io::{self, Read as _};
use std::ops::Deref;
use std::path::Path;

use bytes::Bytes;
use lookat_image::{Charge, MemoryBudget};
use memmap2::MmapMut;

/// A function that reads a whole file. Tests need no disk, and programs decide the meaning of `-`.
pub type Read<'a> = dyn Fn(&Path) -> io::Result<Vec<u8>> + 'a;

/// A function that opens a file for streaming.
pub type Open<'a> = dyn Fn(&Path) -> io::Result<Box<dyn io::Read>> + 'a;

/// The way to access files.
#[derive(Clone, Copy)]
pub(crate) enum Access<'a> {
    Read(&'a Read<'a>),
    Open(&'a Open<'a>),
}

/// The contents of a file.
pub(crate) enum Content {
    Whole(Vec<u8>),
    Stream(Box<dyn io::Read>),
}

impl Content {
    /// The whole contents, if `memory` has room.
    pub fn bytes(self, memory: &MemoryBudget) -> io::Result<Charged> {
        self.bytes_after(0, memory)
    }

    /// The whole contents of a file that had `before` bytes when it was read last.
    pub fn bytes_after(self, before: usize, memory: &MemoryBudget) -> io::Result<Charged> {
        let mut charge = memory.reserve(0).map_err(io::Error::other)?;
        let bytes = match self {
            Content::Whole(bytes) => bytes.into(),
            Content::Stream(file) => read_all(file, before, &mut charge)?,
        };
        charge.resize(bytes.len() as u64).map_err(io::Error::other)?;
        Ok(Charged { bytes, charge })
    }

    /// A stream from the start.
    pub fn stream(self) -> Box<dyn io::Read> {
        match self {
            Content::Whole(bytes) => Box::new(io::Cursor::new(bytes)),
            Content::Stream(file) => file,
        }
    }
}

/// Reads a file in steps, each an eighth of the bytes so far, so that the array is never much larger than the file. `before`: the bytes
/// that it had before.
fn read_all(mut file: Box<dyn io::Read>, before: usize, charge: &mut Charge) -> io::Result<Bytes> {
    let mut bytes = Vec::new();
    // Enough to see the end of a file that has grown by a step.
    if let Some(mut pages) = LargePages::new(before + 2 * step(before)) {
        let mut length = 0;
        while let Some(part) = pages.part(length, step(length)) {
            charge.resize((length + part.len()) as u64).map_err(io::Error::other)?;
            let read = fill(part, &mut file)?;
            length += read;
            if read < part.len() {
                return Ok(Bytes::from_owner(pages).slice(..length));
            }
        }
        // For a moment, they are there twice.
        bytes.try_reserve_exact(length)?;
        bytes.extend_from_slice(&pages.as_ref()[..length]);
    }
    loop {
        let step = step(bytes.len());
        charge.resize((bytes.len() + step) as u64).map_err(io::Error::other)?;
        bytes.try_reserve_exact(step)?;
        if file.by_ref().take(step as u64).read_to_end(&mut bytes)? < step {
            bytes.shrink_to_fit();
            return Ok(bytes.into());
        }
    }
}

/// Reads until the file ends or the array is full. Returns the number of bytes.
fn fill(array: &mut [u8], file: &mut dyn io::Read) -> io::Result<usize> {
    let mut length = 0;
    while length < array.len() {
        match file.read(&mut array[length..]) {
            Ok(0) => break,
            Ok(read) => length += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(length)
}

/// The most bytes that are read at once after so many.
fn step(bytes: usize) -> usize {
    (bytes / 8).max(1 << 16)
}

/// The bytes of a file, charged until they are dropped.
pub(crate) struct Charged {
    bytes: Bytes,
    charge: Charge,
}

impl Charged {
    /// A text that is in memory already. `None` without room to read it, so that reading it tells the error.
    pub fn known(bytes: Bytes, memory: &MemoryBudget) -> Option<Charged> {
        let mut charge = memory.reserve((bytes.len() + step(bytes.len())) as u64).ok()?;
        charge.resize(bytes.len() as u64).ok()?;
        Some(Charged { bytes, charge })
    }

    /// Charges them for good.
    pub fn keep(self) -> Bytes {
        self.charge.keep();
        self.bytes
    }
}

impl Deref for Charged {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Access<'_> {
    pub fn content(self, path: &Path) -> io::Result<Content> {
        match self {
            Access::Read(read) => read(path).map(Content::Whole),
            Access::Open(open) => open(path).map(Content::Stream),
        }
    }
}

/// The smallest array in large pages, in bytes.
const LEAST: usize = 4 << 20;

/// An array of zeros.
pub struct LargePages(MmapMut);

impl LargePages {
    /// `None` for a small array, and where the system has no large pages.
    pub fn new(length: usize) -> Option<LargePages> {
        if length < LEAST || !cfg!(target_os = "linux") {
            return None;
        }
        let pages = MmapMut::map_anon(length).ok()?;
        #[cfg(target_os = "linux")]
        pages.advise(memmap2::Advice::HugePage).ok()?;
        Some(LargePages(pages))
    }

    /// A part of the array. `None` if it goes beyond the end.
    pub fn part(&mut self, start: usize, length: usize) -> Option<&mut [u8]> {
        self.0.get_mut(start..start + length)
    }
}

impl AsRef<[u8]> for LargePages {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

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
