//! `LightSource` and `AreaLightSource`: the lights.

mod area;
mod distant;
mod goniometric;
mod infinite;
mod point;
mod projection;
mod spot;

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};
use lookat_syntax::Text;

use crate::Transform;
use crate::color::{self, LUMINANCE};
use crate::params::Params;
use crate::picture::{Pictures, Settings};
use crate::schema::{Color, Key, Kind, Name, Unit, names};
use crate::transform::LARGEST;

pub use area::Emission;
pub(crate) use area::{AREA_KINDS, emission};
use distant::distant;
use goniometric::goniometric;
use infinite::infinite;
use point::point;
use projection::projection;
use spot::spot;

/// A light without a shape. Each component of its color is at most 1e18.
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
        /// From light space, where the light is the origin (`from`, default the origin) and +z is the axis (from `from` to `to`,
        /// default +z).
        world_from_light: Transform,
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
        /// Light samples per camera sample in the direct lighting integrator, from 1 to 65,536 (`nsamples`, default 1).
        samples: u32,
    },
    /// An environment map (`infinite` with `mapname`).
    Environment {
        /// Latitude from +z in the first row to -z in the last, longitude from +x through +y, in light space
        /// (`mapname`). Values are at least 0.
        map: Arc<MipMap<Vec3>>,
        /// The factor on the map (`L` times `scale`).
        scale: Vec3,
        /// From light space to world space. Only directions count.
        world_from_light: Transform,
        /// Light samples per camera sample in the direct lighting integrator, from 1 to 65,536 (`nsamples`, default 1).
        samples: u32,
    },
    /// A point light with a map of its intensity by direction (`goniometric`).
    Goniometric {
        /// From light space, where the light is the origin.
        world_from_light: Transform,
        /// Radiant intensity where the map is 1 (`I` times `scale`).
        intensity: Vec3,
        /// Latitude from +y in the first row to -y in the last, longitude from +x through +z, in light space
        /// (`mapname`). Values are at least 0.
        map: Arc<MipMap<Vec3>>,
    },
    /// A slide projector (`projection`).
    Projection {
        /// From light space, where the light is the origin and +z the axis of projection.
        world_from_light: Transform,
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

const SCALE: Key<Color> = Key::color("scale", 1.0, "a factor of the light");
const INTENSITY: Key<Color> = Key::color("I", 1.0, "the radiant intensity");
const RADIANCE: Key<Color> = Key::color("L", 1.0, "the radiance");
const MAP_NAME: Key<Name> = Key::string("mapname", "the picture file");
const FROM: Key<[f64; 3]> =
    Key::point("from", [0.0; 3], "the start of the light's axis").unit(Unit::ObjectSpace);
const TO: Key<[f64; 3]> = Key::point("to", [0.0, 0.0, 1.0], "the end of the light's axis, not equal to from")
    .unit(Unit::ObjectSpace);
const N_SAMPLES: Key<i32> = Key::integer(
    "nsamples",
    1,
    "the light samples at each surface, for directlighting; below 1 counts as 1, over 65536 as 65536",
);
const SAMPLES: Key<i32> =
    Key { name: "samples", meaning: "an old name of nsamples, which replaces it", ..N_SAMPLES }
        .default_words("nsamples");

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("LightSource", "point", "a point that shines equally in all directions", &[point::KEYS]),
    Kind::new("LightSource", "spot", "a point that shines within a cone", &[spot::KEYS]),
    Kind::new(
        "LightSource",
        "goniometric",
        "a point whose intensity in each direction comes from a picture",
        &[goniometric::KEYS],
    ),
    Kind::new("LightSource", "projection", "a slide projector", &[projection::KEYS]),
    Kind::new("LightSource", "distant", "parallel light from far away", &[distant::KEYS]),
    Kind::new("LightSource", "infinite", "light from everywhere, or an environment map", &[infinite::KEYS]),
    Kind::new("LightSource", "exinfinite", "another name of infinite", &[infinite::KEYS]),
];

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
        _ => return params.unknown_kind(&names(KINDS)),
    };
    let is_usable = params.finish();
    light.filter(|_| is_usable)
}

/// A point in the range of computation.
fn point_in_range(params: &mut Params, key: &Key<[f64; 3]>) -> DVec3 {
    let point = params.take(key);
    params.check_range(key.name, &point.to_array());
    point
}

/// Reports a light outside the range of computation.
fn check_placed(params: &mut Params, is_in_range: bool) {
    if !is_in_range {
        params.reject("from", format!("the light has coordinates above {LARGEST:e} in world space"), None);
    }
}

fn same_points<T>(params: &mut Params) -> Option<T> {
    if params.usable() && !params.may_lack("from") {
        let are_given = params.was_taken("from") && params.was_taken("to");
        let help = (!are_given).then_some("the default of from is 0 0 0, the default of to is 0 0 1");
        params.reject("to", "from and to are the same point: the light has no direction", help);
    }
    None
}

/// The picture name of a light. An empty name is none, as in pbrt-v3.
fn map_name(params: &mut Params) -> Option<Text> {
    params.take(&MAP_NAME).filter(|file| !file.value.is_empty())
}

/// How infinite and goniometric lights look without a picture.
const UNIFORM: &str = "uniform in all directions";

/// A handle for the picture of a light, with the values of the file in any format. `without`: how the light looks
/// without a picture.
fn shown(params: &Params, file: &Text, pictures: &mut Pictures, without: &str) -> Arc<MipMap<Vec3>> {
    let settings =
        Settings { wrap: Wrap::Repeat, gamma: false, scale: 1.0, bottom_up: false, not_negative: true };
    let instead = format!("renders this light without the picture, {without}");
    pictures.colors.handle(params, &MAP_NAME, file, settings, &instead)
}

fn no_map(params: &mut Params, what_it_does: &str) {
    let message = format!("LightSource \"{}\" without mapname: {what_it_does}", params.kind());
    params.warn("mapname", &message, "add \"string mapname\" with the name of a picture");
}

/// A color times `scale`.
fn scaled(params: &mut Params, key: &Key<Color>) -> Vec3 {
    let [color, scale] = [key, &SCALE].map(|key| {
        let (name, color) = (key.name, params.take(key));
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
    let product = color * scale;
    if !color::is_in_range(product) {
        let (name, limit) = (key.name, color::LARGEST);
        params.reject(name, format!("{name} times scale is too bright; the limit is {limit:e}"), None);
    }
    product
}

/// The number of light samples. `samples` has precedence, as in pbrt-v3.
fn samples(params: &mut Params) -> u32 {
    let samples = params.nested_samples(&N_SAMPLES);
    let samples = params.nested_samples(&Key { default: samples, ..SAMPLES });
    params.replaced_by("nsamples", &["samples"]);
    samples.max(1) as u32
}
