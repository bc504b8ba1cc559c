//! The irradiance that surfaces receive from each light, and whether they receive any.

use std::f64::consts::PI;

use fearless_simd::{Simd, f64x8, mask32x8, mask64x8, prelude::*, u32x8};
use glam::{DVec2, DVec3};
use lookat_scene::Light;

use crate::bsdf::Domain;
use crate::columns::Stored;
use crate::integrator::Tracer;
use crate::integrator::world::World;
use crate::light::Receivers;
use crate::number::{
    LANES, Vec3fx8, Vec3x8, baseline, bits, first_lanes, luminance, set_lanes, to_f64, widen,
};
use crate::prepare::Prepared;
use crate::ray::ElementId;
use crate::surface::{Surface, Surfaces};
use crate::trace::rays::{RayColumns, Rays};
use crate::warp::square_to_disk;

/// About so many shadow rays are traced, and at least so many for each light.
const SHADOW_RAYS: usize = 1 << 16;
const LEAST_OF_A_LIGHT: usize = 64;
/// The most lights that are measured.
const MOST_LIGHTS: usize = 256;
/// The cosine at a surface up to which light counts as none: corners with a few digits tilt triangles of one plane by about so much, over
/// at least a quarter of the radius of a light.
const GRAZING: f64 = 1e-4;

/// What surfaces receive from a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Irradiance {
    /// The light.
    pub light: LightPlace,
    /// The mean irradiance, as luminance, that comes straight from the light to the surfaces.
    pub mean: f64,
    /// True if the light reaches one of the surfaces, or a surface that one of these sees.
    pub reaches: bool,
    /// True if the light would reach one of these if nothing blocked it.
    pub faces: bool,
}

/// The location of a light in a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightPlace {
    /// The number in `World::lights`.
    Light(usize),
    /// The number in `World::primitives` of a shape that emits.
    Primitive(usize),
}

impl Prepared {
    /// What surfaces receive from each light, by about 65,000 shadow rays from evenly spaced ones of them. Each surface has to
    /// [face](Surface::facing) the side that counts. Empty without surfaces, and for more than 256 lights.
    pub fn irradiance(&self, seen: &[Surface]) -> Vec<Irradiance> {
        let (lights, traceable) = (&self.lights, &self.traceable);
        if lights.len() == 0 || lights.len() > MOST_LIGHTS || seen.is_empty() {
            return Vec::new();
        }
        let most = (SHADOW_RAYS / lights.len() / 2).clamp(LEAST_OF_A_LIGHT, seen.len().max(LEAST_OF_A_LIGHT));
        let every = seen.len().div_ceil(most);
        let first: Vec<Surface> = seen.iter().step_by(every).copied().collect();
        // What these see in one direction each: light may come to them from there.
        let bounce = |(i, surface): (usize, &Surface)| {
            let ray = surface.spawn_ray(cosine_direction(surface.n, r2_sequence(i)));
            let hit = traceable.nearest(&ray).filter(|hit| !traceable.emits(hit))?;
            Some(Surface::new(traceable, &ray, &hit).facing(ray.d))
        };
        let second: Vec<Surface> = first.iter().enumerate().filter_map(bounce).collect();
        let world = World::new(traceable);
        let mut tracer = Tracer::new(traceable, lights);
        let of_light = |(number, light): (usize, LightPlace)| {
            let [direct, indirect] = [&first, &second]
                .map(|at| baseline!(simd => received(simd, self, (&world, &mut tracer), number, at)));
            Irradiance {
                light,
                mean: direct.irradiance / first.len() as f64,
                reaches: direct.lit + indirect.lit > 0,
                faces: direct.faced + indirect.faced > 0,
            }
        };
        places(self).into_iter().enumerate().map(of_light).collect()
    }
}

/// The place of each light of the table, which has points and directions first, then shapes, environment maps and constant skies.
fn places(prepared: &Prepared) -> Vec<LightPlace> {
    let (lights, source) = (&prepared.lights, &prepared.traceable.source.lights);
    let rank = |light: &Light| match light {
        Light::Environment { .. } => 1,
        Light::Infinite { .. } => 2,
        _ => 0,
    };
    let of_rank = |of: u32| {
        let own = source.iter().enumerate().filter(move |(_, light)| rank(light) == of);
        own.map(|(number, _)| LightPlace::Light(number))
    };
    let of_shapes = lights.primitives().map(LightPlace::Primitive);
    of_rank(0).chain(of_shapes).chain(of_rank(1)).chain(of_rank(2)).collect()
}

/// The light that surfaces receive from a light source.
#[derive(Default)]
struct Received {
    /// The sum of the irradiance.
    irradiance: f64,
    /// The number of surfaces that receive light, and of those that would without occlusion.
    lit: usize,
    faced: usize,
}

fn received<S: Simd>(
    simd: S,
    prepared: &Prepared,
    (world, tracer): (&World, &mut Tracer),
    light: usize,
    at: &[Surface],
) -> Received {
    let (mut sum, mut columns) = (Received::default(), RayColumns::new());
    for (group, lanes) in at.chunks(LANES).enumerate() {
        let surfaces = side_by_side(simd, world, lanes);
        let [u, v] = [0, 1].map(|axis| f64x8::from_fn(simd, |lane| r2_sequence(group * LANES + lane)[axis]));
        let active = first_lanes(simd, lanes.len());
        let is_sky = light >= prepared.lights.first_sky;
        let samples = if is_sky { 2 } else { 1 };
        for part in 0..samples {
            let (rays, light, faced) = match part {
                0 => of_light(simd, prepared, light, (&surfaces, world), [u, v]),
                _ => of_sky(simd, prepared, light, &surfaces, [u, v]),
            };
            let faced = faced & active & light.is_light();
            columns.store(0, &Stored::new(bits(simd, 0xff)), &rays);
            let is_met = world.occluded(simd, tracer, &columns, faced.to_bitmask(), !is_sky);
            let lit = faced & !bits(simd, is_met);
            sum.faced += set_lanes(faced).count();
            sum.lit += set_lanes(lit).count();
            sum.irradiance += set_lanes(lit).map(|lane| luminance(light.lane(lane))).sum::<f64>();
        }
    }
    sum
}

/// Rays to samples of a light, their share of the irradiance, and where they count.
fn of_light<S: Simd>(
    simd: S,
    prepared: &Prepared,
    light: usize,
    (surfaces, world): (&Surfaces<S>, &World),
    u: [f64x8<S>; 2],
) -> (Rays<S>, Vec3fx8<S>, mask64x8<S>) {
    let [none, all] = [false, true].map(|all| mask32x8::splat(simd, all));
    let domain = Domain { n: surfaces.n, ns: surfaces.n, is_two_sided: none, is_diffuse: all };
    let receivers = Receivers { surfaces: *surfaces, domain, lunes: None };
    let own = world.number(prepared.lights.curved_element(light));
    let leaving = surfaces.element.simd_eq(own) & widen(surfaces.instance.simd_eq(ElementId::WORLD));
    let sample = prepared.lights.sample(simd, light, (&receivers, leaving), (None, u));
    let cosine = sample.shadow.d.dot(surfaces.n.widen());
    // Directions from the surfaces find the rest of a sky.
    let other = if light >= prepared.lights.first_sky { cosine / PI } else { 0.0.simd_into(simd) };
    let share = cosine / (to_f64(sample.pdf) + other);
    let least = (0.25 * prepared.lights.radius(light) / sample.shadow.t_max).max(1.0) * GRAZING;
    let counts = sample.is_valid & cosine.simd_gt(least);
    (sample.shadow, sample.li.scaled(share), counts)
}

/// Rays in directions from the surfaces, for light of a sky.
fn of_sky<S: Simd>(
    simd: S,
    prepared: &Prepared,
    light: usize,
    surfaces: &Surfaces<S>,
    [u, v]: [f64x8<S>; 2],
) -> (Rays<S>, Vec3fx8<S>, mask64x8<S>) {
    let n = surfaces.n.widen();
    let mut d = n;
    for lane in 0..LANES {
        d.set_lane(lane, cosine_direction(n.lane(lane), DVec2::new(u[lane], v[lane])));
    }
    let (radiance, density) = prepared.lights.sky(simd, light, None, d);
    let cosine = d.dot(n);
    let share = cosine / (cosine / PI + to_f64(density));
    (surfaces.spawn_ray(d), radiance.scaled(share), cosine.simd_gt(0.0))
}

/// Surfaces side by side. The first one fills lanes without a surface.
fn side_by_side<S: Simd>(simd: S, world: &World, surfaces: &[Surface]) -> Surfaces<S> {
    let of = |lane: usize| surfaces.get(lane).unwrap_or(&surfaces[0]);
    let zero = Vec3x8::splat(simd, DVec3::ZERO);
    let number = |lane: usize| world.number(of(lane).element);
    let instance = |lane: usize| of(lane).element.instance;
    let mut wide = Surfaces {
        p: zero,
        n: zero.narrow(),
        ns: zero,
        magnitude: 0.0.simd_into(simd),
        element: f64x8::from_fn(simd, number),
        instance: u32x8::from_fn(simd, instance),
        time: 0.0.simd_into(simd),
    };
    for lane in 0..LANES {
        wide.set_lane(lane, of(lane));
    }
    wide
}

/// The `i`-th point of the R2 sequence (Roberts 2018) in the unit square.
pub fn r2_sequence(i: usize) -> DVec2 {
    (DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_3) * (i + 1) as f64).fract()
}

/// A direction that leaves a surface with a density in proportion to its cosine.
fn cosine_direction(n: DVec3, u: DVec2) -> DVec3 {
    let [x, y]: [f64; 2] =
        baseline!(simd => square_to_disk::<f64x8<_>>([u.x, u.y].map(|u| u.simd_into(simd))).map(|x| x[0]));
    let (s, t) = n.any_orthonormal_pair();
    s * x + t * y + n * (1.0 - x * x - y * y).max(0.0).sqrt()
}
