//! How a transformation changes the lengths and the area of a quadric.

use glam::{DMat3, DVec3};

use crate::Transform;
use crate::shape::QuadricForm;

/// The change of the lengths and the area of a quadric.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scaling {
    /// No change that is visible.
    Unchanged,
    /// The area changes by a factor. So do lengths, where they all change by one factor.
    Factor { length: Option<f64>, area: f64 },
    /// The factor of the area is not the same everywhere.
    Uneven,
}

/// The largest relative change of lengths that counts as none: it changes the light by 0.2 %. Files often have matrices
/// with three to five digits.
const TOLERANCE: f64 = 1e-3;

/// The same for a sphere that grows: it may block its own samples, unless shadow rays end before its surface. In pbrt-v3 they
/// end 1e-4 of their length (ShadowEpsilon in core/pbrt.h) before their target.
const GROWTH: f64 = 1e-4;

impl Scaling {
    pub(super) fn of(world_from_object: &Transform, form: &QuadricForm) -> Self {
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| world_from_object.vector(axis));
        let length = libm::cbrt(DMat3::from_cols(x, y, z).determinant().abs());
        let is_alike = |a: DVec3, b: DVec3| {
            (a.length() / length - 1.0).abs() < TOLERANCE && a.dot(b).abs() < TOLERANCE * length * length
        };
        if is_alike(x, y) && is_alike(y, z) && is_alike(z, x) {
            let most = if matches!(form, QuadricForm::Sphere(_)) { GROWTH } else { TOLERANCE };
            return match length - 1.0 > -TOLERANCE && length - 1.0 < most {
                true => Scaling::Unchanged,
                false => Scaling::Factor { length: Some(length), area: length * length },
            };
        }
        if !matches!(form, QuadricForm::Disk(_)) {
            return Scaling::Uneven;
        }
        let area = x.cross(y).length();
        match (area - 1.0).abs() < 2.0 * TOLERANCE {
            true => Scaling::Unchanged,
            false => Scaling::Factor { length: None, area },
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::shape::{Disk, Sphere};

    const SPHERE: QuadricForm = QuadricForm::Sphere(Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0 });
    const DISK: QuadricForm = QuadricForm::Disk(Disk { height: 0.0, radius: 1.0, inner_radius: 0.0 });

    fn of(columns: [[f64; 3]; 3], form: &QuadricForm) -> Scaling {
        let matrix = DMat4::from_mat3(DMat3::from_cols_array_2d(&columns));
        Scaling::of(&Transform::from_matrix(matrix).unwrap(), form)
    }

    fn diagonal([x, y, z]: [f64; 3], form: &QuadricForm) -> Scaling {
        of([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]], form)
    }

    #[test]
    fn rounded_matrices_change_nothing() {
        for form in [SPHERE, DISK] {
            assert_eq!(diagonal([1.00002; 3], &form), Scaling::Unchanged);
            assert_eq!(diagonal([1.0, 1.0, 1.00002], &form), Scaling::Unchanged);
            for cos in [0.86603, 0.866] {
                let turned = [[cos, 0.5, 0.0], [-0.5, cos, 0.0], [0.0, 0.0, 1.0]];
                assert_eq!(of(turned, &form), Scaling::Unchanged);
            }
        }
    }

    #[test]
    fn a_sphere_that_grows_a_little_blocks_its_light() {
        assert!(matches!(diagonal([1.0005; 3], &SPHERE), Scaling::Factor { .. }));
        assert_eq!(diagonal([0.9995; 3], &SPHERE), Scaling::Unchanged);
        assert_eq!(diagonal([1.0005; 3], &DISK), Scaling::Unchanged);
    }

    #[test]
    fn the_area_of_a_disk_depends_on_its_plane_alone() {
        assert_eq!(diagonal([2.0, 3.0, 5.0], &DISK), Scaling::Factor { length: None, area: 6.0 });
        assert_eq!(diagonal([1.0, 1.0, 5.0], &DISK), Scaling::Unchanged);
        let sheared = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(of(sheared, &DISK), Scaling::Unchanged);
        assert_eq!(of(sheared, &SPHERE), Scaling::Uneven);
    }
}
