//! Subsurface scattering: leads paths from where they enter bodies to where they leave them (PBR 15.4).

use fearless_simd::{Simd, f32x8, mask64x8, prelude::*};
use glam::DVec3;

use super::bodies::{Bodies, BodyBatch, Entrances, PROBE_NUMBERS};
use super::lighting::Lighting;
use super::path_batch::PathBatch;
use super::path_record::PathRecord;
use super::profiler::Stage;
use super::vertices::Vertices;
use super::world::{MAX_PASSED, Tracer};
use crate::bsdf::{BsdfSample, LobeSlots};
use crate::bssrdf::diffuse_transmittance;
use crate::frame::Frames;
use crate::number::{LANES, bits, eights, set_bits, set_lanes, vectorized};
use crate::sampler::Streams;
use crate::trace::rays::{NONE, OneRay};

impl<S: Simd> Entrances<S> {
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
            let p = vertices.illumination.receivers.surfaces.p;
            batch.in_bodies.get_or_insert_with(BodyBatch::new).push(&paths, self, p);
        })
    }
}

impl Lighting<'_> {
    /// Leads the paths that have entered bodies to where they leave these, and calls `does` with their vertices there. `dimension`: the first
    /// sample dimension of probes.
    #[inline(never)]
    pub(super) fn leave_bodies<S: Simd>(
        &self,
        simd: S,
        tracer: &mut Tracer,
        streams: &mut Streams,
        dimension: u32,
        batch: &mut PathBatch,
        does: impl FnMut(&mut Tracer, &mut Streams, &Vertices<S>, &mut PathBatch),
    ) {
        let (Some(bodies), Some(mut own)) = (&self.bodies, batch.in_bodies.take()) else { return };
        if own.paths.count > 0 && !tracer.is_stopped {
            let probes = self.sample_probes(simd, streams, bodies, dimension, &mut own);
            self.trace_probes(simd, tracer, probes, &mut own);
            let dimension = dimension.wrapping_add(PROBE_NUMBERS);
            self.at_exits(simd, (tracer, streams, dimension), (bodies, &own), batch, does);
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
        let (world, mut rest) = (&self.world, all);
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

    /// Calls `does` with the vertices where paths leave bodies.
    #[inline(never)]
    fn at_exits<S: Simd>(
        &self,
        simd: S,
        (tracer, streams, dimension): (&mut Tracer, &mut Streams, u32),
        (bodies, BodyBatch { paths, entries, exit_rays, exit_hits, .. }): (&Bodies, &BodyBatch),
        batch: &mut PathBatch,
        mut does: impl FnMut(&mut Tracer, &mut Streams, &Vertices<S>, &mut PathBatch),
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
                let mut shaded = self.world.plain(simd, record, &mut LobeSlots::new());
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
                streams.choose(simd, &record.samples, dimension);
                let [eta, scale]: [f32x8<S>; 2] = [eta, scale].map(|of| of.simd_into(simd));
                let mut slots = LobeSlots::exits(scale, eta, record.active);
                self.at_surfaces(
                    simd,
                    tracer,
                    (record, wo),
                    (&shaded, None),
                    &mut slots,
                    #[inline(always)]
                    |tracer: &mut Tracer, vertices: &Vertices<S>| {
                        does(tracer, streams, vertices, batch);
                    },
                );
            }
        })
    }
}
