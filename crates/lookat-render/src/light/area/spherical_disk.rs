//! Disks, sampled by the solid angle at which points see them.
//!
//! The cone of a disk meets the plane across its axis in an ellipse (Guillén et al., "Area-Preserving Parameterizations for Spherical
//! Ellipses", 2017). Along each ray from the middle of the ellipse, the density is that of the solid angle exactly. The angles of these rays
//! have a density that is the solid angle's along both axes of the ellipse, and off by at most a tenth between: it takes no elliptic
//! integrals, and is 1 where the ellipse is a circle or small.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec3;

use super::spherical_triangle::NEAR;
use super::{Density, LightHits, SurfaceLight};
use crate::curved::Curved;
use crate::light::LightSample;
use crate::light::Receivers;
use crate::number::{Vec2x8, Vec3x8, vectorized};
use crate::surface::{ShapePoint, Surfaces};
use crate::warp::square_to_disk;

/// Whole disks as points see them.
struct SphericalDisks<S: Simd> {
    radius: f64x8<S>,
    /// The axes of the disk: away from the point, across, and its normal.
    axes: [Vec3x8<S>; 3],
    /// The distance of its middle from the point, along the first axis and the last.
    across: f64x8<S>,
    height: f64x8<S>,
    /// The direction of the axis of the cone, along the first axis and the last.
    middle: [f64x8<S>; 2],
    /// Half the axes of the ellipse at distance 1.
    half: [f64x8<S>; 2],
    /// The factor of the tangents of angles in the ellipse, which makes their density that of the solid angle along both of its axes.
    stretch: f64x8<S>,
    /// The points that sample the disk by solid angle. Points in its plane sample no light.
    is_in_range: mask64x8<S>,
}

/// The widest ellipse: beyond it, a point is on the disk.
const WIDEST: f64 = 1e6;

/// The solid angle in an ellipse along a ray of this squared length, over that and what the length alone brings.
#[inline(always)]
fn share<S: Simd>(squared: f64x8<S>) -> f64x8<S> {
    let root = (squared + 1.0).sqrt();
    1.0 / (root * (root + 1.0))
}

impl<S: Simd> SphericalDisks<S> {
    #[inline(always)]
    fn new(simd: S, shape: &Curved, ([x, _, n], radius): ([DVec3; 3], f64), at: &Surfaces<S>) -> Self {
        let to = Vec3x8::splat(simd, shape.center) - at.p;
        let n = Vec3x8::splat(simd, n);
        let height = to.dot(n);
        // Any axes do for points above the middle.
        let (aside, squared) = (n.cross(to), to.length_squared());
        let is_aside = aside.length_squared().simd_gt(squared * 1e-26);
        let y = aside.keep_where(is_aside, n.cross(Vec3x8::splat(simd, x))).normalize();
        let x = y.cross(n);
        let across = is_aside.select(to.dot(x), 0.0.simd_into(simd));
        let radius: f64x8<S> = radius.simd_into(simd);
        let (nearest, farthest, h) = (across - radius, across + radius, height.abs());
        let (l1, l2) = ((nearest * nearest + h * h).sqrt(), (farthest * farthest + h * h).sqrt());
        let (product, dot) = (l1 * l2, nearest * farthest + h * h);
        let sine = radius * h * 2.0;
        let half_x = dot.simd_gt(0.0).select(sine / (product + dot), (product - dot) / sine);
        // Over the disk, the two terms of mx nearly cancel: there, times and over their difference.
        let over = h * h * (nearest - farthest) * (nearest + farthest) / (nearest * l2 - farthest * l1);
        let mx = nearest.simd_lt(0.0).select(over, nearest * l2 + farthest * l1);
        let mz = height * (l1 + l2);
        let inverse = 1.0 / (mx * mx + mz * mz).sqrt();
        let half_y = radius * 2.0 * product.sqrt() * inverse;
        let stretch = (share(half_y * half_y) / share(half_x * half_x)).sqrt();
        let is_near = squared.simd_lt(radius * radius * (4.0 * NEAR));
        let is_above = h.simd_gt(at.rounding(shape.magnitude().simd_into(simd)));
        let is_narrow = half_x.max(half_y).simd_lt(WIDEST) & half_x.min(half_y).simd_gt(1.0 / WIDEST);
        SphericalDisks {
            radius,
            axes: [x, y, n],
            across,
            height,
            middle: [mx * inverse, mz * inverse],
            half: [half_x, half_y],
            stretch,
            is_in_range: is_near & is_above & is_narrow & stretch.is_finite(),
        }
    }

    /// The inverse of the density in directions that lie at this angle in the ellipse: about the solid angle of the disk. The angle is given by
    /// its cosine and sine in the circle that the ellipse is stretched from.
    #[inline(always)]
    fn solid_angle(&self, [cos, sin]: [f64x8<S>; 2]) -> f64x8<S> {
        let [a, b] = self.half;
        let (squared_cos, squared_sin) = (cos * cos, sin * sin);
        let part = share(a * a * squared_cos + b * b * squared_sin) * a * b;
        part * TAU * (self.stretch * squared_cos + squared_sin / self.stretch)
    }

    /// The inverse of the density in given directions to the disk.
    #[inline(always)]
    fn solid_angle_towards(&self, d: Vec3x8<S>) -> f64x8<S> {
        let ([x, y, n], [mx, mz], [a, b]) = (self.axes, self.middle, self.half);
        let (dx, dy, dz) = (d.dot(x), d.dot(y), d.dot(n));
        self.solid_angle(unit([(dx * mz - dz * mx) * b, dy * a]))
    }

    /// Places on the disk, along its first two axes from its middle, and the solid angles whose inverses are their densities.
    #[inline(always)]
    fn sample(&self, [p, q]: Vec2x8<S>) -> (Vec2x8<S>, f64x8<S>) {
        let ([mx, mz], [a, b]) = (self.middle, self.half);
        let squared = p * p + q * q;
        let angle = unit([p, q * self.stretch]);
        let [cos, sin] = angle;
        let length = a * a * cos * cos + b * b * sin * sin;
        let share = share(length);
        let part = 1.0 - squared * share * length;
        let rho = (squared * share * (part + 1.0)).max(0.0).sqrt() / part;
        let (x, y) = (a * rho * cos, b * rho * sin);
        let t = self.height / (mz - x * mx);
        ([t * (mx + x * mz) - self.across, t * y], self.solid_angle(angle))
    }
}

/// The vectors scaled to length one; the first axis for the zero vector.
#[inline(always)]
fn unit<S: Simd>([x, y]: Vec2x8<S>) -> Vec2x8<S> {
    let squared = x * x + y * y;
    let is_valid = squared.simd_gt(f64::MIN_POSITIVE);
    let inverse = 1.0 / squared.sqrt();
    [
        is_valid.select(x * inverse, 1.0.simd_into(x.token())),
        is_valid.select(y * inverse, 0.0.simd_into(x.token())),
    ]
}

impl SurfaceLight {
    /// Directions to points of a whole disk.
    #[inline(never)]
    pub(super) fn sample_disk<S: Simd>(
        &self,
        simd: S,
        (shape, disk): (&Curved, ([DVec3; 3], f64)),
        at: &Receivers<S>,
        u: Vec2x8<S>,
    ) -> LightSample<S> {
        vectorized!(simd, {
            let seen = SphericalDisks::new(simd, shape, disk, &at.surfaces);
            let [p, q] = square_to_disk(u);
            let ([x, y], solid_angle) = seen.sample([p, q]);
            let is_by_angle = seen.is_in_range;
            let (x, y) = (is_by_angle.select(x, p * seen.radius), is_by_angle.select(y, q * seen.radius));
            let [x_axis, y_axis, n] = seen.axes;
            let p = Vec3x8::splat(simd, shape.center) + x_axis * x + y_axis * y;
            let emitting = if self.primitive.reverse_orientation { -n } else { n };
            let magnitude = shape.magnitude().simd_into(simd);
            let on_light = ShapePoint { p, magnitude, n, ns: n, emitting };
            let density = Density { area: self.area.simd_into(simd), solid_angle, is_by_angle };
            self.towards(at, &on_light, self.label.simd_into(simd), &density)
        })
    }

    /// The densities with which points of a whole disk are sampled.
    #[inline(never)]
    pub(super) fn disk_density<S: Simd>(
        &self,
        simd: S,
        (shape, disk): (&Curved, ([DVec3; 3], f64)),
        at: &Surfaces<S>,
        found: &LightHits<S>,
    ) -> Density<S> {
        vectorized!(simd, {
            let seen = SphericalDisks::new(simd, shape, disk, at);
            let solid_angle = seen.solid_angle_towards(found.d);
            Density { area: self.area.simd_into(simd), solid_angle, is_by_angle: seen.is_in_range }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use fearless_simd::mask32x8;
    use glam::DVec2;

    use super::*;
    use crate::bsdf::Domain;
    use crate::light::{LightTable, SceneLight};
    use crate::number::{baseline, bits};
    use crate::prepare::Prepared;
    use crate::testing::{noise, scene, surfaces_at};

    /// A disk of this radius in the plane z = 0 that emits on both sides.
    fn disk(radius: f64) -> LightTable {
        let scene = scene(&format!(
            "Film \"image\" Camera \"perspective\" WorldBegin
             AreaLightSource \"diffuse\" \"bool twosided\" \"true\" Shape \"disk\" \"float radius\" {radius:e} WorldEnd"
        ));
        Prepared::new(&scene).lights
    }

    /// A sample from a point: its direction, the end of its shadow ray, its density, and that which is said afterwards of the direction.
    #[derive(Debug)]
    struct Drawn {
        d: DVec3,
        end: DVec3,
        pdf: f64,
        afterwards: f64,
    }

    fn drawn<S: Simd>(simd: S, table: &LightTable, p: DVec3, u: DVec2) -> Option<Drawn> {
        let SceneLight::Surface(light) = &table.lights[0] else { unreachable!() };
        let surfaces = &surfaces_at(simd, p);
        let (all, none) = (bits(simd, 0xff), bits(simd, 0));
        let [is_two_sided, is_diffuse] = [true, false].map(|all| mask32x8::splat(simd, all));
        let domain = Domain { n: surfaces.n, ns: surfaces.n, is_two_sided, is_diffuse };
        let at = Receivers { surfaces: *surfaces, domain, lunes: None };
        let sample = table.sample(simd, 0, (&at, none), (None, [u.x.simd_into(simd), u.y.simd_into(simd)]));
        if sample.is_valid.to_bitmask() & 1 == 0 {
            return None;
        }
        let magnitude = light.radius.simd_into(simd);
        let end = sample.shadow.at(sample.shadow.t_max + surfaces.rounding(magnitude));
        let d = sample.shadow.d;
        let found = LightHits {
            is_valid: all,
            d,
            p: end,
            n: surfaces.n.widen(),
            triangle: 0.simd_into(simd),
            by_triangle: false,
        };
        let afterwards = table.surface_pdf(simd, 0, surfaces, &found);
        let [pdf, afterwards] = [sample.pdf, afterwards].map(|pdf| f64::from(pdf[0]));
        Some(Drawn { d: d.lane(0), end: end.lane(0), pdf, afterwards })
    }

    const SIDE: u32 = 64;

    fn grid() -> impl Iterator<Item = DVec2> {
        let cell = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
        (0..SIDE * SIDE).map(move |i| DVec2::new(cell(i % SIDE), cell(i / SIDE)))
    }

    /// How far points are aside of the axis and from the plane, in radii: above the disk, its edge, beside it, far away.
    const PLACES: [[f64; 2]; 10] = [
        [0.0, 0.3],
        [0.0, -2.0],
        [0.5, 0.05],
        [0.95, 0.02],
        [1.0, 0.1],
        [1.1, -0.05],
        [3.0, 0.2],
        [1e-9, 1.0],
        [12.0, 5.0],
        [40.0, 20.0],
    ];

    /// On a surface that is parallel to the disk (Howell and Menguc, "Radiative transfer configuration factor catalog", B-13).
    #[test]
    fn samples_bring_the_irradiance_of_the_disk() {
        for size in [1.0, 1e-9, 1e9] {
            let table = disk(size);
            for [aside, height] in PLACES {
                let p = DVec3::new(0.6 * aside, 0.8 * aside, height) * size;
                let mean: f64 = baseline!(simd => grid()
                    .map(|u| drawn(simd, &table, p, u).map_or(0.0, |drawn| drawn.d.z.abs() / drawn.pdf))
                    .sum());
                let squares = aside * aside + height * height;
                let root = ((squares + 1.0).powi(2) - 4.0 * aside * aside).sqrt();
                let expected = PI / 2.0 * (1.0 - (squares - 1.0) / root);
                let mean = mean / f64::from(SIDE * SIDE);
                assert!((mean / expected - 1.0).abs() < 3e-3, "{size} {aside} {height}: {mean} {expected}");
            }
        }
    }

    /// Close to one over the solid angle: above the middle, exactly.
    #[test]
    fn densities_are_about_one_over_the_solid_angle() {
        let table = disk(1.0);
        for [aside, height] in &PLACES[..8] {
            let p = DVec3::new(*aside, 0.0, *height);
            let pdfs: Vec<f64> =
                baseline!(simd => grid().filter_map(|u| Some(drawn(simd, &table, p, u)?.pdf)).collect());
            assert_eq!(pdfs.len() as u32, SIDE * SIDE);
            let solid_angle = pdfs.iter().map(|pdf| pdf.recip()).sum::<f64>() / pdfs.len() as f64;
            // Densities are `f32`.
            let rounding = f64::from(f32::EPSILON);
            let most = if *aside < 1e-6 { rounding } else { 0.1 };
            assert!(pdfs.iter().all(|pdf| (pdf * solid_angle - 1.0).abs() <= most), "{aside} {height}");
            if *aside < 1e-6 {
                let expected = 2.0 * PI * (1.0 - height.abs() / height.hypot(1.0));
                assert!(
                    (solid_angle / expected - 1.0).abs() < rounding,
                    "{height}: {solid_angle} {expected}"
                );
            }
        }
    }

    #[test]
    fn densities_said_afterwards_are_those_of_samples() {
        let mut lit = 0;
        for size in [1.0, 1e-9, 1e9] {
            let table = disk(size);
            for (case, aside) in
                [0.0, 1e-14, 1e-9, 0.3, 0.999, 1.0, 1.001, 2.0, 15.0, 17.0, 1e3].into_iter().enumerate()
            {
                for height in [0.0, 1e-12, 1e-9, -1e-6, 1e-3, 0.1, -1.0, 10.0, 1e3, -1e9] {
                    for k in 0..12 {
                        let p = DVec3::new(-0.6 * aside, 0.8 * aside, height) * size;
                        let u = DVec2::new(noise(k, case as f64 + 0.3).abs(), noise(k, 2.7).abs());
                        // Not the very middle: the density there depends on an angle that rounding decides.
                        let near_middle = DVec2::new(0.5, 0.501);
                        let u = [u, DVec2::ZERO, near_middle, DVec2::splat(1.0 - f64::EPSILON)]
                            [k.saturating_sub(8).min(3)];
                        let Some(drawn) = baseline!(simd => drawn(simd, &table, p, u)) else {
                            assert!(height.abs() < 1e-8, "{size} {aside} {height} {u}");
                            continue;
                        };
                        lit += 1;
                        let what = format!("{size} {aside} {height} {u}: {drawn:?}");
                        // The end of the ray is rounded, and so is the cosine.
                        let distance = drawn.end.distance(p) / size;
                        let tolerance = 1e-6 + 1e-11 / distance + 1e-14 / drawn.d.z.abs();
                        assert!((drawn.afterwards / drawn.pdf - 1.0).abs() < tolerance, "{what}");
                        assert!(drawn.end.truncate().length() < size * (1.0 + 1e-6), "{what}");
                    }
                }
            }
        }
        assert!(lit > 2500, "{lit}");
    }
}
