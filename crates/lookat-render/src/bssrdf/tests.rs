use std::ops::ControlFlow;

use glam::DVec3;

use super::diffusion::Beam;
use super::radial::Radial;
use super::table::Table;
use super::*;
use crate::render::{Settings, render};
use crate::testing::scene;

/// pbrt-v3's table (ComputeBeamDiffusionBSSRDF).
#[test]
fn reflectances_are_those_of_pbrt() {
    for (albedo, g, eta, expected) in [
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
        let radial = Radial::new(&Table::new(g, eta), 1.0, albedo).unwrap();
        let found = radial.value(0.7) / radial.pdf(0.7);
        assert!((found / expected - 1.0).abs() < 3e-3, "{albedo} {g} {eta}: {found}, not {expected}");
    }
}

/// Between the nodes, splines are as near to the integrals along the beam as their steps allow.
#[test]
fn tables_are_near_what_they_tabulate() {
    let (table, beam) = (Table::new(0.3, 1.4), Beam::new(0.3, 1.4));
    for albedo in [0.35, 0.8, 0.97, 0.999] {
        let radial = Radial::new(&table, 1.0, albedo).unwrap();
        for r in [0.011, 0.1, 0.77, 3.1, 14.0] {
            let (found, expected) = (radial.value(r), beam.exitance(albedo, r));
            // In a ring as wide as its radius, interpolation may be wrong by 2e-5 of the light.
            let close = 0.01 * expected + 3e-6 / (r * r);
            assert!((found - expected).abs() < close, "{albedo} {r}: {found}, not {expected}");
        }
    }
}

#[test]
fn densities_are_those_of_the_samples() {
    let table = Table::new(0.0, 1.33);
    for (extinction, albedo) in [(1.0, 0.2), (7.0, 0.9), (0.01, 0.9999)] {
        let radial = Radial::new(&table, extinction, albedo).unwrap();
        // The share of samples within a radius, by quadrature of the density.
        let steps = 200_000;
        let (mut sum, end) = (0.0, radial.reach);
        let mut next = 1;
        for step in 0..steps {
            // Denser near the middle.
            let at = |step: f64| end * (step / f64::from(steps)).powi(3);
            let (a, b) = (at(f64::from(step)), at(f64::from(step) + 1.0));
            let r = 0.5 * (a + b);
            sum += 2.0 * PI * r * radial.pdf(r) * (b - a);
            if sum > f64::from(next) * 0.1 {
                let u = radial.sample(f64::from(next) * 0.1);
                assert!((u / r - 1.0).abs() < 1e-3, "{extinction} {albedo}: {u}, not {r}");
                next += 1;
            }
        }
        assert!((sum - 0.999).abs() < 1e-4, "{extinction} {albedo}: {sum}");
    }
}

#[test]
fn albedos_are_found_again() {
    let table = Table::new(-0.2, 1.5);
    for albedo in [0.02, 0.5, 0.83, 0.99, 0.9997] {
        let effective = Radial::new(&table, 1.0, albedo).unwrap();
        let found = table.albedo(effective.value(1.0) / effective.pdf(1.0));
        assert!((found - albedo).abs() < 1e-4, "{found}, not {albedo}");
    }
    assert_eq!(table.albedo(-1.0), 0.0);
    assert_eq!(table.albedo(7.0), 1.0);
    assert_eq!(table.albedo(f64::NAN), 0.0);
}

/// On a plane, the samples of all axes and channels together find what leaves in all.
#[test]
fn probes_of_a_plane_find_all_light() {
    let table = Table::new(0.0, 1.33);
    let channels = [(1.0, 0.9), (3.0, 0.99), (10.0, 0.5)]
        .map(|(extinction, albedo)| Radial::new(&table, extinction, albedo));
    let n = DVec3::new(0.3, -0.5, 0.8).normalize();
    let (x, y) = n.any_orthonormal_pair();
    // The frame leans, as that of a shading normal.
    let lean = (n + 0.5 * x).normalize();
    let place = Place { p: DVec3::splat(2.0), axes: [lean.cross(y), y, lean] };
    let throughput = Vec3::new(1.0, 0.5, 2.0);
    let (count, mut sum) = (1 << 18, Vec3::ZERO);
    for index in 0..count {
        // Points of Roberts' sequence in three dimensions.
        let u = |share: f64| (f64::from(index) * share + 0.5).fract();
        let [a, b, c] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_5].map(u);
        let Some(probe) = place.probe(&channels, throughput, a, [b, c]) else { continue };
        let t = (place.p - probe.o).dot(n) / probe.d.dot(n);
        if t > 0.0 && t < probe.length {
            sum += place.weight(&channels, throughput, probe.o + probe.d * t, n);
        }
    }
    let found = sum / count as f32;
    for (channel, found) in channels.iter().flatten().zip(found.to_array()) {
        let expected = channel.value(0.1) / channel.pdf(0.1);
        assert!((f64::from(found) / expected - 1.0).abs() < 5e-3, "{found}, not {expected}");
    }
}

#[test]
fn bad_values_give_no_light_or_finite_light() {
    let mut found = 0;
    let bad = [0.0, -1.0, 1e-300, 1e300, f64::INFINITY, f64::NAN, 1.0];
    for (g, eta) in [(-1.0, 1e-3), (1.0, 1e9), (1.0, 1.0), (0.0, 2.6)] {
        let table = Table::new(g, eta);
        for a in bad {
            for b in bad {
                for medium in [Medium::Coefficients(&table), Medium::Color(&table)] {
                    let channels = medium.channels([Vec3::splat(a as f32), Vec3::splat(b as f32)]);
                    let place = Place { p: DVec3::ONE, axes: [DVec3::X, DVec3::Y, DVec3::Z] };
                    for throughput in [Vec3::X, Vec3::ZERO, Vec3::NAN, Vec3::new(1e30, 0.0, 1e-30)] {
                        let probe = place.probe(&channels, throughput, 0.3, [0.4, 0.6]);
                        let rest = probe.map_or(0.0, |probe| probe.rest);
                        assert!((0.0..1.0).contains(&rest), "{throughput} {rest}");
                    }
                    let Some(probe) = place.probe(&channels, Vec3::ONE, 0.3, [0.4, 0.6]) else { continue };
                    found += 1;
                    let p = probe.o + probe.d * probe.length * 0.5;
                    assert!(p.is_finite() && probe.length >= 0.0, "{g} {eta} {a} {b}");
                    let weight = place.weight(&channels, Vec3::ONE, p, DVec3::Z);
                    assert!(!weight.is_nan() && weight.min_element() >= 0.0, "{g} {eta} {a} {b}: {weight}");
                }
            }
        }
    }
    assert!(found > 10, "{found}");
}

/// The mean color of what a camera on the z axis sees in a narrow view.
fn seen(world: &str, integrator: &str, samples: u32) -> Vec3 {
    let scene = scene(&format!(
        "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 4
         Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 PixelFilter \"box\"
         Sampler \"sobol\" \"integer pixelsamples\" {samples} Integrator {integrator} WorldBegin {world} WorldEnd"
    ));
    let rendered = render(&scene, &Settings::default(), &|_| ControlFlow::Continue(()));
    let pixels = rendered.image.rgb().unwrap();
    pixels.iter().map(|rgb| Vec3::from_array(*rgb)).sum::<Vec3>() / pixels.len() as f32
}

/// Between two planes, what comes through from an even light behind is the integral of the profile beyond their distance, as far as any probe
/// reaches.
#[test]
fn light_comes_through_a_wall_as_far_as_each_channel_reaches() {
    const WALL: f64 = 0.4;
    let quad = |z: f64, order: &str| {
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [{order}] \"point P\" [-99 -99 {z} 99 -99 {z} 99 99 {z} -99 99 {z}] "
        )
    };
    let world = format!(
        "AttributeBegin Material \"matte\" \"rgb Kd\" [0 0 0] AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Translate 0 0 -2
         Shape \"disk\" \"float radius\" 2000 AttributeEnd
         Material \"subsurface\" \"rgb sigma_a\" [.02 .1 3] \"rgb sigma_s\" [2 4 9] {} {}",
        quad(0.0, "0 1 2 0 2 3"),
        quad(-WALL, "0 2 1 0 3 2")
    );
    let found = seen(&world, "\"path\" \"integer maxdepth\" 1", 4096);
    let table = Table::new(0.0, 1.33);
    let channels =
        Medium::Coefficients(&table).channels([Vec3::new(0.02, 0.1, 3.0), Vec3::new(2.0, 4.0, 9.0)]);
    let entering = 1.0 - (0.33_f64 / 2.33).powi(2);
    let reach = channels.iter().flatten().map(|channel| channel.reach).fold(0.0, f64::max);
    for (channel, found) in channels.iter().flatten().zip(found.to_array()) {
        let steps = 1_000_000;
        let step = (reach - WALL) / f64::from(steps);
        let ring = |index: i32| {
            let r = WALL + (f64::from(index) + 0.5) * step;
            2.0 * PI * r * channel.value(r) * step
        };
        let expected = entering * (0..steps).map(ring).sum::<f64>();
        assert!((f64::from(found) / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
    }
}

const LIGHT: &str = "LightSource \"infinite\" \"rgb L\" [.3 .4 .5]
    LightSource \"point\" \"rgb I\" [20 20 20] \"point from\" [3 2 2] ";
const BOX: &str = "Shape \"trianglemesh\" \"integer indices\" [0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 2 3 7 2 7 6 1 2 6 1 6 5 0 4 7 0 7 3]
    \"point P\" [-.1 -.1 -1 .1 -.1 -1 .1 .1 -1 -.1 .1 -1 -.1 -.1 0 .1 -.1 0 .1 .1 0 -.1 .1 0] ";

#[test]
fn bodies_look_alike_however_they_are_given() {
    for material in [
        "\"subsurface\" \"float scale\" 10",
        "\"kdsubsurface\" \"rgb Kd\" [.8 .5 .3] \"rgb mfp\" [.1 .2 .1] \"float uroughness\" .3 \"float vroughness\" .2",
        "\"disney\" \"rgb color\" [.8 .5 .3] \"rgb scatterdistance\" [.3 .2 .1]",
    ] {
        let path = "\"path\" \"integer maxdepth\" 4";
        let material = format!("{LIGHT} Material {material} ");
        let expected = seen(&format!("{material} {BOX}"), path, 1024);
        assert!(expected.min_element() > 0.05, "{expected}");
        // Many more shapes make a tree of the world.
        let others = "AttributeBegin Translate 0 0 -99 Shape \"sphere\" AttributeEnd ".repeat(60);
        for (world, integrator) in [
            (format!("{material} {BOX}"), path.replace("path", "volpath")),
            (format!("{material} {BOX} {others}"), path.to_string()),
            (format!("{material} ReverseOrientation {BOX}"), path.to_string()),
            (format!("{material} ObjectBegin \"o\" {BOX} ObjectEnd ObjectInstance \"o\""), path.to_string()),
            (
                format!("Scale -1 1 1 {} Scale -1 1 1 {BOX}", material.replace("[3 2 2]", "[-3 2 2]")),
                path.into(),
            ),
        ] {
            let found = seen(&world, &integrator, 1024);
            let error = ((found - expected) / expected).abs().max_element();
            assert!(error < 0.01, "{world} {integrator}: {found}, not {expected}");
        }
    }
}

/// A mix of a body with itself is the body, and a body without a diffuse share is none.
#[test]
fn shares_of_bodies_count_once() {
    let path = "\"path\" \"integer maxdepth\" 4";
    let disney = |rest: &str| format!("\"disney\" \"rgb color\" [.8 .5 .3] {rest}");
    let body = "\"rgb scatterdistance\" [.3 .2 .1]";
    let named = |material: &str| material.replacen("\"disney\"", "\"a\" \"string type\" \"disney\"", 1);
    let mix = "Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"a\" \"rgb amount\" [.3 .3 .3]";
    for (one, other) in [
        (format!("Material {}", disney(body)), format!("MakeNamedMaterial {} {mix}", named(&disney(body)))),
        (
            format!("Material {}", disney("\"float spectrans\" 1")),
            format!("Material {}", disney(&format!("\"float spectrans\" 1 {body}"))),
        ),
    ] {
        let [one, other] =
            [one, other].map(|material| seen(&format!("{LIGHT} {material} {BOX}"), path, 4096));
        let error = ((other - one) / one).abs().max_element();
        assert!(one.min_element() > 0.02 && error < 0.02, "{other}, not {one}");
    }
}
