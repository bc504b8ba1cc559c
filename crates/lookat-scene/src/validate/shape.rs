//! Whether quadrics and curves keep the promises of a scene.

use std::ops::RangeInclusive;

use super::{is_length, is_placed};
use crate::{Curve, CurveKind, Quadric, QuadricForm};

/// The depths of splits that [`Curve`] allows.
const SPLITS: RangeInclusive<u32> = 0..=5;

pub(super) fn is_curve(curve: &Curve) -> bool {
    let [first, last] = curve.widths;
    let has_normals = match &curve.kind {
        CurveKind::Flat | CurveKind::Cylinder => true,
        CurveKind::Ribbon(normals) => {
            normals.len() == curve.segments.len() + 1 && normals.iter().all(|n| n.is_normalized())
        }
    };
    has_normals
        && !curve.segments.is_empty()
        && curve.segments.as_flattened().iter().all(|p| p.is_finite())
        && SPLITS.contains(&curve.split_depth)
        && first >= 0.0
        && last >= 0.0
        && is_length(first + last)
        && is_placed(&curve.world_from_object)
}

pub(super) fn is_quadric(quadric: &Quadric) -> bool {
    let Quadric { form, phi_max, world_from_object } = *quadric;
    let has_form = match form {
        QuadricForm::Sphere(f) => -f.radius <= f.z_min && f.z_min < f.z_max && f.z_max <= f.radius,
        QuadricForm::Disk(f) => f.height.is_finite() && 0.0 <= f.inner_radius && f.inner_radius < f.radius,
        QuadricForm::Cylinder(f) => f.radius > 0.0 && f.z_min < f.z_max,
        QuadricForm::Cone(f) => f.radius > 0.0 && f.height > 0.0,
        QuadricForm::Paraboloid(f) => f.radius > 0.0 && f.z_min < f.z_max && f.z_max > 0.0,
        QuadricForm::Hyperboloid(f) => f.p1.z != f.p2.z && f.p2.z != 0.0,
    };
    let (low, high) = quadric.corners();
    let has_size = low.is_finite() && high.is_finite() && high.x > 0.0;
    has_form && has_size && phi_max > 0.0 && phi_max <= std::f64::consts::TAU && is_placed(&world_from_object)
}
