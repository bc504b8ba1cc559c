//! `Material "disney"`: Disney's material (Burley, "Extending the Disney BRDF to a BSDF with integrated subsurface scattering",
//! SIGGRAPH 2015 course notes; materials/disney.cpp).

use glam::Vec3;

use crate::material::models::{ETA, not_negative, reflectance};
use crate::params::Params;
use crate::params::value::{ColorTexture, FloatTexture};
use crate::schema::{Key, Keys, Range};
use crate::texture::Texture;

/// The material of Disney's animation studio. Shares are clamped to 0 to 1.
#[derive(Debug, Clone)]
pub struct Disney {
    /// The color of diffuse light, of metal, and of light that passes twice (`color`, default 0.5).
    pub color: Texture<Vec3>,
    /// The share of metal (`metallic`, default 0).
    pub metallic: Texture<f64>,
    /// The index of refraction, above 0 (`eta`, default 1.5).
    pub eta: Texture<f64>,
    /// The square root of the width of the microfacet distribution (`roughness`, default 0.5).
    pub roughness: Texture<f64>,
    /// The share of the hue of `color` in the reflection of dielectrics; only metal shows it (`speculartint`, default 0).
    pub specular_tint: Texture<f64>,
    /// How much wider the distribution is along u than along v (`anisotropic`, default 0).
    pub anisotropic: Texture<f64>,
    /// The strength of the reflection of fabric at grazing angles (`sheen`, default 0).
    pub sheen: Texture<f64>,
    /// The share of the hue of `color` in the sheen (`sheentint`, default 0.5).
    pub sheen_tint: Texture<f64>,
    /// The strength of a second glossy layer (`clearcoat`, default 0).
    pub clearcoat: Texture<f64>,
    /// The smoothness of that layer (`clearcoatgloss`, default 1).
    pub clearcoat_gloss: Texture<f64>,
    /// The share of what is not metal that transmits light specularly (`spectrans`, default 0).
    pub spec_trans: Texture<f64>,
    /// The mean free path of light inside of a solid. Where it is 0, the surface is diffuse (`scatterdistance`, default 0).
    pub scatter_distance: Texture<Vec3>,
    /// What belongs to thin sheets only. `None` for solids (`thin`, default false).
    pub thin: Option<ThinDisney>,
}

/// The diffuse light of a thin sheet.
#[derive(Debug, Clone)]
pub struct ThinDisney {
    /// The share of the diffuse reflection that is flat, as by scattering inside (`flatness`, default 0).
    pub flatness: Texture<f64>,
    /// Twice the share of diffuse light that is transmitted, clamped to 0 to 2 (`difftrans`, default 1).
    pub diff_trans: Texture<f64>,
}

impl Disney {
    /// True for a solid that light may enter to leave it at other points.
    pub fn scatters_inside(&self) -> bool {
        self.thin.is_none() && self.scatter_distance.constant() != Some(Vec3::ZERO)
    }

    /// The numbers that can be textures.
    pub(super) fn numbers(&self) -> Vec<&Texture<f64>> {
        let mut all = vec![
            &self.metallic,
            &self.eta,
            &self.roughness,
            &self.specular_tint,
            &self.anisotropic,
            &self.sheen,
            &self.sheen_tint,
            &self.clearcoat,
            &self.clearcoat_gloss,
            &self.spec_trans,
        ];
        all.extend(self.thin.iter().flat_map(|thin| [&thin.flatness, &thin.diff_trans]));
        all
    }
}

const COLOR: Key<ColorTexture> = Key::color_texture("color", 0.5, "the color");
const METALLIC: Key<FloatTexture> = share("metallic", 0.0, "the share of metal, clamped to 0 to 1");
const INDEX: Key<FloatTexture> = Key::float_texture(ETA.name, 1.5, ETA.meaning).within(Range::above(0.0));
const ROUGHNESS: Key<FloatTexture> = Key::float_texture(
    "roughness",
    0.5,
    "the roughness, usually 0 to 1: the square root of the width of the microfacet distribution",
);
const SPECULAR_TINT: Key<FloatTexture> = share(
    "speculartint",
    0.0,
    "how much the gloss takes on the hue of the color where it is part metal, clamped to 0 to 1",
);
const ANISOTROPIC: Key<FloatTexture> =
    share("anisotropic", 0.0, "how much wider the gloss is along u, clamped to 0 to 1");
const SHEEN: Key<FloatTexture> =
    Key::float_texture("sheen", 0.0, "the reflection of fabric at grazing angles");
const SHEEN_TINT: Key<FloatTexture> =
    share("sheentint", 0.5, "how much the sheen takes on the hue of the color, clamped to 0 to 1");
const CLEARCOAT: Key<FloatTexture> = Key::float_texture("clearcoat", 0.0, "the strength of a second gloss");
const CLEARCOAT_GLOSS: Key<FloatTexture> =
    share("clearcoatgloss", 1.0, "the smoothness of the second gloss, clamped to 0 to 1");
const SPEC_TRANS: Key<FloatTexture> = share(
    "spectrans",
    0.0,
    "the share of what is not metal that transmits light as glass does, clamped to 0 to 1",
);
const SCATTER_DISTANCE: Key<ColorTexture> =
    Key::color_texture("scatterdistance", 0.0, "about the mean free path of light inside a solid");
const THIN: Key<bool> = Key::bool("thin", false, "true renders a thin sheet, false a solid");
const FLATNESS: Key<FloatTexture> = share(
    "flatness",
    0.0,
    "the share of a thin sheet's diffuse reflection that is as by scattering inside, clamped to 0 to 1",
);
const DIFF_TRANS: Key<FloatTexture> = Key::float_texture(
    "difftrans",
    1.0,
    "twice the share of diffuse light that a thin sheet transmits, clamped to 0 to 2",
);

const fn share(name: &'static str, default: f64, meaning: &'static str) -> Key<FloatTexture> {
    Key::float_texture(name, default, meaning)
}

pub(super) const KEYS: Keys = &[
    &COLOR,
    &METALLIC,
    &INDEX,
    &ROUGHNESS,
    &SPECULAR_TINT,
    &ANISOTROPIC,
    &SHEEN,
    &SHEEN_TINT,
    &CLEARCOAT,
    &CLEARCOAT_GLOSS,
    &SPEC_TRANS,
    &SCATTER_DISTANCE,
    &THIN,
    &FLATNESS,
    &DIFF_TRANS,
];

pub(super) fn disney(params: &mut Params) -> Disney {
    let color = reflectance(params, &COLOR);
    let eta = params.take(&INDEX);
    let roughness = clamped(params, &ROUGHNESS, f64::INFINITY);
    let [metallic, specular_tint, anisotropic, sheen_tint, clearcoat_gloss, spec_trans] =
        [&METALLIC, &SPECULAR_TINT, &ANISOTROPIC, &SHEEN_TINT, &CLEARCOAT_GLOSS, &SPEC_TRANS]
            .map(|key| clamped(params, key, 1.0));
    let [sheen, clearcoat] = [&SHEEN, &CLEARCOAT].map(|key| {
        let strength = params.take(key);
        warn_outside(params, key.name, &strength, f64::INFINITY, "it is used as 0, as in pbrt-v3");
        strength
    });
    let is_thin = params.take(&THIN);
    let flatness = clamped(params, &FLATNESS, 1.0);
    let diff_trans = clamped(params, &DIFF_TRANS, 2.0);
    let scatter_distance = params.take(&SCATTER_DISTANCE);
    let scatter_distance =
        not_negative(params, SCATTER_DISTANCE.name, scatter_distance, "write distances of 0 or more");
    if is_thin {
        params.unused(SCATTER_DISTANCE.name, "it belongs to solids", "delete scatterdistance or thin");
    } else {
        for key in [&FLATNESS, &DIFF_TRANS] {
            let help = format!("delete {}, or add \"bool thin\" \"true\"", key.name);
            params.unused(key.name, "it belongs to thin sheets", &help);
        }
    }
    let disney = Disney {
        color,
        metallic,
        eta,
        roughness,
        specular_tint,
        anisotropic,
        sheen,
        sheen_tint,
        clearcoat,
        clearcoat_gloss,
        spec_trans,
        scatter_distance,
        thin: is_thin.then_some(ThinDisney { flatness, diff_trans }),
    };
    warn_of_defects(params, &disney);
    disney
}

/// A number from 0 to `most`. Warns of a constant beyond.
fn clamped(params: &mut Params, key: &Key<FloatTexture>, most: f64) -> Texture<f64> {
    let number = params.take(key);
    let Texture::Constant(value) = number else { return number };
    let used = value.clamp(0.0, most);
    warn_outside(params, key.name, &number, most, &format!("it is used as {used}"));
    Texture::Constant(used)
}

fn warn_outside(params: &mut Params, name: &str, number: &Texture<f64>, most: f64, used: &str) {
    let Some(value) = number.constant() else { return };
    let (beyond, help) = if value < 0.0 {
        ("negative".to_string(), "write 0 or more".to_string())
    } else if value > most {
        (format!("above {most}"), format!("the range of {name} is 0 to {most}"))
    } else {
        return;
    };
    params.warn(name, &format!("{name} is {beyond}: {used}"), &help);
}

/// Warns where pbrt-v3 makes light that the source of the model does not.
fn warn_of_defects(params: &mut Params, disney: &Disney) {
    let is = |number: &Texture<f64>, value: f64| number.constant() == Some(value);
    let Disney { metallic, spec_trans, clearcoat, thin, .. } = disney;
    let (is_dielectric, is_opaque) = (is(metallic, 0.0), is(spec_trans, 0.0));
    if let Some(thin) = thin {
        let message = "pbrt-v3 reflects and refracts at thin sheets as at solids, and too much light from behind; \
                       in lookat both sides are alike";
        params.warn(THIN.name, message, "for the picture of pbrt-v3, render solids");
        if !(is_dielectric && is_opaque || is(&thin.diff_trans, 0.0)) {
            let message = "pbrt-v3 transmits diffuse light as if metallic and spectrans were 0: more light than it receives";
            params.warn(
                DIFF_TRANS.name,
                message,
                "write \"float difftrans\" 0 where the sheet is metal or clear",
            );
        }
    }
    if is_opaque {
        return;
    }
    if !is_dielectric {
        let message = "pbrt-v3 transmits light through metal: more light than it receives";
        params.warn(SPEC_TRANS.name, message, "write a spectrans of 0, or a metallic of 0");
    }
    if thin.is_none() && !(is(spec_trans, 1.0) && is(clearcoat, 0.0)) {
        let message = "pbrt-v3 makes light inside of solids that are part diffuse and part clear, or that have a clearcoat; \
                       lookat has diffuse light and clearcoat outside only";
        params.warn(
            SPEC_TRANS.name,
            message,
            "write a spectrans of 0 or 1 without clearcoat: lookat and pbrt-v3 then agree",
        );
    }
}
