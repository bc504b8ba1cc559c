//! Estimates of time, renderings that are broken off, and renderings in parts.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

use lookat_scene::Scene;
use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::film::FilmSums;
use crate::prepare::Prepared;
use crate::render::{Part, Rendered, Stop, TargetError};
use crate::testing::scene;

#[test]
fn even_work_is_estimated_within_the_slack() {
    let mut left = TimeLeft::default();
    for step in 1..=100 {
        let [least, most] =
            left.at(f64::from(step), 1000 * step as u64, [1000 * (100 - step as u64); 2]).unwrap();
        let truth = f64::from(100 - step);
        assert!((least - truth / SLACK).abs() < 1e-9 && (most - truth * SLACK).abs() < 1e-9);
    }
}

/// Slower samples raise the upper bound, and later also the lower bound.
#[test]
fn slower_samples_are_noticed() {
    let mut left = TimeLeft::default();
    (1..=10_u64).for_each(|second| {
        left.at(second as f64, 1000 * second, [9000; 2]);
    });
    let [mut least, mut most] = [0.0; 2];
    for second in 11..=40_u64 {
        [least, most] = left.at(second as f64, 10_000 + 100 * (second - 10), [1000; 2]).unwrap();
    }
    assert!(most >= 10.0 && least > 1.0, "{least} {most}");
    assert_eq!(TimeLeft::default().at(1.0, 0, [10; 2]), None);
}

/// A lamp, its shadow, and a filter.
fn lamp(sampler: &str, filter: &str) -> Scene {
    scene(&format!(
        "LookAt 0 2 -6 0 1 0 0 1 0 Camera \"perspective\" \"float fov\" 40 PixelFilter \"{filter}\"
        Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 32 \"float cropwindow\" [0 .9 .1 1]
        Sampler \"{sampler}\" \"integer pixelsamples\" 37 Integrator \"path\" \"integer maxdepth\" 2 WorldBegin
        AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [20 20 20] Translate 0.3 1.7 0
        Shape \"sphere\" \"float radius\" 0.4 AttributeEnd
        Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 -9 0 9 9 0 9 9 0 -9] WorldEnd"
    ))
}

const TARGET: TargetError = TargetError { relative: 0.1, confidence: 0.9 };

fn target(max_samples: u32) -> Stop {
    Stop::TargetError { target: TARGET, max_samples, limit: None, error_layers: true }
}

/// As a file keeps them.
fn kept(sums: &FilmSums) -> FilmSums {
    let (header, channels) = sums.clone().into_channels();
    FilmSums::from_channels(header, &channels).unwrap()
}

/// Renders, from sums if there are some, for so many calls of the callback.
fn sitting(scene: &Scene, settings: &Settings, so_far: Option<FilmSums>, calls: u32) -> Rendered {
    let prepared = Prepared::new(scene);
    let left = AtomicU32::new(calls);
    let progress = |_: Progress| match left
        .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1))
    {
        Ok(_) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    match so_far {
        None => prepared.render(&scene.view, settings, &progress),
        Some(sums) => prepared.resume(&scene.view, settings, sums, &progress).unwrap(),
    }
}

/// Wherever it is broken off, any number of times, a rendering ends with the bits of an unbroken one, whatever decides about its samples.
#[test]
fn broken_renderings_end_with_the_same_bits() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let errors = Stop::Samples { error_layers: true };
    let half = Some(Part { index: 1, of: 2 });
    let kinds = [
        (Stop::default(), None),
        (errors, None),
        (Stop::Adaptive, None),
        (target(256), None),
        (errors, half),
    ];
    for (number, (stop, part)) in kinds.into_iter().enumerate() {
        for (filter, sampler) in [("box", "sobol"), ("mitchell", "random"), ("gaussian", "stratified")] {
            for is_extendable in [false, true] {
                let mut scene = lamp(sampler, filter);
                if is_extendable && (number == 1 || number == 2) {
                    scene.view.sampler = scene.view.sampler.with_samples(64);
                }
                let is_extendable = is_extendable && sampler != "stratified" && part.is_none();
                let settings = Settings { stop, part, keep_sums: true, is_extendable, ..Settings::default() };
                let whole = sitting(&scene, &settings, None, u32::MAX);
                assert!(whole.complete);
                // Nothing is kept that changes the picture.
                if !is_extendable {
                    let plain = Settings { keep_sums: false, ..settings };
                    assert!(sitting(&scene, &plain, None, u32::MAX).image == whole.image, "{settings:?}");
                }
                for _ in 0..3 {
                    let (mut so_far, mut sittings) = (None, 0);
                    let resumed = loop {
                        sittings += 1;
                        let calls = random.random_range(0..60);
                        let rendered = sitting(&scene, &settings, so_far.clone(), calls);
                        if rendered.complete {
                            break rendered;
                        }
                        so_far = rendered.sums.as_ref().map(kept).or(so_far);
                        // One replicate tells nothing of the error, and none less.
                        let errors =
                            so_far.as_ref().and_then(|sums| sums.image(true).errors()).unwrap_or_default();
                        assert!(errors.iter().all(|error| {
                            error.replicates > 1 || error.standard_error == [f32::INFINITY; 3]
                        }));
                    };
                    assert!(sittings > 2 || number == 0);
                    assert!(resumed.image == whole.image, "{settings:?} {filter}");
                    assert!(resumed.sums == whole.sums, "{settings:?} {filter}");
                    assert_eq!(resumed.statistics.target, whole.statistics.target);
                }
            }
        }
    }
}

/// Fewer samples and then more are the bits of all at once.
#[test]
fn more_samples_are_those_of_one_rendering() {
    let samples = |error_layers| Stop::Samples { error_layers };
    for (stops, counts) in [
        ([samples(false); 3], [3, 20, 37]),
        ([samples(true); 3], [16, 64, 128]),
        ([Stop::Adaptive; 3], [16, 32, 128]),
        ([target(64), target(128), target(512)], [64, 128, 512]),
    ] {
        for (filter, sampler) in [("box", "random"), ("mitchell", "sobol")] {
            let mut scene = lamp(sampler, filter);
            let mut so_far = None;
            for (stop, count) in stops.into_iter().zip(counts) {
                scene.view.sampler = scene.view.sampler.with_samples(count);
                let settings = Settings { stop, is_extendable: true, keep_sums: true, ..Settings::default() };
                assert!(settings.is_whole_round(count));
                let whole = sitting(&scene, &settings, None, u32::MAX);
                let more = sitting(&scene, &settings, so_far, u32::MAX);
                assert!(more.image == whole.image, "{settings:?} {filter} {count}");
                assert!(more.sums == whole.sums, "{settings:?} {filter} {count}");
                so_far = more.sums.as_ref().map(kept);
            }
        }
    }
}

/// Error layers of parts, in any order, are those of one rendering: a replicate may be cut by parts, or have several of them.
#[test]
fn error_layers_of_parts_add_up() {
    for filter in ["box", "mitchell"] {
        let scene = lamp("halton", filter);
        let stop = Stop::Samples { error_layers: true };
        let whole = sitting(&scene, &Settings { stop, ..Settings::default() }, None, u32::MAX);
        for of in [1, 2, 5, 16, 37] {
            let part = |index| {
                let part = Some(Part { index, of });
                let settings = Settings { stop, part, keep_sums: true, ..Settings::default() };
                kept(&sitting(&scene, &settings, None, u32::MAX).sums.unwrap())
            };
            let mut all = part(of - 1);
            (0..of - 1).for_each(|index| all.add(&part(index)).unwrap());
            assert!(all.image(true) == whole.image, "{filter}: {of}");
        }
    }
}

/// Sums of one stopping rule are no start for another, and damaged ones are refused.
#[test]
fn sums_of_other_renderings_are_refused() {
    let scene = lamp("sobol", "box");
    let settings = |stop| Settings { stop, keep_sums: true, ..Settings::default() };
    let stops = [Stop::default(), Stop::Samples { error_layers: true }, Stop::Adaptive, target(64)];
    let sums = stops.map(|stop| sitting(&scene, &settings(stop), None, 30).sums.unwrap());
    let prepared = Prepared::new(&scene);
    for (own, stop) in stops.into_iter().enumerate() {
        for (other, sums) in sums.iter().enumerate().filter(|(other, _)| *other != own) {
            let found =
                prepared.resume(&scene.view, &settings(stop), sums.clone(), &|_| ControlFlow::Continue(()));
            assert!(found.is_err(), "{own} {other}");
        }
    }
    assert_eq!(sums[2].clone().add(&sums[2]), Err(FilmSumsError::HasState));
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for (own, sums) in sums.iter().enumerate() {
        let (header, channels) = sums.clone().into_channels();
        let in_file = channels.iter().map(|channel| 4 * channel.samples.len() as u64).sum::<u64>();
        assert!((in_file..6 * in_file).contains(&header.bytes()), "{own}: {} {in_file}", header.bytes());
        for _ in 0..100 {
            let mut channels = channels.clone();
            let at = random.random_range(0..channels.len());
            let word = random.random_range(0..channels[at].samples.len());
            channels[at].samples[word] ^= 1 << random.random_range(0..32);
            let Ok(sums) = FilmSums::from_channels(header.clone(), &channels) else { continue };
            let _ = prepared.resume(&scene.view, &settings(stops[own]), sums, &|progress| {
                if progress.done > 1 << 20 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
        }
    }
}
