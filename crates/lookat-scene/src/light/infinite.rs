//! `LightSource "infinite"`: light from all directions.

use glam::DVec3;

use super::{
    Light, MAP_NAME, N_SAMPLES, RADIANCE, SAMPLES, SCALE, UNIFORM, map_name, samples, scaled, shown,
};
use crate::Transform;
use crate::params::Params;
use crate::picture::Pictures;
use crate::schema::{Color, Key, Keys, Name};

const FACTOR: Key<Color> = Key { meaning: "the radiance, or the factor of the environment map", ..RADIANCE };
const ENVIRONMENT: Key<Name> = Key {
    meaning: "the environment map: the first row is +z, the last -z, the columns go from +x through +y",
    ..MAP_NAME
};

pub(super) const KEYS: Keys = &[&FACTOR, &ENVIRONMENT, &N_SAMPLES, &SAMPLES, &SCALE];

/// pbrt-v3's CreateInfiniteLight. An empty `mapname` is none.
pub(super) fn infinite(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let radiance = scaled(params, &FACTOR);
    let samples = samples(params);
    warn_scaled(params, &world_from_light);
    let Some(file) = map_name(params) else {
        return Some(Light::Infinite { radiance, samples });
    };
    Some(Light::Environment {
        map: shown(params, &file, pictures, UNIFORM),
        scale: radiance,
        world_from_light,
        samples,
    })
}

/// pbrt-v3 samples directions whose length is not 1 there (InfiniteAreaLight::Sample_Li).
fn warn_scaled(params: &mut Params, world_from_light: &Transform) {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| world_from_light.vector(axis));
    let is_unit = |axis: DVec3| (axis.length() - 1.0).abs() < 1e-4;
    let is_square = |a: DVec3, b: DVec3| a.dot(b).abs() < 1e-4;
    if [x, y, z].into_iter().all(is_unit) && is_square(x, y) && is_square(y, z) && is_square(z, x) {
        return;
    }
    let message = "pbrt-v3 samples an infinite light under a scale or shear with the wrong density: the light is too bright or too dark";
    params.warn(
        "",
        message,
        "put the light before the Scale, or outside the block of the Scale; to turn the light, use Rotate",
    );
}
