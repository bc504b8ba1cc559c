//! Lights: where to look for light from a point, and how likely each direction is looked at.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3, Vec3};
use lookat_scene::{LightChoice, Primitive, Scene, Shape};

use crate::prepare::corners;
use crate::ray::{ElementId, Ray};
use crate::sphere::PlacedSphere;
use crate::surface::{Surface, emitting_side, on_triangle};
use crate::warp::{
    Frame, square_to_cosine_hemisphere, square_to_cosine_hemisphere_pdf, square_to_triangle,
    square_to_uniform_cone, square_to_uniform_cone_pdf, square_to_uniform_hemisphere,
    square_to_uniform_hemisphere_pdf, square_to_uniform_sphere,
};

/// All lights of a scene.
pub(crate) struct LightTable {
    lights: Vec<SceneLight>,
    /// The share of the power of the lights up to each.
    power_cdf: Vec<f64>,
    /// The light that a primitive is, or none.
    of_primitive: Vec<Option<usize>>,
    /// The sum of what comes from directions in which there is nothing.
    background: Vec3,
    /// World position of the origin.
    eye: DVec3,
}

/// A light, relative to the eye.
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
    Sphere {
        primitive: u32,
        sphere: Box<PlacedSphere>,
        samples: u32,
    },
    Mesh {
        primitive: u32,
        area: f64,
        area_cdf: Vec<f64>,
        samples: u32,
    },
}

/// Light that may reach a point from one direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Radiance, or for lights that are only a point or direction what their irradiance is made of; nothing has been
    /// looked up about what is in the way.
    pub li: Vec3,
    /// Density by solid angle; `None` for lights that no other direction can hit.
    pub pdf: Option<f64>,
    /// The ray that must be free.
    pub shadow: Ray,
}

impl LightTable {
    pub fn new(scene: &Scene, eye: DVec3, spheres: &[Option<PlacedSphere>]) -> Self {
        let mut lights: Vec<SceneLight> =
            scene.lights.iter().map(|light| SceneLight::new(light, eye)).collect();
        let mut of_primitive = vec![None; spheres.len()];
        for (number, primitive) in scene.primitives.iter().enumerate() {
            let Some(light) = SceneLight::of_surface(number as u32, primitive, spheres[number]) else {
                continue;
            };
            of_primitive[number] = Some(lights.len());
            lights.push(light);
        }
        let size = scene_radius(scene, eye);
        let mut sum = 0.0;
        let power: Vec<f64> = lights.iter().map(|light| light.power(scene, size)).collect();
        let total: f64 = power.iter().sum();
        let count = lights.len() as f64;
        let power_cdf = power.iter().map(|power| {
            // Where no light has power, or one has all too much, all are alike.
            sum += if total > 0.0 && total.is_finite() { power / total } else { 1.0 / count };
            sum
        });
        let background = scene.lights.iter().fold(Vec3::ZERO, |sum, light| match light {
            lookat_scene::Light::Infinite { radiance, .. } => sum + *radiance,
            _ => sum,
        });
        LightTable { power_cdf: power_cdf.collect(), lights, of_primitive, background, eye }
    }

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// How many samples of direct light are asked for of a light.
    pub fn samples(&self, light: usize) -> u32 {
        match self.lights[light] {
            SceneLight::Infinite { samples, .. }
            | SceneLight::Sphere { samples, .. }
            | SceneLight::Mesh { samples, .. } => samples,
            _ => 1,
        }
    }

    /// Whether a light is only a point or a direction, which no ray finds by chance.
    pub fn is_delta(&self, light: usize) -> bool {
        use SceneLight::{Distant, Point, Spot};
        matches!(self.lights[light], Point { .. } | Spot { .. } | Distant { .. })
    }

    /// Radiance from a direction in which there is nothing.
    pub fn background(&self) -> Vec3 {
        self.background
    }

    /// A light by a number from 0 to 1, and its probability.
    pub fn choose(&self, choice: LightChoice, u: f64) -> Option<(usize, f64)> {
        let last = self.lights.len().checked_sub(1)?;
        let light = match choice {
            LightChoice::Uniform => ((u * self.lights.len() as f64) as usize).min(last),
            LightChoice::Power => self.power_cdf.partition_point(|share| *share <= u).min(last),
        };
        let probability = self.probability(choice, light);
        (probability > 0.0).then_some((light, probability))
    }

    /// The probability with which [`LightTable::choose`] gives a light.
    pub fn probability(&self, choice: LightChoice, light: usize) -> f64 {
        match choice {
            LightChoice::Uniform => 1.0 / self.lights.len() as f64,
            LightChoice::Power if light == 0 => self.power_cdf[0],
            LightChoice::Power => self.power_cdf[light] - self.power_cdf[light - 1],
        }
    }

    /// A direction towards a light, seen from `from` on the side of `wo`.
    pub fn sample(
        &self,
        light: usize,
        from: &Surface,
        wo: DVec3,
        primitives: &[&Primitive],
        u: DVec2,
    ) -> Option<LightSample> {
        let p = from.p;
        match &self.lights[light] {
            SceneLight::Point { position, intensity } => {
                let (li, shadow) = towards(from, *position, *intensity)?;
                Some(LightSample { li, pdf: None, shadow })
            }
            SceneLight::Spot {
                position,
                light_from_world,
                intensity,
                cos_total_width,
                cos_falloff_start,
            } => {
                let (li, shadow) = towards(from, *position, *intensity)?;
                let axis = (*light_from_world * -shadow.d).normalize_or_zero();
                let falloff = falloff(axis.z, *cos_total_width, *cos_falloff_start);
                (falloff > 0.0).then_some(LightSample { li: li * falloff as f32, pdf: None, shadow })
            }
            SceneLight::Distant { direction, radiance } => {
                Some(LightSample { li: *radiance, pdf: None, shadow: from.leave(*direction) })
            }
            SceneLight::Infinite { radiance, .. } => {
                let (wi, pdf) = sample_sky(from, wo, u);
                (pdf > 0.0).then_some(LightSample { li: *radiance, pdf: Some(pdf), shadow: from.leave(wi) })
            }
            SceneLight::Sphere { primitive, sphere, .. } => {
                let owner = primitives[*primitive as usize];
                let (point, outward) = sample_sphere(sphere, p, u)?;
                let element = ElementId { instance: ElementId::WORLD, primitive: *primitive, index: 0 };
                let emitting = emitting_side(owner, outward);
                let on_light =
                    Surface { p: point, n: outward, ns: outward, emitting, element, primitive: owner };
                let pdf = sphere_pdf(sphere, p, &on_light)?;
                towards_surface(from, &on_light, pdf)
            }
            SceneLight::Mesh { primitive, area, area_cdf, .. } => {
                let owner = primitives[*primitive as usize];
                let Shape::TriangleMesh(mesh) = &owner.shape else { return None };
                let index = area_cdf.partition_point(|share| *share <= u.x).min(area_cdf.len() - 1);
                let before = if index == 0 { 0.0 } else { area_cdf[index - 1] };
                // What is left of the number after the choice is uniform again.
                let rest = ((u.x - before) / (area_cdf[index] - before)).clamp(0.0, 1.0);
                let [b0, b1] = square_to_triangle(DVec2::new(rest, u.y));
                let element =
                    ElementId { instance: ElementId::WORLD, primitive: *primitive, index: index as u32 };
                let on_light = on_triangle(owner, mesh, element, [b0, b1, 1.0 - b0 - b1], self.eye);
                towards_surface(from, &on_light, by_solid_angle(p, &on_light, *area)?)
            }
        }
    }

    /// The light that a surface belongs to.
    pub fn of_surface(&self, surface: &Surface) -> Option<usize> {
        let in_world = surface.element.instance == ElementId::WORLD;
        self.of_primitive.get(surface.element.primitive as usize).copied().flatten().filter(|_| in_world)
    }

    /// Density by solid angle with which [`LightTable::sample`] finds, from `from`, the point `hit` of a light.
    pub fn surface_pdf(&self, light: usize, from: &Surface, hit: &Surface) -> f64 {
        match &self.lights[light] {
            SceneLight::Sphere { sphere, .. } => sphere_pdf(sphere, from.p, hit),
            SceneLight::Mesh { area, .. } => by_solid_angle(from.p, hit, *area),
            _ => None,
        }
        .unwrap_or(0.0)
    }

    /// The lights at infinity, with their radiance and the density with which direction `wi` is sampled.
    pub fn infinite(&self, from: &Surface, wo: DVec3, wi: DVec3) -> impl Iterator<Item = (usize, Vec3, f64)> {
        let pdf = sky_pdf(from, wo, wi);
        self.lights.iter().enumerate().filter_map(move |(number, light)| match light {
            SceneLight::Infinite { radiance, .. } => Some((number, *radiance, pdf)),
            _ => None,
        })
    }
}

impl SceneLight {
    fn new(light: &lookat_scene::Light, eye: DVec3) -> Self {
        match *light {
            lookat_scene::Light::Point { position, intensity } => {
                SceneLight::Point { position: position - eye, intensity }
            }
            lookat_scene::Light::Spot {
                position,
                light_from_world,
                intensity,
                cos_total_width,
                cos_falloff_start,
            } => {
                let position = position - eye;
                SceneLight::Spot { position, light_from_world, intensity, cos_total_width, cos_falloff_start }
            }
            lookat_scene::Light::Distant { direction, radiance } => {
                SceneLight::Distant { direction, radiance }
            }
            lookat_scene::Light::Infinite { radiance, samples } => SceneLight::Infinite { radiance, samples },
        }
    }

    /// The light that a shape of the world is.
    fn of_surface(number: u32, primitive: &Primitive, sphere: Option<PlacedSphere>) -> Option<Self> {
        let emission = primitive.emission?;
        let samples = emission.samples;
        match &primitive.shape {
            Shape::Sphere(_) => {
                Some(SceneLight::Sphere { primitive: number, sphere: Box::new(sphere?), samples })
            }
            Shape::TriangleMesh(mesh) => {
                let mut area = 0.0;
                let mut area_cdf: Vec<f64> = (0..mesh.triangles())
                    .map(|index| {
                        let [a, b, c] = corners(mesh, index, DVec3::ZERO);
                        area += 0.5 * (b - a).cross(c - a).length();
                        area
                    })
                    .collect();
                area_cdf.iter_mut().for_each(|share| *share /= area);
                (area > 0.0).then_some(SceneLight::Mesh { primitive: number, area, area_cdf, samples })
            }
        }
    }

    /// About the power that a light brings into a scene of the given radius; it only guides the choice of lights.
    fn power(&self, scene: &Scene, radius: f64) -> f64 {
        let of_emitter = |primitive: &u32, area: f64| {
            let emission = scene.primitives[*primitive as usize].emission;
            emission.map_or(0.0, |e| luminance(e.radiance) * area * PI * if e.two_sided { 2.0 } else { 1.0 })
        };
        match self {
            SceneLight::Point { intensity, .. } => 4.0 * PI * luminance(*intensity),
            SceneLight::Spot { intensity, cos_total_width, cos_falloff_start, .. } => {
                2.0 * PI * (1.0 - 0.5 * (cos_total_width + cos_falloff_start)) * luminance(*intensity)
            }
            SceneLight::Distant { radiance, .. } => PI * radius * radius * luminance(*radiance),
            SceneLight::Infinite { radiance, .. } => 4.0 * PI * PI * radius * radius * luminance(*radiance),
            SceneLight::Sphere { primitive, sphere, .. } => of_emitter(primitive, sphere_area(sphere)),
            SceneLight::Mesh { primitive, area, .. } => of_emitter(primitive, *area),
        }
    }
}

/// The luminance of linear RGB (ITU-R BT.709).
pub(crate) fn luminance(rgb: Vec3) -> f64 {
    rgb.as_dvec3().dot(DVec3::new(0.212671, 0.715160, 0.072169))
}

/// A direction to a sky that is everywhere alike, on the side of `wo`, and its density by solid angle.
///
/// In proportion to the cosine; but where the shading normal is not the geometric one, light also comes from directions
/// below the horizon of the shading normal, so there all directions above the surface are alike.
fn sample_sky(from: &Surface, wo: DVec3, u: DVec2) -> (DVec3, f64) {
    let frame = Frame::from_z(side_of(from, wo));
    let local =
        if from.n == from.ns { square_to_cosine_hemisphere(u) } else { square_to_uniform_hemisphere(u) };
    let wi = frame.to_world(local);
    (wi, sky_pdf(from, wo, wi))
}

/// Density of [`sample_sky`].
fn sky_pdf(from: &Surface, wo: DVec3, wi: DVec3) -> f64 {
    let cos_theta = side_of(from, wo).dot(wi);
    if from.n == from.ns {
        square_to_cosine_hemisphere_pdf(cos_theta)
    } else if cos_theta > 0.0 {
        square_to_uniform_hemisphere_pdf()
    } else {
        0.0
    }
}

/// The geometric normal on the side of `wo`.
fn side_of(surface: &Surface, wo: DVec3) -> DVec3 {
    if surface.n.dot(wo) < 0.0 { -surface.n } else { surface.n }
}

/// What a light at a point gives, and the ray to it.
fn towards(from: &Surface, position: DVec3, intensity: Vec3) -> Option<(Vec3, Ray)> {
    let to_light = position - from.p;
    let distance = to_light.length();
    let ray = from.leave(to_light.try_normalize()?);
    Some((intensity / (distance * distance) as f32, Ray { t_max: distance, ..ray }))
}

/// The sample of a point of a light with a surface. The ray ends at the light, which does not block it.
fn towards_surface(from: &Surface, on_light: &Surface, pdf: f64) -> Option<LightSample> {
    let to_light = on_light.p - from.p;
    let wi = to_light.try_normalize()?;
    let li = on_light.le(-wi);
    let shadow = Ray { t_max: to_light.length(), target: on_light.element, ..from.leave(wi) };
    (li != Vec3::ZERO && pdf > 0.0).then_some(LightSample { li, pdf: Some(pdf), shadow })
}

/// The density of a point chosen evenly on an area, by solid angle from `p`.
fn by_solid_angle(p: DVec3, on_light: &Surface, area: f64) -> Option<f64> {
    let to_light = on_light.p - p;
    let cos = on_light.n.dot(to_light.normalize_or_zero()).abs();
    let pdf = to_light.length_squared() / (cos * area);
    pdf.is_finite().then_some(pdf)
}

/// pbrt-v3's SpotLight::Falloff.
fn falloff(cos_theta: f64, cos_total_width: f64, cos_falloff_start: f64) -> f64 {
    if cos_theta < cos_total_width {
        return 0.0;
    }
    if cos_theta >= cos_falloff_start {
        return 1.0;
    }
    ((cos_theta - cos_total_width) / (cos_falloff_start - cos_total_width)).powi(4)
}

/// A point of a sphere light and the outward normal there. From outside, of those that can be seen.
fn sample_sphere(sphere: &PlacedSphere, p: DVec3, u: DVec2) -> Option<(DVec3, DVec3)> {
    let on_unit = match visible_cone(sphere, p) {
        Some((axis, distance, radius, one_minus_cos_max)) => {
            let local = square_to_uniform_cone(u, one_minus_cos_max);
            let wi = Frame::from_z(axis).to_world(local);
            // Where the ray first meets the sphere, by the law of sines.
            let sin_squared = (1.0 - local.z) * (1.0 + local.z);
            let closest = distance * local.z;
            let half = (radius * radius - distance * distance * sin_squared).max(0.0).sqrt();
            sphere.object_from_world * (p + wi * (closest - half) - sphere.center)
        }
        None => square_to_uniform_sphere(u),
    };
    let on_unit = on_unit.normalize_or(DVec3::Z);
    sphere.has(on_unit * sphere.shape.radius).then(|| sphere.point(on_unit))
}

/// Where a sphere that is one in the world is seen from outside: axis, distance of the centre, radius, and one minus the
/// cosine of half the angle that it covers.
fn visible_cone(sphere: &PlacedSphere, p: DVec3) -> Option<(DVec3, f64, f64, f64)> {
    let radius = sphere.world_radius?;
    let to_center = sphere.center - p;
    let distance = to_center.length();
    if distance <= radius * (1.0 + 1e-9) {
        return None;
    }
    let sin_squared = (radius / distance).powi(2);
    // 1 - cos without cancellation.
    let one_minus_cos_max = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
    Some((to_center / distance, distance, radius, one_minus_cos_max))
}

/// Density of [`sample_sphere`] by solid angle from `p`.
fn sphere_pdf(sphere: &PlacedSphere, p: DVec3, on_light: &Surface) -> Option<f64> {
    if let Some((_, _, _, one_minus_cos_max)) = visible_cone(sphere, p) {
        return Some(square_to_uniform_cone_pdf(one_minus_cos_max));
    }
    // Evenly on the unit sphere, carried over to the world.
    let on_unit = (sphere.object_from_world * (on_light.p - sphere.center)).normalize_or(DVec3::Z);
    by_solid_angle(p, on_light, 4.0 * PI * area_factor(sphere, on_unit))
}

/// How much larger a small area at `on_unit` is on the sphere in the world than on the unit sphere: the cofactors of the
/// transformation applied to the normal.
fn area_factor(sphere: &PlacedSphere, on_unit: DVec3) -> f64 {
    let scaled = sphere.world_from_object * sphere.shape.radius;
    scaled.determinant().abs() * (sphere.object_from_world.transpose() * on_unit).length()
        / sphere.shape.radius
}

fn sphere_area(sphere: &PlacedSphere) -> f64 {
    let shape = &sphere.shape;
    let share = (shape.z_max - shape.z_min) / (2.0 * shape.radius) * shape.phi_max / (2.0 * PI);
    4.0 * PI * area_factor(sphere, DVec3::Z) * share
}

/// Half the diagonal of the box around the primitives of the world.
fn scene_radius(scene: &Scene, eye: DVec3) -> f64 {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for primitive in &scene.primitives {
        match &primitive.shape {
            Shape::Sphere(form) => {
                let sphere = PlacedSphere::new(**form, eye);
                min = min.min(sphere.center - sphere.half_extent());
                max = max.max(sphere.center + sphere.half_extent());
            }
            Shape::TriangleMesh(mesh) => {
                for p in &mesh.positions {
                    min = min.min(DVec3::from(*p) - eye);
                    max = max.max(DVec3::from(*p) - eye);
                }
            }
        }
    }
    for instance in &scene.instances {
        let origin = instance.world_from_object.point(DVec3::ZERO) - eye;
        min = min.min(origin);
        max = max.max(origin);
    }
    if min.x > max.x { 1.0 } else { (max - min).length() * 0.5 }
}
