//! All samplers: numbers that lie as they should.

use super::*;
use crate::testing::baseline;
use sobol_burley::parts;

const KINDS: [SamplerKind; 3] =
    [SamplerKind::Random, SamplerKind::Stratified { cells: [8, 8], jitter: true }, SamplerKind::SOBOL];

/// The numbers of one sample, as [`Streams`] gives them.
#[derive(Clone)]
struct Stream(Streams);

impl Stream {
    fn next_1d(&mut self) -> f64 {
        baseline!(simd => self.0.next_1d(simd)[3])
    }

    fn nested_2d(&mut self, count: u32, k: u32) -> DVec2 {
        baseline!(simd => DVec2::from(self.0.nested_2d(simd, (count, k)).map(|x| x[3])))
    }
}

fn streams(kind: SamplerKind, count: u32, pixel: [i32; 2]) -> impl Iterator<Item = Stream> {
    let sampler = Sampler { kind, samples_per_pixel: count };
    (0..count).map(move |index| of_sample(&sampler, pixel, index))
}

fn of_sample(sampler: &Sampler, pixel: [i32; 2], index: u32) -> Stream {
    let mut streams = Streams::new();
    streams.restart(sampler, &[Sample { seed: 7, pixel, index }]);
    baseline!(simd => streams.choose(simd, &[0], 0));
    Stream(streams)
}

#[test]
fn numbers_lie_in_the_unit_interval_and_repeat() {
    for kind in KINDS {
        for mut stream in streams(kind, 64, [3, 4]) {
            let mut again = stream.clone();
            for _ in 0..300 {
                let x = stream.next_1d();
                assert!(x > 0.0 && x < 1.0, "{kind:?}");
                assert_eq!(x, again.next_1d());
            }
        }
    }
}

/// A number chooses one of a million lights, and what is left of it is as even as 32 random bits: the first eight of them, and the last.
#[test]
fn numbers_choose_one_of_a_million_and_go_on() {
    const LIGHTS: f64 = (1 << 20) as f64;
    for kind in KINDS {
        let [mut first, mut last] = [[0_u32; 256]; 2];
        for pixel in 0..8 {
            for mut stream in streams(kind, 64, [pixel, 5]) {
                for _ in 0..50 {
                    let rest = ((stream.next_1d() * LIGHTS).fract() * 2_f64.powi(32)) as u32;
                    first[(rest >> 24) as usize] += 1;
                    last[(rest & 255) as usize] += 1;
                }
            }
        }
        for counts in [first, last] {
            let expected = f64::from(8 * 64 * 50) / 256.0;
            let of = |count: &u32| (f64::from(*count) - expected).powi(2) / expected;
            let chi_square: f64 = counts.iter().map(of).sum();
            // Of 255 random degrees of freedom: the mean and five standard deviations.
            assert!(chi_square < 255.0 + 5.0 * (2.0 * 255.0_f64).sqrt(), "{kind:?}: {chi_square}");
        }
    }
}

/// Every stratum of a well distributed pattern holds one sample.
#[test]
fn first_dimensions_are_stratified() {
    let occupied = |kind, base: u32, dimension| {
        let mut cells = vec![0; 64];
        for mut stream in streams(kind, 64, [1, 2]) {
            let numbers: Vec<f64> = (0..4).map(|_| stream.next_1d()).collect();
            cells[(numbers[dimension] * f64::from(base)) as usize] += 1;
        }
        cells[..base as usize].iter().filter(|count| **count > 0).count()
    };
    assert_eq!(occupied(KINDS[1], 64, 0), 64);
    assert_eq!(occupied(KINDS[2], 64, 0), 64);
    assert_eq!(occupied(KINDS[2], 64, 3), 64);
}

/// The errors of estimates in neighboring pixels, and of different dimensions in one pixel, have nothing in common. Those of neighbors may
/// cancel, unless pixels are to be sampled on their own.
#[test]
fn errors_of_neighbors_do_not_add_up() {
    let pixels = 2000;
    for (kind, is_single) in KINDS.map(|kind| (kind, false)).into_iter().chain([(SamplerKind::SOBOL, true)]) {
        let sampler = Sampler { kind, samples_per_pixel: 16 };
        let sampler = if is_single { of_single_pixels(sampler) } else { sampler };
        // The share of 16 samples that fall below a threshold, less its mean.
        let error = |pixel: [i32; 2], dimension: usize| -> f64 {
            let number = |mut stream: Stream| (0..=dimension).map(|_| stream.next_1d()).last();
            let samples = (0..16).map(|index| of_sample(&sampler, pixel, index));
            let below = samples.filter_map(number).filter(|x| *x < 0.37).count();
            below as f64 / 16.0 - 0.37
        };
        let errors = |step: [i32; 2], dimension| -> Vec<f64> {
            (0..pixels).map(|x| error([x + step[0], step[1]], dimension)).collect()
        };
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        for (step, dimensions) in [
            ([1, 0], [0, 0]),
            ([0, 1], [0, 0]),
            ([1, 0], [5, 5]),
            ([0, 1], [5, 5]),
            ([0, 0], [0, 1]),
            ([0, 0], [0, 7]),
        ] {
            let (here, there) = (errors([0, 0], dimensions[0]), errors(step, dimensions[1]));
            let r = product(&here, &there) / (product(&here, &here) * product(&there, &there)).sqrt();
            // Four standard deviations.
            let most = 4.0 / f64::from(pixels).sqrt();
            let may_cancel = kind == SamplerKind::SOBOL && !is_single && step != [0, 0];
            assert!(r < most && (r > -most || may_cancel), "{kind:?} {step:?} {dimensions:?}: {r}");
        }
    }
}

/// Samples that are nested in those of a pixel are as well distributed as so many samples of it.
#[test]
fn nested_samples_differ_from_each_other() {
    for kind in KINDS {
        let nested = streams(kind, 16, [3, 8])
            .flat_map(|stream| (0..4).map(move |k| stream.clone().nested_2d(4, k).x));
        let mut numbers: Vec<f64> = nested.collect();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        assert_eq!(numbers.len(), 64, "{kind:?}");
        let mean = numbers.iter().sum::<f64>() / 64.0;
        // Four standard deviations of independent samples.
        assert!((mean - 0.5).abs() < 4.0 * (1.0 / 12.0_f64 / 64.0).sqrt(), "{kind:?}: {mean}");
    }
}

/// Nested samples of all samples of a pixel are as even as so many samples.
#[test]
fn nested_samples_of_sobol_are_stratified() {
    let numbers = streams(SamplerKind::SOBOL, 16, [1, 2])
        .flat_map(|stream| (0..8).map(move |k| stream.clone().nested_2d(8, k).y));
    let mut strata: Vec<u32> = numbers.map(|y| (y * 128.0) as u32).collect();
    strata.sort_unstable();
    assert!(strata.into_iter().eq(0..128));
}

/// With more samples than can be numbered, nested ones still differ.
#[test]
fn nested_samples_need_no_numbers() {
    for kind in KINDS {
        let sampler = Sampler { kind, samples_per_pixel: 1 << 30 };
        let mut numbers: Vec<f64> = (0..64)
            .flat_map(|index| (0..4).map(move |k| (index << 24, k * 16_000)))
            .flat_map(|(index, k)| of_sample(&sampler, [1, 2], index).nested_2d(1 << 16, k).to_array())
            .collect();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        assert_eq!(numbers.len(), 512, "{kind:?}");
        assert!(numbers.iter().all(|x| (0.0..1.0).contains(x)), "{kind:?}");
    }
}

/// So what has less than half a step of probability is not chosen, wherever it comes.
#[test]
fn numbers_are_the_middles_of_steps() {
    const STEP: f64 = f64::EPSILON;
    assert_eq!([0, u64::MAX].map(unit), [0.5 * STEP, 1.0 - 0.5 * STEP]);
    assert_eq!(unit(5 << 12), 5.5 * STEP);
    assert_eq!(unit(1 << 63), 0.5 + 0.5 * STEP);
}

#[test]
fn side_by_side_is_as_one_by_one() {
    for k in 0..10_000 {
        let bits = mix(k);
        let (a, b) = (bits as u32 >> (k % 32), (bits >> 32) as u32 >> (k / 32 % 32));
        baseline!(simd => {
            let (x, y): (u32x8<_>, u32x8<_>) = (a.simd_into(simd), b.simd_into(simd));
            assert_eq!(owen_scramble_rev(x, y)[3], parts::owen_scramble_rev(a, b));
            assert_eq!(reversed(x)[5], a.reverse_bits());
            let more = u64::from(lowbias(x ^ y)[6]);
            assert_eq!(units(x, y)[6], unit(u64::from(a) << 32 | more));
        });
    }
}

#[test]
fn permutations_are_permutations() {
    for n in [1, 2, 3, 10, 64, 100] {
        let mut image: Vec<u32> = (0..n).map(|i| permute(i, n, 12345)).collect();
        image.sort_unstable();
        assert_eq!(image, (0..n).collect::<Vec<_>>());
    }
}
