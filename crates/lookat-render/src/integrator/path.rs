//! Path tracing (PBR 14.5). The paths that continue are compacted at each surface.
//!
//! pbrt-v3 dimensions two directions from the BSDF at each surface, one for direct light and one to go on; here one serves both, at the same
//! mean.

use std::ops::Range;

use fearless_simd::{Simd, f32x8, mask64x8};
use lookat_scene::LightChoice;

use super::SampleDimensions;
use super::profiler::Stage;
use crate::bsdf::{Bsdf, LobeFilter, Slots};
use crate::camera::{Viewer, Views};
use crate::integrator::lighting::{Directions, LightSamples, Lighting, Vertices};
use crate::integrator::path_batch::{PathBatch, PathPacket, TracedRays};
use crate::integrator::world::{Sees, Tracer, World};
use crate::light::LightTable;
use crate::number::{Colors, bits, first_lanes, set_lanes};
use crate::sampler::Streams;
use crate::shading::Shaded;

/// The first surface at which roulette may end a path, counted from 0; as in pbrt-v3.
const FIRST_ROULETTE: u32 = 4;

/// The surfaces at which Russian roulette may be played: not the last, where all that is left is to look for light.
fn roulette(max_depth: u32) -> Range<u32> {
    FIRST_ROULETTE..max_depth.saturating_sub(1)
}

/// The number of sample dimensions at a surface: light choice, light, direction and roulette. It is the same at all
/// surfaces, so that the dimensions of a surface do not depend on the surfaces before.
pub(super) fn numbers(max_depth: u32) -> u32 {
    5 + u32::from(!roulette(max_depth).is_empty())
}

/// The sample dimensions at each surface with a material, with these lights.
pub(crate) fn dimensions(max_depth: u32, lights: &LightTable, choice: LightChoice) -> Vec<SampleDimensions> {
    let add = |purpose, count, surfaces, needed: bool| {
        needed.then_some(SampleDimensions { purpose, count, surfaces })
    };
    let all = 0..max_depth;
    // Where no light is sampled, another direction takes its numbers.
    let is_sampled = lights.has_extended() && !lights.leaves_all_to_directions(false);
    let dimensions = [
        add("light choice", 1, all.clone(), lights.is_choice(choice)),
        add("light", 2, all.clone(), is_sampled),
        add("direction", 2, all.clone(), !lights.has_extended() || is_sampled),
        add("directions", 4, all, lights.leaves_all_to_directions(false)),
        add("roulette", 1, roulette(max_depth), !roulette(max_depth).is_empty()),
    ];
    dimensions.into_iter().flatten().collect()
}

/// A scene with path tracing.
pub(crate) struct Paths<'s> {
    pub(in crate::integrator) world: World<'s>,
    lighting: Lighting<'s>,
    pub max_depth: u32,
    roulette_threshold: f64,
}

impl<'s> Paths<'s> {
    pub fn new(
        world: World<'s>,
        lights: &'s LightTable,
        choice: LightChoice,
        (max_depth, roulette_threshold): (u32, f64),
    ) -> Self {
        let sampled = LightSamples::One(choice);
        let lighting = Lighting::new(&world, lights, sampled, LobeFilter::All);
        Paths { world, lighting, max_depth, roulette_threshold }
    }

    /// Adds direct light to a packet of paths at a surface, and continues the paths.
    #[inline(never)]
    pub(super) fn surface<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &PathPacket<S>,
        (camera, depth): (Option<Viewer>, u32),
        batch: &mut PathBatch,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let PathPacket { rays, hits, samples, direct, .. } = paths;
                let mut active = first_lanes(simd, samples.len());
                let views = camera.map(|of| Views { of, places: &batch.places, samples, direct: *direct });
                let mut slots = Slots::new();
                let shaded =
                    self.world.shaded(simd, tracer, (rays, hits), views.as_ref(), active, &mut slots);
                let Shaded { surfaces, frames, .. } = &shaded;
                let bsdf = &Bsdf::new(surfaces.n, surfaces.ns, *frames, -rays.d, &mut slots);
                tracer.profile(|profiler| profiler.enter(Stage::Lights));
                let receivers = &self.lighting.receivers(surfaces, bsdf, active);
                let sampler = &self.lighting.sampler(simd, receivers);
                let vertices =
                    Vertices { simd, lighting: &self.lighting, world: &self.world, bsdf, receivers, sampler };
                active &= bsdf.has(LobeFilter::All);
                let smooth = active & bsdf.has(LobeFilter::NonDelta);
                let light = vertices.direct(tracer, streams, smooth);
                batch.add(samples, paths.throughput * light, active);
                let is_last = depth + 1 >= self.max_depth;
                if is_last && !tracer.may_find_light() {
                    return;
                }
                let sample = bsdf.sample(streams.next_2d(simd), LobeFilter::All);
                active &= sample.is_valid;
                let mut throughput = paths.throughput * sample.weight;
                let radiance_scale = paths.carried * sample.radiance_scale;
                let directions = Directions {
                    rays: surfaces.spawn_ray(sample.wi),
                    pdf: sample.pdf,
                    is_delta: sample.is_delta,
                };
                if is_last {
                    let light = vertices.found_light(tracer, &directions, active);
                    batch.add(samples, throughput * light, active);
                    return;
                }
                if !roulette(self.max_depth).is_empty() {
                    active = self.roulette(simd, streams, (&mut throughput, radiance_scale), depth, active);
                }
                let found = self.world.nearest(simd, tracer, &directions.rays, active);
                let light = vertices.light_of(tracer, &directions, &found, active);
                batch.add(samples, throughput * light, active);
                let traced = &mut TracedRays {
                    rays: directions.rays,
                    hits: found,
                    throughput,
                    carried: radiance_scale,
                    branch: 0,
                };
                self.world.continue_paths(
                    simd,
                    tracer,
                    traced,
                    samples,
                    (active, sample.is_delta, Sees::All),
                    batch,
                );
            },
        )
    }

    /// Plays Russian roulette, and returns the paths that continue.
    #[inline(always)]
    fn roulette<S: Simd>(
        &self,
        simd: S,
        streams: &mut Streams,
        (throughput, radiance_scale): (&mut Colors<S>, f32x8<S>),
        depth: u32,
        active: mask64x8<S>,
    ) -> mask64x8<S> {
        let mut asked = 0;
        if depth + 1 > FIRST_ROULETTE {
            for lane in set_lanes(active) {
                let strength = f64::from(throughput.lane(lane).max_element() / radiance_scale[lane]);
                asked |= u64::from(strength < self.roulette_threshold) << lane;
            }
        }
        let numbers = streams.next_1d(simd);
        let mut ended = 0;
        for lane in set_lanes(bits(simd, asked)) {
            let own = throughput.lane(lane);
            let end = (1.0 - f64::from(own.max_element() / radiance_scale[lane])).max(0.05);
            ended |= u64::from(numbers[lane] < end) << lane;
            throughput.set_lane(lane, own / (1.0 - end) as f32);
        }
        active & !bits(simd, ended)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::prepare::Prepared;
    use crate::render::{Settings, render};
    use crate::testing::scene;

    /// A scene of one pixel, with squares above and below the eye.
    fn between(down: bool, integrator: &str, squares: &[(f64, &str, &str)]) -> f32 {
        let square = |(y, material, mask): &(f64, &str, &str)| {
            format!(
                "Material \"{material}\" \"rgb Kd\" [.5 .5 .5] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
                 \"point P\" [-1e6 {y} -1e6 1e6 {y} -1e6 1e6 {y} 1e6 -1e6 {y} 1e6] {mask}"
            )
        };
        let scene = scene(&format!(
            "LookAt 0 1 0 0 {} 0 0 0 1 Film \"image\" \"integer xresolution\" 1 \"integer yresolution\" 1
             Camera \"perspective\" \"float fov\" 20 Sampler \"sobol\" \"integer pixelsamples\" 64
             Integrator {integrator} WorldBegin LightSource \"infinite\" {} WorldEnd",
            if down { 0 } else { 2 },
            squares.iter().map(square).collect::<String>(),
        ));
        let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
        rendered.image.channels[0].samples[0]
    }

    /// A floor under a sky is lit, but not by way of a surface without a material; nor does that hide the sky from the camera.
    #[test]
    fn no_light_comes_through_what_has_no_material() {
        let (floor, above) = ((0.0, "matte", ""), (2.0, "", ""));
        let path = "\"path\"";
        for (down, squares, expected) in
            [(true, &[floor][..], 0.5), (true, &[floor, above], 0.0), (false, &[floor, above], 1.0)]
        {
            let found = between(down, path, squares);
            assert!((found - expected).abs() < 1e-3, "{expected} {found}");
        }
    }

    /// Rays of the BSDF meet what shadow rays pass; as in pbrt-v3.
    #[test]
    fn what_casts_no_shadow_hides_the_sky() {
        let squares = [(0.0, "matte", ""), (2.0, "matte", "\"float shadowalpha\" 0")];
        for integrator in ["\"path\" \"integer maxdepth\" 1", "\"directlighting\""] {
            assert_eq!(between(true, integrator, &squares), 0.0);
        }
        assert!((between(true, "\"ambientocclusion\"", &squares) / std::f32::consts::PI - 1.0).abs() < 1e-3);
    }

    /// Where all that can be drawn is drawn, a surface takes as many numbers as it is said to.
    #[test]
    fn a_surface_takes_as_many_dimensions_as_it_is_said_to_draw() {
        let scene = scene(
            "Film \"image\" Camera \"perspective\" Sampler \"sobol\" Integrator \"path\" WorldBegin
            AreaLightSource \"diffuse\" Translate .5 0 .5
            Shape \"sphere\" \"float radius\" .1 Translate -1 0 0 Shape \"sphere\" \"float radius\" .1 WorldEnd",
        );
        let lights = &Prepared::new(&scene).lights;
        for (max_depth, expected) in [(5, 5), (9, 6)] {
            let drawn: u32 =
                dimensions(max_depth, lights, LightChoice::Spatial).iter().map(|used| used.count).sum();
            assert_eq!((drawn, numbers(max_depth)), (expected, expected));
        }
    }
}
