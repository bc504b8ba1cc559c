//! Rays against a scene: the nearest hit, and whether anything is in the way.

use crate::arithmetic::{Precision, SimdKind};
#[cfg(target_arch = "x86_64")]
use crate::bvh::WideSlabs;
use crate::bvh::{DoubleSlabs, Leaf, Node, Slabs, WIDTH};
use crate::cutout;
use crate::plain::{self, PlainRay};
use crate::prepare::{Group, Other, Traceable};
use crate::ray::{ElementId, Hit, Ray};
#[cfg(target_arch = "x86_64")]
use crate::triangle::block::avx2::filter_ray;
use crate::triangle::block::{Block, FilterRay};
use crate::triangle::{ShearedRay, Triangle};

/// A ray among the elements of a group, which belong to an instance or to the world.
#[derive(Clone, Copy)]
struct Query<'q> {
    group: &'q Group,
    ray: &'q Ray,
    instance: u32,
    /// Whether holes are those that shadow rays pass.
    is_shadow: bool,
}

/// The tests of one ray.
struct Tests<B, F, D> {
    /// Which boxes of a node it may meet within a limit, as bits, and from which distance on.
    boxes: B,
    /// Which triangles of a block it may meet within a limit, as bits.
    filter: F,
    /// Where it does meet a triangle, and in proportion to what its corners weigh.
    decide: D,
}

impl Traceable<'_> {
    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = nothing(ray);
        self.search::<false>(self.query(ray, false), &mut hit).then_some(hit)
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
        Query { group: &self.world, ray, instance: ElementId::WORLD, is_shadow }
    }

    /// Looks for hits that `hit` yields to. With `ANY` the first will do, if it is not the target of the ray.
    fn search<const ANY: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        match self.precision {
            Precision::Mixed => self.search_wide::<ANY, false>(query, hit),
            Precision::Single => self.search_wide::<ANY, true>(query, hit),
            Precision::Double => self.search_double::<ANY>(query, hit),
        }
    }

    /// By tests in `f32` that leave out what is not met. What is left is decided about in `f64`; or if `SINGLE` is set, to
    /// be measured against that, in `f32` too.
    fn search_wide<const ANY: bool, const SINGLE: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        match self.simd.kind() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `Simd` says what the processor has.
            #[allow(unsafe_code)]
            SimdKind::Avx512 => unsafe { self.search_avx512::<ANY, SINGLE>(query, hit) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            #[allow(unsafe_code)]
            SimdKind::Avx2 => unsafe { self.search_avx2::<ANY, SINGLE>(query, hit) },
            SimdKind::Portable => self.search_portable::<ANY, SINGLE>(query, hit),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn search_avx2<const ANY: bool, const SINGLE: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let slabs = WideSlabs::new(&Slabs::new(query.ray));
        let filter = filter_ray(query.ray, &sheared);
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |block: &Block, t_max| filter.may_meet(block, t_max);
        self.search_by::<ANY, SINGLE>(query, hit, &sheared, boxes, filter)
    }

    /// The same, with the registers of AVX-512.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,avx512f,avx512vl,bmi1,bmi2")]
    fn search_avx512<const ANY: bool, const SINGLE: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let slabs = WideSlabs::new(&Slabs::new(query.ray));
        let filter = filter_ray(query.ray, &sheared);
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |block: &Block, t_max| filter.may_meet(block, t_max);
        self.search_by::<ANY, SINGLE>(query, hit, &sheared, boxes, filter)
    }

    fn search_portable<const ANY: bool, const SINGLE: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let slabs = Slabs::new(query.ray);
        let filter = FilterRay::new(query.ray, &sheared, |x| x);
        let boxes = |node: &Node, t_max| slabs.meet(node, t_max);
        let filter = |block: &Block, t_max| filter.may_meet(block, t_max);
        self.search_by::<ANY, SINGLE>(query, hit, &sheared, boxes, filter)
    }

    #[inline(always)]
    fn search_by<const ANY: bool, const SINGLE: bool>(
        &self,
        query: Query,
        hit: &mut Hit,
        sheared: &ShearedRay,
        boxes: impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
        filter: impl Fn(&Block, f64) -> u32,
    ) -> bool {
        let plain = PlainRay::new(query.ray);
        let decide = |triangle: &Triangle| match SINGLE {
            true => plain.intersect(&triangle.corners),
            false => sheared.intersect(&triangle.corners),
        };
        self.search_with::<ANY>(query, hit, &Tests { boxes, filter, decide })
    }

    /// All in `f64`.
    fn search_double<const ANY: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let slabs = DoubleSlabs::new(query.ray);
        let tests = Tests {
            boxes: |node: &Node, t_max| slabs.meet(node, t_max),
            filter: |block: &Block, _| block.all(),
            decide: |triangle: &Triangle| sheared.intersect(&triangle.corners),
        };
        self.search_with::<ANY>(query, hit, &tests)
    }

    #[inline(always)]
    fn search_with<const ANY: bool>(
        &self,
        query: Query,
        hit: &mut Hit,
        tests: &Tests<
            impl Fn(&Node, f32) -> (u32, [f32; WIDTH]),
            impl Fn(&Block, f64) -> u32,
            impl Fn(&Triangle) -> Option<(f64, [f64; 3])>,
        >,
    ) -> bool {
        let mut found = false;
        query.group.bvh.traverse(hit.t, &tests.boxes, |leaf| {
            match leaf {
                Leaf::Block(block) => {
                    let block = &query.group.blocks[block];
                    let mut rest = (tests.filter)(block, hit.t);
                    while rest != 0 {
                        let triangle =
                            &query.group.triangles[block.first as usize + rest.trailing_zeros() as usize];
                        rest &= rest - 1;
                        let met = (tests.decide)(triangle).and_then(|met| triangle_hit(query, triangle, met));
                        found |= met.is_some_and(|met| self.accept::<ANY>(query, met, hit));
                    }
                }
                Leaf::Other(other) => found |= self.meet_other::<ANY>(query, query.group.others[other], hit),
            }
            (!ANY || !found).then_some(hit.t)
        });
        found
    }

    /// All elements, one after the other.
    fn search_all(&self, query: Query, hit: &mut Hit) -> bool {
        let sheared = ShearedRay::new(query.ray);
        let mut found = false;
        for triangle in &query.group.triangles {
            let met = sheared.intersect(&triangle.corners).and_then(|met| triangle_hit(query, triangle, met));
            found |= met.is_some_and(|met| self.accept::<false>(query, met, hit));
        }
        for other in &query.group.others {
            found |= match *other {
                Other::Instance { instance } => {
                    let placed = &self.instances[instance as usize];
                    let (group, ray) = (&self.objects[placed.object], &placed.ray(query.ray, hit.t));
                    self.search_all(Query { group, ray, instance, ..query }, hit)
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
                self.search::<ANY>(Query { group, ray, instance, ..query }, hit)
            }
            Other::Curved { primitive, shape } => {
                let element = ElementId { instance, primitive, index: 0 };
                if ANY && element == ray.target {
                    return false;
                }
                let (shape, leaving) = (&self.curved[shape as usize], element == ray.leaving);
                let t = match self.precision {
                    Precision::Single => plain::curved(shape, ray, hit.t, leaving),
                    _ => shape.intersect(ray, hit.t, leaving),
                };
                t.is_some_and(|t| self.accept::<ANY>(query, Hit { t, element, barycentric: [0.0; 2] }, hit))
            }
            Other::Curve { primitive, piece } => {
                let element = ElementId { instance, primitive, index: piece };
                let same = ElementId { index: ray.leaving.index, ..element } == ray.leaving;
                let leaving = same.then_some(ray.leaving.index);
                let meeting = self.curves.meet(piece, ray, hit.t, leaving);
                meeting.is_some_and(|meeting| {
                    self.accept::<ANY>(
                        query,
                        Hit { t: meeting.t, element, barycentric: meeting.uv.into() },
                        hit,
                    )
                })
            }
        }
    }

    /// Puts `found` in the place of `hit`, if it is nearer.
    #[inline(always)]
    fn accept<const ANY: bool>(&self, query: Query, found: Hit, hit: &mut Hit) -> bool {
        let counts = match ANY {
            true => found.t <= hit.t && found.element != query.ray.target,
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
            || cutout::is_there(self.primitives[element.primitive as usize], element, barycentric, is_shadow)
    }
}

/// No hit yet, within the length of a ray.
fn nothing(ray: &Ray) -> Hit {
    Hit { t: ray.t_max, element: ElementId::NONE, barycentric: [0.0; 2] }
}

/// Where a ray meets a triangle at a distance, if that counts: what is flat is not met again by a ray that leaves it.
#[inline(always)]
fn triangle_hit(query: Query, triangle: &Triangle, (t, weights): (f64, [f64; 3])) -> Option<Hit> {
    let Query { ray, instance, .. } = query;
    let element = ElementId { instance, primitive: triangle.primitive, index: triangle.index };
    let counts = t > 0.0 && element != ray.leaving;
    counts.then(|| Hit { t, element, barycentric: triangle.barycentric(weights) })
}
