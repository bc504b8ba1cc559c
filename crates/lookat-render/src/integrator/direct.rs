//! Direct lighting (PBR 14.3).

use glam::{DVec2, Vec3};
use lookat_scene::LightChoice;

use super::{Draw, MAX_PASSED, Tracer, power_heuristic};
use crate::bsdf::{Bsdf, Domain, Lobes, Part};
use crate::camera::CameraRay;
use crate::light::LightTable;
use crate::ray::Ray;
use crate::sampler::SampleStream;
use crate::surface::Surface;

/// The radiance along a camera ray from lights that are seen, and from lights that the surface sees; by way of mirrors and
/// glass too, at less than `max_depth` surfaces in a row.
///
/// pbrt-v3 follows both the reflected and the refracted ray at glass; here one is chosen, at the same mean.
pub(crate) fn li(
    tracer: &mut Tracer,
    camera_ray: &CameraRay,
    stream: &mut SampleStream,
    all_lights: bool,
    max_depth: u32,
) -> Vec3 {
    let (mut radiance, mut beta) = (Vec3::ZERO, Vec3::ONE);
    let mut ray = camera_ray.ray();
    let mut seen_by = Some(camera_ray);
    let mut lobes = Lobes::default();
    let (mut depth, mut passed) = (0, 0);
    loop {
        let Some(hit) = tracer.nearest(&ray) else {
            return radiance + beta * tracer.lights().background(ray.d);
        };
        let surface = tracer.surface(&ray, &hit);
        let wo = -ray.d;
        let Some(bsdf) = tracer.bsdf(&surface, wo, seen_by.take(), &mut lobes) else {
            // pbrt-v3 looks through a surface without a material, and does not see it glow.
            ray = surface.leave(ray.d);
            passed += 1;
            if passed > MAX_PASSED {
                return radiance;
            }
            continue;
        };
        radiance += beta * surface.le(wo);
        if bsdf.has(Part::Smooth) {
            radiance += beta * from_lights(tracer, &surface, &bsdf, stream, all_lights);
        }
        depth += 1;
        if depth >= max_depth || !bsdf.has(Part::Specular) {
            return radiance;
        }
        let Some(sample) = bsdf.sample(stream.next_2d(), Part::Specular) else { return radiance };
        beta *= sample.weight();
        ray = surface.leave(sample.wi);
    }
}

/// What is drawn at each surface among these lights; `is_specular` where some material has single directions.
pub(crate) fn draws(table: &LightTable, all_lights: bool, is_specular: bool) -> Vec<Draw> {
    let extended: Vec<u32> =
        (0..table.len()).filter(|light| !table.is_delta(*light)).map(|light| table.samples(light)).collect();
    let most = (0..table.len()).map(|light| table.samples(light)).max().unwrap_or(0);
    let samples =
        if all_lights { extended.iter().sum() } else { extended.iter().copied().max().unwrap_or(0) };
    let scattered = if extended.is_empty() { 0 } else { most };
    let mut draws = Vec::new();
    let mut draw = |of, numbers| draws.extend((numbers > 0).then_some(Draw { of, numbers, from: 0 }));
    draw("light choice", u32::from(!all_lights && table.len() > 1));
    draw("lights", 2 * samples);
    draw("direction", 2 * scattered + 2 * u32::from(is_specular));
    draws
}

/// Light that comes straight to the surface: from all lights, or from one, chosen at random.
fn from_lights(
    tracer: &mut Tracer,
    surface: &Surface,
    bsdf: &Bsdf,
    stream: &mut SampleStream,
    all_lights: bool,
) -> Vec3 {
    let count = tracer.lights().len();
    if all_lights {
        return lights(tracer, surface, bsdf, stream, 0..count);
    }
    let chosen = tracer.lights().choose(LightChoice::Uniform, surface.p, stream);
    let Some((light, probability)) = chosen else { return Vec3::ZERO };
    lights(tracer, surface, bsdf, stream, light..light + 1) / probability as f32
}

/// Light that comes straight to the surface from a range of lights.
fn lights(
    tracer: &mut Tracer,
    surface: &Surface,
    bsdf: &Bsdf,
    stream: &mut SampleStream,
    range: std::ops::Range<usize>,
) -> Vec3 {
    let table = tracer.lights();
    // As many directions from the BSDF as the most that a light asks for: one direction serves all lights.
    let scattered = range.clone().map(|light| table.samples(light)).max().unwrap_or(0);
    let mut sum = Vec3::ZERO;
    for light in range.clone() {
        let samples = table.samples(light);
        if table.is_delta(light) {
            // Nothing about it is left to chance.
            sum += sampled_light(tracer, surface, bsdf, (light, 1, scattered), DVec2::ZERO);
            continue;
        }
        for k in 0..samples {
            let u = stream.nested_2d(samples, k);
            sum += sampled_light(tracer, surface, bsdf, (light, samples, scattered), u) / samples as f32;
        }
    }
    if range.clone().all(|light| table.is_delta(light)) {
        return sum;
    }
    let domain = bsdf.domain();
    for k in 0..scattered {
        let Some(sample) = bsdf.sample(stream.nested_2d(scattered, k), Part::Smooth) else { continue };
        let found = found_light(
            tracer,
            surface,
            &domain,
            &surface.leave(sample.wi),
            sample.pdf * f64::from(scattered),
            &range,
        );
        sum += sample.weight() * found / scattered as f32;
    }
    sum
}

/// One sample of a light: its number, how many samples it has, and how many directions the BSDF.
fn sampled_light(
    tracer: &mut Tracer,
    surface: &Surface,
    bsdf: &Bsdf,
    (light, samples, scattered): (usize, u32, u32),
    u: DVec2,
) -> Vec3 {
    let Some(sample) = tracer.lights().sample(light, surface, bsdf, u) else {
        return Vec3::ZERO;
    };
    let f_cos = bsdf.f_cos(sample.shadow.d);
    if f_cos == Vec3::ZERO || tracer.occluded(&sample.shadow) {
        return Vec3::ZERO;
    }
    let Some(pdf) = sample.pdf else { return f_cos * sample.li };
    let other = bsdf.pdf(sample.shadow.d, Part::Smooth) * f64::from(scattered);
    f_cos * sample.li * power_heuristic(pdf * f64::from(samples), other) / pdf as f32
}

/// Light that a direction from the BSDF finds, weighed against light sampling.
fn found_light(
    tracer: &mut Tracer,
    from: &Surface,
    domain: &Domain,
    ray: &Ray,
    pdf: f64,
    range: &std::ops::Range<usize>,
) -> Vec3 {
    let table = tracer.lights();
    let Some(hit) = tracer.nearest(ray) else {
        let infinite = table.infinite(domain, ray.d).filter(|(light, ..)| range.contains(light));
        return infinite
            .map(|(light, radiance, other)| {
                radiance * power_heuristic(pdf, other * f64::from(table.samples(light)))
            })
            .sum();
    };
    let Some(light) = table.of_element(hit.element).filter(|light| range.contains(light)) else {
        return Vec3::ZERO;
    };
    let on_light = tracer.surface(ray, &hit);
    let other = table.surface_pdf(light, from.p, &on_light) * f64::from(table.samples(light));
    on_light.le(-ray.d) * power_heuristic(pdf, other)
}
