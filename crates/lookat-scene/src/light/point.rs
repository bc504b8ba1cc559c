//! `LightSource "point"`: a point light with equal intensity in all directions.

use glam::DVec3;

use super::{FROM, INTENSITY, Light, SCALE, check_placed, point_in_range, scaled};
use crate::Transform;
use crate::params::Params;
use crate::schema::{Key, Keys, Unit};
use crate::transform::in_range;

const OFFSET: Key<[f64; 3]> =
    Key { meaning: "an offset from the origin of the current space", unit: Unit::WorldSpace, ..FROM };

pub(super) const KEYS: Keys = &[&INTENSITY, &OFFSET, &SCALE];

/// pbrt-v3's CreatePointLight.
pub(super) fn point(params: &mut Params, world_from_light: Transform) -> Light {
    let intensity = scaled(params, &INTENSITY);
    let from = point_in_range(params, &OFFSET);
    // pbrt-v3 adds `from` in world space, without the current transformation (lights/point.cpp).
    let position = world_from_light.point(DVec3::ZERO) + from;
    check_placed(params, in_range(&position.to_array()));
    Light::Point { position, intensity }
}
