//! `subsurface` and `kdsubsurface` as a diffuse surface under the gloss of the dielectric: its color is the diffuse reflectance
//! of a half space of the medium, by photon beam diffusion (PBR 15.5, core/bssrdf.cpp; Habel et al. 2013).

use std::f64::consts::PI;

use glam::Vec3;
use lookat_syntax::{Diagnostic, nearest};

use super::media::{MEDIA, Medium};
use super::{MaterialKind, Roughness, constant_color, glossy, gray, scaled, share};
use crate::texture::{Texture, TextureParams};

/// Indices that the fits of Fresnel moments are for.
const FITTED: [f64; 2] = [0.4, 2.5];

/// `kdsubsurface`: `Kd` is the reflectance.
pub(super) fn of_color(params: &mut TextureParams) -> MaterialKind {
    let kd = share(params, "Kd", 0.5);
    let eta = index(params);
    under_gloss(params, kd, eta)
}

/// `subsurface`: the coefficients, or a named medium, give the reflectance.
pub(super) fn of_coefficients(params: &mut TextureParams) -> MaterialKind {
    let medium = named_medium(params);
    let g = if medium.is_some() { 0.0 } else { params.float("g", 0.0).clamp(-1.0, 1.0) };
    let [absorption, scattering] = medium
        .map(|medium| [medium.absorption, medium.scattering])
        .unwrap_or([[0.0011, 0.0024, 0.014], [2.55, 3.21, 3.77]]);
    let absorption = constant_color(params, "sigma_a", Vec3::from_array(absorption));
    let scattering = constant_color(params, "sigma_s", Vec3::from_array(scattering));
    // A scale of both coefficients leaves the reflectance as it is.
    params.float("scale", 1.0);
    let eta = index(params);
    let channel =
        |a: f32, s: f32| if s > 0.0 { reflectance((s / (a + s)).into(), g, eta) as f32 } else { 0.0 };
    let [a, s] = [absorption.to_array(), scattering.to_array()];
    let kd = Vec3::from_array([0, 1, 2].map(|at| channel(a[at], s[at])));
    under_gloss(params, Texture::Constant(kd), eta)
}

fn named_medium(params: &mut TextureParams) -> Option<&'static Medium> {
    let name = params.string("name").filter(|name| !name.value.is_empty())?;
    let medium = MEDIA.iter().find(|medium| medium.name == name.value);
    if medium.is_none() {
        let message =
            "there is no measured medium of this name: the default coefficients count, as in pbrt-v3";
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

fn index(params: &mut TextureParams) -> f64 {
    let eta = params.float("eta", 1.33);
    if eta > 0.0 {
        return eta;
    }
    params.reject("eta", "the index of refraction must be above 0", None);
    1.33
}

/// The diffuse color, as light leaves it through the surface, under the surface's own reflection.
fn under_gloss(params: &mut TextureParams, color: Texture<Vec3>, eta: f64) -> MaterialKind {
    let [kr, kt] = ["Kr", "Kt"].map(|name| share(params, name, 1.0));
    let roughness = Roughness::of_two(params, 0.0);
    let is_zero = |width: &Texture<f64>| width.constant() == Some(0.0);
    let is_smooth = is_zero(&roughness.u) && roughness.v.as_ref().is_some_and(is_zero);
    let passes = (1.0 - 2.0 * fresnel_moment_1(1.0 / eta.clamp(FITTED[0], FITTED[1]))).clamp(0.0, 1.0) as f32;
    let kd = scaled(color, passes * kt.constant().unwrap_or(Vec3::ONE));
    let mut uber = glossy(kd, kr, roughness, eta);
    if is_smooth {
        (uber.kr, uber.ks) = (uber.ks, gray(0.0));
    }
    MaterialKind::Uber(Box::new(uber))
}

/// The share of the light below the surface of a half space that comes back to it. `rho`: the albedo of a scattering event,
/// 0 to 1; `g`: the asymmetry of the phase function; `eta`: the index of refraction.
pub(super) fn reflectance(rho: f64, g: f64, eta: f64) -> f64 {
    // Radii in mean free paths, from 3e-4 to 200 by equal ratios.
    const STEP: f64 = 1.0 / 3.0;
    let eta = eta.clamp(FITTED[0], FITTED[1]);
    let radii = (-24..=16).map(|step| (f64::from(step) * STEP).exp());
    let ring = |r: f64| 2.0 * PI * r * r * STEP * (single(rho, g, eta, r) + multiple(rho, g, eta, r));
    radii.map(ring).sum::<f64>().clamp(0.0, 1.0)
}

/// Depths along a beam, by equal shares of its light, in mean free paths.
fn depths() -> impl Iterator<Item = f64> {
    const COUNT: usize = 16;
    (0..COUNT).map(|index| -(1.0 - (index as f64 + 0.5) / COUNT as f64).ln())
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
        let distance = r.hypot(t);
        let cos = t / distance;
        let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g + 2.0 * g * cos).max(1e-9).powf(1.5));
        let leaves = 1.0 - fresnel_leaving(cos, eta);
        rho * (-(distance + t_critical)).exp() / (distance * distance) * phase * leaves * cos
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
    let fluence = |d: f64| (-sigma_tr * d).exp() / d;
    let flux = |z: f64, d: f64| z * (1.0 + sigma_tr * d) * (-sigma_tr * d).exp() / (d * d * d);
    mean(depths().map(|depth| {
        let real = depth / sigma_t;
        let mirrored = -real + 2.0 * extrapolation;
        let [d_real, d_mirrored] = [real, mirrored].map(|z| r.hypot(z));
        let phi = (fluence(d_real) - fluence(d_mirrored)) / (4.0 * PI * diffusion);
        let e = (flux(real, d_real) - flux(mirrored, d_mirrored)) / (4.0 * PI);
        let near = 1.0 - (-2.0 * sigma_t * (d_real + real)).exp();
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
    let terms = match eta < 1.0 {
        true => [-0.68441, 2.49277, -3.904945, 3.37668, -1.73965, 0.45966],
        false => [0.12746, -1.27198, 5.11455, -10.4646, 11.1136, -4.61686],
    };
    terms.iter().fold(0.0, |sum, term| sum * eta + term)
}

/// Second moment of the same.
fn fresnel_moment_2(eta: f64) -> f64 {
    let polynomial = |terms: [f64; 6], x: f64| terms.iter().fold(0.0, |sum, term| sum * x + term);
    if eta < 1.0 {
        return polynomial([0.0486, 0.07883, -0.65095, 1.12077, -0.8735, 0.27614], eta);
    }
    let inverse = 1.0 / eta;
    let high = polynomial([0.63942, -9.00603, 54.9327, -189.519, 404.557, 0.0], eta);
    high - 547.033 + ((45.3087 * inverse - 218.725) * inverse + 458.843) * inverse
}

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
