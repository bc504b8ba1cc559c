//! The camera of the page: what a request makes of the camera of the file, and its values.

use lookat_render::Prepared;
use lookat_scene::glam::{DVec2, DVec3};
use lookat_scene::{
    Camera, CameraPlacement, Lens, Loaded, Projection, Scene, ScreenWindow, Transform, ViewOverride,
};

use super::messages::{self, SetCamera};

/// The `LookAt` of the file, or for a camera that is placed otherwise one to what it sees in the middle. The
/// transformation before it keeps what no `LookAt` can do, such as mirroring.
pub fn placement(loaded: &Loaded, scene: &Scene, prepared: &Prepared) -> Option<CameraPlacement> {
    if loaded.placement.is_some() {
        return loaded.placement;
    }
    let (view, world_from_camera) = (&scene.view, scene.view.camera.world_from_camera);
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

/// The camera of the file with what the page sets. Fails with the reason.
pub fn changed(
    own: Camera,
    (placement, focal_distance): (Option<CameraPlacement>, Option<f64>),
    set: &SetCamera,
) -> Result<Camera, String> {
    ViewOverride::from(*set).check()?;
    let mut camera = own;
    if let Some(points) = set.look_at {
        let placement = placement.ok_or("the camera of the file has no direction")?;
        let placed = CameraPlacement { points, ..placement }.world_from_camera();
        camera.world_from_camera = placed.map_err(|fault| fault.to_string())?;
    }
    if let (Some(fov), Projection::Perspective { .. }) = (set.fov, own.projection) {
        camera.projection = Projection::Perspective { fov };
    }
    if let Some(edges) = set.screen_window {
        camera.screen = ScreenWindow::from(edges);
    }
    if own.projection != Projection::Environment {
        let radius = set.lens_radius.or(own.lens.map(|lens| lens.radius)).unwrap_or(0.0);
        let distance = set.focal_distance.or(own.lens.map(|lens| lens.focal_distance)).or(focal_distance);
        let lens = Lens { radius, focal_distance: distance.unwrap_or(Lens::UNFOCUSED) };
        camera.lens = (radius > 0.0).then_some(lens);
    }
    Ok(camera)
}

/// The same with numbers that are short enough to write into a file. Points have a millionth of the distance of eye and
/// target; numbers of the file keep their digits.
pub fn rounded(mut set: SetCamera, own: [f64; 9]) -> SetCamera {
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
        edges.iter_mut().for_each(|edge| *edge = near(*edge, size));
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
    match (0.0..=17.0).contains(&decimals) {
        true => format!("{value:.*}", decimals as usize).parse().map_or(value, |value: f64| value + 0.0),
        false => value,
    }
}

/// The values of a camera that a `LookAt` of `points` places. `focal_distance` comes from the file, for a pinhole.
pub fn values(
    camera: &Camera,
    (placement, focal_distance): (Option<CameraPlacement>, Option<f64>),
    points: [f64; 9],
) -> messages::Camera {
    let before = placement.map_or(Transform::IDENTITY, |placement| placement.before);
    let signs = before.vector(DVec3::ONE);
    let kind = match camera.projection {
        Projection::Perspective { .. } => "perspective",
        Projection::Orthographic { .. } => "orthographic",
        Projection::Environment => "environment",
    };
    messages::Camera {
        kind,
        look_at: points,
        has_look_at: placement.is_some_and(|placement| placement.span.is_some()),
        mirrored: [signs.x < 0.0, signs.y < 0.0],
        fov: camera.fov(),
        lens_radius: camera.lens.map_or(0.0, |lens| lens.radius),
        focal_distance: camera.lens.map(|lens| lens.focal_distance).or(focal_distance),
        screen_window: camera.screen.edges(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_were_set_are_short() {
        let own = [1.234_567_891_2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let look_at = [1.234_567_891_2, 1e-17, -19.999_999_999_9, 0.1 + 0.2, 0.0, 0.0, -1e-9, 1.0, 0.0];
        let set = SetCamera { look_at: Some(look_at), fov: Some(100.0 / 3.0), ..SetCamera::default() };
        let found = rounded(set, own);
        assert_eq!(found.look_at.unwrap(), [1.234_567_891_2, 0.0, -20.0, 0.3, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(found.look_at.unwrap()[6].to_string(), "0");
        assert_eq!(found.fov, Some(33.3333));
        // Turned there and back.
        let rolled = [0.0, 0.0, -20.0, 0.0, 0.0, 0.0, 4e-7, 0.999_999_7, 1e-7];
        let set = SetCamera { look_at: Some(rolled), ..SetCamera::default() };
        assert_eq!(rounded(set, own).look_at.unwrap()[6..], [0.0, 1.0, 0.0]);
        // Far smaller and larger than usual.
        let far = |scale: f64| rounded(SetCamera { look_at: Some(look_at.map(|it| it * scale)), ..set }, own);
        for scale in [1e-30, 1e-5, 1e5, 1e30] {
            for (found, wanted) in far(scale).look_at.unwrap().iter().zip(look_at).take(6) {
                assert!((found - wanted * scale).abs() <= 1e-5 * scale, "{found} {wanted} {scale}");
            }
        }
    }
}
