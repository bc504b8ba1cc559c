//! Places on a picture, and how they change from one camera ray to its neighbors (PBR 10.2).

use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::{DVec2, DVec3};
use lookat_scene::Mapping;

use super::{Footprint, TexturePoint, within};
use crate::circle::{angle, longitude_latitude};
use crate::number::{Vec2x8, Vec3x8, those, vectorized};

/// The coordinates. They are finite.
#[inline(never)]
pub(super) fn coordinates<S: Simd>(
    mapping: &Mapping,
    at: &TexturePoint<S>,
    active: mask64x8<S>,
) -> Vec2x8<S> {
    vectorized!(active.token(), {
        let [u, v] = at.uv;
        finite(match mapping {
            Mapping::Uv { scale, offset } => [u * scale.x + offset.x, v * scale.y + offset.y],
            Mapping::Spherical { texture_from_world } => spherical(at.within(texture_from_world)),
            Mapping::Cylindrical { texture_from_world } => cylindrical(at.within(texture_from_world)),
            // The origin apart, so that neighboring points keep their distance however far away it is.
            Mapping::Planar { axes, offset } => {
                let ([s, t], origin) = (along(axes, at.p), axes.map(|axis| at.origin.dot(axis)));
                [s + (origin[0] + offset.x), t + (origin[1] + offset.y)]
            }
        })
    })
}

/// How the coordinates change to the neighbors at the right and below. They are finite.
///
/// pbrt-v3 takes differences on spheres and cylinders, which are wrong where the texture's edges meet; these are
/// derivatives.
#[inline(never)]
pub(super) fn changes<S: Simd>(
    mapping: &Mapping,
    at: &TexturePoint<S>,
    footprint: &Footprint<S>,
    active: mask64x8<S>,
) -> [Vec2x8<S>; 2] {
    vectorized!(active.token(), {
        let ([dp0, dp1], [duv0, duv1]) = (footprint.dp, footprint.duv);
        let [x, y] = match mapping {
            Mapping::Uv { scale, .. } => {
                [[duv0[0] * scale.x, duv0[1] * scale.y], [duv1[0] * scale.x, duv1[1] * scale.y]]
            }
            Mapping::Spherical { texture_from_world: to }
            | Mapping::Cylindrical { texture_from_world: to } => {
                let is_sphere = matches!(mapping, Mapping::Spherical { .. });
                let derivative = if is_sphere { spherical_derivative } else { cylindrical_derivative };
                let (p, dv) = (at.within(to), [within(to, dp0), within(to, dp1)]);
                dv.map(|dv| {
                    each(active, |lane| match dv.lane(lane) {
                        DVec3::ZERO => DVec2::ZERO,
                        dv => derivative(p.lane(lane), dv),
                    })
                })
            }
            Mapping::Planar { axes, .. } => [along(axes, dp0), along(axes, dp1)],
        };
        [finite(x), finite(y)]
    })
}

#[inline(always)]
fn along<S: Simd>(axes: &[DVec3; 2], v: Vec3x8<S>) -> Vec2x8<S> {
    let simd = v.x.token();
    [v.dot(Vec3x8::splat(simd, axes[0])), v.dot(Vec3x8::splat(simd, axes[1]))]
}

/// Coordinates of the file may overflow under a scale.
#[inline(always)]
fn finite<S: Simd>([s, t]: Vec2x8<S>) -> Vec2x8<S> {
    let (is_finite, zero) = (s.is_finite() & t.is_finite(), f64x8::splat(s.token(), 0.0));
    [is_finite.select(s, zero), is_finite.select(t, zero)]
}

/// One by one.
#[inline(always)]
fn each<S: Simd>(active: mask64x8<S>, of: impl Fn(usize) -> DVec2) -> Vec2x8<S> {
    let mut all = [f64x8::splat(active.token(), 0.0); 2];
    for lane in those(active) {
        [all[0][lane], all[1][lane]] = of(lane).into();
    }
    all
}

/// Latitude and longitude, each from 0 to 1.
#[inline(always)]
fn spherical<S: Simd>(v: Vec3x8<S>) -> Vec2x8<S> {
    let [longitude, latitude] = longitude_latitude(v);
    [latitude, longitude]
}

#[inline(never)]
fn spherical_derivative(v: DVec3, dv: DVec3) -> DVec2 {
    let radius = v.truncate().length();
    let outward = v.truncate().dot(dv.truncate()) / radius;
    let dtheta = (v.z * outward - radius * dv.z) / v.length_squared();
    DVec2::new(dtheta / PI, longitude_derivative(v, dv))
}

/// Longitude from 0 to 1, and the height on the unit sphere, as pbrt-v3 has it.
#[inline(always)]
fn cylindrical<S: Simd>(v: Vec3x8<S>) -> Vec2x8<S> {
    [(PI + angle(v.y, v.x)) * (1.0 / TAU), v.normalize_or(DVec3::ZERO).z]
}

#[inline(never)]
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
    use lookat_scene::Transform;

    use super::*;
    use crate::number::bits;
    use crate::testing::baseline;

    const NEAR: [DVec3; 2] = [DVec3::new(1e-3, 2e-3, -1e-3), DVec3::new(0.0, -1e-3, 2e-3)];

    /// A point with its neighbors.
    struct Point {
        p: DVec3,
        origin: DVec3,
        uv: DVec2,
        dp: [DVec3; 2],
        duv: [DVec2; 2],
    }

    fn place(mapping: &Mapping, at: &Point) -> (DVec2, [DVec2; 2]) {
        baseline!(simd => {
            let vectors = |v: DVec3| Vec3x8::splat(simd, v);
            let points = |v: DVec2| v.to_array().map(|x| f64x8::splat(simd, x));
            let lane = |v: Vec2x8<_>| DVec2::new(v[0][5], v[1][5]);
            let footprint = Footprint { dp: at.dp.map(vectors), duv: at.duv.map(points) };
            let texture_point =
                TexturePoint { p: vectors(at.p), origin: at.origin, uv: points(at.uv), footprint: None };
            let active = bits(simd, 1 << 5);
            let changes = changes(mapping, &texture_point, &footprint, active).map(lane);
            (lane(coordinates(mapping, &texture_point, active)), changes)
        })
    }

    fn at(p: DVec3) -> Point {
        let duv = [DVec2::new(0.1, 0.2), DVec2::new(0.3, 0.4)];
        Point { p, origin: DVec3::ZERO, uv: DVec2::new(0.25, 0.5), dp: NEAR, duv }
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
        let texture_from_world = Transform::IDENTITY;
        let on_sphere = |p| place(&Mapping::Spherical { texture_from_world }, &at(p)).0;
        assert_eq!(on_sphere(DVec3::X), DVec2::new(0.5, 0.0));
        assert_eq!(on_sphere(-DVec3::Y * 7.0), DVec2::new(0.5, 0.75));
        assert_eq!(on_sphere(DVec3::NEG_Z), DVec2::new(1.0, 0.0));
        let on_cylinder =
            place(&Mapping::Cylindrical { texture_from_world }, &at(DVec3::new(0.0, 3.0, 4.0))).0;
        assert_eq!(on_cylinder, DVec2::new(0.75, 0.8));
    }

    /// Derivatives are what differences come to.
    #[test]
    fn derivatives_are_those_of_places() {
        for mapping in &mappings()[1..] {
            let p = DVec3::new(0.4, -0.7, 0.5);
            let (st, steps) = place(mapping, &at(p));
            for (step, dp) in steps.into_iter().zip(NEAR) {
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
            let there = |p| place(&moved, &Point { origin: far, ..at(p) }).0;
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
                let dp = [DVec3::ZERO, DVec3::splat(1e300)];
                let (st, changes) =
                    place(&mapping, &Point { p, uv, dp, duv: [uv, -uv], origin: DVec3::ZERO });
                assert!(st.is_finite() && changes.iter().all(|change| change.is_finite()));
            }
        }
    }
}
