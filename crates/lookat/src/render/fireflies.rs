//! Fireflies: single pixels far brighter than all around, from one sample among thousands.

use lookat_image::{Image, luminance};
use lookat_render::{BrightestSample, PathEnd, Prepared, Settings};
use lookat_scene::syntax::Span;
use lookat_scene::{Film, Scene, Sources};

use crate::{interrupt, report};

/// With fewer samples, fireflies are usual, and more samples are what helps.
const LEAST_SAMPLES: u32 = 1024;
/// A firefly is more than so many times as bright as the brightest pixel around it.
const CONTRAST: f32 = 5.0;
/// The least share of its light from one sample.
const DOMINANT: f64 = 0.5;
/// The most pixels whose samples are taken again.
const MOST_TRACED: usize = 3;

/// A pixel that stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spot {
    /// Column and row in the full picture.
    place: [u32; 2],
    luminance: f32,
    /// The luminance of the brightest of its neighbors.
    around: f32,
}

/// The luminances of a picture that may have fireflies, before its tones are mapped. `samples`: the fewest of a pixel.
pub fn luminances(image: &Image, film: &Film, samples: u32) -> Option<Vec<f32>> {
    let may_have_some = samples >= LEAST_SAMPLES && film.max_sample_luminance.is_infinite();
    Some(image.rgb().filter(|_| may_have_some)?.into_iter().map(luminance).collect())
}

/// What to say about the fireflies among these luminances. Takes the samples of some pixels again.
pub fn remark(
    luminances: &[f32],
    (scene, prepared): (&Scene, &Prepared),
    settings: &Settings,
    sources: &Sources,
) -> Option<String> {
    let film = &scene.view.film;
    let spots = spots(luminances, film.crop.width() as usize, [film.crop.x0, film.crop.y0]);
    let (spot, sample) = spots.iter().take(MOST_TRACED).find_map(|spot| {
        let sample = prepared.brightest_sample(&scene.view, settings, spot.place, interrupt::flow)?;
        (sample.share >= DOMINANT).then_some((spot, sample))
    })?;
    // Far below the sample, and above all that other pixels show.
    let others = luminances.iter().filter(|luminance| luminance.is_finite() && **luminance != spot.luminance);
    let usual = others.copied().fold(10.0 * spot.around, f32::max);
    // No limit can be told from black pixels.
    if usual <= 0.0 {
        return None;
    }
    let [x, y] = spot.place;
    let others = match spots.len() - 1 {
        0 => String::new(),
        1 => "; 1 other pixel stands out as much".into(),
        count => format!("; {count} other pixels stand out as much"),
    };
    let percent = (100.0 * sample.share).floor();
    let found = format!(
        "pixel {x}, {y} is a firefly: 1 of its {} samples gives {percent} % of its light{others}",
        sample.samples
    );
    let limit = limit(f64::from(usual) / film.scale);
    let advice = format!(
        "to limit fireflies, write \"float maxsampleluminance\" {limit} in Film; the picture loses the light above it"
    );
    Some(format!("{found}\nits path: {}\n{advice}", path(&sample, sources)))
}

/// The pixels that stand out, the most striking ones first.
fn spots(luminances: &[f32], width: usize, [x0, y0]: [u32; 2]) -> Vec<Spot> {
    let height = luminances.len() / width;
    let around = |x: usize, y: usize| {
        let near = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let all = near(y, height).flat_map(|row| near(x, width).map(move |column| (column, row)));
        all.filter(|at| *at != (x, y)).map(|(x, y)| luminances[y * width + x]).fold(0.0, f32::max)
    };
    let mut found: Vec<Spot> = Vec::new();
    for (at, luminance) in
        luminances.iter().copied().enumerate().filter(|(_, it)| it.is_finite() && *it > 0.0)
    {
        let (x, y) = (at % width, at / width);
        let around = around(x, y);
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
        Some(span) => format!("{} at {}", report::word(span, sources), report::place(span, sources)),
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

    use lookat_render::render;
    use lookat_scene::load_str;

    use super::*;

    /// What is said about a scene of 8 x 8 pixels with so many samples.
    fn said(samples: u32, world: &str) -> Option<String> {
        let loaded = load_str(&format!(
            "LookAt 0 4 -8 0 0.5 0 0 1 0 Camera \"perspective\" \"float fov\" 30 Film \"image\" \"integer xresolution\" 8
            \"integer yresolution\" 8 Sampler \"random\" \"integer pixelsamples\" {samples} Integrator \"path\" WorldBegin
            Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [-9 0 -9 9 0 -9 9 0 9 -9 0 9]
            {world} WorldEnd"
        ));
        let scene = loaded.scene.as_ref().unwrap();
        let settings = Settings::default();
        let rendered = render(scene, &settings, &|_| ControlFlow::Continue(()));
        let prepared = Prepared::new(scene);
        let luminances = luminances(&rendered.image, &scene.view.film, samples)?;
        remark(&luminances, (scene, &prepared), &settings, &loaded.sources)
    }

    /// A lamp in a glass bulb: paths find it by chance alone.
    const BULB: &str = "AttributeBegin Translate 0 3 0 AttributeBegin Material \"glass\" Shape \"sphere\" \"float radius\" 0.3
        AttributeEnd AreaLightSource \"diffuse\" \"rgb L\" [1e4 1e4 1e4] Shape \"sphere\" \"float radius\" 0.02 AttributeEnd
        LightSource \"infinite\" \"rgb L\" [.1 .1 .1]";

    #[test]
    fn a_firefly_is_named_with_its_path() {
        let text = said(1024, BULB).unwrap();
        assert!(text.contains("is a firefly: 1 of its 1024 samples gives"), "{text}");
        assert!(text.contains("sphere") && text.contains("to the light of"), "{text}");
        assert!(text.contains("\"float maxsampleluminance\""), "{text}");
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
            assert_eq!(said(1024, world), None, "{world}");
        }
        // Few samples have noise.
        assert_eq!(said(1023, BULB), None);
    }

    #[test]
    fn limits_have_two_digits() {
        assert_eq!([0.0123, 1.0, 99.1, 1234.0].map(limit), [0.013, 1.0, 100.0, 1300.0]);
    }

    #[test]
    fn spots_stand_out_from_all_around() {
        let mut luminances = vec![1.0; 12];
        luminances[5] = 6.0;
        assert_eq!(spots(&luminances, 4, [10, 20]), [Spot { place: [11, 21], luminance: 6.0, around: 1.0 }]);
        luminances[10] = 2.0;
        assert_eq!(spots(&luminances, 4, [10, 20]), []);
    }
}
