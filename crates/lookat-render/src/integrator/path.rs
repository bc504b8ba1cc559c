//! Path tracing (PBR 14.5). The paths that continue are compacted at each surface.
//!
//! pbrt-v3 dimensions two directions from the BSDF at each surface, one for direct light and one to go on; here one serves both, at the same
//! mean.

use std::ops::Range;

use fearless_simd::{Simd, mask64x8};
use lookat_scene::LightChoice;

use super::SampleDimensions;
use super::bodies::PROBE_NUMBERS;
use crate::bsdf::LobeFilter;
use crate::camera::Viewer;
use crate::integrator::lighting::{Illumination, Lighting};
use crate::integrator::path_batch::{BatchSurface, PathBatch};
use crate::integrator::path_record::{PathColumns, PathRecord};
use crate::integrator::vertices::{Scattering, Vertices};
use crate::integrator::world::{Sees, Tracer};
use crate::light::LightTable;
use crate::medium::Media;
use crate::number::{LANES, bits, set_lanes, vectorized};
use crate::sampler::Streams;

/// The first surface at which roulette may end a path, counted from 0; as in pbrt-v3.
const FIRST_ROULETTE: u32 = 4;

/// The surfaces at which Russian roulette may be played: not the last, where all that is left is to look for light.
fn roulette(max_depth: u32) -> Range<u32> {
    FIRST_ROULETTE..max_depth.saturating_sub(1)
}

/// The number of sample dimensions at a surface: light choice, light, direction and roulette. It is the same at all
/// surfaces, so that the dimensions of a surface do not depend on the surfaces before.
fn numbers(max_depth: u32) -> u32 {
    5 + u32::from(!roulette(max_depth).is_empty())
}

/// The sample dimensions at each surface with a material, with these lights. `has_bodies`: light may enter there and leave elsewhere.
pub(crate) fn dimensions(
    max_depth: u32,
    lights: &LightTable,
    choice: LightChoice,
    has_bodies: bool,
) -> Vec<SampleDimensions> {
    let add = |purpose, count, surfaces, needed: bool| {
        // Where light leaves is a second vertex.
        let count = if has_bodies { 2 * count } else { count };
        needed.then_some(SampleDimensions { purpose, count, surfaces })
    };
    let probe = SampleDimensions { purpose: "probe", count: PROBE_NUMBERS, surfaces: 0..max_depth };
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
    dimensions.into_iter().flatten().chain(has_bodies.then_some(probe)).collect()
}

/// A scene with path tracing.
pub(crate) struct Paths<'s> {
    pub(super) lighting: Lighting<'s>,
    pub max_depth: u32,
    pub(super) roulette_threshold: f64,
}

impl Paths<'_> {
    /// The number of sample dimensions at a surface. Bodies have a second vertex there, where light leaves them.
    pub(super) fn numbers(&self) -> u32 {
        let own = numbers(self.max_depth);
        if self.lighting.bodies.is_some() { 2 * own + PROBE_NUMBERS } else { own }
    }

    /// Adds direct light to the paths of a batch at a surface, and continues the paths. First all are shaded, then all shadow rays are
    /// traced together, and then all rays that continue paths. At the last surface these only look for emission.
    #[inline(never)]
    pub(super) fn surface<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        at: BatchSurface,
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            at.for_each_packet(
                simd,
                (&mut *tracer, streams, &mut *batch),
                #[inline(always)]
                |(tracer, streams, batch), paths| {
                    self.shade(simd, tracer, streams, paths, (at.camera, at.depth), batch);
                },
            );
            let Lighting { world, .. } = &self.lighting;
            if let Some(media) = &world.media {
                self.scatter_in_media(simd, tracer, streams, media, at, batch);
            }
            if self.lighting.bodies.is_some() {
                let probes = at.dimension.wrapping_add(numbers(self.max_depth));
                self.lighting.leave_bodies(
                    simd,
                    tracer,
                    streams,
                    probes,
                    batch,
                    #[inline(always)]
                    |tracer: &mut Tracer,
                     streams: &mut Streams,
                     vertices: &Vertices<S>,
                     batch: &mut PathBatch| {
                        let all = vertices.paths.active;
                        self.scatter(tracer, streams, vertices, (all, all), at.depth, batch);
                    },
                );
            }
            if tracer.is_stopped {
                return;
            }
            self.lighting.trace_waiting(simd, tracer, batch);
            let (scattered, radiance) = batch.branch(0);
            let all = scattered.paths.all();
            if all != 0 {
                let PathColumns { rays, hits, .. } = &mut scattered.paths;
                world.nearest(simd, tracer, rays, all, hits);
                if let Some(media) = &world.media {
                    self.lighting.advance(simd, tracer, (streams, at.depth + 1), media, batch);
                } else {
                    self.lighting.add_emission(simd, tracer, scattered, all, radiance);
                    world.continue_paths(simd, tracer, &mut scattered.paths, Sees::All, radiance);
                }
            }
        })
    }

    /// Samples the lights of the points where paths scatter in media, and the directions that continue the paths.
    #[inline(never)]
    fn scatter_in_media<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        media: &Media,
        at: BatchSurface,
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            let paths = &mut PathRecord::none(simd);
            let count = batch.in_media.as_ref().map_or(0, |own| own.events.count);
            for first in (0..count).step_by(LANES) {
                let Some(own) = batch.in_media.as_ref().filter(|_| tracer.should_continue()) else { break };
                own.events.load(simd, first, count, paths);
                streams.choose(simd, &paths.samples, at.dimension);
                self.lighting.in_media(
                    simd,
                    tracer,
                    media,
                    paths,
                    #[inline(always)]
                    |tracer: &mut Tracer, vertices: &Vertices<S>| {
                        let all = (paths.active, paths.active);
                        self.scatter(tracer, streams, vertices, all, at.depth, batch);
                    },
                );
            }
            if let Some(own) = &mut batch.in_media {
                own.events.count = 0;
            }
        })
    }

    /// Shades a packet of paths, and samples its lights and the directions that continue the paths.
    #[inline(never)]
    fn shade<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        paths: &PathRecord<S>,
        (camera, depth): (Option<Viewer>, u32),
        batch: &mut PathBatch,
    ) {
        vectorized!(simd, {
            self.lighting.at_hits(
                simd,
                tracer,
                paths,
                camera,
                batch,
                #[inline(always)]
                |tracer: &mut Tracer, vertices: &Vertices<S>, batch: &mut PathBatch| {
                    let Scattering::Surface(bsdf) = vertices.scattering else { return };
                    let active = paths.active & bsdf.has(LobeFilter::All);
                    let smooth = active & bsdf.has(LobeFilter::NonDelta);
                    self.scatter(tracer, streams, vertices, (active, smooth), depth, batch);
                },
            );
        })
    }

    /// Samples the lights of vertices and the directions that continue their paths. `active`: the vertices that scatter at all, and those
    /// that scatter into all directions.
    #[inline(always)]
    pub(super) fn scatter<S: Simd>(
        &self,
        tracer: &mut Tracer,
        streams: &mut Streams,
        vertices: &Vertices<S>,
        (active, smooth): (mask64x8<S>, mask64x8<S>),
        depth: u32,
        batch: &mut PathBatch,
    ) {
        let Vertices { illumination: Illumination { simd, receivers, .. }, paths, .. } = *vertices;
        vertices.direct(tracer, streams, smooth, batch);
        let is_last = depth + 1 >= self.max_depth;
        let may_find_light = !is_last || tracer.may_find_light();
        if !may_find_light && vertices.bodies.is_none() {
            return;
        }
        let mut sample = vertices.scattering.sample(streams.next_2d(simd), LobeFilter::All);
        if let Some(bodies) = vertices.bodies {
            bodies.enter(vertices, &mut sample, active, batch);
            if !may_find_light {
                return;
            }
        }
        let mut scattered = vertices.scattered(&sample, active);
        scattered.eta_scale = paths.eta_scale * sample.radiance_scale;
        if is_last {
            self.lighting.look_for_emission((simd, tracer), &scattered, receivers, batch);
            return;
        }
        if !roulette(self.max_depth).is_empty() {
            self.roulette(simd, streams, &mut scattered, depth);
        }
        batch.branch(0).0.push(&scattered, receivers);
    }

    /// Plays Russian roulette, and ends paths.
    #[inline(always)]
    fn roulette<S: Simd>(&self, simd: S, streams: &mut Streams, paths: &mut PathRecord<S>, depth: u32) {
        let PathRecord { throughput, eta_scale, .. } = paths;
        let mut asked = 0;
        if depth + 1 > FIRST_ROULETTE {
            for lane in set_lanes(paths.active) {
                let strength = f64::from(throughput.lane(lane).max_element() / eta_scale[lane]);
                asked |= u64::from(strength < self.roulette_threshold) << lane;
            }
        }
        let numbers = streams.next_1d(simd);
        let mut ended = 0;
        for lane in set_lanes(bits(simd, asked)) {
            let own = throughput.lane(lane);
            let end = (1.0 - f64::from(own.max_element() / eta_scale[lane])).max(0.05);
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
            let drawn = |has_bodies: bool| -> u32 {
                let all = dimensions(max_depth, lights, LightChoice::Spatial, has_bodies);
                all.iter().map(|used| used.count).sum()
            };
            assert_eq!((drawn(false), numbers(max_depth)), (expected, expected));
            assert_eq!(drawn(true), 2 * expected + PROBE_NUMBERS);
        }
    }
}
