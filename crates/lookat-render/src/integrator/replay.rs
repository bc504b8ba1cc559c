//! The rays of a rendering, traced again with nothing in between.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::Simd;

use super::profiler::{Calls, Profiler, STAGES, Stage, StageProfile};
use super::tracer::Tracer;
use super::world::World;
use crate::light::LightTable;
use crate::number::side_by_side;
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
            _ => drop(black_box(world.met(simd, tracer, &rays[0], (active[0], stage == Stage::ShadowRays)))),
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
