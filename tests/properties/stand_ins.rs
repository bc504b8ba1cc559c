//! The stand-ins of unsupported materials reflect as much light as the materials that they replace: the albedo of a sphere and of
//! a sheet under a white sky.

use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Settings, render};
use lookat_scene::{LoadOptions, load};

/// The mean color of a picture by parallel rays along z, from -1 to 1 in x and y.
fn mean_color(world: &str) -> [f64; 3] {
    let text = format!(
        r#"LookAt 0 0 -4  0 0 0  0 1 0
        Camera "orthographic"
        Film "image" "integer xresolution" 16 "integer yresolution" 16
        Sampler "sobol" "integer pixelsamples" 256
        Integrator "path" "integer maxdepth" 100
        WorldBegin
        LightSource "infinite"
        Texture "half" "spectrum" "bilerp"
            "rgb v00" [.5 .5 .5] "rgb v01" [.5 .5 .5] "rgb v10" [.5 .5 .5] "rgb v11" [.501 .501 .501]
        {world}
        WorldEnd"#
    );
    let loaded = load(Path::new("a.pbrt"), &|_| Ok(text.clone().into()), &LoadOptions::default());
    let rendered = render(&loaded.scene.unwrap(), &Settings::default(), &|_| ControlFlow::Continue(()));
    let pixels = rendered.image.rgb().unwrap();
    [0, 1, 2].map(|at| pixels.iter().map(|pixel| f64::from(pixel[at])).sum::<f64>() / pixels.len() as f64)
}

/// The share of diffuse light that a sphere of a material reflects. Parallel rays meet it at all angles, by the cosine.
fn of_sphere(material: &str) -> [f64; 3] {
    // The sphere covers pi/4 of the picture. The sky around it is 1.
    let mean = mean_color(&format!("Material {material} Shape \"sphere\""));
    mean.map(|mean| 1.0 - (1.0 - mean) * 4.0 / std::f64::consts::PI)
}

/// The share of light that a sheet reflects or lets through, at normal incidence.
fn of_sheet(material: &str) -> [f64; 3] {
    mean_color(&format!(
        r#"Material {material} Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
        "point P" [-2 -2 0  -2 2 0  2 2 0  2 -2 0]"#
    ))
}

#[track_caller]
fn near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < tolerance);
    assert!(is_near, "{found:?} is not {expected:?}");
}

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

/// The color by the absorption, as pbrt-v3 fits it (HairBSDF::SigmaAFromReflectance).
#[test]
fn hair_is_brown_unless_it_has_another_constant_color() {
    let brown = [0.0130, 0.0037, 0.0004];
    for absorption in ["", r#""texture sigma_a" "half""#, r#""texture eumelanin" "absent""#] {
        let textures = r#"Texture "absent" "float" "checkerboard""#;
        let found = mean_color(&format!(r#"{textures} Material "hair" {absorption} Shape "sphere""#));
        let around = 1.0 - std::f64::consts::FRAC_PI_4;
        near(found, brown.map(|share| around + (1.0 - around) * share), 0.004);
    }
    near(of_sphere(r#""hair" "rgb color" [.8 .4 .2]"#), [0.8, 0.4, 0.2], 0.004);
    near(of_sphere(r#""hair" "rgb sigma_a" [3 3 3]"#), [0.0; 3], 0.004);
}

/// The numbers are integrals of pbrt-v3's DisneyDiffuse, DisneyRetro and MicrofacetReflection with DisneyFresnel over all pairs of
/// directions, at the default roughness 0.5 and index 1.5.
#[test]
fn disney_reflects_as_much_as_its_lobes() {
    for (color, metallic, expected) in
        [(0.2, 0.0, 0.260), (0.5, 0.0, 0.563), (0.8, 0.0, 0.865), (0.5, 1.0, 0.447), (1.0, 1.0, 0.880)]
    {
        let material =
            format!(r#""disney" "rgb color" [{color} {color} {color}] "float metallic" {metallic}"#);
        near(of_sphere(&material), [expected; 3], 0.02);
    }
    // Smooth glass absorbs nothing.
    near(
        of_sphere(r#""disney" "rgb color" [1 1 1] "float spectrans" 1 "float roughness" 0"#),
        [1.0; 3],
        0.004,
    );
}

/// A thin sheet absorbs light by its color alone. The diffuse part has the color, the clear part its square root.
#[test]
fn thin_disney_keeps_its_light() {
    let white = r#""disney" "bool thin" "true" "rgb color" [1 1 1]"#;
    let gray = r#""disney" "bool thin" "true" "rgb color" [.25 .25 .25]"#;
    for (material, expected) in [
        (white.to_string(), 1.0),
        (gray.to_string(), 0.25),
        (format!("{gray} \"float difftrans\" 2"), 0.25),
        (format!("{white} \"float spectrans\" 1"), 1.0),
        (format!("{white} \"float spectrans\" 0.5"), 1.0),
        (format!("{gray} \"float spectrans\" 1"), 0.5),
        (format!("{gray} \"float spectrans\" 0.5"), 0.375),
        // Facets of width 0.25 lose 8.4 % of the light to masking: the integral of the Smith term for light along the normal.
        (format!("{white} \"float metallic\" 1"), 0.916),
        (format!("{white} \"float metallic\" 0.9"), 0.9 * 0.916 + 0.1),
    ] {
        near(of_sheet(&material), [expected; 3], 0.004);
    }
}
