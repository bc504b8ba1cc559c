//! Traces the rays that a profiler has recorded again, with nothing in between.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::Simd;
use glam::{DVec3, Vec3};

use super::profiler::{Calls, Profiler, STAGES, Stage, StageProfile};
use super::world::{Tracer, World};
use crate::light::LightTable;
use crate::number::{set_lanes, side_by_side};
use crate::traceable::Traceable;

/// Traces rays as the renderer does, and says how long that takes.
#[inline(never)]
fn trace<S: Simd>(simd: S, calls: &Calls<S>, world: &World, tracer: &mut Tracer, stage: Stage) -> Duration {
    // Copying brings the rays into the cache, as far as they fit.
    let calls = calls.clone();
    let started = Instant::now();
    for (rays, active) in &calls {
        match stage {
            Stage::CameraRays => drop(black_box(world.nearest_of(simd, tracer, rays, active))),
            Stage::BounceRays => drop(black_box(world.nearest(simd, tracer, &rays[0], active[0]))),
            _ => {
                black_box(world.occluded(simd, tracer, &rays[0], active[0], stage == Stage::ShadowRays));
            }
        }
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
            if let Some(calls) = &calls[stage as usize] {
                sum.alone += side_by_side!(level, simd => {
                    let calls = calls.downcast_ref::<Calls<_>>();
                    calls.map_or(Duration::ZERO, |calls| trace(simd, calls, &world, &mut tracer, stage))
                });
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
    let mut found = Vec::new();
    for calls in
        [Stage::CameraRays, Stage::BounceRays].iter().filter_map(|it| profiler.calls[*it as usize].as_ref())
    {
        side_by_side!(level, simd => {
            let packets = calls.downcast_ref::<Calls<_>>().into_iter().flatten();
            for (rays, active) in packets.flat_map(|(rays, active)| rays.iter().zip(active)) {
                let hits = world.nearest(simd, &mut tracer, rays, *active);
                for lane in set_lanes(*active) {
                    let (ray, hit) = world.one(rays, &hits, lane);
                    let primitive = hit.map(|hit| hit.element.primitive);
                    let finds_light = hit.is_some_and(|hit| tracer.emitted(&ray, &hit, true) != Vec3::ZERO);
                    found.push(Segment { from: ray.o, primitive, finds_light });
                }
            }
        });
    }
    found
}
