//! A clock for the stages of a rendering, and a record of its rays, to trace them again with nothing in between.

use std::any::Any;
use std::hint::black_box;
use std::ops::Range;
use std::time::{Duration, Instant};

use fearless_simd::{Level, Simd, mask64x8};

use super::tracer::Tracer;
use super::world::World;
use crate::light::LightTable;
use crate::number::{count, side_by_side};
use crate::trace::rays::Rays;
use crate::traceable::Traceable;

/// A part of the work.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    Camera,
    CameraRays,
    Shading,
    Lights,
    ShadowRays,
    Scattering,
    BounceRays,
    SkyRays,
    Film,
}

const STAGES: [(Stage, &str); 9] = [
    (Stage::Camera, "camera"),
    (Stage::CameraRays, "camera rays"),
    (Stage::Shading, "shading"),
    (Stage::Lights, "lights"),
    (Stage::ShadowRays, "shadow rays"),
    (Stage::Scattering, "scattering"),
    (Stage::BounceRays, "bounce rays"),
    (Stage::SkyRays, "sky rays"),
    (Stage::Film, "film"),
];

/// What a stage of a rendering takes on one thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct StageProfile {
    /// Its name.
    pub name: &'static str,
    /// The time from its beginnings to those of the next stages.
    pub time: Duration,
    /// Rays of a stage that traces, surfaces that are shaded; 0 of other stages.
    pub lanes: u64,
    /// Groups of up to eight of them.
    pub batches: u64,
    /// How long its rays take when they are traced again with nothing in between; 0 of stages that do not trace.
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
    stages: [StageProfile; STAGES.len()],
    /// The [`Record`] of each stage that has traced.
    records: [Option<Box<dyn Any + Send>>; STAGES.len()],
}

/// Rays in the order in which they were traced.
struct Record<S: Simd> {
    /// Which packets go together.
    calls: Vec<Range<usize>>,
    rays: Vec<Rays<S>>,
    active: Vec<mask64x8<S>>,
}

impl Profiler {
    /// Starts the clock.
    pub fn new() -> Self {
        let (stage, caller) = (Stage::Film, Stage::Film);
        let stages = STAGES.map(|(_, name)| StageProfile { name, ..StageProfile::default() });
        Profiler { stage, caller, since: Instant::now(), stages, records: Default::default() }
    }

    /// Ends a stage, and begins another one.
    #[cold]
    #[inline(never)]
    pub fn enter(&mut self, stage: Stage) {
        let now = Instant::now();
        self.stages[self.stage as usize].time += now - self.since;
        (self.stage, self.since) = (stage, now);
    }

    pub fn end_rays(&mut self) {
        self.enter(self.caller);
    }

    pub fn count(&mut self, stage: Stage, lanes: u64) {
        let StageProfile { lanes: own, batches, .. } = &mut self.stages[stage as usize];
        (*own, *batches) = (*own + lanes, *batches + 1);
    }

    /// Begins a stage that traces. The record takes no time of any stage.
    #[cold]
    #[inline(never)]
    pub fn begin_rays<S: Simd>(&mut self, stage: Stage, rays: &[Rays<S>], active: &[mask64x8<S>]) {
        self.caller = self.stage;
        self.enter(stage);
        active.iter().for_each(|active| self.count(stage, count(*active)));
        let new = || Box::new(Record::<S> { calls: Vec::new(), rays: Vec::new(), active: Vec::new() }) as _;
        if let Some(record) = self.records[stage as usize].get_or_insert_with(new).downcast_mut::<Record<S>>()
        {
            let from = record.rays.len();
            record.calls.push(from..from + rays.len());
            record.rays.extend_from_slice(rays);
            record.active.extend_from_slice(active);
        }
        self.since = Instant::now();
    }
}

impl<S: Simd> Record<S> {
    /// Traces the rays of a stage as the renderer does, and says how long that takes.
    #[inline(never)]
    fn trace(&self, simd: S, world: &World, tracer: &mut Tracer, stage: Stage) -> Duration {
        // A copy is in the cache, as the rays of the renderer are.
        let (rays, active) = (self.rays.clone(), self.active.clone());
        let started = Instant::now();
        for call in &self.calls {
            let (rays, active) = (&rays[call.clone()], &active[call.clone()]);
            match stage {
                Stage::CameraRays => drop(black_box(world.nearest_of(simd, tracer, rays, active))),
                Stage::BounceRays => drop(black_box(world.nearest(simd, tracer, &rays[0], active[0]))),
                _ => {
                    let is_shadow = stage == Stage::ShadowRays;
                    black_box(world.met(simd, tracer, &rays[0], (active[0], is_shadow)));
                }
            }
        }
        started.elapsed()
    }
}

/// The stages of all tiles together, with their rays traced again.
pub(crate) fn sum(profilers: &[Profiler], scene: &Traceable, lights: &LightTable) -> Vec<StageProfile> {
    let (world, level, mut tracer) = (World::new(scene), Level::new(), Tracer::new(scene, lights));
    let of = |(stage, name)| {
        let mut sum = StageProfile { name, ..StageProfile::default() };
        for Profiler { stages, records, .. } in profilers {
            sum = sum.with(&stages[stage as usize]);
            if let Some(record) = &records[stage as usize] {
                sum.alone += side_by_side!(level, simd => {
                    let record = record.downcast_ref::<Record<_>>();
                    record.map_or(Duration::ZERO, |record| record.trace(simd, &world, &mut tracer, stage))
                });
            }
        }
        sum
    };
    STAGES.map(of).into()
}
