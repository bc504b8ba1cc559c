use std::ops::ControlFlow;

use fearless_simd::Level;
use glam::DVec2;

use super::*;
use crate::render::{Stop, render};
use crate::testing::{levels, scene};

fn all() -> Layers {
    Layers::names().filter_map(Layers::named).fold(Layers::default(), Layers::union)
}

fn settings() -> Settings {
    Settings { layers: all(), ..Settings::default() }
}

/// A picture with all layers. `world` is what the camera at the origin sees, along z, on a film of 40 x 20 pixels.
fn picture(camera: &str, world: &str) -> Image {
    let scene = scene(&format!(
        "Camera {camera} Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 20 Sampler \"halton\"
        \"integer pixelsamples\" 16 Integrator \"path\" \"integer maxdepth\" 1 WorldBegin LightSource \"infinite\" {world} WorldEnd"
    ));
    render(&scene, &settings(), &|_| ControlFlow::Continue(())).image
}

/// The values of a pixel, channel by channel.
fn pixel<const N: usize>(image: &Image, names: [&str; N], [x, y]: [usize; 2]) -> [f32; N] {
    names.map(|name| image.channel(name).unwrap()[40 * y + x])
}

const P: [&str; 3] = ["P.X", "P.Y", "P.Z"];
const N: [&str; 3] = ["N.X", "N.Y", "N.Z"];
const NS: [&str; 3] = ["Ns.X", "Ns.Y", "Ns.Z"];
const ALBEDO: [&str; 3] = ["albedo.R", "albedo.G", "albedo.B"];
const NUMBERS: [&str; 3] = ["shape.I", "material.I", "count.samples"];

const FLOOR: &str = "Material \"matte\" \"rgb Kd\" [.25 .5 .75] Translate 0 0 4 Shape \"trianglemesh\"
    \"integer indices\" [0 1 2 0 2 3] \"point P\" [-50 -50 0 50 -50 0 50 50 0 -50 50 0] \"float uv\" [0 0 1 0 1 1 0 1]";

fn is_close<const M: usize>(found: [f32; M], expected: [f64; M], far: f64) -> bool {
    found.iter().zip(expected).all(|(found, expected)| (f64::from(*found) - expected).abs() <= far)
}

#[test]
fn a_plane_is_where_it_is_for_every_camera() {
    for (camera, width) in [
        ("\"perspective\" \"float fov\" 90", 4.0),
        ("\"perspective\" \"float fov\" 90 \"float lensradius\" 1 \"float focaldistance\" 9", 4.0),
        ("\"orthographic\"", 1.0),
    ] {
        let image = picture(camera, FLOOR);
        for at in [[0, 0], [39, 0], [20, 10], [7, 19]] {
            // The middle of the pixel, on the plane.
            let middle =
                (DVec2::new(at[0] as f64, at[1] as f64) + 0.5 - DVec2::new(20.0, 10.0)) / 10.0 * width;
            let point = [middle.x, -middle.y, 4.0];
            assert!(is_close(pixel(&image, P, at), point, 1e-6), "{camera} {at:?}");
            assert_eq!(pixel(&image, ["Z"], at), [4.0], "{camera} {at:?}");
            let uv = [point[0], point[1]].map(|x| x / 100.0 + 0.5);
            assert!(is_close(pixel(&image, ["uv.U", "uv.V"], at), uv, 1e-6), "{camera} {at:?}");
            assert_eq!(pixel(&image, N, at), [0.0, 0.0, -1.0]);
            assert_eq!(pixel(&image, NS, at), [0.0, 0.0, -1.0]);
            assert_eq!(pixel(&image, ALBEDO, at), [0.25, 0.5, 0.75]);
            assert_eq!(pixel(&image, NUMBERS, at), [1.0, 1.0, 16.0]);
        }
    }
}

/// Through a surface without a material, past the edge of a sphere.
#[test]
fn spheres_instances_and_the_sky_are_told_apart() {
    let world = "Material \"none\" Shape \"disk\" \"float height\" 1 \"float radius\" 9 Material \"mirror\"
        ObjectBegin \"o\" Shape \"sphere\" \"float radius\" 9 Material \"matte\" Shape \"sphere\" ObjectEnd
        Translate 1 0 5 Scale 2 2 2 Rotate 90 0 1 0 ObjectInstance \"o\"";
    let image = picture("\"orthographic\" \"float screenwindow\" [-40 40 -20 20]", world);
    let (outer, sky) = ([23, 10], [0, 0]);
    let [shape, material, _] = pixel(&image, NUMBERS, outer);
    assert_eq!((shape, material), (2.0, 2.0));
    // The middle of the pixel, from the middle of the sphere, which is at (1, 0, 5).
    let [x, y]: [f64; 2] = [(23.5 - 20.0) * 2.0 - 1.0, -(10.5 - 10.0) * 2.0];
    let z = (18_f64.powi(2) - x * x - y * y).sqrt();
    // The ray starts within.
    assert!(is_close(pixel(&image, P, outer), [x + 1.0, y, z + 5.0], 1e-5));
    assert!(is_close(pixel(&image, N, outer), [-x / 18.0, -y / 18.0, -z / 18.0], 2e-2));
    assert_eq!(pixel(&image, ["Z"], sky), [1e10]);
    for names in [P, N, NS, ALBEDO] {
        assert_eq!(pixel(&image, names, sky), [0.0; 3]);
    }
    assert_eq!(pixel(&image, NUMBERS, sky), [0.0, 0.0, 16.0]);
}

/// At an edge a mean has a part of each side, the values of one point do not.
#[test]
fn edges_are_smooth_in_means_alone() {
    let floor =
        FLOOR.replace("-50 -50 0 50 -50 0 50 50 0 -50 50 0", "-50 -50 0 1.25 -50 0 1.25 50 0 -50 50 0");
    let image = picture("\"orthographic\" \"float screenwindow\" [-20 20 -10 10]", &floor);
    assert_eq!(pixel(&image, ["Z"], [21, 3]), [1e10]);
    let [n] = pixel(&image, ["N.Z"], [21, 3]);
    assert!((n + 0.25).abs() < 0.1, "{n}");
    // The picture has the same samples: light of 1 from the sky, and as much as the albedo from the plane.
    let [red, albedo] = pixel(&image, ["R", "albedo.R"], [21, 3]);
    assert!(
        (red - (1.0 + n + albedo)).abs() < 1e-5 && (albedo + 0.25 * n).abs() < 1e-6,
        "{red} {albedo} {n}"
    );
}

#[test]
fn albedos_do_not_depend_on_the_view() {
    for (material, expected) in [
        ("\"matte\" \"rgb Kd\" [.1 .2 .3]", [0.1, 0.2, 0.3]),
        ("\"mirror\" \"rgb Kr\" [.7 .8 .9]", [0.7, 0.8, 0.9]),
        ("\"glass\"", [1.0; 3]),
        // ((1.5 - 1) / (1.5 + 1))^2 of the coating.
        ("\"plastic\" \"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [.5 .5 .5]", [0.12, 0.22, 0.32]),
        ("\"substrate\" \"rgb Kd\" [.1 .2 .3] \"rgb Ks\" [.5 .5 .5]", [0.55, 0.6, 0.65]),
        // ((2 - 1)^2 + 1) / ((2 + 1)^2 + 1).
        ("\"metal\" \"rgb eta\" [2 2 2] \"rgb k\" [1 1 1]", [0.2; 3]),
        // Half of the light goes straight through.
        ("\"uber\" \"rgb Kd\" [.9 .9 .9] \"rgb Ks\" [.25 .25 .25] \"rgb opacity\" [.5 .5 .5]", [0.955; 3]),
        ("\"uber\" \"rgb Kd\" [1 1 1] \"rgb Ks\" [1 1 1]", [1.0; 3]),
    ] {
        let floor = FLOOR.replace("\"matte\" \"rgb Kd\" [.25 .5 .75]", material);
        let image = picture("\"perspective\" \"float fov\" 90", &floor);
        for at in [[0, 0], [20, 10]] {
            let found = pixel(&image, ALBEDO, at);
            assert!(is_close(found, expected, 1e-6), "{material} {at:?}: {found:?}");
        }
    }
}

/// With textures, bumps, a lens, a filter with negative lobes, and replicates.
fn varied() -> lookat_scene::Scene {
    scene(
        r#"LookAt 0 3 -8 0 0 0 0 1 0 Camera "perspective" "float fov" 40 "float lensradius" .1 "float focaldistance" 8
        Film "image" "integer xresolution" 37 "integer yresolution" 21 PixelFilter "mitchell" Sampler "stratified"
        "integer xsamples" 3 "integer ysamples" 3 Integrator "path" WorldBegin LightSource "infinite"
        Texture "t" "color" "checkerboard" "float uscale" 8 "float vscale" 8 "rgb tex1" [1 .2 .2] "rgb tex2" [0 .2 .9]
        Texture "b" "float" "wrinkled" Material "matte" "texture Kd" "t" "texture bumpmap" "b"
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-4 0 -4 -4 0 4 4 0 4 4 0 -4] "float uv" [0 0 0 1 1 1 1 0]
        ObjectBegin "o" Material "plastic" "texture Kd" "t" Shape "sphere" "float radius" .9 ObjectEnd
        Translate -2 1 0 ObjectInstance "o" Translate 4 0 0 Rotate 60 1 0 0 ObjectInstance "o"
        Material "none" Translate -2 0 -2 Shape "sphere" "float radius" .5
        Material "glass" Shape "curve" "point P" [-1 0 0 0 1 0 0 0 0 1 1 0] "float width" .3 WorldEnd"#,
    )
}

#[test]
fn layers_have_equal_bits_at_every_level_and_on_any_number_of_threads() {
    let scene = varied();
    let adaptive = Stop::Time { limit: std::time::Duration::from_secs(3600), max_samples: 9, adaptive: true };
    for stop in [Stop::default(), Stop::Samples { error_layers: true }, adaptive] {
        let image = |level, threads| {
            let mut prepared = Prepared::new(&scene);
            prepared.traceable.level = level;
            let settings = Settings { seed: 5, threads, stop, layers: all(), ..Settings::default() };
            prepared.render(&scene.view, &settings, &|_| ControlFlow::Continue(())).image
        };
        let bits = |image: Image| -> Vec<(String, Vec<u32>)> {
            let bits =
                |channel: Channel| (channel.name, channel.samples.iter().map(|x| x.to_bits()).collect());
            image.channels.into_iter().map(bits).collect()
        };
        let expected = bits(image(Level::new(), 3));
        let names: Vec<&str> = expected.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.iter().filter(|name| **name == "count.samples").count(), 1, "{names:?}");
        for level in levels() {
            assert_eq!(bits(image(level, 1)), expected, "{level:?}");
        }
    }
}

#[test]
fn layers_change_no_color_and_their_values_are_in_range() {
    let scene = varied();
    let image = |layers| {
        render(&scene, &Settings { layers, ..Settings::default() }, &|_| ControlFlow::Continue(())).image
    };
    let (plain, full) = (image(Layers::default()), image(all()));
    assert_eq!(plain.channels, full.channels[..3]);
    // They need no picture.
    let layers = Layers::names().filter(|name| *name != "samples").filter_map(Layers::named);
    let settings = Settings { layers: layers.fold(Layers::default(), Layers::union), ..Settings::default() };
    let prepared = Prepared::new(&scene);
    let alone = prepared.layers(&scene.view, &settings, &|_| ControlFlow::Continue(())).unwrap();
    assert_eq!(alone.channels[3..], full.channels[3..alone.channels.len()]);
    assert!(prepared.layers(&scene.view, &settings, &|_| ControlFlow::Break(())).is_none());
    let range = |name: &str| {
        let samples = full.channel(name).unwrap().iter().copied();
        (samples.clone().fold(f32::INFINITY, f32::min), samples.fold(f32::NEG_INFINITY, f32::max))
    };
    for name in ALBEDO {
        let (least, most) = range(name);
        assert!(least == 0.0 && most > 0.5 && most <= 1.0, "{name} {least} {most}");
    }
    for name in [N, NS].concat() {
        let (least, most) = range(name);
        assert!(least >= -1.0 && most <= 1.0 && least < most, "{name} {least} {most}");
    }
    // Bumps bend shading normals alone.
    assert_ne!(full.channel("N.X"), full.channel("Ns.X"));
    // The shape without a material is in no layer.
    let numbers: std::collections::BTreeSet<u32> =
        full.channel("shape.I").unwrap().iter().map(|number| *number as u32).collect();
    let shapes = Prepared::new(&scene).shapes().len() as u32;
    assert_eq!((shapes, numbers.into_iter().collect::<Vec<_>>()), (4, vec![0, 1, 3, 4]));
}

#[test]
fn an_interrupted_picture_has_no_layers() {
    let scene = varied();
    let all_samples = 9 * 37 * 21;
    for last in [1, all_samples] {
        let progress = |progress: crate::Progress| match progress.done >= last {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let rendered = render(&scene, &settings(), &progress);
        assert_eq!(rendered.image.channels.len(), 3);
        assert!(!rendered.complete);
    }
}

#[test]
fn names_are_found() {
    assert_eq!(Layers::named("denoise"), Some(Layers::DENOISE));
    let channels: Vec<&str> = Layers::DENOISE.channels().map(|(_, _, name)| name).collect();
    assert_eq!(channels, [NS, ALBEDO].concat());
    assert_eq!(Layers::named("depths"), None);
    let numbers = TABLE.iter().enumerate().filter(|(number, (layer, ..))| *number == *layer as usize);
    assert_eq!(numbers.count(), TABLE.len());
    assert_eq!(all().channels().count(), 18);
}
