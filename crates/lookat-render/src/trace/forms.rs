//! What searches need of rays, made for eight of them at once.

use fearless_simd::{Simd, mask64x8};

#[cfg(target_arch = "x86_64")]
use super::search_with;
use super::{Query, RayForms, nothing};
use crate::arithmetic::SimdKind;
use crate::bvh::ManySlabs;
#[cfg(target_arch = "x86_64")]
use crate::bvh::WideSlabs;
use crate::ray::{Hit, Ray};
use crate::trace::lanes::Rays;
use crate::traceable::Traceable;
#[cfg(target_arch = "x86_64")]
use crate::triangle::block::avx2::WideFilter;
use crate::triangle::lanes::{ManyFilters, ManySheared, ShearedRays};

/// Rays as they are tested against boxes and triangles; as they would be made one by one, to the bit.
pub(crate) struct Forms {
    slabs: ManySlabs,
    sheared: ManySheared,
    filters: ManyFilters,
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

impl Traceable {
    /// As [`Traceable::find`], in `f32` and `f64`.
    pub(crate) fn find_formed(&self, ray: &Ray, form: Form, found: &mut Option<Hit>) {
        let hit = found.insert(nothing(ray));
        if !self.search_formed::<false>(&self.query(ray, false), form, hit) {
            *found = None;
        }
    }

    /// As [`Traceable::occluded`], likewise; `is_shadow` of shadow rays, which pass other holes.
    pub(crate) fn occluded_formed(&self, ray: &Ray, form: Form, is_shadow: bool) -> bool {
        self.search_formed::<true>(&self.query(ray, is_shadow), form, &mut nothing(ray))
    }

    fn search_formed<const ANY: bool>(&self, query: &Query, form: Form, hit: &mut Hit) -> bool {
        match self.simd.kind() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` says what the processor has.
            #[allow(unsafe_code)]
            SimdKind::Avx512 => unsafe { self.search_formed_avx512::<ANY>(query, form, hit) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            #[allow(unsafe_code)]
            SimdKind::Avx2 => unsafe { self.search_formed_avx2::<ANY>(query, form, hit) },
            SimdKind::Portable => {
                let _ = form;
                self.search_wide::<ANY>(query, hit)
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn search_formed_avx2<const ANY: bool>(&self, query: &Query, form: Form, hit: &mut Hit) -> bool {
        let slabs = WideSlabs::of(&form.of.slabs, form.lane);
        let filter = WideFilter::of(&form.of.filters, form.of.sheared.axes(form.lane), form.lane);
        let ray = &form.forms(query.ray, filter);
        search_with!(self.search_by::<ANY>(query, hit, ray, slabs))
    }

    /// The same, with the registers of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,avx512f,avx512vl,bmi1,bmi2")]
    fn search_formed_avx512<const ANY: bool>(&self, query: &Query, form: Form, hit: &mut Hit) -> bool {
        let slabs = WideSlabs::of(&form.of.slabs, form.lane);
        let filter = WideFilter::of(&form.of.filters, form.of.sheared.axes(form.lane), form.lane);
        let ray = &form.forms(query.ray, filter);
        search_with!(self.search_by::<ANY>(query, hit, ray, slabs))
    }
}

impl Form<'_> {
    #[inline(always)]
    fn forms<F>(&self, ray: &Ray, filter: F) -> RayForms<F> {
        RayForms { filter, sheared: self.of.sheared.lane(ray.o, self.lane) }
    }
}
