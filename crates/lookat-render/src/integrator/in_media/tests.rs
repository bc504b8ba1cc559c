//! Paths through media against closed forms.

use std::ops::ControlFlow;

use glam::Vec3;

use crate::render::{Settings, render};
use crate::testing::scene;

/// The mean color of what a camera at z = -5 sees, in a narrow view, so that all rays have the same way.
fn seen(before: &str, world: &str, samples: u32) -> Vec3 {
    let scene = scene(&format!(
        "{before} LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 1
         Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Sampler \"sobol\" \"integer pixelsamples\" {samples}
         Integrator \"volpath\" \"integer maxdepth\" 1000 \"float rrthreshold\" 0 WorldBegin {world} WorldEnd"
    ));
    let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
    let mean = |channel: usize| {
        let samples = &rendered.image.channels[channel].samples;
        samples.iter().sum::<f32>() / samples.len() as f32
    };
    Vec3::new(mean(0), mean(1), mean(2))
}

fn medium(rest: &str) -> String {
    format!("MakeNamedMedium \"m\" {rest} ")
}

const BOX: &str = "MediumInterface \"m\" \"\" Material \"\" Shape \"sphere\" \"float radius\" 1.7 ";
const GRID: &str = "\"string type\" \"heterogeneous\" \"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2
    \"float density\" [1 .2 .4 0 2 .1 1 .6] \"point p0\" [-1 -1 -1] \"point p1\" [1 1 1]";

/// Media that absorb nothing are invisible under an even sky.
#[test]
fn media_that_absorb_nothing_lose_no_light() {
    let kinds = ["\"string type\" \"homogeneous\"", GRID];
    // In the colored ones most paths see one channel alone.
    let scattering = ["[1 1 1]", "[9 3 1]"];
    for (kind, sigma_s) in kinds.into_iter().flat_map(|kind| scattering.map(|sigma_s| (kind, sigma_s))) {
        for g in [-0.7, 0.0, 0.9] {
            let medium =
                medium(&format!("{kind} \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" {sigma_s} \"float g\" {g}"));
            let found = seen("", &format!("{medium} LightSource \"infinite\" {BOX}"), 1024);
            assert!((found - 1.0).abs().max_element() < 0.01, "{kind} {sigma_s} {g}: {found}");
        }
    }
}

const LAMP: &str = "AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\" \"bool twosided\" \"true\"
    MediumInterface \"\" \"\" Translate 0 0 4 Shape \"disk\" \"float radius\" 9 AttributeEnd ";

/// Closed forms: light through two boundaries, around an eye in the medium, and through a grid of even density.
#[test]
fn light_is_absorbed_as_it_should_be() {
    let coefficients = "\"rgb sigma_a\" [.1 .5 1] \"rgb sigma_s\" [0 0 0]";
    let even = medium(&format!("\"string type\" \"homogeneous\" {coefficients}"));
    let slab = "MediumInterface \"m\" \"\" Material \"\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6]
        \"point P\" [-9 -9 1 9 -9 1 9 9 1 -9 9 1 -9 -9 -1 9 -9 -1 9 9 -1 -9 9 -1] ";
    let grid = medium(&format!(
        "\"string type\" \"heterogeneous\" {coefficients} \"float density\" 1 \"point p0\" [-1e4 -1e4 -1e4] \"point p1\" [1e4 1e4 1e4]"
    ));
    for (before, world, way) in [
        ("", format!("{even}{LAMP}{slab}"), 2.0),
        ("", format!("{grid}{LAMP}{slab}"), 2.0),
        (&*format!("{even} MediumInterface \"\" \"m\""), LAMP.replace("MediumInterface \"\" \"\"", ""), 9.0),
    ] {
        let expected = (Vec3::new(-0.1, -0.5, -1.0) * way).exp();
        let found = seen(before, &world, 4096);
        let error = (found - expected).abs() / expected;
        assert!(error.max_element() < 0.02, "{before} {world}: {found}, not {expected}");
    }
}

/// What absorbs alone leaves nothing to chance: one sample gives the closed form.
#[test]
fn media_that_scatter_nothing_add_no_noise() {
    let even = medium("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.1 .5 1] \"rgb sigma_s\" [0 0 0]");
    let world = format!(
        "{even} LightSource \"infinite\" {BOX} Material \"mirror\" \"rgb Kr\" [1 1 1] Shape \"disk\" "
    );
    let expected = (Vec3::new(-0.1, -0.5, -1.0) * 3.4).exp();
    let found = seen("", &world, 1);
    assert!(((found - expected).abs() / expected).max_element() < 2e-3, "{found}, not {expected}");
}

/// Samples that see the same rays have other random numbers all the same.
#[test]
fn samples_of_one_ray_differ() {
    let medium = medium(&format!("{GRID} \"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [0 0 0]"));
    let picture = |samples: u32| {
        let scene = scene(&format!(
            "LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 10 Film \"image\" \"integer xresolution\" 8
             \"integer yresolution\" 8 PixelFilter \"box\" Sampler \"halton\" \"integer pixelsamples\" {samples} \"bool samplepixelcenter\" \"true\"
             Integrator \"volpath\" WorldBegin {medium} LightSource \"point\" \"point from\" [0 0 -9] \"rgb I\" [99 99 99]
             {BOX} Material \"matte\" MediumInterface \"\" \"\" Translate 0 0 2 Shape \"disk\" \"float radius\" 9 WorldEnd"
        ));
        render(&scene, &Settings::default(), &|_| ControlFlow::Continue(())).image.rgb().unwrap()
    };
    let [few, some, many] = [16, 256, 4096].map(picture);
    let error = |of: &[[f32; 3]]| {
        let squares = of.iter().zip(&many).map(|(a, b)| (a[0] / b[0] - 1.0).powi(2));
        (squares.sum::<f32>() / many.len() as f32).sqrt()
    };
    assert!(error(&few) > 0.02 && error(&some) < 0.5 * error(&few), "{} {}", error(&few), error(&some));
}

/// Thin slabs, in each other and in an instance, and an eye on a boundary.
#[test]
fn boundaries_are_met_once() {
    let thin = |thickness: f64| {
        let sigma = 1.0 / thickness;
        medium(&format!(
            "\"string type\" \"homogeneous\" \"rgb sigma_a\" [{sigma} {sigma} {sigma}] \"rgb sigma_s\" [0 0 0]"
        ))
    };
    let slab = |from: f64, to: f64| {
        let face = |z: f64| format!("-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z} ");
        format!(
            "MediumInterface \"m\" \"\" Material \"\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6] \"point P\" [{}{}] ",
            face(to),
            face(from)
        )
    };
    for (thickness, world, way) in [
        (1e-6, slab(1.0, 1.0 + 1e-6), 1.0),
        (1e-6, format!("{}{}", slab(1.0, 1.0 + 1e-6), slab(1.0 + 2e-6, 1.0 + 3e-6)), 2.0),
        (
            1e-6,
            format!("ObjectBegin \"o\" {} ObjectEnd Scale 1 1 1e-3 ObjectInstance \"o\"", slab(1.0, 1.001)),
            1.0,
        ),
        // Empty space within it.
        (
            1e-6,
            slab(1.0, 1.0 + 3e-6) + &slab(1.0 + 1e-6, 1.0 + 2e-6).replace("\"m\" \"\"", "\"\" \"m\""),
            2.0,
        ),
    ] {
        let expected = (-way as f32).exp();
        let found =
            seen("", &format!("{}{LAMP}AttributeBegin {world} AttributeEnd", thin(thickness)), 16_384);
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{world}: {found}, not {expected}");
    }
    let on_boundary = seen(
        &format!("{} MediumInterface \"\" \"m\"", thin(1.0)),
        &format!("AttributeBegin {} AttributeEnd {LAMP}", slab(-5.0, -3.0)),
        16_384,
    );
    assert!((on_boundary / (-2.0_f32).exp() - 1.0).abs().max_element() < 0.01, "{on_boundary}");
}

/// Slabs that touch, in either order, and one that lies on the floor that it shades, named before or after it.
#[test]
fn boundaries_in_one_place_are_all_crossed() {
    let face = |z: f64| format!("-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z} ");
    let slab = |name: &str, from: f64, to: f64| {
        format!(
            "MediumInterface \"{name}\" \"\" Material \"\" Shape \"trianglemesh\"
             \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6] \"point P\" [{}{}] ",
            face(to),
            face(from)
        )
    };
    let media = ["a", "b"]
        .map(|name| {
            medium("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [0 0 0]")
                .replace("\"m\"", &format!("\"{name}\""))
        })
        .concat();
    // The floor is at z = 0.7, and the light in front of it.
    let floor = format!(
        "MediumInterface \"\" \"\" Material \"matte\" \"rgb Kd\" [1 1 1] Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]
         \"point P\" [{}] ",
        face(0.7)
    );
    let [near, far] = [slab("a", -1.3, -0.3), slab("b", -0.3, 0.7)];
    let orders = [[&near, &far, &floor], [&far, &near, &floor], [&floor, &near, &far], [&floor, &far, &near]];
    // From above, and at an angle whose cosine is 0.4.
    for (shapes, (x, cosine)) in
        orders.into_iter().flat_map(|order| [(order, (0.0, 1.0)), (order, (2.291_288, 0.4_f32))])
    {
        let light = format!(
            "LightSource \"distant\" \"point from\" [{x} 0 -1] \"point to\" [0 0 0] \"rgb L\" [100 100 100] "
        );
        let without = seen("", &format!("{light}{floor}"), 4096);
        // There and back again.
        let expected = without * (-1.0 - 1.0 / cosine).exp();
        let found = seen("", &format!("{media}{light}{}{}{}", shapes[0], shapes[1], shapes[2]), 16_384);
        assert!(
            ((found - expected).abs() / expected).max_element() < 0.01,
            "{shapes:?}: {found}, not {expected}"
        );
    }
}

/// Slabs within each other whose far sides are in one place, in any order, in front of a lamp, a floor in that place, or another slab.
#[test]
fn media_in_each_other_are_left_where_all_end() {
    let face = |z: f64| format!("-9 -9 {z} 9 -9 {z} 9 9 {z} -9 9 {z} ");
    let slab = |name: &str, around: &str, from: f64, to: f64| {
        format!(
            "MediumInterface \"{name}\" \"{around}\" Material \"\" Shape \"trianglemesh\"
             \"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6] \"point P\" [{}{}] ",
            face(to),
            face(from)
        )
    };
    let media = [("a", 0.25), ("b", 0.5), ("c", 1.0)]
        .map(|(name, sigma)| {
            medium(&format!(
                "\"string type\" \"homogeneous\" \"rgb sigma_a\" [{sigma} {sigma} {sigma}] \"rgb sigma_s\" [0 0 0]"
            ))
            .replace("\"m\"", &format!("\"{name}\""))
        })
        .concat();
    let slabs = [slab("a", "", -2.0, 1.0), slab("b", "a", -1.0, 1.0), slab("c", "b", 0.0, 1.0)];
    let black = "AttributeBegin MediumInterface \"\" \"\" Material \"matte\" \"rgb Kd\" [0 0 0]";
    let square = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]";
    // A floor that glows where all end.
    let floor = format!(
        "{black} AreaLightSource \"diffuse\" \"bool twosided\" \"true\" {square} \"point P\" [{}] AttributeEnd ",
        face(1.0)
    );
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let inside = format!("AttributeBegin {} AttributeEnd ", order.map(|at| &*slabs[at]).concat());
        for (world, depth) in [
            (format!("{floor}{inside}"), 0.25 + 0.5 + 1.0),
            (format!("{inside}{floor}"), 0.25 + 0.5 + 1.0),
            (format!("{LAMP}{inside}"), 0.25 + 0.5 + 1.0),
            (format!("{LAMP}{inside}{}", slab("a", "", 1.0, 3.0)), 0.25 + 0.5 + 1.0 + 2.0 * 0.25),
        ] {
            let found = seen("", &format!("{media}{world}"), 4096);
            let expected = (-depth as f32).exp();
            assert!(
                (found / expected - 1.0).abs().max_element() < 0.02,
                "{order:?} {world}: {found}, not {expected}"
            );
        }
    }
}

/// A dark floor sees a lamp, or a point light, through a medium: what light samples and directions find has one mean.
#[test]
fn shadow_rays_cross_media() {
    let medium = medium("\"string type\" \"homogeneous\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [0 0 0]");
    let floor = "Material \"matte\" \"rgb Kd\" [1 1 1] AttributeBegin Translate 0 0 1 Shape \"disk\" \"float radius\" 9 AttributeEnd ";
    let shell = "AttributeBegin MediumInterface \"m\" \"\" Material \"\" Translate 0 0 -9 Shape \"sphere\" \"float radius\" 2 \
        MediumInterface \"\" \"m\" Shape \"sphere\" AttributeEnd ";
    let light = "LightSource \"point\" \"point from\" [0 0 -9] \"rgb I\" [100 100 100] ";
    let found = seen("", &format!("{medium}{floor}{shell}{light}"), 64);
    let without = seen("", &format!("{medium}{floor}{light}"), 64);
    let expected = without * (-0.5_f32).exp();
    assert!(((found - expected).abs() / expected).max_element() < 0.01, "{found}, not {expected}");
}
