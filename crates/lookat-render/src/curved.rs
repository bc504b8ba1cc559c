//! Curved shapes in their places: what rays meet of them, and points of them.

mod part;
mod profile;
mod quadric;
pub(crate) mod side_by_side;
mod sphere;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3};
use lookat_scene::{Quadric, QuadricForm};

use crate::curved::part::{Part, Sweep};
use crate::curved::profile::Crossings;
use crate::curved::quadric::{Disk, Paraboloid, TurnedSegment};
use crate::curved::side_by_side::FormNumbers;
use crate::number::{V3, Vec2x8, Vec3x8, largest_stretch, power_of_two, prefetch, vectorized};
use crate::parametric::Parametric;
use crate::ray::Ray;
use crate::real::Real;
pub(crate) use sphere::Sphere;

/// A curved shape in its place, relative to the origin.
///
/// Its own space is object space, moved along z to the middle of the form, and scaled by a power of two that brings the
/// size of the form to about one, so that products of its measures are finite.
#[derive(Debug, Clone)]
pub(crate) struct Curved {
    form: UnitShape,
    /// The origin of its own space.
    pub center: DVec3,
    /// Takes offsets from the center to its own space.
    pub own_from_world: DMat3,
    /// The largest distance from the axis, in its own space.
    radius: f64,
    /// The length of 1 of its own space, in object space.
    unit: f64,
    /// For tests of eight rays. `None` for whole spheres.
    numbers: Option<Box<FormNumbers>>,
    /// Has what is rarely needed.
    quadric: Arc<Quadric>,
}

/// The largest squared distance, relative to the squared radius, at which a hit may be the origin of its ray.
pub(crate) const AT_ORIGIN: f64 = f64::EPSILON;

/// A bound of the rounding error of a coordinate, relative to half of its size.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The shape in its own space. Spheres, of which scenes have many, are small.
#[derive(Debug, Clone)]
enum UnitShape {
    Sphere(Sphere),
    Disk(Box<Disk>),
    TurnedSegment(Box<TurnedSegment>),
    Paraboloid(Box<Paraboloid>),
}

impl Curved {
    pub fn new(quadric: &Arc<Quadric>, origin: DVec3) -> Self {
        let transform = &quadric.world_from_object;
        let (m, (low, high, radius)) = (transform.matrix(), quadric.extent());
        let half_height = 0.5 * (high - low);
        let middle = low + half_height;
        let unit = match quadric.form {
            QuadricForm::Sphere(_) => 1.0,
            _ => power_of_two(radius.max(half_height)),
        };
        let form = UnitShape::new(quadric, middle, unit);
        Curved {
            numbers: side_by_side::numbers_of(&form, radius / unit),
            form,
            center: m.w_axis.truncate() - origin + m.z_axis.truncate() * middle,
            own_from_world: *transform.inverse_linear() * unit.recip(),
            radius: radius / unit,
            unit,
            quadric: quadric.clone(),
        }
    }

    /// The transformation from its own space to the world.
    #[inline]
    pub fn world_from_own(&self) -> DMat3 {
        *self.quadric.world_from_object.linear() * self.unit
    }

    /// Half the extent of the uncut form along each axis of the world.
    pub fn half_extent(&self) -> DVec3 {
        let rows = self.world_from_own().transpose();
        let (low, high, _) = self.quadric.extent();
        let half_height = 0.5 * (high - low) / self.unit;
        let along = |row: DVec3| match self.form {
            UnitShape::Sphere(_) => row.length() * self.radius,
            _ => row.truncate().length() * self.radius + row.z.abs() * half_height,
        };
        DVec3::new(along(rows.x_axis), along(rows.y_axis), along(rows.z_axis))
    }

    /// The largest coordinate of the box around it.
    pub fn magnitude(&self) -> f64 {
        (self.center.abs() + self.half_extent()).max_element()
    }

    /// The radius of a ball around the center that holds the uncut form, in the world.
    pub fn bounding_radius(&self) -> f64 {
        let (low, high, _) = self.quadric.extent();
        let own = match self.form {
            UnitShape::Sphere(_) => self.radius,
            _ => libm::hypot(self.radius, 0.5 * (high - low) / self.unit),
        };
        own * largest_stretch(&self.world_from_own())
    }

    /// The sphere that it is.
    pub fn as_sphere(&self) -> Option<&Sphere> {
        match &self.form {
            UnitShape::Sphere(sphere) => Some(sphere),
            _ => None,
        }
    }

    /// The radius if this is a whole sphere in the world.
    pub fn whole_sphere(&self) -> Option<f64> {
        self.as_sphere().filter(|sphere| sphere.is_whole())?.world_radius
    }

    /// The axes of a whole disk in the world, the last one its normal, and its radius; if it is a circle there.
    pub fn whole_disk(&self) -> Option<([DVec3; 3], f64)> {
        let UnitShape::Disk(disk) = &self.form else { return None };
        let [x, y] = [DVec3::X, DVec3::Y].map(|axis| self.world_from_own() * axis);
        let scale = x.length();
        let is_round = (y.length() / scale - 1.0).abs() < 1e-12 && (x.dot(y) / (scale * scale)).abs() < 1e-12;
        let n = self.placed(DVec3::ZERO).1;
        let x = x / scale;
        Some(([x, n.cross(x), n], disk.whole()? * scale)).filter(|_| is_round)
    }

    /// The nearest distance at which the ray meets the shape, more than 0 and at most `t_max`.
    ///
    /// A line meets a curved form twice at most. Of a ray that leaves the shape, one of the two is where it starts, and
    /// does not count; the other one lies at twice the distance of their middle.
    ///
    /// A ray that starts on the shape, as far as rounding can tell, leaves it too.
    pub fn intersect(&self, ray: &Ray, t_max: f64, leaving: bool) -> Option<f64> {
        let (o, d) = self.own_ray(ray);
        let intersect = |leaving| match &self.form {
            UnitShape::Sphere(sphere) if sphere.is_whole() => {
                sphere.meet(o, d)?.first(t_max, leaving, |_| true)
            }
            other => other.intersect(o, d, t_max, leaving),
        };
        let t = intersect(leaving)?;
        let starts_here = !leaving
            && t * t * d.length_squared() <= AT_ORIGIN * self.radius * self.radius
            && self.holds(ray.o, DVec3::ZERO);
        self.prefetch_place();
        if starts_here { intersect(true) } else { Some(t) }
    }

    /// Asks for the memory that the place of a hit will need.
    #[inline(always)]
    pub fn prefetch_place(&self) {
        prefetch(self.quadric.world_from_object.linear(), 0..2);
    }

    /// True if a shadow ray to a point light, which meets the shape, does so nowhere but at the light.
    pub fn is_met_at_end(&self, ray: &Ray, leaving: bool) -> bool {
        let end = ray.end();
        self.holds(end, (end - ray.o).abs())
            && (leaving || {
                let back = Ray { o: end, d: -ray.d, ..*ray };
                self.intersect(&back, ray.t_max, true).is_none()
            })
    }

    /// True if a point lies on the uncut shape within the rounding errors of its coordinates.
    /// `spread`: what the point was computed from, along each axis.
    #[cold]
    fn holds(&self, p: DVec3, spread: DVec3) -> bool {
        let offset = p - self.center;
        let m = &self.own_from_world;
        let own = *m * offset;
        let size = own.abs()
            + DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs()) * (offset.abs() + spread);
        let gradient = DVec3::from(self.form.gradient(V3::from(own)));
        self.form.value(own).abs() <= ROUNDING * gradient.abs().dot(size)
    }

    /// True if the end of the ray, a point of the shape, lies behind another part of it. `leaving`: the ray leaves the shape.
    pub fn hides_end_of(&self, ray: &Ray, leaving: bool) -> bool {
        let (o, d) = self.own_ray(ray);
        let middle = self.form.meet(o, d).map(|line| line.middle);
        middle.is_some_and(|middle| ray.t_max > middle && self.intersect(ray, middle, leaving).is_some())
    }

    fn own_ray(&self, ray: &Ray) -> (DVec3, DVec3) {
        (self.own_from_world * (ray.o - self.center), self.own_from_world * ray.d)
    }

    /// The point of the shape nearest to `p`, which must be near it, and the unit normal there, as pbrt-v3 has it before
    /// it flips it; in the world.
    pub fn project(&self, p: DVec3) -> (DVec3, DVec3) {
        self.placed(self.own_point(p))
    }

    /// As [`Curved::project`], of eight points, to the bit.
    #[inline(always)]
    pub fn project_all<S: Simd>(&self, p: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
        match self.form {
            UnitShape::Sphere(_) => self.placed_near(p),
            _ => self.project_others(p),
        }
    }

    /// Out of line: spheres are not to pay for the others.
    #[inline(never)]
    fn project_others<S: Simd>(&self, p: Vec3x8<S>) -> (Vec3x8<S>, Vec3x8<S>) {
        vectorized!(p.x.token(), self.placed_near(p))
    }

    #[inline(always)]
    fn placed_near<T: Real>(&self, p: V3<T>) -> (V3<T>, V3<T>) {
        self.placed_of(self.own_of(p))
    }

    /// Position and unit normal of a point of its own space that is on the shape.
    pub fn placed(&self, own: DVec3) -> (DVec3, DVec3) {
        let (p, n) = self.placed_of(V3::from(own));
        (p.into(), n.into())
    }

    #[inline(always)]
    fn placed_of<T: Real>(&self, own: V3<T>) -> (V3<T>, V3<T>) {
        let normal = self.form.gradient(own).by(&self.own_from_world.transpose());
        (own.by(&self.world_from_own()).moved_by(self.center), T::normalize(normal))
    }

    /// The point of the shape nearest to a point of the world that is near it; in its own space.
    fn own_point(&self, p: DVec3) -> DVec3 {
        self.own_of(V3::from(p)).into()
    }

    #[inline(always)]
    fn own_of<T: Real>(&self, p: V3<T>) -> V3<T> {
        let own = p.moved_by(-self.center).by(&self.own_from_world);
        match &self.form {
            UnitShape::Sphere(sphere) => T::normalize(own) * own.x.same(sphere.radius),
            UnitShape::Disk(_) => V3 { z: own.z.same(0.0), ..own },
            UnitShape::TurnedSegment(segment) => profile::project(
                own,
                #[inline(always)]
                |p| (segment.value(p), segment.gradient(p)),
            ),
            UnitShape::Paraboloid(paraboloid) => profile::project(
                own,
                #[inline(always)]
                |p| (paraboloid.value(p), paraboloid.gradient(p)),
            ),
        }
    }

    /// The parametric derivatives at the point of the surface nearest to `p`.
    pub fn parametric(&self, p: DVec3) -> Parametric {
        let own = self.own_point(p);
        let local = match &self.form {
            UnitShape::Sphere(sphere) => sphere.parametric(own),
            UnitShape::Disk(disk) => disk.parametric(own),
            UnitShape::TurnedSegment(segment) => segment.parametric(own),
            UnitShape::Paraboloid(paraboloid) => paraboloid.parametric(own),
        };
        local.placed(self.world_from_own(), self.own_from_world.transpose() * self.unit)
    }

    /// A point of the shape for one of the unit square; in its own space. Spheres are sampled by their light.
    pub fn sample(&self, u: DVec2) -> DVec3 {
        match &self.form {
            UnitShape::Sphere(sphere) => sphere.sample(u),
            UnitShape::Disk(disk) => disk.sample(u),
            UnitShape::TurnedSegment(segment) => segment.sample(u),
            UnitShape::Paraboloid(paraboloid) => paraboloid.sample(u),
        }
    }

    /// The ratio of a small area of the shape at `p`, in the world, to the area of the unit square that [`Curved::sample`]
    /// maps to it: the inverse of the density by area.
    pub fn stretch(&self, p: DVec3) -> f64 {
        self.own_stretch(V3::from(self.own_from_world * (p - self.center)))
    }

    #[inline(always)]
    fn own_stretch<T: Real>(&self, own: V3<T>) -> T {
        let area = match &self.form {
            UnitShape::Sphere(sphere) => own.x.same(sphere.area()),
            UnitShape::Disk(disk) => own.x.same(disk.area()),
            UnitShape::TurnedSegment(segment) => own.z.each(|z| segment.stretch(z)),
            UnitShape::Paraboloid(paraboloid) => own.z.each(|z| paraboloid.stretch(z)),
        };
        // The cofactors of the transformation, applied to the normal.
        let normal = T::normalize(self.form.gradient(own)).by(&self.own_from_world.transpose());
        area * self.world_from_own().determinant().abs() * normal.length_squared().sqrt()
    }

    /// Eight points of the shape for some of the unit square, their normals, and the stretches there: [`Curved::sample`],
    /// [`Curved::placed`] and [`Curved::stretch`].
    #[inline(always)]
    pub fn sample_all<S: Simd>(&self, [u, v]: Vec2x8<S>) -> (Vec3x8<S>, Vec3x8<S>, f64x8<S>) {
        let mut own = Vec3x8::splat(u.token(), DVec3::ZERO);
        for (lane, (u, v)) in u.as_slice().iter().zip(v.as_slice()).enumerate() {
            own.set_lane(lane, self.sample(DVec2::new(*u, *v)));
        }
        let (p, n) = self.placed_of(own);
        (p, n, self.own_stretch(p.moved_by(-self.center).by(&self.own_from_world)))
    }

    /// A grid over the shape: of each cell a point, the normal there, as [`Curved::project`] has it, and the area, about.
    pub fn cells(&self) -> impl Iterator<Item = (DVec3, DVec3, f64)> {
        const SIDE: u32 = 16;
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
        (0..SIDE * SIDE).map(move |i| {
            let own = self.sample(DVec2::new(middle(i % SIDE), middle(i / SIDE)));
            let (p, n) = self.placed(own);
            (p, n, self.own_stretch(V3::from(own)) / f64::from(SIDE * SIDE))
        })
    }
}

impl UnitShape {
    fn new(quadric: &Quadric, middle: f64, unit: f64) -> UnitShape {
        let sweep = Sweep::new(quadric.phi_max);
        let segment = |p1: DVec3, p2: DVec3| {
            let own = |p: DVec3| (p - DVec3::Z * middle) / unit;
            UnitShape::TurnedSegment(Box::new(TurnedSegment::new([own(p1), own(p2)], sweep)))
        };
        match quadric.form {
            QuadricForm::Sphere(sphere) => {
                UnitShape::Sphere(Sphere::new(sphere, sweep, quadric.world_from_object.linear()))
            }
            QuadricForm::Disk(disk) => {
                UnitShape::Disk(Box::new(Disk::new(disk.radius / unit, disk.inner_radius / unit, sweep)))
            }
            QuadricForm::Cylinder(form) => {
                segment(DVec3::new(form.radius, 0.0, form.z_min), DVec3::new(form.radius, 0.0, form.z_max))
            }
            QuadricForm::Cone(form) => {
                segment(DVec3::new(form.radius, 0.0, 0.0), DVec3::new(0.0, 0.0, form.height))
            }
            QuadricForm::Hyperboloid(ref form) => segment(form.p1, form.p2),
            QuadricForm::Paraboloid(form) => {
                UnitShape::Paraboloid(Box::new(Paraboloid::new(&form, middle, unit, sweep)))
            }
        }
    }

    /// Out of line: whole spheres, of which scenes have many, are not to pay for the others.
    #[inline(never)]
    fn intersect(&self, o: DVec3, d: DVec3, t_max: f64, leaving: bool) -> Option<f64> {
        self.meet(o, d)?.first(t_max, leaving, |p| self.part().is_none_or(|part| part.has(p)))
    }

    /// Where a line meets the uncut form.
    fn meet(&self, o: DVec3, d: DVec3) -> Option<Crossings> {
        match self {
            UnitShape::Sphere(sphere) => sphere.meet(o, d),
            UnitShape::Disk(disk) => disk.meet(o, d),
            UnitShape::TurnedSegment(segment) => segment.profile.meet(o, d),
            UnitShape::Paraboloid(paraboloid) => paraboloid.profile.meet(o, d),
        }
    }

    /// The part that there is; `None` of a whole sphere.
    fn part(&self) -> Option<Part> {
        match self {
            UnitShape::Sphere(sphere) => sphere.part(),
            UnitShape::Disk(disk) => Some(disk.part),
            UnitShape::TurnedSegment(segment) => Some(segment.part),
            UnitShape::Paraboloid(paraboloid) => Some(paraboloid.part),
        }
    }

    /// A function that is 0 on the uncut form.
    fn value(&self, p: DVec3) -> f64 {
        match self {
            UnitShape::Sphere(sphere) => p.length_squared() - sphere.radius * sphere.radius,
            UnitShape::Disk(_) => p.z,
            UnitShape::TurnedSegment(segment) => segment.value(V3::from(p)),
            UnitShape::Paraboloid(paraboloid) => paraboloid.value(V3::from(p)),
        }
    }

    /// In the direction of the normal, half the gradient of that, or more; at the tip of a cone zero.
    #[inline(always)]
    fn gradient<T: Real>(&self, p: V3<T>) -> V3<T> {
        match self {
            UnitShape::Sphere(_) => p,
            UnitShape::Disk(_) => V3 { x: p.x.same(0.0), y: p.x.same(0.0), z: p.x.same(1.0) },
            UnitShape::TurnedSegment(segment) => segment.gradient(p),
            UnitShape::Paraboloid(paraboloid) => paraboloid.gradient(p),
        }
    }
}
