//! `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
//! of a half space of the medium.

use std::f64::consts::PI;

use glam::Vec3;
use lookat_syntax::{Diagnostic, ParamType, Text, nearest};

use crate::material::MaterialKind;
use crate::material::models::{REMAP, Roughness, along_u, along_v, share};
use crate::material::stand_in::{constant_color, glossy, gray, polynomial};
use crate::params::{Params, Take};
use crate::schema::{ColorTexture, DefaultValue, Effect, FloatTexture, Key, Keys, Name, Range};
use crate::texture::{Texture, TextureParams, product};

// `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
// of a half space of the medium.

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
const ROUGHNESS_U: Key<FloatTexture> = along_u(0.0);
const ROUGHNESS_V: Key<FloatTexture> = along_v(0.0);

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

// The diffuse reflectance of a half space, by photon beam diffusion (PBR 15.5, core/bssrdf.cpp; Habel et al. 2013).

/// Indices that the fits of Fresnel moments are for.
const FITTED: [f64; 2] = [0.4, 2.5];

/// The transmittance of a boundary for diffuse light from outside. `eta`: the index of refraction, inside over outside.
fn diffuse_transmittance(eta: f64) -> f64 {
    let reflected = 2.0 * fresnel_moment_1(1.0 / eta.clamp(FITTED[0], FITTED[1]));
    (1.0 - reflected).clamp(0.0, 1.0)
}

/// The share of the light below the surface of a half space that comes back to it. `rho`: the albedo of a scattering event,
/// 0 to 1; `g`: the asymmetry of the phase function; `eta`: the index of refraction.
pub(super) fn reflectance(rho: f64, g: f64, eta: f64) -> f64 {
    // Radii in mean free paths, from 3e-4 to 200 by equal ratios.
    const STEP: f64 = 1.0 / 3.0;
    let eta = eta.clamp(FITTED[0], FITTED[1]);
    let radii = (-24..=16).map(|step| libm::exp(f64::from(step) * STEP));
    let ring = |r: f64| 2.0 * PI * r * r * STEP * (single(rho, g, eta, r) + multiple(rho, g, eta, r));
    radii.map(ring).sum::<f64>().clamp(0.0, 1.0)
}

/// Depths along a beam, by equal shares of its light, in mean free paths.
fn depths() -> impl Iterator<Item = f64> {
    const COUNT: usize = 16;
    (0..COUNT).map(|index| -libm::log(1.0 - (index as f64 + 0.5) / COUNT as f64))
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count)
}

/// Light that scatters once (BeamDiffusionSS).
fn single(rho: f64, g: f64, eta: f64, r: f64) -> f64 {
    let t_critical = r * (eta * eta - 1.0).max(0.0).sqrt();
    mean(depths().map(|depth| {
        let t = t_critical + depth;
        let distance = libm::hypot(r, t);
        let cos = t / distance;
        let phase = (1.0 - g * g) / (4.0 * PI * libm::pow((1.0 + g * g + 2.0 * g * cos).max(1e-9), 1.5));
        let leaves = 1.0 - fresnel_leaving(cos, eta);
        rho * libm::exp(-(distance + t_critical)) / (distance * distance) * phase * leaves * cos
    }))
}

/// Light that scatters more often, as from a dipole (BeamDiffusionMS).
fn multiple(rho: f64, g: f64, eta: f64, r: f64) -> f64 {
    let (sigma_s, sigma_a) = (rho * (1.0 - g), 1.0 - rho);
    let sigma_t = sigma_s + sigma_a;
    if sigma_t <= 0.0 {
        return 0.0;
    }
    let albedo = sigma_s / sigma_t;
    let diffusion = (2.0 * sigma_a + sigma_s) / (3.0 * sigma_t * sigma_t);
    let sigma_tr = (sigma_a / diffusion).sqrt();
    let (first, second) = (fresnel_moment_1(eta), fresnel_moment_2(eta));
    let extrapolation = -2.0 * diffusion * (1.0 + 3.0 * second) / (1.0 - 2.0 * first);
    let (of_fluence, of_flux) = (0.25 * (1.0 - 2.0 * first), 0.5 * (1.0 - 3.0 * second));
    let fluence = |d: f64| libm::exp(-sigma_tr * d) / d;
    let flux = |z: f64, d: f64| z * (1.0 + sigma_tr * d) * libm::exp(-sigma_tr * d) / (d * d * d);
    mean(depths().map(|depth| {
        let real = depth / sigma_t;
        let mirrored = -real + 2.0 * extrapolation;
        let [d_real, d_mirrored] = [real, mirrored].map(|z| libm::hypot(r, z));
        let phi = (fluence(d_real) - fluence(d_mirrored)) / (4.0 * PI * diffusion);
        let e = (flux(real, d_real) - flux(mirrored, d_mirrored)) / (4.0 * PI);
        let near = 1.0 - libm::exp(-2.0 * sigma_t * (d_real + real));
        near * albedo * albedo * (phi * of_fluence + e * of_flux)
    }))
}

/// Fresnel reflectance of a dielectric of index `eta` for light that leaves it at a cosine.
fn fresnel_leaving(cos: f64, eta: f64) -> f64 {
    let sin2 = eta * eta * (1.0 - cos * cos);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let outside = (1.0 - sin2).sqrt();
    let [parallel, perpendicular] =
        [[cos, eta * outside], [eta * cos, outside]].map(|[a, b]| ((a - b) / (a + b)).powi(2));
    0.5 * (parallel + perpendicular)
}

/// First moment of the Fresnel reflectance (d'Eon and Irving 2011).
fn fresnel_moment_1(eta: f64) -> f64 {
    let coefficients = match eta < 1.0 {
        true => [-0.68441, 2.49277, -3.904945, 3.37668, -1.73965, 0.45966],
        false => [0.12746, -1.27198, 5.11455, -10.4646, 11.1136, -4.61686],
    };
    polynomial(coefficients, eta)
}

/// Second moment of the same.
fn fresnel_moment_2(eta: f64) -> f64 {
    if eta < 1.0 {
        return polynomial([0.0486, 0.07883, -0.65095, 1.12077, -0.8735, 0.27614], eta);
    }
    polynomial([0.63942, -9.00603, 54.9327, -189.519, 404.557, 0.0], eta)
        + polynomial([45.3087, -218.725, 458.843, -547.033], 1.0 / eta)
}

// Scattering coefficients of measured media, per millimeter, as pbrt-v3 has them (core/medium.cpp).
//
// - The first twelve: Jensen, Marschner, Levoy, Hanrahan, "A Practical Model for Subsurface Light Transport", SIGGRAPH 2001
// - The others: Narasimhan et al., "Acquiring Scattering Properties of Participating Media by Dilution", SIGGRAPH 2006

/// A measured medium.
pub(super) struct Medium {
    /// Its name in scenes.
    pub name: &'static str,
    /// Reduced scattering coefficient (red, green, blue), per millimeter.
    pub scattering: [f32; 3],
    /// Absorption coefficient (red, green, blue), per millimeter.
    pub absorption: [f32; 3],
}

const fn medium(name: &'static str, scattering: [f32; 3], absorption: [f32; 3]) -> Medium {
    Medium { name, scattering, absorption }
}

#[rustfmt::skip]
const MEDIA: &[Medium] = &[
    medium("Apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046]),
    medium("Chicken1", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    medium("Chicken2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.2]),
    medium("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    medium("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    medium("Marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071]),
    medium("Potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12]),
    medium("Skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142]),
    medium("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    medium("Skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145]),
    medium("Spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0]),
    medium("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
    medium("Lowfat Milk", [0.89187, 1.5136, 2.532], [0.002875, 0.00575, 0.0115]),
    medium("Reduced Milk", [2.4858, 3.1669, 4.5214], [0.0025556, 0.0051111, 0.012778]),
    medium("Regular Milk", [4.5513, 5.8294, 7.136], [0.0015333, 0.0046, 0.019933]),
    medium("Espresso", [0.72378, 0.84557, 1.0247], [4.7984, 6.5751, 8.8493]),
    medium("Mint Mocha Coffee", [0.31602, 0.38538, 0.48131], [3.772, 5.8228, 7.82]),
    medium("Lowfat Soy Milk", [0.30576, 0.34233, 0.61664], [0.0014375, 0.0071875, 0.035937]),
    medium("Regular Soy Milk", [0.59223, 0.73866, 1.4693], [0.0019167, 0.0095833, 0.065167]),
    medium("Lowfat Chocolate Milk", [0.64925, 0.83916, 1.1057], [0.0115, 0.0368, 0.1564]),
    medium("Regular Chocolate Milk", [1.4585, 2.1289, 2.9527], [0.010063, 0.043125, 0.14375]),
    medium("Coke", [8.9053e-05, 8.372e-05, 0.0], [0.10014, 0.16503, 0.2468]),
    medium("Pepsi", [6.1697e-05, 4.2564e-05, 0.0], [0.091641, 0.14158, 0.20729]),
    medium("Sprite", [6.0306e-06, 6.4139e-06, 6.5504e-06], [0.001886, 0.0018308, 0.0020025]),
    medium("Gatorade", [0.0024574, 0.003007, 0.0037325], [0.024794, 0.019289, 0.008878]),
    medium("Chardonnay", [1.7982e-05, 1.3758e-05, 1.2023e-05], [0.010782, 0.011855, 0.023997]),
    medium("White Zinfandel", [1.7501e-05, 1.9069e-05, 1.288e-05], [0.012072, 0.016184, 0.019843]),
    medium("Merlot", [2.1129e-05, 0.0, 0.0], [0.11632, 0.25191, 0.29434]),
    medium("Budweiser Beer", [2.4356e-05, 2.4079e-05, 1.0564e-05], [0.011492, 0.024911, 0.057786]),
    medium("Coors Light Beer", [5.0922e-05, 4.301e-05, 0.0], [0.006164, 0.013984, 0.034983]),
    medium("Clorox", [0.0024035, 0.0031373, 0.003991], [0.0033542, 0.014892, 0.026297]),
    medium("Apple Juice", [0.00013612, 0.00015836, 0.000227], [0.012957, 0.023741, 0.052184]),
    medium("Cranberry Juice", [0.00010402, 0.00011646, 7.8139e-05], [0.039437, 0.094223, 0.12426]),
    medium("Grape Juice", [5.382e-05, 0.0, 0.0], [0.10404, 0.23958, 0.29325]),
    medium("Ruby Grapefruit Juice", [0.011002, 0.010927, 0.011036], [0.085867, 0.18314, 0.25262]),
    medium("White Grapefruit Juice", [0.22826, 0.23998, 0.32748], [0.0138, 0.018831, 0.056781]),
    medium("Shampoo", [0.0007176, 0.0008303, 0.0009016], [0.014107, 0.045693, 0.061717]),
    medium("Strawberry Shampoo", [0.00015671, 0.00015947, 1.518e-05], [0.01449, 0.05796, 0.075823]),
    medium("Head & Shoulders Shampoo", [0.023805, 0.028804, 0.034306], [0.084621, 0.15688, 0.20365]),
    medium("Lemon Tea Powder", [0.040224, 0.045264, 0.051081], [2.4288, 4.5757, 7.2127]),
    medium("Orange Powder", [0.00015617, 0.00017482, 0.0001762], [0.001449, 0.003441, 0.007863]),
    medium("Pink Lemonade Powder", [0.00012103, 0.00013073, 0.00012528], [0.001165, 0.002366, 0.003195]),
    medium("Cappuccino Powder", [1.8436, 2.5851, 2.1662], [35.844, 49.547, 61.084]),
    medium("Salt Powder", [0.027333, 0.032451, 0.031979], [0.28415, 0.3257, 0.34148]),
    medium("Sugar Powder", [0.00022272, 0.00025513, 0.000271], [0.012638, 0.031051, 0.050124]),
    medium("Suisse Mocha Powder", [2.7979, 3.5452, 4.3365], [17.502, 27.004, 35.433]),
    medium("Pacific Ocean Surface Water", [0.0001764, 0.00032095, 0.00019617], [0.031845, 0.031324, 0.030147]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// pbrt-v3's table (ComputeBeamDiffusionBSSRDF), computed with its 100 depths and 64 radii.
    #[test]
    fn reflectances_are_those_of_pbrt() {
        for (rho, g, eta, expected) in [
            (0.99991, 0.0, 1.33, 0.98923),
            (0.9995, 0.0, 1.33, 0.93497),
            (0.99, 0.0, 1.33, 0.67273),
            (0.9, 0.0, 1.33, 0.29557),
            (0.747, 0.0, 1.3, 0.15969),
            (0.5, 0.0, 1.33, 0.06617),
            (0.067, 0.0, 1.3, 0.00547),
            (0.999, 0.8, 1.33, 0.69376),
            (0.95, 0.0, 1.5, 0.33896),
            (0.9, -0.3, 1.33, 0.40365),
        ] {
            let found = reflectance(rho, g, eta);
            assert!((found / expected - 1.0).abs() < 0.03, "{rho} {g} {eta}: {found}, not {expected}");
        }
        assert_eq!(reflectance(0.0, 0.0, 1.33), 0.0);
    }

    #[test]
    fn media_of_other_colors_differ() {
        let of = |name: &str| {
            let medium = MEDIA.iter().find(|medium| medium.name == name).unwrap();
            [0, 2].map(|at| {
                let [s, a] = [medium.scattering, medium.absorption].map(|it| f64::from(it[at]));
                reflectance(s / (s + a), 0.0, 1.33)
            })
        };
        let ([ketchup, _], [_, ketchup_blue]) = (of("Ketchup"), of("Ketchup"));
        assert!(ketchup > 10.0 * ketchup_blue, "ketchup is red");
        assert!(of("Wholemilk")[0] > 0.8, "milk is bright");
    }
}
