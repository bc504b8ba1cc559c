//! The materials that lookat renders, their parameters, and the types of `Material`.

use std::sync::Arc;

use glam::Vec3;
use lookat_syntax::{Diagnostic, ParamType};

use crate::material::{Material, MaterialKind, Named};
use crate::params::Params;
use crate::params::value::{ColorTexture, FloatTexture, Name, OptionalTexture};
use crate::schema::{Key, Keys, Range, Unit};
use crate::texture::Texture;

/// Defines a material: its struct, the keys of its parameters in the order of the documentation, and its constructor. A color is the name,
/// the default and the meaning of its parameter; other fields come after `@`: name, type, the expression that reads it, and its keys.
macro_rules! model {
    (
        $(#[$doc:meta])*
        $model:ident, $keys:ident, $take:ident($params:ident);
        $($(#[$color_doc:meta])* $color:ident: $name:literal, $default:literal, $meaning:literal;)*
        $(@ $(#[$field_doc:meta])* $field:ident: $ty:ty = $value:expr, $($key:expr),+;)*
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone)]
        pub struct $model {
            $($(#[$color_doc])* pub $color: Texture<Vec3>,)*
            $($(#[$field_doc])* pub $field: $ty,)*
        }

        pub(super) const $keys: Keys = &[
            $(&Key::color_texture($name, $default, $meaning),)*
            $($(&$key,)+)*
        ];

        pub(super) fn $take($params: &mut Params) -> $model {
            $model {
                $($color: reflectance($params, &Key::color_texture($name, $default, $meaning)),)*
                $($field: $value,)*
            }
        }
    };
}

// `Material "matte"`: Lambertian, or Oren-Nayar with a `sigma` above 0 (PBR 9.2.1).

model! {
    /// A diffuse surface.
    Matte, MATTE_KEYS, matte(params);
    /// The diffuse reflectance (`Kd`, default 0.5).
    kd: "Kd", 0.5, "the diffuse reflectance";
    @ /// The Oren-Nayar roughness: standard deviation of the facet angle in degrees, clamped to 0 to 90 (`sigma`,
    /// default 0).
    sigma: Texture<f64> = sigma(params), SIGMA;
}

const SIGMA: Key<FloatTexture> = Key::float_texture(
    "sigma",
    0.0,
    "the standard deviation of the facet angle (Oren-Nayar), clamped to 0 to 90; 0 is Lambertian",
)
.unit(Unit::Degrees);

fn sigma(params: &mut Params) -> Texture<f64> {
    let sigma = params.take(&SIGMA);
    if let Texture::Constant(degrees) = sigma
        && !(0.0..=90.0).contains(&degrees)
    {
        let message =
            format!("sigma is out of range: it is used as {}, as in pbrt-v3", degrees.clamp(0.0, 90.0));
        params.warn("sigma", &message, "use a sigma from 0 (smooth) to 90 degrees");
    }
    sigma
}

// `Material "plastic"`: a diffuse base under a rough dielectric coating (PBR 9.2.2).

model! {
    /// A diffuse base under a rough dielectric coating of index 1.5.
    Plastic, PLASTIC_KEYS, plastic(params);
    /// The diffuse reflectance (`Kd`, default 0.25).
    kd: "Kd", 0.25, "the diffuse reflectance";
    /// The factor on glossy reflection (`Ks`, default 0.25).
    ks: "Ks", 0.25, "the factor of glossy reflection";
    @ /// The roughness of the glossy lobe (`roughness`, default 0.1; `remaproughness`).
    roughness: Roughness = Roughness::isotropic(params, &ROUGHNESS), ROUGHNESS, REMAP;
}

/// The roughness of plastic, translucent and uber.
const ROUGHNESS: Key<FloatTexture> = isotropic(0.1);

// `Material "translucent"`: diffuse and glossy reflection and transmission (materials/translucent.cpp).

model! {
    /// A thin surface of index 1.5 that reflects and transmits.
    Translucent, TRANSLUCENT_KEYS, translucent(params);
    /// The factor on diffuse scattering (`Kd`, default 0.25).
    kd: "Kd", 0.25, "the factor of diffuse scattering";
    /// The factor on glossy scattering (`Ks`, default 0.25).
    ks: "Ks", 0.25, "the factor of glossy scattering";
    /// The reflected part of both (`reflect`, default 0.5).
    reflect: "reflect", 0.5, "the share of both that is reflected";
    /// The transmitted part of both (`transmit`, default 0.5).
    transmit: "transmit", 0.5, "the share of both that is transmitted";
    @ /// The roughness of the glossy lobe (`roughness`, default 0.1; `remaproughness`).
    roughness: Roughness = Roughness::isotropic(params, &ROUGHNESS), ROUGHNESS, REMAP;
}

// `Material "glass"`: reflection and refraction at a dielectric boundary (PBR3 8.2, 8.4; materials/glass.cpp).

model! {
    /// Smooth or rough glass.
    Glass, GLASS_KEYS, glass_as_given(params);
    /// The factor on reflection (`Kr`, default 1).
    kr: "Kr", 1.0, "the factor of reflection";
    /// The factor on transmission (`Kt`, default 1).
    kt: "Kt", 1.0, "the factor of refraction";
    @ /// The relative index of refraction, inside over outside (the side of the normal), above 0 (`eta` or `index`,
    /// default 1.5).
    eta: Texture<f64> = index_of_refraction(params), ETA, INDEX;
    @ /// The roughness; smooth where both values are 0 (`uroughness`, `vroughness`, default 0; `remaproughness`).
    roughness: Roughness = Roughness::of_two(params, &SMOOTH), SMOOTH[0], SMOOTH[1], REMAP;
}

const SMOOTH: [Key<FloatTexture>; 2] = along_each(0.0);

pub(super) fn glass(params: &mut Params) -> Glass {
    let glass = glass_as_given(params);
    let Glass { roughness, eta, .. } = &glass;
    let is_smooth = |width: &Texture<f64>| width.constant() == Some(0.0);
    if eta.constant() == Some(1.0)
        && !(is_smooth(&roughness.u) && roughness.v.as_ref().is_some_and(is_smooth))
    {
        let name = if params.was_taken("eta") { "eta" } else { "index" };
        let message = "pbrt-v3 aborts at rough glass of index 1; lookat lets light pass straight through";
        params.warn(name, message, "write an index of 1.001: it looks the same and renders in both programs");
    }
    glass
}

// `Material "mirror"`: a perfect mirror (materials/mirror.cpp).

model! {
    /// A perfect mirror.
    Mirror, MIRROR_KEYS, mirror(params);
    /// The reflectance (`Kr`, default 0.9).
    kr: "Kr", 0.9, "the reflectance";
}

// `Material "metal"`: a rough conductor (PBR 8.2.1, 9.2 of the source, materials/metal.cpp).

/// A rough conductor in air.
#[derive(Debug, Clone)]
pub struct Metal {
    /// The index of refraction, linear RGB (`eta`, default copper).
    pub eta: Texture<Vec3>,
    /// The absorption coefficient, linear RGB (`k`, default copper).
    pub k: Texture<Vec3>,
    /// The roughness (`roughness`, default 0.01; `uroughness`, `vroughness`, `remaproughness`).
    pub roughness: Roughness,
}

/// The index of refraction and absorption of copper: the spectra of pbrt-v3 (materials/metal.cpp), converted to RGB.
const COPPER: [Vec3; 2] = [Vec3::new(0.199990, 0.922086, 1.099876), Vec3::new(3.904638, 2.447633, 2.137651)];

const fn of_copper(name: &'static str, default: Vec3, meaning: &'static str) -> Key<ColorTexture> {
    Key::new(name, ParamType::Rgb, ColorTexture(default), meaning).default_words("copper")
}

const METAL_ETA: Key<ColorTexture> = of_copper("eta", COPPER[0], "the index of refraction");
const K: Key<ColorTexture> = of_copper("k", COPPER[1], "the absorption coefficient");
const METAL_ROUGHNESS: Key<FloatTexture> = isotropic(0.01);
const METAL_ROUGHNESS_V: Key<OptionalTexture> = given_v("roughness");

pub(super) const METAL_KEYS: Keys = &[&METAL_ETA, &K, &METAL_ROUGHNESS, &GIVEN_U, &METAL_ROUGHNESS_V, &REMAP];

pub(super) fn metal(params: &mut Params) -> Metal {
    let [eta, k] = [&METAL_ETA, &K].map(|key| {
        let (name, value) = (key.name, params.take(key));
        // Spectra may give negative color components.
        if value.constant().is_some_and(|color| color.min_element() < 0.0)
            && params.was_of_type(name, &[ParamType::Rgb])
        {
            let message = format!("{name} is negative, which is not physical");
            params.warn(name, &message, "use eta and k above 0; the defaults are copper");
        }
        value
    });
    Metal { eta, k, roughness: Roughness::of_metal(params) }
}

// `Material "substrate"`: a diffuse base under a glossy coating with Fresnel reflection (Ashikhmin and Shirley, PBR
// 8.5).

model! {
    /// A diffuse base under a coating.
    Substrate, SUBSTRATE_KEYS, substrate(params);
    /// The diffuse reflectance (`Kd`, default 0.5).
    kd: "Kd", 0.5, "the diffuse reflectance of the base";
    /// The specular reflectance at normal incidence (`Ks`, default 0.5).
    ks: "Ks", 0.5, "the specular reflectance of the coating at normal incidence";
    @ /// The roughness of the coating (`uroughness`, `vroughness`, default 0.1; `remaproughness`).
    roughness: Roughness = Roughness::of_two(params, &COATING), COATING[0], COATING[1], REMAP;
}

const COATING: [Key<FloatTexture>; 2] = along_each(0.1);

// `Material "uber"`: diffuse, glossy and specular lobes in one material (materials/uber.cpp).

model! {
    /// Diffuse, glossy and specular lobes in one material.
    Uber, UBER_KEYS, uber(params);
    /// The diffuse reflectance (`Kd`, default 0.25).
    kd: "Kd", 0.25, "the diffuse reflectance";
    /// The factor on glossy reflection (`Ks`, default 0.25).
    ks: "Ks", 0.25, "the factor of glossy reflection";
    /// The factor on specular reflection (`Kr`, default 0).
    kr: "Kr", 0.0, "the factor of specular reflection";
    /// The factor on specular transmission (`Kt`, default 0).
    kt: "Kt", 0.0, "the factor of specular refraction";
    /// The opacity; the rest of the light passes straight through (`opacity`, default 1).
    opacity: "opacity", 1.0, "the share of light that meets the surface; the rest passes straight";
    @ /// The relative index of refraction, inside over outside, above 0 (`eta` or `index`, default 1.5).
    eta: Texture<f64> = index_of_refraction(params), ETA, INDEX;
    @ /// The roughness of the glossy lobe (`uroughness`, or `roughness`, default 0.1; `vroughness`, default the same as
    /// u; `remaproughness`).
    roughness: Roughness = Roughness::of_uber(params),
        ROUGHNESS, GIVEN_U, UBER_ROUGHNESS_V, REMAP;
}

const UBER_ROUGHNESS_V: Key<OptionalTexture> = given_v("uroughness");

// `Material "mix"`: a blend of two materials (materials/mixmat.cpp).

/// A blend of two materials. It consists of at most 100, counting the parts of nested mixes.
#[derive(Debug, Clone)]
pub struct Mix {
    /// The two materials (`namedmaterial1`, `namedmaterial2`). Neither is [`MaterialKind::None`].
    pub materials: [Arc<Material>; 2],
    /// The weight of the first material. The second has the rest (`amount`, default 0.5).
    pub amount: Texture<Vec3>,
}

impl Mix {
    /// The most materials in nested mixes. Each level can double the work, so a short file could take forever.
    pub(crate) const MOST: u32 = 100;

    /// The number of materials, counting the parts of nested mixes.
    pub(crate) fn parts(&self) -> u32 {
        let [first, second] = &self.materials;
        first.parts.saturating_add(second.parts)
    }
}

const FIRST: Key<Name> = Key::string(
    "namedmaterial1",
    "the first material, by its name in MakeNamedMaterial; its bump map is used",
)
.required();
const SECOND: Key<Name> =
    Key::string("namedmaterial2", "the second material, by its name in MakeNamedMaterial").required();
const AMOUNT: Key<ColorTexture> = Key::color_texture("amount", 0.5, "the share of the first material");

pub(super) const MIX_KEYS: Keys = &[&FIRST, &SECOND, &AMOUNT];

pub(super) fn mix(params: &mut Params, named: &Named) -> Mix {
    let materials = [&FIRST, &SECOND].map(|key| part(params, key, named));
    let amount = reflectance(params, &AMOUNT);
    let mut mix = Mix { materials, amount };
    if mix.parts() > Mix::MOST {
        let help = "use fewer materials; a material named by two parameters counts twice, with all its parts";
        params.reject("", format!("this mix consists of more than {} materials", Mix::MOST), Some(help));
        mix.materials = [0, 1].map(|_| Arc::new(Material::DEFAULT));
    }
    mix
}

/// One of the two materials. After an error it is matte, as in pbrt-v3.
fn part(params: &mut Params, key: &Key<Name>, named: &Named) -> Arc<Material> {
    let Some(name) = params.take(key) else { return Arc::new(Material::DEFAULT) };
    let material = params.find(named, &name).map(|instance| instance.material.clone());
    let material = material.unwrap_or_else(|| Arc::new(Material::DEFAULT));
    if !matches!(material.kind, MaterialKind::None) {
        return material;
    }
    let message = format!("\"{}\" is not a surface: a mix cannot contain it", name.value);
    let help = "for holes, use \"uber\" with an opacity, or an alpha texture of the shape";
    params.error(Diagnostic::error(name.span, message).help(help));
    Arc::new(Material::DEFAULT)
}

pub(super) const BUMP: Key<OptionalTexture> =
    Key::optional_texture("bumpmap", "the height above the surface, which changes the shading normal")
        .unit(Unit::WorldSpace);
const INDEX: Key<FloatTexture> =
    Key::float_texture("index", 1.5, "another name of eta").within(Range::above(0.0));
pub(super) const ETA: Key<OptionalTexture> =
    Key::optional_texture("eta", "the index of refraction, inside over outside")
        .within(Range::above(0.0))
        .default_words("index");

pub(super) fn bump(params: &mut Params) -> Option<Texture<f64>> {
    // A constant height of 0 has no effect.
    params.take(&BUMP).filter(|bump| bump.constant() != Some(0.0))
}

/// A reflectance or transmittance. Negative values count as 0, as in pbrt-v3.
pub(super) fn reflectance(params: &mut Params, key: &Key<ColorTexture>) -> Texture<Vec3> {
    let reflectance = params.take(key);
    let name = key.name;
    let Texture::Constant(color) = reflectance else { return reflectance };
    // A spectrum with values up to 1 may give a color above 1, or negative components.
    let is_rgb = params.was_of_type(name, &[ParamType::Rgb, ParamType::Texture]);
    if color.max_element() > 1.0 && is_rgb {
        params.warn(
            name,
            &format!("{name} is above 1: the surface reflects more light than it receives"),
            "use colors from 0 to 1: divide by 255 if yours go to 255",
        );
    }
    not_negative(params, name, reflectance, "use colors from 0 to 1")
}

/// A color of which negative components count as 0, with a warning if it is a constant that has them.
pub(super) fn not_negative(
    params: &mut Params,
    name: &'static str,
    color: Texture<Vec3>,
    help: &str,
) -> Texture<Vec3> {
    let Texture::Constant(constant) = color else { return color };
    // Spectra outside of the sRGB gamut have negative components.
    if constant.min_element() < 0.0 && params.was_of_type(name, &[ParamType::Rgb, ParamType::Texture]) {
        params.warn(name, &format!("{name} is negative: it is used as 0"), help);
    }
    Texture::Constant(constant.max(Vec3::ZERO))
}

/// The index of refraction by either name. `eta` has precedence, as in pbrt-v3.
fn index_of_refraction(params: &mut Params) -> Texture<f64> {
    let eta = params.take(&ETA);
    let range = if eta.is_some() { Range::ALL } else { INDEX.range };
    let index = params.take(&Key { range, ..INDEX });
    params.replaced_by("index", &["eta"]);
    eta.unwrap_or(index)
}

/// The roughness along the two directions of the texture coordinates.
#[derive(Debug, Clone)]
pub struct Roughness {
    /// Along u.
    pub u: Texture<f64>,
    /// Along v. `None` means the same as along u.
    pub v: Option<Texture<f64>>,
    /// If true, values from 0 to 1 are converted to the microfacet alpha by pbrt-v3's RoughnessToAlpha. If false,
    /// they are alpha (`remaproughness`, default true).
    pub remap: bool,
}

pub(super) const REMAP: Key<bool> = Key::bool(
    "remaproughness",
    true,
    "true converts roughness from 0 to 1 to the width of the microfacet distribution, false takes it as the width",
);

const ALONG_U: &str = "the roughness along the texture coordinate u, usually 0 to 1";
const ALONG_V: &str = "the roughness along the texture coordinate v, usually 0 to 1";

const fn isotropic(default: f64) -> Key<FloatTexture> {
    Key::float_texture("roughness", default, "the roughness, usually 0 to 1")
}

/// `uroughness` and `vroughness`.
pub(super) const fn along_each(default: f64) -> [Key<FloatTexture>; 2] {
    [Key::float_texture("uroughness", default, ALONG_U), Key::float_texture("vroughness", default, ALONG_V)]
}

const GIVEN_U: Key<OptionalTexture> = Key::optional_texture("uroughness", ALONG_U).default_words("roughness");

const fn given_v(default_words: &'static str) -> Key<OptionalTexture> {
    Key::optional_texture("vroughness", ALONG_V).default_words(default_words)
}

impl Roughness {
    /// `roughness` alone.
    pub(super) fn isotropic(params: &mut Params, both: &Key<FloatTexture>) -> Self {
        let u = params.take(both);
        let remap = remap(params, &[(both.name, Some(&u))]);
        Roughness { u, v: None, remap }
    }

    /// `uroughness` and `vroughness`.
    pub(super) fn of_two(params: &mut Params, keys: &[Key<FloatTexture>; 2]) -> Self {
        let [u, v] = keys.each_ref().map(|key| params.take(key));
        let remap = remap(params, &[(keys[0].name, Some(&u)), (keys[1].name, Some(&v))]);
        Roughness { u, v: Some(v), remap }
    }

    /// `roughness`, which `uroughness` and `vroughness` each replace.
    fn of_metal(params: &mut Params) -> Self {
        let (both, [u, v], remap) = of_three(params, &METAL_ROUGHNESS, &METAL_ROUGHNESS_V);
        params.replaced_by("roughness", &["uroughness", "vroughness"]);
        let v = v.or(u.is_some().then(|| both.clone()));
        Roughness { u: u.unwrap_or(both), v, remap }
    }

    /// `roughness` or `uroughness` for u, and `vroughness` for v (default the same as u).
    fn of_uber(params: &mut Params) -> Self {
        let (both, [u, v], remap) = of_three(params, &ROUGHNESS, &UBER_ROUGHNESS_V);
        params.replaced_by("roughness", &["uroughness"]);
        Roughness { u: u.unwrap_or(both), v, remap }
    }
}

/// `roughness`, `uroughness` and `vroughness` if they are given, and `remaproughness`.
fn of_three(
    params: &mut Params,
    both: &Key<FloatTexture>,
    v: &Key<OptionalTexture>,
) -> (Texture<f64>, [Option<Texture<f64>>; 2], bool) {
    let first = params.take(both);
    let [along_u, along_v] = [&GIVEN_U, v].map(|key| params.take(key));
    let all = [(both.name, Some(&first)), (GIVEN_U.name, along_u.as_ref()), (v.name, along_v.as_ref())];
    let remap = remap(params, &all);
    (first, [along_u, along_v], remap)
}

/// Takes `remaproughness`, and warns of roughness outside 0 to 1. Negative values give the narrowest lobe, as in pbrt-v3.
/// Widths above 1 are normal: the conversion gives 1.62 for 1.
fn remap(params: &mut Params, all: &[(&str, Option<&Texture<f64>>)]) -> bool {
    let remap = params.take(&REMAP);
    for (name, roughness) in all {
        let value = roughness.and_then(|roughness| roughness.constant()).unwrap_or(0.0);
        let (what, help) = if value < 0.0 {
            ("negative: the surface is almost smooth, as in pbrt-v3", "the usual range is 0 to 1")
        } else if value > 1.0 && remap {
            let help =
                "write a roughness from 0 to 1; if it is a width, add \"bool remaproughness\" \"false\"";
            ("above the usual range 0 to 1", help)
        } else {
            continue;
        };
        params.warn(name, &format!("{name} is {what}"), help);
    }
    remap
}

pub(super) fn gray(value: f32) -> Texture<Vec3> {
    Texture::Constant(Vec3::splat(value))
}
