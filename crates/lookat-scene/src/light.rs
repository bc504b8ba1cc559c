//! `LightSource` and `AreaLightSource`: the lights.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};
use lookat_syntax::{ParamType, Span, Text};

use crate::Transform;
use crate::cache::PictureSettings;
use crate::color::{self, LUMINANCE};
use crate::params::Params;
use crate::params::value::{Color, Name};
use crate::picture::Pictures;
use crate::schema::{Key, Keys, Kind, Range, Unit};
use crate::transform::{LARGEST, in_range};

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
    /// True if no ray can hit the light: it shines from a single point or direction.
    pub(crate) fn is_delta(&self) -> bool {
        !matches!(self, Light::Infinite { .. } | Light::Environment { .. })
    }

    /// Its picture.
    pub(crate) fn map(&self) -> Option<&Arc<MipMap<Vec3>>> {
        match self {
            Light::Environment { map, .. } | Light::Goniometric { map, .. } => Some(map),
            Light::Projection { map, .. } => map.as_ref(),
            _ => None,
        }
    }

    /// True if it gives no light at all.
    pub(crate) fn is_black(&self) -> bool {
        // Texels are at least 0.
        if self.map().is_some_and(|map| map.mean() == Vec3::ZERO) {
            return true;
        }
        self.color() == Vec3::ZERO
    }

    /// The factor of its light.
    pub(crate) fn color(&self) -> Vec3 {
        let (Light::Point { intensity: color, .. }
        | Light::Spot { intensity: color, .. }
        | Light::Goniometric { intensity: color, .. }
        | Light::Projection { intensity: color, .. }
        | Light::Distant { radiance: color, .. }
        | Light::Infinite { radiance: color, .. }
        | Light::Environment { scale: color, .. }) = self;
        *color
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
const SAMPLES: Key<i32> = Key { name: "samples", meaning: "old name of nsamples; overrides it", ..N_SAMPLES }
    .default_words("nsamples");

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("point", "a point that shines equally in all directions", &[POINT_KEYS]),
    Kind::new("spot", "a point that shines within a cone", &[SPOT_KEYS]),
    Kind::new(
        "goniometric",
        "a point whose intensity in each direction comes from a picture",
        &[GONIOMETRIC_KEYS],
    ),
    Kind::new("projection", "a slide projector", &[PROJECTION_KEYS]),
    Kind::new("distant", "parallel light from far away", &[DISTANT_KEYS]),
    Kind::new("infinite", "light from everywhere, or an environment map", &[INFINITE_KEYS]),
    Kind::new("exinfinite", "another name of infinite", &[INFINITE_KEYS]),
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
        "infinite" | "exinfinite" => Some(infinite(params, world_from_light, pictures)),
        "goniometric" => Some(goniometric(params, world_from_light, pictures)),
        "projection" => Some(projection(params, world_from_light, pictures)),
        "area" | "diffuse" => {
            let help = "to make the following shapes emit light, use AreaLightSource";
            params.reject("", "LightSource has no type for shapes", Some(help));
            return None;
        }
        _ => return params.reject_unknown_type(KINDS),
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

/// The picture of a light, with the values of the file in any format. `without`: how the light looks without a picture.
fn light_map(
    params: &mut Params,
    file: &Text,
    pictures: &mut Pictures,
    without: &str,
) -> Option<Arc<MipMap<Vec3>>> {
    let settings = PictureSettings {
        wrap: Wrap::Repeat,
        gamma: false,
        scale: 1.0_f32.to_bits(),
        bottom_up: false,
        not_negative: true,
    };
    let instead = format!("renders this light without the picture, {without}");
    pictures.get(params, MAP_NAME.name, file, settings, &instead)
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
        let is_rgb = params.was_of_type(name, &[ParamType::Rgb]);
        if color.min_element() < 0.0 && (is_rgb || color.dot(LUMINANCE.as_vec3()) < 0.0) {
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

const OFFSET: Key<[f64; 3]> =
    Key { meaning: "an offset from the origin of the current space", unit: Unit::WorldSpace, ..FROM };

const POINT_KEYS: Keys = &[&INTENSITY, &OFFSET, &SCALE];

/// pbrt-v3's CreatePointLight.
pub(super) fn point(params: &mut Params, world_from_light: Transform) -> Light {
    let intensity = scaled(params, &INTENSITY);
    let from = point_in_range(params, &OFFSET);
    // pbrt-v3 adds `from` in world space, without the current transformation (lights/point.cpp).
    let position = world_from_light.point(DVec3::ZERO) + from;
    check_placed(params, in_range(&position.to_array()));
    Light::Point { position, intensity }
}

const CONE_ANGLE: Key<f64> =
    Key::float("coneangle", 30.0, "the angle between the axis and the edge of the cone")
        .within(Range::above_to(0.0, 180.0))
        .unit(Unit::Degrees);
const CONE_DELTA_ANGLE: Key<f64> =
    Key::float("conedeltaangle", 5.0, "the width of the falloff inside the edge, from 0 to coneangle")
        .unit(Unit::Degrees);

const SPOT_KEYS: Keys = &[&INTENSITY, &FROM, &TO, &CONE_ANGLE, &CONE_DELTA_ANGLE, &SCALE];

/// pbrt-v3's CreateSpotLight.
pub(super) fn spot(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let intensity = scaled(params, &INTENSITY);
    let (cone, delta) = (params.take(&CONE_ANGLE), params.take(&CONE_DELTA_ANGLE));
    if params.usable() && !(0.0..=cone).contains(&delta) {
        let start = (cone - delta).abs();
        let message = if start < cone {
            format!("conedeltaangle is out of range: the falloff starts at {start} degrees, as in pbrt-v3")
        } else {
            "conedeltaangle is out of range: the light has no falloff inside its cone, as in pbrt-v3".into()
        };
        params.warn("conedeltaangle", &message, "write a conedeltaangle from 0 to coneangle");
    }
    let from = point_in_range(params, &FROM);
    let to = point_in_range(params, &TO);
    let Some(axis) = (to - from).try_normalize() else { return same_points(params) };
    // A non-uniform scale makes the choice of the frame visible, so this is pbrt's frame.
    let (x, y) = coordinate_system(axis);
    let frame = Transform::to_frame(DMat3::from_cols(x, y, axis));
    let world_from_light = world_from_light * Transform::translate(from) * frame;
    check_placed(params, world_from_light.in_range());
    Some(Light::Spot {
        world_from_light,
        intensity,
        cos_total_width: libm::cos(cone.to_radians()),
        cos_falloff_start: libm::cos((cone - delta).to_radians()),
    })
}

/// Two unit vectors that form a frame with the unit vector `v` (pbrt-v3's CoordinateSystem).
fn coordinate_system(v: DVec3) -> (DVec3, DVec3) {
    let x = if v.x.abs() > v.y.abs() { DVec3::new(-v.z, 0.0, v.x) } else { DVec3::new(0.0, v.z, -v.y) }
        .normalize();
    (x, v.cross(x))
}

const IRRADIANCE: Key<Color> =
    Key { meaning: "the irradiance on a surface perpendicular to the light", ..RADIANCE };

const DISTANT_KEYS: Keys = &[&IRRADIANCE, &FROM, &TO, &SCALE];

/// pbrt-v3's CreateDistantLight.
pub(super) fn distant(params: &mut Params, world_from_light: Transform) -> Option<Light> {
    let radiance = scaled(params, &IRRADIANCE);
    let to_light = point_in_range(params, &FROM) - point_in_range(params, &TO);
    let Some(direction) = world_from_light.vector(to_light).try_normalize() else {
        return same_points(params);
    };
    Some(Light::Distant { direction, radiance })
}

const FACTOR: Key<Color> = Key { meaning: "the radiance, or the factor of the environment map", ..RADIANCE };
const ENVIRONMENT: Key<Name> = Key {
    meaning: "the environment map: the first row is +z, the last -z, the columns go from +x through +y",
    ..MAP_NAME
};

const INFINITE_KEYS: Keys = &[&FACTOR, &ENVIRONMENT, &N_SAMPLES, &SAMPLES, &SCALE];

/// pbrt-v3's CreateInfiniteLight. An empty `mapname` is none.
pub(super) fn infinite(params: &mut Params, world_from_light: Transform, pictures: &mut Pictures) -> Light {
    let radiance = scaled(params, &FACTOR);
    let samples = samples(params);
    warn_scaled(params, &world_from_light);
    let map = map_name(params).and_then(|file| light_map(params, &file, pictures, UNIFORM));
    match map {
        Some(map) => Light::Environment { map, scale: radiance, world_from_light, samples },
        // Without its picture, as in pbrt-v3.
        None => Light::Infinite { radiance, samples },
    }
}

/// pbrt-v3 samples directions whose length is not 1 there (InfiniteAreaLight::Sample_Li).
fn warn_scaled(params: &mut Params, world_from_light: &Transform) {
    if world_from_light.uniform_scale(1e-4).is_some_and(|scale| (scale - 1.0).abs() < 1e-4) {
        return;
    }
    let message = "pbrt-v3 samples an infinite light under a scale or shear with the wrong density: the light is too bright or too dark";
    params.warn(
        "",
        message,
        "put the light before the Scale, or outside the block of the Scale; to turn the light, use Rotate",
    );
}

const WHERE_ONE: Key<Color> = Key { meaning: "the radiant intensity where the picture is 1", ..INTENSITY };
const ALL_DIRECTIONS: Key<Name> = Key {
    meaning: "the picture of all directions: the first row is +y, the last -y, the columns go from +x through +z",
    ..MAP_NAME
};

const GONIOMETRIC_KEYS: Keys = &[&WHERE_ONE, &ALL_DIRECTIONS, &SCALE];

/// pbrt-v3's CreateGoniometricLight.
pub(super) fn goniometric(
    params: &mut Params,
    world_from_light: Transform,
    pictures: &mut Pictures,
) -> Light {
    let intensity = scaled(params, &WHERE_ONE);
    let file = map_name(params);
    if file.is_none() {
        no_map(params, "it has equal intensity in all directions");
    }
    match file.and_then(|file| light_map(params, &file, pictures, UNIFORM)) {
        Some(map) => Light::Goniometric { world_from_light, intensity, map },
        None => Light::Point { position: world_from_light.point(DVec3::ZERO), intensity },
    }
}

const FOV: Key<f64> = Key::float("fov", 45.0, "the angle of the shorter side of the picture")
    .within(Range::between(0.0, 180.0))
    .unit(Unit::Degrees);
const SLIDE: Key<Name> = Key { meaning: "the picture, with its first row at the smallest y", ..MAP_NAME }
    .default_words("a white square");

const PROJECTION_KEYS: Keys = &[&WHERE_ONE, &FOV, &SLIDE, &SCALE];

/// pbrt-v3's CreateProjectionLight.
pub(super) fn projection(params: &mut Params, world_from_light: Transform, pictures: &mut Pictures) -> Light {
    let intensity = scaled(params, &WHERE_ONE);
    let fov = params.take(&FOV);
    let file = map_name(params);
    if file.is_none() {
        no_map(params, "it projects a white square");
    }
    let map = file.and_then(|file| light_map(params, &file, pictures, "as a white square"));
    let aspect = map.as_ref().map_or(1.0, |map| {
        let [width, height] = map.picture_size().map(|side| side as f64);
        width / height
    });
    let half_size = DVec2::splat(libm::tan(fov.to_radians() / 2.0));
    let half_size = half_size * DVec2::new(aspect.max(1.0), aspect.recip().max(1.0));
    Light::Projection { world_from_light, intensity, map, half_size }
}

/// The emission of an area light: `AreaLightSource "diffuse"`, with equal radiance in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emission {
    /// Emitted radiance, linear RGB, each component at most 1e18 (parameters `L` times `scale`).
    pub radiance: Vec3,
    /// True if both sides emit. Default: only the side of the normal emits.
    pub two_sided: bool,
    /// Light samples per camera sample in the direct lighting integrator, from 1 to 65,536. Default 1.
    pub samples: u32,
    /// The AreaLightSource directive. `None` for an emission made in code.
    pub span: Option<Span>,
}

impl Emission {
    /// Emission of this radiance on the side of the normal.
    pub fn new(radiance: Vec3) -> Emission {
        Emission { radiance, two_sided: false, samples: 1, span: None }
    }

    /// True if the radiance is zero.
    pub fn is_black(&self) -> bool {
        self.radiance == Vec3::ZERO
    }
}

const TWO_SIDED: Key<bool> =
    Key::bool("twosided", false, "true emits on both sides of the surface, false on the side of the normal");

const AREA_KEYS: Keys = &[&RADIANCE, &SCALE, &TWO_SIDED, &N_SAMPLES, &SAMPLES];

pub(crate) const AREA_KINDS: &[Kind] = &[
    Kind::new("diffuse", "equal radiance in all directions of each surface point", &[AREA_KEYS]),
    Kind::new("area", "an old name of diffuse", &[AREA_KEYS]),
];

/// pbrt-v3's CreateDiffuseAreaLight.
pub(crate) fn emission(params: &mut Params) -> Option<Emission> {
    // As in pbrt-v3, an empty type ends the emission of the following shapes.
    if params.kind().is_empty() {
        return None;
    }
    if !params.is_known_kind(AREA_KINDS) {
        return params.reject_unknown_type(AREA_KINDS);
    }
    let radiance = scaled(params, &RADIANCE);
    let two_sided = params.take(&TWO_SIDED);
    let samples = samples(params);
    params.finish().then_some(Emission { radiance, two_sided, samples, span: None })
}
