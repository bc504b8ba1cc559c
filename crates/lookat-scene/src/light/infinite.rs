//! `LightSource "infinite"`: light from all around.
//!
//! - `L`: radiance, color, default 1; with a map its factor
//! - `mapname`: picture of all directions, default none
//! - `nsamples`, or `samples`: of direct light per camera sample, default 1
//! - `scale`: a factor, color, default 1

use glam::DMat3;

use super::{Light, map_name, samples, scaled, shown};
use crate::Transform;
use crate::color::LARGEST;
use crate::params::Params;
use crate::picture::Pictures;

/// pbrt-v3's CreateInfiniteLight. An empty `mapname` is none.
pub(super) fn infinite(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let radiance = scaled(params, "L");
    let samples = samples(params);
    let Some(map) = map_name(params).and_then(|file| shown(params, &file, pictures)) else {
        return Some(Light::Infinite { radiance, samples });
    };
    Some(Light::Environment {
        map,
        scale: radiance.clamp(-glam::Vec3::splat(LARGEST), glam::Vec3::splat(LARGEST)),
        world_from_light: DMat3::from_mat4(world_from_light.m),
        light_from_world: DMat3::from_mat4(world_from_light.inv),
        samples,
    })
}
