//! Memory in large pages, where the system has them. Filling a large array takes several times as long in small ones.

use memmap2::MmapMut;

/// The smallest array in large pages, in bytes.
const LEAST: usize = 4 << 20;

/// An array of zeros.
pub struct LargePages(MmapMut);

impl LargePages {
    /// `None` for a small array, and where the system refuses or cannot be asked for large pages.
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
