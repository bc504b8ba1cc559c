//! `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
//! of a half space of the medium.

use glam::Vec3;
use lookat_syntax::{Diagnostic, ParamType, Text, nearest};

use super::diffusion::{diffuse_transmittance, reflectance};
use super::media::{MEDIA, Medium};
use super::{MaterialKind, Roughness, constant_color, glossy, gray, share};
use crate::material::roughness::{self, REMAP};
use crate::params::{Params, Take};
use crate::schema::{ColorTexture, DefaultValue, Effect, FloatTexture, Key, Keys, Name, Range};
use crate::texture::{Texture, TextureParams, product};

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.5, "the diffuse reflectance");
const MEAN_FREE_PATH: Key<ColorTexture> =
    Key::color_texture("mfp", 1.0, "the mean free path of light inside").effect(Effect::NotRendered);
const NAME: Key<MediumName> =
    Key::new("name", ParamType::String, MediumName, "the measured medium that gives the coefficients");
const SIGMA_A: Key<ColorTexture> =
    coefficient("sigma_a", [0.0011, 0.0024, 0.014], "the absorption coefficient, per millimeter");
const SIGMA_S: Key<ColorTexture> =
    coefficient("sigma_s", [2.55, 3.21, 3.77], "the scattering coefficient, per millimeter");
const G: Key<f64> = Key::float("g", 0.0, "the asymmetry of scattering, clamped to -1 (back) to 1 (forward)");
/// A factor of both coefficients leaves the reflectance of a half space as it is.
const SCALE: Key<f64> = Key::float("scale", 1.0, "a factor of the coefficients").effect(Effect::NotRendered);
const ETA: Key<f64> = Key::float("eta", 1.33, "the index of refraction").within(Range::above(0.0));
const KR: Key<ColorTexture> = Key::color_texture("Kr", 1.0, "the factor of reflection at the surface");
const KT: Key<ColorTexture> = Key::color_texture("Kt", 1.0, "the factor of light that enters");
const ROUGHNESS_U: Key<FloatTexture> = roughness::along_u(0.0);
const ROUGHNESS_V: Key<FloatTexture> = roughness::along_v(0.0);

const fn coefficient(name: &'static str, default: [f32; 3], meaning: &'static str) -> Key<ColorTexture> {
    Key::new(name, ParamType::Rgb, ColorTexture(Vec3::from_array(default)), meaning)
}

/// The name of a measured medium, if given.
#[derive(Clone, Copy)]
struct MediumName;

impl DefaultValue for MediumName {
    fn words(self) -> String {
        Name.words()
    }

    fn range(self, _: Range) -> String {
        format!("one of {}", MEDIA.iter().map(|medium| medium.name).collect::<Vec<_>>().join(", "))
    }
}

impl Take for MediumName {
    type Taken = Option<Text>;

    fn take(key: &Key<MediumName>, params: &mut Params) -> Option<Text> {
        params.take(&Key::string(key.name, key.meaning))
    }
}

const G_OF_COLOR: Key<f64> = G.effect(Effect::NotRendered);

pub(in crate::material) const COLOR: Keys = &[&KD, &MEAN_FREE_PATH, &G_OF_COLOR, &SCALE];
pub(in crate::material) const COEFFICIENTS: Keys = &[&NAME, &SIGMA_A, &SIGMA_S, &G, &SCALE];
pub(in crate::material) const SURFACE: Keys = &[&ETA, &KR, &KT, &ROUGHNESS_U, &ROUGHNESS_V, &REMAP];

/// `kdsubsurface`: `Kd` is the reflectance.
pub(super) fn of_color(params: &mut TextureParams) -> MaterialKind {
    let kd = share(params, &KD);
    let eta = params.take(&ETA);
    under_gloss(params, kd, eta)
}

/// `subsurface`: the coefficients, or a named medium, give the reflectance.
pub(super) fn of_coefficients(params: &mut TextureParams) -> MaterialKind {
    let medium = named_medium(params);
    let g = if medium.is_some() { 0.0 } else { params.take(&G).clamp(-1.0, 1.0) };
    let of_medium = |key: Key<ColorTexture>, of: fn(&Medium) -> [f32; 3]| match medium {
        Some(medium) => Key { default: ColorTexture(of(medium).into()), ..key },
        None => key,
    };
    let absorption = constant_color(params, &of_medium(SIGMA_A, |medium| medium.absorption));
    let scattering = constant_color(params, &of_medium(SIGMA_S, |medium| medium.scattering));
    params.take(&SCALE);
    let eta = params.take(&ETA);
    let channel =
        |a: f32, s: f32| if s > 0.0 { reflectance((s / (a + s)).into(), g, eta) as f32 } else { 0.0 };
    let [a, s] = [absorption.to_array(), scattering.to_array()];
    let kd = Vec3::from_array([0, 1, 2].map(|at| channel(a[at], s[at])));
    under_gloss(params, Texture::Constant(kd), eta)
}

fn named_medium(params: &mut TextureParams) -> Option<&'static Medium> {
    let name = params.take(&NAME).filter(|name| !name.value.is_empty())?;
    let medium = MEDIA.iter().find(|medium| medium.name == name.value);
    if medium.is_none() {
        let message =
            "there is no measured medium of this name: the default coefficients are used, as in pbrt-v3";
        let warning = Diagnostic::warning(name.span, message);
        params.push(match nearest(&name.value, MEDIA.iter().map(|medium| medium.name)) {
            Some(near) => {
                warning.help(format!("did you mean \"{near}\"?")).fix(name.span, format!("\"{near}\""))
            }
            None => warning.help("docs/supported.md lists the names; sigma_a and sigma_s give other media"),
        });
    }
    medium
}

/// The diffuse color, as light leaves it through the surface, under the surface's own reflection.
fn under_gloss(params: &mut TextureParams, color: Texture<Vec3>, eta: f64) -> MaterialKind {
    let [kr, kt] = [&KR, &KT].map(|key| share(params, key));
    let roughness = Roughness::of_two(params, [&ROUGHNESS_U, &ROUGHNESS_V]);
    let is_zero = |width: &Texture<f64>| width.constant() == Some(0.0);
    let is_smooth = is_zero(&roughness.u) && roughness.v.as_ref().is_some_and(is_zero);
    let factor = product(params, [gray(diffuse_transmittance(eta) as f32), kt]);
    let kd = product(params, [factor, color]);
    let mut uber = glossy(kd, kr, roughness, eta);
    if is_smooth {
        (uber.kr, uber.ks) = (uber.ks, gray(0.0));
    }
    MaterialKind::Uber(Box::new(uber))
}
