//! Samples and splats on a film.

use super::*;
use crate::render::Settings;
use crate::render::Stop;
use crate::render::render;
use crate::testing::scene;
use rayon::prelude::*;
use std::ops::ControlFlow;

/// A crop window has the pixels of the whole, of any filter, with and without layers of its errors.
#[test]
fn crops_equal_the_whole() {
    let render = |filter: &str, crop: &str, stop: Stop| {
        let scene = scene(&format!(
            "LookAt 0 0 -4 0 0 0 0 1 0 Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32 {crop}
            Camera \"perspective\" Sampler \"sobol\" \"integer pixelsamples\" 20 PixelFilter {filter}
            Integrator \"path\" WorldBegin LightSource \"infinite\" \"rgb L\" [.5 1 2]
            AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" .3 WorldEnd"
        ));
        let settings = Settings { stop, ..Settings::default() };
        render(&scene, &settings, &|_| ControlFlow::Continue(())).image
    };
    for filter in [
        "\"box\"",
        "\"gaussian\"",
        "\"mitchell\" \"float xwidth\" 1.2",
        "\"sinc\"",
        "\"box\" \"float ywidth\" 7",
    ] {
        for error_layers in [false, true] {
            let stop = Stop::Samples { error_layers };
            let whole = render(filter, "", stop);
            let part = render(filter, "\"float cropwindow\" [.25 .75 .5 1]", stop);
            for (whole, part) in whole.channels.iter().zip(&part.channels) {
                let rows = whole.samples.chunks(48).skip(16).map(|row| &row[12..36]);
                assert!(rows.eq(part.samples.chunks(24)), "{filter} {}", whole.name);
            }
        }
    }
}

/// One sample lights the pixels that its filter reaches, by their weights; a flat picture stays flat.
#[test]
fn pixels_are_ratios_of_weighted_sums() {
    let scene = scene(
        "Film \"image\" \"integer xresolution\" 9 \"integer yresolution\" 9 Camera \"perspective\"
        PixelFilter \"mitchell\" WorldBegin Shape \"sphere\" WorldEnd",
    );
    let film = Film::new(&scene.view, Keeps::Sums, false);
    // Samples of a flat picture everywhere, and a bright one.
    let bright = ([4, 5], DVec2::new(0.9, 0.3));
    let places: Vec<([i32; 2], DVec2, f64)> = film
        .sources()
        .pixels()
        .map(|source| (source, DVec2::new(0.25, 0.5), 3.0))
        .chain([(bright.0, bright.1, 100.0)])
        .collect();
    let mut block = ImageBlock::default();
    block.restart(&film, film.sources());
    for (source, place, value) in &places {
        block.add(&film.filter, *source, *place, film.scale().units(DVec3::splat(*value).extend(1.0)));
    }
    film.add(&mut block, &film.adding());
    let image = film.develop(false).rgb().unwrap();
    for (pixel, found) in film.crop().pixels().zip(image) {
        let mut sum = [0.0; 2];
        for ([x, y], square, value) in &places {
            let off = [f64::from(pixel[0] - x) + 0.5 - square.x, f64::from(pixel[1] - y) + 0.5 - square.y];
            let mitchell = |x: f64| match x.abs() {
                x if x < 1.0 => 7.0 * x.powi(3) - 12.0 * x * x + 16.0 / 3.0,
                x if x < 2.0 => -7.0 / 3.0 * x.powi(3) + 12.0 * x * x - 20.0 * x + 32.0 / 3.0,
                _ => 0.0,
            };
            let weight = mitchell(off[0]) * mitchell(off[1]);
            sum = [sum[0] + weight * value, sum[1] + weight];
        }
        let expected = (sum[0] / sum[1]).max(0.0) as f32;
        assert!((found[0] - expected).abs() < 1e-5 * expected.max(1.0), "{pixel:?}: {found:?} {expected}");
        let is_far = pixel[0].abs_diff(4) > 2 || pixel[1].abs_diff(5) > 2;
        assert!(!is_far || found == [3.0; 3], "{pixel:?}");
    }
}

/// From several threads at once: each splat brings its value, in the mean over its places, and the bits do not depend on the order.
#[test]
fn splats_keep_their_energy() {
    for filter in ["box", "triangle", "gaussian", "mitchell", "sinc"] {
        let scene = scene(&format!(
            "Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 40 Camera \"perspective\"
            PixelFilter \"{filter}\" WorldBegin Shape \"sphere\" WorldEnd"
        ));
        // Over all places in a pixel, in the middle of the picture.
        let at = |step: i32, of: i32| f64::from(19) + (f64::from(step) + 0.5) / f64::from(of);
        let places: Vec<DVec2> =
            (0..32).flat_map(|y| (0..32).map(move |x| DVec2::new(at(x, 32), at(y, 32)))).collect();
        let sums = [false, true].map(|is_reversed| {
            let film = Film::new(&scene.view, Keeps::Sums, false);
            let splat = |place: &DVec2| assert!(film.add_splat(*place, Vec3::new(1.0, 1e-5, 3e4)));
            match is_reversed {
                false => places.par_iter().for_each(splat),
                true => places.iter().rev().for_each(splat),
            }
            film.add_light_paths(places.len() as u64);
            film.sums()
        });
        assert_eq!(sums[0], sums[1]);
        let image = sums[0].image(true);
        let total =
            |channel: usize| image.channels[channel].samples.iter().copied().map(f64::from).sum::<f64>();
        // What is below black is written as black.
        let is_signed = matches!(filter, "mitchell" | "sinc");
        for (channel, expected) in [1.0, 1e-5, 3e4].into_iter().enumerate() {
            let ratio = total(channel) / expected;
            let most = if is_signed { 1.3 } else { 1.0 + 1e-5 };
            assert!(ratio > 1.0 - 1e-5 && ratio < most, "{filter}: {ratio}");
        }
    }
}

/// Splats join the samples of the picture, at its edges too, and bad ones are refused.
#[test]
fn splats_join_samples() {
    let scene = scene(
        "Film \"image\" \"integer xresolution\" 8 \"integer yresolution\" 8 Camera \"perspective\"
        PixelFilter \"box\" WorldBegin Shape \"sphere\" WorldEnd",
    );
    let film = Film::new(&scene.view, Keeps::Sums, false);
    let mut block = ImageBlock::default();
    block.restart(&film, film.sources());
    block.add(&film.filter, [3, 4], DVec2::splat(0.5), film.scale().units(DVec3::splat(2.0).extend(1.0)));
    film.add(&mut block, &film.adding());
    assert!(film.add_splat(DVec2::new(3.2, 4.9), Vec3::splat(6.0)));
    for far in [1e9, 1e10, -1e10, 1e300] {
        assert!(film.add_splat(DVec2::new(-0.1, far), Vec3::splat(6.0)));
    }
    assert!(!film.add_splat(DVec2::new(3.2, 4.9), Vec3::NAN));
    assert!(!film.add_splat(DVec2::new(f64::INFINITY, 4.9), Vec3::ONE));
    film.add_light_paths(4);
    let image = film.develop(false).rgb().unwrap();
    assert_eq!(image[4 * 8 + 3], [3.5; 3]);
    assert_eq!(image.iter().filter(|pixel| **pixel != [0.0; 3]).count(), 1);
}
