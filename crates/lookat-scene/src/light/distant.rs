//! `LightSource "distant"`: parallel light from infinity.

use super::{FROM, Light, RADIANCE, SCALE, TO, point_in_range, same_points, scaled};
use crate::Transform;
use crate::params::Params;
use crate::schema::{Color, Key, Keys};

const IRRADIANCE: Key<Color> =
    Key { meaning: "the irradiance on a surface perpendicular to the light", ..RADIANCE };

pub(super) const KEYS: Keys = &[&IRRADIANCE, &FROM, &TO, &SCALE];

/// pbrt-v3's CreateDistantLight.
pub(super) fn distant(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let radiance = scaled(params, &IRRADIANCE);
    let to_light = point_in_range(params, &FROM) - point_in_range(params, &TO);
    let Some(direction) = world_from_light.vector(to_light).try_normalize() else {
        return same_points(params);
    };
    Some(Light::Distant { direction, radiance })
}
