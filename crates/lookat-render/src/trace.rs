//! Traces rays in a scene: the nearest hit, and occlusion. Filters in `f32` discard what a ray surely misses; `f64` decides.

mod hierarchy;
mod list;
mod packets;
pub(crate) mod rays;
#[cfg(test)]
mod tests;
mod wide;

use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use crate::bvh::{Leaf, SlabRays, Slabs};
use crate::cutout::{CutoutPoints, is_solid};
use crate::number::{LANES, Vec3x8, side_by_side, splat_f32, to_f32, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{Group, NonTriangle, Traceable};
use crate::triangle::{Axis, Filter, MOST_MAGNITUDE, ShearedRay, Triangle, Turned, holds_end};
pub(crate) use hierarchy::Tree;
pub(crate) use list::{Element, List, ListedShape};
pub(crate) use packets::{Coherence, PacketCount};
pub(crate) use wide::WideTracer;

/// A ray that is traced in the elements of a group, which is an instance or the world.
#[derive(Clone, Copy)]
struct Query<'q> {
    group: &'q Group,
    ray: &'q Ray,
    instance: u32,
    /// The index of the triangle that the ray leaves, if it is in this group. The ray cannot hit this flat triangle again.
    leaving: u32,
    /// True for shadow rays, which may pass other holes.
    is_shadow: bool,
    /// Only hits that come later than one at this distance, of this element, count.
    after: Option<(f64, ElementId)>,
}

impl<'q> Query<'q> {
    #[inline(always)]
    fn new(group: &'q Group, ray: &'q Ray, instance: u32, is_shadow: bool) -> Self {
        let leaving = if ray.leaving.instance == instance { ray.leaving_place } else { Hit::NO_PLACE };
        Query { group, ray, instance, leaving, is_shadow, after: None }
    }

    /// The query in an object, of a ray in its space.
    #[inline(always)]
    fn within(&self, group: &'q Group, ray: &'q Ray, instance: u32) -> Self {
        Query { after: self.after, ..Query::new(group, ray, instance, self.is_shadow) }
    }
}

impl Traceable {
    /// The nearest hit.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.nearest_after(ray, None)
    }

    /// The hits of a ray in the order of their distances; those at one distance in the order of their elements. Of an element that the ray
    /// meets twice, the first counts.
    pub fn hits<'r>(&'r self, ray: &'r Ray) -> impl Iterator<Item = Hit> + use<'r> {
        let mut after = None;
        std::iter::from_fn(move || {
            let hit = self.nearest_after(ray, after)?;
            after = Some((hit.t, hit.element));
            Some(hit)
        })
    }

    fn nearest_after(&self, ray: &Ray, after: Option<(f64, ElementId)>) -> Option<Hit> {
        let mut hit = nothing(ray);
        let query = Query { after, ..self.query(ray, false) };
        side_by_side!(self.level, simd => self.search_alone::<_, false>(simd, query, &mut hit)).then_some(hit)
    }

    /// True if anything but its target is in the way of a shadow ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let query = self.query(ray, true);
        side_by_side!(self.level, simd => self.search_alone::<_, true>(simd, query, &mut nothing(ray)))
    }

    /// The nearest hit, found without trees.
    pub fn nearest_by_all(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = nothing(ray);
        self.search_all::<false>(self.query(ray, false), &mut hit).then_some(hit)
    }

    /// True if anything is in the way of the ray, found without trees.
    #[cfg(test)]
    fn occluded_by_all(&self, ray: &Ray) -> bool {
        self.search_all::<true>(self.query(ray, true), &mut nothing(ray))
    }

    fn query<'q>(&'q self, ray: &'q Ray, is_shadow: bool) -> Query<'q> {
        Query::new(&self.world, ray, ElementId::WORLD, is_shadow)
    }

    /// Traces a single ray with [`Traceable::search`].
    #[inline(always)]
    fn search_alone<S: Simd, const ANY: bool>(&self, simd: S, query: Query, hit: &mut Hit) -> bool {
        let (o, d) = (Vec3x8::splat(simd, query.ray.o), Vec3x8::splat(simd, query.ray.d));
        self.search::<S, ANY>(simd, query, (&TraversalRays::new(simd, o, d), 0), hit)
    }

    /// Searches for hits that replace `hit`, and returns true if there is one. With `ANY` the first hit ends the search, and
    /// the target of the ray does not count.
    ///
    /// Tests in `f32` discard what the ray surely misses. Tests in `f64` decide about the rest.
    #[inline(never)]
    fn search<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        query: Query,
        (forms, lane): (&TraversalRays<S>, usize),
        hit: &mut Hit,
    ) -> bool {
        vectorized!(simd, {
            let group = query.group;
            let (slabs, filter) = forms.one(simd, lane);
            let (mut found, mut sheared) = (false, None);
            group.bvh.traverse::<ANY, _>(
                &group.blocks,
                hit.t,
                #[inline(always)]
                |node, t_max| slabs.meet(simd, node, t_max),
                #[inline(always)]
                |leaf| {
                    match leaf {
                        Leaf::Block(number) => {
                            let block = &group.blocks[number];
                            let leaving = block.bit_of(query.leaving);
                            // A product in f32 may overflow to infinity, which is a limit too.
                            let end = (hit.t * f64::from(filter.length()[0])) as f32;
                            let Some(hits) = filter.meet::<true>(simd, block, end, leaving) else {
                                return Some(hit.t);
                            };
                            // The target of a shadow ray never is wholly before its end.
                            if ANY && hits.certain_before(end) & block.solid != 0 {
                                found = true;
                                return None;
                            }
                            let mut rest = hits.may;
                            while rest != 0 {
                                let lane = rest.trailing_zeros();
                                rest &= rest - 1;
                                let place = block.place(lane);
                                found |= self.meet_triangle::<ANY>(query, place, &mut sheared, hit);
                            }
                        }
                        Leaf::NonTriangle(other) => {
                            found |= self.meet_non_triangle::<S, ANY>(
                                simd,
                                query,
                                group.non_triangles[other],
                                hit,
                            );
                        }
                    }
                    (!ANY || !found).then_some(hit.t)
                },
            );
            found
        })
    }

    /// Out of line, because few triangles get here. `sheared` keeps the prepared ray for the next triangle.
    #[inline(never)]
    fn meet_triangle<const ANY: bool>(
        &self,
        query: Query,
        place: u32,
        sheared: &mut Option<ShearedRay>,
        hit: &mut Hit,
    ) -> bool {
        let (ray, triangle) = (query.ray, query.group.triangle(place));
        let element = triangle.element(query.instance);
        // A shadow ray ends at its target, or just before: no need to decide which.
        if ANY && element == ray.target {
            return false;
        }
        let sheared = sheared.get_or_insert_with(|| ShearedRay::new(ray));
        let Some((t, weights)) = sheared.intersect(&triangle.corners) else { return false };
        if ANY && ray.may_end_at(t) && holds_end(ray, &triangle.corners) {
            return false;
        }
        let barycentric = triangle.barycentric(weights);
        self.accept::<ANY>(query, Hit { t, element, barycentric, place }, hit)
    }

    /// Tests all elements in turn.
    fn search_all<const ANY: bool>(&self, query: Query, hit: &mut Hit) -> bool {
        let (mut found, mut sheared) = (false, None);
        for place in (0..query.group.triangles.len() as u32).filter(|place| *place != query.leaving) {
            found |= self.meet_triangle::<ANY>(query, place, &mut sheared, hit);
        }
        for other in &query.group.non_triangles {
            found |= match *other {
                NonTriangle::Instance { instance, .. } => {
                    let placed = self.placed(instance, query.ray.time);
                    let (group, ray) = (&self.objects[placed.object], &placed.ray(query.ray, hit.t));
                    self.search_all::<ANY>(query.within(group, ray, instance), hit)
                }
                other => self.meet_shape::<ANY>(query, other, hit),
            };
        }
        found
    }

    /// Out of line, so that triangles do not pay for it.
    #[inline(never)]
    fn meet_non_triangle<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        query: Query,
        other: NonTriangle,
        hit: &mut Hit,
    ) -> bool {
        let NonTriangle::Instance { instance, .. } = other else {
            return self.meet_shape::<ANY>(query, other, hit);
        };
        let placed = self.placed(instance, query.ray.time);
        let (group, ray) = (&self.objects[placed.object], &placed.ray(query.ray, hit.t));
        let query = query.within(group, ray, instance);
        match group.single_shape() {
            Some(other) => self.meet_shape::<ANY>(query, other, hit),
            None => vectorized!(simd, self.search_alone::<S, ANY>(simd, query, hit)),
        }
    }

    fn meet_shape<const ANY: bool>(&self, query: Query, other: NonTriangle, hit: &mut Hit) -> bool {
        let Query { ray, instance, .. } = query;
        let (element, met) = match other {
            NonTriangle::Instance { .. } => return false,
            NonTriangle::Curved { primitive, shape } => {
                let element = ElementId { instance, primitive, index: 0 };
                if ANY && element == ray.target {
                    return false;
                }
                let (shape, leaving) = (&self.curved[shape as usize], element == ray.leaving);
                let t = shape.intersect(ray, hit.t, leaving);
                let is_end = |t: &f64| ANY && ray.may_end_at(*t) && shape.is_met_at_end(ray, leaving);
                (element, t.filter(|t| !is_end(t)).map(|t| (t, [0.0; 2])))
            }
            NonTriangle::Curve { primitive, piece } => {
                let element = ElementId { instance, primitive, index: piece };
                let same = ElementId { index: ray.leaving.index, ..element } == ray.leaving;
                let meeting = self.curves.meet(piece, ray, hit.t, same.then_some(ray.leaving.index));
                (element, meeting.map(|meeting| (meeting.t, meeting.uv.into())))
            }
        };
        let Some((t, barycentric)) = met else { return false };
        self.accept::<ANY>(query, Hit { t, element, barycentric, place: Hit::NO_PLACE }, hit)
    }

    /// True if the element has no hole at the point.
    #[inline(always)]
    fn is_valid(&self, element: ElementId, barycentric: [f64; 2], is_shadow: bool) -> bool {
        let ElementId { primitive, index, .. } = element;
        !self.is_cut_out(primitive)
            || is_solid(self.level, self.primitive(primitive), index, barycentric, is_shadow)
    }

    /// The rays that hit a triangle of the world where it has no hole. `sides`: unnormalized weights of its corners.
    #[inline(always)]
    fn meet_solid<S: Simd>(
        &self,
        (triangle, sides): (&Triangle, &[f64x8<S>; 3]),
        met: mask64x8<S>,
        is_shadow: bool,
    ) -> mask64x8<S> {
        if !self.is_cut_out(triangle.primitive) {
            return met;
        }
        let [b0, b1, _] = triangle.weights(*sides);
        let element = triangle.element(ElementId::WORLD);
        let (primitives, triangles) = ([self.primitive(element.primitive); LANES], [element.index; LANES]);
        CutoutPoints { primitives, triangles, barycentric: [b0, b1], is_shadow }.solid(met)
    }

    /// Replaces `hit` by `found` if that is nearer and no hole. True if it does.
    #[inline(always)]
    fn accept<const ANY: bool>(&self, query: Query, found: Hit, hit: &mut Hit) -> bool {
        debug_assert!(!ANY || found.element != query.ray.target, "it was left out before");
        let counts = if ANY { found.t <= hit.t } else { hit.yields_to(found.t, found.element) };
        let is_later = query.after.is_none_or(|(t, element)| found.yields_to(t, element));
        let Hit { element, barycentric, .. } = found;
        let accepted = counts && is_later && self.is_valid(element, barycentric, query.is_shadow);
        if accepted {
            *hit = found;
        }
        accepted
    }
}

/// A hit record that any hit within the length of the ray replaces.
fn nothing(ray: &Ray) -> Hit {
    Hit { t: ray.t_max, element: ElementId::NONE, barycentric: [0.0; 2], place: Hit::NO_PLACE }
}

/// Eight rays, prepared for tests against boxes and triangles in `f32`.
pub(crate) struct TraversalRays<S: Simd> {
    pub slabs: SlabRays<S>,
    turned: Turned<S>,
    /// The largest coordinate of each origin. Infinite for rays out of the range of `f32`.
    pub magnitude: f32x8<S>,
    /// Bits of the rays whose longest axis is not x, and bits of those whose longest axis is z.
    is_not: [u64; 2],
}

impl<S: Simd> TraversalRays<S> {
    #[inline(always)]
    pub fn new(simd: S, o: Vec3x8<S>, d: Vec3x8<S>) -> Self {
        let o = [to_f32(o.x), to_f32(o.y), to_f32(o.z)];
        let d = [to_f32(d.x), to_f32(d.y), to_f32(d.z)];
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let is_not_x = x.simd_lt(y) | x.simd_lt(z);
        let is_not_y = is_not_x & y.simd_lt(z);
        let longest = x.max(y).max(z);
        let magnitude = o[0].abs().max(o[1].abs()).max(o[2].abs());
        // Distances along the longest axis are finite.
        let is_near = magnitude.simd_lt(longest * 1e35);
        let is_safe =
            longest.simd_gt(1e-30) & longest.simd_lt(1e30) & magnitude.simd_lt(MOST_MAGNITUDE) & is_near;
        let turned = |[x, y, z]: [f32x8<S>; 3]| {
            let pick = |if_x, if_y, if_z| is_not_y.select(if_z, is_not_x.select(if_y, if_x));
            [pick(y, z, x), pick(z, x, y), pick(x, y, z)]
        };
        TraversalRays {
            slabs: SlabRays::new(simd, o, d),
            turned: Turned::new(turned(o), turned(d)),
            magnitude: is_safe.select(magnitude, splat_f32(simd, f32::INFINITY)),
            is_not: [is_not_x.to_bitmask(), is_not_y.to_bitmask()],
        }
    }

    /// One ray, for tests against the boxes of a node and the triangles of a block.
    #[inline(always)]
    pub fn one(&self, simd: S, lane: usize) -> (Slabs<S>, Filter<S>) {
        let filter = Filter::new(self.axes(lane), self.turned.one(simd, lane), self.magnitude[lane]);
        (self.slabs.one(simd, lane), filter)
    }

    /// All rays, for tests against one triangle. `None` if the longest axis differs between rays.
    #[inline(always)]
    pub fn all(&self) -> Option<Filter<S>> {
        let are_alike = self.is_not.iter().all(|is_not| [0, (1 << LANES) - 1].contains(is_not));
        are_alike.then(|| Filter::new(self.axes(0), self.turned, self.magnitude.reduce_max()))
    }

    /// The axes in an order that puts the longest axis of the ray last.
    #[inline(always)]
    fn axes(&self, lane: usize) -> [Axis; 3] {
        Axis::ORDERS[self.order(lane)]
    }

    /// The index of these axes in [`Axis::ORDERS`].
    #[inline(always)]
    fn order(&self, lane: usize) -> usize {
        self.is_not.iter().map(|is_not| (is_not >> lane & 1) as usize).sum()
    }
}
