//! Paths that enter bodies in which light scatters, and leave them at other points (PBR 15.4).

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::{DVec3, Vec3};

use super::lighting::Lighting;
use super::path::Paths;
use super::path_batch::{BatchSurface, PathBatch};
use super::path_record::{PathColumns, PathRecord};
use super::profiler::Stage;
use super::vertices::Vertices;
use super::world::{MAX_PASSED, Tracer};
use crate::bsdf::{BsdfSample, Inside, LobeSlots};
use crate::bssrdf::{Body, Channels, Place, diffuse_transmittance};
use crate::frame::Frames;
use crate::number::{LANES, Vec3fx8, Vec3x8, bits, eights, set_bits, set_lanes, vectorized, widen};
use crate::sampler::Streams;
use crate::shading::{Materials, Shaded};
use crate::trace::rays::{HitColumns, NONE, OneRay, RayColumns};
use crate::traceable::Traceable;

/// The sample dimensions of a probe.
pub(super) const PROBE_NUMBERS: u32 = 3;

/// The bodies of a world.
pub(in crate::integrator) struct Bodies<'s> {
    /// Of each material.
    of_material: Vec<Option<Body<'s>>>,
}

impl<'s> Bodies<'s> {
    /// `None` for a world without any.
    pub fn new(materials: &Materials<'s>, traceable: &'s Traceable) -> Option<Self> {
        let of_material: Vec<_> =
            materials.all.iter().map(|material| Body::new(material, &traceable.tables)).collect();
        of_material.iter().any(Option::is_some).then_some(Bodies { of_material })
    }

    fn of(&self, entry: &Entry) -> Option<&Body<'s>> {
        self.of_material[entry.material as usize].as_ref()
    }

    /// The channels of a body where a path has entered it.
    fn channels<'a>(&'a self, entry: &'a Entry) -> Option<&'a Channels> {
        self.of(entry)?.constant.as_ref().or(entry.channels.as_ref())
    }
}

/// Where rays meet bodies. Their shading normals are on the side of the rays, which counts as outside: what a boundary lets through leaves it
/// by subsurface scattering alone.
#[derive(Clone, Copy)]
pub(in crate::integrator) struct Entrances<S: Simd> {
    mask: mask64x8<S>,
    colors: [Vec3fx8<S>; 2],
    /// The indices of refraction.
    eta: f32x8<S>,
    /// The shading normals.
    ns: Vec3x8<S>,
    /// Where the geometric normals point inside.
    is_reversed: mask64x8<S>,
    materials: [u32; LANES],
}

impl<S: Simd> Entrances<S> {
    /// Where rays in directions `d` enter bodies.
    #[inline(always)]
    pub fn enters(&self, d: Vec3x8<S>) -> mask64x8<S> {
        self.mask & self.ns.dot(d).simd_lt(0.0)
    }

    /// Takes samples out that enter bodies. Their paths wait in the batch.
    #[inline(never)]
    pub fn enter(
        &self,
        vertices: &Vertices<S>,
        sample: &mut BsdfSample<S>,
        active: mask64x8<S>,
        batch: &mut PathBatch,
    ) {
        let simd = active.token();
        vectorized!(simd, {
            let entering = active & sample.is_valid & self.enters(sample.wi);
            if !entering.any_true() {
                return;
            }
            sample.is_valid &= !entering;
            let mut paths = vertices.scattered(&BsdfSample { is_valid: entering, ..*sample }, entering);
            // Whatever refraction does to radiance is undone where the path leaves.
            paths.throughput = paths.throughput / sample.radiance_scale;
            paths.eta_scale = vertices.paths.eta_scale;
            paths.medium = vertices.paths.medium;
            let surfaces = &vertices.illumination.receivers.surfaces;
            let own = batch.in_bodies.get_or_insert_with(BodyBatch::new);
            own.paths.push(&paths);
            for lane in set_lanes(entering) {
                let n = self.ns.lane(lane);
                let (x, y) = n.any_orthonormal_pair();
                own.entries.push(Entry {
                    place: Place { p: surfaces.p.lane(lane), axes: [x, y, n] },
                    is_reversed: self.is_reversed.to_bitmask() >> lane & 1 == 1,
                    material: self.materials[lane],
                    colors: self.colors.map(|color| color.lane(lane)),
                    eta: self.eta[lane],
                    channels: None,
                    rest: 0.0,
                    found: 0,
                });
            }
        })
    }
}

/// Where a path has entered a body.
struct Entry {
    place: Place,
    /// True if the geometric normal points inside.
    is_reversed: bool,
    /// The number of the material.
    material: u32,
    colors: [Vec3; 2],
    eta: f32,
    /// The channels of these colors, if the body has others elsewhere.
    channels: Option<Channels>,
    /// A random number that chooses among the points that a probe finds.
    rest: f64,
    /// The number of these so far.
    found: u32,
}

/// The paths of a batch that have entered bodies, and their probes.
pub(in crate::integrator) struct BodyBatch {
    paths: PathColumns,
    entries: Vec<Entry>,
    /// What is left of the probes, and the next points on them.
    probes: RayColumns,
    hits: HitColumns,
    /// The probes to the chosen points, and these.
    exit_rays: RayColumns,
    exit_hits: HitColumns,
}

impl BodyBatch {
    fn new() -> Box<Self> {
        Box::new(BodyBatch {
            paths: PathColumns::new(),
            entries: Vec::new(),
            probes: RayColumns::new(),
            hits: HitColumns::new(),
            exit_rays: RayColumns::new(),
            exit_hits: HitColumns::new(),
        })
    }

    /// Removes all paths.
    pub fn clear(&mut self) {
        self.paths.count = 0;
        self.entries.clear();
    }
}

impl Lighting<'_> {
    /// Finds the bodies that rays meet, and turns their shading normals to the side of the rays.
    #[inline(never)]
    pub fn entrances<S: Simd>(
        &self,
        simd: S,
        paths: &PathRecord<S>,
        shaded: &mut Shaded<S>,
        inside: Option<Inside<S>>,
    ) -> Option<Entrances<S>> {
        vectorized!(simd, {
            let Inside { mask, colors, eta } = inside?;
            let mask = widen(mask) & paths.active;
            let Shaded { found, frames, .. } = shaded;
            let surfaces = &mut found.surfaces;
            let is_behind = mask & surfaces.ns.dot(paths.rays.d).simd_gt(0.0);
            surfaces.ns = (-surfaces.ns).keep_where(is_behind, surfaces.ns);
            let turned = Frames { x: frames.x, y: -frames.y, z: -frames.z };
            *frames = turned.keep_where(is_behind, *frames);
            let mut materials = [0; LANES];
            for lane in set_lanes(mask) {
                materials[lane] = self.world.materials.number(found.elements[lane].primitive);
            }
            let is_reversed = surfaces.n.widen().dot(paths.rays.d).simd_gt(0.0);
            Some(Entrances { mask, colors, eta, ns: surfaces.ns, is_reversed, materials })
        })
    }
}

impl Paths<'_> {
    /// Leads the paths that have entered bodies to where they leave these, samples the lights there, and the directions that continue the
    /// paths. `at.dimension`: the first dimension of probes.
    #[inline(never)]
    pub(super) fn leave_bodies<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        bodies: &Bodies,
        at: BatchSurface,
        batch: &mut PathBatch,
    ) {
        let Some(mut own) = batch.in_bodies.take() else { return };
        if own.paths.count > 0 && !tracer.is_stopped {
            let probes = self.sample_probes(simd, streams, bodies, at.dimension, &mut own);
            self.trace_probes(simd, tracer, probes, &mut own);
            self.at_exits(simd, tracer, streams, bodies, at, (&own, batch));
        }
        own.clear();
        batch.in_bodies = Some(own);
    }

    /// Samples a probe for each path. Returns the paths with one; each bit is one.
    #[inline(never)]
    fn sample_probes<S: Simd>(
        &self,
        simd: S,
        streams: &mut Streams,
        bodies: &Bodies,
        dimension: u32,
        BodyBatch { paths, entries, probes, .. }: &mut BodyBatch,
    ) -> u64 {
        vectorized!(simd, {
            let (record, mut valid) = (&mut PathRecord::none(simd), 0);
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, record);
                streams.choose(simd, &record.samples, dimension);
                let (choice, [u, v]) = (streams.next_1d(simd), streams.next_2d(simd));
                for lane in set_lanes(record.active) {
                    let entry = &mut entries[first + lane];
                    let Some(body) = bodies.of(entry) else { continue };
                    if body.constant.is_none() {
                        entry.channels = Some(body.channels(entry.colors));
                    }
                    let Some(channels) = bodies.channels(entry) else { continue };
                    let throughput = record.throughput.lane(lane);
                    let probe = entry.place.probe(channels, throughput, choice[lane], [u[lane], v[lane]]);
                    let Some(probe) = probe else { continue };
                    entry.rest = probe.rest;
                    let ray = OneRay {
                        o: probe.o,
                        d: probe.d,
                        t_max: probe.length,
                        leaving: NONE,
                        time: record.rays.time[lane],
                        ..record.rays.one(lane)
                    };
                    probes.set(first + lane, &ray);
                    valid |= 1 << (first + lane);
                }
            }
            valid
        })
    }

    /// Finds all points of each probe where it crosses the same material, and chooses one.
    #[inline(never)]
    fn trace_probes<S: Simd>(&self, simd: S, tracer: &mut Tracer, all: u64, batch: &mut BodyBatch) {
        let (world, mut rest) = (&self.lighting.world, all);
        let BodyBatch { entries, probes, hits, exit_rays, exit_hits, .. } = batch;
        exit_hits.clear();
        for _ in 0..MAX_PASSED {
            if rest == 0 {
                break;
            }
            world.nearest_as(simd, tracer, Stage::BounceRays, probes, rest, hits);
            let mut open = 0;
            for (first, own) in eights(rest) {
                let (rays, found) = (probes.eight(simd, first), hits.eight(simd, first));
                for lane in set_bits(own) {
                    let (ray, Some(hit)) = world.one(&rays, &found, lane) else { continue };
                    let (at, ray_before) = (first + lane, rays.one(lane));
                    let entry = &mut entries[at];
                    if world.materials.number(hit.element.primitive) == entry.material {
                        entry.found += 1;
                        // Each so far is equally likely.
                        let scaled = entry.rest * f64::from(entry.found);
                        if scaled < 1.0 {
                            entry.rest = scaled;
                            exit_rays.set(at, &ray_before);
                            exit_hits.copy(at, hits);
                        } else {
                            entry.rest = (scaled - 1.0) / f64::from(entry.found - 1);
                        }
                    }
                    let o = tracer.surface(&ray, &hit).spawn_ray(ray.d).o;
                    let t_max = ray_before.t_max - (o - ray.o).dot(ray.d);
                    if t_max > 0.0 {
                        let (leaving, leaving_instance) = (found.element[lane], found.instance[lane]);
                        probes.set(at, &OneRay { o, t_max, leaving, leaving_instance, ..ray_before });
                        open |= 1 << at;
                    }
                }
            }
            rest = open;
        }
    }

    /// Continues the paths where they leave bodies.
    #[inline(never)]
    fn at_exits<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        bodies: &Bodies,
        at: BatchSurface,
        (BodyBatch { paths, entries, exit_rays, exit_hits, .. }, batch): (&BodyBatch, &mut PathBatch),
    ) {
        vectorized!(simd, {
            let record = &mut PathRecord::none(simd);
            for first in (0..paths.count).step_by(LANES) {
                paths.load(simd, first, paths.count, record);
                exit_rays.load(simd, first, &mut record.rays);
                exit_hits.load(simd, first, &mut record.hits);
                record.active &= record.hits.is_hit();
                if !tracer.should_continue() || !record.active.any_true() {
                    continue;
                }
                let mut shaded = self.lighting.world.plain(simd, record, &mut LobeSlots::new());
                let surfaces = &mut shaded.found.surfaces;
                let (mut eta, mut scale) = ([1.0; LANES], [0.0; LANES]);
                let mut leaving = 0;
                for lane in set_lanes(record.active) {
                    let entry = &entries[first + lane];
                    let Some(channels) = bodies.channels(entry) else { continue };
                    let n = DVec3::from(surfaces.n.lane(lane));
                    let throughput = record.throughput.lane(lane);
                    let weight = entry.place.weight(channels, throughput, surfaces.p.lane(lane), n);
                    let throughput = throughput * weight * entry.found as f32;
                    if throughput.max_element() > 0.0 && throughput.is_finite() {
                        record.throughput.set_lane(lane, throughput);
                        eta[lane] = entry.eta;
                        scale[lane] = (1.0 / diffuse_transmittance(entry.eta.into())) as f32;
                        leaving |= 1 << lane;
                    }
                    if entry.is_reversed {
                        let ns = -surfaces.ns.lane(lane);
                        surfaces.ns.set_lane(lane, ns);
                    }
                }
                record.active = bits(simd, leaving);
                if leaving == 0 {
                    continue;
                }
                shaded.frames = Frames::from_z(shaded.found.surfaces.ns.narrow());
                let wo = shaded.found.surfaces.ns;
                streams.choose(simd, &record.samples, at.dimension.wrapping_add(PROBE_NUMBERS));
                let [eta, scale]: [f32x8<S>; 2] = [eta, scale].map(|of| of.simd_into(simd));
                let mut slots = LobeSlots::exits(scale, eta, record.active);
                let all = (record.active, record.active);
                self.lighting.at_surfaces(
                    simd,
                    tracer,
                    (record, wo),
                    (&shaded, None),
                    &mut slots,
                    #[inline(always)]
                    |tracer: &mut Tracer, vertices: &Vertices<S>| {
                        self.scatter(tracer, streams, vertices, all, at.depth, batch);
                    },
                );
            }
        })
    }
}
