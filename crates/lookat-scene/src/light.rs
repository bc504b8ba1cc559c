//! `LightSource` and `AreaLightSource`: the lights.

mod goniometric;
mod infinite;
mod projection;

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};
use lookat_syntax::Text;

use crate::color::LUMINANCE;
use crate::params::Params;
use crate::picture::{Pictures, Settings};
use crate::{Emission, Transform};

use goniometric::goniometric;
use infinite::infinite;
use projection::projection;

/// A light without a shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// A point light with equal intensity in all directions (`point`).
    Point {
        /// World position: the origin of the current space plus `from`, which is in world space (default 0).
        position: DVec3,
        /// Radiant intensity (`I` times `scale`).
        intensity: Vec3,
    },
    /// A point light within a cone (`spot`).
    Spot {
        /// World position (`from`, default the origin).
        position: DVec3,
        /// Transforms world directions to light space, where +z is the axis (from `from` to `to`, default +z).
        light_from_world: DMat3,
        /// Radiant intensity along the axis (`I` times `scale`).
        intensity: Vec3,
        /// Cosine of the half angle of the cone (`coneangle`, default 30 degrees).
        cos_total_width: f64,
        /// Cosine of the angle where falloff starts: `coneangle` minus `conedeltaangle` (default 5 degrees).
        cos_falloff_start: f64,
    },
    /// Parallel light from infinity (`distant`).
    Distant {
        /// Unit vector toward the light (from `to` to `from`, default -z).
        direction: DVec3,
        /// Irradiance on a perpendicular surface (`L` times `scale`).
        radiance: Vec3,
    },
    /// Constant radiance from all directions (`infinite`).
    Infinite {
        /// Radiance (`L` times `scale`).
        radiance: Vec3,
        /// Light samples per camera sample in the direct lighting integrator (`nsamples`, default 1).
        samples: u32,
    },
    /// An environment map (`infinite` with `mapname`).
    Environment {
        /// Latitude from +z in the first row to -z in the last, longitude from +x through +y, in light space
        /// (`mapname`). Values are at least 0.
        map: Arc<MipMap<Vec3>>,
        /// The factor on the map (`L` times `scale`).
        scale: Vec3,
        /// Transforms directions from light space to world space.
        world_from_light: DMat3,
        /// The inverse.
        light_from_world: DMat3,
        /// Light samples per camera sample in the direct lighting integrator (`nsamples`, default 1).
        samples: u32,
    },
    /// A point light with a map of its intensity by direction (`goniometric`).
    Goniometric {
        /// World position: the origin of light space.
        position: DVec3,
        /// Transforms world directions to light space.
        light_from_world: DMat3,
        /// Radiant intensity where the map is 1 (`I` times `scale`).
        intensity: Vec3,
        /// Latitude from +y in the first row to -y in the last, longitude from +x through +z, in light space
        /// (`mapname`). Values are at least 0.
        map: Arc<MipMap<Vec3>>,
    },
    /// A slide projector (`projection`).
    Projection {
        /// World position: the origin of light space.
        position: DVec3,
        /// Transforms world directions to light space, where +z is the axis of projection.
        light_from_world: DMat3,
        /// Radiant intensity where the map is 1 (`I` times `scale`).
        intensity: Vec3,
        /// The picture, with the smallest y in its first row (`mapname`). `None` is 1 everywhere. Values are at least
        /// 0.
        map: Option<Arc<MipMap<Vec3>>>,
        /// Half the size of the picture at z = 1 in light space (from `fov` of the shorter side, default 45 degrees).
        half_size: DVec2,
    },
}

impl Light {
    /// Whether no ray can hit the light: it shines from a single point or direction.
    pub(crate) fn is_delta(&self) -> bool {
        !matches!(self, Light::Infinite { .. } | Light::Environment { .. })
    }

    /// Whether it gives no light at all.
    pub(crate) fn is_black(&self) -> bool {
        let map = match self {
            Light::Environment { map, .. } | Light::Goniometric { map, .. } => Some(map),
            Light::Projection { map, .. } => map.as_ref(),
            _ => None,
        };
        // Texels are at least 0.
        if map.is_some_and(|map| map.mean() == Vec3::ZERO) {
            return true;
        }
        let (Light::Point { intensity: color, .. }
        | Light::Spot { intensity: color, .. }
        | Light::Goniometric { intensity: color, .. }
        | Light::Projection { intensity: color, .. }
        | Light::Distant { radiance: color, .. }
        | Light::Infinite { radiance: color, .. }
        | Light::Environment { scale: color, .. }) = self;
        *color == Vec3::ZERO
    }
}

const N_SAMPLES: crate::schema::Key<i32> =
    crate::schema::Key::integer("nsamples", 1, "light samples at each surface, for direct lighting");

pub(crate) const NAMES: &[&str] = &["point", "spot", "goniometric", "projection", "distant", "infinite"];

/// pbrt-v3's MakeLight.
pub(crate) fn light(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Option<Light> {
    let light = match params.kind() {
        "point" => Some(point(params, world_from_light)),
        "spot" => spot(params, world_from_light),
        "distant" => distant(params, world_from_light),
        "infinite" | "exinfinite" => infinite(params, world_from_light, pictures),
        "goniometric" => goniometric(params, world_from_light, pictures),
        "projection" => projection(params, world_from_light, pictures),
        "area" | "diffuse" => {
            let help = "to make the following shapes emit light, use AreaLightSource";
            params.reject("", "LightSource has no type for shapes", Some(help));
            return None;
        }
        _ => return params.unknown_kind(NAMES),
    };
    let is_usable = params.finish();
    light.filter(|_| is_usable)
}

fn point(params: &mut Params, world_from_light: Transform) -> Light {
    let intensity = scaled(params, "I");
    let from = point_in_range(params, "from", DVec3::ZERO);
    // pbrt-v3 adds `from` in world space, without the current transformation (lights/point.cpp).
    Light::Point { position: world_from_light.point(DVec3::ZERO) + from, intensity }
}

fn distant(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let radiance = scaled(params, "L");
    let to_light = point_in_range(params, "from", DVec3::ZERO) - point_in_range(params, "to", DVec3::Z);
    let Some(direction) = world_from_light.vector(to_light).try_normalize() else {
        return same_points(params);
    };
    Some(Light::Distant { direction, radiance })
}

fn point_in_range(params: &mut Params, name: &'static str, default: DVec3) -> DVec3 {
    let point = params.triple(name, lookat_syntax::ParamType::Point3, default.into());
    params.check_range(name, &point.to_array());
    point
}

fn same_points<T>(params: &mut Params) -> Option<T> {
    if params.usable() && !params.may_lack("from") {
        let are_given = params.was_taken("from") && params.was_taken("to");
        let help = (!are_given).then_some("the default of from is 0 0 0, the default of to is 0 0 1");
        params.reject("to", "from and to are the same point: the light has no direction", help);
    }
    None
}

fn spot(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let intensity = scaled(params, "I");
    let cone = params.angle("coneangle", 30.0);
    let delta = params.angle("conedeltaangle", 5.0);
    if !(cone > 0.0 && cone <= 180.0) {
        params.reject("coneangle", "coneangle must be above 0 and at most 180 degrees", None);
    } else if !(0.0..=cone).contains(&delta) {
        let start = (cone - delta).abs();
        let message = match start < cone {
            true => format!(
                "conedeltaangle is out of range: the falloff starts at {start} degrees, as in pbrt-v3"
            ),
            false => {
                "conedeltaangle is out of range: the light has no falloff inside its cone, as in pbrt-v3"
                    .into()
            }
        };
        params.warn("conedeltaangle", &message, "write a conedeltaangle from 0 to coneangle");
    }
    let from = point_in_range(params, "from", DVec3::ZERO);
    let to = point_in_range(params, "to", DVec3::Z);
    let Some(axis) = (to - from).try_normalize() else { return same_points(params) };
    // pbrt-v3's CreateSpotLight. A non-uniform scale makes the choice of the frame visible, so this is pbrt's frame.
    let (x, y) = coordinate_system(axis);
    let axes_from_frame = DMat3::from_cols(x, y, axis);
    Some(Light::Spot {
        position: world_from_light.point(from),
        light_from_world: axes_from_frame.transpose() * DMat3::from_mat4(world_from_light.inv),
        intensity,
        cos_total_width: cone.to_radians().cos(),
        cos_falloff_start: (cone - delta).to_radians().cos(),
    })
}

/// Two unit vectors that form a frame with the unit vector `v` (pbrt-v3's CoordinateSystem).
fn coordinate_system(v: DVec3) -> (DVec3, DVec3) {
    let x = if v.x.abs() > v.y.abs() { DVec3::new(-v.z, 0.0, v.x) } else { DVec3::new(0.0, v.z, -v.y) }
        .normalize();
    (x, v.cross(x))
}

/// The picture name of a light. An empty name is none, as in pbrt-v3.
fn map_name(params: &mut Params) -> Option<Text> {
    params.string("mapname").filter(|file| !file.value.is_empty())
}

/// How infinite and goniometric lights look without a picture.
const UNIFORM: &str = "uniform in all directions";

/// The picture of a light, with the values of the file in any format. After an error, the light has no picture, as in
/// pbrt-v3. `without`: how the light looks without a picture.
fn shown(
    params: &mut Params,
    file: &Text,
    pictures: &mut Pictures,
    without: &str,
) -> Option<Arc<MipMap<Vec3>>> {
    let settings =
        Settings { wrap: Wrap::Repeat, gamma: false, scale: 1.0, bottom_up: false, not_negative: true };
    let instead = format!("renders this light without the picture, {without}");
    params.dispensable(|params| pictures.colors.get(params, "mapname", file, settings, &instead))
}

fn no_map(params: &mut Params, what_it_does: &str) {
    let message = format!("LightSource \"{}\" without mapname: {what_it_does}", params.kind());
    params.warn("mapname", &message, "add \"string mapname\" with the name of a picture");
}

fn scaled(params: &mut Params, name: &'static str) -> Vec3 {
    let [color, scale] = [name, "scale"].map(|name| {
        let color = params.spectrum(name, Vec3::ONE);
        // Spectra outside the sRGB gamut have negative components.
        if color.min_element() < 0.0 && (params.was_rgb(name) || color.dot(LUMINANCE.as_vec3()) < 0.0) {
            params.warn(
                name,
                "a light with a negative color subtracts light; pbrt-v3 shows samples below 0 as black",
                "use colors of 0 or more",
            );
        }
        color
    });
    color * scale
}

/// The number of light samples. `samples` is an old name, which has precedence in pbrt-v3.
fn samples(params: &mut Params) -> u32 {
    let samples = params.nested_samples(&crate::schema::Key { default: 1, ..N_SAMPLES });
    params.nested_samples(&crate::schema::Key { name: "samples", default: samples, ..N_SAMPLES }).max(1)
        as u32
}

pub(crate) const AREA_NAMES: &[&str] = &["diffuse", "area"];

/// pbrt-v3's CreateDiffuseAreaLight.
pub(crate) fn emission(params: &mut Params) -> Option<Emission> {
    // As in pbrt-v3, an empty type ends the emission of the following shapes.
    if params.kind().is_empty() {
        return None;
    }
    if !AREA_NAMES.contains(&params.kind()) {
        return params.unknown_kind(AREA_NAMES);
    }
    let radiance = scaled(params, "L");
    let two_sided = params.bool("twosided", false);
    let samples = samples(params);
    params.finish().then_some(Emission { radiance, two_sided, samples })
}
