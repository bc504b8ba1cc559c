//! Rays from the camera: C1 to C20.

use twofloat::TwoFloat;

use super::double_double::{Wide, quotient};
use super::exact_camera::{CameraAxes, LookAt, Pinhole, angle};
use super::*;
use crate::text_scene::film;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("C1", |trial| view(trial, &Pinhole::new(NEAR, trial.at, SQUARE), near_middle, Pinhole::pixels)),
    ("C2", |trial| view(trial, &Pinhole::new(NEAR, trial.at, SQUARE), near_middle, Pinhole::radians)),
    ("C3", |trial| view(trial, &Pinhole::new(NEAR, 180.0 - trial.at, SQUARE), near_middle, Pinhole::radians)),
    ("C4", |trial| view(trial, &Pinhole::new(far(trial.at), 45.0, [1920, 1080]), anywhere, Pinhole::pixels)),
    ("C5", lens_far_away),
    ("C6", up_near_view),
    ("C9", |trial| {
        view(trial, &Pinhole::new(distant_target(trial.at), 45.0, [1024; 2]), in_f32, Pinhole::radians)
    }),
    ("C10", |trial| through_lens(trial, 1.0, trial.at)),
    ("C12", |trial| if trial.at.is_nan() { negative_radius() } else { through_lens(trial, trial.at, 10.0) }),
    ("C13", |trial| if trial.at.is_nan() { Tally::default() } else { telecentric(trial) }),
    ("C14", off_center),
    ("C15", |_| reversed_window()),
    ("C16", window),
    ("C17", portrait),
    ("C18", scaled),
    ("C19", |_| numbers()),
];

/// The text of a scene for its camera. Only a few pixels of the film are rendered, so the film may have any size.
fn text(camera: &str, size: [u32; 2]) -> String {
    let film = film(size) + " \"float cropwindow\" [.5 .51 .5 .51]";
    format!(
        "{camera} {film} Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\" WorldEnd"
    )
}

const SQUARE: [u32; 2] = [16384; 2];

const NEAR: LookAt = [DVec3::new(3.0, 4.0, 5.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Z];

/// An eye this far from the origin with a target 10 from it: numbers without pattern.
fn far(distance: f64) -> LookAt {
    let eye = distance * DVec3::new(0.6180339887, 0.3141592653, 0.7206834121)
        + DVec3::new(0.123456789, 0.23456789, 0.3456789);
    [eye, eye + DVec3::new(6.12345678, 7.0123456, 3.54321), DVec3::Z]
}

fn distant_target(distance: f64) -> LookAt {
    let near = DVec3::new(1e8, 0.0, 0.0);
    match distance {
        1.0 => [near, near + DVec3::X, DVec3::Z],
        _ => [DVec3::new(1.0, 2.0, 3.0), distance * DVec3::new(0.3, 0.5, -0.8), DVec3::Y],
    }
}

/// A point of the film.
type Place = fn(&mut Pcg64Mcg, [u32; 2]) -> DVec2;

/// The largest error of a camera. `error` measures one random ray.
fn errors(
    trial: &Trial,
    camera: &str,
    film: [u32; 2],
    error: impl Fn(&mut Pcg64Mcg, &PreparedScene) -> f64 + Sync,
) -> Tally {
    let prepared = prepared(&text(camera, film));
    tally(trial.rays, trial.seed, |random, tally| tally.error(error(random, &prepared)))
}

/// The largest error of the directions of a perspective view.
fn view(trial: &Trial, exact: &Pinhole, place: Place, error: fn(&Pinhole, DVec2, DVec3) -> f64) -> Tally {
    errors(trial, &exact.text(), exact.resolution, |random, prepared| {
        let film = place(random, exact.resolution);
        error(exact, film, prepared.camera.ray(film, DVec2::splat(0.5)).d)
    })
}

fn anywhere(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    DVec2::from(resolution.map(f64::from)) * unit_square(random)
}

fn in_f32(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    anywhere(random, resolution).as_vec2().as_dvec2()
}

/// Half anywhere on the film, half near its middle, where a wide film has few.
fn near_middle(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    if random.random::<bool>() {
        return anywhere(random, resolution);
    }
    let distance = (13.0 - 30.0 * random.random::<f64>()).exp2();
    let direction = DVec2::from_angle(std::f64::consts::TAU * random.random::<f64>());
    DVec2::from(resolution.map(f64::from)) / 2.0 + distance * direction
}

fn unit_square(random: &mut Pcg64Mcg) -> DVec2 {
    DVec2::new(random.random(), random.random())
}

/// Exact products are not enough: the difference of eye and target is rounded before, which turns the view by 1e-16.
fn up_near_view(trial: &Trial) -> Tally {
    // Each answer loads a scene.
    tally(trial.rays.div_ceil(100), trial.seed, |random, tally| {
        let points = tilted(random, trial.at);
        let error = match (CameraAxes::new(points), side(points)) {
            (Some(view), Some(side)) => angle(side, view.right),
            _ => f64::NAN,
        };
        tally.error(error);
    })
}

/// The side vector of the camera of a scene. `None` if the scene has an error.
fn side(look_at: LookAt) -> Option<DVec3> {
    let camera = format!("LookAt {} Camera \"perspective\"", look_at.map(xyz).join("  "));
    let scene = load(&text(&camera, [64, 64])).scene?;
    Some(scene.view.camera.world_from_camera.matrix().x_axis.truncate())
}

/// Eye (for half of them the origin), target, and an up vector `tilt` away from the view.
fn tilted(random: &mut Pcg64Mcg, tilt: f64) -> LookAt {
    let [eye, look, other] = [0; 3].map(|_| in_cube(random));
    // Of different sizes, so that their difference is rounded.
    let (eye, look) = if other.x < 0.0 { (DVec3::ZERO, look) } else { (0.3 * eye, 17.0 * look) };
    let view = look - eye;
    let across = view.cross(other).normalize();
    [eye, look, 3.0 * (view.normalize() * tilt.cos() + across * tilt.sin())]
}

const FILM: [u32; 2] = [640, 480];

fn lens_far_away(trial: &Trial) -> Tally {
    let exact = Pinhole::new(far(trial.at), 45.0, FILM);
    let camera = exact.text() + " \"float lensradius\" .05 \"float focaldistance\" 10";
    errors(trial, &camera, FILM, |random, prepared| {
        let film = anywhere(random, FILM);
        let ray = prepared.camera.ray(film, unit_square(random));
        let [x, y] = exact.slope(film).map(|slope| slope * 10.0);
        blur(exact.view.world(x, y, TwoFloat::from(10.0)), ray.o, ray.d)
    })
}

/// The distance of a ray from a point, in radii of the lens.
fn blur(focus: Wide, o: DVec3, d: DVec3) -> f64 {
    let d = Wide::new(d);
    f64::from(quotient(focus.minus(Wide::new(o)).cross(d).length(), d.length())) / 0.05
}

fn lens_camera(radius: f64, focal_distance: f64) -> String {
    format!("Camera \"perspective\" \"float lensradius\" {radius} \"float focaldistance\" {focal_distance}")
}

fn negative_radius() -> Tally {
    let mut tally = Tally::default();
    let prepared = prepared(&text(&lens_camera(-1.0, 10.0), FILM));
    let o = prepared.camera.ray(DVec2::new(3.0, 5.0), DVec2::new(0.9, 0.1)).o;
    tally.check(o == DVec3::ZERO, || format!("a lens of radius -1 is no pinhole: its ray starts at {o}"));
    tally
}

/// Directions from given points of the lens, in camera space.
fn through_lens(trial: &Trial, radius: f64, focal_distance: f64) -> Tally {
    let exact = Pinhole::in_camera_space(FILM);
    errors(trial, &lens_camera(radius, focal_distance), FILM, |random, prepared| {
        let film = anywhere(random, FILM);
        let ray = prepared.camera.ray(film, unit_square(random));
        let truth = refracted(exact.slope(film), [ray.o.x, ray.o.y], focal_distance);
        let is_on_lens = ray.o.z == 0.0 && ray.o.length() <= radius * (1.0 + 1e-15);
        if is_on_lens { angle(ray.d, truth) } else { f64::NAN }
    })
}

/// The direction of a ray from a point of the lens. `[x, y]` is the slope of the ray through the middle of the lens that meets it in
/// the plane of focus.
fn refracted([x, y]: [TwoFloat; 2], lens: [f64; 2], focal_distance: f64) -> Wide {
    let one = TwoFloat::from(1.0);
    if focal_distance < 1.0 {
        return Wide([x * focal_distance - lens[0], y * focal_distance - lens[1], one * focal_distance]);
    }
    // Farther, the lens is a point, to 40 digits.
    let scale = if focal_distance > 1e50 { TwoFloat::from(0.0) } else { one / focal_distance };
    Wide([x - scale * lens[0], y - scale * lens[1], one])
}

fn telecentric(trial: &Trial) -> Tally {
    let camera = "Camera \"orthographic\" \"float focaldistance\" 2 \"float lensradius\" .1 \"bool telecentric\" \"true\"";
    errors(trial, camera, FILM, |random, prepared| {
        let film = anywhere(random, FILM);
        // Opposite points of the lens.
        let u = unit_square(random);
        let rays = [u, DVec2::ONE - u].map(|u| prepared.camera.ray(film, u));
        // The place of the pixel at any depth: in `f64`, to 1e-12 pixels.
        let [width, height] = FILM.map(f64::from);
        let pixel = DVec2::new(2.0 * film.x - width, height - 2.0 * film.y) / height;
        from_mean(rays.map(|ray| (ray.o + prepared.world.origin(), ray.d)), pixel, trial.at)
    })
}

/// The distance of a pixel from the mean of two rays, at a depth in focal distances of 2. In pixels.
fn from_mean(rays: [(DVec3, DVec3); 2], pixel: DVec2, depth: f64) -> f64 {
    let at = |(o, d): (DVec3, DVec3)| o.truncate() + d.truncate() * ((2.0 * depth - o.z) / d.z);
    let mean = (at(rays[0]) + at(rays[1])) / 2.0;
    (mean - pixel).length() * f64::from(FILM[1]) / 2.0
}

fn off_center(trial: &Trial) -> Tally {
    let (low, high) = (trial.at - 0.5, trial.at + 0.5);
    let camera = format!("Camera \"orthographic\" \"float screenwindow\" [{low} {high} {low} {high}]");
    errors(trial, &camera, [3000; 2], |random, prepared| {
        let film = anywhere(random, [3000; 2]);
        let (o, eye) = (prepared.camera.ray(film, DVec2::splat(0.5)).o, prepared.world.origin());
        let dx = (TwoFloat::new_add(o.x, eye.x) - low) * 3000.0 - film.x;
        let dy = (TwoFloat::from(high) - TwoFloat::new_add(o.y, eye.y)) * 3000.0 - film.y;
        f64::from(dx).hypot(f64::from(dy))
    })
}

/// A reversed window turns the picture.
fn reversed_window() -> Tally {
    let mut tally = Tally::default();
    for kind in ["perspective", "orthographic"] {
        let [plain, reversed] = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            prepared(&text(&format!("Camera \"{kind}\" \"float screenwindow\" {edges}"), [64, 48]))
        });
        for film in [DVec2::new(0.0, 0.0), DVec2::new(5.0, 40.0), DVec2::new(63.5, 1.25)] {
            let u = DVec2::splat(0.5);
            let (a, b) = (plain.camera.ray(film, u), reversed.camera.ray(DVec2::new(64.0, 48.0) - film, u));
            let is_mirrored = (a.d - b.d).length().max((a.o - b.o).length()) < 1e-15;
            tally.check(is_mirrored, || format!("{kind}, reversed window: {a:?} is not {b:?}"));
        }
    }
    tally
}

/// Window and film differ in aspect.
fn window(trial: &Trial) -> Tally {
    let camera = "Camera \"perspective\" \"float frameaspectratio\" 3 \"float screenwindow\" [-1 1 -1 1]";
    errors(trial, camera, FILM, |random, prepared| {
        let film = anywhere(random, FILM);
        let x = TwoFloat::new_sub(2.0 * film.x, 640.0) / 640.0;
        let y = TwoFloat::new_sub(480.0, 2.0 * film.y) / 480.0;
        let truth = CameraAxes::in_camera_space().world(x, y, TwoFloat::from(1.0));
        angle(prepared.camera.ray(film, DVec2::splat(0.5)).d, truth)
    })
}

fn portrait(trial: &Trial) -> Tally {
    let films = [[480, 640], [640, 480]].into_iter().zip(trial.seed..);
    let one = |(film, seed)| {
        view(&Trial { seed, ..*trial }, &Pinhole::in_camera_space(film), anywhere, Pinhole::radians)
    };
    films.map(one).collect()
}

fn scaled(trial: &Trial) -> Tally {
    let (exact, scale) = (Pinhole::new(NEAR, 60.0, FILM), trial.at);
    // Every second camera is mirrored.
    let sign = if trial.seed.is_multiple_of(2) { -1.0 } else { 1.0 };
    let camera = format!("Scale {} {scale} {scale} {}", sign * scale, exact.text());
    errors(trial, &camera, FILM, |random, prepared| {
        let film = anywhere(random, FILM);
        let d = prepared.camera.ray(film, DVec2::splat(0.5)).d;
        let mirrored = if sign < 0.0 { DVec2::new(640.0 - film.x, film.y) } else { film };
        exact.radians(mirrored, d).max((d.length() - 1.0).abs())
    })
}

/// Decimal numbers are read as the nearest number with 53 bits.
fn numbers() -> Tally {
    const NUMBERS: [(&str, f64); 8] = [
        ("100000000000000000000", 1e20),
        ("-9223372036854775809", -9223372036854775808.0),
        ("9007199254740993", 9007199254740992.0),
        ("9007199254740993.00000000000000000001", 9007199254740994.0),
        (".1", f64::from_bits(0x3FB9_9999_9999_999A)),
        ("+1.25e-3", 0.00125),
        ("16777217", 16777217.0),
        ("1E+22", 1e22),
    ];
    let mut tally = Tally::default();
    for (number, value) in NUMBERS {
        let scene = scene(&text(&format!("Translate {number} 0 0 Camera \"perspective\""), [64, 48]));
        let read = -scene.view.camera.world_from_camera.matrix().w_axis.x;
        tally.check(read == value, || format!("{number} is read as {read:?}, not {value:?}"));
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_right_for_an_up_far_from_the_view() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..20 {
            let points = tilted(&mut random, 1.0);
            let truth = CameraAxes::new(points).unwrap().right;
            assert!(angle(side(points).unwrap(), truth) < 1e-15);
        }
    }

    #[test]
    fn an_up_vector_has_its_tilt() {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        let [eye, look, up] = tilted(&mut random, 1e-6);
        let tilt = (look - eye).cross(up).length() / ((look - eye).length() * up.length());
        assert!((tilt / 1e-6 - 1.0).abs() < 1e-6, "{tilt}");
    }

    /// From a point of the lens to the point where the ray through the middle of the lens meets the plane of focus.
    #[test]
    fn lenses_refract_to_the_plane_of_focus() {
        let (slope, lens) = (DVec2::new(0.4, -0.3), DVec2::new(0.6, 0.1));
        for focal_distance in [0.25, 4.0] {
            let d = (slope * focal_distance - lens).extend(focal_distance);
            let truth = refracted(slope.to_array().map(TwoFloat::from), lens.to_array(), focal_distance);
            assert!(angle(d, truth) < 1e-15);
        }
    }

    #[test]
    fn known_rays_have_known_errors() {
        // Ten from the lens, a direction that is off by 1e-3 misses by 0.01: a fifth of the radius of 0.05.
        let focus = CameraAxes::in_camera_space().world(0.0.into(), 0.0.into(), 10.0.into());
        assert!((blur(focus, DVec3::ZERO, DVec3::new(1e-3, 0.0, 1.0)) - 0.2).abs() < 1e-6);
        // A view that widens with depth is off by the distance from its middle at twice the focal distance.
        let (pixel, lens) = (DVec2::new(0.5, 0.25), DVec2::new(0.03, 0.01));
        let rays = [lens, -lens].map(|lens| (lens.extend(0.0), (pixel - lens).extend(2.0)));
        assert!((from_mean(rays, pixel, 2.0) - pixel.length() * 240.0).abs() < 1e-9);
        assert!(from_mean(rays, pixel, 1.0) < 1e-9);
    }
}
