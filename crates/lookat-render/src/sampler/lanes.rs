//! Numbers for camera samples side by side.

use std::array::from_fn;

use arrayvec::ArrayVec;
use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec2;
use lookat_scene::{Sampler, SamplerKind};

use super::halton::Seeds;
use super::sequence::halton_points;
use super::{SampleStream, of_pixel};
use crate::lanes::{LANES, those};

/// Numbers for camera samples of any pixels, eight of which are had at a time. Each call takes the next dimensions of the
/// patterns of these, as [`SampleStream::next_2d`] does.
#[derive(Debug, Clone)]
pub(crate) struct Streams {
    kind: Kind,
    /// Which samples are had.
    chosen: ArrayVec<u16, LANES>,
}

#[derive(Debug, Clone)]
enum Kind {
    Halton(Box<Halton>),
    /// With the samples that they are of.
    Each(Vec<(Sample, SampleStream)>),
}

/// Points of Halton's sequence, which are had together.
#[derive(Debug, Clone)]
struct Halton {
    pixel_center: bool,
    count: u32,
    /// Of each sample the seed of its pixel, and its number.
    samples: Vec<(u64, u32)>,
    /// The same of those that are had.
    seeds: Seeds,
    indices: [u32; LANES],
    dimension: u32,
}

/// A camera sample: a seed, a pixel, and which of its samples.
pub(crate) type Sample = (u64, [u32; 2], u32);

impl Streams {
    /// Those of no samples as yet.
    pub fn new(sampler: &Sampler) -> Self {
        let kind = match sampler.kind {
            SamplerKind::Halton { pixel_center } => Kind::Halton(Box::new(Halton {
                pixel_center,
                count: sampler.samples_per_pixel,
                samples: Vec::new(),
                seeds: Seeds::default(),
                indices: [0; LANES],
                dimension: 0,
            })),
            _ => Kind::Each(Vec::new()),
        };
        Streams { kind, chosen: ArrayVec::new() }
    }

    /// Goes to the beginning of others, of a sampler of the same kind.
    pub fn restart(&mut self, sampler: &Sampler, samples: &[Sample]) {
        match &mut self.kind {
            Kind::Halton(halton) => {
                halton.count = sampler.samples_per_pixel;
                halton.samples.clear();
                halton.samples.extend(samples.iter().map(of_pattern));
            }
            Kind::Each(streams) => {
                for ((of, stream), sample) in streams.iter_mut().zip(samples) {
                    // Mostly of the same pixel.
                    if (of.0, of.1) == (sample.0, sample.1) {
                        stream.restart(sample.2);
                    } else {
                        *stream = of_sample(sampler, *sample);
                    }
                    *of = *sample;
                }
                let more = samples.iter().skip(streams.len());
                streams.extend(more.map(|sample| (*sample, of_sample(sampler, *sample))));
            }
        }
    }

    /// Goes on with some of the samples, of which so many dimensions have been taken.
    #[inline(always)]
    pub fn choose(&mut self, samples: &[u16], dimension: u32) {
        self.chosen.clear();
        for sample in samples {
            self.chosen.push(*sample);
        }
        if let Kind::Halton(halton) = &mut self.kind {
            for lane in 0..LANES {
                let sample = samples.get(lane).unwrap_or(&samples[0]);
                let (seed, index) = halton.samples[usize::from(*sample)];
                halton.seeds.put(lane, seed);
                halton.indices[lane] = index;
            }
            halton.dimension = dimension;
        }
    }

    /// Points of the unit square for those that are active. The others leave the dimensions to be taken by others.
    #[inline(always)]
    pub fn next_2d<S: Simd>(&mut self, simd: S, active: mask64x8<S>) -> [f64x8<S>; 2] {
        let [x, y] = match &mut self.kind {
            Kind::Halton(halton) => halton.next_2d(),
            Kind::Each(streams) => {
                let mut points = [[0.5; LANES]; 2];
                let bits = active.to_bitmask();
                for (lane, sample) in self.chosen.iter().enumerate() {
                    let stream = &mut streams[usize::from(*sample)].1;
                    if bits >> lane & 1 == 1 {
                        (points[0][lane], points[1][lane]) = stream.next_2d().into();
                    } else {
                        stream.skip(2);
                    }
                }
                points
            }
        };
        [x.simd_into(simd), y.simd_into(simd)]
    }

    /// Points for the `k`-th of `count` samples that are nested in each; as [`SampleStream::nested_2d`].
    pub fn nested_2d<S: Simd>(
        &mut self,
        simd: S,
        active: mask64x8<S>,
        (count, k): (u32, u32),
    ) -> [f64x8<S>; 2] {
        if count == 1 {
            return self.next_2d(simd, active);
        }
        let mut points = [[0.5; LANES]; 2];
        let mut put = |lane: usize, point: DVec2| [points[0][lane], points[1][lane]] = point.into();
        match &mut self.kind {
            Kind::Halton(halton) => {
                for lane in those(active) {
                    put(lane, halton.stream(lane, halton.dimension).nested_2d(count, k));
                }
                halton.dimension += if k + 1 == count { 2 } else { 0 };
            }
            Kind::Each(streams) => {
                for (lane, sample) in self.chosen.iter().enumerate() {
                    let stream = &mut streams[usize::from(*sample)].1;
                    if active.to_bitmask() >> lane & 1 == 1 {
                        put(lane, stream.nested_2d(count, k));
                    } else if k + 1 == count {
                        stream.skip(2);
                    }
                }
            }
        }
        points.map(|numbers| numbers.simd_into(simd))
    }

    /// Numbers for those that are active, in the same way.
    pub fn next_1d<S: Simd>(&mut self, active: mask64x8<S>) -> [f64; LANES] {
        match &mut self.kind {
            Kind::Halton(halton) => {
                halton.dimension += 1;
                halton.numbers(halton.dimension - 1)
            }
            Kind::Each(streams) => {
                let mut numbers = [0.5; LANES];
                for lane in those(active) {
                    numbers[lane] = streams[usize::from(self.chosen[lane])].1.next_1d();
                }
                for lane in those(!active).filter(|lane| *lane < self.chosen.len()) {
                    streams[usize::from(self.chosen[lane])].1.skip(1);
                }
                numbers
            }
        }
    }

    /// Leaves dimensions to be taken by others.
    #[inline(always)]
    pub fn skip(&mut self, dimensions: u32) {
        match &mut self.kind {
            Kind::Halton(halton) => halton.dimension += dimensions,
            Kind::Each(streams) => {
                self.chosen.iter().for_each(|sample| streams[usize::from(*sample)].1.skip(dimensions));
            }
        }
    }
}

impl Halton {
    #[inline(always)]
    fn next_2d(&mut self) -> [[f64; LANES]; 2] {
        let at = self.dimension;
        self.dimension += 2;
        if at == 0 && self.pixel_center {
            return [[0.5; LANES]; 2];
        }
        [self.numbers(at), self.numbers(at + 1)]
    }

    /// Those of a dimension.
    #[inline(always)]
    fn numbers(&self, dimension: u32) -> [f64; LANES] {
        halton_points(dimension, &self.indices, self.count, &self.seeds)
            .unwrap_or_else(|| self.one_by_one(dimension))
    }

    /// Beyond what there is of the sequence.
    #[cold]
    fn one_by_one(&self, dimension: u32) -> [f64; LANES] {
        from_fn(|lane| self.stream(lane, dimension).next_1d())
    }

    /// That of a lane, from a dimension on.
    fn stream(&self, lane: usize, dimension: u32) -> SampleStream {
        let mut stream = SampleStream::halton(self.seeds.lane(lane), self.indices[lane], self.count);
        stream.skip(dimension);
        stream
    }
}

/// The seed of its pixel, and its number.
fn of_pattern((seed, pixel, index): &Sample) -> (u64, u32) {
    (of_pixel(*seed, *pixel), *index)
}

fn of_sample(sampler: &Sampler, (seed, pixel, index): Sample) -> SampleStream {
    let mut stream = SampleStream::new(sampler, seed, pixel);
    stream.restart(index);
    stream
}
