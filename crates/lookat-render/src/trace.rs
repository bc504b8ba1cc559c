//! Rays against a scene: the nearest hit, and whether anything is in the way.

mod bundle;
mod forms;
pub(crate) mod lanes;
#[cfg(test)]
mod tests;

use std::array::from_fn;

pub(crate) use bundle::BUNDLE;
use bundle::{MOST_LEAVES, OTHER};
pub(crate) use forms::{Form, Forms};

use crate::arithmetic::SimdKind;
#[cfg(test)]
use crate::bvh::DoubleSlabs;
#[cfg(target_arch = "x86_64")]
use crate::bvh::WideSlabs;
use crate::bvh::{Leaf, Node, Slabs, WIDTH};
use crate::cutout;
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Group, Other, Traceable};
#[cfg(target_arch = "x86_64")]
use crate::triangle::block::avx2::{WideFilter, filter_ray};
use crate::triangle::block::{Block, FilterRay, of_place, place};
use crate::triangle::{ShearedRay, Triangle, holds_end};

/// A ray among the elements of a group, which belong to an instance or to the world.
#[derive(Clone, Copy)]
struct Query<'q> {
    group: &'q Group,
    ray: &'q Ray,
    instance: u32,
    /// The place of the triangle that the ray leaves, if it is of this group: what is flat is not met again.
    leaving: u32,
    /// Whether holes are those that shadow rays pass.
    is_shadow: bool,
}

impl<'q> Query<'q> {
    #[inline(always)]
    fn new(group: &'q Group, ray: &'q Ray, instance: u32, is_shadow: bool) -> Self {
        let leaving = if ray.leaving.instance == instance { ray.leaving_place } else { Hit::NO_PLACE };
        Query { group, ray, instance, leaving, is_shadow }
    }

    /// The bit of the triangle that the ray leaves, if it is in the block of a number.
    #[inline(always)]
    fn leaving_of(&self, number: usize) -> u32 {
        let (block, lane) = of_place(self.leaving);
        u32::from(block == number) << lane
    }
}

/// What came of a search.
struct Search {
    /// Whether there is a hit that was not there before.
    found: bool,
    /// Whether no nearer hit can be left.
    is_complete: bool,
}

/// [`Traceable::search_by`] with the tests that `WideSlabs` and `WideFilter` have. A macro, since closures are compiled for the
/// instructions of the function that they are in.
#[cfg(target_arch = "x86_64")]
macro_rules! search_with {
    ($self:ident.search_by::<$any:ident, $n:tt>($queries:ident, $hits:ident, $rays:expr, $slabs:ident)) => {{
        let boxes = |node: &$crate::bvh::Node, t_max| $slabs.meet(node, t_max);
        let filter =
            |ray: &WideFilter, block: &$crate::triangle::block::Block, t_max| ray.may_meet(block, t_max);
        let surely =
            |ray: &WideFilter, block: &$crate::triangle::block::Block, t_max| ray.surely_meets(block, t_max);
        $self.search_by::<$any, $n, _>($queries, $hits, $rays, boxes, filter, surely)
    }};
}
#[cfg(target_arch = "x86_64")]
use search_with;

impl Traceable {
    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut found = None;
        self.find(ray, &mut found);
        found
    }

    /// The same, put where it is to be.
    pub(crate) fn find(&self, ray: &Ray, found: &mut Option<Hit>) {
        let hit = found.insert(nothing(ray));
        if !self.search::<false>(self.query(ray, false), hit) {
            *found = None;
        }
    }

    /// Whether anything but its target is in the way of a shadow ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.search::<true>(self.query(ray, true), &mut nothing(ray))
    }

    /// Whether a ray meets anything at all.
    pub fn meets(&self, ray: &Ray) -> bool {
        self.search::<true>(self.query(ray, false), &mut nothing(ray))
    }

    /// The nearest hit, found without trees.
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = nothing(ray);
        self.search_all(self.query(ray, false), &mut hit).then_some(hit)
    }

    fn query<'q>(&'q self, ray: &'q Ray, is_shadow: bool) -> Query<'q> {
        Query::new(&self.world, ray, ElementId::WORLD, is_shadow)
    }

    /// Looks for hits that `hit` yields to. With `ANY` the first will do; the target of the ray is left out.
    fn search<const ANY: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let (queries, hits) = (&[query], std::array::from_mut(hit));
        #[cfg(test)]
        if self.is_double {
            return self.search_double::<ANY>(queries, hits).found;
        }
        self.search_wide::<ANY, 1>(queries, hits).found
    }

    /// By tests in `f32` that leave out what is not met. What is left is decided about in `f64`. Several rays are of one group, and
    /// run the same way along each axis.
    fn search_wide<const ANY: bool, const N: usize>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
    ) -> Search {
        match self.simd.kind() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` says what the processor has.
            #[allow(unsafe_code)]
            SimdKind::Avx512 => unsafe { self.search_avx512::<ANY, N>(queries, hits) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            #[allow(unsafe_code)]
            SimdKind::Avx2 => unsafe { self.search_avx2::<ANY, N>(queries, hits) },
            SimdKind::Portable => self.search_portable::<ANY, N>(queries, hits),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn search_avx2<const ANY: bool, const N: usize>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
    ) -> Search {
        let slabs = WideSlabs::new(&slabs(queries));
        let rays = from_fn(|k| RayForms::new(queries[k].ray, |ray, sheared| filter_ray(ray, sheared)));
        search_with!(self.search_by::<ANY, N>(queries, hits, &rays, slabs))
    }

    /// The same, with the registers of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,avx512f,avx512vl,bmi1,bmi2")]
    fn search_avx512<const ANY: bool, const N: usize>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
    ) -> Search {
        let slabs = WideSlabs::new(&slabs(queries));
        let rays = from_fn(|k| RayForms::new(queries[k].ray, |ray, sheared| filter_ray(ray, sheared)));
        search_with!(self.search_by::<ANY, N>(queries, hits, &rays, slabs))
    }

    fn search_portable<const ANY: bool, const N: usize>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
    ) -> Search {
        let slabs = slabs(queries);
        let rays =
            from_fn(|k| RayForms::new(queries[k].ray, |ray, sheared| FilterRay::new(ray, sheared, |x| x)));
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |ray: &FilterRay<f32>, block: &Block, t_max| ray.may_meet(block, t_max);
        let surely = |ray: &FilterRay<f32>, block: &Block, t_max| ray.surely_meets(block, t_max);
        self.search_by::<ANY, N, _>(queries, hits, &rays, boxes, filter, surely)
    }

    /// By the forms of each ray: which boxes of a node any of them may meet, and which triangles of a block one of them.
    #[inline(always)]
    fn search_by<const ANY: bool, const N: usize, F>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
        rays: &[RayForms<F>; N],
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        filter: impl Fn(&F, &Block, f64) -> u32,
        surely: impl Fn(&F, &Block, f64) -> u32,
    ) -> Search {
        let filter = |k: usize, block: &Block, t_max| filter(&rays[k].filter, block, t_max);
        let surely = |k: usize, block: &Block, t_max| surely(&rays[k].filter, block, t_max);
        let decide = |k: usize, triangle: &Triangle| rays[k].sheared.intersect(&triangle.corners);
        self.search_with::<ANY, N>(queries, hits, boxes, filter, surely, decide)
    }

    /// All in `f64`.
    #[cfg(test)]
    fn search_double<const ANY: bool>(&self, queries: &[Query; 1], hits: &mut [Hit; 1]) -> Search {
        let ray = queries[0].ray;
        let (sheared, slabs) = (ShearedRay::new(ray), DoubleSlabs::new(ray));
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |_, block: &Block, _| block.all();
        let decide = |_, triangle: &Triangle| sheared.intersect(&triangle.corners);
        self.search_with::<ANY, 1>(queries, hits, boxes, filter, |_, _, _| 0, decide)
    }

    /// `boxes` tells which boxes of a node any of the rays may meet within a limit, as bits, and from which distance on;
    /// `filter`, which triangles of a block the ray of a number may meet within a limit, as bits; `surely`, some of those
    /// that `decide` would tell it meets; and `decide`, where it does meet a triangle, and in proportion to what its corners weigh.
    #[inline(always)]
    fn search_with<const ANY: bool, const N: usize>(
        &self,
        queries: &[Query; N],
        hits: &mut [Hit; N],
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        filter: impl Fn(usize, &Block, f64) -> u32,
        surely: impl Fn(usize, &Block, f64) -> u32,
        decide: impl Fn(usize, &Triangle) -> Option<(f64, [f64; 3])>,
    ) -> Search {
        // Of several rays each goes on until all have their nearest hit.
        const { assert!(N == 1 || !ANY) };
        let group = queries[0].group;
        let (mut found, mut leaves) = (false, 0);
        let limit = farthest(hits);
        let visit = |leaf| {
            leaves += if matches!(leaf, Leaf::Other(_)) { OTHER } else { 1 };
            if N > 1 && leaves > MOST_LEAVES {
                return None;
            }
            // Of what a shadow ray meets, it seldom has to be known where.
            if let (false, Leaf::Block(number)) = (ANY, leaf) {
                group.blocks[number].prefetch_triangles();
            }
            for (k, (query, hit)) in queries.iter().zip(&mut *hits).enumerate() {
                match leaf {
                    Leaf::Block(number) => {
                        let block = &group.blocks[number];
                        let others = !query.leaving_of(number);
                        let mut rest = filter(k, block, hit.t) & others;
                        // The target of a shadow ray never is wholly before its end.
                        if ANY && rest != 0 && !self.has_cutouts && surely(k, block, hit.t) & others != 0 {
                            found = true;
                            return None;
                        }
                        while rest != 0 {
                            let lane = rest.trailing_zeros();
                            let (triangle, place) = (block.triangle(lane), place(number, lane));
                            rest &= rest - 1;
                            // A shadow ray ends at its target, or just before: no need to decide which.
                            if ANY && triangle.element(query.instance) == query.ray.target {
                                continue;
                            }
                            let met = decide(k, triangle)
                                .and_then(|met| triangle_hit(*query, triangle, place, met))
                                .filter(|met| !ANY || !is_end(query.ray, triangle, met.t));
                            found |= met.is_some_and(|met| self.accept::<ANY>(*query, met, hit));
                        }
                    }
                    Leaf::Other(other) => found |= self.meet_other::<ANY>(*query, group.others[other], hit),
                }
            }
            (!ANY || !found).then(|| farthest(hits))
        };
        let prefetch = |leaf| {
            if let Leaf::Block(number) = leaf {
                group.blocks[number].prefetch_filter();
            }
        };
        group.bvh.traverse::<ANY>(limit, boxes, visit, prefetch);
        Search { found, is_complete: N == 1 || leaves <= MOST_LEAVES }
    }

    /// All elements, one after the other.
    fn search_all(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let mut found = false;
        for (place, triangle) in query.group.triangles().filter(|(place, _)| *place != query.leaving) {
            let met = sheared
                .intersect(&triangle.corners)
                .and_then(|met| triangle_hit(query, triangle, place, met));
            found |= met.is_some_and(|met| self.accept::<false>(query, met, hit));
        }
        for other in &query.group.others {
            found |= match *other {
                Other::Instance { instance } => {
                    let placed = &self.instances[instance as usize];
                    let (group, ray) = (&self.objects[placed.object], &placed.ray(query.ray, hit.t));
                    self.search_all(Query::new(group, ray, instance, query.is_shadow), hit)
                }
                other => self.meet_other::<false>(query, other, hit),
            };
        }
        found
    }

    /// Out of line: triangles are not to pay for it.
    #[inline(never)]
    fn meet_other<const ANY: bool>(&self, query: Query, other: Other, hit: &mut Hit) -> bool {
        let Query { ray, instance, .. } = query;
        match other {
            Other::Instance { instance } => {
                let placed = &self.instances[instance as usize];
                let (group, ray) = (&self.objects[placed.object], &placed.ray(ray, hit.t));
                let query = Query::new(group, ray, instance, query.is_shadow);
                match group.others[..] {
                    [other] if group.blocks.is_empty() => self.meet_other::<ANY>(query, other, hit),
                    _ => self.search::<ANY>(query, hit),
                }
            }
            Other::Curved { primitive, shape } => {
                let element = ElementId { instance, primitive, index: 0 };
                if ANY && element == ray.target {
                    return false;
                }
                let (shape, leaving) = (&self.curved[shape as usize], element == ray.leaving);
                let t = shape.intersect(ray, hit.t, leaving);
                if ANY && t.is_some_and(|t| ray.may_end_at(t) && shape.is_met_at_end(ray, leaving)) {
                    return false;
                }
                t.is_some_and(|t| {
                    self.accept::<ANY>(
                        query,
                        Hit { t, element, barycentric: [0.0; 2], place: Hit::NO_PLACE },
                        hit,
                    )
                })
            }
            Other::Curve { primitive, piece } => {
                let element = ElementId { instance, primitive, index: piece };
                let same = ElementId { index: ray.leaving.index, ..element } == ray.leaving;
                let leaving = same.then_some(ray.leaving.index);
                let meeting = self.curves.meet(piece, ray, hit.t, leaving);
                meeting.is_some_and(|meeting| {
                    self.accept::<ANY>(
                        query,
                        Hit { t: meeting.t, element, barycentric: meeting.uv.into(), place: Hit::NO_PLACE },
                        hit,
                    )
                })
            }
        }
    }

    /// Puts `found` in the place of `hit`, if it is nearer.
    #[inline(always)]
    fn accept<const ANY: bool>(&self, query: Query, found: Hit, hit: &mut Hit) -> bool {
        debug_assert!(!ANY || found.element != query.ray.target, "it was left out before");
        let counts = match ANY {
            true => found.t <= hit.t,
            false => hit.yields_to(found.t, found.element),
        };
        let accepted = counts && self.is_there(&found, query.is_shadow);
        if accepted {
            *hit = found;
        }
        accepted
    }

    /// Whether there is something where a ray meets a triangle, and no hole.
    #[inline(always)]
    fn is_there(&self, hit: &Hit, is_shadow: bool) -> bool {
        let Hit { element, barycentric, .. } = *hit;
        !self.has_cutouts
            || cutout::is_there(self.primitive(element.primitive), element, barycentric, is_shadow)
    }
}

/// A ray as it is tested against triangles: by the filter, and in `f64`.
struct RayForms<F> {
    filter: F,
    sheared: ShearedRay,
}

impl<F> RayForms<F> {
    #[inline(always)]
    fn new(ray: &Ray, filter: impl Fn(&Ray, &ShearedRay) -> F) -> Self {
        let sheared = ShearedRay::new(ray);
        RayForms { filter: filter(ray, &sheared), sheared }
    }
}

/// Boxes that any of the rays may meet.
#[inline(always)]
fn slabs<const N: usize>(queries: &[Query; N]) -> Slabs {
    let mut slabs = Slabs::new(queries[0].ray);
    for query in &queries[1..] {
        slabs = slabs.union(&Slabs::new(query.ray));
    }
    slabs
}

/// Nothing beyond this is nearer than any of the hits.
#[inline(always)]
fn farthest<const N: usize>(hits: &[Hit; N]) -> f64 {
    let mut t = hits[0].t;
    for hit in &hits[1..] {
        t = t.max(hit.t);
    }
    t
}

/// No hit yet, within the length of a ray.
fn nothing(ray: &Ray) -> Hit {
    Hit { t: ray.t_max, element: ElementId::NONE, barycentric: [0.0; 2], place: Hit::NO_PLACE }
}

/// True if a shadow ray meets a triangle only at the point light in its plane.
#[inline(always)]
fn is_end(ray: &Ray, triangle: &Triangle, t: f64) -> bool {
    ray.may_end_at(t) && holds_end(ray, &triangle.corners)
}

/// Where a ray meets a triangle at a distance, and in proportion to what its corners weigh, if that counts.
#[inline(always)]
fn triangle_hit(query: Query, triangle: &Triangle, place: u32, (t, weights): (f64, [f64; 3])) -> Option<Hit> {
    let element = triangle.element(query.instance);
    (t > 0.0).then(|| Hit { t, element, barycentric: triangle.barycentric(weights), place })
}
