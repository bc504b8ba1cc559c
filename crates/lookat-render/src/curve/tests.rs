use super::*;

fn curve(seed: f64) -> [DVec3; 4] {
    [0.0, 1.0, 2.0, 3.0].map(|k| {
        let k = seed * 3.7 + k;
        DVec3::new((k * 1.9).sin(), (k * 3.1).cos(), (k * 0.8).sin()) + DVec3::X * (k % 1.0)
    })
}

#[test]
fn a_part_is_the_same_curve() {
    let whole = curve(0.3);
    let part = subcurve(&whole, 0.25, 0.75);
    for u in [0.0, 0.4, 1.0] {
        let (p, dp) = evaluate(&part, u);
        let (q, dq) = evaluate(&whole, 0.25 + 0.5 * u);
        assert!(p.distance(q) < 1e-15 && (dp * 2.0).distance(dq) < 1e-14);
    }
}

/// All minima of the distance, against a walk along the curve in small steps.
#[test]
fn falls_are_where_the_distance_is_least() {
    for case in 0..2000 {
        let points = curve(f64::from(case));
        let mut found = Vec::new();
        falls(&approach(&points), &mut |u| found.push(u));
        let steps = 2000;
        let distance = |k: i32| evaluate(&points, f64::from(k) / f64::from(steps)).0.length();
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
            let (p, dp) = evaluate(&points, u);
            assert!(p.dot(dp).abs() < 1e-12, "{case}: {u}");
        }
    }
}

#[test]
fn a_curve_that_starts_with_a_point_twice_has_a_round_end() {
    let behind = [DVec3::X, DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0];
    let mut found = Vec::new();
    falls(&approach(&behind), &mut |u| found.push(u));
    assert_eq!(found, [0.0]);
    let none = [DVec3::X, DVec3::X * 1.5, DVec3::X * 2.0, DVec3::X * 3.0];
    falls(&approach(&none), &mut |_| panic!("a straight end"));
}
