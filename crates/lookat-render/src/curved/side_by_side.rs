//! Eight rays against curved shapes: all against one, or each against its own.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use super::part::{PART, have};
use super::profile::{Crossings, DOUBT, Equation, ProfileNumbers};
use super::{AT_ORIGIN, Curved, UnitShape};
use crate::number::{LANES, V3, Vec3x8, bits, has_compress, set_lanes, vectorized};
use crate::ray::Ray;

/// Forms that are tested alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    WholeSphere,
    PartialSphere,
    Disk,
    Profile,
}

impl Kind {
    pub const ALL: [Kind; 4] = [Kind::WholeSphere, Kind::PartialSphere, Kind::Disk, Kind::Profile];
    pub const COUNT: usize = Kind::ALL.len();
}

/// The numbers of a form that tests need: the largest distance from its axis, those of its part, and those of its kind.
pub(crate) type FormNumbers<T = f64> = [T; OWN + 6];
/// The first number of the part, and of the kind.
const CUT: usize = 1;
const OWN: usize = CUT + PART;

/// Possible hits of rays on curved shapes.
pub(crate) struct ShapeHits<S: Simd> {
    pub met: mask64x8<S>,
    pub t: f64x8<S>,
    /// The rays that must be tested one by one.
    pub doubtful: mask64x8<S>,
}

/// Eight rays for tests against curved shapes.
#[derive(Clone, Copy)]
pub(crate) struct ShapeRays<S: Simd> {
    pub o: Vec3x8<S>,
    pub d: Vec3x8<S>,
    pub t_max: f64x8<S>,
    /// The rays that leave their shapes.
    pub leaving: mask64x8<S>,
    /// The rays that count.
    pub active: mask64x8<S>,
}

impl<S: Simd> ShapeRays<S> {
    /// One of the rays.
    #[inline(always)]
    fn one(&self, lane: usize) -> Ray {
        Ray { t_max: self.t_max[lane], ..Ray::new(self.o.lane(lane), self.d.lane(lane)) }
    }

    /// Rays of the world in the space of a shape.
    #[inline(always)]
    fn in_space_of(&self, curved: &Curved) -> Self {
        let (o, d) = (self.o.moved_by(-curved.center), self.d);
        ShapeRays { o: o.by(&curved.own_from_world), d: d.by(&curved.own_from_world), ..*self }
    }

    /// The hits of rays in the spaces of their shapes, whole spheres of these radii, with the bits of [`Curved::intersect`].
    #[inline(always)]
    pub fn meet_whole_spheres(&self, radius: f64x8<S>) -> ShapeHits<S> {
        match Meet::spheres(radius, self) {
            Some(meet) => meet.first(
                radius,
                self,
                #[inline(always)]
                |_, may| (may, may & !may),
            ),
            None => ShapeHits::none(self.t_max),
        }
    }

    /// The hits of rays in the spaces of their shapes, of a kind, with the bits of [`Curved::intersect`]. `ends_at_middle`: only those before
    /// the middle of both places where the line meets the form count.
    #[inline(always)]
    pub fn meet(&self, kind: Kind, number: impl Fn(usize) -> f64x8<S>, ends_at_middle: bool) -> ShapeHits<S> {
        let none = ShapeHits::none(self.t_max);
        // Others have no fused operations, or need more code for this than fits their caches.
        if !has_compress(self.t_max.token()) {
            return ShapeHits { doubtful: self.active, ..none };
        }
        let radius = number(0);
        let meet = match kind {
            Kind::WholeSphere | Kind::PartialSphere => Meet::spheres(radius, self),
            Kind::Disk => Meet::disks([number(OWN), number(OWN + 1)], self),
            Kind::Profile => {
                let [w, a, b] = [number(OWN), number(OWN + 1), number(OWN + 2)];
                let [c, e, reach_squared] = [number(OWN + 3), number(OWN + 4), number(OWN + 5)];
                Meet::profiles(&[w, a, b, c, e, reach_squared], self, ends_at_middle)
            }
        };
        let (Some(meet), mut rays) = (meet, *self) else { return none };
        if ends_at_middle {
            let middle = meet.crossings.middle;
            rays.t_max = self.t_max.simd_gt(middle).select(middle, 0.0.simd_into(middle.token()));
        }
        meet.first(
            radius,
            &rays,
            #[inline(always)]
            |p, may| {
                have(
                    #[inline(always)]
                    |at| number(CUT + at),
                    p,
                    may,
                )
            },
        )
    }
}

/// What [`ShapeRays::meet`] needs to know of a form. `None` of whole spheres, of which the radius is enough.
pub(super) fn numbers_of(form: &UnitShape, radius: f64) -> Option<Box<FormNumbers>> {
    let mut numbers = Box::new([radius; OWN + 6]);
    numbers[CUT..OWN].copy_from_slice(&form.part()?.numbers());
    match form {
        UnitShape::Sphere(_) => {}
        UnitShape::Disk(disk) => numbers[OWN..OWN + 2].copy_from_slice(&disk.numbers()),
        UnitShape::TurnedSegment(segment) => numbers[OWN..].copy_from_slice(&segment.profile.numbers()),
        UnitShape::Paraboloid(paraboloid) => numbers[OWN..].copy_from_slice(&paraboloid.profile.numbers()),
    }
    Some(numbers)
}

/// The numbers of shapes, one for each lane.
#[inline(always)]
pub(crate) fn gather(shapes: &[&Curved]) -> FormNumbers<[f64; LANES]> {
    let mut columns = [[1.0; LANES]; OWN + 6];
    for (lane, shape) in shapes.iter().enumerate().take(LANES) {
        for (column, x) in columns.iter_mut().zip(shape.numbers.iter().flat_map(|all| all.iter())) {
            column[lane] = *x;
        }
    }
    columns
}

impl Curved {
    /// The largest distance from the axis, in its own space; the radius of a sphere.
    #[inline(always)]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    #[inline(always)]
    pub fn kind(&self) -> Kind {
        match &self.form {
            UnitShape::Sphere(sphere) if sphere.is_whole() => Kind::WholeSphere,
            UnitShape::Sphere(_) => Kind::PartialSphere,
            UnitShape::Disk(_) => Kind::Disk,
            UnitShape::TurnedSegment(_) | UnitShape::Paraboloid(_) => Kind::Profile,
        }
    }

    /// The hits of eight rays, whose origins and directions are in the world, with the bits of [`Curved::intersect`].
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, rays: &ShapeRays<S>) -> ShapeHits<S> {
        let own = rays.in_space_of(self);
        match self.kind() {
            Kind::WholeSphere => own.meet_whole_spheres(self.radius.simd_into(own.t_max.token())),
            _ => self.meet_own(&own, false),
        }
    }

    /// The active rays of the world that meet the shape, and where, with the bits of [`Curved::intersect`].
    #[inline(always)]
    pub fn intersect_all<S: Simd>(&self, rays: &ShapeRays<S>) -> (mask64x8<S>, f64x8<S>) {
        let hits = self.meet(rays);
        if hits.doubtful.any_true() { self.intersect_doubtful(rays, hits) } else { (hits.met, hits.t) }
    }

    /// Tests the doubtful rays one by one.
    #[inline(never)]
    fn intersect_doubtful<S: Simd>(
        &self,
        rays: &ShapeRays<S>,
        ShapeHits { met, mut t, doubtful }: ShapeHits<S>,
    ) -> (mask64x8<S>, f64x8<S>) {
        let (mut met, leaving) = (met.to_bitmask(), rays.leaving.to_bitmask());
        for lane in set_lanes(doubtful) {
            let found = self.intersect(&rays.one(lane), rays.t_max[lane], leaving >> lane & 1 == 1);
            met = met & !(1 << lane) | u64::from(found.is_some()) << lane;
            t[lane] = found.unwrap_or(0.0);
        }
        (bits(t.token(), met), t)
    }

    /// The active rays of the world whose ends, points of the shape, lie behind another part of it. As [`Curved::hides_end_of`].
    #[inline(always)]
    pub fn hides_ends_of<S: Simd>(&self, rays: &ShapeRays<S>) -> mask64x8<S> {
        let ShapeHits { met, doubtful, .. } = self.meet_own(&rays.in_space_of(self), true);
        let mut hidden = met & !doubtful;
        for lane in set_lanes(doubtful) {
            let is_hidden = self.hides_end_of(&rays.one(lane), rays.leaving.to_bitmask() >> lane & 1 == 1);
            hidden |= bits(met.token(), u64::from(is_hidden) << lane);
        }
        hidden
    }

    /// The hits of rays in the space of the shape: see [`ShapeRays::meet`].
    #[inline(never)]
    fn meet_own<S: Simd>(&self, own: &ShapeRays<S>, ends_at_middle: bool) -> ShapeHits<S> {
        let simd = own.t_max.token();
        let Some(numbers) = &self.numbers else {
            return ShapeHits { doubtful: own.active, ..ShapeHits::none(own.t_max) };
        };
        vectorized!(simd, {
            own.meet(
                self.kind(),
                #[inline(always)]
                |at| numbers[at].simd_into(simd),
                ends_at_middle,
            )
        })
    }
}

impl<S: Simd> ShapeHits<S> {
    #[inline(always)]
    fn none(t: f64x8<S>) -> Self {
        let none = bits(t.token(), 0);
        ShapeHits { met: none, t, doubtful: none }
    }
}

/// Where eight lines meet forms.
struct Meet<S: Simd> {
    crossings: Crossings<Vec3x8<S>, f64x8<S>>,
    /// The lines that meet their forms, and those of which that is not certain.
    meets: mask64x8<S>,
    doubtful: mask64x8<S>,
}

impl<S: Simd> Meet<S> {
    /// As [`super::Sphere::meet`], for spheres of these radii. `None` where no line meets its own.
    #[inline(always)]
    fn spheres(radius: f64x8<S>, rays: &ShapeRays<S>) -> Option<Self> {
        let ShapeRays { o, d, active, .. } = *rays;
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        let near = o + d * k;
        let correction = -near.dot(d) / dd;
        let near = near + d * correction;
        let distance = near.length_squared().sqrt();
        let squared = (radius - distance) * (radius + distance);
        let doubtful = (radius - distance).abs().simd_le(o.magnitude() * (8.0 * f64::EPSILON)) & active;
        let meets = active & !squared.simd_lt(0.0);
        if !(meets | doubtful).any_true() {
            return None;
        }
        let half = (squared / dd).sqrt();
        let t = [k + (correction - half), k + (correction + half)];
        let crossings = Crossings { d, near, offsets: [-half, half], t, middle: k + correction };
        Some(Meet { crossings, meets, doubtful })
    }

    /// As [`super::Disk::meet`], for disks of these outer and inner radii. `None` where no line meets its own.
    #[inline(always)]
    fn disks([outer, inner]: [f64x8<S>; 2], rays: &ShapeRays<S>) -> Option<Self> {
        let ShapeRays { o, d, t_max, leaving, active } = *rays;
        let t = -o.z / d.z;
        let is_ahead = active & t.simd_gt(0.0) & t.simd_le(t_max) & !leaving;
        if !is_ahead.any_true() {
            return None;
        }
        let near = fused(o, d, t);
        let offset = -(near.z / d.z);
        let p = near + d * offset;
        let (squared, outer, inner) = (p.x * p.x + p.y * p.y, outer * outer, inner * inner);
        // Farther from both rims than a ray alone must be.
        let is_clear =
            (squared - outer).abs().simd_gt(outer * 1e-13) & (squared - inner).abs().simd_ge(inner * 1e-13);
        let meets = is_ahead & squared.simd_le(outer) & squared.simd_ge(inner);
        let never = f64x8::splat(t.token(), f64::NAN);
        let middle = f64x8::splat(t.token(), f64::NEG_INFINITY);
        let crossings = Crossings { d, near, offsets: [offset; 2], t: [t, never], middle };
        Some(Meet { crossings, meets, doubtful: is_ahead & !is_clear })
    }

    /// As [`super::profile::Profile::meet`], for profiles with these numbers. `None` where no line meets its own. The middle is found only if
    /// it is needed.
    #[inline(always)]
    fn profiles(numbers: &ProfileNumbers<f64x8<S>>, rays: &ShapeRays<S>, needs_middle: bool) -> Option<Self> {
        let ShapeRays { o, d, active, .. } = *rays;
        let [w, .., reach_squared] = *numbers;
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        let near = fused(o, d, k);
        let beside = near.dot(d);
        let is_far = ((near.length_squared() - reach_squared) * dd).simd_gt(beside * beside);
        let is_near = active & !is_far;
        if !is_near.any_true() {
            return None;
        }
        let (Equation { alpha, beta, gamma, margin }, size) = Equation::new(numbers, near, d);
        let is_safe = margin.abs().simd_gt(size * DOUBT);
        let (meets, unsure) = (is_near & margin.simd_ge(0.0), is_near & !is_safe);
        if !(meets | unsure).any_true() {
            return None;
        }
        let root = (w * margin).sqrt();
        let q = -(beta + root.copysign(beta));
        let (a, b) = (q / alpha, gamma / q);
        let offsets = [a.min(b), a.max(b)];
        let doubtful = unsure | (meets & !(a - b).is_finite());
        let needs_middle = needs_middle || rays.leaving.any_true();
        let middle = if needs_middle { k + -beta / alpha } else { k };
        let crossings = Crossings { d, near, offsets, t: [k + offsets[0], k + offsets[1]], middle };
        Some(Meet { crossings, meets, doubtful })
    }

    /// As [`Crossings::first`], for forms of these radii. `has`: which of points of the forms their parts have, and which are doubtful.
    #[inline(always)]
    fn first(
        &self,
        radius: f64x8<S>,
        rays: &ShapeRays<S>,
        has: impl Fn(Vec3x8<S>, mask64x8<S>) -> (mask64x8<S>, mask64x8<S>),
    ) -> ShapeHits<S> {
        let Crossings { d, near, offsets, t, middle } = self.crossings;
        let ShapeRays { t_max, leaving, .. } = *rays;
        let meets = self.meets;
        let is_first = meets & t[0].simd_gt(0.0) & t[0].simd_le(t_max) & !leaving;
        let is_second = meets & t[1].simd_gt(0.0) & t[1].simd_le(t_max) & !(leaving & middle.simd_le(0.0));
        let (is_first, first_doubt) = has(near + d * offsets[0], is_first);
        let (is_second, second_doubt) = has(near + d * offsets[1], is_second);
        let doubtful = self.doubtful | first_doubt | second_doubt;
        let met = is_first | is_second;
        let t = is_first.select(t[0], t[1]);
        // Such rays may leave their shapes.
        let is_at_origin = met & !leaving & (t * t * d.length_squared()).simd_le(AT_ORIGIN * radius * radius);
        ShapeHits { met, t, doubtful: doubtful | is_at_origin }
    }
}

/// The points at `k` of lines, as exact as double-double numbers; only with fused operations.
#[inline(always)]
fn fused<S: Simd>(o: Vec3x8<S>, d: Vec3x8<S>, k: f64x8<S>) -> Vec3x8<S> {
    V3 { x: fused_along(o.x, d.x, k), y: fused_along(o.y, d.y, k), z: fused_along(o.z, d.z, k) }
}

/// As `TwoFloat::new_mul(d, k) + o`.
#[inline(always)]
fn fused_along<S: Simd>(o: f64x8<S>, d: f64x8<S>, k: f64x8<S>) -> f64x8<S> {
    let product = d * k;
    let rest = d.mul_sub(k, product);
    let sum = product + o;
    let a = sum - o;
    let b = sum - a;
    sum + (rest + ((product - a) + (o - b)))
}
