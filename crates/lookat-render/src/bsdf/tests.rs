//! Every material: samples follow their density, light goes both ways alike, and none is made.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec2, DVec3};
use lookat_scene::{
    Disney, FourierTable, Glass, Hair, HairColor, Material, MaterialKind, Matte, Metal, Mirror, Mix, Plastic,
    Roughness, Substrate, Texture, ThinDisney, Transform, Translucent, Uber, Value, Varying,
};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::LobeSlots;
use super::lobe::{LobeKind, Lobes};
use super::*;
use crate::number::Vec3fx8;
use crate::number::{LANES, set_lanes};
use crate::testing::baseline;
use crate::texture::TexturePoint;
use glam::Vec3;

const COLOR: Vec3 = Vec3::new(0.9, 0.5, 0.7);

fn constant<T: Value>(value: T) -> Texture<T> {
    Texture::Constant(value)
}

fn color(share: f32) -> Texture<Vec3> {
    constant(COLOR * share)
}

fn rough(u: f64, v: f64) -> Roughness {
    Roughness { u: constant(u), v: Some(constant(v)), remap: false }
}

fn uber() -> Uber {
    Uber {
        kd: color(0.3),
        ks: color(0.3),
        kr: color(0.2),
        kt: color(0.3),
        roughness: rough(0.3, 0.3),
        eta: constant(1.5),
        opacity: color(0.8),
    }
}

fn glass(u: f64, v: f64) -> MaterialKind {
    glass_of(1.5, rough(u, v))
}

fn glass_of(eta: f64, roughness: Roughness) -> MaterialKind {
    let all = constant(Vec3::ONE);
    MaterialKind::Glass(Glass { kr: all.clone(), kt: all, roughness, eta: constant(eta) })
}

fn substrate(u: f64, v: f64) -> MaterialKind {
    MaterialKind::Substrate(Substrate { kd: color(0.7), ks: color(0.3), roughness: rough(u, v) })
}

/// Everything that a solid can have, at the default roughness.
fn disney() -> Disney {
    Disney {
        color: color(0.6),
        metallic: constant(0.3),
        eta: constant(1.5),
        roughness: constant(0.5),
        specular_tint: constant(0.7),
        anisotropic: constant(0.6),
        sheen: constant(0.5),
        sheen_tint: constant(0.5),
        clearcoat: constant(1.0),
        clearcoat_gloss: constant(0.0),
        spec_trans: constant(0.0),
        scatter_distance: color(0.0),
        thin: None,
    }
}

fn fourier(bytes: &[u8]) -> MaterialKind {
    MaterialKind::Fourier(std::sync::Arc::new(FourierTable::from_bytes(bytes).unwrap()))
}

fn hair() -> Hair {
    Hair {
        color: HairColor::Absorption(color(0.5)),
        eta: constant(1.55),
        beta_m: constant(0.4),
        beta_n: constant(0.4),
        alpha: constant(3.0),
    }
}

fn thin() -> Option<ThinDisney> {
    Some(ThinDisney { flatness: constant(0.5), diff_trans: constant(0.8) })
}

fn material(kind: MaterialKind) -> Material {
    Material::new(kind, None)
}

/// All kinds, by name.
fn materials() -> Vec<(&'static str, Material)> {
    let metal = |u, v| {
        let (eta, k) = (constant(Vec3::new(0.2, 0.9, 1.1)), constant(Vec3::new(3.9, 2.4, 2.1)));
        MaterialKind::Metal(Box::new(Metal { eta, k, roughness: rough(u, v) }))
    };
    let plastic =
        MaterialKind::Plastic(Plastic { kd: color(0.5), ks: color(0.5), roughness: rough(0.2, 0.2) });
    let translucent = MaterialKind::Translucent(Translucent {
        kd: color(0.6),
        ks: color(0.4),
        reflect: constant(Vec3::splat(0.5)),
        transmit: constant(Vec3::splat(0.5)),
        roughness: rough(0.3, 0.3),
    });
    let mix = MaterialKind::Mix(Mix {
        materials: [material(plastic.clone()), material(substrate(0.2, 0.5))].map(std::sync::Arc::new),
        amount: constant(Vec3::new(0.2, 0.5, 0.9)),
    });
    let all = [
        ("matte", MaterialKind::Matte(Matte { kd: color(1.0), sigma: constant(0.0) })),
        ("rough matte", MaterialKind::Matte(Matte { kd: color(1.0), sigma: constant(40.0) })),
        ("plastic", plastic),
        ("translucent", translucent),
        ("smooth glass", glass(0.0, 0.0)),
        ("rough glass", glass(0.3, 0.3)),
        ("brushed glass", glass(0.6, 0.2)),
        ("mirror", MaterialKind::Mirror(Mirror { kr: color(1.0) })),
        ("metal", metal(0.1, 0.1)),
        ("brushed metal", metal(0.7, 0.2)),
        ("substrate", substrate(0.3, 0.3)),
        ("brushed substrate", substrate(0.6, 0.2)),
        ("uber", MaterialKind::Uber(Box::new(uber()))),
        ("mix", mix),
        ("lacquer", fourier(include_bytes!("../../../../pbrt-scenes/materials/lacquer.bsdf"))),
        ("paper", fourier(include_bytes!("../../../../pbrt-scenes/materials/paper.bsdf"))),
        ("hair", MaterialKind::Hair(Box::new(hair()))),
        ("disney", MaterialKind::Disney(Box::new(disney()))),
        ("disney glass", MaterialKind::Disney(Box::new(Disney { spec_trans: constant(0.7), ..disney() }))),
        (
            "thin disney",
            MaterialKind::Disney(Box::new(Disney { spec_trans: constant(0.4), thin: thin(), ..disney() })),
        ),
    ];
    all.into_iter().map(|(name, kind)| (name, material(kind))).collect()
}

const OUT: [DVec3; 4] = [
    DVec3::new(0.0, 0.0, 1.0),
    DVec3::new(0.48, -0.36, 0.8),
    DVec3::new(-0.8, 0.55, 0.24),
    DVec3::new(0.5, 0.3, -0.81),
];

/// The frame turned away from the axes.
fn frame() -> Frame {
    let z = DVec3::new(0.3, -0.5, 0.8).normalize();
    baseline!(simd => {
        let Frames { x, y, z } = Frames::from_z(Vec3x8::splat(simd, z));
        Frame(DMat3::from_cols(x.lane(0), y.lane(0), z.lane(0)))
    })
}

struct Frame(DMat3);

impl Frame {
    fn z(&self) -> DVec3 {
        self.0.z_axis
    }

    fn to_world(&self, v: DVec3) -> DVec3 {
        self.0 * v
    }

    fn to_local(&self, v: DVec3) -> DVec3 {
        self.0.transpose() * v
    }
}

/// A point of a surface, seen from a direction of its frame.
struct Point<'m> {
    material: &'m Material,
    local_o: DVec3,
}

/// A sample at a point.
struct Sample {
    wi: DVec3,
    pdf: f64,
    weight: Vec3,
    is_delta: bool,
    radiance_scale: f32,
}

impl Point<'_> {
    fn wo(&self) -> DVec3 {
        frame().to_world(self.local_o.normalize())
    }

    /// Does something with the BSDF.
    fn ask<S: Simd, T>(&self, simd: S, ask: impl FnOnce(&Bsdf<S>) -> T) -> T {
        let mut slots = LobeSlots::new();
        let at = TexturePoint::splat(simd, DVec3::ZERO, [0.3, 0.7]);
        slots.build(self.material.kind(), &at, bits(simd, 0xff));
        let n = Vec3x8::splat(simd, frame().z());
        ask(&Bsdf::new(n.narrow(), n, Frames::from_z(n.narrow()), Vec3x8::splat(simd, self.wo()), &mut slots))
    }

    fn has(&self, part: LobeFilter) -> bool {
        baseline!(simd => self.ask(simd, |bsdf| bsdf.has(part).any_true()))
    }

    /// Values and densities.
    fn f_cos_pdf(&self, wi: &[DVec3], part: LobeFilter) -> Vec<(Vec3, f64)> {
        let mut all = Vec::new();
        baseline!(simd => self.ask(simd, |bsdf| for wi in wi.chunks(LANES) {
            let mut directions = Vec3x8::splat(simd, DVec3::Z);
            wi.iter().enumerate().for_each(|(lane, wi)| directions.set_lane(lane, *wi));
            let (f_cos, pdf) = bsdf.f_cos_pdf(directions.narrow(), part);
            all.extend((0..wi.len()).map(|lane| (f_cos.lane(lane), f64::from(pdf[lane]))));
        }));
        all
    }

    /// Samples, where there are some.
    fn samples(&self, u: &[DVec2], part: LobeFilter) -> Vec<Option<Sample>> {
        let mut all = Vec::new();
        baseline!(simd => self.ask(simd, |bsdf| for u in u.chunks(LANES) {
            let of = |lane: usize| u.get(lane).copied().unwrap_or_default();
            let square = [f64x8::from_fn(simd, |lane| of(lane).x), f64x8::from_fn(simd, |lane| of(lane).y)];
            let sample = bsdf.sample(square, part);
            let is_valid: Vec<usize> = set_lanes(sample.is_valid).collect();
            all.extend((0..u.len()).map(|lane| is_valid.contains(&lane).then(|| Sample {
                wi: sample.wi.lane(lane),
                pdf: f64::from(sample.pdf[lane]),
                weight: sample.weight.lane(lane),
                is_delta: sample.is_delta.to_bitmask() >> lane & 1 == 1,
                radiance_scale: sample.radiance_scale[lane],
            })));
        }));
        all
    }
}

fn grid(side: u32) -> Vec<DVec2> {
    let cell = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
    (0..side * side).map(move |i| DVec2::new(cell(i % side), cell(i / side))).collect()
}

const RINGS: usize = 20;
const SECTORS: usize = 24;

/// The cell of the sphere that a direction lies in: equal steps of the angle to z and of the angle about it.
fn cell(local: DVec3) -> usize {
    let ring = (local.truncate().length().atan2(local.z) / PI * RINGS as f64) as usize;
    let sector = ((local.y.atan2(local.x) / TAU).rem_euclid(1.0) * SECTORS as f64) as usize;
    ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)
}

/// The density over the cells of the sphere, by Simpson's rule with 32 steps each way.
fn expected(point: &Point) -> Vec<f64> {
    const STEPS: usize = 32;
    let weight = |i: usize| match i {
        0 | STEPS => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let area = (PI / RINGS as f64) * (TAU / SECTORS as f64) / (3.0 * STEPS as f64).powi(2);
    let one = |ring: usize, sector: usize| {
        let (mut directions, mut weights) = (Vec::new(), Vec::new());
        for (i, j) in (0..=STEPS).flat_map(|i| (0..=STEPS).map(move |j| (i, j))) {
            // Just inside, so that the step of the density at the horizon stays on its side.
            let along = (i as f64).clamp(1e-5, STEPS as f64 - 1e-5) / STEPS as f64;
            let (r, z) = (PI * (ring as f64 + along) / RINGS as f64).sin_cos();
            let phi = TAU * (sector as f64 + j as f64 / STEPS as f64) / SECTORS as f64;
            directions.push(frame().to_world(DVec3::new(r * phi.cos(), r * phi.sin(), z)));
            weights.push(weight(i) * weight(j) * r);
        }
        let found = point.f_cos_pdf(&directions, LobeFilter::NonDelta);
        found.iter().zip(weights).map(|((_, pdf), weight)| pdf * weight).sum::<f64>() * area
    };
    (0..RINGS * SECTORS).map(|at| one(at / SECTORS, at % SECTORS)).collect()
}

/// The chi-square test of samples against their density, with the share that is not scattered as a cell of its own.
#[test]
fn samples_follow_their_density() {
    const SAMPLES: u32 = 300;
    let mut count = 0.0;
    for (name, material) in &materials() {
        for (number, local_o) in OUT.into_iter().enumerate() {
            let point = Point { material, local_o };
            if !point.has(LobeFilter::NonDelta) {
                continue;
            }
            let mut found = vec![0.0; RINGS * SECTORS + 1];
            let mut random = random_numbers(number as u64);
            let square: Vec<_> = (0..SAMPLES * SAMPLES).map(|_| DVec2::new(random(), random())).collect();
            for sample in point.samples(&square, LobeFilter::NonDelta) {
                let at = sample.map_or(RINGS * SECTORS, |sample| cell(frame().to_local(sample.wi)));
                found[at] += 1.0;
            }
            let mut expected = expected(&point);
            // Lobes that pass light on absorb what cannot pass.
            expected.push((1.0 - expected.iter().sum::<f64>()).max(0.0));
            let p = p_value(&found, &expected, f64::from(SAMPLES * SAMPLES));
            assert!(p > 1e-4, "{name} {local_o}: p = {p}");
            count += 1.0;
        }
    }
    assert_eq!(count, 18.0 * 4.0);
}

/// Evenly distributed numbers from 0 to 1.
fn random_numbers(seed: u64) -> impl FnMut() -> f64 {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
    move || random.random_range(0.0..1.0)
}

/// The probability of a deviation this large, with cells of few samples put together.
fn p_value(found: &[f64], expected: &[f64], samples: f64) -> f64 {
    let (mut chi2, mut degrees, mut rest) = (0.0, -1.0, (0.0, 0.0));
    let mut add = |found: f64, expected: f64| {
        chi2 += (found - expected).powi(2) / expected;
        degrees += 1.0;
    };
    for (found, share) in found.iter().zip(expected) {
        let expected = share * samples;
        if expected >= 20.0 {
            add(*found, expected);
        } else {
            rest = (rest.0 + found, rest.1 + expected);
        }
    }
    if rest.1 > 5.0 {
        add(rest.0, rest.1);
    }
    if degrees < 1.0 { 1.0 } else { 1.0 - ChiSquared::new(degrees).unwrap().cdf(chi2) }
}

/// Up to what rounding the direction to `f32` does to facets of a tenth, and to cosines.
#[test]
fn sampled_values_are_those_of_f_and_pdf() {
    let mut exceptions = 0;
    for (name, material) in &materials() {
        for local_o in OUT {
            let point = Point { material, local_o };
            let samples: Vec<Sample> =
                point.samples(&grid(16), LobeFilter::NonDelta).into_iter().flatten().collect();
            let directions: Vec<DVec3> = samples.iter().map(|sample| sample.wi).collect();
            for (sample, (f_cos, pdf)) in
                samples.iter().zip(point.f_cos_pdf(&directions, LobeFilter::NonDelta))
            {
                assert!(
                    (sample.pdf - pdf).abs() <= 1e-4 * pdf + 1e-7,
                    "{name} {local_o}: {} {pdf}",
                    sample.pdf
                );
                let own = sample.weight * sample.pdf as f32;
                let excess = (own - f_cos).length() - (1e-4 * f_cos.length() + 1e-7);
                if excess <= 0.0 {
                    continue;
                }
                // Near total reflection the rounding of a direction changes much.
                let beside = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| {
                    let wi = (sample.wi + axis * f64::from(f32::EPSILON)).normalize();
                    (point.f_cos_pdf(&[wi], LobeFilter::NonDelta)[0].0 - f_cos).length()
                });
                let rounding = beside.into_iter().fold(0.0, f32::max);
                assert!(excess <= rounding, "{name} {local_o}: {own} {f_cos} {rounding}");
                assert!(sample.wi.dot(DVec3::Z) * local_o.z < 0.0, "{name}: only refraction is that sharp");
                exceptions += 1;
            }
        }
    }
    assert!(exceptions <= 3, "{exceptions} of 14,000");
}

/// The share of white light from all around that comes towards `local_o`, refraction's density aside: that of the channel
/// that most comes back of, and its standard error.
fn albedo(material: &Material, local_o: DVec3) -> (f64, f64) {
    let side = 256;
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for sample in (Point { material, local_o }).samples(&grid(side), LobeFilter::All).into_iter().flatten() {
        let weight = (sample.weight / sample.radiance_scale).as_dvec3();
        (sum, squares) = (sum + weight, squares + weight * weight);
    }
    let count = f64::from(side * side);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(DVec3::ZERO) / count;
    (mean.max_element(), variance.max_element().sqrt())
}

/// No surface gives back more light than it gets, from any side, at any roughness. Where nothing is absorbed and the
/// surface is smooth, it gives back all.
#[test]
fn no_light_is_made() {
    let mut all = materials();
    // The diffuse light of disney ignores what the gloss reflects; what is clear or metal makes none. Tilted scales of hair make a little.
    all.retain(|(name, _)| !name.contains("disney") && *name != "hair");
    for roughness in [0.001, 0.05, 0.3, 1.0] {
        let white = |metallic| Disney {
            color: constant(Vec3::ONE),
            roughness: constant(f64::sqrt(roughness)),
            metallic: constant(metallic),
            spec_trans: constant(1.0),
            clearcoat: constant(0.0),
            ..disney()
        };
        for metallic in [0.0, 0.5, 1.0] {
            let solid = white(metallic);
            let sheet = Disney { thin: thin(), ..solid.clone() };
            for disney in [solid, sheet] {
                all.push(("disney", material(MaterialKind::Disney(Box::new(disney)))));
            }
        }
        all.push(("glass", material(glass(roughness, roughness))));
        all.push(("substrate", material(substrate(roughness, roughness))));
        // Between alike media light goes straight on; between nearly alike ones, nearly so.
        all.push(("smooth glass", material(glass_of(1.0, rough(roughness, roughness)))));
        all.push(("nearly nothing", material(glass_of(1.0002, rough(roughness, roughness)))));
    }
    for (name, material) in all {
        for degrees in [0.0, 30.0, 60.0, 80.0, 88.0, 100.0, 150.0_f64] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (share, error) = albedo(&material, DVec3::new(sin, 0.0, cos));
            assert!(share < 1.0 + 1e-5 + 4.0 * error, "{name} at {degrees} degrees: {share} ± {error}");
            if name == "smooth glass" {
                assert!((share - 1.0).abs() < 1e-3, "{name} at {degrees} degrees: {share}");
            }
            if name == "matte" {
                assert!((share - 0.9).abs() < 1e-5, "{name} at {degrees} degrees: {share}");
            }
        }
    }
}

/// Light that is reflected goes both ways alike; what is refracted changes with the squared index.
#[test]
fn what_goes_one_way_goes_the_other() {
    for (name, material) in &materials() {
        for a in OUT {
            for b in OUT.into_iter().chain([DVec3::new(0.1, -0.2, -0.97)]) {
                let (a, b) = (a.normalize(), b.normalize());
                let f = |local_o: DVec3, wi: DVec3| {
                    let found =
                        Point { material, local_o }.f_cos_pdf(&[frame().to_world(wi)], LobeFilter::All);
                    found[0].0 / wi.z.abs() as f32
                };
                let (one, other) = (f(a, b), f(b, a));
                if ["hair", "lacquer", "paper"].contains(name) {
                    continue;
                }
                if a.z * b.z > 0.0 {
                    assert!((one - other).length() <= 1e-5 * one.length(), "{name} {a} {b}: {one} {other}");
                } else if name.ends_with("glass") || *name == "thin disney" {
                    let ratio = if a.z > 0.0 { 1.5_f32.powi(2) } else { 1.5_f32.powi(-2) };
                    let ratio = if *name == "thin disney" { 1.0 } else { ratio };
                    assert!((one * ratio - other).length() <= 1e-4 * other.length(), "{name} {a} {b}");
                }
            }
        }
    }
}

/// Without absorption, hair gives back all light; at every place across it, and from every side.
#[test]
fn white_hair_absorbs_nothing() {
    for (beta_m, beta_n, alpha) in
        [(0.3, 0.3, 2.0), (0.1, 0.2, 0.0), (0.6, 1.0, 0.0), (1.0, 0.6, 0.0), (0.05, 0.05, 0.0)]
    {
        let white = Hair {
            color: HairColor::Absorption(constant(Vec3::ZERO)),
            beta_m: constant(beta_m),
            beta_n: constant(beta_n),
            alpha: constant(alpha),
            ..hair()
        };
        let material = material(MaterialKind::Hair(Box::new(white)));
        for local_o in OUT {
            let (share, error) = albedo(&material, local_o);
            // Scales turn light away from directions beyond the fiber's own.
            let tolerance = 4.0 * error + if alpha == 0.0 { 1e-3 } else { 0.03 };
            assert!((share - 1.0).abs() < tolerance, "{beta_m} {beta_n} {local_o}: {share} ± {error}");
        }
    }
}

/// Without scales, and at equal angles to the fiber, light goes both ways alike, seen from the other side of the fiber. Otherwise the
/// attenuation by the fiber depends on the viewer only, as in pbrt-v3.
#[test]
fn light_in_hair_goes_both_ways_at_equal_angles() {
    baseline!(simd => {
        let lobe = |h: f32| Lobes {
            colors: [Vec3fx8::splat(simd, COLOR), Vec3fx8::splat(simd, Vec3::new(h, 0.0, 1.0))],
            roughness: [splat_f32(simd, 0.1), splat_f32(simd, 0.2)],
            eta: splat_f32(simd, 1.55),
            ..Lobes::new(LobeKind::Hair, Vec3fx8::splat(simd, Vec3::ONE))
        };
        let above = mask32x8::splat(simd, true);
        for h in [-0.9, -0.4, 0.0, 0.3, 0.8] {
            for phi in [0.3_f32, 1.4, 2.8, 4.0, 5.5] {
                let [a, b] = [Vec3::new(0.6, 0.8 * phi.cos(), 0.8 * phi.sin()), Vec3::new(-0.6, 0.48, 0.64)];
                let [a, b] = [a, b].map(|w| Vec3fx8::splat(simd, w));
                let (one, other) = (lobe(h).f_pdf(a, b, above, above).0 * b.z, lobe(-h).f_pdf(b, a, above, above).0 * a.z.abs());
                let (one, other) = (one.lane(0), other.lane(0));
                assert!((one - other).length() <= 1e-4 * one.length(), "{h} {phi}: {one} {other}");
            }
        }
    });
}

/// Light that goes in and out of glass keeps its direction and its energy.
#[test]
fn refraction_is_undone_on_the_way_out() {
    let material = material(glass(0.0, 0.0));
    for local_o in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.9, 0.2, 0.4)] {
        let into = Point { material: &material, local_o };
        let (wo, n) = (into.wo(), frame().z());
        let one =
            |point: &Point, u: f64| point.samples(&[DVec2::splat(u)], LobeFilter::All).remove(0).unwrap();
        let through = one(&into, 0.999_999);
        assert!(through.is_delta && through.wi.dot(n) < 0.0);
        let sines = [wo, through.wi].map(|w| w.cross(n).length());
        assert!((sines[0] - 1.5 * sines[1]).abs() < 1e-12);
        let out = Point { local_o: frame().to_local(through.wi), ..into };
        let back = one(&out, 0.999_999);
        assert!((back.wi - wo).length() < 1e-12);
        assert!((through.weight * back.weight - Vec3::ONE).length() < 1e-6);
        assert!((through.radiance_scale * back.radiance_scale - 1.0).abs() < 1e-6);
        let mirrored = one(&into, 0.0).wi;
        assert!((mirrored + wo - n * (2.0 * wo.dot(n))).length() < 1e-12);
    }
}

/// The white share of a clear hole passes straight through.
#[test]
fn opacity_lets_light_through() {
    let clear = Uber { opacity: constant(Vec3::splat(0.25)), ..uber() };
    let material = &material(MaterialKind::Uber(Box::new(clear)));
    let point = Point { material, local_o: OUT[1] };
    // The first number chooses the lobe: a fine row finds its probability to 1 in 65536.
    let row: Vec<_> = (0..65536).map(|i| DVec2::new((f64::from(i) + 0.5) / 65536.0, 0.5)).collect();
    let straight = point.samples(&row, LobeFilter::Delta).into_iter().flatten();
    let straight = straight.filter(|sample| (sample.wi + point.wo()).length() < 1e-9);
    let share: f64 = straight.map(|sample| f64::from(sample.weight.x)).sum::<f64>() / 65536.0;
    assert!((share - 0.75).abs() < 1e-4, "{share}");
}

#[test]
fn no_material_has_more_lobes_than_is_said_of_it() {
    for (name, material) in materials() {
        let exact = most_lobes(&material);
        let waves = Texture::varying(Varying::Windy { texture_from_world: Transform::IDENTITY });
        let bound = most_lobes(&Material::new(material.kind().clone(), Some(waves)));
        assert!(exact.all <= bound.all && exact.specular <= bound.specular, "{name}: {exact:?}, {bound:?}");
    }
    let exact = |kind| {
        let most = most_lobes(&material(kind));
        (most.all, most.specular)
    };
    assert_eq!(exact(MaterialKind::Uber(Box::new(uber()))), (5, 3));
    assert_eq!(
        (exact(glass(0.0, 0.0)), exact(glass(0.3, 0.3)), exact(substrate(0.1, 0.1))),
        ((1, 1), (1, 0), (1, 0))
    );
}

/// Parameters that no substance has, from textures, scatter nothing that is no number.
#[test]
fn extreme_parameters_scatter_numbers() {
    let extreme = |x: f64| {
        let uber = Uber { eta: constant(x), roughness: rough(x, 0.1), ..uber() };
        let rough_glass = glass_of(x, rough(0.2, x));
        let matte = Matte { kd: color(1.0), sigma: constant(x) };
        let disney = Disney {
            color: color(1.0),
            metallic: constant(x),
            eta: constant(x),
            roughness: constant(x),
            specular_tint: constant(x),
            anisotropic: constant(x),
            sheen: constant(x),
            sheen_tint: constant(x),
            clearcoat: constant(x),
            clearcoat_gloss: constant(x),
            spec_trans: constant(x),
            scatter_distance: color(x as f32),
            thin: None,
        };
        let [a, b] =
            [Hair { alpha: constant(x), beta_m: constant(x), ..hair() }, Hair { eta: constant(x), ..hair() }];
        let pigments = HairColor::Pigments { eumelanin: constant(x), pheomelanin: constant(0.0) };
        let c = Hair { color: pigments, beta_n: constant(x), ..hair() };
        let thin = Some(ThinDisney { flatness: constant(x), diff_trans: constant(x) });
        let sheet = Disney { spec_trans: constant(0.5), thin, ..disney.clone() };
        [
            MaterialKind::Disney(Box::new(disney)),
            MaterialKind::Disney(Box::new(sheet)),
            MaterialKind::Hair(Box::new(a)),
            MaterialKind::Hair(Box::new(b)),
            MaterialKind::Hair(Box::new(c)),
            MaterialKind::Uber(Box::new(uber)),
            glass_of(x, rough(0.0, 0.0)),
            rough_glass,
            MaterialKind::Matte(matte),
        ]
    };
    for x in [0.0, -1.0, 1e-300, 1e20, 1e50, f64::INFINITY, f64::NAN] {
        for material in extreme(x).map(material) {
            for local_o in OUT {
                let point = Point { material: &material, local_o };
                for sample in point.samples(&grid(16), LobeFilter::All).into_iter().flatten() {
                    assert!(sample.weight.is_finite() && sample.wi.is_finite(), "{x} {material:?}");
                }
            }
        }
    }
}

/// Lambert lobes of these reflectances, seen from the normal.
fn weighed<S: Simd>(simd: S, reflectances: &[f32]) -> LobeSlots<'static, S> {
    let (mut slots, mut from) = (LobeSlots::new(), 0);
    for color in reflectances {
        let lobe = Lobes::new(LobeKind::Lambert, Vec3fx8::splat(simd, Vec3::splat(*color)));
        slots.push(lobe, mask32x8::splat(simd, true), &mut from);
    }
    weigh(&mut slots.lobes, splat_f32(simd, 1.0));
    slots
}

/// A quarter is shared alike, the rest in proportion to what is reflected; alike where that says nothing.
#[test]
fn lobes_are_likely_by_what_they_reflect() {
    let probabilities = |reflectances: &[f32]| -> Vec<f32> {
        baseline!(simd => {
            weighed(simd, reflectances).lobes.iter().map(|slot| slot.probability[0]).collect()
        })
    };
    assert_eq!(probabilities(&[0.01]), [1.0]);
    let [a, b] = probabilities(&[0.25, 0.75])[..] else { panic!() };
    assert!((a - (0.125 + 0.25 * 0.75)).abs() < 1e-6 && (a + b - 1.0).abs() < 1e-6);
    for nothing in [-0.5, f32::NAN] {
        assert_eq!(probabilities(&[nothing, 1.0]), [0.125, 0.875]);
    }
    for useless in [[0.0, 0.0], [-1.0, 0.0], [f32::MAX, f32::MAX], [f32::INFINITY, 1.0]] {
        assert_eq!(probabilities(&useless), [0.5, 0.5]);
    }
}

/// Over even numbers, lobes come up as often as is said, and what is left of the number is even again.
#[test]
fn choices_keep_their_probabilities() {
    const STEPS: u32 = 10_000;
    let mut found = [(0, 0.0, 0.0); 3];
    baseline!(simd => {
        let slots = &weighed(simd, &[0.1, 0.2, 0.7]).lobes;
        for step in 0..STEPS {
            let u = (f64::from(step) + 0.5) / f64::from(STEPS);
            let choice = choose(slots, LobeFilter::NonDelta, f64x8::splat(simd, u));
            assert!((0.0..1.0).contains(&choice.rest[0]));
            let (count, said, sum) = found[choice.slot[0] as usize];
            found[choice.slot[0] as usize] =
                (count + 1, said + f64::from(choice.probability[0]), sum + choice.rest[0]);
        }
        assert_eq!(choose(slots, LobeFilter::Delta, f64x8::splat(simd, 0.5)).slot[0], NO_SLOT);
        assert!(choose(slots, LobeFilter::All, f64x8::splat(simd, 1.0)).rest[0] < 1.0);
    });
    for (count, said, sum) in found {
        let count = f64::from(count);
        assert!((said / count - count / f64::from(STEPS)).abs() < 1e-3);
        assert!((sum / count - 0.5).abs() < 1e-3);
    }
}
