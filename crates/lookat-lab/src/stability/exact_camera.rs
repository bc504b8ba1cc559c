//! A camera in double-double numbers: the true directions of its rays.

use glam::{DVec2, DVec3};
use twofloat::TwoFloat;

use super::double_double::{Wide, quotient};
use crate::text_scene::xyz;

/// The tangent of half an angle in degrees, above 0 and below 180.
pub(super) fn tan_half(degrees: f64) -> TwoFloat {
    if degrees > 90.0 {
        // The difference is exact.
        return quotient(1.0.into(), tan_half(180.0 - degrees));
    }
    let x = twofloat::consts::PI * degrees / 360.0;
    let (mut sin, mut cos) = (TwoFloat::from(0.0), TwoFloat::from(0.0));
    // Taylor series: the last term is below 1e-37.
    for n in (0..30).rev() {
        let term = (1..=n).fold(TwoFloat::from(1.0), |power, k| power * x / f64::from(k));
        let signed = if n % 4 < 2 { term } else { -term };
        if n % 2 == 0 { cos += signed } else { sin += signed }
    }
    quotient(sin, cos)
}

/// Eye, target and up vector.
pub(super) type LookAt = [DVec3; 3];

/// The axes of a camera in the world, of length one.
#[derive(Debug, Clone, Copy)]
pub(super) struct CameraAxes {
    pub right: Wide,
    pub up: Wide,
    pub forward: Wide,
}

impl CameraAxes {
    pub fn in_camera_space() -> CameraAxes {
        let [right, up, forward] = DVec3::AXES.map(Wide::new);
        CameraAxes { right, up, forward }
    }

    /// The axes of a `LookAt`. `None` for an `up` parallel to the view.
    pub fn new([eye, look, up]: LookAt) -> Option<CameraAxes> {
        let view = Wide::new(look).minus(Wide::new(eye));
        // Products of two numbers are exact, and so is the sign of their difference. The low parts are products of
        // their own, so that no digit is lost where `up` nearly meets the view.
        let part = |of: fn(&TwoFloat) -> f64| Wide(view.0.map(|x| TwoFloat::from(of(&x))));
        let (high, low) = (part(TwoFloat::hi), part(TwoFloat::lo));
        let up = Wide::new(up);
        let side = up.cross(high).plus(up.cross(low));
        if side.0.iter().all(|x| *x == 0.0) {
            return None;
        }
        let (right, forward) = (side.unit(), view.unit());
        Some(CameraAxes { right, up: forward.cross(right), forward })
    }

    /// A vector with these components along the axes.
    pub fn world(&self, x: TwoFloat, y: TwoFloat, z: TwoFloat) -> Wide {
        self.right.times(x).plus(self.up.times(y)).plus(self.forward.times(z))
    }
}

/// A perspective camera without a lens, with the default window: the field of view is that of the shorter side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pinhole {
    look_at: LookAt,
    fov: f64,
    pub resolution: [u32; 2],
    pub view: CameraAxes,
    tan: TwoFloat,
}

impl Pinhole {
    /// # Panics
    ///
    /// If the up vector is parallel to the view.
    pub fn new(look_at: LookAt, fov: f64, resolution: [u32; 2]) -> Pinhole {
        let view = CameraAxes::new(look_at).expect("a view has a side");
        Pinhole { look_at, fov, resolution, view, tan: tan_half(fov) }
    }

    /// At the origin, with a field of view of 90 degrees.
    pub fn in_camera_space(resolution: [u32; 2]) -> Pinhole {
        Pinhole::new([DVec3::ZERO, DVec3::Z, DVec3::Y], 90.0, resolution)
    }

    /// The directives of the camera.
    pub fn text(&self) -> String {
        let look_at = self.look_at.map(xyz).join("  ");
        format!("LookAt {look_at} Camera \"perspective\" \"float fov\" {}", self.fov)
    }

    /// The direction in camera space through a point of the film, with z = 1.
    pub fn slope(&self, film: DVec2) -> [TwoFloat; 2] {
        let [width, height] = self.resolution.map(f64::from);
        let scale = self.tan / width.min(height);
        [TwoFloat::new_sub(2.0 * film.x, width) * scale, TwoFloat::new_sub(height, 2.0 * film.y) * scale]
    }

    /// The direction in the world, of no particular length.
    pub fn direction(&self, film: DVec2) -> Wide {
        let [x, y] = self.slope(film);
        self.view.world(x, y, TwoFloat::from(1.0))
    }

    /// How far a direction is off, in radians.
    pub fn radians(&self, film: DVec2, d: DVec3) -> f64 {
        angle(d, self.direction(film))
    }

    /// How many pixels a direction is off.
    pub fn pixels(&self, film: DVec2, d: DVec3) -> f64 {
        let d = Wide::new(d);
        let depth = d.dot(self.view.forward);
        let [width, height] = self.resolution.map(f64::from);
        let scale = quotient(width.min(height).into(), self.tan * 2.0);
        let [x, y] = self.slope(film);
        let dx = (quotient(d.dot(self.view.right), depth) - x) * scale;
        let dy = (quotient(d.dot(self.view.up), depth) - y) * scale;
        if depth > 0.0 { f64::from(dx).hypot(f64::from(dy)) } else { f64::NAN }
    }
}

/// The angle between a direction and the true one, small or not; not a number if `d` has no direction.
pub(super) fn angle(d: DVec3, truth: Wide) -> f64 {
    let d = Wide::new(d);
    f64::from(d.cross(truth).length()).atan2(f64::from(d.dot(truth)))
        + if f64::from(d.dot(d)) > 0.0 { 0.0 } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tangents_are_those_of_a_table() {
        // Computed with 60 digits, split in two.
        let table = [
            (0.001, 8.726646260193173e-06, -6.465618911120815e-22),
            (1.0, 0.00872686779075879, 2.5644768135649835e-20),
            (37.25, 0.3370230028633979, 2.6011097137939908e-17),
            (45.0, 0.41421356237309503, 1.4349369327986523e-17),
            (90.0, 1.0, 0.0),
            (120.0, 1.7320508075688772, 1.0035084221806903e-16),
            (179.9, 1145.915299373488, 2.4785589005782584e-14),
            (179.999, 114591.5590227086, -4.3058683793968474e-12),
        ];
        for (degrees, high, low) in table {
            let error = (tan_half(degrees) - high - low) / high;
            assert!(error.abs() < 1e-30, "{degrees}: {error}");
        }
    }

    #[test]
    fn quotients_and_roots_have_all_digits() {
        let third = quotient(TwoFloat::from(1.0), TwoFloat::new_add(3.0, 1e-20));
        let error = third * TwoFloat::new_add(3.0, 1e-20) - 1.0;
        assert!(error.abs() < 1e-31, "{error}");
        let root = TwoFloat::from(2.0).sqrt();
        assert!((root * root - 2.0).abs() < 1e-30);
    }

    #[test]
    fn the_view_of_axes_is_exact() {
        let eye = DVec3::new(3.0, 4.0, 5.0);
        let view = CameraAxes::new([eye, eye + 7.0 * DVec3::Z, DVec3::new(1e-15, 0.0, 3.0)]).unwrap();
        assert_eq!(angle(-DVec3::Y, view.right), 0.0);
        assert_eq!(angle(-DVec3::X, view.up), std::f64::consts::PI);
        assert!(CameraAxes::new([eye, DVec3::ZERO, 2.0 * eye]).is_none());
    }

    #[test]
    fn pixels_and_angles_are_known() {
        let pinhole = Pinhole::in_camera_space([640, 480]);
        let film = DVec2::new(640.0, 0.0);
        let corner = DVec3::new(4.0 / 3.0, 1.0, 1.0);
        assert!(angle(corner, pinhole.direction(film)) < 1e-16);
        assert!(pinhole.pixels(film, corner) < 1e-13);
        assert!((pinhole.pixels(film, corner + 0.25 * DVec3::X) - 60.0).abs() < 1e-12);
        assert!(
            (angle(DVec3::X, pinhole.direction(DVec2::new(320.0, 240.0))) - std::f64::consts::FRAC_PI_2)
                .abs()
                < 1e-15
        );
        assert!(angle(DVec3::ZERO, CameraAxes::in_camera_space().up).is_nan());
    }
}
