//! Motion: transformations that change between a start time and an end time (PBR 2.9).

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::Transform;

/// The current transformation at the start time and at the end time.
#[derive(Debug, Clone)]
pub(crate) struct TransformSet {
    pub start: Arc<Transform>,
    pub end: Arc<Transform>,
}

impl TransformSet {
    /// The same transformation at both times.
    pub fn still(transform: Transform) -> Self {
        let start = Arc::new(transform);
        TransformSet { end: start.clone(), start }
    }

    /// True if the two transformations differ.
    pub fn is_animated(&self) -> bool {
        !Arc::ptr_eq(&self.start, &self.end) && self.start != self.end
    }

    pub fn inverse(&self) -> Self {
        self.map(|transform| transform.inverse())
    }

    /// Both transformations, changed in the same way.
    pub fn map(&self, change: impl Fn(&Transform) -> Transform) -> Self {
        let start = TransformSet::still(change(&self.start));
        if Arc::ptr_eq(&self.start, &self.end) {
            return start;
        }
        TransformSet { end: Arc::new(change(&self.end)), ..start }
    }
}

/// A transformation that moves from one place at the start time to another at the end time, as in pbrt: translation and scale change in
/// proportion to time, and rotation about one axis has a constant speed and takes the shorter way. Times are shares of the way from the
/// start time, 0, to the end time, 1; before and after, nothing moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnimatedTransform {
    start: Transform,
    end: Transform,
    /// The translation at the start, and what is added until the end.
    translation: [DVec3; 2],
    /// The rotation at the start, and its products with the matrix of the cross product with the axis, once and twice.
    rotation: [DMat3; 3],
    /// The angle of the rotation until the end, in radians.
    angle: f64,
    /// The scale at the start, a symmetric matrix, and what is added until the end.
    scale: [DMat3; 2],
}

/// One transformation mirrors and the other does not: on the way, everything would be flat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("one of the transformations mirrors, and the other does not")]
pub struct MirrorsOnTheWay;

/// The parts of the motion whose bounds are computed one by one.
const PARTS: u32 = 32;

impl AnimatedTransform {
    /// A motion between two transformations.
    pub fn new(start: Transform, end: Transform) -> Result<Self, MirrorsOnTheWay> {
        if start.swaps_handedness() != end.swaps_handedness() {
            return Err(MirrorsOnTheWay);
        }
        let (r0, s0) = polar(start.linear());
        let (r1, s1) = polar(end.linear());
        let (axis, angle) = axis_angle(r1 * r0.transpose());
        let cross = DMat3::from_cols(axis.cross(DVec3::X), axis.cross(DVec3::Y), axis.cross(DVec3::Z));
        let [t0, t1] = [start, end].map(|transform| transform.point(DVec3::ZERO));
        Ok(AnimatedTransform {
            start,
            end,
            translation: [t0, t1 - t0],
            rotation: [r0, cross * r0, cross * cross * r0],
            angle,
            scale: [s0, s1 - s0],
        })
    }

    /// No motion.
    pub fn still(transform: Transform) -> Self {
        AnimatedTransform::new(transform, transform).unwrap_or_else(|_| unreachable!("both are the same"))
    }

    /// The transformations at the start and at the end.
    pub fn ends(&self) -> [Transform; 2] {
        [self.start, self.end]
    }

    /// The transformation at a time.
    pub fn at(&self, time: f64) -> Transform {
        if time <= 0.0 {
            return self.start;
        }
        if time >= 1.0 {
            return self.end;
        }
        let (sin, cos) = libm::sincos(self.angle * time);
        let [r, along, back] = self.rotation;
        let linear = (r + along * sin + back * (1.0 - cos)) * (self.scale[0] + self.scale[1] * time);
        let translation = self.translation[0] + self.translation[1] * time;
        // It exists, as the scale stays definite between two such scales.
        let inverse = linear.inverse();
        Transform {
            m: DAffine3::from_mat3_translation(linear, translation),
            inv: DAffine3::from_mat3_translation(inverse, -(inverse * translation)),
        }
    }

    /// The lowest and the highest corner of a box around all places of a box, except for rounding.
    pub fn bounds(&self, [low, high]: [DVec3; 2]) -> [DVec3; 2] {
        let corners: [DVec3; 8] = std::array::from_fn(|at| {
            DVec3::new([low.x, high.x][at & 1], [low.y, high.y][at >> 1 & 1], [low.z, high.z][at >> 2])
        });
        // With v = S p, the second derivative of a point's place T + R v is at most angle^2 |v| + 2 angle |dv|. Between two times a
        // path is no farther from their chord than an eighth of that times the square of their distance.
        let parts = if self.angle == 0.0 { 1 } else { PARTS };
        let step = 1.0 / f64::from(parts);
        let reach = |p: DVec3| {
            let change = (self.scale[1] * p).length();
            let longest = (self.scale[0] * p).length() + change;
            (self.angle * self.angle * longest + 2.0 * self.angle * change) * step * step / 8.0
        };
        let reach = corners.into_iter().map(reach).fold(0.0, f64::max);
        let times = (0..=parts).map(|part| f64::from(part) * step);
        let places = times.flat_map(|time| {
            let placed = self.at(time);
            corners.map(|corner| placed.point(corner))
        });
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = places.fold(nothing, |[low, high], p| [low.min(p), high.max(p)]);
        [low - reach, high + reach]
    }
}

/// The rotation and the symmetric scale whose product is a matrix (PBR 2.9.3). Of one that mirrors, the scale does.
fn polar(matrix: &DMat3) -> (DMat3, DMat3) {
    let size = matrix.to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    let scaled = *matrix * (1.0 / size);
    let mut rotation = scaled;
    let length = |m: &DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    // Newton's iteration, scaled so that it takes few steps for any scale (Higham 1986).
    for _ in 0..50 {
        let inverse = rotation.inverse().transpose();
        let factor = (length(&inverse) / length(&rotation)).sqrt();
        let next = (rotation * factor + inverse * factor.recip()) * 0.5;
        let change = (next - rotation).to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        rotation = next;
        if change < 1e-15 {
            break;
        }
    }
    if rotation.determinant() < 0.0 {
        rotation = -rotation;
    }
    let scale = rotation.transpose() * *matrix;
    // Rounding left it not quite symmetric.
    (rotation, (scale + scale.transpose()) * 0.5)
}

/// The axis, of length one, and the angle of a rotation, from 0 to pi.
fn axis_angle(rotation: DMat3) -> (DVec3, f64) {
    let q = DQuat::from_mat3(&rotation);
    // Of the two quaternions of a rotation, this one takes the shorter way.
    let (v, w) = if q.w < 0.0 { (-q.xyz(), -q.w) } else { (q.xyz(), q.w) };
    let length = v.length();
    if length == 0.0 { (DVec3::Z, 0.0) } else { (v / length, 2.0 * libm::atan2(length, w)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rotated(degrees: f64, axis: DVec3) -> Transform {
        Transform::rotate(degrees, axis).unwrap()
    }

    fn near(a: Transform, b: Transform, tolerance: f64) {
        assert!(a.matrix().abs_diff_eq(b.matrix(), tolerance), "{a:?} {b:?}");
    }

    /// A turn about one axis, with a scale along it and a way, is the same turn by a share of its angle.
    #[test]
    fn parts_of_a_motion_are_in_proportion_to_time() {
        for mirror in [1.0, -1.0] {
            let axis = DVec3::new(1.0, 2.0, -0.5);
            let own = rotated(30.0, DVec3::X) * Transform::scale(DVec3::new(mirror, 2.0, 3.0)).unwrap();
            let placed = |time: f64| {
                let way = DVec3::new(4.0, -1.0, 2.0) * time;
                Transform::translate(way) * rotated(150.0 * time, axis) * own
            };
            let motion = AnimatedTransform::new(placed(0.0), placed(1.0)).unwrap();
            for time in [0.0, 0.1, 0.5, 0.9, 1.0] {
                near(motion.at(time), placed(time), 1e-13);
            }
            assert_eq!([motion.at(-1.0), motion.at(2.0)], motion.ends());
        }
    }

    #[test]
    fn scales_change_evenly_and_the_shorter_way_is_taken() {
        let [small, large] = [1e-9, 1e9].map(|x| Transform::scale(DVec3::new(x, x, 1e-40)).unwrap());
        let motion = AnimatedTransform::new(small, large).unwrap();
        assert!((motion.at(0.25).vector(DVec3::X).x / (0.75e-9 + 0.25e9) - 1.0).abs() < 1e-15);
        let motion = AnimatedTransform::new(Transform::IDENTITY, rotated(270.0, DVec3::Z)).unwrap();
        near(motion.at(0.5), rotated(-45.0, DVec3::Z), 1e-15);
        let mirrored = Transform::scale(DVec3::new(1.0, -1.0, 1.0)).unwrap();
        assert_eq!(AnimatedTransform::new(Transform::IDENTITY, mirrored), Err(MirrorsOnTheWay));
    }

    /// Points of boxes at many times lie in the bounds of the motion, which are not much larger than needed.
    #[test]
    fn bounds_hold_all_places() {
        for (degrees, way, scale) in [
            (180.0, DVec3::ZERO, 1.0),
            (170.0, DVec3::new(3.0, -20.0, 1.0), 0.2),
            (1.0, DVec3::ONE, 5.0),
            (0.0, DVec3::new(0.0, 1e6, 0.0), 1.0),
        ] {
            let axis = DVec3::new(0.3, -1.0, 0.7);
            let start = rotated(40.0, DVec3::Y) * Transform::scale(DVec3::new(1.0, 3.0, -0.5)).unwrap();
            let end = Transform::translate(way)
                * rotated(degrees, axis)
                * start
                * Transform::scale(DVec3::splat(scale)).unwrap();
            let motion = AnimatedTransform::new(start, end).unwrap();
            let corners = [DVec3::new(-1.0, 2.0, 0.5), DVec3::new(2.0, 2.5, 4.0)];
            let [low, high] = motion.bounds(corners);
            let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for time in 0..=1000 {
                let placed = motion.at(f64::from(time) / 1000.0);
                for corner in 0..8 {
                    let pick = |axis: usize| corners[corner >> axis & 1][axis];
                    let p = placed.point(DVec3::new(pick(0), pick(1), pick(2)));
                    (least, most) = (least.min(p), most.max(p));
                }
            }
            let rounding = 1e-9 * (most - least);
            assert!((low - rounding).cmple(least).all() && (high + rounding).cmpge(most).all());
            let excess = (least - low).max(high - most);
            assert!(excess.max_element() < 0.02 * (most - least).max_element(), "{excess}");
        }
    }
}
