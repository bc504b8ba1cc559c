//! `LightSource "projection"`: a slide projector.

use glam::DVec2;

use super::{INTENSITY, Light, MAP_NAME, SCALE, map_name, no_map, scaled, shown};
use crate::Transform;
use crate::params::Params;
use crate::picture::Pictures;
use crate::schema::{Color, Key, Keys, Name, Range, Unit};

const WHERE_ONE: Key<Color> = Key { meaning: "the radiant intensity where the picture is 1", ..INTENSITY };
const FOV: Key<f64> = Key::float("fov", 45.0, "the angle of the shorter side of the picture")
    .within(Range::between(0.0, 180.0))
    .unit(Unit::Degrees);
const SLIDE: Key<Name> = Key { meaning: "the picture, with its first row at the smallest y", ..MAP_NAME }
    .default_words("a white square");

pub(super) const KEYS: Keys = &[&WHERE_ONE, &FOV, &SLIDE, &SCALE];

/// pbrt-v3's CreateProjectionLight.
pub(super) fn projection(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let intensity = scaled(params, &WHERE_ONE);
    let fov = params.take(&FOV);
    let map = match map_name(params) {
        Some(file) => Some(shown(params, &file, pictures, "as a white square")),
        None => {
            no_map(params, "it projects a white square");
            None
        }
    };
    let half_size = libm::tan(fov.to_radians() / 2.0);
    Some(Light::Projection {
        world_from_light,
        intensity,
        map,
        // The loaded picture stretches it.
        half_size: DVec2::splat(half_size),
    })
}
