//! `LightSource "projection"`: a slide projector.
//!
//! - `I`: radiant intensity where the map is 1, color, default 1
//! - `fov`: angle of the shorter side of the picture, in degrees, default 45
//! - `mapname`: the picture, default a white square
//! - `scale`: a factor, color, default 1

use glam::{DMat3, DVec2, DVec3};

use super::{Light, map_name, no_map, scaled, shown};
use crate::Transform;
use crate::params::Params;
use crate::picture::Pictures;

/// pbrt-v3's CreateProjectionLight.
pub(super) fn projection(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let intensity = scaled(params, "I");
    let fov = params.angle("fov", 45.0);
    if !(fov > 0.0 && fov < 180.0) {
        params.reject("fov", "fov must be above 0 and below 180 degrees", None);
    }
    let map = match map_name(params) {
        Some(file) => shown(params, &file, pictures, "as a white square"),
        None => {
            no_map(params, "it projects a white square");
            None
        }
    };
    let aspect = map.as_ref().map_or(1.0, |map| {
        let [width, height] = map.picture_size().map(|side| side as f64);
        width / height
    });
    let half_size = (fov.to_radians() / 2.0).tan();
    Some(Light::Projection {
        position: world_from_light.point(DVec3::ZERO),
        light_from_world: DMat3::from_mat4(world_from_light.inv),
        intensity,
        map,
        half_size: half_size * DVec2::new(aspect.max(1.0), aspect.recip().max(1.0)),
    })
}
