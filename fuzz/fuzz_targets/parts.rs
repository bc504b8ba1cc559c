//! The sums of parts and checkpoints: changed anywhere, they are sums, or an error, and a rendering goes on from them or refuses them.

#![no_main]

use std::ops::ControlFlow;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU32, Ordering};

use libfuzzer_sys::fuzz_target;
use lookat_image::IntegerChannel;
use lookat_render::{FilmSums, Part, Prepared, Progress, Settings, Stop, SumsHeader, TargetError};
use lookat_scene::{Scene, load_str};

/// Sums of one way to render, as a file has them.
struct Kept {
    settings: Settings,
    header: Vec<u8>,
    channels: Vec<IntegerChannel>,
}

static SCENE: LazyLock<(Scene, Prepared)> = LazyLock::new(|| {
    let text = r#"LookAt 0 0 -4 0 0 0 0 1 0 Film "image" "integer xresolution" 6 "integer yresolution" 5
        Camera "perspective" PixelFilter "gaussian" Sampler "sobol" "integer pixelsamples" 64 WorldBegin
        LightSource "infinite" Shape "sphere" WorldEnd"#;
    let scene = load_str(text).scene.expect("the scene has no fault");
    let prepared = Prepared::new(&scene);
    (scene, prepared)
});

static KEPT: LazyLock<Vec<Kept>> = LazyLock::new(|| {
    let (scene, prepared) = &*SCENE;
    let target = TargetError { relative: 0.01, confidence: 0.95 };
    let target = Stop::TargetError { target, max_samples: 256, limit: None, error_layers: true };
    let errors = Stop::Samples { error_layers: true };
    let part = Some(Part { index: 1, of: 3 });
    let kept = |(stop, part)| {
        let settings = Settings { threads: 1, stop, part, keep_sums: true, ..Settings::default() };
        let break_off = |progress: Progress| match progress.done {
            0..1000 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        };
        let rendered = prepared.render(&scene.view, &settings, &break_off);
        let (header, channels) = rendered.sums.expect("they are kept").into_channels();
        Kept { settings, header: header.to_bytes(), channels }
    };
    [(Stop::default(), None), (errors, part), (errors, None), (Stop::Adaptive, None), (target, None)]
        .map(kept)
        .into()
});

fuzz_target!(|data: &[u8]| {
    let Some((kind, edits)) = data.split_first() else { return };
    let Kept { settings, header, channels } = &KEPT[usize::from(*kind) % KEPT.len()];
    let (mut header, mut channels) = (header.clone(), channels.clone());
    let size = channels[0].samples.len();
    for [low, middle, high, bits] in edits.as_chunks().0 {
        let at = usize::from(*low) | usize::from(*middle) << 8 | usize::from(*high) << 16;
        let at = at % (header.len() + 4 * size * channels.len());
        match at.checked_sub(header.len()) {
            None => header[at] ^= bits,
            Some(at) => {
                let word = at / 4;
                channels[word / size].samples[word % size] ^= u32::from(*bits) << (8 * (at % 4));
            }
        }
    }
    let Ok(header) = SumsHeader::from_bytes(&header) else { return };
    let Ok(sums) = FilmSums::from_channels(header, &channels) else { return };
    sums.image(true);
    let _ = sums.clone().add(&sums);
    sums.clone().into_channels();
    let (scene, prepared) = &*SCENE;
    let calls = AtomicU32::new(0);
    let few = |_: Progress| match calls.fetch_add(1, Ordering::Relaxed) {
        0..20 => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    };
    let _ = prepared.resume(&scene.view, settings, sums, &few);
});
