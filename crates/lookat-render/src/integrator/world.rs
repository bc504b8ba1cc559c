//! Traces packets of rays, counts them, and stops when the time is over.

use fearless_simd::{Simd, prelude::*};
use glam::Vec3;

use super::path_record::{PATHS, PathRecord};
use super::profiler::{Profiler, Stage};
use crate::bsdf::LobeSlots;
use crate::camera::Views;
use crate::frame::Frames;
use crate::light::LightTable;
use crate::medium::Media;
use crate::number::{LANES, bits, eights, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::shading::{Materials, Shaded, Sheets};
use crate::surface::Surface;
use crate::trace::{
    Coherence, List, PacketCount, Tree, WideTracer,
    rays::{HitColumns, Hits, RayColumns, Rays},
};
use crate::traceable::Traceable;

/// The emitters whose light rays see directly.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sees {
    Nothing,
    /// Emitters except surfaces without a material.
    Materials,
    All,
}

/// A world in which packets of rays are traced and shaded.
pub(crate) struct World<'s> {
    pub materials: Materials<'s>,
    /// The media, if there are any.
    pub media: Option<Media<'s>>,
    aggregate: Aggregate<'s>,
}

enum Aggregate<'s> {
    List(List<'s>, Sheets<'s>),
    Tree(Tree<'s>),
}

impl<'s> World<'s> {
    pub fn new(traceable: &'s Traceable) -> Self {
        let materials = Materials::new(traceable);
        let list = List::new(traceable).filter(|_| !materials.has_passed);
        let list = list.and_then(|list| Some((Sheets::new(traceable, &list)?, list)));
        let aggregate = match list {
            Some((sheets, list)) => Aggregate::List(list, sheets),
            None => Aggregate::Tree(Tree { scene: traceable }),
        };
        World { materials, media: Media::new(traceable), aggregate }
    }

    /// True if rays traverse the BVH.
    pub fn uses_bvh(&self) -> bool {
        matches!(self.aggregate, Aggregate::Tree(_))
    }

    /// Finds the nearest hits of active camera rays; each bit of `active` is a ray.
    #[inline(never)]
    pub fn nearest_of_camera<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) {
        vectorized!(simd, {
            tracer.begin_rays(Stage::CameraRays, rays, active);
            hits.clear();
            let (all, mut from) = ((u64::BITS - active.leading_zeros()).div_ceil(LANES as u32) as usize, 0);
            while from < all {
                let mut count = all - from;
                if let Aggregate::Tree(tree) = &self.aggregate {
                    let packets = tracer.packet_count.next(count);
                    if packets > 0 {
                        let coherence = tree.nearest_of(simd, rays, from..from + packets, active, hits);
                        tracer.packet_count.learn(packets, coherence);
                        if coherence != Coherence::Low {
                            from += packets;
                            continue;
                        }
                        if packets > 1 {
                            continue;
                        }
                    }
                    count = 1 + tracer.packet_count.apart(count - 1);
                }
                let own = u64::MAX >> (u64::BITS as usize - LANES * count) << (LANES * from);
                self.search(simd, tracer, rays, active & own, hits);
                from += count;
            }
            tracer.profile(Profiler::end_rays);
        })
    }

    /// Finds the nearest hits of active rays that continue paths; each bit of `active` is a ray.
    pub fn nearest<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) {
        self.nearest_as(simd, tracer, Stage::BounceRays, rays, active, hits);
    }

    /// Finds the nearest hits of active rays; each bit of `active` is a ray.
    #[inline(never)]
    pub(super) fn nearest_as<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        stage: Stage,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) {
        tracer.begin_rays(stage, rays, active);
        hits.clear();
        self.search(simd, tracer, rays, active, hits);
        tracer.profile(Profiler::end_rays);
    }

    /// Finds nearest hits without counting rays.
    #[inline(never)]
    fn search<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) {
        vectorized!(simd, {
            match &self.aggregate {
                Aggregate::List(list, _) => list.nearest(simd, rays, active, hits),
                Aggregate::Tree(tree) => tree.nearest(simd, &mut tracer.wide, rays, active, hits),
            }
        })
    }

    /// The active rays that hit anything but their targets; each bit is a ray. `is_shadow`: these are shadow rays, which may pass other
    /// holes.
    #[inline(never)]
    pub fn occluded<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &RayColumns,
        active: u64,
        is_shadow: bool,
    ) -> u64 {
        vectorized!(simd, {
            let stage = if is_shadow { Stage::ShadowRays } else { Stage::SkyRays };
            tracer.begin_rays(stage, rays, active);
            let met = match &self.aggregate {
                Aggregate::List(list, _) => list.occluded(simd, rays, active, is_shadow),
                Aggregate::Tree(tree) => tree.occluded(simd, &mut tracer.wide, rays, active, is_shadow),
            };
            tracer.profile(Profiler::end_rays);
            met
        })
    }

    /// Finds what rays see that only look for emission. Returns the rays that may see any. Rays that cannot hit an emitter are only tested
    /// for occlusion of the sky.
    #[inline(never)]
    pub fn find_emission<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        rays: &RayColumns,
        active: u64,
        hits: &mut HitColumns,
    ) -> u64 {
        vectorized!(simd, {
            let mut may_hit = 0;
            for (first, own) in eights(active) {
                let rays = rays.eight(simd, first);
                may_hit |= (tracer.scene.emitters.may_be_hit(simd, &rays).to_bitmask() & own) << first;
            }
            let others = active & !may_hit;
            if may_hit != 0 {
                self.nearest(simd, tracer, rays, may_hit, hits);
            } else {
                hits.clear();
            }
            if !tracer.lights.has_skies() || others == 0 {
                return may_hit;
            }
            may_hit | others & !self.occluded(simd, tracer, rays, others, false)
        })
    }

    /// The surfaces at the hits, with the lobes of materials without textures. At least one ray has a hit.
    #[inline(never)]
    pub fn plain<'m, S: Simd>(
        &'m self,
        simd: S,
        PathRecord { rays, hits, active, .. }: &PathRecord<S>,
        slots: &mut LobeSlots<'m, S>,
    ) -> Shaded<S> {
        vectorized!(simd, {
            let is_hit = hits.is_hit() & *active;
            let found = match &self.aggregate {
                Aggregate::List(_, sheets) => sheets.at(simd, (rays, hits), is_hit),
                Aggregate::Tree(tree) => tree.at(simd, (rays, hits), is_hit),
            };
            let is_open = self.materials.lobes(simd, &found.elements, is_hit, slots);
            Shaded { found, frames: Frames::from_z(found.surfaces.ns.narrow()), is_open }
        })
    }

    /// The surfaces at the hits, with all lobes. At least one ray has a hit. `views`: the camera samples, if these are
    /// camera rays.
    #[inline(always)]
    pub fn shaded<'m, S: Simd>(
        &'m self,
        simd: S,
        tracer: &Tracer<'m>,
        paths: &PathRecord<S>,
        views: Option<&Views>,
        slots: &mut LobeSlots<'m, S>,
    ) -> Shaded<S> {
        let mut shaded = self.plain(simd, paths, slots);
        if shaded.is_open.any_true() {
            shaded.paint(tracer.scene, paths.rays.d, views, slots);
        }
        shaded
    }

    /// The number of an element of the world in [`Hits::element`]. For [`ElementId::NONE`]: a number that no hit has.
    pub fn number(&self, element: ElementId) -> f64 {
        match &self.aggregate {
            Aggregate::List(list, _) => list.number(element),
            Aggregate::Tree(tree) => tree.number(element),
        }
    }

    /// One of the rays and its hit.
    pub fn one<S: Simd>(&self, rays: &Rays<S>, hits: &Hits<S>, lane: usize) -> (Ray, Option<Hit>) {
        let is_hit = hits.element[lane] >= 0.0;
        match &self.aggregate {
            Aggregate::List(list, _) => {
                let ray = Ray::new(rays.o.lane(lane), rays.d.lane(lane));
                (ray, is_hit.then(|| list.hit(hits, lane)))
            }
            Aggregate::Tree(tree) => (tree.ray(&rays.one(lane)), is_hit.then(|| tree.hit(hits, lane))),
        }
    }

    /// Continues rays straight through surfaces without a material. `add` receives the emission that delta rays see on
    /// their way.
    #[inline(always)]
    pub fn pass<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        paths: &mut PathRecord<S>,
        sees: Sees,
        mut add: impl FnMut(usize, Vec3),
    ) {
        if !self.materials.has_passed {
            return;
        }
        let (mut passed, mut escaped) = (0, 0);
        for lane in set_lanes(paths.active & paths.hits.is_hit()) {
            let (mut ray, mut found) = self.one(&paths.rays, &paths.hits, lane);
            let adds = sees != Sees::Nothing && paths.is_delta.to_bitmask() >> lane & 1 == 1;
            let scene = tracer.scene;
            let surfaces = pass_interfaces(
                scene,
                &mut ray,
                &mut found,
                |hit| scene.is_passed(hit),
                |ray, found| match found {
                    _ if !adds => {}
                    Some(hit) => add(lane, tracer.emitted(ray, hit, sees == Sees::All)),
                    None => escaped |= 1 << lane,
                },
            );
            tracer.rays += u64::from(surfaces.min(MAX_PASSED));
            if surfaces > 0 {
                passed |= 1 << lane;
                paths.rays.o.set_lane(lane, ray.o);
                paths.hits.set_lane(lane, found.as_ref(), tracer.scene.labels);
            }
        }
        if escaped != 0 {
            let light = tracer.lights.background(simd, paths.rays.d);
            for lane in set_lanes(bits(simd, escaped)) {
                add(lane, light.lane(lane));
            }
        }
        paths.has_passed = bits(simd, passed);
    }
}

/// The most surfaces without a material that a ray passes through in a row.
pub(super) const MAX_PASSED: u32 = 1000;

/// Continues a ray straight through interfaces, surfaces that `passes` accepts, and returns their number. `see` receives the
/// ray and its nearest hit behind each.
pub(crate) fn pass_interfaces(
    scene: &Traceable,
    ray: &mut Ray,
    found: &mut Option<Hit>,
    passes: impl Fn(&Hit) -> bool,
    mut see: impl FnMut(&Ray, Option<&Hit>),
) -> u32 {
    let mut passed = 0;
    while let Some(hit) = found.filter(&passes) {
        *ray = Surface::new(scene, ray, &hit).spawn_ray(ray.d);
        passed += 1;
        if passed > MAX_PASSED {
            *found = None;
            break;
        }
        *found = scene.nearest(ray);
        see(ray, found.as_ref());
    }
    passed
}

/// Decides whether sampling continues.
pub(crate) trait Supervisor: Sync {
    /// False once sampling stops.
    fn should_continue(&self) -> bool;
}

/// The calls of [`Tracer::should_continue`] for each call of the supervisor: about a millisecond.
const STEPS: u32 = 1 << 10;

/// Traces rays and counts them.
pub(crate) struct Tracer<'s> {
    pub(super) scene: &'s Traceable,
    pub(super) lights: &'s LightTable,
    pub rays: u64,
    /// A number of each sample of a batch, for random numbers that no sampler gives.
    pub seeds: [u64; PATHS],
    /// The number of packets of camera rays that go together.
    pub packet_count: PacketCount,
    pub(super) wide: Box<WideTracer>,
    /// Called every [`STEPS`] steps.
    supervisor: Option<&'s dyn Supervisor>,
    steps: u32,
    /// True once sampling has been stopped: the samples of the current batch are not complete.
    pub is_stopped: bool,
    /// Set while the stages of a rendering are measured.
    pub profiler: Option<Box<Profiler>>,
}

impl<'s> Tracer<'s> {
    pub fn new(scene: &'s Traceable, lights: &'s LightTable) -> Self {
        Tracer {
            scene,
            lights,
            rays: 0,
            seeds: [0; PATHS],
            packet_count: PacketCount::LARGEST,
            wide: Box::new(WideTracer::new()),
            supervisor: None,
            steps: 0,
            is_stopped: false,
            profiler: None,
        }
    }

    /// The seeds of some samples of the batch.
    #[inline(always)]
    pub fn seeds_of(&self, samples: [u16; LANES]) -> [u64; LANES] {
        samples.map(|sample| self.seeds[usize::from(sample) % PATHS])
    }

    /// Lets a supervisor decide when sampling stops.
    pub fn supervised(self, supervisor: &'s dyn Supervisor) -> Self {
        Tracer { supervisor: Some(supervisor), ..self }
    }

    /// False once sampling stops. Called for each packet of rays, because the rays of one sample may take minutes.
    #[inline(always)]
    pub fn should_continue(&mut self) -> bool {
        self.steps += 1;
        if self.steps >= STEPS {
            self.ask_supervisor();
        }
        !self.is_stopped
    }

    #[cold]
    #[inline(never)]
    fn ask_supervisor(&mut self) {
        self.steps = 0;
        self.is_stopped |= self.supervisor.is_some_and(|supervisor| !supervisor.should_continue());
    }

    /// Calls a function with the profiler, if there is one.
    #[inline(always)]
    pub fn profile(&mut self, does: impl FnOnce(&mut Profiler)) {
        if let Some(profiler) = &mut self.profiler {
            does(profiler);
        }
    }

    /// Counts the active rays before they are traced, and starts their stage.
    #[inline(always)]
    fn begin_rays(&mut self, stage: Stage, rays: &RayColumns, active: u64) {
        self.rays += u64::from(active.count_ones());
        self.profile(|profiler| profiler.begin_rays(stage, rays, active));
    }

    /// The surface at a hit of `ray`. Apart from the search for it, because large values are best not moved.
    #[inline]
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> Surface<'s> {
        Surface::new(self.scene, ray, hit)
    }

    /// The radiance that a hit surface emits towards the ray. `glows`: surfaces without a material count too.
    pub fn emitted(&self, ray: &Ray, hit: &Hit, glows: bool) -> Vec3 {
        let is_lit = self.scene.emits(hit) && (glows || !self.scene.is_passed(hit));
        if is_lit { self.surface(ray, hit).le(-ray.d) } else { Vec3::ZERO }
    }

    /// True if rays can find light: the scene has a sky, or a shape that emits.
    pub fn may_find_light(&self) -> bool {
        self.lights.has_skies() || !self.scene.emitters.is_empty()
    }
}
