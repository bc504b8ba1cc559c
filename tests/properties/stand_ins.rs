//! The stand-ins of unsupported materials reflect as much light as the materials that they replace: the albedo of a sphere and of
//! a sheet under a white sky.

use crate::albedo::{near, of_sphere};

/// The reflectance of a smooth dielectric for diffuse light from outside, by the Fresnel equations.
fn fresnel_mean(eta: f64) -> f64 {
    const COUNT: u32 = 10_000;
    let reflectance = |cos: f64| {
        let inside = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
        let [s, p] =
            [(cos - eta * inside) / (cos + eta * inside), (eta * cos - inside) / (eta * cos + inside)];
        0.5 * (s * s + p * p)
    };
    let cosines = (0..COUNT).map(|index| (f64::from(index) + 0.5) / f64::from(COUNT));
    cosines.map(|cos| 2.0 * cos * reflectance(cos)).sum::<f64>() / f64::from(COUNT)
}

/// Light is reflected by Fresnel. The rest enters, and a share of it leaves with the normalized Sw of pbrt-v3 (core/bssrdf.h).
#[test]
fn subsurface_reflects_the_share_of_its_medium() {
    let fresnel = fresnel_mean(1.33);
    let under_gloss = |share: f64| [fresnel + (1.0 - fresnel) * share; 3];
    for (material, share) in [
        (r#""kdsubsurface" "rgb Kd" [.5 .5 .5]"#, 0.5),
        (r#""kdsubsurface" "texture Kd" "half""#, 0.5),
        (r#""kdsubsurface" "rgb Kd" [.5 .5 .5] "texture Kt" "half""#, 0.25),
        (r#""kdsubsurface" "texture Kd" "half" "texture Kt" "half""#, 0.25),
        (r#""subsurface" "rgb sigma_s" [0 0 0]"#, 0.0),
        // The table that pbrt-v3 computes for this albedo (ComputeBeamDiffusionBSSRDF).
        (r#""subsurface" "rgb sigma_a" [1 1 1] "rgb sigma_s" [9 9 9]"#, 0.29557),
        (r#""subsurface" "rgb sigma_a" [1 1 1] "rgb sigma_s" [9 9 9] "texture Kt" "half""#, 0.5 * 0.29557),
    ] {
        near(of_sphere(material), under_gloss(share), 0.01);
    }
}
