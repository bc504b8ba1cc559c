use std::array::from_fn;
use std::f64::consts::TAU;

use fearless_simd::{f64x8, prelude::*};
use glam::{DMat3, DVec2, DVec3};
use lookat_scene::{Cone, Cylinder, Disk, Hyperboloid, Paraboloid, Quadric, QuadricForm, Sphere, Transform};

use super::Curved;
use super::side_by_side::{Kind, ShapeRays, gather};
use crate::number::{LANES, Vec3x8, bits, has_compress, set_lanes, side_by_side};
use crate::ray::Ray;
use crate::testing::{levels, noise};

const WHOLE: QuadricForm = QuadricForm::Sphere(Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0 });

fn forms() -> [QuadricForm; 8] {
    let hyperboloid = |p1: [f64; 3], p2: [f64; 3]| {
        QuadricForm::Hyperboloid(Box::new(Hyperboloid { p1: p1.into(), p2: p2.into() }))
    };
    [
        QuadricForm::Sphere(Sphere { radius: 1.5, z_min: -0.8, z_max: 1.2 }),
        QuadricForm::Disk(Disk { height: 0.7, radius: 1.3, inner_radius: 0.4 }),
        QuadricForm::Cylinder(Cylinder { radius: 0.8, z_min: -0.5, z_max: 1.7 }),
        QuadricForm::Cone(Cone { radius: 1.1, height: 2.3 }),
        QuadricForm::Paraboloid(Paraboloid { radius: 1.2, z_min: 0.3, z_max: 1.9 }),
        QuadricForm::Paraboloid(Paraboloid { radius: 1.2, z_min: -0.4, z_max: 0.9 }),
        hyperboloid([1.0, 0.2, -0.7], [0.3, 1.4, 1.1]),
        hyperboloid([0.2, 0.9, 1.5], [1.1, 0.1, -0.4]),
    ]
}

fn placed(form: QuadricForm, phi_max: f64, world_from_object: Transform) -> Curved {
    Curved::new(&Quadric { form, phi_max, world_from_object }.into(), DVec3::ZERO)
}

/// Turned, stretched and mirrored.
fn skew() -> Transform {
    let turn = Transform::rotate(40.0, DVec3::new(1.0, 2.0, 0.5)).unwrap();
    let stretch = Transform::scale(DVec3::new(1.5, -0.7, 2.2)).unwrap();
    Transform::translate(DVec3::new(5.0, -3.0, 4.0)) * turn * stretch
}

/// A point of a form by pbrt-v3's parameters, in object space.
fn at(form: &QuadricForm, phi_max: f64, uv: DVec2) -> DVec3 {
    let (phi, v) = (uv.x * phi_max, uv.y);
    let turned = |r: f64, z: f64| (DVec2::from_angle(phi) * r).extend(z);
    let mix = |a: f64, b: f64| a + (b - a) * v;
    match *form {
        QuadricForm::Sphere(Sphere { radius, z_min, z_max }) => {
            let theta = mix((z_min / radius).acos(), (z_max / radius).acos());
            turned(radius * theta.sin(), radius * theta.cos())
        }
        QuadricForm::Disk(Disk { height, radius, inner_radius }) => turned(mix(radius, inner_radius), height),
        QuadricForm::Cylinder(Cylinder { radius, z_min, z_max }) => turned(radius, mix(z_min, z_max)),
        QuadricForm::Cone(Cone { radius, height }) => turned(mix(radius, 0.0), mix(0.0, height)),
        QuadricForm::Paraboloid(Paraboloid { radius, z_min, z_max }) => {
            let z = mix(z_min, z_max);
            turned(radius * (z / z_max).sqrt(), z)
        }
        QuadricForm::Hyperboloid(ref form) => {
            let Hyperboloid { p1, p2 } = **form;
            let p = p1.lerp(p2, v);
            DVec2::from_angle(phi).rotate(p.truncate()).extend(p.z)
        }
    }
}

fn grid() -> impl Iterator<Item = DVec2> {
    (0..49).map(|i| DVec2::new(0.08 + 0.14 * f64::from(i % 7), 0.46 + 0.08 * f64::from(i / 7)))
}

#[test]
fn rays_meet_each_form_where_its_parameters_say() {
    for form in forms() {
        for transform in [Transform::IDENTITY, skew()] {
            let shape = placed(form.clone(), 5.0, transform);
            for uv in grid() {
                let p = transform.point(at(&form, 5.0, uv));
                let d = DVec3::new(0.3 - uv.x, 0.8 * uv.y - 0.4, 0.6).normalize();
                let ray = Ray::new(p - d * 1e-3, d);
                let t = shape.intersect(&ray, f64::INFINITY, false).unwrap_or(f64::NAN);
                assert!((t - 1e-3).abs() < 1e-12, "{form:?} {uv} {t}");
                let (on, n) = shape.project(p + DVec3::splat(1e-9));
                let (again, off) = (shape.project(on).0.distance(on), on.distance(p));
                assert!(off < 1e-8 && again < 1e-14, "{form:?} {uv} {off} {again}");
                assert!(shape.project(p).0.distance(p) < 1e-14, "{form:?} {uv}");
                assert!((n.length() - 1.0).abs() < 1e-12, "{form:?} {uv}");
            }
        }
    }
}

#[test]
fn parameters_and_their_derivatives_are_those_of_finite_differences() {
    const STEP: f64 = 1e-5;
    for form in forms() {
        for transform in [Transform::IDENTITY, skew()] {
            let shape = placed(form.clone(), 5.0, transform);
            let point = |uv| transform.point(at(&form, 5.0, uv));
            // As pbrt-v3 has it: the normal of object space, and its change transformed.
            let own = placed(form.clone(), 5.0, Transform::IDENTITY);
            let own_normal = |uv| own.project(at(&form, 5.0, uv)).1;
            let normals = DMat3::from_mat4(transform.inverse_matrix()).transpose();
            for uv in grid() {
                let found = shape.parametric(point(uv));
                assert!(found.uv.distance(uv) < 1e-13, "{form:?} {uv} {}", found.uv);
                let (_, n) = shape.project(point(uv));
                let side = found.dpdu.cross(found.dpdv).normalize().dot(n) * transform_sign(transform);
                assert!((side - 1.0).abs() < 1e-12, "{form:?} {uv} {side}");
                for (axis, dp, dn) in [(DVec2::X, found.dpdu, found.dndu), (DVec2::Y, found.dpdv, found.dndv)]
                {
                    let (a, b) = (point(uv - axis * STEP), point(uv + axis * STEP));
                    let change = (b - a) / (2.0 * STEP);
                    assert!(change.distance(dp) < 1e-8 * dp.length(), "{form:?} {uv} {change} {dp}");
                    let change = own_normal(uv + axis * STEP) - own_normal(uv - axis * STEP);
                    let change = normals * change / (2.0 * STEP);
                    assert!(change.distance(dn) < 1e-7, "{form:?} {uv} {change} {dn}");
                }
            }
        }
    }
}

/// The normal of pbrt-v3 is dpdu x dpdv in object space, so it is on the other side in a mirror.
fn transform_sign(transform: Transform) -> f64 {
    1.0_f64.copysign(DMat3::from_mat4(transform.matrix()).determinant())
}

#[test]
fn areas_are_those_of_textbooks() {
    // pbrt-v3's formulas, but for the hyperboloid: that is summed up.
    let expected = |form: &QuadricForm, phi_max: f64| match *form {
        QuadricForm::Sphere(f) => phi_max * f.radius * (f.z_max - f.z_min),
        QuadricForm::Disk(f) => phi_max * 0.5 * (f.radius.powi(2) - f.inner_radius.powi(2)),
        QuadricForm::Cylinder(f) => (f.z_max - f.z_min) * f.radius * phi_max,
        QuadricForm::Cone(f) => f.radius * f.height.hypot(f.radius) * phi_max / 2.0,
        QuadricForm::Paraboloid(f) => {
            let k = 4.0 * f.z_max / f.radius.powi(2);
            let up_to = |z: f64| (k * z + 1.0).powf(1.5);
            f.radius.powi(4) * phi_max / (12.0 * f.z_max.powi(2)) * (up_to(f.z_max) - up_to(f.z_min.max(0.0)))
        }
        QuadricForm::Hyperboloid(_) => {
            let point =
                |i: u32, j: u32| at(form, phi_max, DVec2::new(f64::from(i) / 300.0, f64::from(j) / 300.0));
            let cell = |i, j| {
                (point(i + 1, j + 1) - point(i, j)).cross(point(i + 1, j) - point(i, j + 1)).length() / 2.0
            };
            (0..90_000).map(|at| cell(at % 300, at / 300)).sum()
        }
    };
    for form in forms() {
        for phi_max in [TAU, 2.0] {
            let shape = placed(form.clone(), phi_max, Transform::IDENTITY);
            let area: f64 = shape.cells().map(|(.., area)| area).sum();
            let expected = expected(&form, phi_max);
            assert!((area / expected - 1.0).abs() < 1e-3, "{form:?}: {area}, not {expected}");
        }
    }
}

#[test]
fn samples_are_on_the_shape_with_the_density_of_their_stretch() {
    for form in forms() {
        let shape = placed(form.clone(), 5.0, skew());
        for uv in grid() {
            let point = |u: DVec2| shape.placed(shape.sample(u)).0;
            let p = point(uv);
            assert!(shape.project(p).0.distance(p) < 1e-14, "{form:?} {uv}");
            assert!(shape.parametric(p).uv.cmpge(DVec2::splat(-1e-13)).all(), "{form:?} {uv}");
            assert!(shape.parametric(p).uv.cmple(DVec2::splat(1.0 + 1e-13)).all(), "{form:?} {uv}");
            let step = |axis: DVec2| (point(uv + axis * 1e-5) - point(uv - axis * 1e-5)) / 2e-5;
            let area = step(DVec2::X).cross(step(DVec2::Y)).length();
            assert!((shape.stretch(p) / area - 1.0).abs() < 1e-8, "{form:?} {uv}");
        }
    }
}

#[test]
fn tangent_rays_are_told_apart_at_any_distance() {
    for exponent in [1, 4, 7] {
        let far = 10_f64.powi(exponent);
        let ball = placed(WHOLE, TAU, Transform::translate(DVec3::new(0.0, 0.0, far)));
        let turned = Transform::from_matrix(glam::DMat4::from_cols_array(&TURNED)).unwrap();
        let tube = QuadricForm::Cylinder(Cylinder { radius: 1.0, z_min: -3.0, z_max: 2.0 });
        let tube = placed(tube, TAU, Transform::translate(DVec3::new(0.0, 0.0, far)) * turned);
        for (offset, expected) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
            let ray = Ray::new(DVec3::new(offset, 0.0, 0.0), DVec3::Z);
            for shape in [&ball, &tube] {
                assert_eq!(shape.intersect(&ray, f64::INFINITY, false).is_some(), expected, "{far} {offset}");
            }
        }
    }
}

/// Takes z to y, y to x, and x to z.
const TURNED: [f64; 16] = [0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn a_ray_that_leaves_a_shape_does_not_meet_where_it_starts() {
    let ball = placed(
        QuadricForm::Sphere(Sphere { radius: 2.0, z_min: -2.0, z_max: 2.0 }),
        TAU,
        Transform::IDENTITY,
    );
    let start = DVec3::new(0.0, 0.0, 2.0);
    assert_eq!(ball.intersect(&Ray::new(start, DVec3::Z), f64::INFINITY, true), None);
    assert_eq!(ball.intersect(&Ray::new(start, -DVec3::Z), f64::INFINITY, true), Some(4.0));
    assert_eq!(ball.intersect(&Ray::new(DVec3::ZERO, DVec3::X), f64::INFINITY, false), Some(2.0));
    for form in forms() {
        for transform in [Transform::IDENTITY, skew()] {
            let shape = placed(form.clone(), TAU, transform);
            for (number, uv) in grid().enumerate() {
                let p = transform.point(at(&form, TAU, uv));
                let angle = 0.7 * number as f64;
                let d = DVec3::new(angle.cos(), angle.sin(), (2.3 * angle).sin()).normalize();
                let t = shape.intersect(&Ray::new(p, d), f64::INFINITY, true);
                // From well off the surface: what is beyond is the same.
                let beyond = Ray::new(p + d * 1e-6, d);
                let expected = shape.intersect(&beyond, f64::INFINITY, false).map(|t| t + 1e-6);
                let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-9;
                assert_eq!(t.is_some(), expected.is_some(), "{form:?} {uv} {t:?} {expected:?}");
                assert!(t.zip(expected).is_none_or(near), "{form:?} {uv} {t:?} {expected:?}");
            }
        }
    }
}

#[test]
fn a_line_in_the_surface_is_no_hit_and_one_across_is() {
    let tube = QuadricForm::Cylinder(Cylinder { radius: 1.0, z_min: -1.0, z_max: 1.0 });
    let tube = placed(tube, TAU, Transform::IDENTITY);
    let along = |x: f64| tube.intersect(&Ray::new(DVec3::new(x, 0.0, -5.0), DVec3::Z), f64::INFINITY, false);
    assert_eq!([along(0.5), along(1.0), along(2.0)], [None; 3]);
    // One crossing only: up the axis of a paraboloid, and along a cone's own slope.
    let bowl = QuadricForm::Paraboloid(Paraboloid { radius: 1.0, z_min: 0.0, z_max: 4.0 });
    let up = Ray::new(DVec3::new(0.5, 0.0, -3.0), DVec3::Z);
    assert_eq!(placed(bowl, TAU, Transform::IDENTITY).intersect(&up, f64::INFINITY, false), Some(4.0));
    let cone = placed(QuadricForm::Cone(Cone { radius: 1.0, height: 1.0 }), TAU, Transform::IDENTITY);
    let slope = Ray::new(DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(cone.intersect(&slope, f64::INFINITY, false), Some(1.5));
}

#[test]
fn only_similar_transformations_keep_a_sphere() {
    let turn = Transform::rotate(30.0, DVec3::ONE).unwrap();
    let double = Transform::scale(DVec3::splat(2.0)).unwrap();
    let stretch = Transform::scale(DVec3::new(1.0, 1.0, 1.01)).unwrap();
    let radius = |transform| placed(WHOLE, TAU, transform).as_sphere().unwrap().world_radius;
    assert!((radius(turn * double).unwrap() - 2.0).abs() < 1e-14);
    assert_eq!(radius(turn * stretch), None);
}

/// Whole and cut forms of all kinds, in places near and far, small and large.
fn shapes() -> Vec<Curved> {
    let moved = |x: f64, size: f64| {
        Transform::translate(DVec3::new(x, -0.3 * x, 0.7 * x))
            * skew()
            * Transform::scale(DVec3::splat(size)).unwrap()
    };
    let places = [Transform::IDENTITY, skew(), moved(1e5, 1.0), moved(0.0, 1e-6), moved(0.0, 1e7)];
    let cylinder = QuadricForm::Cylinder(Cylinder { radius: 1.0, z_min: -1.0, z_max: 1.0 });
    let disk = QuadricForm::Disk(Disk { height: 0.0, radius: 1.0, inner_radius: 0.0 });
    let all = forms().into_iter().chain([WHOLE, cylinder, disk]);
    let sweeps = [TAU, 5.0, 2.0, 3.2];
    all.flat_map(|form| {
        places.iter().flat_map(move |place| {
            let form = form.clone();
            sweeps.map(move |phi_max| placed(form.clone(), phi_max, *place))
        })
    })
    .collect()
}

/// A ray at the shape, and whether it leaves it: from outside and inside, along axes, at its rim, from points of it, past it, short ones.
fn ray_at(shape: &Curved, i: usize) -> (Ray, bool) {
    let vector = |k: f64| DVec3::new(noise(i, k), noise(i, k + 0.3), noise(i, k + 0.7));
    let on = |k: f64| shape.placed(shape.sample(DVec2::new(noise(i, k).abs(), noise(i, k + 0.5).abs())));
    let size = shape.half_extent().max_element();
    let (p, n) = on(1.1);
    let o = match i % 5 {
        0 => shape.center + vector(2.2) * size * 0.3,
        1 => p,
        _ => shape.center + vector(2.2) * size * [2.0, 50.0, 4.0][i % 3],
    };
    let d = match i % 7 {
        // Towards it, or inwards.
        0 | 1 => on(3.3).0 - o,
        // Along its axes.
        2 => shape.world_from_own() * [DVec3::X, DVec3::Y, DVec3::Z][i / 7 % 3],
        // Nearly touching it.
        3 => on(4.4).0 + n * size * 10_f64.powi(-(i as i32 / 7 % 17)) - o,
        4 => n.cross(vector(5.5)),
        5 => vector(5.5) * DVec3::new(1.0, 0.0, 1.0),
        _ => vector(6.6),
    };
    let d = if i.is_multiple_of(4) { d } else { d.normalize_or(DVec3::Z) };
    let t_max = if i.is_multiple_of(3) { size * 3.0 * noise(i, 7.7).abs() } else { f64::INFINITY };
    (Ray { t_max, ..Ray::new(o, d) }, i % 5 == 1 && i.is_multiple_of(2))
}

/// Eight rays have the bits that each has alone: against one shape, and each against another of its kind.
#[test]
fn rays_meet_side_by_side_what_they_meet_alone() {
    let (shapes, mut case) = (shapes(), 0);
    let (mut met, mut hidden, mut tested, mut doubts) = (0, 0, 0, 0);
    for shape in &shapes {
        let alike: Vec<&Curved> = shapes.iter().filter(|other| other.kind() == shape.kind()).collect();
        for round in 0..60 {
            let is_mixed = round % 2 == 1 && shape.kind() != Kind::WholeSphere;
            let of: [&Curved; LANES] =
                from_fn(|lane| if is_mixed { alike[(case + lane) * 7 % alike.len()] } else { shape });
            let rays: [(Ray, bool); LANES] = from_fn(|lane| ray_at(of[lane], case + lane));
            case += LANES;
            for level in levels() {
                side_by_side!(level, simd => {
                    let none = Vec3x8::splat(simd, DVec3::ZERO);
                    let (mut o, mut d, mut t_max, mut leaving) = (none, none, none.x, 0);
                    for (lane, (ray, leaves)) in rays.iter().enumerate() {
                        o.set_lane(lane, ray.o);
                        d.set_lane(lane, ray.d);
                        t_max[lane] = ray.t_max;
                        leaving |= u64::from(*leaves) << lane;
                    }
                    let active = bits(simd, !0 >> 56 & !(round as u64));
                    let mut all = ShapeRays { o, d, t_max, leaving: bits(simd, leaving), active };
                    if !is_mixed {
                        let hides = shape.hides_ends_of(&all).to_bitmask();
                        for lane in set_lanes(active) {
                            let (ray, leaves) = rays[lane];
                            assert_eq!(hides >> lane & 1 == 1, shape.hides_end_of(&ray, leaves), "{ray:?} {shape:?}");
                        }
                        hidden += hides.count_ones();
                    }
                    let found = if is_mixed {
                        for (lane, (ray, _)) in rays.iter().enumerate() {
                            let (o, d) = of[lane].own_ray(ray);
                            all.o.set_lane(lane, o);
                            all.d.set_lane(lane, d);
                        }
                        let columns = gather(&of);
                        all.meet(shape.kind(), |at| columns[at].simd_into(simd), false)
                    } else {
                        shape.meet(&all)
                    };
                    assert_eq!((found.met | found.doubtful).to_bitmask() & !active.to_bitmask(), 0);
                    for lane in set_lanes(active) {
                        let (ray, leaves) = rays[lane];
                        let alone = of[lane].intersect(&ray, ray.t_max, leaves);
                        met += usize::from(alone.is_some());
                        if has_compress(simd) {
                            tested += 1;
                            doubts += usize::from(found.doubtful.to_bitmask() >> lane & 1 == 1);
                        }
                        if found.doubtful.to_bitmask() >> lane & 1 == 1 {
                            continue;
                        }
                        let together = (found.met.to_bitmask() >> lane & 1 == 1).then(|| found.t[lane].to_bits());
                        assert_eq!(together, alone.map(f64::to_bits), "{ray:?} {leaves} {:?}", of[lane]);
                    }
                });
            }
        }
    }
    assert!(met > 50_000 && hidden > 1000 && doubts * 5 < tested, "{met} {hidden} {doubts} of {tested}");
}

/// Points are brought onto shapes, and sampled, side by side as they are alone.
#[test]
fn points_are_projected_and_sampled_side_by_side_as_they_are_alone() {
    let name = |(p, n): (DVec3, DVec3)| [p, n].map(|v| v.to_array().map(f64::to_bits));
    for (number, shape) in shapes().iter().enumerate() {
        for round in 0..20 {
            let near = |lane: usize| {
                let i = (number * 20 + round) * LANES + lane;
                let p = shape.placed(shape.sample(DVec2::new(noise(i, 1.1).abs(), noise(i, 2.2).abs()))).0;
                let size = shape.half_extent().max_element() * [0.0, 1e-12, 1e-7][i % 3];
                p + DVec3::new(noise(i, 3.3), noise(i, 4.4), noise(i, 5.5)) * size
            };
            for level in levels() {
                side_by_side!(level, simd => {
                    let mut points = Vec3x8::splat(simd, shape.center);
                    for lane in 1..LANES {
                        points.set_lane(lane, near(lane));
                    }
                    let u = [6.6, 7.7].map(|k| f64x8::from_fn(simd, |lane| noise(number * 20 + round + lane, k).abs()));
                    let (on, normals, stretches) = shape.sample_all(u);
                    let (p, n) = shape.project_all(points);
                    for lane in 0..LANES {
                        let (found, alone) = ((p.lane(lane), n.lane(lane)), shape.project(points.lane(lane)));
                        assert_eq!(name(found), name(alone), "{shape:?}");
                        let sample = shape.placed(shape.sample(DVec2::new(u[0][lane], u[1][lane])));
                        assert_eq!(name((on.lane(lane), normals.lane(lane))), name(sample), "{shape:?}");
                        assert_eq!(stretches[lane].to_bits(), shape.stretch(sample.0).to_bits(), "{shape:?}");
                    }
                });
            }
        }
    }
}
