//! Paths and shadow rays in participating media: where paths scatter or meet a surface with a material next, and how much light shadow rays
//! let through. Both cross the boundaries of media (PBR 15.3.1).

#[cfg(test)]
mod tests;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, prelude::*};
use glam::DVec3;

use super::lighting::Lighting;
use super::path_batch::{LightColumns, MediaBatch, MediaRoom, PathBatch, Radiance, ScatteredPaths};
use super::path_record::{PATHS, PathColumns, PathRecord};
use super::profiler::Stage;
use super::world::{MAX_PASSED, Tracer, World};
use crate::columns::Column;
use crate::medium::{EMPTY, Media, MediumNumber, MediumSamples, SampleNumbers};
use crate::number::{LANES, bits, eights, narrow, set_bits, set_lanes, vectorized};
use crate::ray::{ElementId, Hit, Ray};
use crate::sampler::Streams;
use crate::trace::rays::{HitColumns, OneRay, RayColumns};

/// What continues paths that scatter in media.
pub(super) struct Events<'e> {
    /// Those that have scattered.
    pub paths: &'e mut PathColumns,
    pub streams: &'e mut Streams,
    /// The number of surfaces before.
    pub depth: u32,
}

impl Lighting<'_> {
    /// Leads the traced paths of a batch to where they scatter next, in a medium or at a surface with a material, and adds the emission
    /// that they see on their way. `depth`: the number of surfaces before.
    pub fn advance<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        (streams, depth): (&mut Streams, u32),
        media: &Media,
        batch: &mut PathBatch,
    ) {
        let mut own = batch.in_media.take().unwrap_or_else(MediaBatch::new);
        let MediaBatch { events: paths, room } = &mut *own;
        paths.count = 0;
        let (scattered, radiance) = batch.branch(0);
        let events = Events { paths, streams, depth };
        self.lead(simd, tracer, media, (scattered, radiance), Some(events), room);
        batch.in_media = Some(own);
    }

    /// Does what [`Lighting::advance`] does. Without `events`, what paths would scatter is lost to them.
    #[inline(never)]
    pub fn lead<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        media: &Media,
        (scattered, radiance): (&mut ScatteredPaths, &mut Radiance),
        mut events: Option<Events>,
        MediaRoom { ahead, arrived }: &mut MediaRoom,
    ) {
        arrived.paths.count = 0;
        let mut numbered = 0;
        for _ in 0..MAX_PASSED {
            if scattered.paths.count == 0 {
                break;
            }
            // Whether paths scatter before or not: so emission has no noise of that.
            self.add_emission(simd, tracer, scattered, scattered.paths.all(), radiance);
            self.sample_media(simd, tracer, media, scattered, (&mut events, &mut numbered), ahead);
            scattered.paths.count = 0;
            let ahead_of_surfaces = self.cross(
                simd,
                tracer,
                media,
                ahead,
                (&mut *scattered, &mut *arrived),
                events.as_mut().map(|events| &mut *events.paths),
            );
            let (all, paths) = (scattered.paths.all(), &mut scattered.paths);
            if all != 0 {
                self.world.nearest(simd, tracer, &paths.rays, all, &mut paths.hits);
            }
            for (path, hit) in ahead_of_surfaces {
                paths.hits.set(path, &hit, tracer.scene.labels, tracer.scene.emits(&hit));
            }
        }
        std::mem::swap(scattered, arrived);
    }

    /// Samples where paths scatter before they get to the ends of their rays; without `events`, only attenuates them. `numbered`: bits of the
    /// samples whose paths have used the numbers that the sampler has for this way.
    #[inline(never)]
    fn sample_media<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        media: &Media,
        ScatteredPaths { paths, receivers }: &ScatteredPaths,
        (events, numbered): (&mut Option<Events>, &mut u64),
        ahead: &mut ScatteredPaths,
    ) {
        vectorized!(simd, {
            let own = &mut PathRecord::none(simd);
            ahead.paths.count = 0;
            for at in (0..paths.count).step_by(LANES) {
                paths.load(simd, at, paths.count, own);
                let (end, way) = (own.ends(), (&own.rays, own.medium));
                let seeds = tracer.seeds_of(own.samples);
                let MediumSamples { scatters, t, weight } = match events {
                    Some(Events { streams, depth, .. }) => {
                        let is_new = |lane: &usize| {
                            own.medium[*lane] != EMPTY && *numbered >> own.samples[*lane] & 1 == 0
                        };
                        let new = set_lanes(own.active).filter(is_new).fold(0, |new, lane| new | 1 << lane);
                        let mut first = [None; LANES];
                        if new != 0 {
                            streams.choose(simd, &own.samples, 0);
                            let [a, b] = streams.on_the_way(simd, *depth);
                            for lane in set_bits(new) {
                                first[lane] = Some([a[lane], b[lane]]);
                                *numbered |= 1 << own.samples[lane];
                            }
                        }
                        let numbers = &SampleNumbers { first, seeds };
                        media.sample(way, own.throughput, end, (own.active, numbers))
                    }
                    None => {
                        let weight = media.transmittance(way, end, (own.active, &seeds));
                        MediumSamples { scatters: bits(simd, 0), t: end, weight }
                    }
                };
                own.throughput = own.throughput * weight;
                own.active &= own.throughput.is_light();
                own.scatters = scatters;
                own.hits.t = t;
                // It is a hit of nothing.
                let element = own.hits.element;
                own.hits.element = scatters.select(element.max(0.0), element);
                let receivers = receivers.eight(simd, at, self.has_lunes);
                ahead.push_with_hits(own, &receivers);
            }
        });
    }

    /// Moves paths that have met surfaces without a material to behind these, and the others that go on to their vertices. Returns the
    /// crossing paths whose next hit is known: see [`Crossing::met`].
    #[inline(never)]
    fn cross<S: Simd>(
        &self,
        simd: S,
        tracer: &Tracer,
        media: &Media,
        ScatteredPaths { paths, receivers }: &ScatteredPaths,
        (crossing, arrived): (&mut ScatteredPaths, &mut ScatteredPaths),
        mut events: Option<&mut PathColumns>,
    ) -> ArrayVec<(usize, Hit), PATHS> {
        vectorized!(simd, {
            let (own, mut known) = (&mut PathRecord::none(simd), ArrayVec::new());
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, own);
                let receivers = receivers.eight(simd, first, self.has_lunes);
                let going_on = own.active & own.hits.is_hit();
                let mut crosses = 0_u64;
                for lane in set_lanes(going_on & !own.scatters) {
                    let (ray, Some(hit)) = self.world.one(&own.rays, &own.hits, lane) else { continue };
                    if tracer.scene.is_passed(&hit) {
                        let Crossing { o, medium, met } =
                            self.world.cross(tracer, media, (&ray, &hit), own.medium[lane]);
                        own.medium[lane] = medium;
                        own.rays.o.set_lane(lane, o);
                        let path = crossing.paths.count + crosses.count_ones() as usize;
                        known.extend(met.map(|hit| (path, hit)));
                        crosses |= 1 << lane;
                    }
                }
                let crosses = bits(simd, crosses);
                let before = own.rays;
                own.rays.leaving = crosses.select(own.hits.element, before.leaving);
                own.rays.leaving_instance =
                    narrow(crosses).select(own.hits.instance, before.leaving_instance);
                own.has_passed |= crosses;
                own.active = crosses;
                crossing.push(own, &receivers);
                own.active = going_on & !crosses & !own.scatters;
                arrived.push_with_hits(own, &receivers);
                if let Some(events) = &mut events {
                    own.active = going_on & own.scatters;
                    events.push_with_hits(own);
                }
            }
            known
        })
    }
}

/// A path or a shadow ray behind a surface without a material.
struct Crossing {
    /// Where it starts again.
    o: DVec3,
    /// The medium that it is in there.
    medium: MediumNumber,
    /// A surface with a material in the same place, which it hits next.
    met: Option<Hit>,
}

/// The most boundaries in one place that are told apart.
const MOST_TOUCHING: usize = 16;

/// A boundary that a ray crosses.
struct Boundary {
    /// The medium in front of it.
    from: MediumNumber,
    /// The medium behind it.
    to: MediumNumber,
    /// True if the ray comes from inside.
    is_exit: bool,
}

impl Boundary {
    /// The boundary at a hit of a ray in direction `d`, where the geometric normal is `n`. `None` if the media on its sides are not said.
    fn new(media: &Media, hit: &Hit, n: DVec3, d: DVec3) -> Option<Self> {
        let [inside, outside] = media.interface(hit.element.primitive)?;
        let is_exit = n.dot(d) > 0.0;
        let (from, to) = if is_exit { (inside, outside) } else { (outside, inside) };
        Some(Boundary { from, to, is_exit })
    }

    /// The medium behind boundaries in one place.
    fn cross_all(
        mut boundaries: ArrayVec<Boundary, MOST_TOUCHING>,
        mut medium: MediumNumber,
    ) -> MediumNumber {
        let next_of = |boundaries: &[Boundary], medium| boundaries.iter().position(|it| it.from == medium);
        // Where none begins in the medium, the scene contradicts itself. Then a ray leaves a medium before it enters another.
        let mut next = next_of(&boundaries, medium)
            .or_else(|| boundaries.iter().position(|it| it.is_exit))
            .or((!boundaries.is_empty()).then_some(0));
        while let Some(index) = next {
            medium = boundaries.remove(index).to;
            next = next_of(&boundaries, medium);
        }
        medium
    }
}

impl World<'_> {
    /// Leads a ray, which is in `medium` at its start, across a surface without a material that it hits.
    ///
    /// It starts again behind the surface, beyond all that touches it there; so whatever does is looked for first, and crossed too, in an
    /// order in which each boundary begins in the medium where the one before ends. A surface with a material is hit from the medium before.
    #[inline(never)]
    fn cross(
        &self,
        tracer: &Tracer,
        media: &Media,
        (ray, hit): (&Ray, &Hit),
        medium: MediumNumber,
    ) -> Crossing {
        let (scene, surface) = (tracer.scene, tracer.surface(ray, hit));
        let (before, behind) = (surface.spawn_ray(-ray.d).o, surface.spawn_ray(ray.d));
        // Across the surface: at a grazing angle, a way along the ray ends before it.
        let across = behind.o - before;
        let between = Ray { o: before, d: across.normalize(), t_max: across.length(), ..behind };
        let mut boundaries = ArrayVec::<_, MOST_TOUCHING>::new();
        boundaries.extend(Boundary::new(media, hit, surface.n, ray.d));
        for touching in scene.hits(&between).take(MOST_TOUCHING - 1) {
            if scene.is_passed(&touching) {
                let n = tracer.surface(&between, &touching).n;
                boundaries.extend(Boundary::new(media, &touching, n, between.d));
                continue;
            }
            let ahead = Ray { o: before, ..behind };
            let met = scene.hits(&ahead).take(MOST_TOUCHING).find(|hit| hit.element == touching.element);
            if met.is_some() {
                return Crossing { o: before, medium, met };
            }
        }
        Crossing { o: behind.o, medium: Boundary::cross_all(boundaries, medium), met: None }
    }

    /// Multiplies the light of shadow rays by what the media on their way let through. Returns the rays that no surface with a material
    /// blocks.
    #[inline(never)]
    pub(in crate::integrator) fn transmit<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        media: &Media,
        rays: &mut RayColumns,
        light: &mut LightColumns,
        all: u64,
    ) -> u64 {
        vectorized!(simd, {
            for t_max in rays.t_max.iter_mut().filter(|t_max| **t_max == f64::INFINITY) {
                *t_max = media.reach;
            }
            let is_target = |hit: &Hit, target: f64| {
                hit.element.instance == ElementId::WORLD && tracer.scene.labels.of(hit.element) == target
            };
            let (mut rest, mut free, mut hits) = (all, 0, HitColumns::new());
            for _ in 0..MAX_PASSED {
                if rest == 0 {
                    break;
                }
                self.nearest_as(simd, tracer, Stage::ShadowRays, rays, rest, &mut hits);
                for (first, own) in eights(rest) {
                    let (eight, found) = (rays.eight(simd, first), hits.eight(simd, first));
                    let (mut blocked, mut crossed) = (0, ArrayVec::<_, LANES>::new());
                    let mut end = eight.t_max.max(0.0);
                    for lane in set_bits(own) {
                        let (ray, hit) = self.one(&eight, &found, lane);
                        // The light itself is no obstacle.
                        let hit = hit.filter(|hit| !is_target(hit, eight.target[lane]));
                        match hit {
                            Some(hit) if tracer.scene.is_passed(&hit) => {
                                end[lane] = hit.t;
                                crossed.push((lane, ray, hit));
                            }
                            Some(_) => blocked |= 1 << lane,
                            None => {}
                        }
                    }
                    let medium = Column::load(simd, &light.medium[first..first + LANES]);
                    let going_on = bits(simd, own & !blocked);
                    let seeds = tracer.seeds_of(light.samples_from(first));
                    let shares = media.transmittance((&eight, medium), end, (going_on, &seeds));
                    let is_dark = !shares.is_light().to_bitmask();
                    for lane in set_lanes(going_on) {
                        let (at, share) = (first + lane, shares.lane(lane));
                        light.red[at] *= share.x;
                        light.green[at] *= share.y;
                        light.blue[at] *= share.z;
                    }
                    let mut open = 0;
                    for (lane, ray, hit) in crossed.into_iter().filter(|(lane, ..)| is_dark >> lane & 1 == 0)
                    {
                        let at = first + lane;
                        let Crossing { o, medium, met } =
                            self.cross(tracer, media, (&ray, &hit), light.medium[at]);
                        if let Some(met) = met {
                            blocked |= u64::from(!is_target(&met, eight.target[lane])) << lane;
                            continue;
                        }
                        light.medium[at] = medium;
                        let t_max = eight.t_max[lane] - (o - ray.o).dot(ray.d);
                        let (leaving, leaving_instance) = (found.element[lane], found.instance[lane]);
                        rays.set(at, &OneRay { o, t_max, leaving, leaving_instance, ..rays.one(at) });
                        open |= 1 << lane;
                    }
                    rest = rest & !(own << first) | open << first;
                    free |= (own & !blocked & !is_dark & !open) << first;
                }
            }
            free
        })
    }
}
