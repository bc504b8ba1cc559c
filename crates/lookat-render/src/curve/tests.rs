use lookat_scene::{CurveKind, Transform};

use super::bezier::subcurve;
use super::*;

const POINTS: [DVec3; 4] = [
    DVec3::new(-1.0, 0.0, 0.0),
    DVec3::new(-0.2, 1.4, 0.8),
    DVec3::new(0.3, -1.2, 0.5),
    DVec3::new(1.0, 0.6, -0.4),
];

fn curve(kind: CurveKind, transform: Transform) -> Curve {
    let further = [POINTS[3], POINTS[3] * 2.0 - POINTS[2], DVec3::new(1.5, 0.1, 1.0), DVec3::X * 2.0];
    let segments = vec![POINTS, further];
    Curve { segments, kind, widths: [0.2, 0.05], split_depth: 3, world_from_object: transform.into() }
}

fn straight(width: f64, length: f64) -> Curve {
    let points = [0.0, 1.0, 2.0, 3.0].map(|k| DVec3::X * (k * length / 3.0));
    let world_from_object = Transform::IDENTITY;
    Curve {
        segments: vec![points],
        kind: CurveKind::Flat,
        widths: [width; 2],
        split_depth: 2,
        world_from_object: world_from_object.into(),
    }
}

fn nearest(curves: &Curves, ray: &Ray, leaving: Option<u32>) -> Option<(u32, Meeting)> {
    let all = (0..curves.pieces.len() as u32)
        .filter_map(|piece| Some((piece, curves.meet(piece, ray, f64::INFINITY, leaving)?)));
    all.min_by(|a, b| a.1.t.total_cmp(&b.1.t))
}

fn random_ray(case: u32) -> Ray {
    let k = f64::from(case) * 0.618;
    let around = DVec3::new((k * 1.7).sin(), (k * 2.3).cos(), (k * 0.9).sin());
    let o = DVec3::new((k * 0.7).cos(), (k * 1.1).sin(), (k * 3.3).cos()) * 4.0;
    Ray::new(o, (around - o).normalize())
}

/// The first place where the curve, seen along a ray and taken for many short ones, is as near as half its width.
fn by_steps(curve: &Curve, ray: &Ray) -> Option<f64> {
    const STEPS: u32 = 4000;
    let mut curves = Curves::default();
    curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    let view = curves.segments[0].view(ray, DVec3::X.into());
    let mut least: Option<f64> = None;
    for (segment, points) in curve.segments.iter().enumerate() {
        let seen = points.map(|p| view.see((p - curve.segments[0][0]).into()));
        let at = |step: u32| DVec3::from(evaluate(&seen, f64::from(step) / f64::from(STEPS))[0]);
        for step in 1..STEPS {
            let [a, p, b] = [step - 1, step, step + 1].map(at);
            let share = (segment as f64 + f64::from(step) / f64::from(STEPS)) / 2.0;
            let [near, least_here, far] = [a, p, b].map(|p| p.truncate().length());
            let width = 0.2 + (0.05 - 0.2) * share;
            if least_here <= near && least_here <= far && least_here <= 0.5 * width && p.z > 0.0 {
                least = Some(least.map_or(p.z / view.length, |t| t.min(p.z / view.length)));
            }
        }
    }
    least
}

#[test]
fn meetings_are_those_of_many_short_steps() {
    let stretch =
        Transform::rotate(30.0, DVec3::ONE).unwrap() * Transform::scale(DVec3::new(1.0, -0.5, 1.5)).unwrap();
    for transform in [Transform::IDENTITY, stretch] {
        let curve = curve(CurveKind::Flat, transform);
        let mut curves = Curves::default();
        curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
        let (mut hits, mut other) = (0, 0);
        for case in 0..1500 {
            let ray = random_ray(case);
            let found = nearest(&curves, &ray, None).map(|(_, meeting)| meeting.t);
            let expected = by_steps(&curve, &ray);
            hits += u32::from(found.is_some());
            // Rays at the very edge or end may be told otherwise by steps.
            other += u32::from(match (found, expected) {
                (Some(a), Some(b)) => (a - b).abs() > 2e-3,
                (a, b) => a.is_some() != b.is_some(),
            });
        }
        assert!(hits > 60 && other <= hits / 50, "{other} of {hits}");
    }
}

/// Whatever is met lies in the box of its piece.
#[test]
fn boxes_hold_all_meetings() {
    let turn = Transform::rotate(50.0, DVec3::new(1.0, 2.0, 0.3)).unwrap();
    let transform =
        Transform::translate(DVec3::X * 0.3) * turn * Transform::scale(DVec3::new(2.0, 0.3, -1.0)).unwrap();
    let curve = curve(CurveKind::Cylinder, transform);
    let mut curves = Curves::default();
    let boxes = curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    let mut hits = 0;
    for case in 0..4000 {
        let ray = random_ray(case);
        for (piece, [low, high], _) in &boxes {
            let Some(meeting) = curves.meet(*piece, &ray, f64::INFINITY, None) else { continue };
            let p = ray.at(meeting.t);
            hits += 1;
            assert!(p.cmpge(low - 1e-12).all() && p.cmple(high + 1e-12).all(), "{case}: {p} {low} {high}");
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn u_runs_along_and_v_across() {
    let curve = straight(0.5, 3.0);
    let mut curves = Curves::default();
    curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    // pbrt-v3's figures: seen along +z, v grows with y.
    let ray = Ray::new(DVec3::new(0.75, 0.125, -2.0), DVec3::Z);
    let (piece, meeting) = nearest(&curves, &ray, None).unwrap();
    assert!((meeting.t - 2.0).abs() < 1e-15);
    assert!(meeting.uv.distance(DVec2::new(0.25, 0.75)) < 1e-9, "{}", meeting.uv);
    let [dpdu, dpdv] = curves.segments[0].tangents(DVec3::Z, meeting.uv);
    assert!(dpdu.distance(DVec3::X * 3.0) < 1e-14 && dpdv.distance(DVec3::Y * 0.5) < 1e-14);
    assert!(curves.normal(piece, &ray, meeting.uv).distance(DVec3::Z) < 1e-14);
}

/// Nothing is met beyond straight ends and sides, and everything up to them.
#[test]
fn a_straight_curve_is_a_rectangle() {
    let curve = straight(0.5, 3.0);
    let mut curves = Curves::default();
    curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    let met = |x, y| nearest(&curves, &Ray::new(DVec3::new(x, y, -2.0), DVec3::Z), None).is_some();
    for inside in 0..1000 {
        let share = f64::from(inside) / 999.0;
        assert!(met(3.0 * share, 0.25 - 0.5 * (share * 17.0).fract()), "{share}");
    }
    for (x, y) in [(-1e-9, 0.0), (3.0 + 1e-8, 0.0), (1.0, 0.25 + 1e-12), (1.0, -0.25 - 1e-12)] {
        assert!(!met(x, y), "{x} {y}");
    }
}

/// A ray that leaves a curve does not meet it where it starts, at however flat an angle, from whatever place.
#[test]
fn a_ray_does_not_meet_the_straight_curve_that_it_leaves() {
    for length in [1.0, 100.0] {
        let curve = straight(0.1, length);
        let mut curves = Curves::default();
        curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
        for case in 0..2000 {
            let k = f64::from(case) * 0.618;
            let aim = DVec3::new(length * (k * 1.7).fract(), 0.099 * ((k * 2.9).fract() - 0.5), 0.0);
            let ray = Ray::new(aim - DVec3::Z * 2.0 + DVec3::X * (k * 3.1).fract(), DVec3::Z);
            let Some((piece, meeting)) = nearest(&curves, &ray, None) else { continue };
            let slope = 10_f64.powf(-4.0 * (k * 0.7).fract());
            let d = DVec3::new((k * 5.3).sin().signum(), slope * (k * 4.1).sin(), -slope * (k * 4.1).cos());
            let left = nearest(&curves, &Ray::new(ray.at(meeting.t), d.normalize()), Some(piece));
            assert_eq!(left, None, "{length} {case}: {d}");
        }
    }
}

/// It is met where it bends back into the way.
#[test]
fn a_ray_meets_the_far_side_of_a_bend_that_it_leaves() {
    let points = [DVec3::ZERO, DVec3::X * 4.0, DVec3::new(4.0, 0.0, 1.0), DVec3::Z];
    let kind = CurveKind::Flat;
    let world_from_object = Transform::IDENTITY;
    let curve = Curve {
        segments: vec![points],
        kind,
        widths: [0.1; 2],
        split_depth: 3,
        world_from_object: world_from_object.into(),
    };
    let mut curves = Curves::default();
    curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    let ray = Ray::new(DVec3::new(1.0, 0.0, -1.0), DVec3::Z);
    let (piece, first) = nearest(&curves, &ray, None).unwrap();
    let (_, second) = nearest(&curves, &Ray::new(ray.at(first.t), DVec3::Z), Some(piece)).unwrap();
    assert!(second.t > 0.5 && second.uv.x > 0.5, "{second:?}");
}

#[test]
fn a_ribbon_is_seen_as_it_is_turned() {
    let mut curve = straight(0.5, 3.0);
    curve.kind = CurveKind::Ribbon(vec![DVec3::Z, DVec3::Y]);
    let mut curves = Curves::default();
    curves.add(&Arc::new(curve.clone()), DVec3::ZERO);
    // Half of the width is seen where it is turned by 60 degrees.
    for (y, expected) in [(0.124, true), (0.126, false)] {
        let ray = Ray::new(DVec3::new(2.0, y, -2.0), DVec3::Z);
        assert_eq!(nearest(&curves, &ray, None).is_some(), expected);
    }
    let ray = Ray::new(DVec3::new(1.5, 0.0, -2.0), DVec3::Z);
    let (piece, meeting) = nearest(&curves, &ray, None).unwrap();
    let normal = curves.normal(piece, &ray, meeting.uv);
    assert!(normal.dot(DVec3::new(0.0, 1.0, 1.0).normalize()).abs() > 1.0 - 1e-9, "{normal}");
}

fn random_points(seed: f64) -> Points<f64> {
    [0.0, 1.0, 2.0, 3.0].map(|k| {
        let k = seed * 3.7 + k;
        V3 { x: (k * 1.9).sin() + k % 1.0, y: (k * 3.1).cos(), z: (k * 0.8).sin() }
    })
}

#[test]
fn a_part_is_the_same_curve() {
    let whole = random_points(0.3);
    let part = subcurve(&whole, [0.25, 0.75]);
    for u in [0.0, 0.4, 1.0] {
        let [p, dp] = evaluate(&part, u).map(DVec3::from);
        let [q, dq] = evaluate(&whole, 0.25 + 0.5 * u).map(DVec3::from);
        assert!(p.distance(q) < 1e-15 && (dp * 2.0).distance(dq) < 1e-14);
    }
}

/// All minima of the distance, against a walk along the curve in small steps.
#[test]
fn falls_are_where_the_distance_is_least() {
    for case in 0..2000 {
        let points = random_points(f64::from(case));
        let mut found = Vec::new();
        falls(&approach(&points), &mut |u| found.push(u));
        let steps = 2000;
        let distance = |k: i32| evaluate(&points, f64::from(k) / f64::from(steps))[0].length_squared();
        let least: Vec<f64> = (1..steps)
            .filter(|k| distance(*k) <= distance(k - 1) && distance(*k) < distance(k + 1))
            .map(|k| f64::from(k) / f64::from(steps))
            .collect();
        // Those within some steps of an end may be counted or not.
        let inner = |u: &f64| (0.005..=0.995).contains(u);
        found.retain(inner);
        let least: Vec<f64> = least.into_iter().filter(inner).collect();
        assert_eq!(found.len(), least.len(), "{case}: {found:?} {least:?}");
        assert!(found.iter().zip(&least).all(|(a, b)| (a - b).abs() < 0.001), "{found:?} {least:?}");
        for u in found {
            let [p, dp] = evaluate(&points, u);
            assert!(p.dot(dp).abs() < 1e-12, "{case}: {u}");
        }
    }
}

#[test]
fn a_curve_that_starts_with_a_point_twice_has_a_round_end() {
    let behind = [1.0, 1.0, 2.0, 3.0].map(|x| V3::from(DVec3::X * x));
    let mut found = Vec::new();
    falls(&approach(&behind), &mut |u| found.push(u));
    assert_eq!(found, [0.0]);
    let none = [1.0, 1.5, 2.0, 3.0].map(|x| V3::from(DVec3::X * x));
    falls(&approach(&none), &mut |_| panic!("a straight end"));
}

/// No ray to a point within half a width of a piece is left out; most others are.
#[test]
fn capsules_hold_their_pieces() {
    let stretch =
        Transform::rotate(30.0, DVec3::ONE).unwrap() * Transform::scale(DVec3::new(1.0, -0.5, 1.5)).unwrap();
    for (transform, origin) in [(Transform::IDENTITY, DVec3::ZERO), (stretch, DVec3::new(1e6, -2e4, 3.0))] {
        let curve = Arc::new(curve(CurveKind::Flat, transform));
        let mut curves = Curves::default();
        curves.add(&curve, origin);
        let mut passed = 0;
        for case in 0..4000 {
            let Ray { o, d, .. } = random_ray(case);
            let piece = &curves.pieces[case as usize % 16];
            let segment = &curves.segments[piece.segment as usize];
            let part = segment.part(piece.range());
            let at = f64::from(case) * 0.37 % 1.0;
            let width = segment.widths.at(part.range[0] + (part.range[1] - part.range[0]) * at);
            let end = DVec3::from(evaluate(&part.points, at)[0]) + d.any_orthonormal_vector() * (0.5 * width);
            let end = segment.anchor + *curve.world_from_object.linear() * end;
            let capsule = segment.capsule(&part);
            let ray = Ray::new(o - origin, end - (o - origin));
            let may_meet = |d: DVec3, t_max: f64| capsule.numbers().may_meet(ray.o.into(), d.into(), t_max);
            assert!(may_meet(ray.d, 1.0 + 1e-9) && may_meet(ray.d, f64::INFINITY), "{ray:?}");
            assert!(!may_meet(ray.d, 0.1) && !may_meet(-ray.d, 1.0));
            passed += u32::from(!may_meet(d, f64::INFINITY));
        }
        assert!(passed > 3000, "{passed} of 4000 rays pass");
    }
}
