//! What the tests of several files share.

use std::path::Path;

use fearless_simd::{Level, Simd, prelude::*};
use glam::DVec3;
use lookat_scene::{LoadOptions, Scene, load};

use crate::number::Vec3x8;
pub(crate) use crate::number::baseline;
use crate::ray::ElementId;
use crate::surface::Surfaces;
use crate::trace::rays::NONE;

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
    let (element, instance) = (NONE.simd_into(simd), ElementId::WORLD.simd_into(simd));
    let (p, magnitude) = (Vec3x8::splat(simd, p), 0.0.simd_into(simd));
    Surfaces { p, n: n.narrow(), ns: n, magnitude, element, instance, time: 0.0.simd_into(simd) }
}

/// This processor's instructions, and those of older ones.
pub(crate) fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let older = [best.as_avx2().map(Level::Avx2), best.as_sse2().map(Level::Sse2)];
    #[cfg(not(target_arch = "x86_64"))]
    let older: [Option<Level>; 0] = [];
    [best].into_iter().chain(older.into_iter().flatten()).collect()
}

/// The number of cases of a property test: that in the environment variable LOOKAT_CASES, or else `usual`.
pub(crate) fn cases(usual: usize) -> usize {
    std::env::var("LOOKAT_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(usual)
}
