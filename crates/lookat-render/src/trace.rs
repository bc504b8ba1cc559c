//! Rays against a scene: the nearest hit, and whether anything is in the way.

mod forms;
pub(crate) mod lanes;
mod packet;
mod stream;
#[cfg(test)]
mod tests;

pub(crate) use forms::{Form, Forms};
pub(crate) use stream::{MOST_PACKETS, StreamSize, Together};

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

/// [`Traceable::search_by`] with the tests that `WideSlabs` and `WideFilter` have. A macro, since closures are compiled for the
/// instructions of the function that they are in.
#[cfg(target_arch = "x86_64")]
macro_rules! search_with {
    ($self:ident.search_by::<$any:ident>($query:ident, $hit:ident, $ray:expr, $slabs:ident)) => {{
        let boxes = |node: &$crate::bvh::Node, t_max| $slabs.meet(node, t_max);
        let filter =
            |ray: &WideFilter, block: &$crate::triangle::block::Block, t_max| ray.may_meet(block, t_max);
        let surely =
            |ray: &WideFilter, block: &$crate::triangle::block::Block, t_max| ray.surely_meets(block, t_max);
        $self.search_by::<$any, _>($query, $hit, $ray, boxes, filter, surely)
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

    /// The nearest hit, found without trees.
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = nothing(ray);
        self.search_all(self.query(ray, false), &mut hit).then_some(hit)
    }

    fn query<'q>(&'q self, ray: &'q Ray, is_shadow: bool) -> Query<'q> {
        Query::new(&self.world, ray, ElementId::WORLD, is_shadow)
    }

    /// Looks for hits that `hit` yields to, and returns whether there is one. With `ANY` the first will do; the target of the ray is
    /// left out.
    fn search<const ANY: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        #[cfg(test)]
        if self.is_double {
            return self.search_double::<ANY>(&query, hit);
        }
        self.search_wide::<ANY>(&query, hit)
    }

    /// By tests in `f32` that leave out what is not met. What is left is decided about in `f64`.
    fn search_wide<const ANY: bool>(&self, query: &Query, hit: &mut Hit) -> bool {
        match self.simd.kind() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` says what the processor has.
            #[allow(unsafe_code)]
            SimdKind::Avx512 => unsafe { self.search_avx512::<ANY>(query, hit) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            #[allow(unsafe_code)]
            SimdKind::Avx2 => unsafe { self.search_avx2::<ANY>(query, hit) },
            SimdKind::Portable => self.search_portable::<ANY>(query, hit),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn search_avx2<const ANY: bool>(&self, query: &Query, hit: &mut Hit) -> bool {
        let slabs = WideSlabs::new(&Slabs::new(query.ray));
        let ray = &RayForms::new(query.ray, |ray, sheared| filter_ray(ray, sheared));
        search_with!(self.search_by::<ANY>(query, hit, ray, slabs))
    }

    /// The same, with the registers of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,avx512f,avx512vl,bmi1,bmi2")]
    fn search_avx512<const ANY: bool>(&self, query: &Query, hit: &mut Hit) -> bool {
        let slabs = WideSlabs::new(&Slabs::new(query.ray));
        let ray = &RayForms::new(query.ray, |ray, sheared| filter_ray(ray, sheared));
        search_with!(self.search_by::<ANY>(query, hit, ray, slabs))
    }

    fn search_portable<const ANY: bool>(&self, query: &Query, hit: &mut Hit) -> bool {
        let slabs = Slabs::new(query.ray);
        let ray = &RayForms::new(query.ray, |ray, sheared| FilterRay::new(ray, sheared, |x| x));
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |ray: &FilterRay<f32>, block: &Block, t_max| ray.may_meet(block, t_max);
        let surely = |ray: &FilterRay<f32>, block: &Block, t_max| ray.surely_meets(block, t_max);
        self.search_by::<ANY, _>(query, hit, ray, boxes, filter, surely)
    }

    /// By the forms of the ray: which boxes of a node it may meet, and which triangles of a block.
    #[inline(always)]
    fn search_by<const ANY: bool, F>(
        &self,
        query: &Query,
        hit: &mut Hit,
        ray: &RayForms<F>,
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        filter: impl Fn(&F, &Block, f64) -> u32,
        surely: impl Fn(&F, &Block, f64) -> u32,
    ) -> bool {
        let filter = |block: &Block, t_max| filter(&ray.filter, block, t_max);
        let surely = |block: &Block, t_max| surely(&ray.filter, block, t_max);
        let decide = |triangle: &Triangle| ray.sheared.intersect(&triangle.corners);
        self.search_with::<ANY>(query, hit, boxes, filter, surely, decide)
    }

    /// All in `f64`.
    #[cfg(test)]
    fn search_double<const ANY: bool>(&self, query: &Query, hit: &mut Hit) -> bool {
        let (sheared, slabs) = (ShearedRay::new(query.ray), DoubleSlabs::new(query.ray));
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let decide = |triangle: &Triangle| sheared.intersect(&triangle.corners);
        self.search_with::<ANY>(query, hit, boxes, |block, _| block.all(), |_, _| 0, decide)
    }

    /// `boxes` gives the boxes of a node that the ray may meet within a limit, as bits, and where it enters them. `filter` gives the
    /// triangles of a block that it may meet within a limit, as bits. `surely` gives some of the triangles that it certainly meets.
    /// `decide` tells where it meets a triangle, and in proportion to what its corners weigh.
    #[inline(always)]
    fn search_with<const ANY: bool>(
        &self,
        query: &Query,
        hit: &mut Hit,
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        filter: impl Fn(&Block, f64) -> u32,
        surely: impl Fn(&Block, f64) -> u32,
        decide: impl Fn(&Triangle) -> Option<(f64, [f64; 3])>,
    ) -> bool {
        let group = query.group;
        let mut found = false;
        let limit = hit.t;
        let visit = |leaf| {
            match leaf {
                Leaf::Block(number) => {
                    let block = &group.blocks[number];
                    // Of what a shadow ray meets, it seldom has to be known where.
                    if !ANY {
                        block.prefetch_triangles();
                    }
                    let others = !query.leaving_of(number);
                    let mut rest = filter(block, hit.t) & others;
                    // The target of a shadow ray never is wholly before its end.
                    if ANY && rest != 0 && !self.has_cutouts && surely(block, hit.t) & others != 0 {
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
                        let met = decide(triangle)
                            .and_then(|met| triangle_hit(*query, triangle, place, met))
                            .filter(|met| !ANY || !is_end(query.ray, triangle, met.t));
                        found |= met.is_some_and(|met| self.accept::<ANY>(*query, met, hit));
                    }
                }
                Leaf::Other(other) => found |= self.meet_other::<ANY>(*query, group.others[other], hit),
            }
            (!ANY || !found).then_some(hit.t)
        };
        let prefetch = |leaf| {
            if let Leaf::Block(number) = leaf {
                group.blocks[number].prefetch_filter();
            }
        };
        group.bvh.traverse::<ANY>(limit, boxes, visit, prefetch);
        found
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
