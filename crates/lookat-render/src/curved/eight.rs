//! Eight rays against curved shapes: all against one, or each against its own.

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};

use super::part::{Part, PartNumbers, have};
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
pub(crate) type FormNumbers<T> = [T; 16];

/// Possible hits of rays on curved shapes.
pub(crate) struct Meetings<S: Simd> {
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
    /// Rays of the world in the space of a shape.
    #[inline(always)]
    fn in_space_of(&self, curved: &Curved) -> Self {
        let (o, d) = (self.o.moved_by(-curved.center), self.d);
        ShapeRays { o: o.by(&curved.own_from_world), d: d.by(&curved.own_from_world), ..*self }
    }

    /// The hits of rays in the spaces of their shapes, whole spheres of these radii, with the bits of [`Curved::intersect`].
    #[inline(always)]
    pub fn meet_whole_spheres(&self, radius: f64x8<S>) -> Meetings<S> {
        let (crossings, meets, doubtful) = Crossings8::of_spheres(radius, (self.o, self.d), self.active);
        if !(meets | doubtful).any_true() {
            return Meetings { met: meets, t: self.t_max, doubtful };
        }
        let found = crossings.first_of(meets, (radius, None), self.t_max, self.leaving);
        Meetings { doubtful: found.doubtful | doubtful, ..found }
    }

    /// The hits of rays in the spaces of their shapes, of a kind, with the bits of [`Curved::intersect`]. `ends_at_middle`: only those before the middle of both places
    /// where the line meets the form count.
    #[inline(never)]
    pub fn meet(&self, kind: Kind, numbers: &FormNumbers<f64x8<S>>, ends_at_middle: bool) -> Meetings<S> {
        let ShapeRays { o, d, t_max, leaving, active } = *self;
        let none = active & !active;
        // Others have no fused operations, or need more code for this than fits their caches.
        if !has_compress(active.token()) {
            return Meetings { met: none, t: t_max, doubtful: active };
        }
        vectorized!(active.token(), {
            let [radius, part @ .., a, b, c, e, f, g] = numbers;
            let (crossings, meets, doubtful) = match kind {
                Kind::WholeSphere | Kind::PartialSphere => Crossings8::of_spheres(*radius, (o, d), active),
                Kind::Disk => Crossings8::of_disks([*a, *b], (o, d), active),
                Kind::Profile => Crossings8::of_profiles(&[*a, *b, *c, *e, *f, *g], (o, d), active),
            };
            if !(meets | doubtful).any_true() {
                return Meetings { met: meets, t: t_max, doubtful };
            }
            let mut t_max = t_max;
            if ends_at_middle {
                t_max =
                    t_max.simd_gt(crossings.middle).select(crossings.middle, 0.0.simd_into(t_max.token()));
            }
            let found = crossings.first_of(meets, (*radius, Some(part)), t_max, leaving);
            Meetings { doubtful: found.doubtful | doubtful, ..found }
        })
    }
}

/// The numbers of shapes, one for each lane.
#[inline(always)]
pub(crate) fn gather<S: Simd>(simd: S, shapes: &[&Curved]) -> FormNumbers<f64x8<S>> {
    let mut columns = [[1.0; LANES]; 16];
    for (lane, shape) in shapes.iter().enumerate().take(LANES) {
        for (column, x) in columns.iter_mut().zip(shape.numbers()) {
            column[lane] = x;
        }
    }
    columns.map(
        #[inline(always)]
        |column| column.simd_into(simd),
    )
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

    /// What [`ShapeRays::meet`] needs to know of the form.
    pub fn numbers(&self) -> FormNumbers<f64> {
        let mut numbers = [self.radius; 16];
        numbers[1..10].copy_from_slice(&self.form.part().unwrap_or(Part::WHOLE).numbers());
        match &self.form {
            UnitShape::Sphere(_) => {}
            UnitShape::Disk(disk) => numbers[10..12].copy_from_slice(&disk.numbers()),
            UnitShape::TurnedSegment(segment) => numbers[10..].copy_from_slice(&segment.profile.numbers()),
            UnitShape::Paraboloid(paraboloid) => numbers[10..].copy_from_slice(&paraboloid.profile.numbers()),
        }
        numbers
    }

    /// The hits of eight rays, whose origins and directions are in the world, with the bits of [`Curved::intersect`].
    #[inline(always)]
    pub fn meet<S: Simd>(&self, rays: &ShapeRays<S>) -> Meetings<S> {
        let own = rays.in_space_of(self);
        match self.kind() {
            Kind::WholeSphere => own.meet_whole_spheres(self.radius.simd_into(own.t_max.token())),
            _ => self.meet_own(&own, false),
        }
    }

    /// The active rays of the world whose ends, points of the shape, lie behind another part of it. As [`Curved::hides_end_of`].
    #[inline(always)]
    pub fn hides_ends_of<S: Simd>(&self, rays: &ShapeRays<S>) -> mask64x8<S> {
        let Meetings { met, doubtful, .. } = self.meet_own(&rays.in_space_of(self), true);
        let mut hidden = met & !doubtful;
        for lane in set_lanes(doubtful) {
            let ray = Ray { t_max: rays.t_max[lane], ..Ray::new(rays.o.lane(lane), rays.d.lane(lane)) };
            let is_hidden = self.hides_end_of(&ray, rays.leaving.to_bitmask() >> lane & 1 == 1);
            hidden |= bits(met.token(), u64::from(is_hidden) << lane);
        }
        hidden
    }

    /// The hits of rays in the space of the shape: see [`ShapeRays::meet`].
    #[inline(never)]
    fn meet_own<S: Simd>(&self, own: &ShapeRays<S>, ends_at_middle: bool) -> Meetings<S> {
        let simd = own.t_max.token();
        vectorized!(simd, {
            let numbers = self.numbers();
            let mut splat = [own.t_max; 16];
            for (all, x) in splat.iter_mut().zip(numbers) {
                *all = x.simd_into(simd);
            }
            own.meet(self.kind(), &splat, ends_at_middle)
        })
    }
}

/// Where eight lines meet forms.
type Crossings8<S> = Crossings<Vec3x8<S>, f64x8<S>>;

impl<S: Simd> Crossings8<S> {
    /// As [`super::Sphere::meet`], for spheres of these radii. Also returns which lines meet theirs, and which of all are doubtful.
    #[inline(always)]
    fn of_spheres(
        radius: f64x8<S>,
        (o, d): (Vec3x8<S>, Vec3x8<S>),
        active: mask64x8<S>,
    ) -> (Self, mask64x8<S>, mask64x8<S>) {
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        let near = o + d * k;
        let correction = -near.dot(d) / dd;
        let near = near + d * correction;
        let distance = near.length_squared().sqrt();
        let squared = (radius - distance) * (radius + distance);
        let doubtful = (radius - distance).abs().simd_le(o.magnitude() * (8.0 * f64::EPSILON)) & active;
        let met = active & !squared.simd_lt(0.0);
        let half = (squared / dd).sqrt();
        let t = [k + (correction - half), k + (correction + half)];
        (Crossings { d, near, offsets: [-half, half], t, middle: k + correction }, met, doubtful)
    }

    /// As [`super::Disk::meet`], for disks with these radii. Also returns which lines meet theirs, and which of all are doubtful.
    #[inline(always)]
    fn of_disks(
        [outer, inner]: [f64x8<S>; 2],
        (o, d): (Vec3x8<S>, Vec3x8<S>),
        active: mask64x8<S>,
    ) -> (Self, mask64x8<S>, mask64x8<S>) {
        let t = -o.z / d.z;
        let near = fused(o, d, t);
        let offset = -(near.z / d.z);
        let p = near + d * offset;
        let r = (p.x * p.x + p.y * p.y).sqrt();
        let is_ahead = active & t.simd_gt(0.0);
        let (at_rim, at_hole) = ((r - outer).abs(), (r - inner).abs());
        let is_clear = at_rim.simd_gt(outer * 1e-14) & (at_hole.simd_gt(inner * 1e-14) | inner.simd_eq(0.0));
        let meets = is_ahead & r.simd_le(outer) & r.simd_ge(inner);
        let none = f64x8::splat(active.token(), f64::NAN);
        let middle = f64x8::splat(active.token(), f64::NEG_INFINITY);
        let crossings = Crossings { d, near, offsets: [offset; 2], t: [t, none], middle };
        (crossings, meets, is_ahead & !is_clear)
    }

    /// As [`super::profile::Profile::meet`], for profiles with these numbers. Also returns which lines meet theirs, and which of these are doubtful.
    #[inline(always)]
    fn of_profiles(
        numbers: &ProfileNumbers<f64x8<S>>,
        (o, d): (Vec3x8<S>, Vec3x8<S>),
        active: mask64x8<S>,
    ) -> (Self, mask64x8<S>, mask64x8<S>) {
        let [w, .., reach_squared] = *numbers;
        let dd = d.length_squared();
        let k = -o.dot(d) / dd;
        let near = fused(o, d, k);
        let beside = near.dot(d);
        let is_near = active & !(near.length_squared() - beside * beside / dd).simd_gt(reach_squared);
        let (Equation { alpha, beta, gamma, margin }, size) = Equation::new(numbers, near, d);
        let is_safe = margin.abs().simd_gt(size * DOUBT);
        let root = (w * margin).sqrt();
        let q = -(beta + root.copysign(beta));
        let (a, b) = (q / alpha, gamma / q);
        let offsets = [a.min(b), a.max(b)];
        let meets = is_near & margin.simd_ge(0.0);
        let doubtful = is_near & (!is_safe | (meets & !(a - b).is_finite()));
        let t = [k + offsets[0], k + offsets[1]];
        (Crossings { d, near, offsets, t, middle: k + -beta / alpha }, meets, doubtful)
    }

    /// As [`Crossings::first`], for lines that meet forms of these radii. `part`: of forms that are cut.
    #[inline(always)]
    fn first_of(
        &self,
        meets: mask64x8<S>,
        (radius, part): (f64x8<S>, Option<&PartNumbers<f64x8<S>>>),
        t_max: f64x8<S>,
        leaving: mask64x8<S>,
    ) -> Meetings<S> {
        let Crossings { d, near, offsets, t, middle } = *self;
        let mut is_first = meets & t[0].simd_gt(0.0) & t[0].simd_le(t_max) & !leaving;
        let mut is_second =
            meets & t[1].simd_gt(0.0) & t[1].simd_le(t_max) & !(leaving & middle.simd_le(0.0));
        let mut doubtful = meets & !meets;
        if let Some(part) = part {
            let (first, first_doubt) = have(part, near + d * offsets[0], is_first);
            let (second, second_doubt) = have(part, near + d * offsets[1], is_second);
            (is_first, is_second) = (first, second);
            doubtful = first_doubt | second_doubt;
        }
        let met = is_first | is_second;
        let t = is_first.select(t[0], t[1]);
        // Such rays may leave their shapes.
        let is_at_origin = met & !leaving & (t * t * d.length_squared()).simd_le(AT_ORIGIN * radius * radius);
        Meetings { met, t, doubtful: doubtful | is_at_origin }
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
