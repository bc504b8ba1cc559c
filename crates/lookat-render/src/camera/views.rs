//! Where camera rays come from.

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec2;

use super::CameraRays;
use crate::number::{LANES, Vec3x8};

/// What sends camera rays.
#[derive(Clone, Copy)]
pub(crate) struct Viewer<'v> {
    pub camera: &'v CameraRays,
    /// From one sample to the next, in pixels.
    pub spacing: f64,
}

/// Where camera rays of samples come from.
#[derive(Clone, Copy)]
pub(crate) struct Views<'v> {
    pub of: Viewer<'v>,
    /// Of each sample its place on the film, and what chooses the point on the lens.
    pub places: &'v [(DVec2, DVec2)],
    /// Which of the samples are side by side.
    pub samples: &'v [u16],
    /// Those of them whose rays have not passed anything, as bits.
    pub direct: u64,
}

impl Views<'_> {
    /// Origins and directions, of any length, of the neighbors of the rays to the right and below, through the same points of the lens.
    #[inline(always)]
    pub fn neighbors<S: Simd>(&self, simd: S) -> [(Vec3x8<S>, Vec3x8<S>); 2] {
        let mut places = [[0.0; LANES]; 4];
        for (lane, sample) in self.samples.iter().enumerate() {
            let (film, on_lens) = self.places[usize::from(*sample)];
            for (own, place) in places.iter_mut().zip([film.x, film.y, on_lens.x, on_lens.y]) {
                own[lane] = place;
            }
        }
        let [x, y, u, v]: [f64x8<S>; 4] = places.map(
            #[inline(always)]
            |places| places.simd_into(simd),
        );
        let Viewer { camera, spacing } = self.of;
        let lines = |film| camera.lines(simd, film, Some([u, v]));
        [lines([x + spacing, y]), lines([x, y + spacing])]
    }
}
