//! The camera of the page: its values, what a request makes of it, and the changes of the text that keep it.

use lookat_render::Prepared;
use lookat_scene::glam::{DVec2, DVec3};
use lookat_scene::syntax::{Fix, ParamType, Span, value_span};
use lookat_scene::{
    Camera, CameraPlacement, FileCamera, Lens, Loaded, Scene, Sources, Transform, View, ViewOverride,
};

use crate::failure::Failure;
use crate::view::messages;
use lookat_scene::DirectiveText;

/// The `LookAt` of the file, or for a camera that is placed otherwise one to what it sees in the middle. The
/// transformation before it keeps what no `LookAt` can do, such as mirroring.
pub fn placement(loaded: &Loaded, scene: &Scene, prepared: &Prepared) -> Option<CameraPlacement> {
    if loaded.placement.is_some() {
        return loaded.placement;
    }
    let (view, world_from_camera) = (&scene.view, scene.view.camera.middle());
    let [width, height] = view.film.resolution.map(f64::from);
    let eye = world_from_camera.point(DVec3::ZERO);
    let forward = world_from_camera.vector(DVec3::Z).try_normalize()?;
    let along = |p: DVec3| Some((p - eye).dot(forward)).filter(|distance| *distance > 0.0);
    let seen = prepared.pick(view, DVec2::new(width, height) / 2.0).and_then(|picked| along(picked.p));
    let middle = || scene.world.bounds().and_then(|[low, high]| along((low + high) / 2.0));
    let look = eye + forward * seen.or_else(middle).unwrap_or(1.0);
    let up = world_from_camera.vector(DVec3::Y).try_normalize()?;
    let points = [eye, look, up].map(|point| point.to_array()).concat().try_into().ok()?;
    CameraPlacement::of(world_from_camera, points).ok()
}

/// The camera of a page, with numbers that are short enough to write into a file. Points have a millionth of the distance of eye and
/// target; numbers of the file keep their digits.
pub fn rounded(mut set: ViewOverride, own: [f64; 9]) -> ViewOverride {
    let digits = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
    if let Some(points) = &mut set.look_at {
        let [eye, look, up] = [0, 3, 6].map(|at| DVec3::from_slice(&points[at..at + 3]));
        for (at, (value, own)) in points.iter_mut().zip(own).enumerate() {
            let size = if at < 6 { eye.distance(look) } else { up.length() };
            if *value != own {
                *value = near(*value, size);
            }
        }
    }
    if let Some(edges) = &mut set.screen_window {
        let size = (edges[1] - edges[0]).abs().min((edges[3] - edges[2]).abs());
        *edges = edges.map(|edge| near(edge, size));
    }
    for value in [&mut set.fov, &mut set.lens_radius, &mut set.focal_distance] {
        *value = value.map(digits);
    }
    set
}

/// A number to a millionth of a size.
fn near(value: f64, size: f64) -> f64 {
    // A vector that was turned is a little too short.
    let decimals = 6.0 - (size.log10() + 1e-6).floor();
    if (0.0..=17.0).contains(&decimals) {
        format!("{value:.*}", decimals as usize).parse().map_or(value, |value: f64| value + 0.0)
    } else {
        value
    }
}

/// The values of a camera that a `LookAt` of `points` places. `moves`: anything in the scene does.
pub fn values(
    View { camera, film, .. }: &View,
    file: &FileCamera,
    points: [f64; 9],
    moves: bool,
) -> messages::Camera {
    let from_pupil = camera.lens.and_then(|lens| camera.lens_system()?.equivalent_view(lens.focal_distance));
    let before = file.placement.map_or(Transform::IDENTITY, |placement| placement.before);
    let signs = before.vector(DVec3::ONE);
    messages::Camera {
        kind: camera.projection.name(),
        look_at: points,
        has_look_at: file.placement.is_some_and(|placement| placement.span.is_some()),
        mirrored: [signs.x < 0.0, signs.y < 0.0],
        fov: camera.fov(),
        view_angle: from_pupil.map(|view| 2.0 * (view.scale * camera.screen_unit(film)).atan().to_degrees()),
        lens_depth: from_pupil.map_or(0.0, |view| view.depth),
        lens_radius: camera.lens.map_or(0.0, |lens| lens.radius),
        focal_distance: camera.lens.map(|lens| lens.focal_distance).or(file.focal_distance),
        screen_window: camera.screen.edges(),
        time: Some(camera.shutter.open).filter(|open| *open == camera.shutter.close),
        times: Some(camera.shutter.transform_times).filter(|_| moves),
    }
}

/// The changes that give the scene the camera that the page sets. Fails with the reason why no change does.
pub fn camera_fixes(loaded: &Loaded, own: &Camera, set: &ViewOverride) -> Result<Vec<Fix>, Failure> {
    let mut fixes = match set.look_at {
        Some(points) => look_at_fixes(&loaded.sources, loaded.placement, points)?,
        None => Vec::new(),
    };
    let parameters = parameters(own, set);
    if !parameters.is_empty() {
        let place = loaded.places.camera;
        let directive = place.and_then(|place| DirectiveText::at(&loaded.sources, place));
        let directive =
            directive.ok_or("the scene has no Camera: write Camera \"perspective\" before WorldBegin")?;
        fixes
            .extend(parameters.into_iter().flat_map(|(name, values)| set_numbers(&directive, name, &values)));
    }
    Ok(fixes)
}

fn set_numbers(directive: &DirectiveText, name: &str, values: &[f64]) -> Vec<Fix> {
    // halffov replaces fov.
    let is_half = name == "fov" && directive.param("halffov").is_some();
    let (name, factor) = if is_half { ("halffov", 0.5) } else { (name, 1.0) };
    let words: Vec<String> = values.iter().map(|value| short(factor * value)).collect();
    directive.set(ParamType::Float, name, &words)
}

/// A number with all its digits, and with an exponent if it is very large or very small.
fn short(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() > 20 { format!("{value:e}") } else { plain }
}

/// The numbers of the `LookAt` that differ.
fn look_at_fixes(
    sources: &Sources,
    placement: Option<CameraPlacement>,
    points: [f64; 9],
) -> Result<Vec<Fix>, Failure> {
    let found = placement.and_then(|placement| Some((placement.span?, placement.points)));
    let (span, own) = found.ok_or(
        "no LookAt places the camera in this file: write a LookAt instead of the transformations before Camera",
    )?;
    let list = Span { start: span.start + "LookAt".len() as u32, ..span };
    let text = &sources.file(span.file).text;
    let differing = (0..9).filter(|at| own[*at] != points[*at]);
    let fix = |at: usize| Fix { span: value_span(text, list, at), replacement: short(points[at]) };
    Ok(differing.map(fix).collect())
}

/// The parameters whose values differ from the file.
fn parameters(own: &Camera, set: &ViewOverride) -> Vec<(&'static str, Vec<f64>)> {
    let Lens { radius, focal_distance } = own.lens.unwrap_or(Lens { radius: 0.0, focal_distance: f64::NAN });
    let one = |value: f64| vec![value];
    let all = [
        ("fov", set.fov.map(one), own.fov().map(one)),
        ("screenwindow", set.screen_window.map(Vec::from), Some(own.screen.edges().into())),
        ("lensradius", set.lens_radius.map(one), Some(one(radius))),
        (own.focus_parameter(), set.focal_distance.map(one), Some(one(focal_distance))),
    ];
    let differing = all.into_iter().filter(|(_, set, own)| set != own);
    differing.filter_map(|(name, set, _)| Some((name, set?))).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use lookat_scene::{LoadOptions, load};

    use crate::view::write::changes;

    #[test]
    fn numbers_that_were_set_are_short() {
        let own = [1.234_567_891_2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let look_at = [1.234_567_891_2, 1e-17, -19.999_999_999_9, 0.1 + 0.2, 0.0, 0.0, -1e-9, 1.0, 0.0];
        let set = ViewOverride { look_at: Some(look_at), fov: Some(100.0 / 3.0), ..ViewOverride::default() };
        let found = rounded(set, own);
        assert_eq!(found.look_at.unwrap(), [1.234_567_891_2, 0.0, -20.0, 0.3, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(found.look_at.unwrap()[6].to_string(), "0");
        assert_eq!(found.fov, Some(33.3333));
        // Turned there and back.
        let rolled = [0.0, 0.0, -20.0, 0.0, 0.0, 0.0, 4e-7, 0.999_999_7, 1e-7];
        let set = ViewOverride { look_at: Some(rolled), ..ViewOverride::default() };
        assert_eq!(rounded(set, own).look_at.unwrap()[6..], [0.0, 1.0, 0.0]);
        // Far smaller and larger than usual.
        let far =
            |scale: f64| rounded(ViewOverride { look_at: Some(look_at.map(|it| it * scale)), ..set }, own);
        for scale in [1e-30, 1e-5, 1e5, 1e30] {
            for (found, wanted) in far(scale).look_at.unwrap().iter().zip(look_at).take(6) {
                assert!((found - wanted * scale).abs() <= 1e-5 * scale, "{found} {wanted} {scale}");
            }
        }
    }

    const REST: &str = "Film \"image\" Sampler \"sobol\" Integrator \"path\" Include \"world.pbrt\"";
    const WORLD: &str = "WorldBegin LightSource \"infinite\" Shape \"sphere\" WorldEnd";

    /// A scene in two files.
    fn loaded(camera: &str) -> Loaded {
        let text = format!("{camera}\n{REST}\n");
        let read = |path: &Path| {
            Ok(match path.to_str() {
                Some("world.pbrt") => WORLD.into(),
                Some("lens.dat") => "50 6 1.5 20\n-60 5 1 20\n".into(),
                _ => text.clone().into(),
            })
        };
        load(Path::new("a.pbrt"), &read, &LoadOptions::default())
    }

    fn written(camera: &str, set: &ViewOverride) -> Result<String, Failure> {
        let loaded = loaded(camera);
        let own = &loaded.scene.as_ref().unwrap().view.camera;
        let fixes = camera_fixes(&loaded, own, set)?;
        let changes = changes(&loaded.sources, &fixes)?;
        assert!(changes.len() < 2 && changes.iter().all(|change| change.path == Path::new("a.pbrt")));
        let after =
            changes.into_iter().next().map(|change| String::from_utf8(change.after.to_vec()).unwrap());
        let after = after.unwrap_or_else(|| format!("{camera}\n{REST}\n"));
        Ok(after.strip_suffix(&format!("\n{REST}\n")).unwrap().to_owned())
    }

    #[test]
    fn only_the_numbers_that_differ_change() {
        let none = ViewOverride::default();
        for (camera, set, expected) in [
            (
                "LookAt 0 0 -4.0 # the eye\n  0 0 0\t0 1 0 Camera \"perspective\"",
                ViewOverride { look_at: Some([1.5, 0.0, -4.0, 0.0, -0.25, 0.0, 0.0, 1.0, 0.0]), ..none },
                "LookAt 1.5 0 -4.0 # the eye\n  0 -0.25 0\t0 1 0 Camera \"perspective\"",
            ),
            (
                "LookAt [0 0 -4 0 0 0 0 1 0] Rotate 3 0 1 0 Camera \"perspective\" \"float fov\" [40]",
                ViewOverride {
                    look_at: Some([0.0, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
                    fov: Some(50.0),
                    ..none
                },
                "LookAt [0 0 -5 0 0 0 0 1 0] Rotate 3 0 1 0 Camera \"perspective\" \"float fov\" [50]",
            ),
            (
                "Camera \"perspective\" # plain\n\"float halffov\" 20 # half",
                ViewOverride { fov: Some(50.0), lens_radius: Some(0.1), focal_distance: Some(3.0), ..none },
                "Camera \"perspective\" # plain\n\"float halffov\" 25 \"float lensradius\" 0.1 \"float focaldistance\" 3 # half",
            ),
            (
                "Camera \"orthographic\"",
                ViewOverride { screen_window: Some([-2.0, 2.0, -1.5, 1.5]), ..none },
                "Camera \"orthographic\" \"float screenwindow\" [-2 2 -1.5 1.5]",
            ),
            (
                "Camera \"orthographic\" \"float screenwindow\" [-1.0 1 -1 1]",
                ViewOverride { screen_window: Some([-1.0, 1.0, -1.5, 1.5]), ..none },
                "Camera \"orthographic\" \"float screenwindow\" [-1.0 1 -1.5 1.5]",
            ),
            (
                "Camera \"realistic\" \"string lensfile\" \"lens.dat\"",
                ViewOverride { focal_distance: Some(3.0), ..none },
                "Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float focusdistance\" 3",
            ),
            (
                "Camera \"perspective\" \"float fov\" 40",
                ViewOverride { fov: Some(40.0), ..none },
                "Camera \"perspective\" \"float fov\" 40",
            ),
        ] {
            let found = written(camera, &set).unwrap();
            assert_eq!(found, expected);
            // What is written gives the camera that was set.
            let after = loaded(&found);
            let camera = after.scene.unwrap().view.camera;
            assert!(parameters(&camera, &set).is_empty(), "{found}");
            assert!(set.look_at.is_none() || after.placement.unwrap().points == set.look_at.unwrap());
        }
    }

    #[test]
    fn what_cannot_be_written_has_a_reason() {
        let look_at = Some([1.0, 0.0, -4.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let set = ViewOverride { look_at, ..ViewOverride::default() };
        let reason = written("Translate 0 0 4 Camera \"perspective\"", &set).unwrap_err().to_string();
        assert!(reason.starts_with("no LookAt places the camera"), "{reason}");
        let set = ViewOverride { fov: Some(30.0), ..ViewOverride::default() };
        let reason = written("LookAt 0 0 -4 0 0 0 0 1 0", &set).unwrap_err().to_string();
        assert!(reason.starts_with("the scene has no Camera"), "{reason}");
    }
}
