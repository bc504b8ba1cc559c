//! Packets of eight rays, and groups of packets of camera rays that traverse the hierarchy together.

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f32x8, f64x8, mask64x8, prelude::*};

use super::rays::{HitColumns, Hits, NONE, RayColumns, Rays};
use super::{Query, TraversalRays, Tree, nothing};
use crate::bvh::{Leaf, Slabs, WIDTH, not_less};
use crate::columns;
use crate::number::{LANES, Vec3x8, bits, narrow, set_lanes, splat_f32, to_f32};
use crate::ray::{ElementId, Hit, Ray};
use crate::traceable::{NonTriangle, Traceable};
use crate::triangle::{
    Axis, Block, Filter, Tolerance, Triangle,
    sheared::{BoxedTriangle, ShearedRays},
};

/// The most packets that traverse the BVH together.
const MOST_PACKETS: usize = columns::MOST / LANES;

/// Above this number of triangle tests per packet, separate packets are faster.
const MOST_TESTS: usize = 24;

/// The cost of a test of a non-triangle, in triangle tests.
const OTHER_TESTS: usize = 16;

/// How well packets stayed together on their way through the BVH.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coherence {
    /// The packets stayed together and needed few tests. More packets may go together next time.
    High,
    Enough,
    /// The rays run in different directions, or need too many tests together.
    Low,
}

/// Decides how many packets go together next, by how coherent the packets before were.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PacketCount {
    packets: usize,
    /// The number of packets whose rays were traced apart after the last incoherent packet.
    apart: u32,
    /// The number of these packets that are left.
    apart_left: u32,
}

/// The most packets in a row whose rays are traced apart.
const LONGEST_APART: u32 = 63;

impl PacketCount {
    pub const LARGEST: PacketCount = PacketCount { packets: MOST_PACKETS, apart: 0, apart_left: 0 };

    /// The number of packets that go together next, out of those left. 0 if the rays of the next packet are traced
    /// apart.
    pub fn next(&mut self, left: usize) -> usize {
        if self.apart_left > 0 {
            self.apart_left -= 1;
            return 0;
        }
        self.packets.min(left)
    }

    /// Takes the packets whose rays are traced apart next, out of those left. Returns their number.
    pub fn apart(&mut self, left: usize) -> usize {
        let count = left.min(self.apart_left as usize);
        self.apart_left -= count as u32;
        count
    }

    /// Records how coherent a group of `count` packets was.
    pub fn learn(&mut self, count: usize, coherence: Coherence) {
        match coherence {
            Coherence::Low if count == 1 => {
                self.packets = 1;
                self.apart = LONGEST_APART.min(2 * self.apart + 1);
                self.apart_left = self.apart;
            }
            Coherence::Low => self.packets = count / 2,
            Coherence::High if count == self.packets => {
                (self.packets, self.apart) = (MOST_PACKETS.min(2 * count), 0);
            }
            Coherence::High | Coherence::Enough => self.apart = 0,
        }
    }
}

impl Tree<'_> {
    /// Finds the nearest hits of packets of rays from free space, for active rays; nothing if the packets do not stay together. `range`: the
    /// numbers of the packets.
    #[inline(always)]
    pub fn nearest_of<S: Simd>(
        &self,
        simd: S,
        rays: &RayColumns,
        range: Range<usize>,
        active: u64,
        hits: &mut HitColumns,
    ) -> Coherence {
        let mut packets: ArrayVec<Packet<S>, MOST_PACKETS> = ArrayVec::new();
        let mut all: Option<Slabs<S>> = None;
        for first in range.clone().map(|packet| LANES * packet) {
            let active = bits(simd, active >> first & 0xff);
            let rays = whole(simd, rays.eight(simd, first), active);
            let Some((packet, own)) = Packet::new(simd, &rays, active) else { return Coherence::Low };
            all = match all {
                Some(all) => all.union(own),
                None => Some(own),
            };
            if all.is_none() {
                return Coherence::Low;
            }
            packets.push(packet);
        }
        let Some(slabs) = all else { return Coherence::Low };
        let slabs = slabs.of_all(simd);
        let error = packets.iter().fold(0.0, |error: f32, packet| error.max(packet.filter.error));
        let (world, most) = (&self.scene.world, MOST_TESTS * packets.len());
        let mut tests = 0;
        let mut limit = farthest(&packets);
        world.bvh.traverse::<false, _>(
            &world.blocks,
            limit,
            #[inline(always)]
            |node, t_max| slabs.meet(simd, node, t_max),
            #[inline(always)]
            |leaf| {
                match leaf {
                    Leaf::Block(number) => {
                        let block = &world.blocks[number];
                        let tolerance = block.tolerance(error);
                        let mut rest =
                            slabs.meet_boxes(simd, block.boxes(simd), not_less(limit)) & block.mask;
                        while rest != 0 {
                            let lane = rest.trailing_zeros();
                            rest &= rest - 1;
                            tests += packets.len();
                            for packet in &mut packets {
                                let may = packet.may_meet(simd, block, lane as usize, &tolerance);
                                if may != 0 {
                                    packet.meet(simd, self.scene, block.place(lane), may);
                                }
                            }
                        }
                    }
                    Leaf::NonTriangle(other) => {
                        tests += OTHER_TESTS * packets.len();
                        for (number, packet) in range.clone().zip(&mut packets) {
                            let other = world.non_triangles[other];
                            packet.meet_non_triangle(simd, self.scene, (rays, LANES * number), other);
                        }
                    }
                }
                limit = farthest(&packets);
                (tests <= most).then_some(limit)
            },
        );
        if tests > most {
            return Coherence::Low;
        }
        for (number, packet) in range.zip(&packets) {
            hits.set_eight(simd, LANES * number, &packet.hits);
        }
        if 4 * tests <= most { Coherence::High } else { Coherence::Enough }
    }
}

/// The distance of the farthest of all nearest hits.
#[inline(always)]
fn farthest<S: Simd>(packets: &[Packet<S>]) -> f64 {
    let mut t = packets[0].hits.t;
    for packet in &packets[1..] {
        t = t.max(packet.hits.t);
    }
    t.reduce_max()
}

/// The rays that are active, and the first of them in the place of the others.
#[inline(always)]
fn whole<S: Simd>(simd: S, rays: Rays<S>, active: mask64x8<S>) -> Rays<S> {
    if active.all_true() {
        return rays;
    }
    let first = active.to_bitmask().trailing_zeros() as usize % LANES;
    let (o, d) = (rays.o.lane(first), rays.d.lane(first));
    rays.keep_where(active, Rays::new(Vec3x8::splat(simd, o), Vec3x8::splat(simd, d)))
}

/// Eight rays whose direction is longest along one axis, and their nearest hits so far.
pub(super) struct Packet<S: Simd> {
    rays: ShearedRays<S>,
    /// Leaves out triangles that are not met; `f64` decides about the others.
    pub filter: Filter<S>,
    /// The depth of the nearest hits along the longest axis.
    depth: f32x8<S>,
    active: mask64x8<S>,
    pub hits: Hits<S>,
}

impl<S: Simd> Packet<S> {
    /// Prepares rays for tests against triangles and boxes. `None` if the directions differ in sign or in their longest
    /// axis, or are out of the range of `f32`.
    #[inline(always)]
    pub fn new(simd: S, rays: &Rays<S>, active: mask64x8<S>) -> Option<(Self, Slabs<S>)> {
        let (sheared, traversal) =
            (ShearedRays::new(rays.o, rays.d, active), TraversalRays::new(simd, rays.o, rays.d));
        let filter = traversal.all()?;
        if !traversal.magnitude.simd_lt(f32::INFINITY).all_true() {
            return None;
        }
        // Those that are not active are at their end.
        let t = active.select(rays.t_max, NONE.simd_into(simd));
        let (depth, hits) = (to_f32(t) * filter.length(), Hits { t, ..Hits::none(simd) });
        Some((Packet { rays: sheared, filter, depth, active, hits }, traversal.slabs.all()?))
    }

    /// Bits of the rays that may hit a triangle of a block before their nearest hits.
    #[inline(always)]
    pub fn may_meet(&self, simd: S, block: &Block, lane: usize, tolerance: &Tolerance) -> u64 {
        let corner = |at: usize, axis: Axis| splat_f32(simd, block.corners[at][axis as usize][lane % WIDTH]);
        let passes = self.filter.sides(corner).pass(tolerance);
        let [front, back] = self.filter.depths(corner);
        // The depths are products of rounded factors.
        let farthest = self.depth * (1.0 + 8.0 * f32::EPSILON) + tolerance.error;
        let is_out = passes | front.simd_gt(farthest) | back.simd_lt(-tolerance.error);
        !is_out.to_bitmask() & ((1 << WIDTH) - 1)
    }

    /// Records the triangle as the hit of the given rays for which it is the nearest. True if there is such a ray.
    #[inline(always)]
    pub fn meet(&mut self, simd: S, scene: &Traceable, place: u32, may: u64) -> bool {
        let triangle = scene.world.triangle(place);
        let (met, t, sides) =
            self.rays.intersect(simd, &BoxedTriangle::new(triangle), bits(simd, may) & self.active);
        let mut nearer = met & t.simd_lt(self.hits.t);
        let as_near = met & t.simd_eq(self.hits.t);
        if as_near.any_true() {
            nearer |= self.named_earlier(simd, scene, triangle, as_near);
        }
        nearer = scene.meet_solid((triangle, &sides), nearer, false);
        if !nearer.any_true() {
            return false;
        }
        let element: f64x8<S> = f64::from(place).simd_into(simd);
        let hits = &mut self.hits;
        hits.t = nearer.select(t, hits.t);
        hits.element = nearer.select(element, hits.element);
        hits.instance = narrow(nearer).select(ElementId::WORLD.simd_into(simd), hits.instance);
        for (own, weight) in hits.sides.iter_mut().zip(triangle.weights(sides)) {
            *own = nearer.select(weight, *own);
        }
        let emits = scene.primitive(triangle.primitive).emission.is_some();
        hits.emits = if emits { hits.emits | nearer } else { hits.emits & !nearer };
        self.depth = to_f32(hits.t) * self.filter.length();
        true
    }

    /// The rays whose hit so far has a later name than the triangle, or that have no hit.
    #[cold]
    #[inline(never)]
    fn named_earlier(
        &self,
        simd: S,
        scene: &Traceable,
        triangle: &Triangle,
        rays: mask64x8<S>,
    ) -> mask64x8<S> {
        let mut earlier = 0;
        for lane in set_lanes(rays) {
            let hit = self.hit(scene, lane);
            earlier |= u64::from(hit.yields_to(hit.t, triangle.element(ElementId::WORLD))) << lane;
        }
        bits(simd, earlier)
    }

    /// Lets one ray after the other meet what is no triangle. `first`: the first of the rays of this packet.
    #[inline(never)]
    pub fn meet_non_triangle(
        &mut self,
        simd: S,
        scene: &Traceable,
        (rays, first): (&RayColumns, usize),
        other: NonTriangle,
    ) {
        let tree = Tree { scene };
        for lane in set_lanes(self.active) {
            let (ray, mut hit) = (tree.ray(&rays.one(first + lane)), self.hit(scene, lane));
            let query = Query::new(&scene.world, &ray, ElementId::WORLD, false);
            if scene.meet_non_triangle::<S, false>(simd, query, other, &mut hit) {
                let hits = &mut self.hits;
                hits.set_lane(lane, Some(&hit), scene.labels);
                let (own, emits) = (bits(simd, 1 << lane), scene.emits(&hit));
                hits.emits = if emits { hits.emits | own } else { hits.emits & !own };
            }
        }
        self.depth = to_f32(self.hits.t) * self.filter.length();
    }

    /// The nearest hit of a ray so far.
    fn hit(&self, scene: &Traceable, lane: usize) -> Hit {
        if self.hits.element[lane] < 0.0 {
            return Hit {
                t: self.hits.t[lane],
                ..nothing(&Ray::new(Default::default(), Default::default()))
            };
        }
        Tree { scene }.hit(&self.hits, lane)
    }
}

#[cfg(test)]
mod tests {
    use super::super::rays::OneRay;
    use super::*;
    use crate::columns::Stored;
    use crate::number::side_by_side;
    use crate::ray::Ray;
    use crate::testing::noise;
    use crate::testing::{self};
    use crate::traceable::Traceable;
    use glam::DVec3;
    use lookat_scene::Scene;
    use std::array::from_fn;
    use std::fmt::Write;

    /// A wavy field, with shapes on it.
    fn scene(shapes: &str) -> Scene {
        let mut heights = String::new();
        for at in 0..50 * 50 {
            let [x, y] = [at % 50, at / 50].map(f64::from);
            let _ = write!(heights, "{:.4} ", 0.1 * (0.7 * x).sin() * (0.4 * y).cos());
        }
        testing::scene(&format!(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
             Shape \"heightfield\" \"integer nu\" 50 \"integer nv\" 50 \"float Pz\" [{heights}] {shapes} WorldEnd"
        ))
    }

    /// From rays that are almost one to some that have little in common, from one point or from many.
    fn rays(case: usize) -> [Ray; LANES * MOST_PACKETS] {
        let vector = |i, k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
        let (o, target) =
            (DVec3::new(0.5, -1.0, 1.5) + vector(case, 1.1) * 0.3, vector(case, 2.9) * 0.5 + 0.5);
        let spread = 10_f64.powi(case as i32 % 7 - 6);
        from_fn(|k| {
            let i = case * LANES * MOST_PACKETS + k;
            let o = if case.is_multiple_of(2) { o } else { o + vector(i, 5.1) * spread };
            let d = target.with_z(0.0) + vector(i, 3.7) * spread - o;
            // Sometimes along a plane, and on one side of it or the other.
            let d = if case.is_multiple_of(5) { d.with_x([0.0, -0.0][case % 2]) } else { d };
            Ray::new(o, d.normalize())
        })
    }

    /// The coherence of some rays and the number of rays with a hit. Checks that each hit equals that of the ray alone.
    fn trace<S: Simd>(simd: S, scene: &Traceable, rays: &[Ray]) -> (Coherence, usize) {
        let mut columns = RayColumns::new();
        // What is not active is anything.
        let blank = Rays::new(Vec3x8::splat(simd, DVec3::NAN), Vec3x8::splat(simd, DVec3::NAN));
        for packet in 0..MOST_PACKETS {
            columns.store(LANES * packet, &Stored::new(bits(simd, 0xff)), &blank);
        }
        for (at, ray) in rays.iter().enumerate() {
            columns.set(at, &OneRay { o: ray.o, d: ray.d, ..columns.one(at) });
        }
        let (tree, mut hits) = (Tree { scene }, HitColumns::new());
        let active = u64::MAX >> (u64::BITS as usize - rays.len());
        let range = 0..rays.len().div_ceil(LANES);
        let together = tree.nearest_of(simd, &columns, range, active, &mut hits);
        if together == Coherence::Low {
            return (together, 0);
        }
        let mut met = 0;
        for (at, ray) in rays.iter().enumerate() {
            let (hits, lane) = (hits.eight(simd, at / LANES * LANES), at % LANES);
            let own = (hits.element[lane] >= 0.0).then(|| tree.hit(&hits, lane));
            let name =
                |hit: Hit| (hit.element, hit.t.to_bits(), hit.barycentric.map(f64::to_bits), hit.place);
            assert_eq!(own.map(name), scene.nearest(ray).map(name), "{ray:?}");
            assert_eq!(own.is_some_and(|hit| scene.emits(&hit)), hits.emits.to_bitmask() >> lane & 1 == 1);
            met += usize::from(own.is_some());
        }
        (together, met)
    }

    /// What rays meet is the same to the bit, whether they stay together or not.
    #[test]
    fn rays_meet_together_what_they_meet_alone() {
        let level = fearless_simd::Level::new();
        let spheres = "AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .2 Translate .6 .6 0
            Shape \"sphere\" \"float radius\" .1";
        // Two squares in one place, of which the first counts.
        let squares = "Translate 0 0 .3 Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0]
            \"integer indices\" [0 1 2 0 2 3] AreaLightSource \"diffuse\" Shape \"trianglemesh\"
            \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [1 2 0 2 3 0]";
        let holes = "Texture \"h\" \"float\" \"checkerboard\" \"float uscale\" 9 \"float vscale\" 9 Translate 0 0 .2
            Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0 0 1 0] \"integer indices\" [0 1 2 0 2 3] \"texture alpha\" \"h\"
            \"float uv\" [0 0 1 0 1 1 0 1] Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 1 1 0] \"integer indices\" [0 1 2]";
        for shapes in ["", spheres, squares, holes] {
            let scene = crate::Prepared::new(&scene(shapes)).traceable;
            let (mut met, mut stayed) = (0, [0; 3]);
            for case in 0..2000 {
                let rays = rays(case);
                for count in [rays.len(), LANES, 3] {
                    side_by_side!(level, simd => {
                        let (together, own) = trace(simd, &scene, &rays[..count]);
                        met += own;
                        stayed[together as usize] += 1;
                    });
                }
            }
            assert!(met > 20_000 && stayed.iter().all(|count| *count > 100), "{met} {stayed:?}");
        }
    }
}
