//! What searches need of rays, made for eight of them at once.

use fearless_simd::{Simd, mask64x8};

use crate::bvh::ManySlabs;
use crate::trace::lanes::Rays;
use crate::triangle::lanes::{ManyFilters, ManySheared, ShearedRays};

/// Rays as they are tested against boxes and triangles; as they would be made one by one, to the bit.
pub(crate) struct Forms {
    pub slabs: ManySlabs,
    pub sheared: ManySheared,
    pub filters: ManyFilters,
}

/// One of them.
#[derive(Clone, Copy)]
pub(crate) struct Form<'f> {
    pub of: &'f Forms,
    pub lane: usize,
}

impl Forms {
    pub fn new() -> Self {
        Forms { slabs: ManySlabs::NOTHING, sheared: ManySheared::NOTHING, filters: ManyFilters::NOTHING }
    }

    /// Those of other rays, as far as they are active.
    #[inline(always)]
    pub fn put<S: Simd>(&mut self, simd: S, rays: &Rays<S>, active: mask64x8<S>) {
        let sheared = ShearedRays::new(rays.o, rays.d, active);
        self.slabs.put(simd, rays.o, sheared.inverse());
        self.sheared.put(&sheared);
        self.filters.put(&sheared);
    }
}
