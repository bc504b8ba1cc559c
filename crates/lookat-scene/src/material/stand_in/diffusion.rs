//! The diffuse reflectance of a half space, by photon beam diffusion (PBR 15.5, core/bssrdf.cpp; Habel et al. 2013).

use std::f64::consts::PI;

use super::polynomial;

/// Indices that the fits of Fresnel moments are for.
const FITTED: [f64; 2] = [0.4, 2.5];

/// The transmittance of a boundary for diffuse light from outside. `eta`: the index of refraction, inside over outside.
pub(super) fn diffuse_transmittance(eta: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::super::media::MEDIA;
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
