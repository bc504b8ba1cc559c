//! The camera of the page: what a request makes of the camera of the file, and its values.

use lookat_render::Prepared;
use lookat_scene::glam::{DVec2, DVec3};
use lookat_scene::{
    Camera, CameraPlacement, Lens, Loaded, Projection, Scene, ScreenWindow, Transform, ViewOverride,
};

use super::messages;

/// The plane of focus of a lens that nobody has focused, as in the format.
const UNFOCUSED: f64 = 1e6;

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
    let looking =
        CameraPlacement { span: None, before: Transform::IDENTITY, points, after: Transform::IDENTITY };
    let before = world_from_camera.inverse() * looking.world_from_camera().ok()?;
    Some(CameraPlacement { before, ..looking })
}

/// The camera of the file with what the page sets. Fails with the reason.
pub fn changed(
    own: Camera,
    placement: Option<CameraPlacement>,
    set: &ViewOverride,
) -> Result<Camera, String> {
    set.check()?;
    let mut camera = own;
    if let Some(points) = set.look_at {
        let placement = placement.ok_or("the camera of the file has no direction")?;
        let placed = CameraPlacement { points, ..placement }.world_from_camera();
        camera.world_from_camera = placed.map_err(|fault| fault.to_string())?;
    }
    if let (Some(fov), Projection::Perspective { .. }) = (set.fov, own.projection) {
        camera.projection = Projection::Perspective { fov };
    }
    if let Some([x0, x1, y0, y1]) = set.screen_window {
        camera.screen = ScreenWindow { min: DVec2::new(x0, y0), max: DVec2::new(x1, y1) };
    }
    if own.projection != Projection::Environment {
        let radius = set.lens_radius.or(own.lens.map(|lens| lens.radius)).unwrap_or(0.0);
        let distance = set.focal_distance.or(own.lens.map(|lens| lens.focal_distance));
        let lens = Lens { radius, focal_distance: distance.unwrap_or(UNFOCUSED) };
        camera.lens = (radius > 0.0).then_some(lens);
    }
    Ok(camera)
}

/// The values of a camera that a `LookAt` of `points` places.
pub fn values(camera: &Camera, placement: Option<&CameraPlacement>, points: [f64; 9]) -> messages::Camera {
    let ScreenWindow { min, max } = camera.screen;
    let before = placement.map_or(Transform::IDENTITY, |placement| placement.before);
    let signs = before.vector(DVec3::ONE);
    let (kind, fov) = match camera.projection {
        Projection::Perspective { fov } => ("perspective", Some(fov)),
        Projection::Orthographic { .. } => ("orthographic", None),
        Projection::Environment => ("environment", None),
    };
    messages::Camera {
        kind,
        look_at: points,
        has_look_at: placement.is_some_and(|placement| placement.span.is_some()),
        mirrored: [signs.x < 0.0, signs.y < 0.0],
        fov,
        lens_radius: camera.lens.map_or(0.0, |lens| lens.radius),
        focal_distance: camera.lens.map(|lens| lens.focal_distance),
        screen_window: [min.x, max.x, min.y, max.y],
    }
}
