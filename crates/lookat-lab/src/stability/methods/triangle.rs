//! Ray against triangle: the distance of the hit. Both sides can be hit.

use num_traits::Float;

use super::{Vector, along, cross, dot, gamma, sub};

/// Three corners.
pub(in crate::stability) type Triangle<T> = [Vector<T>; 3];

/// A formula: origin, direction, corners.
pub(in crate::stability) type Formula<T> = fn(Vector<T>, Vector<T>, &Triangle<T>) -> Option<T>;

/// The formulas in single precision.
pub(in crate::stability) const SINGLE: [(&str, Formula<f32>); 6] = [
    ("Möller-Trumbore f32", moeller_trumbore),
    ("Möller-Trumbore f32, epsilon", moeller_trumbore_epsilon),
    ("Baldwin-Weber f32", baldwin_weber),
    ("Woop f32", woop),
    ("Plücker f32", pluecker),
    ("pbrt-v3", pbrt_v3),
];

/// And in double precision.
pub(in crate::stability) const DOUBLE: [(&str, Formula<f64>); 4] = [
    ("Möller-Trumbore f64", moeller_trumbore),
    ("Baldwin-Weber f64", baldwin_weber),
    ("Woop f64", woop),
    ("Plücker f64", pluecker),
];

/// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", Journal of Graphics Tools 2(1), 1997.
fn moeller_trumbore<T: Float>(o: Vector<T>, d: Vector<T>, triangle: &Triangle<T>) -> Option<T> {
    moeller_trumbore_above(o, d, triangle, T::zero())
}

/// The same with the threshold of the paper's listing for rays in the plane.
fn moeller_trumbore_epsilon(o: Vector<f32>, d: Vector<f32>, triangle: &Triangle<f32>) -> Option<f32> {
    moeller_trumbore_above(o, d, triangle, 1e-6)
}

fn moeller_trumbore_above<T: Float>(
    o: Vector<T>,
    d: Vector<T>,
    [a, b, c]: &Triangle<T>,
    least: T,
) -> Option<T> {
    let (e1, e2) = (sub(*b, *a), sub(*c, *a));
    let p = cross(d, e2);
    let det = dot(e1, p);
    if det == T::zero() || det.abs() < least {
        return None;
    }
    let s = sub(o, *a);
    let u = dot(s, p) / det;
    let q = cross(s, e1);
    let v = dot(d, q) / det;
    let inside = u >= T::zero() && v >= T::zero() && u + v <= T::one();
    ahead(dot(e2, q) / det).filter(|_| inside)
}

fn ahead<T: Float>(t: T) -> Option<T> {
    (t > T::zero()).then_some(t)
}

/// Baldwin and Weber, "Fast Ray-Triangle Intersections by Coordinate Transformation", JCGT 5(3), 2016: to the space in
/// which the triangle has the corners 0, (1, 0) and (0, 1), by a matrix with a column of the identity.
fn baldwin_weber<T: Float>(o: Vector<T>, d: Vector<T>, [a, b, c]: &Triangle<T>) -> Option<T> {
    let (e1, e2) = (sub(*b, *a), sub(*c, *a));
    let n = cross(e1, e2);
    let size = n.map(T::abs);
    // The column is that of the longest coordinate of the normal, so that the others are bounded.
    let i = if size[0] > size[1] && size[0] > size[2] {
        0
    } else if size[1] > size[2] {
        1
    } else {
        2
    };
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    let (x1, x2) = (cross(*b, *a), cross(*c, *a));
    let row_u = [e2[k] / n[i], -e2[j] / n[i], x2[i] / n[i]];
    let row_v = [-e1[k] / n[i], e1[j] / n[i], -x1[i] / n[i]];
    let row_t = [n[j] / n[i], n[k] / n[i], -dot(*a, n) / n[i]];
    let height = o[i] + row_t[0] * o[j] + row_t[1] * o[k] + row_t[2];
    let slope = d[i] + row_t[0] * d[j] + row_t[1] * d[k];
    let t = ahead(-height / slope)?;
    let p = along(o, d, t);
    let [u, v] = [row_u, row_v].map(|row| row[0] * p[j] + row[1] * p[k] + row[2]);
    (u >= T::zero() && v >= T::zero() && u + v <= T::one()).then_some(t)
}

/// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
fn woop<T: Float>(o: Vector<T>, d: Vector<T>, triangle: &Triangle<T>) -> Option<T> {
    Sheared::new(o, d, triangle).distance()
}

/// A triangle where the ray is the z axis.
struct Sheared<T> {
    corners: [Vector<T>; 3],
    /// Twice the areas between the ray and each edge, as far as `T` tells them.
    edges: Vector<T>,
}

impl<T: Float> Sheared<T> {
    fn new(o: Vector<T>, d: Vector<T>, triangle: &Triangle<T>) -> Self {
        let size = d.map(T::abs);
        let (xy, xz, yz) = (size[0] > size[1], size[0] > size[2], size[1] > size[2]);
        let z = if xy && xz {
            0
        } else if !xy && yz {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = [-d[x] / d[z], -d[y] / d[z], d[z].recip()];
        let corners = triangle.map(|corner| {
            let p = sub(corner, o);
            [p[x] + shear[0] * p[z], p[y] + shear[1] * p[z], shear[2] * p[z]]
        });
        let [a, b, c] = corners;
        let mut edges = [edge(b, c), edge(c, a), edge(a, b)];
        if edges.contains(&T::zero()) {
            edges = [edge_in_double(b, c), edge_in_double(c, a), edge_in_double(a, b)];
        }
        Sheared { corners, edges }
    }

    fn det(&self) -> T {
        self.edges[0] + self.edges[1] + self.edges[2]
    }

    fn distance(&self) -> Option<T> {
        let (zero, det) = (T::zero(), self.det());
        let (below, above) = (self.edges.iter().any(|e| *e < zero), self.edges.iter().any(|e| *e > zero));
        if below && above || det == zero {
            return None;
        }
        ahead(dot(self.edges, self.corners.map(|p| p[2])) / det)
    }
}

fn edge<T: Float>(p: Vector<T>, q: Vector<T>) -> T {
    p[0] * q[1] - p[1] * q[0]
}

/// For `f32`: products are exact. For `f64` there is nothing wider, and nothing changes.
fn edge_in_double<T: Float>(p: Vector<T>, q: Vector<T>) -> T {
    let wide = |x: T| x.to_f64().unwrap_or(f64::NAN);
    T::from(edge(p.map(wide), q.map(wide))).unwrap_or_else(T::nan)
}

/// pbrt-v3 (PBR 3.6.2 and 3.9.6): the test of Woop et al., and no hit where the distance is within its error bound, or
/// where the normal has no length.
fn pbrt_v3(o: Vector<f32>, d: Vector<f32>, triangle: &Triangle<f32>) -> Option<f32> {
    let sheared = Sheared::new(o, d, triangle);
    let t = sheared.distance()?;
    let largest = |v: Vector<f32>| v.into_iter().fold(0.0, |max: f32, x| max.max(x.abs()));
    let [x, y, z] = [0, 1, 2].map(|i| largest(sheared.corners.map(|p| p[i])));
    let delta_z = gamma::<f32>(3) * z;
    let (delta_x, delta_y) = (gamma::<f32>(5) * (x + z), gamma::<f32>(5) * (y + z));
    let delta_e = 2.0 * (gamma::<f32>(2) * x * y + delta_y * x + delta_x * y);
    let e = largest(sheared.edges);
    let delta_t = 3.0 * (gamma::<f32>(3) * e * z + delta_e * z + delta_z * e) * sheared.det().recip().abs();
    let normal = cross(sub(triangle[2], triangle[0]), sub(triangle[1], triangle[0]));
    (t > delta_t && dot(normal, normal) != 0.0).then_some(t)
}

/// Plücker coordinates (Jones, "Intersecting a Ray and a Triangle with Plücker Coordinates", Ray Tracing News 13(1), 2000)
/// with corners relative to the origin of the ray, and with edges as wide as rounding, as in Embree.
fn pluecker<T: Float>(o: Vector<T>, d: Vector<T>, triangle: &Triangle<T>) -> Option<T> {
    let [a, b, c] = triangle.map(|corner| sub(corner, o));
    let [ca, ab, bc] = [sub(c, a), sub(a, b), sub(b, c)];
    let side = |edge, p: Vector<T>, q: Vector<T>| dot(cross(edge, std::array::from_fn(|i| p[i] + q[i])), d);
    let sides = [side(ca, c, a), side(ab, a, b), side(bc, b, c)];
    let margin = T::epsilon() * (sides[0] + sides[1] + sides[2]).abs();
    if !(sides.iter().all(|s| *s >= -margin) || sides.iter().all(|s| *s <= margin)) {
        return None;
    }
    let n = cross(ca, ab);
    ahead(dot(a, n) / dot(n, d))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays through known points, seen from all sides, so that each axis is the longest once.
    fn check<T: Float>(formula: Formula<T>, name: &str, tolerance: f64) {
        let number = |x: f64| T::from(x).unwrap();
        let triangle = [[1.0, 0.2, 0.1], [-0.7, 0.9, 0.3], [-0.2, -0.8, -0.6]];
        let corners = triangle.map(|p| p.map(number));
        let at = |weights: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| (0..3).map(|k| weights[k] * triangle[k][i]).sum())
        };
        for axis in 0..3 {
            for side in [-3.0, 3.0] {
                let mut o = [0.4, 0.5, 0.3];
                o[axis] = side;
                let ask = |target: [f64; 3]| {
                    let d: [f64; 3] = std::array::from_fn(|i| target[i] - o[i]);
                    formula(o.map(number), d.map(number), &corners)
                };
                for weights in [[0.3, 0.3, 0.4], [0.05, 0.05, 0.9], [0.9, 0.06, 0.04]] {
                    let t = ask(at(weights)).map(|t| t.to_f64().unwrap());
                    assert!(
                        t.is_some_and(|t| (t - 1.0).abs() < tolerance),
                        "{name} {o:?} {weights:?}: {t:?}"
                    );
                }
                for weights in [[-0.1, 0.5, 0.6], [0.5, -0.1, 0.6], [0.5, 0.6, -0.1], [-0.1, -0.1, 1.2]] {
                    assert!(ask(at(weights)).is_none(), "{name} {o:?} {weights:?}");
                }
                // Behind the origin.
                let through = at([0.3, 0.3, 0.4]);
                assert!(ask(std::array::from_fn(|i| 2.0 * o[i] - through[i])).is_none(), "{name} {o:?}");
            }
        }
    }

    #[test]
    fn formulas_find_what_is_easy() {
        SINGLE.into_iter().for_each(|(name, formula)| check(formula, name, 1e-5));
        DOUBLE.into_iter().for_each(|(name, formula)| check(formula, name, 1e-13));
    }

    /// A square of half size S around the foot of an eye at height 1: pbrt-v3 loses none to 1e5, and half at 5e5.
    #[test]
    fn the_error_bound_of_pbrt_hides_what_it_is_known_to_hide() {
        let lost = |s: f32| {
            let triangle = [[-s, 0.0, -s], [s, 0.0, -s], [s, 0.0, s]];
            let rays = (0..1000).map(|i| 0.9 * i as f32 / 1000.0);
            rays.filter(|x| pbrt_v3([0.5 * s, 1.0, 0.0], [0.5 - x, -1.0 / s, -0.4], &triangle).is_none())
                .count()
        };
        assert_eq!(lost(1e3), 0);
        assert!(lost(1e7) > 500);
    }
}
