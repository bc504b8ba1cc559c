use super::ShearedRay;
use super::Triangle;
use super::*;
use crate::number::{Vec3x8, side_by_side};
use crate::ray::Ray;
use crate::testing::{levels, noise};
use crate::trace::TraversalRays;
use fearless_simd::Level;
use glam::DVec3;

fn hit(o: DVec3, d: DVec3, triangle: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
    let (t, sides) = ShearedRay::new(&Ray::new(o, d)).intersect(&triangle)?;
    Some((t, sides.map(|side| side / sides.iter().sum::<f64>())))
}

#[test]
fn finds_distance_and_weights() {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let (t, weights) = hit(DVec3::new(0.25, 0.5, -3.0), DVec3::Z, triangle).unwrap();
    assert_eq!((t, weights), (3.0, [0.25, 0.25, 0.5]));
    assert!(hit(DVec3::new(0.6, 0.6, -3.0), DVec3::Z, triangle).is_none());
    // A ray in the plane of the triangle misses.
    assert!(hit(DVec3::new(-1.0, 0.2, 0.0), DVec3::X, triangle).is_none());
}

#[test]
fn corners_in_any_order_give_the_same_distance() {
    let p = [DVec3::new(0.1, 0.2, 0.7), DVec3::new(1.3, -0.4, 0.9), DVec3::new(0.3, 1.7, 1.1)];
    let (o, d) = (DVec3::new(0.3, 0.4, -3.0), DVec3::new(0.07, 0.02, 1.0));
    let (corners, _) = sorted(p);
    let (t, weights) = hit(o, d, corners).unwrap();
    for [i, j, k] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
        let (corners, first) = sorted([p[i], p[j], p[k]]);
        assert_eq!(hit(o, d, corners), Some((t, weights)));
        assert_eq!(first.map(|at| corners[usize::from(at)]), [p[i], p[j]]);
    }
}

/// An eye in the plane of two triangles, on their edge or beside it, in planes that are rounded: nothing is met. A little above
/// the plane of an axis it meets what is below.
#[test]
fn rays_from_the_plane_of_a_triangle_miss_it() {
    for case in 0..20_000 {
        let vector = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
        let (x, d) = (vector(1.1).normalize(), vector(5.1).normalize());
        let y = x.cross(vector(2.1)).normalize();
        let size = 10_f64.powi(case as i32 % 13 - 6);
        let corner = |u: f64, v: f64| (x * u + y * v) * size;
        let o = if case % 2 == 0 { DVec3::ZERO } else { corner(noise(case, 7.1), noise(case, 8.1)) };
        let square = [corner(-4.0, -3.0), corner(4.0, -5.0), corner(4.0, 3.0), corner(-5.0, 4.0)];
        for corners in [[square[0], square[1], square[2]], [square[0], square[2], square[3]]] {
            assert_eq!(hit(o, d, corners), None, "{case}");
        }
    }
    let floor = [DVec3::new(-30.0, 0.0, -20.0), DVec3::new(30.0, 0.0, -20.0), DVec3::new(0.0, 0.0, 50.0)];
    let down = DVec3::new(0.3, -1.0, 0.2).normalize();
    for height in [1e-300, 1e-30, 1e-15, 1.0] {
        let above = DVec3::new(0.1, height, 0.7);
        assert!(hit(above, down, floor).is_some() && hit(above, -down, floor).is_none(), "{height}");
    }
}

/// A seam on the side of the boxes of both triangles, whose vertices are far beyond the hit.
#[test]
fn rays_at_a_seam_between_boxes_never_pass() {
    for half in [1e2, 1e4, 1e6, 1e9] {
        let [a, b] = [-half, half].map(|z| DVec3::new(0.5, -1.0, z));
        let (left, right) = (DVec3::new(-half, -1.0, 0.0), DVec3::new(half, -1.0, 0.0));
        for case in 0..20_000 {
            let k = f64::from(case);
            let beside =
                10_f64.powf(-17.0 + 12.0 * (k * 0.618).fract()) * if case % 2 == 0 { 1.0 } else { -1.0 };
            let o = DVec3::new((k * 0.37).sin(), 0.0, (k * 0.71).cos());
            let target = DVec3::new(0.5 + beside, -1.0, 2.0 + 48.0 * (k * 0.414).fract());
            let d = (target - o).normalize();
            let found = [[a, b, left], [a, right, b]].map(|triangle| hit(o, d, triangle));
            assert!(found.iter().any(Option::is_some), "{half} {case}");
        }
    }
}

#[test]
fn rays_at_shared_edges_and_vertices_never_pass() {
    // Two triangles that share an edge, and rays aimed at it from every side.
    let corner = |k: f64| DVec3::new((k * 0.7).sin(), (k * 1.3).cos(), (k * 0.37).sin() * 0.5);
    for case in 0..20_000 {
        let k = f64::from(case) * 0.618;
        let [p, q] = [corner(k), corner(k + 5.0)];
        let across = (q - p).cross(corner(k + 9.0)).normalize();
        let (left, right) = (p + across + 0.3 * q, q - across * 2.0);
        let along = f64::from(case % 11) / 10.0;
        let (target, o) = (p + (q - p) * along, corner(k + 2.0) * 4.0 + DVec3::splat(3.0));
        let d = (target - o).normalize();
        // Only where the two lie on opposite sides of the edge as seen from the origin.
        let normal = (p - o).cross(q - o);
        if normal.dot(left - o) * normal.dot(right - o) >= 0.0 {
            continue;
        }
        // The ends of the edge are corners of the pair: a ray may pass beyond them by rounding.
        let inner = (0.05..0.95).contains(&along);
        let hits = hit(o, d, [p, q, left]).is_some() || hit(o, d, [q, p, right]).is_some();
        assert!(hits || !inner, "case {case}");
    }
}

fn block(triangles: &[[DVec3; 3]]) -> Block {
    let triangles: Vec<Triangle> = triangles.iter().copied().map(Triangle::of_corners).collect();
    Block::new(&triangles, 0)
}

/// The triangles that a ray may meet before `t_max`, and those that it surely meets.
fn meet(level: Level, ray: &Ray, block: &Block, t_max: f64) -> (u32, u32) {
    side_by_side!(level, simd => {
        let forms = TraversalRays::new(simd, Vec3x8::splat(simd, ray.o), Vec3x8::splat(simd, ray.d));
        let (_, filter) = forms.one(simd, 0);
        let end = (t_max * f64::from(filter.length()[0])) as f32;
        let [early, late] = [filter.meet::<true>(simd, block, end, 0), filter.meet::<false>(simd, block, end, 0)]
            .map(|hits| hits.map_or((0, 0), |hits| (hits.may, hits.certain_before(end))));
        assert_eq!(early, late);
        late
    })
}

/// Triangles near and far, small and large, and rays at their edges: whatever `f64` meets, the filter lets through,
/// and little else.
#[test]
fn no_triangle_that_is_met_is_left_out() {
    let (mut met, mut extra, levels) = (0, 0, levels());
    for case in 0..40_000 {
        let (size, away) = (10_f64.powi(case as i32 % 9 - 4), 10_f64.powi(case as i32 % 7 - 1));
        let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
        let place = point(7.0) * away;
        let triangles =
            [1.0, 2.0, 3.0, 4.0, 5.0].map(|k| [0.0, 0.3, 0.6].map(|corner| place + point(k + corner) * size));
        let block = block(&triangles);
        let [p, q, _] = triangles[case % 5];
        let o = place + point(8.0) * size * 3.0;
        // At an edge, or at random.
        let target =
            if case % 2 == 0 { p + (q - p) * noise(case, 9.0).abs() } else { place + point(9.0) * size };
        let ray = Ray::new(o, (target - o).normalize());
        let sheared = ShearedRay::new(&ray);
        let t_max = if case % 3 == 0 { size } else { f64::INFINITY };
        let hits = |triangle| sheared.intersect(triangle).is_some_and(|(t, _)| t <= t_max);
        let exact: u32 =
            triangles.iter().zip(0..).map(|(triangle, lane)| u32::from(hits(triangle)) << lane).sum();
        met += exact.count_ones();
        for &level in &levels {
            let (may, _) = meet(level, &ray, &block, t_max);
            assert_eq!(exact & !may, 0, "{ray:?} {triangles:?}");
            // Where all is far larger than the triangles, f32 cannot tell.
            extra += if away <= size * 10.0 { (may & !exact).count_ones() } else { 0 };
        }
    }
    assert!(met > 10_000 && extra < met * levels.len() as u32, "{met} {extra}");
}

/// Triangles of all sizes, flat ones and points, near the ray and far from it, which ends before them, in them, at their
/// hit or a corner but for the rounding of `f32`, or beyond; and its direction has any length. What `f32` is sure of,
/// `f64` meets, with any instructions.
#[test]
fn what_is_surely_met_is_met() {
    let (mut met, mut sure, levels) = (0, 0, levels());
    for case in 0..60_000 {
        let (size, away) = (10_f64.powi(case as i32 % 9 - 6), 10_f64.powi(case as i32 % 7 - 1));
        let point = |k: f64| DVec3::new(noise(case, k), noise(case, k + 0.1), noise(case, k + 0.2));
        let place = point(7.0) * away;
        let aside = if case % 5 == 0 { point(5.0) * away } else { DVec3::ZERO };
        // Some in a plane, which the ray runs straight at, sometimes from almost there.
        let is_flat = case % 3 == 0;
        let flat = if is_flat { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
        let triangles = [1.0, 2.0, 3.0, 4.0]
            .map(|k| [0.0, 0.3, 0.6].map(|corner| place + aside + flat * point(k + corner) * size));
        let block = block(&triangles);
        let target = place + flat * point(9.0) * size * 0.5;
        let back = if is_flat { point(8.0) * DVec3::new(0.1, 0.1, 1.0) } else { point(8.0) };
        let d = -back.normalize() * 10_f64.powi(case as i32 % 13 - 6);
        let distance = if case % 2 == 0 { away.max(size) } else { noise(case, 4.3) * 1e-7 * place.length() };
        let o = target + back * 2.0 * distance;
        let ray = Ray::new(o, d);
        let sheared = ShearedRay::new(&ray);
        let near = 1.0 + 2e-7 * noise(case, 6.1);
        let corner = (triangles[case % 4][case % 3] - o).dot(d) / d.length_squared();
        let hit = triangles.iter().find_map(|triangle| sheared.intersect(triangle)).map_or(1.0, |hit| hit.0);
        for t_max in [hit * near, corner * near, hit * 0.999, hit * 1.001, 0.0, -1.0, f64::INFINITY] {
            let hits = |triangle| sheared.intersect(triangle).is_some_and(|(t, _)| t > 0.0 && t <= t_max);
            let bit = |(triangle, lane)| u32::from(hits(triangle)) << lane;
            let exact: u32 = triangles.iter().zip(0..).map(bit).sum();
            met += exact.count_ones();
            for &level in &levels {
                let (_, surely) = meet(level, &ray, &block, t_max);
                assert_eq!(surely & !exact, 0, "{ray:?} {t_max} {triangles:?}");
                sure += surely.count_ones();
            }
        }
    }
    assert!(met > 50_000 && sure > 10_000 * levels.len() as u32, "{met} {sure}");
}

/// Nor where directions are beyond what `f64` can turn.
#[test]
fn directions_of_any_length_pass() {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| (p + DVec3::Z) * 1e-3);
    let block = block(&[triangle]);
    for length in [1e-310, 1e-200, 1e-101, 1e101, 1e200, 1e290, 1e300] {
        let ray = Ray::new(DVec3::new(2e-4, 2e-4, 0.0), DVec3::Z * length);
        for (t_max, level) in [f64::INFINITY, 1.0 / length]
            .into_iter()
            .flat_map(|t| levels().into_iter().map(move |level| (t, level)))
        {
            assert_eq!(meet(level, &ray, &block, t_max), (1, 0), "{length} {t_max}");
        }
    }
}

/// Where `f32` overflows, vanishes or is not a number, `f64` decides.
#[test]
fn numbers_beyond_f32_pass() {
    for size in [1e-100, 1e-45, 1e-30, 1e19, 1e30, 1e39, 1e100] {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| (p + DVec3::Z) * size);
        let block = block(&[triangle]);
        let ray = Ray::new(DVec3::new(0.25, 0.25, 0.0) * size, DVec3::Z);
        let sheared = ShearedRay::new(&ray);
        assert!(sheared.intersect(&triangle).is_some(), "{size}");
        for (t_max, level) in
            [f64::INFINITY, size].into_iter().flat_map(|t| levels().into_iter().map(move |level| (t, level)))
        {
            assert_eq!(meet(level, &ray, &block, t_max), (1, 0), "{size} {t_max}");
        }
    }
}
