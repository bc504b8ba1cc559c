use std::array::from_fn;
use std::sync::Arc;

use fearless_simd::f64x8;
use glam::{DVec2, DVec3, Vec3};
use lookat_image::{MipMap, Wrap};
use lookat_scene::Mapping;

use super::*;
use crate::number::{LANES, Vec3x8, bits, side_by_side};
use crate::testing::{baseline, levels, noise};
use crate::texture::Footprint;

/// A place and the ends of its footprint.
type Place = (DVec2, [DVec2; 2]);

const ELLIPSE: ImageFilter = ImageFilter::Ellipse { max_anisotropy: 8.0 };

fn image<T: lookat_scene::Value>(map: &MipMap<T::Texel>, filter: ImageFilter) -> ImageMap<T> {
    let mapping = Mapping::Uv { scale: DVec2::ONE, offset: DVec2::ZERO };
    ImageMap { map: Arc::new(map.clone()), mapping, filter }
}

/// Lookups with the instructions of each level, which have the same bits.
fn colors(map: &MipMap<Vec3>, filter: ImageFilter, places: &[Place; LANES]) -> [Vec3; LANES] {
    let image = image::<Vec3>(map, filter);
    let all = levels().into_iter().map(|level| {
        side_by_side!(level, simd => {
            let lanes = |of: &dyn Fn(&Place) -> f64| f64x8::from_fn(simd, |lane| of(&places[lane]));
            let pair = |of: &dyn Fn(&Place) -> DVec2| [lanes(&|at| of(at).x), lanes(&|at| of(at).y)];
            let none = Vec3x8::splat(simd, DVec3::ZERO);
            let footprint = Footprint { dp: [none; 2], duv: [pair(&|at| at.1[0]), pair(&|at| at.1[1])] };
            let at = TexturePoint { p: none, origin: DVec3::ZERO, uv: pair(&|at| at.0), footprint: Some(&footprint) };
            let values = value::<_, Vec3>(&image, &at, bits(simd, 0xff));
            from_fn(|lane| values.lane(lane))
        })
    });
    let all: Vec<[Vec3; LANES]> = all.collect();
    let bits = |all: &[Vec3; LANES]| all.map(|color| color.to_array().map(f32::to_bits));
    assert!(all.iter().all(|own| bits(own) == bits(&all[0])));
    all[0]
}

fn color(map: &MipMap<Vec3>, filter: ImageFilter, st: DVec2, ends: [DVec2; 2]) -> Vec3 {
    colors(map, filter, &[(st, ends); LANES])[0]
}

/// A picture without pattern.
fn map(wrap: Wrap) -> MipMap<Vec3> {
    let texel = |i: usize| Vec3::new(noise(i, 1.1) as f32, noise(i, 2.3) as f32, noise(i, 3.7) as f32).abs();
    MipMap::new(64, 32, (0..64 * 32).map(texel).collect(), wrap)
}

/// A texel that may lie beyond the edges.
fn texel(map: &MipMap<Vec3>, level: usize, s: i64, t: i64) -> DVec3 {
    map.levels()[level].corners(s, t, map.wrap())[0].as_dvec3()
}

/// What [`ellipse::means`] approximates, by the loop over the box of pbrt-v3's MIPMap::EWA.
fn exact_ellipse(map: &MipMap<Vec3>, (st, ends): Place, max_anisotropy: f64) -> DVec3 {
    let (major, mut minor) =
        if ends[0].length() < ends[1].length() { (ends[1], ends[0]) } else { (ends[0], ends[1]) };
    minor *= (major.length() / (minor.length() * max_anisotropy)).max(1.0);
    let last = map.levels().len() - 1;
    let level = (last as f64 + minor.length().log2()).max(0.0);
    let at = |level: usize| {
        if level > last {
            return map.mean().as_dvec3();
        }
        let own = &map.levels()[level];
        let size = DVec2::new(own.width() as f64, own.height() as f64);
        let (x, y, center) = (major * size, minor * size, st * size - 0.5);
        let (a, b, c) =
            (x.y * x.y + y.y * y.y + 1.0, -2.0 * (x.x * x.y + y.x * y.y), x.x * x.x + y.x * y.x + 1.0);
        let f = a * c - b * b * 0.25;
        let (half_width, half_height) = (c.sqrt() + 1.0, a.sqrt() + 1.0);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for t in (center.y - half_height) as i64 - 1..(center.y + half_height) as i64 + 2 {
            for s in (center.x - half_width) as i64 - 1..(center.x + half_width) as i64 + 2 {
                let d = DVec2::new(s as f64, t as f64) - center;
                let squared_radius = (a * d.x * d.x + b * d.x * d.y + c * d.y * d.y) / f;
                if squared_radius < 1.0 {
                    let weight = (-2.0 * squared_radius).exp() - (-2.0_f64).exp();
                    sum += texel(map, level, s, t) * weight;
                    total += weight;
                }
            }
        }
        sum / total
    };
    let finer = level as usize;
    at(finer).lerp(at(finer + 1), level.fract())
}

/// PBR 10.4.4.
fn exact_trilinear(map: &MipMap<Vec3>, (st, ends): Place) -> DVec3 {
    let last = map.levels().len() - 1;
    let width = ends[0].abs().max_element().max(ends[1].abs().max_element());
    let level = (last as f64 + width.log2()).max(0.0);
    if level >= last as f64 {
        return map.mean().as_dvec3();
    }
    let at = |level: usize| {
        let own = &map.levels()[level];
        let place = st * DVec2::new(own.width() as f64, own.height() as f64) - 0.5;
        let (first, rest) = (place.floor(), place - place.floor());
        let row = |t: i64| {
            let at = |s: i64| texel(map, level, first.x as i64 + s, first.y as i64 + t);
            at(0).lerp(at(1), rest.x)
        };
        row(0).lerp(row(1), rest.y)
    };
    at(level as usize).lerp(at(level as usize + 1), level.fract())
}

/// Everywhere in and around the picture, from a small part of a texel to several pictures.
fn places(round: usize) -> [Place; LANES] {
    from_fn(|lane| {
        let random = |k: f64| noise(round * LANES + lane, k);
        let size = (random(5.1) * 7.0 - 5.0).exp2();
        let end = |k: f64| DVec2::new(random(k), random(k + 0.3)) * size;
        let thin = if lane % 2 == 0 { 1.0 } else { 0.1 };
        (DVec2::new(random(1.7), random(2.9)) * 2.0, [end(3.3), end(4.7) * thin])
    })
}

#[test]
fn lookups_are_near_exact_ones() {
    for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black] {
        let map = map(wrap);
        for round in 0..400 {
            let places = places(round);
            let all = [(ELLIPSE, 3e-6), (ImageFilter::Trilinear, 1e-6)];
            for (filter, bound) in all {
                let found = colors(&map, filter, &places);
                for (place, found) in places.into_iter().zip(found) {
                    let exact = match filter {
                        ImageFilter::Ellipse { max_anisotropy } => exact_ellipse(&map, place, max_anisotropy),
                        ImageFilter::Trilinear => exact_trilinear(&map, place),
                    };
                    // Beyond black edges, there is nothing to compare with.
                    let error = (found.as_dvec3() - exact).abs().max_element() / exact.max_element().max(0.1);
                    assert!(
                        error < bound,
                        "{wrap:?} {filter:?} {place:?}: {found} is not {exact}, by {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn nothing_beyond_the_edge_counts() {
    baseline!(simd => for i in 0..1000 {
        let x = i as f32 / 999.0 * 1.1;
        let weight = ellipse::weight(x.simd_into(simd))[0];
        let exact = (-2.0 * f64::from(x)).exp() - (-2.0_f64).exp();
        assert!((f64::from(weight) - exact.max(0.0)).abs() < 3e-7 && (x < 1.0 || weight == 0.0), "{x} {weight}");
    });
}

/// A long thin ellipse of many texels.
#[test]
fn long_ellipses_are_near_exact_ones() {
    let map = map(Wrap::Repeat);
    let place = (DVec2::new(0.3, 0.7), [DVec2::new(10.0, 7.0), DVec2::new(-0.007, 0.01)]);
    let found = color(&map, ImageFilter::Ellipse { max_anisotropy: 1000.0 }, place.0, place.1);
    let exact = exact_ellipse(&map, place, 1000.0);
    assert!((found.as_dvec3() - exact).abs().max_element() < 1e-5, "{found} {exact}");
}

#[test]
fn a_point_is_the_finest_version_and_all_is_the_mean() {
    let map = map(Wrap::Black);
    let st = DVec2::new(0.3, 0.7);
    let at = |ends| color(&map, ELLIPSE, st, ends);
    assert_eq!(at([DVec2::ZERO, DVec2::ZERO]), map.bilinear(st));
    assert_eq!(at([DVec2::X, DVec2::ZERO]), map.bilinear(st));
    for ends in [[DVec2::X * 2.0, DVec2::Y * 3.0], [DVec2::X * 1e300, DVec2::Y], [DVec2::splat(1e300); 2]] {
        assert!((at(ends) - map.mean()).length() < 1e-7);
    }
    // Either axis may be the longer one.
    let (x, y) = (DVec2::new(0.1, 0.02), DVec2::new(0.0, 0.05));
    assert_eq!(at([x, y]), at([y, x]));
    let trilinear = |width: f64| color(&map, ImageFilter::Trilinear, st, [DVec2::X * width, DVec2::ZERO]);
    assert_eq!([0.0, 1e-300, 1.0 / 64.0].map(trilinear), [map.bilinear(st); 3]);
    assert_eq!([1.0, 1e300].map(trilinear), [map.mean(); 2]);
}

/// Of a ramp the mean over any ellipse is the value at its center.
#[test]
fn a_ramp_stays() {
    let texels = (0..64 * 64).map(|i| Vec3::splat((i % 64) as f32)).collect();
    let ramp = MipMap::new(64, 64, texels, Wrap::Clamp);
    for (x, y) in [((0.05, 0.02), (0.0, 0.03)), ((0.01, 0.0), (0.1, 0.1))] {
        let value = color(&ramp, ELLIPSE, DVec2::splat(0.5), [x.into(), y.into()]).x;
        assert!((value - 31.5).abs() < 0.3, "{value}");
    }
}

/// A thin ellipse is widened: across, then, it covers more.
#[test]
fn anisotropy_is_limited() {
    let texels = (0..64 * 64).map(|i| Vec3::splat((i / 64 % 2) as f32)).collect();
    let stripes = MipMap::new(64, 64, texels, Wrap::Repeat);
    let at = |max_anisotropy| {
        let filter = ImageFilter::Ellipse { max_anisotropy };
        color(&stripes, filter, DVec2::new(0.5, 0.5078125), [DVec2::X * 0.9, DVec2::Y * 0.001]).x
    };
    assert!((at(4.0) - 0.5).abs() < 0.01 && (at(1e3) - 0.5).abs() > 0.1);
}
