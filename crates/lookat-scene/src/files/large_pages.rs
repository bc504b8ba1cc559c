//! Memory in large pages, where the system has them. Filling a large array takes several times as long in small ones.

use std::io;

use lookat_image::Charge;
use memmap2::MmapMut;

/// The bytes of an array that is worth it.
const LEAST: usize = 4 << 20;

/// An array of bytes.
pub struct LargePages(MmapMut);

impl LargePages {
    /// `None` for a small array, and without room.
    pub fn new(length: usize, charge: &mut Charge) -> Option<LargePages> {
        if length < LEAST || charge.resize(length as u64).is_err() {
            return None;
        }
        let pages = MmapMut::map_anon(length).ok()?;
        #[cfg(target_os = "linux")]
        pages.advise(memmap2::Advice::HugePage).ok()?;
        Some(LargePages(pages))
    }

    /// Reads a file until it ends or the array is full. Returns the number of bytes.
    pub fn fill(&mut self, file: &mut dyn io::Read) -> io::Result<usize> {
        let mut length = 0;
        while length < self.0.len() {
            match file.read(&mut self.0[length..]) {
                Ok(0) => break,
                Ok(read) => length += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(length)
    }
}

impl AsRef<[u8]> for LargePages {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}
