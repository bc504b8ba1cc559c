//! Traces the rays that a profiler has recorded again, with nothing in between.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::Simd;
use glam::{DVec3, Vec3};

use super::profiler::{Profiler, STAGES, Stage, StageProfile};
use super::world::{Tracer, World};
use crate::columns::MOST;
use crate::light::LightTable;
use crate::number::{LANES, side_by_side};
use crate::trace::rays::{HitColumns, RayColumns};
use crate::traceable::Traceable;

/// Traces rays as the renderer does, and says how long that takes.
#[inline(never)]
fn trace<S: Simd>(
    simd: S,
    calls: &[(RayColumns, u64)],
    world: &World,
    tracer: &mut Tracer,
    stage: Stage,
) -> Duration {
    // Copying brings the rays into the cache, as far as they fit.
    let calls = calls.to_vec();
    let mut hits = HitColumns::new();
    let started = Instant::now();
    for (rays, active) in &calls {
        match stage {
            Stage::CameraRays => world.nearest_of_camera(simd, tracer, rays, *active, &mut hits),
            Stage::BounceRays => world.nearest(simd, tracer, rays, *active, &mut hits),
            _ => {
                let is_shadow = stage == Stage::ShadowRays;
                black_box(world.occluded(simd, tracer, rays, *active, is_shadow));
            }
        }
        black_box(&hits);
    }
    started.elapsed()
}

/// The stages of all tiles together, with their rays traced again.
pub(crate) fn stage_profiles(
    profilers: &[Profiler],
    scene: &Traceable,
    lights: &LightTable,
) -> Vec<StageProfile> {
    let (world, level, mut tracer) = (World::new(scene), scene.level, Tracer::new(scene, lights));
    let of = |(stage, name)| {
        let mut sum = StageProfile { name, ..StageProfile::default() };
        for Profiler { stages, calls, .. } in profilers {
            sum = sum.with(&stages[stage as usize]);
            let calls = &calls[stage as usize];
            if !calls.is_empty() {
                sum.alone += side_by_side!(level, simd => trace(simd, calls, &world, &mut tracer, stage));
            }
        }
        sum
    };
    STAGES.map(of).into()
}

/// A segment of a path, from the start of a ray to its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub from: DVec3,
    /// The number of the primitive that it has hit. `None` for a ray that leaves the world.
    pub primitive: Option<u32>,
    /// True if the ray sees emission of the surface it has hit.
    pub finds_light: bool,
}

/// The rays from the camera and from surfaces that a profiler has kept, in order.
pub(crate) fn segments(profiler: &Profiler, scene: &Traceable, lights: &LightTable) -> Vec<Segment> {
    let (world, level, mut tracer) = (World::new(scene), scene.level, Tracer::new(scene, lights));
    let (mut found, mut hits) = (Vec::new(), HitColumns::new());
    for (rays, active) in
        [Stage::CameraRays, Stage::BounceRays].iter().flat_map(|it| &profiler.calls[*it as usize])
    {
        side_by_side!(level, simd => {
            world.nearest(simd, &mut tracer, rays, *active, &mut hits);
            for at in (0..MOST).filter(|at| active >> at & 1 == 1) {
                let (first, lane) = (at / LANES * LANES, at % LANES);
                let (ray, hit) = world.one(&rays.eight(simd, first), &hits.eight(simd, first), lane);
                let primitive = hit.map(|hit| hit.element.primitive);
                let finds_light = hit.is_some_and(|hit| tracer.emitted(&ray, &hit, true) != Vec3::ZERO);
                found.push(Segment { from: ray.o, primitive, finds_light });
            }
        });
    }
    found
}
