//! Segments of curves in their places.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use lookat_scene::{CurveKind, Transform};

use super::approach::{approach, falls};
use super::bezier::{Points, View, evaluate, subcurve};
use super::capsule::Capsule;
use crate::number::{V3, largest_stretch};
use crate::ray::Ray;
use crate::real::Real;
use crate::warp::at_angle;

/// A segment of a curve. Its own space is that of the object, about the first point of the curve.
pub(super) struct Segment {
    /// Its number in the curve, and the number of the last one. Segments of a curve are one after another.
    pub number: u32,
    pub last: u32,
    pub world_from_object: Arc<Transform>,
    /// The origin of its own space, relative to the origin of the world.
    pub anchor: DVec3,
    /// In its own space.
    pub points: Points<f64>,
    pub widths: Widths<f64>,
    pub cross_section: CrossSection,
}

/// See [`lookat_scene::CurveKind`].
pub(super) enum CrossSection {
    Flat,
    Cylinder,
    /// With the unit normals at both ends of the segment.
    Ribbon(Box<[DVec3; 2]>),
}

impl CrossSection {
    /// Of a segment with a number.
    pub fn new(kind: &CurveKind, number: u32) -> Self {
        match kind {
            CurveKind::Flat => CrossSection::Flat,
            CurveKind::Cylinder => CrossSection::Cylinder,
            CurveKind::Ribbon(normals) => {
                let normal = |at: u32| normals.get(at as usize).copied().unwrap_or(DVec3::Z);
                CrossSection::Ribbon(Box::new([normal(number), normal(number + 1)]))
            }
        }
    }
}

/// The widths at both ends of a segment, in object space.
pub(super) struct Widths<T>(pub [T; 2]);

impl<T: Real> Widths<T> {
    #[inline(always)]
    pub fn at(&self, u: T) -> T {
        let [first, last] = self.0;
        first + (last - first) * u
    }

    /// The larger of the widths at both ends of a part.
    #[inline(always)]
    pub fn widest(&self, [from, to]: [T; 2]) -> T {
        self.at(from).max(self.at(to))
    }
}

/// A part of a segment: its first and last parameter, and its control points in the space of the segment.
pub(super) struct Part {
    pub range: [f64; 2],
    pub points: Points<f64>,
}

impl Segment {
    #[inline(always)]
    pub fn part(&self, range: [f64; 2]) -> Part {
        Part { range, points: subcurve(&self.points, range) }
    }

    #[inline(always)]
    pub fn object_from_world(&self) -> &DMat3 {
        self.world_from_object.inverse_linear()
    }

    /// The share of the width that is seen from a direction: all, except of a ribbon.
    pub fn facing(&self, u: f64, direction: DVec3) -> f64 {
        match &self.cross_section {
            CrossSection::Flat | CrossSection::Cylinder => 1.0,
            CrossSection::Ribbon(normals) => ribbon_normal(normals, u).dot(direction).abs(),
        }
    }

    /// The change of the position with u and with v, in object space, as seen from a unit direction. That with v is as long
    /// as the curve is wide there.
    pub fn tangents(&self, direction: DVec3, uv: DVec2) -> [DVec3; 2] {
        let [_, dpdu] = evaluate(&self.points, uv.x);
        let dpdu = DVec3::from(dpdu);
        let across = match &self.cross_section {
            CrossSection::Flat => direction.cross(dpdu),
            CrossSection::Cylinder => {
                let axis = dpdu.normalize_or(DVec3::X);
                let (side, turn) = (direction.cross(dpdu), at_angle((0.5 - uv.y) * PI));
                side * turn.x + axis.cross(side) * turn.y
            }
            CrossSection::Ribbon(normals) => ribbon_normal(normals, uv.x).cross(dpdu),
        };
        let width = self.widths.at(uv.x) * self.facing(uv.x, direction);
        [dpdu, across.normalize_or(direction.any_orthonormal_vector()) * width]
    }

    /// The box around a part, relative to the origin of the world: all that is within half a width of it, in object space.
    pub fn corners(&self, part: &Part) -> [DVec3; 2] {
        let rows = self.world_from_object.linear().transpose();
        let round = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let half = round * (0.5 * self.widths.widest(part.range));
        let [a, b, c, d] = self.placed(&part.points).map(DVec3::from);
        [a.min(b).min(c).min(d) - half, a.max(b).max(c).max(d) + half]
    }

    /// Points, relative to the origin of the world.
    pub fn placed(&self, points: &Points<f64>) -> Points<f64> {
        points.map(|p| V3::from(self.anchor + *self.world_from_object.linear() * DVec3::from(p)))
    }

    /// A capsule that holds a part.
    pub fn capsule(&self, part: &Part) -> Capsule {
        let stretch = largest_stretch(self.world_from_object.linear());
        Capsule::around(&self.placed(&part.points), 0.5 * self.widths.widest(part.range) * stretch)
    }

    /// The view along a ray, with `along` about in the direction of x.
    pub fn view(&self, ray: &Ray, along: V3<f64>) -> View<f64> {
        let [o, d] = [ray.o - self.anchor, ray.d].map(|v| V3::from(*self.object_from_world() * v));
        let (view, is_possible) = View::new(o, d, along);
        if is_possible {
            view
        } else {
            View::new(o, d, DVec3::from(view.z).any_orthonormal_vector().into()).0
        }
    }

    /// The place in a range that is nearest to the start of the ray of a view.
    pub fn nearest(&self, range: [f64; 2], view: &View<f64>) -> f64 {
        let seen = view.see_all(self.part(range).points);
        let distance = |u: f64| evaluate(&seen, u)[0].length_squared();
        let mut nearest = if distance(0.0) <= distance(1.0) { 0.0 } else { 1.0 };
        falls(&approach(&seen), &mut |u| {
            if distance(u) < distance(nearest) {
                nearest = u;
            }
        });
        range[0] + (range[1] - range[0]) * nearest
    }
}

/// The normal of a ribbon at a place, turned evenly from one given normal to the next; as in pbrt-v3, which takes angles
/// above 90 degrees for 90.
fn ribbon_normal([from, to]: &[DVec3; 2], u: f64) -> DVec3 {
    let angle = libm::acos(from.dot(*to).clamp(0.0, 1.0));
    if angle < 1e-6 {
        return *from;
    }
    (*from * libm::sin((1.0 - u) * angle) + *to * libm::sin(u * angle)) / libm::sin(angle)
}
