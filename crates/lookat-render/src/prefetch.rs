//! Memory that is asked for before it is needed.

use std::ops::Range;

/// What processors load at once, in bytes.
const LINE: usize = 64;

/// Asks for some lines of memory, counted from a place, which may be anywhere.
#[inline(always)]
pub(crate) fn prefetch<T>(at: *const T, lines: Range<usize>) {
    #[cfg(target_arch = "x86_64")]
    for line in lines {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every such processor has it, and it does nothing wherever it points.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(at.cast::<i8>().wrapping_add(LINE * line));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (at, lines, LINE);
}
