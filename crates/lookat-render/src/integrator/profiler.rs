//! The time that each stage of rendering takes: a clock, and a record of the rays, which are traced again on their own.

use std::any::Any;
use std::hint::black_box;
use std::time::{Duration, Instant};

use fearless_simd::{Simd, mask64x8};
use glam::{DVec3, Vec3};

use super::world::{Tracer, World};
use crate::light::LightTable;
use crate::number::{count, set_lanes, side_by_side};
use crate::trace::rays::Rays;
use crate::traceable::Traceable;

/// The stages and their names.
macro_rules! stages {
    ($($stage:ident $name:literal,)*) => {
        /// A part of the work.
        #[derive(Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Stage {
            $($stage,)*
        }

        pub(super) const STAGES: [(Stage, &str); [$($name),*].len()] = [$((Stage::$stage, $name),)*];
    };
}

stages! {
    Camera "camera",
    CameraRays "camera rays",
    Shading "shading",
    Lights "lights",
    ShadowRays "shadow rays",
    Scattering "scattering",
    BounceRays "bounce rays",
    SkyRays "sky rays",
    Film "film",
}

/// The cost of a stage of a rendering on one thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageProfile {
    /// The name of the stage.
    pub name: &'static str,
    /// The time of the stage, without the recording of rays.
    pub time: Duration,
    /// Rays of a stage that traces, surfaces that are shaded; 0 of other stages.
    pub lanes: u64,
    /// Groups of eight lanes, also those in which no lane has any.
    pub batches: u64,
    /// The time of its rays when they are traced again with nothing in between. 0 for stages that do not trace.
    pub alone: Duration,
}

impl StageProfile {
    /// This stage and another one together.
    pub fn with(self, other: &StageProfile) -> StageProfile {
        StageProfile {
            name: self.name,
            time: self.time + other.time,
            lanes: self.lanes + other.lanes,
            batches: self.batches + other.batches,
            alone: self.alone + other.alone,
        }
    }
}

/// Measures the stages of a tile.
pub(crate) struct Profiler {
    stage: Stage,
    since: Instant,
    /// The stage to which a stage that traces returns.
    caller: Stage,
    pub(super) stages: [StageProfile; STAGES.len()],
    /// The [`Calls`] of each stage that has traced.
    pub(super) calls: [Option<Box<dyn Any + Send>>; STAGES.len()],
}

/// Packets that were traced together, in order, and which of their rays were active.
pub(super) type Calls<S> = Vec<(Vec<Rays<S>>, Vec<mask64x8<S>>)>;

impl Profiler {
    /// Starts the clock.
    pub fn new() -> Self {
        let stages = STAGES.map(|(_, name)| StageProfile { name, ..StageProfile::default() });
        let (stage, since) = (Stage::Film, Instant::now());
        Profiler { stage, since, caller: stage, stages, calls: Default::default() }
    }

    /// Ends a stage, and begins another one.
    #[cold]
    #[inline(never)]
    pub fn enter(&mut self, stage: Stage) {
        let now = Instant::now();
        self.stages[self.stage as usize].time += now - self.since;
        (self.stage, self.since) = (stage, now);
    }

    /// Counts a group of this stage.
    pub fn count(&mut self, lanes: u64) {
        let own = &mut self.stages[self.stage as usize];
        (own.lanes, own.batches) = (own.lanes + lanes, own.batches + 1);
    }

    /// Begins a stage that traces, and keeps its rays. The clock stands still meanwhile.
    #[cold]
    #[inline(never)]
    pub fn begin_rays<S: Simd>(&mut self, stage: Stage, rays: &[Rays<S>], active: &[mask64x8<S>]) {
        self.caller = self.stage;
        self.enter(stage);
        for active in active {
            self.count(count(*active));
        }
        let calls = self.calls[stage as usize].get_or_insert_with(|| Box::new(Calls::<S>::new()));
        if let Some(calls) = calls.downcast_mut::<Calls<S>>() {
            calls.push((rays.to_vec(), active.to_vec()));
        }
        self.since = Instant::now();
    }

    pub fn end_rays(&mut self) {
        self.enter(self.caller);
    }
}

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
            _ => drop(black_box(world.occluded(
                simd,
                tracer,
                &rays[0],
                (active[0], stage == Stage::ShadowRays),
            ))),
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
