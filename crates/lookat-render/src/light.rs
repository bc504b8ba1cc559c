//! Lights: where to look for light from a point, and how likely each direction is looked at.

mod choice;
mod environment;
mod facing;
mod goniometric;
pub(crate) mod lanes;
mod lune;
mod mesh;
mod projection;
mod receiver;
mod sphere;
mod surface;

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_scene::{DirectStrategy, Light, Primitive, Transform, World};

use crate::bsdf::Domain;
use crate::ray::{ElementId, Ray};
use crate::surface::Surface;
use crate::trace::lanes::Labels;
use crate::traceable::Traceable;
use environment::{Environment, EnvironmentSample};
use goniometric::Goniometric;
pub(crate) use lune::Lune;
use projection::Projection;
pub(crate) use receiver::Receiver;
use surface::{SurfaceForm, SurfaceLight};

/// All lights of a scene.
pub(crate) struct LightTable {
    /// Skies last, and of these last those that are everywhere alike.
    lights: Vec<SceneLight>,
    /// The number of the first sky.
    first_sky: usize,
    /// How many are not everywhere alike: all that there is to sample from a surface without a [`Lune`].
    uneven: usize,
    /// The share of each light in the power of all, about; and the sums up to each that is no sky.
    power_shares: Vec<f64>,
    power_cdf: Vec<f64>,
    /// The light that a primitive is, or none.
    of_primitive: Vec<Option<usize>>,
    has_surfaces: bool,
    /// The sum of what comes alike from all directions in which there is nothing.
    background: Vec3,
    /// World position of the origin.
    origin: DVec3,
    labels: Labels,
    source: Arc<World>,
}

/// A light, relative to the origin.
enum SceneLight {
    Point {
        position: DVec3,
        intensity: Vec3,
    },
    Spot {
        position: DVec3,
        light_from_world: DMat3,
        intensity: Vec3,
        cos_total_width: f64,
        cos_falloff_start: f64,
    },
    Distant {
        direction: DVec3,
        radiance: Vec3,
    },
    Infinite {
        radiance: Vec3,
        samples: u32,
    },
    Environment(Box<Environment>),
    Goniometric(Goniometric),
    Projection(Projection),
    Surface(SurfaceLight),
}

/// Light that may reach a point from one direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Radiance, or for lights that are only a point or direction the irradiance on a surface that faces them. Nothing
    /// has been looked up about what is in the way.
    pub li: Vec3,
    /// Density by solid angle; `None` for lights that no other direction can hit.
    pub pdf: Option<f64>,
    /// The ray that must be free.
    pub shadow: Ray,
}

/// A light that is a point, as it is seen from somewhere.
struct PointLight {
    position: DVec3,
    /// The direction to it.
    wi: DVec3,
    squared_distance: f64,
    /// That towards the place from where it is seen, not 0.
    intensity: Vec3,
}

impl LightTable {
    /// The lights of a world, in the coordinates of its traceable form.
    pub fn new(source: &Arc<World>, traceable: &Traceable) -> Self {
        let origin = traceable.origin;
        let all = source.lights.iter().map(|light| SceneLight::new(light, origin));
        let (mut skies, mut lights): (Vec<SceneLight>, Vec<SceneLight>) = all.partition(SceneLight::is_sky);
        let mut of_primitive = vec![None; source.primitives.len()];
        for (number, primitive) in source.primitives.iter().enumerate() {
            if let Some(light) = SurfaceLight::new(number as u32, primitive, traceable) {
                of_primitive[number] = Some(lights.len());
                lights.push(SceneLight::Surface(light));
            }
        }
        let background = source.lights.iter().fold(Vec3::ZERO, |sum, light| match light {
            Light::Infinite { radiance, .. } => sum + *radiance,
            _ => sum,
        });
        skies.sort_by_key(SceneLight::is_even);
        let first_sky = lights.len();
        let uneven = first_sky + skies.partition_point(|sky| !sky.is_even());
        lights.extend(skies);
        let power_shares = choice::power_shares(&lights, choice::radius(traceable));
        LightTable {
            power_cdf: choice::cumulated(&power_shares[..first_sky]),
            power_shares,
            lights,
            first_sky,
            uneven,
            has_surfaces: of_primitive.iter().any(Option::is_some),
            of_primitive,
            background,
            origin,
            labels: traceable.labels,
            source: source.clone(),
        }
    }

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// The kind of each light, skies last.
    pub fn kinds(&self) -> impl Iterator<Item = &'static str> {
        self.lights.iter().map(|light| match light {
            SceneLight::Point { .. } => "point",
            SceneLight::Spot { .. } => "spot",
            SceneLight::Distant { .. } => "distant",
            SceneLight::Infinite { .. } => "infinite",
            SceneLight::Environment(_) => "infinite with a picture",
            SceneLight::Goniometric(_) => "goniometric",
            SceneLight::Projection(_) => "projection",
            SceneLight::Surface(SurfaceLight { form: SurfaceForm::Mesh(_), .. }) => "mesh",
            SceneLight::Surface(SurfaceLight { form: SurfaceForm::Curved(_), .. }) => "quadric",
        })
    }

    /// How many samples of direct light there are of a light, where all are sampled.
    pub fn samples(&self, light: usize, strategy: DirectStrategy) -> u32 {
        match &self.lights[light] {
            _ if strategy == DirectStrategy::EachOnce => 1,
            SceneLight::Infinite { samples, .. } => *samples,
            SceneLight::Environment(environment) => environment.samples,
            SceneLight::Surface(surface) => surface.samples,
            _ => 1,
        }
    }

    /// Whether directions from the BSDF alone look for light, at a surface with that [`Lune`].
    pub fn leaves_all_to_directions(&self, lune: Option<&Lune>) -> bool {
        self.eligible(lune) == 0 && self.len() > 0
    }

    /// Whether light may come from where there is nothing.
    pub fn has_skies(&self) -> bool {
        self.first_sky < self.lights.len()
    }

    /// Whether any light is more than a point or a direction.
    pub fn has_extended(&self) -> bool {
        self.has_surfaces || self.has_skies()
    }

    /// Whether a light is only a point or a direction, which no ray finds by chance.
    pub fn is_delta(&self, light: usize) -> bool {
        self.lights[light].is_delta()
    }

    /// Radiance from a direction in which there is nothing.
    pub fn background(&self, d: DVec3) -> Vec3 {
        let shown = self.lights[self.first_sky..].iter().map(|light| match light {
            SceneLight::Environment(environment) => environment.radiance(d),
            _ => Vec3::ZERO,
        });
        self.background + shown.sum::<Vec3>()
    }

    /// The directions that samples of the BSDF miss, if there is a sky from which light may come there.
    #[inline]
    pub fn lune(&self, domain: &Domain) -> Option<Lune> {
        if self.has_skies() { Lune::new(domain) } else { None }
    }

    /// A direction towards a light, for a surface with that [`Lune`].
    pub fn sample(&self, light: usize, from: &Surface, lune: Option<&Lune>, u: DVec2) -> Option<LightSample> {
        match &self.lights[light] {
            SceneLight::Distant { direction, radiance } => {
                Some(LightSample { li: *radiance, pdf: None, shadow: from.leave(*direction) })
            }
            SceneLight::Infinite { radiance, .. } => {
                let lune = lune?;
                let (wi, pdf) = (lune.sample(u), lune.inside_pdf());
                Some(LightSample { li: *radiance, pdf: Some(pdf), shadow: from.leave(wi) })
            }
            SceneLight::Environment(environment) => {
                let EnvironmentSample { wi, radiance, pdf } = environment.sample(lune, u)?;
                Some(LightSample { li: radiance, pdf: Some(pdf), shadow: from.leave(wi) })
            }
            SceneLight::Surface(surface) => surface.sample(self.primitive(surface), self.origin, from, u),
            light @ (SceneLight::Point { .. }
            | SceneLight::Spot { .. }
            | SceneLight::Goniometric(_)
            | SceneLight::Projection(_)) => {
                let PointLight { position, squared_distance, intensity, .. } = light.seen_from(from.p)?;
                let li = intensity / squared_distance as f32;
                let shadow = Ray { target: ElementId::POINT_LIGHT, ..from.towards(position) };
                Some(LightSample { li, pdf: None, shadow })
            }
        }
    }

    /// The weight of a sample that was drawn with density `a`, where another way would have drawn it with density `b`
    /// (Veach; PBR 13.10.1). Densities are multiplied by the number of samples of each way.
    pub fn weight(&self, light: usize, a: f64, b: f64) -> f32 {
        let ratio = b / a;
        match light >= self.first_sky {
            // The balance heuristic: samples of skies leave to the BSDF what it finds.
            true => (1.0 / (1.0 + ratio)) as f32,
            // The power heuristic with exponent 2; as a ratio, so that no square overflows.
            false => (1.0 / (1.0 + ratio * ratio)) as f32,
        }
    }

    /// The sum of all skies, where each is of one color; `None` where any is a picture.
    pub fn even_sky(&self) -> Option<Vec3> {
        let color = |light: &SceneLight| match light {
            SceneLight::Infinite { radiance, .. } => Some(*radiance),
            _ => None,
        };
        self.lights[self.first_sky..].iter().map(color).sum()
    }

    /// The shape that is a light.
    fn primitive(&self, light: &SurfaceLight) -> &Primitive {
        &self.source.primitives[light.number as usize]
    }

    /// The first light that is a sky; they are the last.
    pub fn first_sky(&self) -> usize {
        self.first_sky
    }

    /// The light that an element belongs to.
    pub fn of_element(&self, element: ElementId) -> Option<usize> {
        let in_world = element.instance == ElementId::WORLD;
        self.of_primitive.get(element.primitive as usize).copied().flatten().filter(|_| in_world)
    }

    /// Density by solid angle with which [`LightTable::sample`] finds, from the point `from`, the point `hit` of a light, in
    /// direction `d`.
    pub fn surface_pdf(&self, light: usize, from: DVec3, d: DVec3, hit: &Surface) -> f64 {
        match &self.lights[light] {
            SceneLight::Surface(surface) => surface.pdf(from, d, hit).unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// The skies, with their radiance and the density with which direction `wi` is sampled.
    pub fn skies(&self, lune: Option<&Lune>, wi: DVec3) -> impl Iterator<Item = (usize, Vec3, f64)> {
        self.lights.iter().enumerate().skip(self.first_sky).filter_map(move |(number, light)| match light {
            SceneLight::Infinite { radiance, .. } => {
                Some((number, *radiance, lune.map_or(0.0, |lune| lune.pdf(wi))))
            }
            SceneLight::Environment(environment) => {
                let (radiance, pdf) = environment.evaluate(lune, wi);
                Some((number, radiance, pdf))
            }
            _ => None,
        })
    }
}

impl SceneLight {
    fn is_delta(&self) -> bool {
        !self.is_sky() && !matches!(self, SceneLight::Surface(_))
    }

    fn is_sky(&self) -> bool {
        matches!(self, SceneLight::Infinite { .. } | SceneLight::Environment(_))
    }

    /// A light that is a point, as it is seen from `p`. `None` where it shines elsewhere.
    fn seen_from(&self, p: DVec3) -> Option<PointLight> {
        let position = match self {
            SceneLight::Point { position, .. } | SceneLight::Spot { position, .. } => *position,
            SceneLight::Goniometric(light) => light.position,
            SceneLight::Projection(light) => light.position,
            _ => return None,
        };
        let to_light = position - p;
        let squared_distance = to_light.length_squared();
        let wi = to_light.try_normalize()?;
        let intensity = match self {
            SceneLight::Point { intensity, .. } => *intensity,
            SceneLight::Spot { light_from_world, intensity, cos_total_width, cos_falloff_start, .. } => {
                let axis = (*light_from_world * -wi).normalize_or_zero();
                *intensity * falloff(axis.z, *cos_total_width, *cos_falloff_start) as f32
            }
            SceneLight::Goniometric(light) => light.intensity * light.factor(-wi),
            SceneLight::Projection(light) => light.intensity * light.factor(-wi)?,
            _ => return None,
        };
        (intensity != Vec3::ZERO).then_some(PointLight { position, wi, squared_distance, intensity })
    }

    /// Whether it is a sky that is everywhere alike.
    fn is_even(&self) -> bool {
        match self {
            SceneLight::Infinite { .. } => true,
            SceneLight::Environment(environment) => environment.is_even(),
            _ => false,
        }
    }

    /// The share of its light that samples of it are for: of a sky, what samples of the BSDF do not find as well.
    fn sampled_share(&self, lune: Option<&Lune>) -> f64 {
        let above = match self {
            SceneLight::Infinite { .. } => 0.0,
            SceneLight::Environment(environment) => environment.share_above(),
            _ => return 1.0,
        };
        above + lune.map_or(0.0, Lune::share)
    }

    fn new(light: &Light, origin: DVec3) -> Self {
        match *light {
            Light::Point { position, intensity } => {
                SceneLight::Point { position: position - origin, intensity }
            }
            Light::Spot { ref world_from_light, intensity, cos_total_width, cos_falloff_start } => {
                let (position, light_from_world) = placed(world_from_light, origin);
                SceneLight::Spot { position, light_from_world, intensity, cos_total_width, cos_falloff_start }
            }
            Light::Distant { direction, radiance } => SceneLight::Distant { direction, radiance },
            Light::Infinite { radiance, samples } => SceneLight::Infinite { radiance, samples },
            Light::Environment { ref map, scale, ref world_from_light, samples } => {
                SceneLight::Environment(Box::new(Environment::new(map, scale, world_from_light, samples)))
            }
            Light::Goniometric { ref world_from_light, intensity, ref map } => {
                let (position, light_from_world) = placed(world_from_light, origin);
                let map = map.clone();
                SceneLight::Goniometric(Goniometric { position, light_from_world, intensity, map })
            }
            Light::Projection { ref world_from_light, intensity, ref map, half_size } => {
                let (position, light_from_world) = placed(world_from_light, origin);
                let map = map.clone();
                SceneLight::Projection(Projection { position, light_from_world, intensity, map, half_size })
            }
        }
    }
}

/// The place of a light in render space, and the transformation of directions to light space.
fn placed(world_from_light: &Transform, origin: DVec3) -> (DVec3, DMat3) {
    (world_from_light.point(DVec3::ZERO) - origin, DMat3::from_mat4(world_from_light.inverse_matrix()))
}

/// pbrt-v3's SpotLight::Falloff.
fn falloff(cos_theta: f64, cos_total_width: f64, cos_falloff_start: f64) -> f64 {
    if cos_theta < cos_total_width {
        return 0.0;
    }
    if cos_theta >= cos_falloff_start {
        return 1.0;
    }
    let within = (cos_theta - cos_total_width) / (cos_falloff_start - cos_total_width);
    let squared = within * within;
    squared * squared
}
