//! Parts of a rendering.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// One of several equal parts of the samples of each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// From 0 to one less than `of`.
    pub index: u32,
    /// The number of parts: at least 1.
    pub of: u32,
}

impl Part {
    /// The indices of its samples, of so many. Parts differ by one sample at most; with more parts than samples, some are empty.
    pub fn range(self, samples: u32) -> Range<u32> {
        let start = |index: u32| {
            (u64::from(index.min(self.of)) * u64::from(samples) / u64::from(self.of.max(1))) as u32
        };
        start(self.index)..start(self.index.saturating_add(1))
    }
}
