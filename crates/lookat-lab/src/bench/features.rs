//! What each feature costs: one scene, with one thing more at a time.

use std::path::Path;

use lookat_render::{Precision, Settings, Stop};
use lookat_scene::Scene;

use super::rendering::render;
use super::table::{Cell, Row, Table, in_turn, timed};

/// Two spheres on a floor under four lamps, with all that can be left out left out.
const BASE: &str = r#"LookAt 0 2 -5  0 0.6 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 160 "integer yresolution" 120
PixelFilter "box"
Sampler "sobol" "integer pixelsamples" 16
Integrator "path" "integer maxdepth" 4 "string lightsamplestrategy" "uniform"
WorldBegin
LightSource "point" "point from" [-3 4 -2] "rgb I" [9 9 9]
LightSource "point" "point from" [3 4 -2] "rgb I" [9 9 9]
LightSource "point" "point from" [-3 4 2] "rgb I" [9 9 9]
LightSource "point" "point from" [3 4 2] "rgb I" [9 9 9]
#textures
Material "matte" "rgb Kd" [.6 .6 .6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 0 -9 -9 0 9 9 0 9 9 0 -9] "float uv" [0 0 0 9 9 9 9 0]
Material "matte" "rgb Kd" [.7 .5 .3]
Translate -1 1 0
Shape "sphere"
Translate 2.1 0 0
Shape "sphere"
WorldEnd
"#;

/// What is put in place of what.
type Change = (&'static str, &'static str);

/// A feature: its name, what of the base it changes, and how it is rendered.
struct Feature {
    name: &'static str,
    changes: &'static [Change],
    settings: fn(&mut Settings),
}

const fn in_scene(name: &'static str, changes: &'static [Change]) -> Feature {
    Feature { name, changes, settings: |_| {} }
}

const MATTE: &str = r#"Material "matte" "rgb Kd" [.7 .5 .3]"#;
const FLOOR: &str = r#"Material "matte" "rgb Kd" [.6 .6 .6]"#;
const TEXTURED: &str = r#"Material "matte" "texture Kd" "t""#;
const LAST: &str = "Translate 2.1 0 0\nShape \"sphere\"";

const FEATURES: &[Feature] = &[
    in_scene("base: a pinhole, diffuse surfaces, four lamps", &[]),
    in_scene(
        "thin lens",
        &[("\"float fov\" 40", "\"float fov\" 40 \"float lensradius\" .1 \"float focaldistance\" 5")],
    ),
    in_scene("gaussian filter", &[("\"box\"", "\"gaussian\"")]),
    in_scene("halton sampler", &[("\"sobol\"", "\"halton\"")]),
    in_scene("lights by power", &[("\"uniform\"", "\"power\"")]),
    in_scene("lights by their light at the point", &[("\"uniform\"", "\"spatial\"")]),
    in_scene(
        "picture as texture, filtered",
        &[
            ("#textures", r#"Texture "t" "spectrum" "imagemap" "string filename" "picture.pfm""#),
            (FLOOR, TEXTURED),
        ],
    ),
    in_scene(
        "checkerboard, filtered",
        &[
            (
                "#textures",
                r#"Texture "t" "spectrum" "checkerboard" "rgb tex1" [.7 .7 .7] "rgb tex2" [.5 .5 .5]"#,
            ),
            (FLOOR, TEXTURED),
        ],
    ),
    in_scene(
        "bumps of noise",
        &[
            ("#textures", r#"Texture "t" "float" "fbm""#),
            (FLOOR, r#"Material "matte" "rgb Kd" [.6 .6 .6] "texture bumpmap" "t""#),
        ],
    ),
    in_scene(
        "holes",
        &[
            ("#textures", r#"Texture "t" "float" "checkerboard""#),
            ("\"float uv\" [0", "\"texture alpha\" \"t\" \"float uv\" [0"),
        ],
    ),
    in_scene(
        "rough diffuse surfaces",
        &[(MATTE, r#"Material "matte" "rgb Kd" [.7 .5 .3] "float sigma" 20"#)],
    ),
    in_scene("plastic", &[(MATTE, r#"Material "plastic" "rgb Kd" [.7 .5 .3]"#)]),
    in_scene("smooth glass", &[(MATTE, r#"Material "glass""#)]),
    in_scene("rough glass", &[(MATTE, r#"Material "glass" "float uroughness" .2 "float vroughness" .2"#)]),
    in_scene(
        "instances",
        &[
            (LAST, "ObjectInstance \"o\" Translate 2.1 0 0 ObjectInstance \"o\""),
            (
                "Translate -1 1 0\nShape \"sphere\"",
                "ObjectBegin \"o\" Shape \"sphere\" ObjectEnd Translate -1 1 0",
            ),
        ],
    ),
    Feature {
        name: "error layers",
        changes: &[],
        settings: |settings| settings.stop = Stop::Samples { error_layers: true },
    },
    Feature { name: "f64 alone", changes: &[], settings: |settings| settings.precision = Precision::Double },
];

/// Each feature by its ratio to the base, in the same round.
pub(super) fn table(rounds: usize) -> Table {
    let scenes: Vec<Scene> = FEATURES.iter().map(scene).collect();
    let measured = in_turn(rounds, FEATURES.len(), |feature| {
        let mut settings = Settings { threads: 1, ..Settings::default() };
        (FEATURES[feature].settings)(&mut settings);
        let (seconds, rendered) = timed(|| render(&scenes[feature], &settings));
        (seconds, rendered.statistics.rays as f64)
    });
    let base = measured[0].clone();
    let row = |(feature, measured): (&Feature, &Vec<(f64, f64)>)| {
        let of = |value: &dyn Fn((f64, f64), (f64, f64)) -> f64| {
            Cell::of(measured.iter().zip(&base).map(|(own, base)| value(*own, *base)))
        };
        let cells = vec![
            of(&|own, _| own.0),
            of(&|own, base| own.0 / base.0),
            of(&|own, base| own.1 / base.1),
            of(&|own, base| own.0 / own.1 / (base.0 / base.1)),
        ];
        Row { name: feature.name.into(), cells }
    };
    Table {
        name: "features",
        title: "the base scene with one more feature, on one thread; ratios to the base".into(),
        columns: vec!["s", "time", "rays", "time of a ray"],
        rows: FEATURES.iter().zip(&measured).map(row).collect(),
    }
}

/// The base as a feature changes it.
///
/// # Panics
///
/// If that gives no scene, or changes nothing.
fn scene(feature: &Feature) -> Scene {
    let mut text = BASE.to_owned();
    for (from, to) in feature.changes {
        assert!(text.contains(from), "{}: {from}", feature.name);
        text = text.replacen(from, to, 1);
    }
    let read = |path: &Path| match path.extension() {
        Some(_) => Ok(picture()),
        None => Ok(text.clone().into_bytes()),
    };
    let loaded = lookat_scene::load(Path::new("scene"), &read, &Default::default());
    loaded.scene.unwrap_or_else(|| panic!("{}: {:?}", feature.name, loaded.diagnostics))
}

/// Colors, 256 by 256.
fn picture() -> Vec<u8> {
    let mut bytes = b"PF\n256 256\n-1.0\n".to_vec();
    for at in 0..256 * 256_u32 {
        for channel in 0..3 {
            let value = (at.wrapping_mul(2_654_435_761) >> (8 * channel) & 255) as f32 / 255.0;
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_feature_makes_another_scene() {
        let inspected = |feature: &Feature| lookat_render::inspect(&scene(feature));
        let base = inspected(&FEATURES[0]);
        assert!(!base.has_lens && !base.has_filter_table && !base.has_cutouts && base.world.instances == 0);
        assert_eq!(
            base.surfaces.as_ref().map(|surfaces| (surfaces.lambert, surfaces.coordinates)),
            Some((2, 0))
        );
        // The sampler and the precision are not asked for there.
        for feature in FEATURES.iter().filter(|feature| !feature.changes.is_empty()) {
            assert!(feature.name == "halton sampler" || inspected(feature) != base, "{}", feature.name);
        }
    }
}
