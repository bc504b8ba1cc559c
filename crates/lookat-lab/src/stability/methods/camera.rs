//! Camera rays as pbrt makes them, matrix by matrix, and in closed form.

use num_traits::{Float, FloatConst};

use super::{Vector, cross, dot, sub};

/// A matrix for column vectors, row by row.
pub(in crate::stability) type Matrix<T> = [[T; 4]; 4];

fn of<T: Float>(x: f64) -> T {
    T::from(x).expect("every precision holds a rounded number")
}

fn identity<T: Float>() -> Matrix<T> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { T::one() } else { T::zero() }))
}

fn product<T: Float>(a: Matrix<T>, b: Matrix<T>) -> Matrix<T> {
    let entry =
        |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] + a[i][3] * b[3][j];
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Applies a matrix to a position, with the division by w (PBR 2.8).
pub(in crate::stability) fn point<T: Float>(m: &Matrix<T>, p: Vector<T>) -> Vector<T> {
    let row = |i: usize| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3];
    let w = row(3);
    std::array::from_fn(|i| if w == T::one() { row(i) } else { row(i) / w })
}

/// Applies a matrix to a direction.
pub(in crate::stability) fn vector<T: Float>(m: &Matrix<T>, v: Vector<T>) -> Vector<T> {
    std::array::from_fn(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

pub(in crate::stability) fn normalize<T: Float>(v: Vector<T>) -> Vector<T> {
    let scale = dot(v, v).sqrt().recip();
    v.map(|x| x * scale)
}

/// Gauss and Jordan's method with full pivoting, as in pbrt-v3's `Inverse`.
fn inverse<T: Float>(mut m: Matrix<T>) -> Matrix<T> {
    let (mut done, mut swaps) = ([false; 4], Vec::new());
    for _ in 0..4 {
        let (row, column) = pivot(&m, done);
        done[column] = true;
        m.swap(row, column);
        swaps.push((row, column));
        let scale = m[column][column].recip();
        m[column][column] = T::one();
        m[column] = m[column].map(|x| x * scale);
        let source = m[column];
        for (_, target) in m.iter_mut().enumerate().filter(|(i, _)| *i != column) {
            let factor = target[column];
            target[column] = T::zero();
            for (x, y) in target.iter_mut().zip(source) {
                *x = *x - y * factor;
            }
        }
    }
    for (row, column) in swaps.into_iter().rev() {
        m.iter_mut().for_each(|r| r.swap(row, column));
    }
    m
}

fn pivot<T: Float>(m: &Matrix<T>, done: [bool; 4]) -> (usize, usize) {
    let free = || (0..4).filter(|i| !done[*i]);
    let places = free().flat_map(|i| free().map(move |j| (i, j)));
    places.fold((4, 4), |best, (i, j)| {
        let is_larger = best.0 == 4 || m[i][j].abs() >= m[best.0][best.1].abs();
        if is_larger { (i, j) } else { best }
    })
}

fn scaling<T: Float>(by: [T; 2]) -> Matrix<T> {
    let mut m = identity();
    (m[0][0], m[1][1]) = (by[0], by[1]);
    m
}

/// pbrt's screen window: xmin, xmax, ymin, ymax.
pub(in crate::stability) type Window<T> = [T; 4];

/// From -1 to 1 along the shorter axis.
pub(in crate::stability) fn default_window<T: Float>(resolution: [T; 2]) -> Window<T> {
    let frame = resolution[0] / resolution[1];
    let one = T::one();
    if frame > one { [-frame, frame, -one, one] } else { [-one, one, -one / frame, one / frame] }
}

/// The inverse of pbrt's `ScreenToRaster` (PBR 6.1.1), composed of the inverses of its parts.
fn screen_from_raster<T: Float>(window: Window<T>, resolution: [T; 2]) -> Matrix<T> {
    let [x0, x1, y0, y1] = window;
    let mut translation = identity();
    (translation[0][3], translation[1][3]) = (x0, y1);
    let one = T::one();
    let size = scaling([one / (one / (x1 - x0)), one / (one / (y0 - y1))]);
    let pixels = scaling(resolution.map(|n| one / n));
    product(translation, product(size, pixels))
}

/// pbrt's `RasterToCamera` of a perspective camera (PBR 6.2.2), with its planes at 0.01 and 1000.
pub(in crate::stability) fn perspective<T: Float + FloatConst>(
    degrees: T,
    window: Window<T>,
    resolution: [T; 2],
) -> Matrix<T> {
    let (near, far): (T, T) = (of(1e-2), of(1000.0));
    let mut projection = identity();
    projection[2] = [T::zero(), T::zero(), far / (far - near), -far * near / (far - near)];
    projection[3] = [T::zero(), T::zero(), T::one(), T::zero()];
    let radians = T::PI() / of(180.0) * degrees;
    let scale = T::one() / (T::one() / (radians / of(2.0)).tan());
    let camera_from_screen = product(inverse(projection), scaling([scale, scale]));
    product(camera_from_screen, screen_from_raster(window, resolution))
}

/// pbrt's `RasterToCamera` of an orthographic camera (PBR 6.2.1).
pub(in crate::stability) fn orthographic<T: Float>(window: Window<T>, resolution: [T; 2]) -> Matrix<T> {
    screen_from_raster(window, resolution)
}

/// The cross product of pbrt-v3: in `f64`, then rounded.
fn cross_in_double<T: Float>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    let double = |v: Vector<T>| v.map(|x| x.to_f64().unwrap_or(f64::NAN));
    cross(double(a), double(b)).map(of)
}

/// pbrt's `LookAt` (PBR 2.7.7): the world from the camera; `None` where its side vector has no length.
pub(in crate::stability) fn look_at<T: Float>(
    eye: Vector<T>,
    look: Vector<T>,
    up: Vector<T>,
) -> Option<Matrix<T>> {
    let forward = normalize(sub(look, eye));
    let side = cross_in_double(normalize(up), forward);
    if dot(side, side).sqrt() == T::zero() || forward.iter().any(|x| x.is_nan()) {
        return None;
    }
    let right = normalize(side);
    Some(columns(right, cross_in_double(forward, right), forward, eye))
}

/// The side vector by Kahan's difference of products, normalized last: pbrt-v4's `DifferenceOfProducts` (PBR4 3.3.2).
pub(in crate::stability) fn side_by_kahan(
    eye: Vector<f64>,
    look: Vector<f64>,
    up: Vector<f64>,
) -> Vector<f64> {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let cd = c * d;
        a.mul_add(b, -cd) + (-c).mul_add(d, cd)
    };
    let (a, b) = (up, sub(look, eye));
    normalize([
        difference(a[1], b[2], a[2], b[1]),
        difference(a[2], b[0], a[0], b[2]),
        difference(a[0], b[1], a[1], b[0]),
    ])
}

fn columns<T: Float>(x: Vector<T>, y: Vector<T>, z: Vector<T>, origin: Vector<T>) -> Matrix<T> {
    let (zero, one) = (T::zero(), T::one());
    let row = |i: usize| [x[i], y[i], z[i], origin[i]];
    [row(0), row(1), row(2), [zero, zero, zero, one]]
}

/// The direction in the camera through a point of the film: by pbrt's matrices (PBR 6.2.2).
pub(in crate::stability) fn by_matrices<T: Float>(camera_from_raster: &Matrix<T>, film: [T; 2]) -> Vector<T> {
    normalize(point(camera_from_raster, [film[0], film[1], T::zero()]))
}

/// The same without matrices: an interpolation of the window's edges, times the tangent (Shirley and
/// Marschner, "Fundamentals of Computer Graphics", 4.3).
pub(in crate::stability) fn direct<T: Float>(
    degrees: T,
    window: Window<T>,
    resolution: [T; 2],
    film: [T; 2],
) -> Vector<T> {
    let lerp = |t: T, a: T, b: T| (T::one() - t) * a + t * b;
    let scale = (degrees.to_radians() / of(2.0)).tan();
    let [x0, x1, y0, y1] = window;
    let x = lerp(film[0] / resolution[0], x0, x1) * scale;
    let y = lerp(film[1] / resolution[1], y1, y0) * scale;
    normalize([x, y, T::one()])
}

/// pbrt's thin lens (PBR 6.2.3): the direction from a point of the lens to where the ray `d` through its center meets
/// the plane of focus.
pub(in crate::stability) fn thin_lens<T: Float>(d: Vector<T>, lens: [T; 2], focal_distance: T) -> Vector<T> {
    let focus = d.map(|x| x * (focal_distance / d[2]));
    normalize(sub(focus, [lens[0], lens[1], T::zero()]))
}

/// The same divided by the focal distance, which then overflows nothing.
pub(in crate::stability) fn scaled_lens<T: Float>(
    d: Vector<T>,
    lens: [T; 2],
    focal_distance: T,
) -> Vector<T> {
    let scale = d[2] / focal_distance;
    normalize([d[0] - lens[0] * scale, d[1] - lens[1] * scale, d[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vector<f64>, b: Vector<f64>, tolerance: f64) {
        assert!(sub(a, b).iter().all(|x| x.abs() <= tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn the_inverse_of_a_matrix_undoes_it() {
        let m = [[0.0, 2.0, 0.5, 1.0], [3.0, 0.0, -1.0, 2.0], [1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 4.0]];
        let unit = product(m, inverse(m));
        for (i, row) in unit.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((x - f64::from(u8::from(i == j))).abs() < 1e-14, "{unit:?}");
            }
        }
    }

    #[test]
    fn matrices_and_closed_form_give_the_same_ray() {
        // A landscape film: 90 degrees reach from -1 to 1 on its height.
        let resolution = [640.0, 480.0];
        let window = default_window(resolution);
        let corner = normalize([4.0 / 3.0, -1.0, 1.0]);
        let camera = perspective(90.0, window, resolution);
        near(by_matrices(&camera, [640.0, 480.0]), corner, 1e-13);
        near(direct(90.0, window, resolution, [640.0, 480.0]), corner, 1e-15);
        let half = perspective(90.0_f32, [-4.0 / 3.0, 4.0 / 3.0, -1.0, 1.0], [640.0, 480.0]);
        near(by_matrices(&half, [640.0, 480.0]).map(f64::from), corner, 1e-6);
    }

    #[test]
    fn the_orthographic_window_is_met_at_its_corners() {
        let camera = orthographic([1.0, 3.0, -2.0, 5.0], [20.0, 70.0]);
        near(point(&camera, [0.0, 0.0, 0.0]), [1.0, 5.0, 0.0], 1e-14);
        near(point(&camera, [20.0, 70.0, 0.0]), [3.0, -2.0, 0.0], 1e-14);
    }

    #[test]
    fn look_at_is_left_handed() {
        let (eye, look, up) = ([3.0, 4.0, 5.0], [3.0, 4.0, 9.0], [0.0, 2.0, 1.0]);
        let camera = look_at(eye, look, up).unwrap();
        near(point(&camera, [0.0; 3]), eye, 0.0);
        near(vector(&camera, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0], 1e-15);
        near(side_by_kahan(eye, look, up), [1.0, 0.0, 0.0], 1e-15);
        assert!(look_at(eye, eye, up).is_none());
        assert!(look_at(eye, look, [0.0, 0.0, 1.0]).is_none());
    }

    #[test]
    fn both_forms_of_the_lens_meet_in_the_focus() {
        let d = normalize([0.3, -0.2, 1.0]);
        let expected = normalize([0.3 * 4.0 - 0.5, -0.2 * 4.0 + 0.1, 4.0]);
        near(thin_lens(d, [0.5, -0.1], 4.0), expected, 1e-15);
        near(scaled_lens(d, [0.5, -0.1], 4.0), expected, 1e-15);
    }
}
