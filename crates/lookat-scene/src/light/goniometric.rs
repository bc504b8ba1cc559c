//! `LightSource "goniometric"`: a point light with a map of its intensity by direction.
//!
//! - `I`: radiant intensity where the map is 1, color, default 1
//! - `mapname`: map of all directions, default 1 everywhere
//! - `scale`: a factor, color, default 1

use glam::{DMat3, DVec3};

use super::{Light, UNIFORM, map_name, no_map, scaled, shown};
use crate::Transform;
use crate::params::Params;
use crate::picture::Pictures;

/// pbrt-v3's CreateGoniometricLight.
pub(super) fn goniometric(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let intensity = scaled(params, "I");
    let position = world_from_light.point(DVec3::ZERO);
    let Some(file) = map_name(params) else {
        no_map(params, "it has equal intensity in all directions");
        return Some(Light::Point { position, intensity });
    };
    let Some(map) = shown(params, &file, pictures, UNIFORM) else {
        return Some(Light::Point { position, intensity });
    };
    let light_from_world = DMat3::from_mat4(world_from_light.inv);
    Some(Light::Goniometric { position, light_from_world, intensity, map })
}
