//! `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
//! of a half space of the medium.

use std::f64::consts::PI;

use glam::Vec3;
use lookat_syntax::ParamType;

use crate::material::MaterialKind;
use crate::material::models::{
    REMAP, Roughness, along_each, constant_color, glossy, gray, polynomial, reflectance,
};
use crate::medium::measured::{MeasuredMedium, MediumName, measured};
use crate::params::Params;
use crate::params::value::{ColorTexture, FloatTexture};
use crate::schema::{Key, Keys, Range};
use crate::texture::{Texture, product};

const KD: Key<ColorTexture> = Key::color_texture("Kd", 0.5, "the diffuse reflectance");
const NAME: Key<MediumName> = measured("name", "the measured medium that gives the coefficients");
const SIGMA_A: Key<ColorTexture> =
    coefficient("sigma_a", [0.0011, 0.0024, 0.014], "the absorption coefficient, per millimeter");
const SIGMA_S: Key<ColorTexture> =
    coefficient("sigma_s", [2.55, 3.21, 3.77], "the scattering coefficient, per millimeter");
const G: Key<f64> = Key::float("g", 0.0, "the asymmetry of scattering, clamped to -1 (back) to 1 (forward)");
/// A factor of both coefficients leaves the reflectance of a half space as it is.
const SCALE: Key<f64> = Key::float("scale", 1.0, "a factor of the coefficients").not_rendered();
const ETA: Key<f64> = Key::float("eta", 1.33, "the index of refraction").within(Range::above(0.0));
const KR: Key<ColorTexture> = Key::color_texture("Kr", 1.0, "the factor of reflection at the surface");
const KT: Key<ColorTexture> = Key::color_texture("Kt", 1.0, "the factor of light that enters");
const ROUGHNESS: [Key<FloatTexture>; 2] = along_each(0.0);

const fn coefficient(name: &'static str, default: [f32; 3], meaning: &'static str) -> Key<ColorTexture> {
    Key::new(name, ParamType::Rgb, ColorTexture(Vec3::from_array(default)), meaning)
}

pub(in crate::material) const COLOR: Keys = &[
    &KD,
    &Key::color_texture("mfp", 1.0, "the mean free path of light inside").not_rendered(),
    &G.not_rendered(),
    &SCALE,
];
pub(in crate::material) const COEFFICIENTS: Keys = &[&NAME, &SIGMA_A, &SIGMA_S, &G, &SCALE];
pub(in crate::material) const SURFACE: Keys = &[&ETA, &KR, &KT, &ROUGHNESS[0], &ROUGHNESS[1], &REMAP];

pub(super) fn stand_in(params: &mut Params) -> MaterialKind {
    let (replacement, material) = if params.kind() == "kdsubsurface" {
        ("\"uber\" with the same Kd and index", of_color(params))
    } else {
        let replacement = "\"uber\" with the same index and the diffuse color of the coefficients";
        (replacement, of_coefficients(params))
    };
    let message =
        format!("lookat does not support Material \"{}\": it renders {replacement} instead", params.kind());
    params.unsupported(message);
    material
}

/// `kdsubsurface`: `Kd` is the reflectance.
fn of_color(params: &mut Params) -> MaterialKind {
    let kd = reflectance(params, &KD);
    let eta = params.take(&ETA);
    under_gloss(params, kd, eta)
}

/// `subsurface`: the coefficients, or a named medium, give the reflectance.
fn of_coefficients(params: &mut Params) -> MaterialKind {
    let medium = MeasuredMedium::take(params, &NAME);
    let g = if medium.is_some() { 0.0 } else { params.take(&G).clamp(-1.0, 1.0) };
    let of_medium = |key: Key<ColorTexture>, of: fn(&MeasuredMedium) -> Vec3| match medium {
        Some(medium) => Key { default: ColorTexture(of(medium)), ..key },
        None => key,
    };
    let absorption = constant_color(params, &of_medium(SIGMA_A, |medium| medium.absorption));
    let scattering = constant_color(params, &of_medium(SIGMA_S, |medium| medium.scattering));
    params.take(&SCALE);
    let eta = params.take(&ETA);
    let channel =
        |a: f32, s: f32| if s > 0.0 { diffuse_reflectance((s / (a + s)).into(), g, eta) as f32 } else { 0.0 };
    let [a, s] = [absorption.to_array(), scattering.to_array()];
    let kd = Vec3::from_array([0, 1, 2].map(|at| channel(a[at], s[at])));
    under_gloss(params, Texture::Constant(kd), eta)
}

/// The diffuse color, as light leaves it through the surface, under the surface's own reflection.
fn under_gloss(params: &mut Params, color: Texture<Vec3>, eta: f64) -> MaterialKind {
    let [kr, kt] = [&KR, &KT].map(|key| reflectance(params, key));
    let roughness = Roughness::of_two(params, &ROUGHNESS);
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
fn diffuse_reflectance(rho: f64, g: f64, eta: f64) -> f64 {
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
    let coefficients = if eta < 1.0 {
        [-0.68441, 2.49277, -3.904945, 3.37668, -1.73965, 0.45966]
    } else {
        [0.12746, -1.27198, 5.11455, -10.4646, 11.1136, -4.61686]
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The material of a sphere after a directive.
    fn material(directive: &str) -> MaterialKind {
        let scene = format!("WorldBegin\n{directive}\nShape \"sphere\"\nWorldEnd");
        let read = |_: &Path| Ok(scene.clone().into_bytes());
        let loaded = crate::load(Path::new("a.pbrt"), &read, &Default::default());
        loaded.scene.unwrap().world.primitives[0].material.kind.clone()
    }

    #[track_caller]
    fn diffuse(directive: &str) -> Vec3 {
        match material(directive) {
            MaterialKind::Matte(matte) => matte.kd.constant().unwrap(),
            MaterialKind::Uber(uber) => uber.kd.constant().unwrap(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn media_have_the_color_of_their_coefficients() {
        let ketchup = diffuse("Material \"subsurface\" \"string name\" \"Ketchup\" \"float eta\" 1.3");
        assert!(ketchup.x < 0.2 && ketchup.x > 10.0 * ketchup.z, "{ketchup}");
        let black = diffuse("Material \"subsurface\" \"rgb sigma_s\" [0 0 0]");
        assert_eq!(black, Vec3::ZERO);
        let kd = diffuse("Material \"kdsubsurface\" \"rgb Kd\" [0.8 0.4 0.2]");
        assert!(kd.y > 0.36 && kd.y < 0.4 && (kd.x - 2.0 * kd.y).abs() < 1e-6, "{kd}");
    }

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
            let found = diffuse_reflectance(rho, g, eta);
            assert!((found / expected - 1.0).abs() < 0.03, "{rho} {g} {eta}: {found}, not {expected}");
        }
        assert_eq!(diffuse_reflectance(0.0, 0.0, 1.33), 0.0);
    }

    #[test]
    fn media_of_other_colors_differ() {
        let of = |name: &str| {
            let medium = MeasuredMedium::named(name).unwrap();
            [0, 2].map(|at| {
                let [s, a] = [medium.scattering, medium.absorption].map(|it| f64::from(it[at]));
                diffuse_reflectance(s / (s + a), 0.0, 1.33)
            })
        };
        let ([ketchup, _], [_, ketchup_blue]) = (of("Ketchup"), of("Ketchup"));
        assert!(ketchup > 10.0 * ketchup_blue, "ketchup is red");
        assert!(of("Wholemilk")[0] > 0.8, "milk is bright");
    }
}
