//! Whether quadrics and curves keep the promises of a scene.

use std::f64::consts::TAU;

use glam::DVec2;

use crate::shape::Limits;
use crate::{Curve, CurveKind, Quadric, QuadricForm};

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
        && curve.split_depth <= Curve::MOST_SPLITS
        && first >= 0.0
        && last >= 0.0
        && first + last > 0.0
        && curve.world_from_object.in_range()
        && curve.is_in_range()
}

pub(super) fn is_quadric(quadric: &Quadric) -> bool {
    let Quadric { form, phi_max, world_from_object } = *quadric;
    let limits = Limits::new(&world_from_object);
    let is_length = |x: f64| limits.lengths().contains(&x);
    let has_form = match form {
        QuadricForm::Sphere(f) => {
            is_length(f.radius) && -f.radius <= f.z_min && f.z_min < f.z_max && f.z_max <= f.radius
        }
        QuadricForm::Disk(f) => {
            let is_ring = 0.0 <= f.inner_radius && f.inner_radius < f.radius;
            is_length(f.radius) && is_ring && limits.contain(&[f.height])
        }
        QuadricForm::Cylinder(f) => {
            is_length(f.radius) && f.z_min < f.z_max && limits.contain(&[f.z_min, f.z_max])
        }
        QuadricForm::Cone(f) => is_length(f.radius) && is_length(f.height),
        QuadricForm::Paraboloid(f) => {
            let has_height = f.z_min < f.z_max && f.z_max > 0.0 && limits.contain(&[f.z_min, f.z_max]);
            is_length(f.radius) && has_height && f.is_curved()
        }
        QuadricForm::Hyperboloid(f) => {
            let is_off_axis = [f.p1, f.p2].iter().any(|p| p.truncate() != DVec2::ZERO);
            let are_near = [f.p1, f.p2].iter().all(|p| limits.contain(&p.to_array()));
            are_near && is_off_axis && f.p1.z != f.p2.z && f.p2.z != 0.0
        }
    };
    has_form && phi_max > 0.0 && phi_max <= TAU && world_from_object.in_range()
}
