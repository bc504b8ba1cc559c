//! Segments of curves in their places.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use lookat_scene::Transform;

use super::approach::{approach, falls};
use super::bezier::{Points, View, evaluate, subcurve};
use super::capsule::Capsule;
use crate::number::{V3, largest_stretch};
use crate::ray::Ray;
use crate::real::Real;

/// A segment of a curve. Its own space is that of the object, about the first point of the curve.
pub(super) struct Segment {
    /// The index of the curve.
    pub curve: u32,
    /// Its number in the curve.
    pub number: u32,
    pub world_from_object: Arc<Transform>,
    /// The origin of its own space, relative to the origin of the world.
    pub anchor: DVec3,
    /// In its own space.
    pub points: Points<f64>,
    pub widths: Widths<f64>,
    pub is_ribbon: bool,
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
    pub fn part(&self, range: [f64; 2]) -> Part {
        Part { range, points: subcurve(&self.points, range) }
    }

    #[inline(always)]
    pub fn object_from_world(&self) -> &DMat3 {
        self.world_from_object.inverse_linear()
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

    /// The place that is nearest to the start of the ray of a view.
    pub fn nearest(&self, view: &View<f64>) -> f64 {
        let seen = view.see_all(self.points);
        let distance = |u: f64| evaluate(&seen, u)[0].length_squared();
        let mut nearest = if distance(0.0) <= distance(1.0) { 0.0 } else { 1.0 };
        falls(&approach(&seen), &mut |u| {
            if distance(u) < distance(nearest) {
                nearest = u;
            }
        });
        nearest
    }
}
