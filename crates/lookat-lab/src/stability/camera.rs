//! Rays from the camera: C1 to C20.

use twofloat::TwoFloat;

use super::double_double::{Wide, quotient};
use super::exact_camera::{CameraAxes, Pinhole, angle, tan_half};
use super::*;

pub(super) const MEASURES: &[(&str, Measure)] = &[
    ("C1", |trial| view(trial, NEAR, trial.at, [16384; 2], near_middle, Pinhole::pixels)),
    ("C2", |trial| view(trial, NEAR, trial.at, [16384; 2], near_middle, radians)),
    ("C3", |trial| view(trial, NEAR, 180.0 - trial.at, [16384; 2], near_middle, radians)),
    ("C4", |trial| view(trial, far(trial.at), 45.0, [1920, 1080], anywhere, Pinhole::pixels)),
    ("C5", lens_far_away),
    ("C6", up_near_view),
    ("C7", |_| Tally::default()),
    ("C8", |_| Tally::default()),
    ("C9", |trial| view(trial, distant_target(trial.at), 45.0, [1024; 2], anywhere_in_f32, radians)),
    ("C10", |trial| through_lens(trial, 1.0, trial.at)),
    ("C11", |_| Tally::default()),
    ("C12", |trial| match trial.at.is_nan() {
        true => negative_radius(),
        false => through_lens(trial, trial.at, 10.0),
    }),
    ("C13", |trial| if trial.at.is_nan() { Tally::default() } else { telecentric(trial) }),
    ("C14", off_center),
    ("C15", |_| reversed_window()),
    ("C16", window),
    ("C17", portrait),
    ("C18", scaled),
    ("C19", |_| numbers()),
    ("C20", |_| Tally::default()),
];

/// The text of a scene for its camera. Only a few pixels of the film are rendered, so the film may have any size.
fn text(camera: &str, [width, height]: [u32; 2]) -> String {
    let size = format!("\"integer xresolution\" {width} \"integer yresolution\" {height}");
    let film = format!("Film \"image\" {size} \"float cropwindow\" [.5 .51 .5 .51]");
    format!(
        "{camera} {film} Sampler \"sobol\" Integrator \"path\" WorldBegin LightSource \"infinite\" WorldEnd"
    )
}

/// Eye, target and up vector.
type LookAt = [DVec3; 3];

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

fn perspective(look_at: LookAt, fov: f64) -> String {
    format!("LookAt {} Camera \"perspective\" \"float fov\" {fov}", look_at.map(xyz).join("  "))
}

fn pinhole([eye, look, up]: LookAt, fov: f64, resolution: [u32; 2]) -> Pinhole {
    let view = CameraAxes::new(eye, look, up).expect("these views have a side");
    Pinhole { view, tan: tan_half(fov), resolution }
}

/// A point of the film.
type Place = fn(&mut Pcg64Mcg, [u32; 2]) -> DVec2;

/// The largest error of the directions of a perspective view.
fn view(
    trial: &Trial,
    look_at: LookAt,
    fov: f64,
    film: [u32; 2],
    place: Place,
    error: fn(&Pinhole, DVec2, DVec3) -> f64,
) -> Tally {
    let exact = pinhole(look_at, fov, film);
    directions(trial, &perspective(look_at, fov), film, place, |place, d| error(&exact, place, d))
}

/// The largest error of the directions of a camera.
fn directions(
    trial: &Trial,
    camera: &str,
    film: [u32; 2],
    place: Place,
    error: impl Fn(DVec2, DVec3) -> f64 + Sync,
) -> Tally {
    let probe = probe(&text(camera, film));
    tally(trial.rays, trial.seed, |random, tally| {
        let place = place(random, film);
        tally.error(error(place, probe.camera_ray(place, DVec2::splat(0.5)).d));
    })
}

fn radians(pinhole: &Pinhole, film: DVec2, d: DVec3) -> f64 {
    angle(d, pinhole.direction(film))
}

fn anywhere(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
    DVec2::from(resolution.map(f64::from)) * unit_square(random)
}

fn anywhere_in_f32(random: &mut Pcg64Mcg, resolution: [u32; 2]) -> DVec2 {
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
        let points @ [eye, look, up] = tilted(random, trial.at);
        let error = match (CameraAxes::new(eye, look, up), side(points)) {
            (Some(view), Some(side)) => angle(side, view.right),
            _ => f64::NAN,
        };
        tally.error(error);
    })
}

/// The side vector of the camera of a scene. `None` if the scene has an error.
fn side(look_at: LookAt) -> Option<DVec3> {
    let scene = load(&text(&perspective(look_at, 90.0), [64, 64])).scene?;
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

const LENS_FILM: [u32; 2] = [640, 480];

fn lens_far_away(trial: &Trial) -> Tally {
    let look_at = far(trial.at);
    let camera = perspective(look_at, 45.0) + " \"float lensradius\" .05 \"float focaldistance\" 10";
    let probe = probe(&text(&camera, LENS_FILM));
    let exact = pinhole(look_at, 45.0, LENS_FILM);
    tally(trial.rays, trial.seed, |random, tally| {
        let film = anywhere(random, LENS_FILM);
        let ray = probe.camera_ray(film, unit_square(random));
        let [x, y] = exact.slope(film).map(|slope| slope * 10.0);
        tally.error(blur(exact.view.world(x, y, TwoFloat::from(10.0)), ray.o, ray.d));
    })
}

/// The distance of a ray from a point, in radii of the lens.
fn blur(focus: Wide, o: DVec3, d: DVec3) -> f64 {
    let d = Wide::new(d);
    f64::from(quotient(focus.minus(Wide::new(o)).cross(d).length(), d.length())) / 0.05
}

fn lens_text(radius: f64, focal_distance: f64) -> String {
    let lens = format!("\"float lensradius\" {radius} \"float focaldistance\" {focal_distance}");
    text(&format!("Camera \"perspective\" {lens}"), LENS_FILM)
}

fn negative_radius() -> Tally {
    let mut tally = Tally::default();
    let o = probe(&lens_text(-1.0, 10.0)).camera_ray(DVec2::new(3.0, 5.0), DVec2::new(0.9, 0.1)).o;
    tally.check(o == DVec3::ZERO, || format!("a lens of radius -1 is no pinhole: its ray starts at {o}"));
    tally
}

/// Directions from given points of the lens, in camera space.
fn through_lens(trial: &Trial, radius: f64, focal_distance: f64) -> Tally {
    let probe = probe(&lens_text(radius, focal_distance));
    let exact = Pinhole { view: CameraAxes::CAMERA_SPACE, tan: tan_half(90.0), resolution: LENS_FILM };
    tally(trial.rays, trial.seed, |random, tally| {
        let film = anywhere(random, LENS_FILM);
        let ray = probe.camera_ray(film, unit_square(random));
        let truth = refracted(exact.slope(film), [ray.o.x, ray.o.y], focal_distance);
        let is_on_lens = ray.o.z == 0.0 && ray.o.length() <= radius * (1.0 + 1e-15);
        tally.error(if is_on_lens { angle(ray.d, truth) } else { f64::NAN });
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
    let probe = probe(&text(camera, LENS_FILM));
    tally(trial.rays, trial.seed, |random, tally| {
        let film = anywhere(random, LENS_FILM);
        // Opposite points of the lens.
        let u = unit_square(random);
        let rays = [u, DVec2::ONE - u].map(|u| probe.camera_ray(film, u));
        let eye = probe.origin();
        // The place of the pixel at any depth: in `f64`, to 1e-12 pixels.
        let [width, height] = LENS_FILM.map(f64::from);
        let pixel = DVec2::new(2.0 * film.x - width, height - 2.0 * film.y) / height;
        tally.error(from_mean(rays.map(|ray| (ray.o + eye, ray.d)), pixel, trial.at));
    })
}

/// The distance of a pixel from the mean of two rays, at a depth in focal distances of 2. In pixels.
fn from_mean(rays: [(DVec3, DVec3); 2], pixel: DVec2, depth: f64) -> f64 {
    let at = |(o, d): (DVec3, DVec3)| o.truncate() + d.truncate() * ((2.0 * depth - o.z) / d.z);
    let mean = (at(rays[0]) + at(rays[1])) / 2.0;
    (mean - pixel).length() * f64::from(LENS_FILM[1]) / 2.0
}

fn off_center(trial: &Trial) -> Tally {
    let (low, high) = (trial.at - 0.5, trial.at + 0.5);
    let camera = format!("Camera \"orthographic\" \"float screenwindow\" [{low} {high} {low} {high}]");
    let probe = probe(&text(&camera, [3000; 2]));
    tally(trial.rays, trial.seed, |random, tally| {
        let film = anywhere(random, [3000; 2]);
        let (o, eye) = (probe.camera_ray(film, DVec2::splat(0.5)).o, probe.origin());
        let dx = (TwoFloat::new_add(o.x, eye.x) - low) * 3000.0 - film.x;
        let dy = (TwoFloat::from(high) - TwoFloat::new_add(o.y, eye.y)) * 3000.0 - film.y;
        tally.error(f64::from(dx).hypot(f64::from(dy)));
    })
}

/// A reversed window turns the picture.
fn reversed_window() -> Tally {
    let mut tally = Tally::default();
    for kind in ["perspective", "orthographic"] {
        let [plain, reversed] = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            probe(&text(&format!("Camera \"{kind}\" \"float screenwindow\" {edges}"), [64, 48]))
        });
        for film in [DVec2::new(0.0, 0.0), DVec2::new(5.0, 40.0), DVec2::new(63.5, 1.25)] {
            let u = DVec2::splat(0.5);
            let (a, b) = (plain.camera_ray(film, u), reversed.camera_ray(DVec2::new(64.0, 48.0) - film, u));
            let is_mirrored = (a.d - b.d).length().max((a.o - b.o).length()) < 1e-15;
            tally.check(is_mirrored, || format!("{kind}, reversed window: {a:?} is not {b:?}"));
        }
    }
    tally
}

/// Window and film differ in aspect.
fn window(trial: &Trial) -> Tally {
    let camera = "Camera \"perspective\" \"float frameaspectratio\" 3 \"float screenwindow\" [-1 1 -1 1]";
    directions(trial, camera, [640, 480], anywhere, |film, d| {
        let x = TwoFloat::new_sub(2.0 * film.x, 640.0) / 640.0;
        let y = TwoFloat::new_sub(480.0, 2.0 * film.y) / 480.0;
        angle(d, CameraAxes::CAMERA_SPACE.world(x, y, TwoFloat::from(1.0)))
    })
}

fn portrait(trial: &Trial) -> Tally {
    let films = [[480, 640], [640, 480]].into_iter().zip(trial.seed..);
    let one = |(film, seed)| {
        let exact = Pinhole { view: CameraAxes::CAMERA_SPACE, tan: tan_half(90.0), resolution: film };
        let camera = "Camera \"perspective\" \"float fov\" 90";
        directions(&Trial { seed, ..*trial }, camera, film, anywhere, |film, d| radians(&exact, film, d))
    };
    films.map(one).collect()
}

fn scaled(trial: &Trial) -> Tally {
    let (film, scale) = ([640, 480], trial.at);
    let exact = pinhole(NEAR, 60.0, film);
    // Every second camera is mirrored.
    let sign = if trial.seed.is_multiple_of(2) { -1.0 } else { 1.0 };
    let camera = format!("Scale {} {scale} {scale} {}", sign * scale, perspective(NEAR, 60.0));
    directions(trial, &camera, film, anywhere, |film, d| {
        let mirrored = if sign < 0.0 { DVec2::new(640.0 - film.x, film.y) } else { film };
        radians(&exact, mirrored, d).max((d.length() - 1.0).abs())
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
            let truth = CameraAxes::new(points[0], points[1], points[2]).unwrap().right;
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
        let focus = CameraAxes::CAMERA_SPACE.world(0.0.into(), 0.0.into(), 10.0.into());
        assert!((blur(focus, DVec3::ZERO, DVec3::new(1e-3, 0.0, 1.0)) - 0.2).abs() < 1e-6);
        // A view that widens with depth is off by the distance from its middle at twice the focal distance.
        let (pixel, lens) = (DVec2::new(0.5, 0.25), DVec2::new(0.03, 0.01));
        let rays = [lens, -lens].map(|lens| (lens.extend(0.0), (pixel - lens).extend(2.0)));
        assert!((from_mean(rays, pixel, 2.0) - pixel.length() * 240.0).abs() < 1e-9);
        assert!(from_mean(rays, pixel, 1.0) < 1e-9);
    }
}
