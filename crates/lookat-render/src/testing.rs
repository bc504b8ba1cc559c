//! What the tests of several files share.

use std::path::Path;

use fearless_simd::{Simd, prelude::*};
use glam::DVec3;
use lookat_scene::{LoadOptions, Scene, load};

use crate::lanes::Vec3x8;
use crate::surface::lanes::Surfaces;
use crate::trace::lanes::{NONE, WORLD};

/// A number without a pattern, from -1 to 1.
pub(crate) fn noise(i: usize, k: f64) -> f64 {
    ((i as f64 * k).sin() * 1e4).fract()
}

/// The scene of a text without mistakes.
pub(crate) fn scene(text: &str) -> Scene {
    let loaded = load(Path::new("test.pbrt"), &|_| Ok(text.to_owned().into()), &LoadOptions::default());
    loaded.scene.unwrap_or_else(|| panic!("{:?} {text}", loaded.diagnostics))
}

/// Points that all lie at one place, on a plane across z.
pub(crate) fn surfaces_at<S: Simd>(simd: S, p: DVec3) -> Surfaces<S> {
    let n = Vec3x8::splat(simd, DVec3::Z);
    let (element, instance) = (NONE.simd_into(simd), WORLD.simd_into(simd));
    Surfaces { p: Vec3x8::splat(simd, p), n, ns: n, magnitude: 0.0.simd_into(simd), element, instance }
}

/// Does something with the instructions that all processors of a kind have.
macro_rules! baseline {
    ($simd:ident => $does:expr) => {{
        let level = fearless_simd::Level::new();
        #[cfg(target_arch = "x86_64")]
        let $simd = level.as_sse2().expect("every x86-64 processor has SSE2");
        #[cfg(target_arch = "aarch64")]
        let $simd = level.as_neon().expect("every AArch64 processor has NEON");
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let $simd = level.as_fallback().expect("every processor can do without");
        $does
    }};
}
pub(crate) use baseline;
