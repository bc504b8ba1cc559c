//! What intersections are computed with.

use std::sync::LazyLock;

use fearless_simd::Level;

/// What the processor offers. Whoever has one may call the functions that ask for that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Simd {
    /// Private: it must be true.
    kind: SimdKind,
}

/// Instructions that compute eight numbers at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SimdKind {
    /// None that are asked for by name.
    Portable,
    /// AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// These, with the registers of AVX-512.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self.kind {
            SimdKind::Portable if cfg!(target_arch = "x86_64") => "SSE2",
            SimdKind::Portable if cfg!(target_arch = "aarch64") => "NEON",
            SimdKind::Portable => "none",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx512 => "AVX-512",
        }
    }

    /// The best that this processor has. Asked for often, so that it is looked for once.
    pub fn best() -> Self {
        static BEST: LazyLock<Simd> = LazyLock::new(|| Simd::of(Level::new()));
        *BEST
    }

    /// That of a level.
    pub fn of(level: Level) -> Self {
        let kind = match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(_) => SimdKind::Avx512,
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(_) => SimdKind::Avx2,
            _ => SimdKind::Portable,
        };
        Simd { kind }
    }

    pub fn kind(self) -> SimdKind {
        self.kind
    }
}
