//! The lights of a scene: samples of them from points, and the densities of these samples.

mod area;
mod choice;
mod environment;
mod lune;
mod parts;
mod point;
mod tree;

use std::array::from_fn;
use std::sync::OnceLock;

use fearless_simd::{Select, Simd, SimdBase, f32x8, f64x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::{DMat3, DVec3, Vec3};
use lookat_scene::{DirectStrategy, Light, Transform, World};

use crate::bsdf::Domain;
use crate::light::tree::Leaves;
use crate::number::{LANES, Vec3fx8, Vec3x8, bits, narrow, splat_f32, widen};
use crate::ray::ElementId;
use crate::surface::Surfaces;
use crate::trace::rays::Rays;
use crate::traceable::Traceable;
pub(crate) use area::LightHits;
use area::{SurfaceForm, SurfaceLight};
pub(crate) use choice::{Chosen, Estimates, LightSampler};
use environment::{Environment, EnvironmentSample};
pub(crate) use lune::Lunes;
use point::{PointLight, Spread};

/// All lights of a scene.
pub(crate) struct LightTable {
    /// The lights. Skies come last, and constant skies last of all.
    lights: Vec<SceneLight>,
    /// The index of the first sky.
    pub first_sky: usize,
    /// The number of lights that are not constant skies. Surfaces without a lune sample only these: see [`Lunes`].
    uneven: usize,
    /// The approximate share of each light in the total power.
    power_shares: Vec<f64>,
    /// The sums of these shares up to each light that is no sky.
    power_cdf: Vec<f64>,
    /// The light that a primitive is, or none.
    of_primitive: Vec<Option<usize>>,
    has_surfaces: bool,
    /// The radiance of all constant skies.
    background: Vec3,
    /// The lights without a position, such as skies, which are in no tree.
    beside: Vec<usize>,
    /// True if the strategy "spatial" uses a light tree.
    needs_tree: bool,
    /// The light tree, built on first use.
    leaves: OnceLock<Leaves>,
    /// The lights with too many triangles to sample each.
    finely_split: Vec<usize>,
    /// The tree of their triangles, built on first use.
    triangles: OnceLock<Leaves>,
}

/// A light, relative to the origin.
enum SceneLight {
    Point(PointLight),
    Distant { direction: DVec3, radiance: Vec3 },
    Infinite { radiance: Vec3, samples: u32 },
    Environment(Box<Environment>),
    Surface(Box<SurfaceLight>),
}

impl LightTable {
    /// The lights of a world, in the coordinates of its traceable form.
    pub fn new(source: &World, traceable: &Traceable) -> Self {
        let origin = traceable.origin;
        let all = source.lights.iter().map(|light| SceneLight::new(light, origin));
        let (mut skies, mut lights): (Vec<SceneLight>, Vec<SceneLight>) = all.partition(SceneLight::is_sky);
        let mut of_primitive = Vec::new();
        for (number, primitive) in source.primitives.iter().enumerate() {
            if let Some(light) = SurfaceLight::new(number as u32, primitive, traceable) {
                of_primitive.resize(number, None);
                of_primitive.push(Some(lights.len()));
                lights.push(SceneLight::Surface(Box::new(light)));
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
            beside: choice::beside(&lights),
            needs_tree: choice::needs_tree(&lights),
            finely_split: parts::finely_split(&lights),
            lights,
            first_sky,
            uneven,
            has_surfaces: of_primitive.iter().any(Option::is_some),
            of_primitive,
            background,
            leaves: OnceLock::new(),
            triangles: OnceLock::new(),
        }
    }

    /// The number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// The kind of each light, skies last.
    pub fn kinds(&self) -> impl Iterator<Item = &'static str> {
        self.lights.iter().map(|light| match light {
            SceneLight::Point(light) => light.kind(),
            SceneLight::Distant { .. } => "distant",
            SceneLight::Infinite { .. } => "infinite",
            SceneLight::Environment(_) => "infinite with a picture",
            SceneLight::Surface(light) => match light.form {
                SurfaceForm::Mesh(_) => "mesh",
                SurfaceForm::Curved(_) => "quadric",
            },
        })
    }

    /// The primitives of the world that are lights, in the order of the lights.
    pub fn primitives(&self) -> impl Iterator<Item = usize> {
        self.of_primitive.iter().enumerate().filter_map(|(number, light)| light.map(|_| number))
    }

    /// The number of samples of a light if all lights are sampled.
    pub fn samples(&self, light: usize, strategy: DirectStrategy) -> u32 {
        match &self.lights[light] {
            _ if strategy == DirectStrategy::EachOnce => 1,
            SceneLight::Infinite { samples, .. } => *samples,
            SceneLight::Environment(environment) => environment.samples,
            SceneLight::Surface(surface) => surface.samples,
            _ => 1,
        }
    }

    /// True if only BSDF directions look for light. `has_lune`: at a surface with a lune.
    pub fn leaves_all_to_directions(&self, has_lune: bool) -> bool {
        self.eligible(has_lune) == 0 && self.len() > 0
    }

    /// True if rays that hit nothing may find light.
    pub fn has_skies(&self) -> bool {
        self.first_sky < self.lights.len()
    }

    /// True if any light is not a delta light.
    pub fn has_extended(&self) -> bool {
        self.has_surfaces || self.has_skies()
    }

    /// The radius of a light that is a shape; 0 for other lights.
    pub fn radius(&self, light: usize) -> f64 {
        match &self.lights[light] {
            SceneLight::Surface(surface) => surface.radius,
            _ => 0.0,
        }
    }

    /// True for delta lights: a point or a direction, which no ray finds by chance.
    pub fn is_delta(&self, light: usize) -> bool {
        self.lights[light].is_delta()
    }

    /// The radiance of all skies along directions.
    #[inline(always)]
    pub fn background<S: Simd>(&self, simd: S, d: Vec3x8<S>) -> Vec3fx8<S> {
        let mut sum = Vec3fx8::splat(simd, self.background);
        for light in &self.lights[self.first_sky..] {
            if let SceneLight::Environment(environment) = light {
                sum = sum + environment.radiance(simd, d);
            }
        }
        sum
    }

    /// Samples directions towards a light. `leaving`: the lanes whose surface is the light itself. `triangles`: the chosen
    /// triangles of a light whose triangles are chosen one by one.
    #[inline(always)]
    pub fn sample<S: Simd>(
        &self,
        simd: S,
        light: usize,
        (at, leaving): (&Receivers<S>, mask64x8<S>),
        (triangles, u): (Option<u32x8<S>>, [f64x8<S>; 2]),
    ) -> LightSample<S> {
        let all = bits(simd, 0xff);
        match &self.lights[light] {
            SceneLight::Point(light) => light.sample(simd, at),
            SceneLight::Distant { direction, radiance } => {
                let shadow = at.surfaces.spawn_ray(Vec3x8::splat(simd, *direction));
                LightSample::of_delta(all, Vec3fx8::splat(simd, *radiance), shadow)
            }
            SceneLight::Infinite { radiance, .. } => {
                let (is_valid, wi, pdf) = match &at.lunes {
                    Some(lunes) => (lunes.is_valid, lunes.sample(u), lunes.inside_pdf()),
                    None => (!all, at.surfaces.p, splat_f32(simd, 1.0)),
                };
                LightSample::with_pdf(
                    is_valid,
                    Vec3fx8::splat(simd, *radiance),
                    pdf,
                    at.surfaces.spawn_ray(wi),
                )
            }
            SceneLight::Environment(environment) => {
                let EnvironmentSample { wi, radiance, pdf } = environment.sample(simd, at.lunes.as_ref(), u);
                LightSample::with_pdf(all, radiance, pdf, at.surfaces.spawn_ray(wi))
            }
            SceneLight::Surface(surface) => surface.sample(simd, (at, leaving), (triangles, u)),
        }
    }

    /// True if [`LightTable::sample_alike`] samples these two together.
    pub fn are_alike(&self, a: usize, b: usize) -> bool {
        match (&self.lights[a], &self.lights[b]) {
            (SceneLight::Point(a), SceneLight::Point(b)) => a.is_even() && b.is_even(),
            (SceneLight::Surface(a), SceneLight::Surface(b)) => a.sphere().is_some() && b.sphere().is_some(),
            _ => false,
        }
    }

    /// Samples a different light for each point. Only the points in `alike` count; all pairs of their lights must satisfy
    /// [`LightTable::are_alike`].
    #[inline(always)]
    pub fn sample_alike<S: Simd>(
        &self,
        simd: S,
        (lights, alike): (u32x8<S>, mask64x8<S>),
        (at, leaving): (&Receivers<S>, mask64x8<S>),
        u: [f64x8<S>; 2],
    ) -> LightSample<S> {
        let mask = alike.to_bitmask();
        let first = mask.trailing_zeros() as usize;
        let number = |lane: usize| lights[if mask >> lane & 1 == 1 { lane } else { first }] as usize;
        let number = from_fn::<usize, LANES, _>(number);
        match &self.lights[number[0]] {
            SceneLight::Point(one) => {
                let light =
                    |number| if let SceneLight::Point(own) = &self.lights[number] { own } else { one };
                PointLight::sample_even(simd, number.map(light), at)
            }
            SceneLight::Surface(one) => {
                let light =
                    |number| if let SceneLight::Surface(own) = &self.lights[number] { own } else { one };
                SurfaceLight::sample_spheres(
                    simd,
                    (number.map(|number| &**light(number)), alike),
                    (at, leaving),
                    u,
                )
            }
            _ => self.sample(simd, number[0], (at, leaving), (None, u)),
        }
    }

    /// The element of a light that is a curved shape.
    pub fn curved_element(&self, light: usize) -> ElementId {
        match &self.lights[light] {
            SceneLight::Surface(light) if matches!(light.form, SurfaceForm::Curved(_)) => light.element(),
            _ => ElementId::NONE,
        }
    }

    /// The light that an element belongs to.
    pub fn of_element(&self, element: ElementId) -> Option<usize> {
        let in_world = element.instance == ElementId::WORLD;
        self.of_primitive.get(element.primitive as usize).copied().flatten().filter(|_| in_world)
    }

    /// The densities by solid angle with which [`LightTable::sample`] samples the points of a light that rays have hit.
    #[inline(always)]
    pub fn surface_pdf<S: Simd>(
        &self,
        simd: S,
        light: usize,
        at: &Surfaces<S>,
        found: &LightHits<S>,
    ) -> f32x8<S> {
        match &self.lights[light] {
            SceneLight::Surface(surface) => surface.pdf(simd, at, found),
            _ => splat_f32(simd, 0.0),
        }
    }

    /// The radiance of a sky from directions of length one, and the densities with which they are sampled.
    #[inline(always)]
    pub fn sky<S: Simd>(
        &self,
        simd: S,
        light: usize,
        lunes: Option<&Lunes<S>>,
        wi: Vec3x8<S>,
    ) -> (Vec3fx8<S>, f32x8<S>) {
        match &self.lights[light] {
            SceneLight::Environment(environment) => environment.evaluate(simd, lunes, wi),
            SceneLight::Infinite { radiance, .. } => {
                let pdf = match lunes {
                    Some(lunes) => lunes.pdf(wi),
                    None => splat_f32(simd, 0.0),
                };
                (Vec3fx8::splat(simd, *radiance), pdf)
            }
            _ => (Vec3fx8::splat(simd, Vec3::ZERO), splat_f32(simd, 0.0)),
        }
    }
}

/// The weights of samples that were drawn with density `a`, where another way would have drawn them with density `b` (Veach; PBR 13.10.1).
/// Densities are multiplied by the number of samples of each way.
#[inline(always)]
pub(crate) fn weights<S: Simd>(is_sky: mask32x8<S>, a: f32x8<S>, b: f32x8<S>) -> f32x8<S> {
    let ratio = b / a;
    // The balance heuristic: samples of skies leave to the BSDF what it finds. Of others the power heuristic with exponent 2; as a ratio,
    // so that no square overflows.
    1.0 / (1.0 + is_sky.select(ratio, ratio * ratio))
}

impl SceneLight {
    fn is_delta(&self) -> bool {
        !self.is_sky() && !matches!(self, SceneLight::Surface(_))
    }

    fn is_sky(&self) -> bool {
        matches!(self, SceneLight::Infinite { .. } | SceneLight::Environment(_))
    }

    /// True for a constant sky.
    fn is_even(&self) -> bool {
        match self {
            SceneLight::Infinite { .. } => true,
            SceneLight::Environment(environment) => environment.is_even(),
            _ => false,
        }
    }

    /// The share of its light that light samples are for. For a sky: the light that BSDF samples do not find as well.
    #[inline(always)]
    fn sampled_share<S: Simd>(&self, simd: S, lunes: Option<&Lunes<S>>) -> f64x8<S> {
        let above = match self {
            SceneLight::Infinite { .. } => 0.0,
            SceneLight::Environment(environment) => environment.share_above(),
            _ => return 1.0.simd_into(simd),
        };
        match lunes {
            Some(lunes) => lunes.share() + above,
            None => above.simd_into(simd),
        }
    }

    fn new(light: &Light, origin: DVec3) -> Self {
        let point = |(position, light_from_world), intensity, spread| {
            SceneLight::Point(PointLight { position, light_from_world, intensity, spread })
        };
        match *light {
            Light::Point { position, intensity } => {
                point((position - origin, DMat3::IDENTITY), intensity, Spread::Even)
            }
            Light::Spot { ref world_from_light, intensity, cos_total_width, cos_falloff_start } => {
                let spread = Spread::Cone { total_width: cos_total_width, falloff_start: cos_falloff_start };
                point(placed(world_from_light, origin), intensity, spread)
            }
            Light::Distant { direction, radiance } => SceneLight::Distant { direction, radiance },
            Light::Infinite { radiance, samples } => SceneLight::Infinite { radiance, samples },
            Light::Environment { ref map, scale, ref world_from_light, samples } => {
                SceneLight::Environment(Box::new(Environment::new(map, scale, world_from_light, samples)))
            }
            Light::Goniometric { ref world_from_light, intensity, ref map } => {
                point(placed(world_from_light, origin), intensity, Spread::Goniometric(map.clone()))
            }
            Light::Projection { ref world_from_light, intensity, ref map, half_size } => {
                let spread = Spread::Projection { map: map.clone(), half_size };
                point(placed(world_from_light, origin), intensity, spread)
            }
        }
    }
}

/// The position of a light in render space, and the transformation of directions to light space.
fn placed(world_from_light: &Transform, origin: DVec3) -> (DVec3, DMat3) {
    (world_from_light.point(DVec3::ZERO) - origin, DMat3::from_mat4(world_from_light.inverse_matrix()))
}

/// Samples of lights.
pub(crate) struct LightSample<S: Simd> {
    /// The lanes with a valid sample.
    pub is_valid: mask64x8<S>,
    /// The radiance, without occlusion. For delta lights: the irradiance on a surface that faces them.
    pub li: Vec3fx8<S>,
    /// Densities by solid angle; 1 for lights that no other direction can hit.
    pub pdf: f32x8<S>,
    /// The lanes with lights that BSDF directions can hit.
    pub has_pdf: mask64x8<S>,
    /// The shadow rays.
    pub shadow: Rays<S>,
}

impl<S: Simd> LightSample<S> {
    /// A sample of a delta light.
    #[inline(always)]
    pub fn of_delta(is_valid: mask64x8<S>, li: Vec3fx8<S>, shadow: Rays<S>) -> Self {
        let simd = shadow.t_max.token();
        LightSample { is_valid, li, pdf: splat_f32(simd, 1.0), has_pdf: bits(simd, 0), shadow }
    }

    /// A sample of a light that BSDF directions can hit.
    #[inline(always)]
    pub fn with_pdf(is_valid: mask64x8<S>, li: Vec3fx8<S>, pdf: f32x8<S>, shadow: Rays<S>) -> Self {
        let is_valid = is_valid & widen(pdf.simd_gt(0.0) & pdf.is_finite());
        LightSample { is_valid, li, pdf, has_pdf: bits(pdf.token(), 0xff), shadow }
    }

    /// Keeps the lanes in `mask` and takes the other lanes from `others`.
    #[inline(always)]
    pub fn keep_where(self, mask: mask64x8<S>, others: Self) -> Self {
        LightSample {
            is_valid: mask & self.is_valid | !mask & others.is_valid,
            li: self.li.keep_where_wide(mask, others.li),
            pdf: narrow(mask).select(self.pdf, others.pdf),
            has_pdf: mask & self.has_pdf | !mask & others.has_pdf,
            shadow: self.shadow.keep_where(mask, others.shadow),
        }
    }
}

/// Surfaces that receive light, and the directions from which they scatter it.
#[derive(Clone, Copy)]
pub(crate) struct Receivers<S: Simd> {
    pub surfaces: Surfaces<S>,
    pub domain: Domain<S>,
    /// The directions in which BSDF samples miss light of skies. `None` if there are no such directions.
    pub lunes: Option<Lunes<S>>,
}

/// Estimates are no better than this: a smaller cosine counts for as much.
const LEAST_COSINE: f32 = 0.1;

impl<S: Simd> Receivers<S> {
    /// `numbers[0]` in lanes without a lune, `numbers[1]` in lanes with one.
    #[inline(always)]
    pub fn by_lune<N>(&self, simd: S, numbers: [N::Element; 2]) -> N
    where
        N: SimdBase<S>,
        mask32x8<S>: Select<N>,
    {
        let [without, with] = numbers.map(|number| N::splat(simd, number));
        match &self.lunes {
            Some(lunes) => narrow(lunes.is_valid).select(with, without),
            None => without,
        }
    }

    /// About the cosine at which light arrives from a ball in direction `wi`, whose radius is `spread` times its distance.
    /// 0 where all of it arrives from a side that nothing is scattered from. 1 from elsewhere, where that depends on more than
    /// the cosine: highlights are brightest in grazing light.
    #[inline(always)]
    pub fn cosine(&self, wi: Vec3fx8<S>, spread: f32x8<S>) -> f32x8<S> {
        let Domain { n, ns, is_two_sided, is_diffuse } = self.domain;
        let (none, one) = (splat_f32(spread.token(), 0.0), splat_f32(spread.token(), 1.0));
        let is_behind = !is_two_sided & wi.dot(n).simd_le(-spread);
        // Of the part that is highest above the surface.
        let cosine = (wi.dot(ns) + spread).max(LEAST_COSINE).min(1.0);
        is_behind.select(none, is_diffuse.select(cosine, one))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::baseline;
    use crate::testing::surfaces_at;
    use glam::DVec3;

    #[test]
    fn light_from_behind_counts_where_it_comes_through() {
        let ns = Vec3::new(0.6, 0.0, 0.8);
        let cosine = |[is_two_sided, is_diffuse]: [bool; 2], wi: Vec3, spread: f32| {
            baseline!(simd => {
                let mask = |all: bool| mask32x8::splat(simd, all);
                let domain = Domain {
                    n: Vec3fx8::splat(simd, Vec3::Z),
                    ns: Vec3fx8::splat(simd, ns),
                    is_two_sided: mask(is_two_sided),
                    is_diffuse: mask(is_diffuse),
                };
                let receivers = Receivers { surfaces: surfaces_at(simd, DVec3::ZERO), domain, lunes: None };
                receivers.cosine(Vec3fx8::splat(simd, wi), splat_f32(simd, spread))[0]
            })
        };
        let (diffuse, through, glossy) = ([false, true], [true, false], [false, false]);
        let (above, below, grazing) = (Vec3::Z, -Vec3::Z, Vec3::new(-0.8, 0.0, 0.6));
        assert_eq!([above, below].map(|wi| cosine(diffuse, wi, 0.0)), [0.8, 0.0]);
        assert_eq!([above, below].map(|wi| cosine(through, wi, 0.0)), [1.0, 1.0]);
        assert_eq!([diffuse, glossy].map(|of| cosine(of, grazing, 0.0)), [LEAST_COSINE, 1.0]);
        // What reaches above the surface.
        assert_eq!([0.9, 1.1].map(|spread| cosine(diffuse, below, spread) > 0.0), [false, true]);
    }
}
