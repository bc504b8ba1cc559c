//! Path tracing (PBR 14.5).

pub(crate) mod lanes;

use std::ops::Range;

use glam::Vec3;
use lookat_scene::LightChoice;

use super::weighed::{Emission, Samples, Sampling, Vertex, found_light, light_of, one_light};
use super::{Draw, FirstHit, MAX_PASSED, Tracer};
use crate::bsdf::{Lobes, Part};
use crate::light::{LightTable, Receiver};
use crate::sampler::SampleStream;

/// What the path integrator is set to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settings {
    pub max_depth: u32,
    pub roulette_threshold: f64,
    pub light_choice: LightChoice,
}

/// The first surface at which roulette may end a path, counted from 0; as in pbrt-v3.
const FIRST_ROULETTE: u32 = 4;

/// The surfaces at which Russian roulette may be played: not the last, where all that is left is to look for light.
fn roulette(max_depth: u32) -> Range<u32> {
    FIRST_ROULETTE..max_depth.saturating_sub(1)
}

/// What is drawn at each surface with a material, among these lights.
pub(crate) fn draws(max_depth: u32, lights: &LightTable) -> Vec<Draw> {
    let draw = |of, numbers, surfaces, needed: bool| needed.then_some(Draw { of, numbers, surfaces });
    let all = 0..max_depth;
    // Where no light is sampled, another direction takes its numbers.
    let is_sampled = lights.has_extended() && !lights.leaves_all_to_directions(None);
    let draws = [
        draw("light choice", 1, all.clone(), lights.len() > 1),
        draw("light", 2, all.clone(), is_sampled),
        draw("direction", 2, all.clone(), !lights.has_extended() || is_sampled),
        draw("directions", 4, all, lights.leaves_all_to_directions(None)),
        draw("roulette", 1, roulette(max_depth), !roulette(max_depth).is_empty()),
    ];
    draws.into_iter().flatten().collect()
}

/// The radiance along a camera ray.
///
/// pbrt-v3 draws two directions from the BSDF at each surface, one for direct light and one to go on; here one serves
/// both, at the same mean.
pub(crate) fn li(
    tracer: &mut Tracer,
    first: &FirstHit,
    stream: &mut SampleStream,
    settings: &Settings,
) -> Vec3 {
    let lights = tracer.lights();
    let (mut radiance, mut beta) = (Vec3::ZERO, Vec3::ONE);
    // What refraction has done to beta: roulette is to count light, not its density.
    let mut compression = 1.0;
    // Whether light that the ray finds counts in full: it comes from the camera or from single directions. Other rays have been
    // asked what they find, and weighed, as they left their surface.
    let mut is_full = true;
    let has_roulette = !roulette(settings.max_depth).is_empty();
    let (mut ray, mut found) = (*first.ray, first.hit.copied());
    let mut seen_by = Some(first.camera_ray);
    let mut lobes = Lobes::default();
    let (mut bounces, mut passed) = (0, 0);
    loop {
        let Some(hit) = &found else {
            return if is_full { radiance + beta * lights.background(ray.d) } else { radiance };
        };
        let surface = tracer.surface(&ray, hit);
        let wo = -ray.d;
        if is_full {
            radiance += beta * surface.le(wo);
        }
        if bounces >= settings.max_depth {
            return radiance;
        }
        if surface.is_passed() {
            // pbrt-v3 sees no light through a surface without a material, except from the camera or from single directions.
            seen_by = None;
            ray = surface.leave(ray.d);
            passed += 1;
            if passed > MAX_PASSED {
                return radiance;
            }
            tracer.find(&ray, &mut found);
            continue;
        }
        let bsdf = tracer.bsdf(&surface, wo, seen_by.take(), &mut lobes);
        let is_smooth = bsdf.has(Part::Smooth);
        let receiver = &Receiver { p: surface.p, domain: bsdf.domain() };
        let lune = if is_smooth { lights.lune(&receiver.domain) } else { None };
        let lune = lune.as_ref();
        let samples = Samples::of_one(lights, settings.light_choice, lune);
        let sampling = Sampling { receiver, lune, samples };
        let vertex = Vertex { surface: &surface, bsdf: &bsdf, part: Part::All, sampling };
        if is_smooth {
            radiance += beta * one_light(tracer, &vertex, stream, settings.light_choice);
        }
        bounces += 1;
        let is_last = bounces >= settings.max_depth;
        if is_last && !tracer.may_find_light() {
            return radiance;
        }
        let sample = bsdf.sample(stream.next_2d(), Part::All);
        let Some(sample) = &sample else { return radiance };
        beta *= sample.weight();
        compression *= sample.compression;
        ray = surface.leave(sample.wi);
        let emission = Emission::by(&vertex, sample);
        if is_last {
            return radiance + beta * found_light(tracer, emission, &ray);
        }
        if has_roulette {
            // As pbrt-v3: from the fifth surface on, by the brightest channel.
            let strength = f64::from(beta.max_element() / compression);
            if bounces > FIRST_ROULETTE && strength < settings.roulette_threshold {
                let end = (1.0 - strength).max(0.05);
                if stream.next_1d() < end {
                    return radiance;
                }
                beta /= (1.0 - end) as f32;
            } else {
                stream.skip(1);
            }
        }
        tracer.find(&ray, &mut found);
        is_full = matches!(emission, Emission::Full);
        if !is_full {
            radiance += beta * light_of(tracer, emission, &ray, found.as_ref());
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::camera::CameraRay;
    use crate::prepare::Prepared;
    use crate::testing::scene;

    /// A floor under a sky is lit, but not by way of a surface without a material; nor does that hide the sky from the camera.
    #[test]
    fn no_light_comes_through_what_has_no_material() {
        let quad = |y: f64| {
            format!(
                "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
                 \"point P\" [-1e6 {y} -1e6 1e6 {y} -1e6 1e6 {y} 1e6 -1e6 {y} 1e6]"
            )
        };
        for (down, above, expected) in [(true, false, 0.5), (true, true, 0.0), (false, true, 1.0)] {
            let above = if above { format!("Material \"\" {}", quad(2.0)) } else { String::new() };
            let scene = scene(&format!(
                "LookAt 0 1 0 0 {} 0 0 0 1 Film \"image\" Camera \"perspective\" \"float fov\" 20 Sampler \"sobol\"
                 Integrator \"path\" WorldBegin LightSource \"infinite\" Material \"matte\" \"rgb Kd\" [.5 .5 .5] {} {above}
                 WorldEnd",
                if down { 0 } else { 2 },
                quad(0.0),
            ));
            let prepared = Prepared::new(&scene);
            let Prepared { traceable, lights, .. } = &prepared;
            let camera = prepared.camera(&scene.view);
            let film = DVec2::new(641.0, 361.0);
            let camera_ray = &CameraRay { camera: &camera, film, on_lens: DVec2::ZERO, spacing: 1.0 };
            let settings =
                Settings { max_depth: 5, roulette_threshold: 0.0, light_choice: LightChoice::Spatial };
            let (mut tracer, mut sum) = (Tracer::new(traceable, lights), Vec3::ZERO);
            let (mut stream, ray) = (SampleStream::new(&scene.view.sampler, 0, [0, 0]), camera_ray.ray());
            let hit = tracer.nearest(&ray);
            let first = FirstHit { camera_ray, ray: &ray, hit: hit.as_ref() };
            for index in 0..64 {
                stream.restart(index);
                sum += li(&mut tracer, &first, &mut stream, &settings) / 64.0;
            }
            assert!((sum - expected).abs().max_element() < 1e-3, "{expected} {sum}");
        }
    }

    /// In a closed room that absorbs nothing, a path takes at each surface all dimensions that it ever takes.
    #[test]
    fn a_surface_takes_as_many_dimensions_as_it_is_said_to_draw() {
        let scene = scene(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"sphere\" AreaLightSource \"diffuse\" Translate .5 0 .5
            Shape \"sphere\" \"float radius\" .1 Translate -1 0 0 Shape \"sphere\" \"float radius\" .1 WorldEnd",
        );
        let prepared = Prepared::new(&scene);
        let Prepared { traceable, lights, .. } = &prepared;
        let camera = prepared.camera(&scene.view);
        for max_depth in [5, 9] {
            let film = DVec2::new(700.0, 300.0);
            let camera_ray = CameraRay { camera: &camera, film, on_lens: DVec2::ZERO, spacing: 1.0 };
            let settings = Settings { max_depth, roulette_threshold: 0.0, light_choice: LightChoice::Power };
            let mut stream = SampleStream::new(&scene.view.sampler, 0, [0, 0]);
            let mut tracer = Tracer::new(traceable, lights);
            let ray = camera_ray.ray();
            let hit = tracer.nearest(&ray);
            let first = FirstHit { camera_ray: &camera_ray, ray: &ray, hit: hit.as_ref() };
            li(&mut tracer, &first, &mut stream, &settings);
            let draws = draws(max_depth, lights);
            let at_each: u32 = draws.iter().map(|draw| draw.numbers).sum();
            // Those of roulette are taken also where it is not played, but for the last surface.
            let has_roulette = !roulette(max_depth).is_empty();
            let taken = at_each * max_depth - u32::from(has_roulette);
            assert_eq!(stream.dimension(), taken);
            let drawn = |draw: &Draw| draw.numbers * draw.surfaces.len() as u32;
            let skipped = if has_roulette { FIRST_ROULETTE } else { 0 };
            assert_eq!(draws.iter().map(drawn).sum::<u32>(), taken - skipped);
        }
    }
}
