//! Ray against box: whether the ray, without end, meets the closed box.

use super::{Vector, gamma};

/// The corners of a box.
pub(in crate::stability) type Box32 = [Vector<f32>; 2];

/// pbrt-v3, `Bounds3::IntersectP` with the inverse direction (PBR 4.3.1).
pub(in crate::stability) fn pbrt_v3(bounds: Box32, o: Vector<f32>, d: Vector<f32>) -> bool {
    let inverse = d.map(|x| 1.0 / x);
    let negative = inverse.map(|x| usize::from(x < 0.0));
    let near = |i: usize| (bounds[negative[i]][i] - o[i]) * inverse[i];
    let far = |i: usize| (bounds[1 - negative[i]][i] - o[i]) * inverse[i] * (1.0 + 2.0 * gamma::<f32>(3));
    let (mut t_min, mut t_max) = (near(0), far(0));
    for i in [1, 2] {
        let (near, far) = (near(i), far(i));
        if t_min > far || near > t_max {
            return false;
        }
        t_min = if near > t_min { near } else { t_min };
        t_max = if far < t_max { far } else { t_max };
    }
    t_min < f32::INFINITY && t_max > 0.0
}

/// pbrt-v3, `Bounds3::IntersectP` that gives both distances (PBR 3.1.2).
pub(in crate::stability) fn pbrt_v3_loop(bounds: Box32, o: Vector<f32>, d: Vector<f32>) -> bool {
    let (mut t_min, mut t_max) = (0.0_f32, f32::INFINITY);
    for i in 0..3 {
        let inverse = 1.0 / d[i];
        let (mut near, mut far) = ((bounds[0][i] - o[i]) * inverse, (bounds[1][i] - o[i]) * inverse);
        if near > far {
            std::mem::swap(&mut near, &mut far);
        }
        far *= 1.0 + 2.0 * gamma::<f32>(3);
        t_min = if near > t_min { near } else { t_min };
        t_max = if far < t_max { far } else { t_max };
        if t_min > t_max {
            return false;
        }
    }
    true
}

/// Both slabs ordered by a minimum and a maximum that leave out what is not a number (Kay and Kajiya, "Ray Tracing Complex
/// Scenes", 1986, as it is mostly written today). Far distances are multiplied by `pad`.
pub(in crate::stability) fn min_max(bounds: Box32, o: Vector<f32>, d: Vector<f32>, pad: f32) -> bool {
    let (mut t_min, mut t_max) = (0.0_f32, f32::INFINITY);
    for i in 0..3 {
        let inverse = 1.0 / d[i];
        let (a, b) = ((bounds[0][i] - o[i]) * inverse, (bounds[1][i] - o[i]) * inverse);
        t_min = t_min.max(a.min(b));
        t_max = t_max.min(a.max(b) * pad);
    }
    t_min <= t_max
}

/// The same with the minimum and maximum of SSE, which give their second operand where one is not a number.
pub(in crate::stability) fn sse(bounds: Box32, o: Vector<f32>, d: Vector<f32>) -> bool {
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let max = |a: f32, b: f32| if a > b { a } else { b };
    let (mut t_min, mut t_max) = (0.0_f32, f32::INFINITY);
    for i in 0..3 {
        let inverse = 1.0 / d[i];
        let (a, b) = ((bounds[0][i] - o[i]) * inverse, (bounds[1][i] - o[i]) * inverse);
        t_min = max(min(a, b), t_min);
        t_max = min(max(a, b), t_max);
    }
    t_min <= t_max
}

/// The padding of pbrt-v3 (PBR 3.9.2).
pub(in crate::stability) fn pbrt_pad() -> f32 {
    1.0 + 2.0 * gamma::<f32>(3)
}

/// The padding of Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013: two steps of the far distance.
pub(in crate::stability) const IZE_PAD: f32 = 1.000_000_2;

/// The box, larger by the least step on each side.
pub(in crate::stability) fn grown([low, high]: Box32) -> Box32 {
    [low.map(f32::next_down), high.map(f32::next_up)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bounds: Box32, o: Vector<f32>, d: Vector<f32>) -> [bool; 6] {
        [
            pbrt_v3(bounds, o, d),
            pbrt_v3_loop(bounds, o, d),
            min_max(bounds, o, d, 1.0),
            min_max(bounds, o, d, pbrt_pad()),
            min_max(grown(bounds), o, d, 1.0),
            sse(bounds, o, d),
        ]
    }

    #[test]
    fn they_agree_where_it_is_easy() {
        let bounds = [[-1.0, -2.0, 3.0], [1.0, 2.0, 5.0]];
        let hits = [
            ([0.0, 0.0, 0.0], [0.1, -0.2, 1.0]),
            ([0.5, 0.5, 4.0], [1.0, 0.3, -0.2]),
            ([3.0, 0.1, 9.0], [-0.5, 0.1, -1.0]),
        ];
        for (o, d) in hits {
            assert_eq!(all(bounds, o, d), [true; 6], "{o:?} {d:?}");
            let back = d.map(|x| -x);
            let inside = o == [0.5, 0.5, 4.0];
            assert_eq!(all(bounds, o, back), [inside; 6], "{o:?} {back:?}");
        }
        for (o, d) in [([0.0, 0.0, 0.0], [1.0, 0.2, 0.9]), ([5.0, 0.1, 4.0], [-0.5, 1.0, 0.1])] {
            assert_eq!(all(bounds, o, d), [false; 6], "{o:?} {d:?}");
        }
    }

    /// An axis-parallel ray through the inside is no trouble yet.
    #[test]
    fn they_take_zero_components() {
        for zero in [0.0, -0.0] {
            assert_eq!(all([[0.0; 3], [1.0; 3]], [0.5, 0.5, -1.0], [zero, zero, 1.0]), [true; 6]);
            assert_eq!(all([[0.0; 3], [1.0; 3]], [1.5, 0.5, -1.0], [zero, zero, 1.0]), [false; 6]);
        }
    }
}
