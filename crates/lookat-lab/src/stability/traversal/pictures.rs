//! Pictures of unusual size, and the same picture on any number of threads: V14 and V15.

use crate::stability::prelude::*;

/// A scene, whose film and sampler are what the case is about.
fn text(film: &str, sampler: &str, integrator: &str, world: &str) -> String {
    let camera = "LookAt -3 1.5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 60";
    let film = format!("Film \"image\" {film} Sampler {sampler} Integrator {integrator}");
    format!("{camera} {film} WorldBegin {world} WorldEnd")
}

const BALLS: &str = include_str!("scenes/balls.pbrt");

const INTEGRATORS: [&str; 3] = [r#""path""#, r#""directlighting""#, r#""ambientocclusion""#];

/// Films, the samples of each pixel, and the pixels of the picture.
const FILMS: [(&str, u32, usize); 6] = [
    (r#""integer xresolution" 8 "integer yresolution" 8"#, 1, 64),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 1, 1),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 7, 1),
    (r#""integer xresolution" 65536 "integer yresolution" 1"#, 1, 65536),
    (r#""integer xresolution" 1 "integer yresolution" 65536"#, 1, 65536),
    (r#""integer xresolution" 8 "integer yresolution" 8 "float cropwindow" [0.5 0.625 0 0.125]"#, 1, 1),
];

pub(super) fn degenerate(_: &Effort) -> Found {
    let mut found = refused("V14");
    for (film, samples, pixels) in FILMS {
        for (sampler, integrator) in ["sobol", "halton", "random"].iter().zip(INTEGRATORS) {
            let sampler = format!("\"{sampler}\" \"integer pixelsamples\" {samples}");
            let rgb = render(&scene(&text(film, &sampler, integrator, BALLS)), 0);
            let right = rgb.len() == pixels && rgb.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
            found.check(right, || format!("{film}, {sampler}: {} pixels, or not finite", rgb.len()));
        }
    }
    found
}

const BOX: &str = include_str!("scenes/box.pbrt");

const COPIES: &str = include_str!("scenes/copies.pbrt");

pub(super) fn threads(_: &Effort) -> Found {
    // Neither side is a multiple of the tiles.
    let film = r#""integer xresolution" 50 "integer yresolution" 37"#;
    let scenes = [
        ("path, light in a box", text(film, r#""sobol" "integer pixelsamples" 16"#, INTEGRATORS[0], BOX)),
        ("direct light, copies", text(film, r#""halton" "integer pixelsamples" 16"#, INTEGRATORS[1], COPIES)),
        ("occlusion", text(film, r#""stratified""#, INTEGRATORS[2], BALLS)),
        (
            "lens, wide filter",
            text(film, r#""random" "integer pixelsamples" 9"#, INTEGRATORS[0], BALLS)
                .replace("\"float fov\"", "\"float lensradius\" 0.3 \"float focaldistance\" 3 \"float fov\"")
                .replace("Integrator", "PixelFilter \"mitchell\" Integrator"),
        ),
    ];
    let mut found = Found::default();
    for (name, text) in scenes {
        same_on_threads(&mut found, name, &scene(&text));
    }
    found
}

/// Checks that a picture is not black, and the same to the bit on some numbers of threads.
pub(in crate::stability) fn same_on_threads(found: &mut Found, name: &str, scene: &Scene) {
    let bits = |threads| render(scene, threads).into_iter().flatten().map(f32::to_bits).collect::<Vec<u32>>();
    let one = bits(1);
    found.check(one.iter().any(|bits| *bits != 0), || format!("{name}: black"));
    for threads in [2, 7] {
        found.check(bits(threads) == one, || format!("{name}: {threads} threads give other bits than 1"));
    }
}
