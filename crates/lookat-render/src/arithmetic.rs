//! What intersections are computed with.

use std::sync::LazyLock;

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
            SimdKind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            SimdKind::Avx512 => "AVX-512",
        }
    }

    /// The best that this processor has. Asked for often, so that it is looked for once.
    pub fn best() -> Self {
        static BEST: LazyLock<Simd> = LazyLock::new(Simd::detect);
        *BEST
    }

    fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            let more = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2");
            return Simd { kind: if more { SimdKind::Avx512 } else { SimdKind::Avx2 } };
        }
        Simd { kind: SimdKind::Portable }
    }

    pub fn kind(self) -> SimdKind {
        self.kind
    }
}
