//! Rays that wait at instances traverse the objects of these together.

use fearless_simd::Simd;

use super::{MOST_RAYS, Traced, WideTracer};
use crate::number::vectorized;
use crate::ray::ElementId;
use crate::trace::rays::{OneRay, RayColumns};
use crate::traceable::NonTriangle;

/// A ray that waits at an instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtInstance {
    ray: u8,
    instance: u32,
    /// The object that the instance places.
    object: u32,
}

/// Fewer rays in one object are traced one by one.
const FEW: usize = 4;

impl WideTracer {
    /// Makes a ray wait if it has met an instance of an object that is not a single shape. True if it waits.
    #[inline(always)]
    pub(super) fn waits_at<S: Simd>(&mut self, traced: &Traced<S>, ray: usize, other: NonTriangle) -> bool {
        let NonTriangle::Instance { instance, object } = other else { return false };
        let waits = traced.scene.objects[object as usize].single_shape().is_none();
        if waits {
            self.at_instances.push(AtInstance { ray: ray as u8, instance, object });
        }
        waits
    }

    /// Traces the rays that wait in their instances, but those that are `done`. Returns those that hit anything, if `ANY` hit will do.
    #[inline(never)]
    pub(super) fn trace_in_instances<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        done: u64,
    ) -> u64 {
        let mut inner = self.inner.take().unwrap_or_else(|| Box::new((WideTracer::new(), RayColumns::new())));
        let mut all = std::mem::take(&mut self.at_instances);
        all.retain(|one| done >> one.ray & 1 == 0);
        all.sort_unstable_by_key(|one| one.object);
        let mut met = 0;
        for same in all.chunk_by(|a, b| a.object == b.object) {
            if same.len() < FEW {
                met |= same.iter().fold(0, |met, one| met | self.trace_alone::<S, ANY>(traced, one));
            } else {
                met |= self.trace_together::<S, ANY>(traced, same, &mut inner);
            }
        }
        self.inner = Some(inner);
        met
    }

    /// Traces a ray in its instance. Returns its bit if it has a hit.
    fn trace_alone<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        &AtInstance { ray, instance, object }: &AtInstance,
    ) -> u64 {
        let other = NonTriangle::Instance { instance, object };
        u64::from(self.test_non_triangle::<S, ANY>(traced, usize::from(ray), other) && ANY) << ray
    }

    /// Traces rays in instances of the same object. Returns those that hit anything, if `ANY` hit will do.
    #[inline(never)]
    fn trace_together<S: Simd, const ANY: bool>(
        &mut self,
        traced: &Traced<S>,
        same: &[AtInstance],
        (inner, rays): &mut (WideTracer, RayColumns),
    ) -> u64 {
        let Traced { simd, scene, rays: outer, is_shadow, .. } = *traced;
        vectorized!(simd, {
            let mut instances = [ElementId::WORLD; MOST_RAYS];
            for (at, AtInstance { ray, instance, .. }) in same.iter().enumerate() {
                let ray = usize::from(*ray);
                let OneRay { o, d, time, .. } = outer.one(ray);
                let placed = scene.placed(*instance, time);
                // Hits beyond one that is deferred do not count either.
                let t_max = self.end(traced, ray).min(f64::from(self.limit[ray]));
                let (o, d) = (placed.to_object(o), placed.vector_to_object(d));
                rays.set(at, &OneRay { o, d, t_max, ..outer.one(ray) });
                instances[at] = *instance;
            }
            let group = &scene.objects[same[0].object as usize];
            let own = Traced { simd, scene, group, rays, instances: &instances, is_shadow };
            let active = u64::MAX >> (MOST_RAYS - same.len());
            let (mut met, rest) = inner.trace_group::<S, ANY>(&own, active);
            met = (0..same.len()).fold(0, |all, at| all | (met >> at & 1) << same[at].ray);
            for (at, one) in same.iter().enumerate() {
                if rest >> at & 1 == 1 {
                    met |= self.trace_alone::<S, ANY>(traced, one);
                } else if let Some(hit) = inner.hits.nearest(at).filter(|_| !ANY) {
                    let ray = usize::from(one.ray);
                    if self.hits.replace(ray, outer.t_max[ray], hit) {
                        self.record::<ANY>(ray, hit);
                    }
                }
            }
            met
        })
    }
}
