//! Pairs of a ray and something that it may hit: their tests wait until there are eight.

use fearless_simd::{Simd, mask64x8};

use super::MOST_RAYS;
use crate::number::{LANES, Vec3x8, first_lanes};
use crate::trace::rays::RayColumns;

/// At most eight pairs of a ray and something else.
#[derive(Clone, Copy)]
pub(super) struct Pairs<T> {
    rays: [u8; LANES],
    others: [T; LANES],
    count: usize,
}

impl<T: Copy> Pairs<T> {
    /// No pairs. `zero`: anything.
    pub const fn none(zero: T) -> Self {
        Pairs { rays: [0; LANES], others: [zero; LANES], count: 0 }
    }

    /// Adds a pair. True if there is room for no other.
    #[inline(always)]
    pub fn push(&mut self, ray: usize, other: T) -> bool {
        let at = self.count % LANES;
        (self.rays[at], self.others[at], self.count) = (ray as u8, other, at + 1);
        self.count == LANES
    }

    /// Takes all pairs.
    #[inline(always)]
    pub fn take(&mut self) -> Self {
        let all = *self;
        self.count = 0;
        all
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.count
    }

    /// A ray and what it may hit.
    #[inline(always)]
    pub fn pair(&self, lane: usize) -> (usize, T) {
        (usize::from(self.rays[lane]) % MOST_RAYS, self.others[lane])
    }

    /// What the rays may hit.
    #[inline(always)]
    pub fn others(&self) -> impl Iterator<Item = T> {
        self.others.into_iter().take(self.count)
    }

    /// The lanes that have a pair.
    #[inline(always)]
    pub fn lanes<S: Simd>(&self, simd: S) -> mask64x8<S> {
        first_lanes(simd, self.count)
    }

    /// The origins of the rays, and their directions.
    #[inline(always)]
    pub fn lines<S: Simd>(&self, simd: S, rays: &RayColumns) -> [Vec3x8<S>; 2] {
        let mut lines = [[[1.0; LANES]; 3]; 2];
        for (lane, ray) in self.rays.iter().enumerate().take(self.count) {
            for (line, v) in lines.iter_mut().zip(rays.line(usize::from(*ray))) {
                [line[0][lane], line[1][lane], line[2][lane]] = v.into();
            }
        }
        [Vec3x8::from_arrays(simd, &lines[0]), Vec3x8::from_arrays(simd, &lines[1])]
    }
}
