//! Transformations between spaces, composed and inverted in `f64`, and angles that look like radians.

mod animated;

use std::ops::Mul;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use lookat_syntax::Severity;

pub(crate) use animated::TransformSet;
pub use animated::{AnimatedTransform, MirrorsOnTheWay};

/// An affine transformation with its inverse, as in pbrt. Its constructors make both. Points placed by exact numbers, such as the eye of a
/// `LookAt`, are returned exactly.
///
/// `a * b` applies `b` first. The name `b_from_a` of a value gives both spaces.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Transform {
    m: DAffine3,
    inv: DAffine3,
}

/// The largest coordinate, and the largest entry of a transformation and its inverse. It is far above any use, and
/// its areas, volumes and squares are finite.
pub(crate) const LARGEST: f64 = 1e50;

/// True if all values are in the range of computation. Has no early exit, so that the comparison vectorizes.
pub(crate) fn in_range(values: &[f64]) -> bool {
    values.iter().fold(true, |all, x| all & (x.abs() <= LARGEST))
}

/// The reason why a `LookAt` is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LookAtError {
    /// The eye equals the target.
    #[error("the eye and the target of LookAt are the same point")]
    EyeAtLook,
    /// The up vector has length zero.
    #[error("the up vector of LookAt is zero")]
    ZeroUp,
    /// The up vector is parallel to the view.
    #[error("the up vector of LookAt is parallel to the view")]
    UpParallel,
    /// The transformation or its inverse has entries above 1e50.
    #[error("the transformation or its inverse has entries above {LARGEST:e}")]
    OutOfRange,
}

impl Transform {
    /// The identity.
    pub const IDENTITY: Transform = Transform { m: DAffine3::IDENTITY, inv: DAffine3::IDENTITY };

    /// A translation.
    pub fn translate(by: DVec3) -> Self {
        Transform { m: DAffine3::from_translation(by), inv: DAffine3::from_translation(-by) }
    }

    /// A scale along the axes. `None` if a factor is zero, or too small or large to invert.
    pub fn scale(by: DVec3) -> Option<Self> {
        let inv = by.recip();
        (by.is_finite() && inv.is_finite())
            .then(|| Transform { m: DAffine3::from_scale(by), inv: DAffine3::from_scale(inv) })
    }

    /// A rotation by `degrees` about `axis`: counterclockwise in a right-handed system with the axis pointing at the
    /// viewer, clockwise in pbrt's left-handed system. `None` for an axis of length zero.
    pub fn rotate(degrees: f64, axis: DVec3) -> Option<Self> {
        // Scaled first, so that the length neither overflows nor underflows.
        let axis = (axis / axis.abs().max_element()).try_normalize()?;
        let (sin, cos) = sin_cos_degrees(degrees);
        let along = |v: DVec3| {
            let parallel = axis * v.dot(axis);
            parallel + (v - parallel) * cos + axis.cross(v) * sin
        };
        Some(Transform::to_frame(DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))))
    }

    /// A rotation that takes the axes to the unit vectors of a frame.
    pub(crate) fn to_frame(frame: DMat3) -> Self {
        Transform { m: DAffine3::from_mat3(frame), inv: DAffine3::from_mat3(frame.transpose()) }
    }

    /// The viewing transformation of `LookAt`: camera from world space, left-handed, +z forward, +y up.
    ///
    /// The side vector is `cross(up, look - eye)`, normalized last. Compensated differences keep full accuracy even
    /// if `up` is nearly parallel to the view.
    pub fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Result<Self, LookAtError> {
        let view = look - eye;
        if view == DVec3::ZERO {
            return Err(LookAtError::EyeAtLook);
        }
        if up == DVec3::ZERO {
            return Err(LookAtError::ZeroUp);
        }
        let rest = rounded_off(look, eye, view);
        // Scaled by powers of two, which is exact.
        let (scale, up) = (scale_to_one(view), up * scale_to_one(up));
        let (view, rest) = (view * scale, rest * scale);
        let side = cross_exact(up, view) + up.cross(rest);
        if side.length() <= 4e-16 * up.length() * view.length() {
            return Err(LookAtError::UpParallel);
        }
        let (right, forward) = (side.normalize(), view.normalize());
        let up = cross_exact(forward, right).normalize();
        let rotation = DMat3::from_cols(right, up, forward);
        let to_camera = rotation.transpose();
        let m = DAffine3::from_mat3_translation(to_camera, -(to_camera * eye));
        let placed = Transform { m, inv: DAffine3::from_mat3_translation(rotation, eye) };
        placed.in_range().then_some(placed).ok_or(LookAtError::OutOfRange)
    }

    /// From a matrix. `None` if it is singular or not affine.
    pub fn from_matrix(m: DMat4) -> Option<Self> {
        // Scaled to about one, so that the determinant neither underflows nor overflows.
        let size = DMat3::from_mat4(m).to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        if size == 0.0 || !m.is_finite() || m.row(3) != DVec4::W {
            return None;
        }
        let linear = DMat3::from_mat4(m) * (1.0 / size);
        let determinant = linear.determinant();
        // The product of column lengths bounds the determinant. Below this ratio the determinant is rounding error.
        let volume = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
        if determinant.abs() <= 1e-15 * volume {
            return None;
        }
        let inverse = linear.inverse() * (1.0 / size);
        let translation = -(inverse * m.w_axis.truncate());
        let inv = DAffine3::from_mat3_translation(inverse, translation);
        inv.is_finite().then_some(Transform { m: DAffine3::from_mat4(m), inv })
    }

    /// From a singular affine matrix, with a thickness where it has none: a millionth of its size. `None` if it is not affine.
    pub(crate) fn thickened(m: DMat4) -> Option<Self> {
        const THICKNESS: f64 = 1e-6;
        if m.row(3) != DVec4::W {
            return None;
        }
        let linear = DMat3::from_mat4(m);
        let size = linear.to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
        let size = if size == 0.0 { 1.0 } else { size };
        // Along no axis of theirs are usual matrices singular.
        let rotation = DMat3::from_quat(DQuat::from_xyzw(1.0, 2.0, 3.0, 4.0).normalize());
        let thick = linear + rotation * (size * THICKNESS);
        Transform::from_matrix(DMat4::from_mat3_translation(thick, m.w_axis.truncate()))
    }

    /// True if all entries, also of the inverse, can be multiplied a few times without overflow.
    pub(crate) fn in_range(&self) -> bool {
        in_range(&self.m.to_cols_array()) && in_range(&self.inv.to_cols_array())
    }

    /// The matrix, for column vectors.
    pub fn matrix(&self) -> DMat4 {
        self.m.into()
    }

    /// The inverse of the matrix, except for rounding.
    pub fn inverse_matrix(&self) -> DMat4 {
        self.inv.into()
    }

    /// The linear part of the matrix.
    #[inline]
    pub fn linear(&self) -> &DMat3 {
        &self.m.matrix3
    }

    /// The linear part of the inverse.
    #[inline]
    pub fn inverse_linear(&self) -> &DMat3 {
        &self.inv.matrix3
    }

    /// The bits of the matrix and of its inverse.
    pub(crate) fn bits(&self) -> [[u64; 12]; 2] {
        [self.m, self.inv].map(|matrix| matrix.to_cols_array().map(f64::to_bits))
    }

    /// The inverse.
    pub fn inverse(self) -> Self {
        Transform { m: self.inv, inv: self.m }
    }

    /// Transforms a point.
    #[inline]
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.m.transform_point3(p)
    }

    /// Transforms a vector.
    #[inline]
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.m.transform_vector3(v)
    }

    /// Transforms a surface normal by the inverse transpose. Does not normalize.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        self.inv.matrix3.transpose() * n
    }

    /// The vectors that the axes become.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.vector(axis))
    }

    /// The factor of all lengths, for a rotation with a uniform scale and no shear. `None` for others. `tolerance` is relative.
    pub(crate) fn uniform_scale(&self, tolerance: f64) -> Option<f64> {
        let [x, y, z] = self.axes();
        let scale = libm::cbrt(DMat3::from_cols(x, y, z).determinant().abs());
        let is_right = |a: DVec3, b: DVec3| {
            (a.length() / scale - 1.0).abs() < tolerance && a.dot(b).abs() < tolerance * scale * scale
        };
        (is_right(x, y) && is_right(y, z) && is_right(z, x)).then_some(scale)
    }

    /// True if it swaps handedness.
    pub fn swaps_handedness(&self) -> bool {
        // With normalized columns, the sign of the determinant survives any scale.
        let [x, y, z] = self.axes().map(DVec3::normalize_or_zero);
        DMat3::from_cols(x, y, z).determinant() < 0.0
    }
}

impl Mul for Transform {
    type Output = Transform;

    fn mul(self, other: Transform) -> Transform {
        // Sums of four products: those of three may be -0 in place of 0.
        let product = |a: DAffine3, b: DAffine3| DAffine3::from_mat4(DMat4::from(a) * DMat4::from(b));
        Transform { m: product(self.m, other.m), inv: product(other.inv, self.inv) }
    }
}

/// Sine and cosine, exact at multiples of 90 degrees.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = degrees % 360.0;
    match turned {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => libm::sincos(turned.to_radians()),
    }
}

/// The power of two that scales the largest component to about one.
fn scale_to_one(v: DVec3) -> f64 {
    let exponent = libm::log2(v.abs().max_element()).floor();
    libm::exp2((-exponent).clamp(-1022.0, 1022.0))
}

/// The rounding error of the difference of two points (Knuth's two-sum).
fn rounded_off(a: DVec3, b: DVec3, difference: DVec3) -> DVec3 {
    let back = difference - a;
    (a - (difference - back)) - (b + back)
}

/// The cross product with each component within 1.5 ulp (Kahan's difference of products).
fn cross_exact(a: DVec3, b: DVec3) -> DVec3 {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let cd = c * d;
        let error = (-c).mul_add(d, cd);
        a.mul_add(b, -cd) + error
    };
    DVec3::new(difference(a.y, b.z, a.z, b.y), difference(a.z, b.x, a.x, b.z), difference(a.x, b.y, a.y, b.x))
}

/// Common angles in degrees.
const COMMON: [f64; 9] = [30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// Fields of view that are rare in degrees, and common in radians.
const NARROW: std::ops::Range<f64> = 0.25..2.0;

/// The severity, message and help for an angle that may be in radians. A common angle in radians, rounded or not, gives
/// a warning. Another narrow field of view gives a note.
pub(crate) fn doubt(name: &str, given: f64) -> Option<(Severity, String, String)> {
    let is_meant = |degrees: &f64| (given.abs() / degrees.to_radians() - 1.0).abs() < 6e-4;
    let common = COMMON.into_iter().find(is_meant).map(|degrees| degrees.copysign(given));
    let is_narrow = name == "fov" && NARROW.contains(&given);
    let narrow = is_narrow.then(|| (given.to_degrees() * 10.0).round() / 10.0);
    let (severity, message) = match common {
        Some(_) => (Severity::Warning, format!("{name} is {given} degrees: this looks like radians")),
        None => (Severity::Note, format!("{name} {given} is a very narrow view")),
    };
    let degrees = common.or(narrow)?;
    Some((severity, message, format!("angles are in degrees: {given} rad is {degrees} degrees")))
}

#[cfg(test)]
mod tests {
    mod transform {
        use super::super::*;

        fn near(a: DVec3, b: DVec3) {
            assert!((a - b).length() < 1e-14, "{a} {b}");
        }

        #[test]
        fn look_at_is_left_handed_with_z_forward() {
            let eye = DVec3::new(3.0, 4.0, 5.0);
            let camera_from_world = Transform::look_at(eye, eye + DVec3::Z, DVec3::Y).unwrap();
            near(camera_from_world.point(eye + DVec3::X), DVec3::X);
            near(camera_from_world.point(eye + DVec3::new(0.0, 0.0, 2.0)), DVec3::new(0.0, 0.0, 2.0));
            let back = Transform::look_at(eye, eye - DVec3::Z, DVec3::Y).unwrap();
            near(back.vector(DVec3::X), -DVec3::X);
            assert_eq!(back.inverse().point(DVec3::ZERO), eye);
        }

        #[test]
        fn look_at_keeps_its_accuracy_when_up_nearly_meets_the_view() {
            for exponent in [1, 5, 8, 12, 14] {
                let tilt = 10_f64.powi(-exponent);
                let view = Transform::look_at(DVec3::ZERO, DVec3::Z, DVec3::new(tilt, 0.0, 1.0)).unwrap();
                near(view.inverse().vector(DVec3::Y), DVec3::X);
            }
            // The difference of these points is rounded, and `up` differs from it in the last digits only.
            let (eye, look) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(7.7, -5.3, 11.9));
            let up = (look - eye) / 3.0 + DVec3::new(0.0, 1e-13, 0.0);
            let side = Transform::look_at(eye, look, up).unwrap().inverse().vector(DVec3::X);
            // Computed with 60 digits from the binary numbers above.
            near(side, DVec3::new(0.8358592829700306, -0.00275220217373855, -0.5489368674592927));
        }

        #[test]
        fn a_view_without_meaning_is_refused() {
            let (p, q) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0));
            assert_eq!(Transform::look_at(p, p, DVec3::Z), Err(LookAtError::EyeAtLook));
            assert_eq!(Transform::look_at(p, q, DVec3::splat(3.0)), Err(LookAtError::UpParallel));
            assert_eq!(Transform::look_at(p, q, DVec3::ZERO), Err(LookAtError::ZeroUp));
        }

        #[test]
        fn rotations_follow_pbrt() {
            // pbrt-v3 transform.cpp: Rotate(90, z) takes x to y.
            let quarter = Transform::rotate(90.0, DVec3::new(0.0, 0.0, 7.0)).unwrap();
            assert_eq!(quarter.vector(DVec3::X), DVec3::Y);
            let third = Transform::rotate(120.0, DVec3::ONE).unwrap();
            near(third.vector(DVec3::X), DVec3::Y);
            assert_eq!(Transform::rotate(10.0, DVec3::ZERO), None);
        }

        #[test]
        fn every_transformation_has_its_inverse() {
            let sheared =
                DMat4::from_cols_array(&[2., 0., 1., 0., 3., 4., 0., 0., 0., 5., 1., 0., 7., 8., 9., 1.]);
            let all = [
                Transform::translate(DVec3::new(3.0, -4.0, 5.0)),
                Transform::scale(DVec3::new(-2.0, 0.5, 7.0)).unwrap(),
                Transform::rotate(40.0, DVec3::new(1.0, 2.0, 3.0)).unwrap(),
                Transform::look_at(DVec3::new(3.0, 4.0, 5.0), DVec3::X, DVec3::Y).unwrap(),
                Transform::from_matrix(sheared).unwrap(),
            ];
            let product = all.into_iter().reduce(|a, b| a * b).unwrap();
            for Transform { m, inv } in all.into_iter().chain([product, product.inverse()]) {
                assert!((m * inv).abs_diff_eq(DAffine3::IDENTITY, 1e-12), "{m:?} {inv:?}");
            }
        }

        #[test]
        fn only_singular_matrices_are_refused() {
            assert!(Transform::from_matrix(DMat4::ZERO).is_none());
            let flat =
                DMat4::from_cols_array(&[1., 2., 3., 0., 2., 4., 6., 0., 0., 1., 0., 0., 0., 0., 0., 1.]);
            assert!(Transform::from_matrix(flat).is_none());
            for size in [1e-60, 1e-6, 1.0, 1e60] {
                let scale = Transform::from_matrix(DMat4::from_scale(DVec3::splat(size))).unwrap();
                assert!((scale.inv.x_axis.x * size - 1.0).abs() < 1e-15);
                assert!(!scale.swaps_handedness());
                let mirror = Transform::scale(DVec3::new(-size, size, size)).unwrap();
                assert!(mirror.swaps_handedness());
            }
        }

        #[test]
        fn singular_matrices_become_thin() {
            let columns = |x: DVec3, y: DVec3, z: DVec3| {
                DMat4::from_mat3_translation(DMat3::from_cols(x, y, z), DVec3::splat(7.0))
            };
            let [a, b] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 0.1)];
            for (m, normal) in [
                (columns(a, b, DVec3::ZERO), Some(a.cross(b))),
                (columns(DVec3::ZERO, b * 1e20, a * 1e20), Some(a.cross(b))),
                (columns(a, a + b, b), Some(a.cross(b))),
                (columns(a, a, a), None),
                (columns(DVec3::ZERO, DVec3::ZERO, DVec3::ZERO), None),
            ] {
                let thin = Transform::thickened(m).unwrap();
                let size =
                    DMat3::from_mat4(m).to_cols_array().iter().fold(1.0_f64, |max, x| max.max(x.abs()));
                let error = thin.point(a) - m.transform_point3(a);
                assert!(error.length() < 1e-5 * size, "{m} {error}");
                if let Some(normal) = normal {
                    let found = thin.normal(DVec3::new(0.3, -0.4, 0.5)).normalize();
                    assert!(found.cross(normal.normalize()).length() < 1e-5, "{m} {found}");
                }
            }
            let projective =
                DMat4::from_cols_array(&[1., 0., 0., 1., 0., 1., 0., 0., 0., 0., 0., 0., 0., 0., 0., 1.]);
            assert!(Transform::thickened(projective).is_none());
        }
    }
    mod angle {
        use super::super::*;

        #[test]
        fn radians_are_doubted() {
            for degrees in COMMON {
                let rounded = (degrees.to_radians() * 1e4).round() / 1e4;
                assert!(doubt("fov", degrees.to_radians()).is_some() && doubt("fov", -rounded).is_some());
                assert_eq!(doubt("fov", degrees), None);
            }
            for shorter in ["0.785", "1.57", "3.14", "6.28"] {
                assert!(doubt("fov", shorter.parse().unwrap()).is_some(), "{shorter}");
            }
            let is_note =
                |given| doubt("fov", given).is_some_and(|(severity, ..)| severity == Severity::Note);
            assert!(is_note(1.0) && is_note(0.3) && !is_note(0.785));
            for given in [0.0, 0.8, 1.0, 1.5, 3.0, 3.1, 5.0, f64::INFINITY, f64::NAN] {
                assert_eq!(doubt("the angle", given), None);
            }
            assert!(doubt("fov", 0.7).unwrap().2.ends_with("0.7 rad is 40.1 degrees"));
            assert_eq!(doubt("fov", 2.0), None);
            let (_, message, help) = doubt("the angle", -90_f64.to_radians()).unwrap();
            assert!(
                message.starts_with("the angle is -1.57")
                    && message.ends_with(" degrees: this looks like radians")
            );
            assert!(
                help.starts_with("angles are in degrees: -1.57") && help.ends_with(" rad is -90 degrees")
            );
        }
    }
}
