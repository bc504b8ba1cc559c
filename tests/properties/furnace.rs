//! Scenes whose picture is known in closed form.

use std::ops::ControlFlow;
use std::path::Path;

use lookat_render::{Rendered, Settings, render};
use lookat_scene::{LoadOptions, load};

fn rendered(text: &str) -> Rendered {
    let mesh = include_bytes!("../../pbrt-scenes/geometry/icosphere.ply");
    let white = [&b"PF\n2 1\n-1.0\n"[..], [1.0_f32; 6].map(f32::to_le_bytes).as_flattened()].concat();
    let read = |path: &Path| {
        Ok(match path.to_str() {
            Some("icosphere.ply") => mesh.to_vec(),
            Some("white.pfm") => white.clone(),
            _ => text.into(),
        })
    };
    let loaded = load(Path::new("furnace.pbrt"), &read, &LoadOptions::default());
    // pbrt-v3 renders some of these otherwise; nothing else is wrong.
    let mut messages = loaded.diagnostics.iter().map(|problem| &problem.message);
    assert_eq!(messages.find(|message| !message.starts_with("pbrt-v3 ")), None);
    render(&loaded.scene.unwrap(), &Settings::default(), &|_| ControlFlow::Continue(()))
}

/// The mean over the middle of the picture, where the object is.
fn middle(text: &str) -> f64 {
    let image = rendered(text).image;
    let (width, height) = (image.data_window.width as usize, image.data_window.height as usize);
    let pixels = image.rgb().unwrap();
    let inner = |side: usize| side * 3 / 8..side * 5 / 8;
    let places = inner(height).flat_map(|y| inner(width).map(move |x| y * width + x));
    let values: Vec<f64> = places.map(|at| f64::from(pixels[at][1])).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn furnace(integrator: &str, sampler: &str, light: &str, shape: &str) -> String {
    format!(
        r#"LookAt 0 0 -4  0 0 0  0 1 0
        Camera "perspective" "float fov" 40
        Film "image" "integer xresolution" 32 "integer yresolution" 32
        Sampler {sampler}
        Integrator {integrator}
        WorldBegin
        {light}
        Material "matte" "rgb Kd" [0.5 0.5 0.5]
        {shape}
        WorldEnd"#
    )
}

const SKY: &str = r#"LightSource "infinite""#;

/// A convex grey body under a white sky is 0.5 all over, for every integrator, sampler and shape.
#[test]
fn a_grey_body_under_a_white_sky_is_half_as_bright() {
    let samplers = [
        r#""sobol" "integer pixelsamples" 64"#,
        r#""halton" "integer pixelsamples" 64"#,
        r#""random" "integer pixelsamples" 64"#,
        r#""stratified" "integer xsamples" 8 "integer ysamples" 8"#,
    ];
    let shapes = [
        r#"Shape "sphere""#,
        r#"Shape "plymesh" "string filename" "icosphere.ply""#,
        "Scale 1 0.7 1.3 Rotate 30 1 1 0 Shape \"sphere\"",
        "ObjectBegin \"ball\" Shape \"sphere\" ObjectEnd Scale 1 1 0.5 ObjectInstance \"ball\"",
    ];
    for integrator in [r#""directlighting""#, r#""directlighting" "string strategy" "one""#, r#""path""#] {
        for shape in shapes {
            for sampler in samplers {
                let value = middle(&furnace(integrator, sampler, SKY, shape));
                // Four standard deviations of independent samples, of which there are 4,096.
                assert!((value - 0.5).abs() < 2e-3, "{integrator} {sampler} {shape}: {value}");
            }
        }
    }
}

/// A sky is sampled in another way than a map of one, but is the same, also where normals are bent and light passes.
#[test]
fn a_white_sky_is_as_good_as_a_white_map() {
    let materials = [
        r#""translucent" "rgb transmit" [1 1 1] "rgb reflect" [0 0 0] "rgb Kd" [1 1 1] "rgb Ks" [0 0 0]"#,
        r#""translucent" "rgb Kd" [0.5 0.5 0.5] "rgb Ks" [0.5 0.5 0.5] "float roughness" 0.3"#,
        r#""glass" "float uroughness" 0.4 "float vroughness" 0.4"#,
        r#""plastic" "rgb Kd" [0.5 0.5 0.5] "rgb Ks" [0.5 0.5 0.5]"#,
    ];
    let quad =
        r#"Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-2 -2 0  2 -2 0  2 2 0  -2 2 0]"#;
    let tilted = format!(r#"{quad} "normal N" [0 2 -1  0 2 -1  0 2 -1  0 2 -1]"#);
    let sampler = r#""sobol" "integer pixelsamples" 1024"#;
    for material in materials {
        let bumped =
            r#"Texture "slope" "float" "bilerp" "float v00" 0 "float v01" 0 "float v10" 8 "float v11" 8"#;
        let bent = format!(r#"{bumped} Material {material} "texture bumpmap" "slope" {quad}"#);
        // Flat almost everywhere: normals that differ by rounding alone.
        let tiled = r#"Texture "tiles" "float" "checkerboard" "float uscale" 4 "float vscale" 4"#;
        let flat = format!(r#"{tiled} Material {material} "texture bumpmap" "tiles" {quad}"#);
        let plain = format!("Material {material} {quad}");
        for shape in [plain, format!("Material {material} {tilted}"), bent, flat] {
            for integrator in [r#""directlighting""#, r#""path""#] {
                let value = |sky| middle(&furnace(integrator, sampler, sky, &shape));
                let (sky, map) =
                    (value(SKY), value(r#"LightSource "infinite" "string mapname" "white.pfm""#));
                assert!((sky - map).abs() < 0.02, "{integrator} {shape}: {sky} {map}");
            }
        }
    }
}

/// Inside a closed box whose walls all emit 1 and reflect a half, the light is 1 + 1/2 + 1/4 + ... = 2.
#[test]
fn light_between_walls_adds_up() {
    let room =
        r#"AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" "true" Scale 10 10 10 Shape "sphere""#;
    for (depth, expected) in [(0, 1.0), (1, 1.5), (3, 1.875), (40, 2.0)] {
        let integrator = format!(r#""path" "integer maxdepth" {depth}"#);
        let value = middle(&furnace(&integrator, r#""sobol" "integer pixelsamples" 64"#, room, ""));
        assert!((value - expected).abs() < 0.01, "{depth}: {value}");
    }
}

/// The radiance of a white floor straight below a light 3 above it.
fn floor_below(light: &str) -> f64 {
    // The camera looks down from below the light.
    middle(&format!(
        r#"LookAt 0 1 0  0 0 0  0 0 1
        Camera "perspective" "float fov" 0.1
        Film "image" "integer xresolution" 4 "integer yresolution" 4
        Sampler "sobol" "integer pixelsamples" 4096
        Integrator "directlighting"
        WorldBegin
        AttributeBegin Translate 0 3 0 {light} AttributeEnd
        Material "matte" "rgb Kd" [1 1 1]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 0 -9 -9 0 9 9 0 9 9 0 -9]
        WorldEnd"#
    ))
}

/// Under a sphere of radiance 1, the irradiance of the floor is pi (r / d)^2, so the floor shows (r / d)^2.
#[test]
fn a_sphere_light_gives_its_form_factor() {
    for radius in [0.001, 0.1, 1.0] {
        let value =
            floor_below(&format!(r#"AreaLightSource "diffuse" Shape "sphere" "float radius" {radius}"#));
        assert!((value / (radius / 3.0_f64).powi(2) - 1.0).abs() < 2e-3, "{radius}");
    }
}

/// A bowl, half of a sphere, with its opening down: through the opening one sees as much as a disk, r^2 / (r^2 + d^2); but
/// only if the inside emits. With its opening up it is seen as the whole sphere.
#[test]
fn a_bowl_emits_from_the_sides_that_it_is_told_to() {
    let bowl = |turn: i32, side: &str| {
        let light = r#"AreaLightSource "diffuse""#;
        floor_below(&format!(r#"{light} {side} Rotate {turn} 1 0 0 Shape "sphere" "float zmax" 0"#))
    };
    // The bowl is below z = 0 of its space: turned by 90 degrees about x its opening is down, by -90 up.
    let (down, up) = (90, -90);
    let near = |value: f64, expected: f64| {
        assert!((value - expected).abs() < 3e-3 * (1.0 / 9.0), "{value} {expected}")
    };
    near(bowl(down, ""), 0.0);
    near(bowl(down, r#""bool twosided" "true""#), 0.1);
    near(bowl(down, "ReverseOrientation"), 0.1);
    near(bowl(up, ""), 1.0 / 9.0);
    near(bowl(up, r#""bool twosided" "true""#), 1.0 / 9.0);
    near(bowl(up, "ReverseOrientation"), 0.0);
}

/// A stretched sphere emits as a mirror image or a copy of itself does: two sides show no more than one from outside, and
/// a reversed one nothing.
#[test]
fn a_stretched_sphere_hides_its_inside() {
    let light = |side: &str| {
        floor_below(&format!(
            r#"AreaLightSource "diffuse" {side} Scale 1 1 2 Shape "sphere" "float radius" 0.5"#
        ))
    };
    let one = light("");
    assert!(one > 0.05);
    assert!((light(r#""bool twosided" "true""#) / one - 1.0).abs() < 5e-3);
    assert_eq!(light("ReverseOrientation"), 0.0);
}

/// The irradiance under a square light of side 1 at distance 1, on its axis, by its form factor; the ceiling that it is
/// flush with, and the point of the ceiling that a point light stands on, hide nothing.
#[test]
fn lights_flush_with_a_surface_shine() {
    let ceiling =
        r#"Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 3 -9 9 3 -9 9 3 9 -9 3 9]"#;
    let quad = r#"AttributeBegin AreaLightSource "diffuse" "bool twosided" "true" Shape "trianglemesh"
        "integer indices" [0 1 2 0 2 3] "point P" [-.5 3 -.5 .5 3 -.5 .5 3 .5 -.5 3 .5] AttributeEnd"#;
    let point = r#"LightSource "point" "point from" [0 3 0]"#;
    let floor = |world: &str| {
        middle(&format!(
            r#"LookAt 0 1 0  0 0 0  0 0 1
            Camera "perspective" "float fov" 0.1
            Film "image" "integer xresolution" 4 "integer yresolution" 4
            Sampler "sobol" "integer pixelsamples" 1024
            Integrator "directlighting"
            WorldBegin
            Material "matte" "rgb Kd" [1 1 1]
            Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-9 0 -9 -9 0 9 9 0 9 9 0 -9]
            {world}
            WorldEnd"#
        ))
    };
    // Four times the form factor of a corner: a square of side 1/2 at distance 3.
    let (a, c) = (0.5_f64, 3.0_f64);
    let side = (a * a + c * c).sqrt();
    let form_factor = 4.0 * 2.0 * a / side * (a / side).atan() / (2.0 * std::f64::consts::PI);
    for world in [format!("{quad} {ceiling}"), format!("{ceiling} {quad}")] {
        assert!((floor(&world) / form_factor - 1.0).abs() < 0.01, "{} {form_factor}", floor(&world));
    }
    let expected = 1.0 / 9.0 / std::f64::consts::PI;
    assert!((floor(&format!("{point} {ceiling}")) / expected - 1.0).abs() < 1e-6);
}

/// Faces that stand twice do not shade each other, at any size, also in an instance that comes from far away; and a ray
/// passes through doubled faces without a material in the end.
#[test]
fn doubled_faces_are_as_good_as_single_ones() {
    let sky = |size: f64, material: &str, place: &str| {
        let quad = format!(
            r#"Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
            "point P" [-{size} 0 -{size} -{size} 0 {size} {size} 0 {size} {size} 0 -{size}]"#
        );
        let text = format!(
            r#"LookAt 0 1 0  0.1 0 0.2  0 0 1
            Camera "perspective" "float fov" 30
            Film "image" "integer xresolution" 16 "integer yresolution" 16
            Sampler "sobol" "integer pixelsamples" 16
            Integrator "path" "integer maxdepth" 2
            WorldBegin
            LightSource "infinite"
            {material}
            ObjectBegin "ground" Rotate 17 1 0.3 0.2 {quad} {quad} ObjectEnd
            {place} ObjectInstance "ground"
            WorldEnd"#
        );
        middle(&text)
    };
    let grey = r#"Material "matte" "rgb Kd" [0.5 0.5 0.5]"#;
    for size in [1.0, 1e3, 1e5, 1e7] {
        let value = sky(size, grey, "");
        assert!((value - 0.5).abs() < 2e-3, "{size}: {value}");
        let value = sky(size, r#"Material "none""#, "");
        assert!((value - 1.0).abs() < 1e-6, "{size}: {value}");
    }
}

/// Ambient occlusion of a convex body is pi.
#[test]
fn nothing_occludes_a_convex_body() {
    for cosine in ["true", "false"] {
        let integrator = format!(r#""ambientocclusion" "bool cossample" "{cosine}" "integer nsamples" 16"#);
        let value =
            middle(&furnace(&integrator, r#""sobol" "integer pixelsamples" 16"#, SKY, r#"Shape "sphere""#));
        assert!((value - std::f64::consts::PI).abs() < 0.01, "{cosine}: {value}");
    }
}

#[test]
fn threads_do_not_change_a_bit_and_seeds_do() {
    let text = furnace(r#""path""#, r#""sobol" "integer pixelsamples" 4"#, SKY, r#"Shape "sphere""#);
    let loaded = load(Path::new("a.pbrt"), &|_| Ok(text.clone().into()), &LoadOptions::default());
    let scene = loaded.scene.unwrap();
    let picture = |threads, seed| {
        render(&scene, &Settings { threads, seed, ..Settings::default() }, &|_| ControlFlow::Continue(()))
            .image
            .rgb()
            .unwrap()
    };
    let one = picture(1, 0);
    assert!(one == picture(2, 0) && one == picture(7, 0));
    assert!(one != picture(1, 1));
}

#[test]
fn breaking_off_leaves_a_whole_picture() {
    let text = furnace(r#""path""#, r#""sobol" "integer pixelsamples" 1024"#, SKY, r#"Shape "sphere""#);
    let scene =
        load(Path::new("a.pbrt"), &|_| Ok(text.clone().into()), &LoadOptions::default()).scene.unwrap();
    let rendered = render(&scene, &Settings::default(), &|progress| {
        if progress.done * 4 > progress.total { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(!rendered.complete && rendered.statistics.samples < 1024 * 32 * 32);
    assert!(rendered.image.rgb().unwrap().iter().all(|pixel| pixel[0] > 0.3));
}

/// The triangles of a flat lamp do not light each other's backs, even though rounding tilts them.
#[test]
fn the_back_of_a_lamp_is_black() {
    for (integrator, turn) in [("path", 0), ("directlighting", 0), ("path", 37), ("directlighting", 143)] {
        let text = format!(
            r#"LookAt 0 0 -5  0 0 0  0 1 0
            Camera "perspective" "float fov" 40
            Film "image" "integer xresolution" 16 "integer yresolution" 16
            Sampler "sobol" "integer pixelsamples" 16
            Integrator "{integrator}"
            WorldBegin
            AreaLightSource "diffuse" "rgb L" [10 10 10]
            Rotate {turn} 1 2 100
            Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point P" [-1 1 1  1 1 1  1 -1 1  -1 -1 1]
            WorldEnd"#
        );
        let pixels = rendered(&text).image.rgb().unwrap();
        assert!(pixels.iter().all(|pixel| *pixel == [0.0; 3]), "{integrator} {turn}");
    }
}
