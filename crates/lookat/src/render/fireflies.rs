//! Fireflies: single pixels far brighter than all around, from one sample among thousands.

use lookat_image::{Image, luminance};
use lookat_render::{BrightestSample, PathEnd, Prepared, Settings};
use lookat_scene::syntax::Span;
use lookat_scene::{Film, Scene, Sources};
use serde::Serialize;

use crate::readable::{percent, plural};
use crate::{interrupt, report};

/// With fewer samples, fireflies are usual, and more samples are what helps.
const LEAST_SAMPLES: u32 = 1024;
/// A firefly is more than so many times as bright as the brightest pixel around it.
const CONTRAST: f32 = 5.0;
/// The least share of its light from one sample.
const DOMINANT: f64 = 0.5;
/// The most fireflies whose samples are taken again, and the most other pixels.
const MOST_TRACED: usize = 3;
const MOST_MEASURED: usize = 32;
/// A limit that takes this share of the light or more is no advice.
const MUCH: f64 = 0.05;

/// A pixel that stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spot {
    /// Column and row in the full picture.
    place: [u32; 2],
    luminance: f32,
    /// The luminance of the brightest pixel around it that has none of its samples.
    around: f32,
}

/// The luminances of a picture that may have fireflies, before its tones are mapped. `samples`: the fewest of a pixel.
pub fn luminances(image: &Image, film: &Film, samples: u32) -> Option<Vec<f32>> {
    let may_have_some = samples >= LEAST_SAMPLES && film.max_sample_luminance.is_infinite();
    Some(image.rgb().filter(|_| may_have_some)?.into_iter().map(luminance).collect())
}

/// What fireflies a picture has.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fireflies {
    /// Number of fireflies.
    pixels: usize,
    /// Column and row of one such pixel.
    pixel: [u32; 2],
    /// Its samples.
    samples: u32,
    /// Share of its light from the brightest sample.
    share: f64,
    /// Path of the brightest sample, in words.
    path: String,
    /// A limit for `maxsampleluminance`.
    limit: f64,
    /// Fraction of the picture's light that this limit removes.
    loss: f64,
}

impl Fireflies {
    /// The fireflies among these luminances. Takes the samples of some pixels again.
    pub fn find(
        luminances: &[f32],
        scene: &Scene,
        prepared: &Prepared,
        settings: &Settings,
        sources: &Sources,
    ) -> Option<Fireflies> {
        let film = &scene.view.film;
        let spots = spots(
            luminances,
            film.crop.width() as usize,
            [film.crop.x0, film.crop.y0],
            scene.view.filter.reach(),
        );
        let brightest = |pixel, limit| {
            prepared.brightest_sample(&scene.view, settings, pixel, limit / film.scale, interrupt::flow)
        };
        let (spot, limit, sample) = spots.iter().take(MOST_TRACED).find_map(|spot| {
            let limit = limit(usual(luminances, spot)?);
            let sample = brightest(spot.place, limit)?;
            (sample.share >= DOMINANT).then_some((spot, limit, sample))
        })?;
        // What fireflies have in excess, or what the limit takes of pixels here and there: light that all pixels get so has no spots.
        let sum = |values: &mut dyn Iterator<Item = f32>| values.map(f64::from).sum::<f64>();
        let all = sum(&mut luminances.iter().copied().filter(|it| it.is_finite()));
        let excess = sum(&mut spots.iter().map(|spot| spot.luminance - spot.around)) / all;
        let place = |at: u32| [film.crop.x0 + at % film.crop.width(), film.crop.y0 + at / film.crop.width()];
        let apart = luminances.len() / MOST_MEASURED + 1;
        let places = (0..luminances.len() as u32).skip(apart / 2).step_by(apart).map(place);
        let others: Vec<_> = places.filter_map(|pixel| brightest(pixel, limit)).collect();
        let of_others = |value: fn(&BrightestSample) -> f64| others.iter().map(value).sum::<f64>();
        let measured = of_others(|it| it.loss) / of_others(|it| it.sum).max(f64::MIN_POSITIVE);
        Some(Fireflies {
            pixels: spots.len(),
            pixel: spot.place,
            samples: sample.samples,
            share: sample.share,
            path: path(&sample, sources),
            limit: limit / film.scale,
            loss: excess.max(measured),
        })
    }

    /// What to say about them, in lines.
    pub fn lines(&self) -> [String; 3] {
        let Fireflies { pixels, pixel: [x, y], samples, share, path, limit, loss } = self;
        let others = match *pixels as u64 - 1 {
            0 => String::new(),
            count => format!("; {} out", plural(count, "other pixel stands", "other pixels stand")),
        };
        let advice = if *loss >= MUCH {
            format!(
                "about {} of the picture's light comes from such samples: take more samples, or use a larger light",
                percent(*loss, 1)
            )
        } else {
            format!(
                "to limit fireflies, write \"float maxsampleluminance\" {limit} in Film; the picture loses about {} of its light",
                percent(*loss, 1)
            )
        };
        let share = (100.0 * share).floor();
        let found = format!(
            "pixel {x}, {y} is a firefly: 1 of its {samples} samples gives {share} % of its light{others}"
        );
        [found, format!("its path: {path}"), advice]
    }
}

/// What samples usually have at most: far below those of fireflies, and above all that other pixels show. `None` among black pixels, which
/// tell no limit.
fn usual(luminances: &[f32], spot: &Spot) -> Option<f64> {
    let others = luminances.iter().filter(|luminance| luminance.is_finite() && **luminance != spot.luminance);
    let usual = others.copied().fold(10.0 * spot.around, f32::max);
    (usual > 0.0).then_some(f64::from(usual))
}

/// The pixels that stand out from all beyond the reach of their samples, the most striking ones first.
fn spots(luminances: &[f32], width: usize, [x0, y0]: [u32; 2], reach: [u32; 2]) -> Vec<Spot> {
    let height = luminances.len() / width;
    // The brightest up to so many pixels away, but not nearer than `from`.
    let brightest = |x: usize, y: usize, from: [usize; 2], to: [usize; 2]| {
        let near = |at: usize, to: usize, end: usize| at.saturating_sub(to)..(at + to + 1).min(end);
        let all =
            near(y, to[1], height).flat_map(|row| near(x, to[0], width).map(move |column| (column, row)));
        let is_far =
            |(column, row): &(usize, usize)| column.abs_diff(x) >= from[0] || row.abs_diff(y) >= from[1];
        all.filter(is_far).map(|(x, y)| luminances[y * width + x]).fold(0.0, f32::max)
    };
    let reach = reach.map(|reach| reach as usize);
    let beyond = reach.map(|reach| reach + 1);
    let mut found: Vec<Spot> = Vec::new();
    for (at, luminance) in
        luminances.iter().copied().enumerate().filter(|(_, it)| it.is_finite() && *it > 0.0)
    {
        let (x, y) = (at % width, at / width);
        // A sample counts most for the pixel that it lies in.
        if luminance < brightest(x, y, [1, 1], reach) {
            continue;
        }
        let around = brightest(x, y, beyond, beyond);
        if luminance > CONTRAST * around {
            found.push(Spot { place: [x0 + x as u32, y0 + y as u32], luminance, around });
        }
    }
    found.sort_by(|a, b| (b.luminance - b.around).total_cmp(&(a.luminance - a.around)));
    found
}

/// The path of a sample, in words.
fn path(sample: &BrightestSample, sources: &Sources) -> String {
    let name = |span: Option<Span>| match span {
        Some(span) => format!("{} at {}", sources.word(span), report::place(span, sources)),
        None => "a shape".into(),
    };
    let surfaces: Vec<String> = sample.surfaces.iter().map(|span| name(*span)).collect();
    let end = match sample.end {
        PathEnd::Shape(span) => format!("to the light of {}", name(span)),
        PathEnd::Sky => "to an infinite light".into(),
        PathEnd::Sampled => "to a light".into(),
    };
    format!("{}, {end}", surfaces.join(", "))
}

/// A limit with two digits that is not smaller.
fn limit(luminance: f64) -> f64 {
    let unit = 10_f64.powf(luminance.log10().floor() - 1.0);
    let rounded = (luminance / unit).ceil() * unit;
    format!("{rounded:.1e}").parse().unwrap_or(luminance)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use lookat_render::render;
    use lookat_scene::load_str;

    /// What is said about a scene of so many pixels on each side, with so many samples each.
    fn said((side, samples): (u32, u32), world: &str) -> Option<String> {
        let loaded = load_str(&format!(
            "LookAt 0 4 -8 0 0.5 0 0 1 0 Camera \"perspective\" \"float fov\" 30 Film \"image\" \"integer xresolution\" {side}
            \"integer yresolution\" {side} Sampler \"random\" \"integer pixelsamples\" {samples} Integrator \"path\" WorldBegin
            Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9]
            {world} WorldEnd"
        ));
        let scene = loaded.scene.as_ref().unwrap();
        let settings = Settings::default();
        let rendered = render(scene, &settings, &|_| ControlFlow::Continue(()));
        let prepared = Prepared::new(scene);
        let luminances = luminances(&rendered.image, &scene.view.film, samples)?;
        let found = Fireflies::find(&luminances, scene, &prepared, &settings, &loaded.sources)?;
        Some(found.lines().join("\n"))
    }

    /// A lamp in a glass bulb: paths find it by chance alone.
    const BULB: &str = "AttributeBegin Translate 0 3 0 AttributeBegin Material \"glass\" Shape \"sphere\" \"float radius\" 0.3
        AttributeEnd AreaLightSource \"diffuse\" \"rgb L\" [1e4 1e4 1e4] Shape \"sphere\" \"float radius\" 0.02 AttributeEnd
        LightSource \"infinite\" \"rgb L\" [.1 .1 .1]";

    #[test]
    fn a_firefly_is_named_with_its_path() {
        let text = said((8, 1024), BULB).unwrap();
        assert!(text.contains("is a firefly: 1 of its 1024 samples gives"), "{text}");
        assert!(text.contains("sphere") && text.contains("to the light of"), "{text}");
        // Most of the light of this picture comes so.
        assert!(text.contains("take more samples") && !text.contains("maxsampleluminance"), "{text}");
    }

    #[test]
    fn a_limit_is_advised_where_it_takes_little() {
        let bulb =
            BULB.replace("[1e4 1e4 1e4]", "[4e3 4e3 4e3]").replace("0.02 AttributeEnd", "0.004 AttributeEnd");
        let text = said((40, 1024), &bulb).unwrap();
        assert!(text.contains("write \"float maxsampleluminance\""), "{text}");
    }

    #[test]
    fn usual_scenes_have_none() {
        let lamp = "AttributeBegin Translate 1 3 0 AreaLightSource \"diffuse\" \"rgb L\" [50 50 50]
            Shape \"sphere\" \"float radius\" 0.2 AttributeEnd Translate 0 1 0 Shape \"sphere\"";
        // A lamp in view that fills less than a pixel is seen by many samples.
        let small = "Translate 0 1 -2 AreaLightSource \"diffuse\" \"rgb L\" [1e5 1e5 1e5]
            Shape \"sphere\" \"float radius\" 0.03";
        for world in
            [lamp, small, "LightSource \"point\" \"point from\" [0 3 0] Translate 0 1 0 Shape \"sphere\""]
        {
            assert_eq!(said((8, 1024), world), None, "{world}");
        }
        // Few samples have noise.
        assert_eq!(said((8, 1023), BULB), None);
    }

    #[test]
    fn limits_have_two_digits() {
        assert_eq!([0.0123, 1.0, 99.1, 1234.0].map(limit), [0.013, 1.0, 100.0, 1300.0]);
    }

    #[test]
    fn spots_stand_out_from_all_around() {
        let mut luminances = vec![1.0; 12];
        luminances[5] = 6.0;
        assert_eq!(
            spots(&luminances, 4, [10, 20], [0, 0]),
            [Spot { place: [11, 21], luminance: 6.0, around: 1.0 }]
        );
        luminances[10] = 2.0;
        assert_eq!(spots(&luminances, 4, [10, 20], [0, 0]), []);
        // A filter of several pixels gives the sample to neighbors, too.
        let mut luminances = vec![1.0; 49];
        (luminances[24], luminances[25], luminances[17]) = (6.0, 4.0, 2.0);
        let spot = Spot { place: [3, 3], luminance: 6.0, around: 1.0 };
        assert_eq!(spots(&luminances, 7, [0, 0], [1, 1]), [spot]);
        luminances[26] = 2.0;
        assert_eq!(spots(&luminances, 7, [0, 0], [1, 1]), []);
    }
}
