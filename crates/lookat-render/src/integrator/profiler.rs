//! The time that each stage of rendering takes: a clock, and a record of the rays.

use std::time::{Duration, Instant};

use crate::number::eights;
use crate::trace::rays::RayColumns;

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
    /// For each stage that traces, the rays of each call, in order, and which of them were active.
    pub(super) calls: [Vec<(RayColumns, u64)>; STAGES.len()],
}

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
    pub fn begin_rays(&mut self, stage: Stage, rays: &RayColumns, active: u64) {
        self.caller = self.stage;
        self.enter(stage);
        for (_, eight) in eights(active) {
            self.count(eight.count_ones().into());
        }
        self.calls[stage as usize].push((rays.clone(), active));
        self.since = Instant::now();
    }

    pub fn end_rays(&mut self) {
        self.enter(self.caller);
    }
}
