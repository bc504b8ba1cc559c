//! Numbers for camera samples side by side.

use std::array::from_fn;

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec2;
use lookat_scene::{Sampler, SamplerKind};

use super::halton::Seeds;
use super::sequence::halton_points;
use super::{SampleStream, of_pixel};
use crate::lanes::LANES;

/// Numbers for eight camera samples of any pixels. Each call takes the next dimensions of the pattern, as
/// [`SampleStream::next_2d`] does.
#[derive(Debug, Clone)]
pub(crate) enum Streams {
    /// Points of Halton's sequence, which are had together.
    Halton { pixel_center: bool, seeds: Seeds, indices: [u32; LANES], count: u32, dimension: u32 },
    /// With the samples that they are of.
    Each(Box<[(Sample, SampleStream); LANES]>),
}

/// A camera sample: a seed, a pixel, and which of its samples.
pub(crate) type Sample = (u64, [u32; 2], u32);

impl Streams {
    /// Those of some samples, from their beginning.
    pub fn new(sampler: &Sampler, samples: &[Sample; LANES]) -> Self {
        match sampler.kind {
            SamplerKind::Halton { pixel_center } => Streams::Halton {
                pixel_center,
                seeds: Seeds::new(samples.map(|(seed, pixel, _)| of_pixel(seed, pixel))),
                indices: samples.map(|(.., index)| index),
                count: sampler.samples_per_pixel,
                dimension: 0,
            },
            _ => Streams::Each(Box::new(samples.map(|sample| (sample, of_sample(sampler, sample))))),
        }
    }

    /// Goes to the beginning of others.
    pub fn restart(&mut self, sampler: &Sampler, samples: &[Sample; LANES]) {
        let Streams::Each(streams) = self else {
            *self = Streams::new(sampler, samples);
            return;
        };
        for ((of, stream), sample) in streams.iter_mut().zip(samples) {
            // Mostly of the same pixel.
            if (of.0, of.1) == (sample.0, sample.1) {
                stream.restart(sample.2);
            } else {
                *stream = of_sample(sampler, *sample);
            }
            *of = *sample;
        }
    }

    /// Points of the unit square.
    #[inline(always)]
    pub fn next_2d<S: Simd>(&mut self, simd: S) -> [f64x8<S>; 2] {
        let [x, y] = match self {
            Streams::Halton { pixel_center: true, dimension: at @ 0, .. } => {
                *at += 2;
                [[0.5; LANES]; 2]
            }
            Streams::Halton { seeds, indices, count, dimension, .. } => {
                let at = *dimension;
                *dimension += 2;
                [numbers(at, indices, *count, seeds), numbers(at + 1, indices, *count, seeds)]
            }
            Streams::Each(streams) => {
                let points: [DVec2; LANES] = from_fn(|lane| streams[lane].1.next_2d());
                [points.map(|p| p.x), points.map(|p| p.y)]
            }
        };
        [x.simd_into(simd), y.simd_into(simd)]
    }
}

fn of_sample(sampler: &Sampler, (seed, pixel, index): Sample) -> SampleStream {
    let mut stream = SampleStream::new(sampler, seed, pixel);
    stream.restart(index);
    stream
}

/// Those of a dimension.
#[inline(always)]
fn numbers(dimension: u32, indices: &[u32; LANES], count: u32, seeds: &Seeds) -> [f64; LANES] {
    halton_points(dimension, indices, count, seeds)
        .unwrap_or_else(|| one_by_one(dimension, indices, count, seeds))
}

/// Beyond what there is of the sequence.
#[cold]
fn one_by_one(dimension: u32, indices: &[u32; LANES], count: u32, seeds: &Seeds) -> [f64; LANES] {
    from_fn(|lane| SampleStream::halton(seeds.lane(lane), indices[lane], count).number(dimension))
}
