//! Pictures of unusual size, and the same picture on any number of threads: V14 and V15.

use lookat_scene::syntax::Diagnostic;

use crate::stability::prelude::*;

/// A scene, whose film and sampler are what the case is about.
fn text(film: &str, sampler: &str, integrator: &str, world: &str) -> String {
    format!(
        "LookAt -3 1.5 -3  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 60
Film \"image\" {film}
Sampler {sampler}
Integrator {integrator}
WorldBegin
{world}
WorldEnd"
    )
}

const BALLS: &str = include_str!("scenes/balls.pbrt");

const INTEGRATORS: [&str; 3] = [r#""path""#, r#""directlighting""#, r#""ambientocclusion""#];

/// Films, the samples of each pixel, and the pixels of the picture; `None` where it must be an error.
const FILMS: [(&str, u32, Option<usize>); 10] = [
    (r#""integer xresolution" 8 "integer yresolution" 8"#, 1, Some(64)),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 1, Some(1)),
    (r#""integer xresolution" 1 "integer yresolution" 1"#, 7, Some(1)),
    (r#""integer xresolution" 65536 "integer yresolution" 1"#, 1, Some(65536)),
    (r#""integer xresolution" 1 "integer yresolution" 65536"#, 1, Some(65536)),
    (r#""integer xresolution" 8 "integer yresolution" 8 "float cropwindow" [0.5 0.625 0 0.125]"#, 1, Some(1)),
    (r#""integer xresolution" 8 "integer yresolution" 8 "float cropwindow" [0.5 0.5 0 1]"#, 1, None),
    (r#""integer xresolution" 8 "integer yresolution" 8 "float cropwindow" [0.51 0.52 0 1]"#, 1, None),
    (r#""integer xresolution" 0 "integer yresolution" 8"#, 1, None),
    (r#""integer xresolution" 8 "integer yresolution" 8"#, 0, None),
];

pub(super) fn degenerate(_: &Effort) -> Found {
    let mut found = Found::default();
    let samplers = ["sobol", "halton", "random"];
    for (film, samples, pixels) in FILMS {
        for (sampler, integrator) in samplers.iter().zip(INTEGRATORS) {
            let sampler = format!("\"{sampler}\" \"integer pixelsamples\" {samples}");
            let text = text(film, &sampler, integrator, BALLS);
            let problem = problem(&text, pixels);
            found.check(problem.is_none(), || format!("{film}, {sampler}: {}", problem.unwrap_or_default()));
        }
    }
    found
}

/// What is wrong with the picture of a scene, or with how it is refused.
fn problem(text: &str, pixels: Option<usize>) -> Option<String> {
    let loaded = load(text);
    let Some(pixels) = pixels else {
        if loaded.scene.is_some() {
            return Some("is not refused".into());
        }
        // The trouble is with the film or the sampler.
        let line = |problem: &Diagnostic| loaded.sources.location(problem.span()).line;
        let told = loaded.diagnostics.iter().any(|problem| (2..=3).contains(&line(problem)));
        return (!told).then(|| "no error names the line".into());
    };
    let Some(scene) = loaded.scene else { return Some(format!("is refused: {:?}", loaded.diagnostics)) };
    let Some(rgb) = render(&scene, 0).rgb() else { return Some("has no colors".into()) };
    if rgb.len() != pixels {
        return Some(format!("{} pixels", rgb.len()));
    }
    let finite = rgb.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
    (!finite).then(|| "is not finite".into())
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
    let bits = |threads| {
        let rgb = render(scene, threads).rgb().unwrap_or_default();
        rgb.into_iter().flatten().map(f32::to_bits).collect::<Vec<u32>>()
    };
    let one = bits(1);
    found.check(one.iter().any(|bits| *bits != 0), || format!("{name}: black"));
    for threads in [2, 7] {
        found.check(bits(threads) == one, || format!("{name}: {threads} threads give other bits than 1"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What should be refused and is not, and the other way round, is told.
    #[test]
    fn problems_are_found() {
        let good = text(FILMS[0].0, r#""sobol" "integer pixelsamples" 1"#, INTEGRATORS[0], BALLS);
        assert_eq!(problem(&good, Some(64)), None);
        assert!(problem(&good, Some(63)).is_some() && problem(&good, None).is_some());
        let elsewhere = good.replace("Shape \"sphere\"", "Shape \"nothing\" nonsense");
        assert!(problem(&elsewhere, None).is_some());
    }
}
