//! Bodies in which light scatters reflect as much light as their parameters say, where they are much larger than the way of light inside: the
//! albedo of a sphere and of a sheet under a white sky.

use crate::albedo::{near, of_sheet, of_sphere};

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
    let below_surface = |reflected: f64, share: f64| [reflected + (1.0 - reflected) * share; 3];
    for (material, share) in [
        (r#""kdsubsurface" "float scale" .002 "rgb Kd" [.5 .5 .5]"#, 0.5),
        (r#""kdsubsurface" "float scale" .002 "texture Kd" "half""#, 0.5),
        (r#""kdsubsurface" "rgb mfp" [.002 .003 .001] "rgb Kd" [.8 .8 .8]"#, 0.8),
        (r#""kdsubsurface" "float scale" .002 "rgb Kd" [.5 .5 .5] "texture Kt" "half""#, 0.25),
        (r#""kdsubsurface" "float scale" .002 "texture Kd" "half" "texture Kt" "half""#, 0.25),
        (r#""subsurface" "rgb sigma_s" [0 0 0]"#, 0.0),
        // The table that pbrt-v3 computes for this albedo (ComputeBeamDiffusionBSSRDF).
        (r#""subsurface" "float scale" 100 "rgb sigma_a" [1 1 1] "rgb sigma_s" [9 9 9]"#, 0.29557),
        (
            r#""subsurface" "float scale" 100 "rgb sigma_a" [1 1 1] "rgb sigma_s" [9 9 9] "texture Kt" "half""#,
            0.5 * 0.29557,
        ),
    ] {
        near(of_sphere(material), below_surface(fresnel, share), 0.01);
        let at_normal = (0.33_f64 / 2.33).powi(2);
        near(of_sheet(material), below_surface(at_normal, share), 0.01);
    }
}

/// Nothing makes light, whatever the boundary and the way inside.
#[test]
fn bodies_make_no_light() {
    let white = r#""rgb Kd" [1 1 1]"#;
    for material in [
        format!(r#""kdsubsurface" {white} "float scale" .01"#),
        format!(r#""kdsubsurface" {white} "float scale" 3"#),
        format!(r#""kdsubsurface" {white} "float scale" .1 "float uroughness" .4 "float vroughness" .4"#),
        format!(r#""kdsubsurface" {white} "float scale" .1 "float eta" 1 "float g" -1"#),
        r#""subsurface" "rgb sigma_a" [0 0 0] "rgb sigma_s" [5 50 500] "float eta" 1.8 "float g" .9"#.into(),
    ] {
        is_between(&material, 1.01);
    }
    // What Disney's surface reflects comes on top: a sphere has up to 1.032 in pbrt-v3.
    is_between(r#""disney" "rgb color" [1 1 1] "rgb scatterdistance" [.05 .3 2] "float roughness" 1"#, 1.05);
}

fn is_between(material: &str, most: f64) {
    let found = of_sphere(material);
    assert!(found.iter().all(|found| *found > 0.1 && *found < most), "{material}: {found:?}");
}
