//! Direct lighting (PBR 14.3).

pub(crate) mod lanes;

use glam::{DVec2, Vec3};
use lookat_scene::{DirectStrategy, LightChoice};

use super::weighed::{LightSamples, Samples, Sampling, Vertex, by_directions, one_light, sampled_light};
use super::{Draw, FirstHit, MAX_PASSED, Tracer};
use crate::bsdf::{Bsdf, Lobes, Part};
use crate::light::{LightTable, Receiver};
use crate::sampler::SampleStream;
use crate::surface::Surface;

/// The radiance along a camera ray from lights that are seen, and from lights that the surface sees; by way of mirrors and
/// glass too, at less than `max_depth` surfaces in a row.
///
/// pbrt-v3 follows both the reflected and the refracted ray at glass; here one is chosen, at the same mean.
pub(crate) fn li(
    tracer: &mut Tracer,
    first: &FirstHit,
    stream: &mut SampleStream,
    strategy: DirectStrategy,
    max_depth: u32,
) -> Vec3 {
    let (mut radiance, mut beta) = (Vec3::ZERO, Vec3::ONE);
    let (mut ray, mut found) = (*first.ray, first.hit.copied());
    let mut seen_by = Some(first.camera_ray);
    let mut lobes = Lobes::default();
    let (mut depth, mut passed) = (0, 0);
    loop {
        let Some(hit) = &found else {
            return radiance + beta * tracer.lights().background(ray.d);
        };
        let surface = tracer.surface(&ray, hit);
        let wo = -ray.d;
        if surface.is_passed() {
            seen_by = None;
            // pbrt-v3 looks through a surface without a material, and does not see it glow.
            ray = surface.leave(ray.d);
            passed += 1;
            if passed > MAX_PASSED {
                return radiance;
            }
            tracer.find(&ray, &mut found);
            continue;
        }
        let bsdf = tracer.bsdf(&surface, wo, seen_by.take(), &mut lobes);
        radiance += beta * surface.le(wo);
        if bsdf.has(Part::Smooth) {
            radiance += beta * from_lights(tracer, &surface, &bsdf, stream, strategy);
        }
        depth += 1;
        if depth >= max_depth || !bsdf.has(Part::Specular) {
            return radiance;
        }
        let Some(sample) = bsdf.sample(stream.next_2d(), Part::Specular) else { return radiance };
        beta *= sample.weight();
        ray = surface.leave(sample.wi);
        tracer.find(&ray, &mut found);
    }
}

/// How one light is chosen; as in pbrt-v3.
const CHOICE: LightChoice = LightChoice::Uniform;

/// What is drawn at each of `depth` surfaces among these lights; `is_specular` where some material has single directions.
pub(crate) fn draws(
    table: &LightTable,
    strategy: DirectStrategy,
    depth: u32,
    is_specular: bool,
) -> Vec<Draw> {
    // A sky that is not sampled gives its samples to directions, so that the sum is the same for all surfaces.
    let eligible = table.eligible(None);
    let extended = (0..eligible).filter(|light| !table.is_delta(*light));
    let (samples, scattered): (u32, u32) = match strategy {
        DirectStrategy::All | DirectStrategy::EachOnce => (
            total(extended.map(|light| table.samples(light, strategy))),
            total(directions(table, strategy, eligible)),
        ),
        DirectStrategy::One => (u32::from(table.has_extended()), u32::from(table.has_extended())),
    };
    let mut draws = Vec::new();
    let mut draw =
        |of, numbers| draws.extend((numbers > 0).then_some(Draw { of, numbers, surfaces: 0..depth }));
    draw("light choice", u32::from(strategy == DirectStrategy::One && table.len() > 1));
    draw("lights", samples.saturating_mul(2));
    draw("direction", scattered.saturating_add(u32::from(is_specular)).saturating_mul(2));
    draws
}

/// Light that comes straight to the surface: from one light, chosen at random, or from all.
fn from_lights(
    tracer: &mut Tracer,
    surface: &Surface,
    bsdf: &Bsdf,
    stream: &mut SampleStream,
    strategy: DirectStrategy,
) -> Vec3 {
    let table = tracer.lights();
    let receiver = &Receiver { p: surface.p, domain: bsdf.domain() };
    let lune = table.lune(&receiver.domain);
    let lune = lune.as_ref();
    let vertex = |samples| {
        let sampling = Sampling { receiver, lune, samples };
        Vertex { surface, bsdf, part: Part::Smooth, sampling }
    };
    if strategy == DirectStrategy::One {
        let vertex = &vertex(Samples::of_one(table, CHOICE, lune));
        let light = one_light(tracer, vertex, stream, CHOICE);
        return light + by_directions(tracer, vertex, stream, u32::from(table.has_extended()));
    }
    let eligible = table.eligible(lune);
    let samples = Samples {
        lights: LightSamples::Each(strategy),
        directions: total(directions(table, strategy, eligible)),
    };
    let vertex = &vertex(samples);
    let mut radiance = Vec3::ZERO;
    for light in 0..eligible {
        let count = table.samples(light, strategy);
        for k in 0..count {
            // Where nothing about a light is left to chance, no numbers are.
            let u = if table.is_delta(light) { DVec2::ZERO } else { stream.nested_2d(count, k) };
            radiance += sampled_light(tracer, vertex, (light, f64::from(count)), u);
        }
    }
    directions(table, strategy, eligible)
        .fold(radiance, |sum, count| sum + by_directions(tracer, vertex, stream, count))
}

/// How many directions from the BSDF look for all lights, pattern by pattern, where the first so many lights are eligible
/// for samples: as many as the most that a light asks for, and those that the others ask for.
fn directions(table: &LightTable, strategy: DirectStrategy, eligible: usize) -> impl Iterator<Item = u32> {
    let samples = move |light| table.samples(light, strategy);
    let most = (0..table.len()).map(samples).max().filter(|_| table.has_extended());
    most.into_iter().chain((eligible..table.len()).map(samples))
}

fn total(counts: impl Iterator<Item = u32>) -> u32 {
    counts.fold(0, u32::saturating_add)
}
