//! The camera of the page as changes of the text: the numbers that differ, and nothing else.

use lookat_scene::syntax::{Fix, ParamType, Span, value_span};
use lookat_scene::{Camera, CameraPlacement, Lens, Loaded, Sources};

use super::messages::SetCamera;
use crate::directive_text::DirectiveText;

/// The changes that give the scene the camera that the page sets. Fails with the reason why no change does.
pub fn camera_fixes(loaded: &Loaded, own: &Camera, set: &SetCamera) -> Result<Vec<Fix>, String> {
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
) -> Result<Vec<Fix>, String> {
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
fn parameters(own: &Camera, set: &SetCamera) -> Vec<(&'static str, Vec<f64>)> {
    let Lens { radius, focal_distance } = own.lens.unwrap_or(Lens { radius: 0.0, focal_distance: f64::NAN });
    let one = |value: f64| vec![value];
    let all = [
        ("fov", set.fov.map(one), own.fov().map(one)),
        ("screenwindow", set.screen_window.map(Vec::from), Some(own.screen.edges().into())),
        ("lensradius", set.lens_radius.map(one), Some(one(radius))),
        ("focaldistance", set.focal_distance.map(one), Some(one(focal_distance))),
    ];
    let differing = all.into_iter().filter(|(_, set, own)| set != own);
    differing.filter_map(|(name, set, _)| Some((name, set?))).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use lookat_scene::{LoadOptions, load};

    use super::*;
    use crate::view::write::changes;

    const REST: &str = "Film \"image\" Sampler \"sobol\" Integrator \"path\" Include \"world.pbrt\"";
    const WORLD: &str = "WorldBegin LightSource \"infinite\" Shape \"sphere\" WorldEnd";

    /// A scene in two files.
    fn loaded(camera: &str) -> Loaded {
        let text = format!("{camera}\n{REST}\n");
        let read = |path: &Path| {
            Ok(if path == Path::new("world.pbrt") { WORLD.into() } else { text.clone().into() })
        };
        load(Path::new("a.pbrt"), &read, &LoadOptions::default())
    }

    fn written(camera: &str, set: &SetCamera) -> Result<String, String> {
        let loaded = loaded(camera);
        let own = loaded.scene.as_ref().unwrap().view.camera;
        let fixes = camera_fixes(&loaded, &own, set)?;
        let changes = changes(&loaded.sources, &fixes)?;
        assert!(changes.len() < 2 && changes.iter().all(|change| change.path == Path::new("a.pbrt")));
        let after =
            changes.into_iter().next().map(|change| String::from_utf8(change.after.to_vec()).unwrap());
        let after = after.unwrap_or_else(|| format!("{camera}\n{REST}\n"));
        Ok(after.strip_suffix(&format!("\n{REST}\n")).unwrap().to_owned())
    }

    #[test]
    fn only_the_numbers_that_differ_change() {
        let none = SetCamera::default();
        for (camera, set, expected) in [
            (
                "LookAt 0 0 -4.0 # the eye\n  0 0 0\t0 1 0 Camera \"perspective\"",
                SetCamera { look_at: Some([1.5, 0.0, -4.0, 0.0, -0.25, 0.0, 0.0, 1.0, 0.0]), ..none },
                "LookAt 1.5 0 -4.0 # the eye\n  0 -0.25 0\t0 1 0 Camera \"perspective\"",
            ),
            (
                "LookAt [0 0 -4 0 0 0 0 1 0] Rotate 3 0 1 0 Camera \"perspective\" \"float fov\" [40]",
                SetCamera {
                    look_at: Some([0.0, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
                    fov: Some(50.0),
                    ..none
                },
                "LookAt [0 0 -5 0 0 0 0 1 0] Rotate 3 0 1 0 Camera \"perspective\" \"float fov\" [50]",
            ),
            (
                "Camera \"perspective\" # plain\n\"float halffov\" 20 # half",
                SetCamera { fov: Some(50.0), lens_radius: Some(0.1), focal_distance: Some(3.0), ..none },
                "Camera \"perspective\" # plain\n\"float halffov\" 25 \"float lensradius\" 0.1 \"float focaldistance\" 3 # half",
            ),
            (
                "Camera \"orthographic\"",
                SetCamera { screen_window: Some([-2.0, 2.0, -1.5, 1.5]), ..none },
                "Camera \"orthographic\" \"float screenwindow\" [-2 2 -1.5 1.5]",
            ),
            (
                "Camera \"orthographic\" \"float screenwindow\" [-1.0 1 -1 1]",
                SetCamera { screen_window: Some([-1.0, 1.0, -1.5, 1.5]), ..none },
                "Camera \"orthographic\" \"float screenwindow\" [-1.0 1 -1.5 1.5]",
            ),
            (
                "Camera \"perspective\" \"float fov\" 40",
                SetCamera { fov: Some(40.0), ..none },
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
        let set = SetCamera { look_at, ..SetCamera::default() };
        let reason = written("Translate 0 0 4 Camera \"perspective\"", &set).unwrap_err();
        assert!(reason.starts_with("no LookAt places the camera"), "{reason}");
        let set = SetCamera { fov: Some(30.0), ..SetCamera::default() };
        let reason = written("LookAt 0 0 -4 0 0 0 0 1 0", &set).unwrap_err();
        assert!(reason.starts_with("the scene has no Camera"), "{reason}");
    }
}
