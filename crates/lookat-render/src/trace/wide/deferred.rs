//! The nearest hits of many rays, where triangles that `f32` is sure of are decided in `f64` at the end, eight side by side.

use fearless_simd::Simd;

use super::pairs::Pairs;
use super::{MOST_RAYS, Traced};
use crate::number::{prefetch, set_lanes};
use crate::ray::{Hit, Ray};
use crate::trace::nothing;
use crate::trace::rays::HitColumns;
use crate::traceable::{Group, Traceable};

/// The nearest hits of rays, some of which are not decided yet.
///
/// One triangle that a ray certainly hits is deferred, with bounds of its depth. Another one replaces it if it is certainly nearer, is
/// dropped if it is certainly farther, and else is decided at once, like all that is uncertain.
pub(super) struct DeferredHits {
    /// The nearest of the hits that are decided, of rays that have one.
    decided: [Hit; MOST_RAYS],
    /// The index of the triangle that is deferred, of rays that have one.
    deferred: [u32; MOST_RAYS],
    /// Its least and its greatest depth along the longest axis of the ray.
    least: [f32; MOST_RAYS],
    most: [f32; MOST_RAYS],
    /// Bits of the rays that have a hit that is decided, and of those that have one that is deferred.
    has_decided: u64,
    has_deferred: u64,
}

impl DeferredHits {
    pub fn new() -> Self {
        let hit = nothing(&Ray::new(Default::default(), Default::default()));
        DeferredHits {
            decided: [hit; MOST_RAYS],
            deferred: [0; MOST_RAYS],
            least: [0.0; MOST_RAYS],
            most: [0.0; MOST_RAYS],
            has_decided: 0,
            has_deferred: 0,
        }
    }

    pub fn clear(&mut self) {
        (self.has_decided, self.has_deferred) = (0, 0);
    }

    /// True if a triangle at depths from the first to the second is certainly nearer than the one that is deferred.
    #[inline(always)]
    pub fn replaces(&self, ray: usize, [_, most]: [f32; 2]) -> bool {
        self.has_deferred >> ray & 1 == 0 || most < self.least[ray]
    }

    /// True if a triangle at such depths is certainly farther than the one that is deferred.
    #[inline(always)]
    pub fn is_beyond(&self, ray: usize, [least, _]: [f32; 2]) -> bool {
        least > self.most[ray]
    }

    /// Defers a triangle that a ray certainly hits, instead of the one before.
    #[inline(always)]
    pub fn defer(&mut self, group: &Group, ray: usize, place: u32, [least, most]: [f32; 2]) {
        self.has_deferred |= 1 << ray;
        (self.deferred[ray], self.least[ray], self.most[ray]) = (place, least, most);
        prefetch(group.triangle(place), 0..2);
    }

    /// Replaces the nearest hit that is decided.
    #[inline(always)]
    pub fn decide(&mut self, ray: usize, hit: &Hit) {
        self.has_decided |= 1 << ray;
        self.decided[ray] = *hit;
    }

    /// Decides the hits that are deferred.
    #[inline(always)]
    pub fn finish<S: Simd>(&mut self, traced: &Traced<S>) {
        let mut rest = std::mem::take(&mut self.has_deferred);
        while rest != 0 {
            let (mut pairs, mut is_full) = (Pairs::none(0), false);
            while rest != 0 && !is_full {
                let ray = rest.trailing_zeros() as usize % MOST_RAYS;
                rest &= rest - 1;
                is_full = pairs.push(ray, self.deferred[ray]);
            }
            let found = pairs.intersect(traced);
            for lane in set_lanes(found.met) {
                let (ray, _) = pairs.pair(lane);
                self.replace(ray, traced.rays.t_max[ray], &pairs.hit(traced, &found, lane));
            }
        }
    }

    /// Records a hit if it replaces the nearest one that is decided, or, if there is none, lies within `t_max`. True if it does.
    #[inline(always)]
    pub fn replace(&mut self, ray: usize, t_max: f64, hit: &Hit) -> bool {
        let is_nearer = match self.has_decided >> ray & 1 {
            1 => self.decided[ray].yields_to(hit.t, hit.element),
            _ => hit.t <= t_max,
        };
        if is_nearer {
            self.decide(ray, hit);
        }
        is_nearer
    }

    /// The nearest of the hits of a ray that are decided.
    #[inline(always)]
    pub fn nearest(&self, ray: usize) -> Option<&Hit> {
        (self.has_decided >> ray & 1 == 1).then_some(&self.decided[ray])
    }

    /// Writes the hits, once all are decided.
    #[inline(always)]
    pub fn write(&self, scene: &Traceable, hits: &mut HitColumns) {
        let mut rest = self.has_decided;
        while rest != 0 {
            let ray = rest.trailing_zeros() as usize % MOST_RAYS;
            rest &= rest - 1;
            let hit = &self.decided[ray];
            hits.set(ray, hit, scene.labels, scene.emits(hit));
        }
    }
}
