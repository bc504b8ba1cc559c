//! `LightSource "goniometric"`: a point light with a map of its intensity by direction.

use glam::DVec3;

use super::{INTENSITY, Light, MAP_NAME, SCALE, UNIFORM, map_name, no_map, scaled, shown};
use crate::Transform;
use crate::params::Params;
use crate::picture::Pictures;
use crate::schema::{Color, Key, Keys, Name};

const WHERE_ONE: Key<Color> = Key { meaning: "the radiant intensity where the picture is 1", ..INTENSITY };
const ALL_DIRECTIONS: Key<Name> = Key {
    meaning: "the picture of all directions: the first row is +y, the last -y, the columns go from +x through +z",
    ..MAP_NAME
};

pub(super) const KEYS: Keys = &[&WHERE_ONE, &ALL_DIRECTIONS, &SCALE];

/// pbrt-v3's CreateGoniometricLight.
pub(super) fn goniometric(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let intensity = scaled(params, &WHERE_ONE);
    let Some(file) = map_name(params) else {
        no_map(params, "it has equal intensity in all directions");
        return Some(Light::Point { position: world_from_light.point(DVec3::ZERO), intensity });
    };
    let map = shown(params, &file, pictures, UNIFORM);
    Some(Light::Goniometric { world_from_light, intensity, map })
}
