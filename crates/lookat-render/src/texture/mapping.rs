//! Places on a picture, and how they change from one camera ray to its neighbors (PBR 10.2).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use lookat_scene::{Mapping, Transform};

use super::TexturePoint;

/// The coordinates. They are finite.
pub(crate) fn coordinates(mapping: &Mapping, at: &TexturePoint) -> DVec2 {
    finite(match mapping {
        Mapping::Uv { scale, offset } => at.uv * *scale + *offset,
        Mapping::Spherical { texture_from_world } => spherical(at.within(texture_from_world)),
        Mapping::Cylindrical { texture_from_world } => cylindrical(at.within(texture_from_world)),
        // The origin apart, so that neighboring points keep their distance however far away it is.
        Mapping::Planar { axes, offset } => along(axes, at.p) + (along(axes, at.origin) + *offset),
    })
}

/// How the coordinates change to the neighbors at the right and below. They are finite.
///
/// pbrt-v3 takes differences on spheres and cylinders, which are wrong where the texture's edges meet; these are
/// derivatives.
pub(crate) fn changes(mapping: &Mapping, at: &TexturePoint) -> [DVec2; 2] {
    let changes = match mapping {
        Mapping::Uv { scale, .. } => at.footprint.duv.map(|duv| duv * *scale),
        Mapping::Spherical { texture_from_world } => {
            let v = at.within(texture_from_world);
            steps(at, texture_from_world, |dv| spherical_derivative(v, dv))
        }
        Mapping::Cylindrical { texture_from_world } => {
            let v = at.within(texture_from_world);
            steps(at, texture_from_world, |dv| cylindrical_derivative(v, dv))
        }
        Mapping::Planar { axes, .. } => at.footprint.dp.map(|dp| along(axes, dp)),
    };
    changes.map(finite)
}

fn along(axes: &[DVec3; 2], v: DVec3) -> DVec2 {
    DVec2::new(v.dot(axes[0]), v.dot(axes[1]))
}

/// Coordinates of the file may overflow under a scale.
fn finite(st: DVec2) -> DVec2 {
    if st.is_finite() { st } else { DVec2::ZERO }
}

fn steps(
    at: &TexturePoint,
    texture_from_world: &Transform,
    derivative: impl Fn(DVec3) -> DVec2,
) -> [DVec2; 2] {
    at.footprint.dp.map(|dp| match dp {
        DVec3::ZERO => DVec2::ZERO,
        dp => derivative(texture_from_world.vector(dp)),
    })
}

/// Latitude and longitude, each from 0 to 1.
fn spherical(v: DVec3) -> DVec2 {
    let theta = v.truncate().length().atan2(v.z);
    let phi = v.y.atan2(v.x);
    DVec2::new(theta / PI, if phi < 0.0 { phi / TAU + 1.0 } else { phi / TAU })
}

fn spherical_derivative(v: DVec3, dv: DVec3) -> DVec2 {
    let radius = v.truncate().length();
    let outward = v.truncate().dot(dv.truncate()) / radius;
    let dtheta = (v.z * outward - radius * dv.z) / v.length_squared();
    DVec2::new(dtheta / PI, longitude_derivative(v, dv))
}

/// Longitude from 0 to 1, and the height on the unit sphere, as pbrt-v3 has it.
fn cylindrical(v: DVec3) -> DVec2 {
    DVec2::new((PI + v.y.atan2(v.x)) / TAU, v.normalize_or_zero().z)
}

fn cylindrical_derivative(v: DVec3, dv: DVec3) -> DVec2 {
    let length = v.length();
    let height = (dv.z - v.z * v.dot(dv) / (length * length)) / length;
    DVec2::new(longitude_derivative(v, dv), height)
}

fn longitude_derivative(v: DVec3, dv: DVec3) -> f64 {
    v.truncate().perp_dot(dv.truncate()) / v.truncate().length_squared() / TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Footprint;

    fn place(mapping: &Mapping, at: &TexturePoint) -> (DVec2, [DVec2; 2]) {
        (coordinates(mapping, at), changes(mapping, at))
    }

    fn at(p: DVec3) -> TexturePoint {
        let dp = [DVec3::new(1e-3, 2e-3, -1e-3), DVec3::new(0.0, -1e-3, 2e-3)];
        let duv = [DVec2::new(0.1, 0.2), DVec2::new(0.3, 0.4)];
        TexturePoint { p, origin: DVec3::ZERO, uv: DVec2::new(0.25, 0.5), footprint: Footprint { dp, duv } }
    }

    fn mappings() -> [Mapping; 4] {
        let turned = Transform::rotate(40.0, DVec3::new(1.0, 2.0, 3.0)).unwrap()
            * Transform::translate(DVec3::new(0.3, 0.1, 0.2));
        [
            Mapping::Uv { scale: DVec2::new(2.0, 3.0), offset: DVec2::new(0.5, -0.5) },
            Mapping::Spherical { texture_from_world: turned },
            Mapping::Cylindrical { texture_from_world: turned },
            Mapping::Planar { axes: [DVec3::new(1.0, 2.0, 0.0), DVec3::Z], offset: DVec2::X },
        ]
    }

    #[test]
    fn known_places() {
        let [uv, _, _, planar] = mappings();
        let (st, [right, below]) = place(&uv, &at(DVec3::ZERO));
        assert_eq!(st, DVec2::ONE);
        assert!((right - DVec2::new(0.2, 0.6)).length() + (below - DVec2::new(0.6, 1.2)).length() < 1e-12);
        assert_eq!(place(&planar, &at(DVec3::new(1.0, 2.0, 3.0))).0, DVec2::new(6.0, 3.0));
        assert_eq!(spherical(DVec3::X), DVec2::new(0.5, 0.0));
        assert_eq!(spherical(-DVec3::Y * 7.0), DVec2::new(0.5, 0.75));
        assert_eq!(spherical(DVec3::NEG_Z), DVec2::new(1.0, 0.0));
        assert_eq!(cylindrical(DVec3::new(0.0, 3.0, 4.0)), DVec2::new(0.75, 0.8));
    }

    /// Derivatives are what differences come to.
    #[test]
    fn derivatives_are_those_of_places() {
        for mapping in &mappings()[1..] {
            let p = DVec3::new(0.4, -0.7, 0.5);
            let (st, steps) = place(mapping, &at(p));
            for (step, dp) in steps.into_iter().zip(at(p).footprint.dp) {
                let beside = place(mapping, &at(p + dp * 1e-4)).0;
                assert!(((beside - st) / 1e-4 - step).length() < 1e-6, "{mapping:?}");
            }
        }
    }

    /// Far from the origin, with an origin of coordinates nearby, places are as near at hand.
    #[test]
    fn the_eye_is_apart() {
        let far = DVec3::new(1e8, -3e8, 2e8);
        for mapping in mappings() {
            let moved = match mapping {
                Mapping::Spherical { texture_from_world } => {
                    Mapping::Spherical { texture_from_world: texture_from_world * Transform::translate(-far) }
                }
                Mapping::Cylindrical { texture_from_world } => Mapping::Cylindrical {
                    texture_from_world: texture_from_world * Transform::translate(-far),
                },
                same => same,
            };
            let near = |p| place(&mapping, &at(p)).0;
            let there = |p| place(&moved, &TexturePoint { origin: far, ..at(p) }).0;
            let (a, b) = (DVec3::new(0.4, -0.7, 0.5), DVec3::new(0.4, -0.7, 0.5 + 1e-7));
            assert!(((near(a) - near(b)) - (there(a) - there(b))).length() < 1e-7);
        }
    }

    #[test]
    fn no_point_is_without_coordinates() {
        let texture_from_world = Transform::IDENTITY;
        let uv = Mapping::Uv { scale: DVec2::splat(1e50), offset: DVec2::ZERO };
        let all =
            [uv, Mapping::Spherical { texture_from_world }, Mapping::Cylindrical { texture_from_world }];
        for mapping in all {
            for p in [DVec3::ZERO, DVec3::splat(1e200), DVec3::new(1e-300, 0.0, 0.0)] {
                let uv = DVec2::splat(1e300);
                let footprint = Footprint { dp: [DVec3::ZERO, DVec3::splat(1e300)], duv: [uv, -uv] };
                let at = TexturePoint { p, uv, footprint, origin: DVec3::ZERO };
                assert!(coordinates(&mapping, &at).is_finite());
                assert!(changes(&mapping, &at).iter().all(|change| change.is_finite()));
            }
        }
    }
}
