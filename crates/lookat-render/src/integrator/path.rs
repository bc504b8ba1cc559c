//! Path tracing (PBR 14.5). The paths that continue are compacted at each surface.
//!
//! pbrt-v3 dimensions two directions from the BSDF at each surface, one for direct light and one to go on; here one serves both, at the same
//! mean.

use std::ops::Range;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, mask64x8, prelude::*};
use glam::Vec3;
use lookat_scene::LightChoice;

use super::SampleDimensions;
use super::profiler::Stage;
use crate::bsdf::{Domain, LobeFilter};
use crate::camera::Viewer;
use crate::integrator::lighting::{Illumination, Lighting};
use crate::integrator::path_batch::{BatchSurface, PathBatch};
use crate::integrator::path_record::PathRecord;
use crate::integrator::vertices::Vertices;
use crate::integrator::world::{Sees, Tracer};
use crate::light::{LightSampler, LightTable, Lunes, Receivers};
use crate::number::{Colors, LANES, bits, set_lanes, vectorized};
use crate::sampler::Streams;
use crate::surface::Surfaces;
use crate::trace::{
    MOST_PACKETS,
    rays::{Hits, Rays},
};

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
    pub(super) lighting: Lighting<'s>,
    pub max_depth: u32,
    pub(super) roulette_threshold: f64,
}

/// The packets of a batch at a surface, from their shading until their rays are traced. An array for each part, so that only what is needed
/// is loaded.
struct ShadedPackets<'s, S: Simd> {
    surfaces: ArrayVec<Surfaces<S>, MOST_PACKETS>,
    domains: ArrayVec<Domain<S>, MOST_PACKETS>,
    lunes: ArrayVec<Option<Lunes<S>>, MOST_PACKETS>,
    samplers: ArrayVec<LightSampler<'s, S>, MOST_PACKETS>,
    /// The direct light that reaches the film if nothing is in the way of the shadow rays, and the paths that get it.
    light: ArrayVec<Colors<S>, MOST_PACKETS>,
    is_lit: ArrayVec<mask64x8<S>, MOST_PACKETS>,
    shadow_rays: ArrayVec<Rays<S>, MOST_PACKETS>,
    is_sampled: ArrayVec<mask64x8<S>, MOST_PACKETS>,
    /// The paths that go on.
    scattered: ArrayVec<PathRecord<S>, MOST_PACKETS>,
}

impl<S: Simd> ShadedPackets<'_, S> {
    fn new() -> Self {
        ShadedPackets {
            surfaces: ArrayVec::new(),
            domains: ArrayVec::new(),
            lunes: ArrayVec::new(),
            samplers: ArrayVec::new(),
            light: ArrayVec::new(),
            is_lit: ArrayVec::new(),
            shadow_rays: ArrayVec::new(),
            is_sampled: ArrayVec::new(),
            scattered: ArrayVec::new(),
        }
    }
}

impl<'s> Paths<'s> {
    /// Adds direct light to the paths of a batch at a surface, and continues the paths. First all are shaded, then all shadow rays are
    /// traced together, and then all rays that continue paths.
    #[inline(never)]
    pub(super) fn surface<S: Simd>(
        &'s self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        at: BatchSurface,
        batch: &mut PathBatch,
    ) {
        let packets = &mut ShadedPackets::new();
        vectorized!(simd, {
            at.for_each_packet(
                simd,
                (&mut *tracer, streams, &mut *batch),
                #[inline(always)]
                |(tracer, streams, batch), paths| {
                    self.shade(simd, tracer, streams, paths, (at.camera, at.depth), batch, packets);
                },
            );
            if tracer.is_stopped {
                return;
            }
            self.add_direct(simd, tracer, packets, batch);
            let is_last = at.depth + 1 >= self.max_depth;
            if !is_last || tracer.may_find_light() {
                self.trace_scattered(simd, tracer, packets, is_last, batch);
            }
        })
    }

    /// Shades a packet of paths, and samples its lights and the directions that continue the paths.
    #[expect(clippy::too_many_arguments, reason = "all that a surface needs, and its result")]
    #[inline(never)]
    fn shade<S: Simd>(
        &'s self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &PathRecord<S>,
        (camera, depth): (Option<Viewer>, u32),
        batch: &mut PathBatch,
        packets: &mut ShadedPackets<'s, S>,
    ) {
        vectorized!(simd, {
            let sampler = self.lighting.at_hits(
                simd,
                tracer,
                paths,
                camera,
                batch,
                #[inline(always)]
                |tracer: &mut Tracer, vertices: &Vertices<S>, _: &mut PathBatch| {
                    let Vertices { illumination: Illumination { receivers, .. }, bsdf, .. } = vertices;
                    let active = paths.active & bsdf.has(LobeFilter::All);
                    let smooth = active & bsdf.has(LobeFilter::NonDelta);
                    let direct = vertices.one_light_unoccluded(tracer, streams, smooth);
                    tracer.profile(|profiler| profiler.enter(Stage::Scattering));
                    packets.light.push(paths.throughput * direct.light);
                    packets.is_lit.push(active);
                    packets.shadow_rays.push(direct.shadow);
                    packets.is_sampled.push(direct.is_sampled);
                    let is_last = depth + 1 >= self.max_depth;
                    if is_last && !tracer.may_find_light() {
                        packets.scattered.push(PathRecord { active: bits(simd, 0), ..*paths });
                    } else {
                        let sample = bsdf.sample(streams.next_2d(simd), LobeFilter::All);
                        let mut scattered = vertices.scattered(&sample, active);
                        scattered.carried = paths.carried * sample.radiance_scale;
                        if !is_last && !roulette(self.max_depth).is_empty() {
                            self.roulette(simd, streams, &mut scattered, depth);
                        }
                        packets.scattered.push(scattered);
                    }
                    packets.surfaces.push(*receivers.surfaces);
                    packets.domains.push(receivers.domain);
                    packets.lunes.push(receivers.lunes);
                },
            );
            packets.samplers.push(sampler);
        })
    }

    /// Traces the shadow rays of packets, and adds direct light.
    #[inline(always)]
    fn add_direct<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        packets: &ShadedPackets<S>,
        batch: &mut PathBatch,
    ) {
        let mut occluded = 0;
        if packets.is_sampled.iter().any(|own| own.any_true()) {
            let rays: ArrayVec<&Rays<S>, MOST_PACKETS> = packets.shadow_rays.iter().collect();
            let world = &self.lighting.world;
            occluded = world.occluded_of_packets(simd, tracer, &rays, &packets.is_sampled, true);
        }
        for (packet, paths) in packets.scattered.iter().enumerate() {
            let own = bits(simd, occluded >> (LANES * packet) & 0xff);
            let light = Colors::splat(simd, Vec3::ZERO).keep_where_wide(own, packets.light[packet]);
            batch.add_light(&paths.samples, light, packets.is_lit[packet]);
        }
    }

    /// Traces the rays that continue the paths of packets, adds the emission that they see, and continues the paths. At the last surface
    /// rays only look for emission.
    #[inline(always)]
    fn trace_scattered<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        packets: &mut ShadedPackets<S>,
        is_last: bool,
        batch: &mut PathBatch,
    ) {
        let world = &self.lighting.world;
        let mut hits: ArrayVec<Hits<S>, MOST_PACKETS> = ArrayVec::new();
        let mut active: ArrayVec<mask64x8<S>, MOST_PACKETS> = ArrayVec::new();
        for paths in &packets.scattered {
            hits.push(Hits::none(simd));
            active.push(paths.active);
        }
        let rays: ArrayVec<&Rays<S>, MOST_PACKETS> =
            packets.scattered.iter().map(|paths| &paths.rays).collect();
        if is_last {
            world.find_emission(simd, tracer, &rays, &mut active, &mut hits);
        } else {
            world.nearest_of_packets(simd, tracer, &rays, &active, &mut hits);
        }
        drop(rays);
        for (packet, (hits, active)) in hits.iter().zip(&active).enumerate() {
            let paths = &mut packets.scattered[packet];
            (paths.hits, paths.active) = (*hits, *active);
            let escapes = tracer.lights.has_skies() && (!hits.is_hit() & *active).any_true();
            if escapes || (hits.emits & *active).any_true() {
                self.add_found(simd, tracer, packets, packet, batch);
            }
            if !is_last {
                world.continue_paths(simd, tracer, &mut packets.scattered[packet], (0, Sees::All), batch);
            }
        }
    }

    /// Adds the emission that the rays of a packet see.
    #[inline(never)]
    fn add_found<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        packets: &ShadedPackets<S>,
        packet: usize,
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            let (surfaces, domain) = (&packets.surfaces[packet], packets.domains[packet]);
            let receivers = &Receivers { surfaces, domain, lunes: packets.lunes[packet] };
            let sampler = &packets.samplers[packet];
            let illumination = Illumination { simd, lighting: &self.lighting, receivers, sampler };
            let paths = &packets.scattered[packet];
            batch.add(paths, illumination.light_of(tracer, paths));
        })
    }

    /// Plays Russian roulette, and ends paths.
    #[inline(always)]
    fn roulette<S: Simd>(&self, simd: S, streams: &mut Streams, paths: &mut PathRecord<S>, depth: u32) {
        let PathRecord { throughput, carried: radiance_scale, .. } = paths;
        let mut asked = 0;
        if depth + 1 > FIRST_ROULETTE {
            for lane in set_lanes(paths.active) {
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
        paths.active &= !bits(simd, ended);
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
