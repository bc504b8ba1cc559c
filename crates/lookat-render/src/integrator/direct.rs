//! Direct lighting (PBR 14.3), by way of mirrors and glass too, at less than `max_depth` surfaces in a row.
//!
//! At glass both the reflected and the refracted ray are followed, as in pbrt-v3; but of a path that has become a small part of its
//! sample one is chosen, at the same mean.

use fearless_simd::{Simd, mask32x8, prelude::*};
use lookat_scene::{DirectStrategy, LightChoice};

use super::SampleDimensions;
use super::profiler::Stage;
use crate::bsdf::{BsdfSample, LobeFilter};
use crate::camera::Viewer;
use crate::integrator::lighting::{LightSamples, Lighting, directions, most_samples};
use crate::integrator::path_batch::{BatchSurface, PathBatch, ScatteredPaths};
use crate::integrator::path_record::PathRecord;
use crate::integrator::vertices::{Scattering, Vertices};
use crate::integrator::world::{Sees, Tracer, World};
use crate::light::LightTable;
use crate::number::{narrow, splat_f32, vectorized, widen};
use crate::sampler::Streams;

/// The light sampler for one light per surface. pbrt-v3 uses equal probabilities.
pub(crate) const CHOICE: LightChoice = LightChoice::Spatial;

/// A path is followed into all single directions if the share of each in its sample is more than this. A sample has shares of 1 in all,
/// which directions have in proportion to what they scatter: so it has less than a thousand paths. What glass reflects twice is followed.
const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// The surfaces at which paths may branch: each needs memory for its branches.
const MOST_BRANCHED: u32 = 32;

/// The sample dimensions at each of `depth` surfaces with these lights. `is_specular`: some material has delta lobes.
pub(crate) fn dimensions(
    table: &LightTable,
    strategy: DirectStrategy,
    depth: u32,
    is_specular: bool,
) -> Vec<SampleDimensions> {
    // A sky that is not sampled gives its samples to directions, so that the sum is the same for all surfaces.
    let eligible = table.eligible(false);
    let extended = (0..eligible).filter(|light| !table.is_delta(*light));
    let chosen = table.chosen_triangles(strategy);
    let (choices, samples, scattered) = match strategy {
        DirectStrategy::All | DirectStrategy::EachOnce => (
            u32::from(chosen > 0),
            total(extended.map(|light| table.samples(light, strategy).saturating_mul(table.parts(light))))
                .saturating_add(chosen),
            directions(table, LightSamples::Each(strategy), false),
        ),
        DirectStrategy::One => {
            let has_extended = u32::from(table.has_extended());
            (u32::from(table.is_choice(CHOICE)), has_extended, has_extended)
        }
    };
    let mut dimensions = Vec::new();
    let mut add = |purpose, count| {
        dimensions.extend((count > 0).then_some(SampleDimensions { purpose, count, surfaces: 0..depth }))
    };
    add("light choice", choices);
    add("lights", samples.saturating_mul(2));
    add("direction", scattered.saturating_add(u32::from(is_specular)).saturating_mul(2));
    dimensions
}

/// A scene with direct lighting.
pub(crate) struct Direct<'s> {
    pub(super) lighting: Lighting<'s>,
    /// The number of sample dimensions for the light at a surface.
    numbers: u32,
    /// True if one BSDF direction is sampled beside the light.
    has_direction: bool,
    max_depth: u32,
}

impl<'s> Direct<'s> {
    pub fn new(world: World<'s>, lights: &'s LightTable, strategy: DirectStrategy, max_depth: u32) -> Self {
        let is_one = strategy == DirectStrategy::One;
        let sampled = if is_one { LightSamples::One(CHOICE) } else { LightSamples::Each(strategy) };
        let lighting = Lighting::new(world, lights, sampled, LobeFilter::NonDelta);
        let (numbers, has_direction) = (numbers(lights, strategy), is_one && lights.has_extended());
        Direct { lighting, numbers, has_direction, max_depth }
    }

    /// The most surfaces of a path with direct light.
    pub fn surfaces(&self) -> u32 {
        self.max_depth.max(1)
    }

    /// The number of sample dimensions at a surface, for its light and for the delta direction that continues the path.
    pub fn numbers(&self) -> u32 {
        self.numbers.saturating_add(2)
    }

    /// Adds direct light to the paths of a batch at a surface, and continues the paths along delta directions.
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
            if tracer.is_stopped {
                return;
            }
            let Lighting { world, .. } = &self.lighting;
            self.lighting.trace_waiting(simd, tracer, batch);
            for branch in 0..batch.branches() {
                let (ScatteredPaths { paths, .. }, radiance) = batch.branch(branch);
                let all = paths.all();
                if all != 0 {
                    world.nearest(simd, tracer, &paths.rays, all, &mut paths.hits);
                    world.add_emitted(simd, tracer, paths, Sees::Materials, radiance);
                    world.continue_paths(simd, tracer, paths, Sees::Materials, radiance);
                }
            }
        });
    }

    /// Shades a packet of paths, and samples its lights and the delta directions that continue the paths.
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
                    let smooth = paths.active & bsdf.has(LobeFilter::NonDelta);
                    if smooth.any_true() {
                        vertices.direct(tracer, streams, smooth, batch);
                        if self.has_direction {
                            let u = streams.next_2d(simd);
                            vertices.by_direction(tracer, u, smooth, batch);
                        }
                    } else {
                        streams.skip(self.numbers);
                        tracer.profile(|profiler| profiler.enter(Stage::Scattering));
                    }
                    let specular = paths.active & bsdf.has(LobeFilter::Delta);
                    if depth + 1 >= self.max_depth || !specular.any_true() {
                        return;
                    }
                    let (share, mut delta_samples) = (paths.share, bsdf.delta_samples());
                    let mut least = share;
                    for sample in &delta_samples {
                        let own = narrow(sample.is_valid);
                        least = own.select(least.min(share * sample.pdf), least);
                    }
                    let is_branched =
                        least.simd_gt(LEAST_SHARE) & mask32x8::splat(simd, depth < MOST_BRANCHED);
                    let chosen = specular & !widen(is_branched);
                    if let Some(first) = delta_samples.first_mut().filter(|_| chosen.any_true()) {
                        let sample = bsdf.sample(streams.next_2d(simd), LobeFilter::Delta);
                        *first =
                            BsdfSample { pdf: splat_f32(simd, 1.0), ..sample }.keep_where(chosen, *first);
                    }
                    for (branch, sample) in delta_samples.iter().enumerate() {
                        // The first holds what is chosen, too.
                        let own = if branch == 0 { specular } else { specular & !chosen };
                        let mut scattered = vertices.scattered(sample, own);
                        if !scattered.active.any_true() {
                            continue;
                        }
                        scattered.share = share * sample.pdf;
                        batch.branch(branch).0.paths.push(&scattered);
                    }
                },
            );
        })
    }
}

/// The number of sample dimensions for the light at a surface.
fn numbers(table: &LightTable, strategy: DirectStrategy) -> u32 {
    if strategy == DirectStrategy::One {
        return 3 + if table.has_extended() { 2 } else { 0 };
    }
    let extended = (0..table.len()).filter(|light| !table.is_delta(*light));
    let sampled = extended.filter(|light| table.samples(*light, strategy) > 0);
    // The samples of a part, and the triangles that are chosen, are nested.
    let pairs = total(sampled.map(|light| table.parts(light)))
        .saturating_add(u32::from(most_samples(table, strategy) > 0));
    pairs.saturating_mul(2).saturating_add(if table.chosen_triangles(strategy) > 0 { 3 } else { 0 })
}

fn total(counts: impl Iterator<Item = u32>) -> u32 {
    counts.fold(0, u32::saturating_add)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use crate::render::{Settings, render};
    use crate::testing::scene;

    const INTEGRATORS: [&str; 3] =
        ["\"whitted\"", "\"directlighting\"", "\"directlighting\" \"string strategy\" \"one\""];

    /// The largest and the smallest pixel of a scene with one sample in each.
    fn extremes(integrator: &str, world: &str) -> [f32; 2] {
        let scene = scene(&format!(
            "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
             Camera \"perspective\" \"float fov\" 1 Sampler \"sobol\" \"integer pixelsamples\" 1
             Integrator {integrator} WorldBegin {world} WorldEnd"
        ));
        let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
        let pixels = rendered.image.channels[0].samples.iter().copied();
        [pixels.clone().fold(f32::MIN, f32::max), pixels.fold(f32::MAX, f32::min)]
    }

    /// Between two lamps of radiance 1, one sample sees both: 0.04 reflected, and 0.96 refracted out of a medium of index 1.5.
    #[test]
    fn one_sample_follows_reflection_and_refraction() {
        let square = |z: i32| {
            format!(
                "Shape \"trianglemesh\" \"integer indices\" [0 2 1 0 3 2]
                 \"point P\" [-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z}] "
            )
        };
        let lamp =
            "Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\" \"bool twosided\" \"true\" ";
        let world = format!("Material \"glass\" {} {lamp} {} {}", square(1), square(2), square(-1));
        for integrator in INTEGRATORS {
            for found in extremes(integrator, &world) {
                let expected = 0.04 + 0.96 / 2.25;
                assert!((found - expected).abs() < 1e-3, "{integrator}: {expected} {found}");
            }
        }
    }

    /// A point of a floor under squares that are far away, small, and unlike each other: each sample has the light of all, or nearly if
    /// there are many.
    #[test]
    fn each_sample_has_the_light_of_all_triangles() {
        for (count, integrators, limit) in [(10, &INTEGRATORS[..], 1.05), (100, &INTEGRATORS[..2], 1.5)] {
            let (mut indices, mut points) = (String::new(), String::new());
            for i in 0..count {
                let [x, z] = [0.75, 0.57].map(|step| 100.0 * (f64::from(i) * step).fract() - 50.0);
                let (y, half) = (20.0 + f64::from(i * 7 % 10) * 8.0, 0.1 + 0.1 * f64::from(i % 3));
                for [dx, dz] in [[-half, -half], [half, -half], [half, half], [-half, half]] {
                    points += &format!("{} {y} {} ", x + dx, z + dz);
                }
                indices += &[0, 1, 2, 0, 2, 3].map(|corner| (4 * i + corner).to_string() + " ").concat();
            }
            let world = format!(
                "AttributeBegin Translate 0 0 1 Material \"matte\" Shape \"disk\" \"float radius\" 9 AttributeEnd
                 Rotate -90 1 0 0 AreaLightSource \"diffuse\" \"rgb L\" [1e3 1e3 1e3] \"bool twosided\" \"true\"
                 Shape \"trianglemesh\" \"integer indices\" [{indices}] \"point P\" [{points}]"
            );
            for integrator in integrators {
                let [most, least] = extremes(integrator, &world);
                assert!(least > 0.0 && most / least < limit, "{count} {integrator}: {most} {least}");
            }
        }
    }

    /// Glass under an even sky is invisible: the branches of each sample, followed or chosen, have all of its light. There are 2^100
    /// ways.
    #[test]
    fn branches_are_bounded_and_lose_no_light() {
        let world = "LightSource \"infinite\" Material \"glass\" ".to_string()
            + &"Translate 0 0 3 Shape \"sphere\" ".repeat(8);
        for integrator in INTEGRATORS {
            for found in extremes(&format!("{integrator} \"integer maxdepth\" 100"), &world) {
                assert!((found - 1.0).abs() < 2e-3, "{integrator}: {found}");
            }
        }
    }
}
