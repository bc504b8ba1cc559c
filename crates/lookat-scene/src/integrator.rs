//! `Integrator`: the light transport algorithm.

use lookat_syntax::ParamType;

use crate::params::Params;
use crate::params::value::Integers;
use crate::schema::{Key, Keys, Kind, Range};

/// The light transport algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// Direct lighting, and specular reflection and transmission.
    DirectLighting {
        /// The lights sampled at each point.
        strategy: DirectStrategy,
        /// The maximum number of bounces, at most 20,000 (`maxdepth`, default 5).
        max_depth: u32,
    },
    /// Path tracing. The default of pbrt-v3.
    Path {
        /// The maximum number of bounces, at most 20,000 (`maxdepth`, default 5).
        max_depth: u32,
        /// The Russian roulette threshold of the path throughput (`rrthreshold`, default 1).
        roulette_threshold: f64,
        /// The light sampler (`lightsamplestrategy`).
        light_choice: LightChoice,
    },
    /// Ambient occlusion. An open sky gives pi, as in pbrt-v3.
    AmbientOcclusion {
        /// If true, rays are cosine-distributed; if false, uniform (`cossample`, default true).
        cosine: bool,
        /// Rays per camera sample, from 1 to 65,536 (`nsamples`, default 64).
        samples: u32,
    },
}

/// The lights that direct lighting samples at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectStrategy {
    /// Every light, with its `nsamples` (`strategy` "all", the default).
    All,
    /// Every light once: `whitted`.
    EachOnce,
    /// One random light ("one").
    One,
}

/// The light sampler of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightChoice {
    /// Equal probabilities.
    Uniform,
    /// Proportional to emitted power.
    Power,
    /// Proportional to the unoccluded light at the point. The default of pbrt-v3.
    Spatial,
}

impl Integrator {
    /// The integrator of pbrt-v3 without an Integrator directive.
    pub(crate) const PBRT_DEFAULT: Integrator = Integrator::path(5);

    const fn path(max_depth: u32) -> Integrator {
        Integrator::Path { max_depth, roulette_threshold: 1.0, light_choice: LightChoice::Spatial }
    }
}

const MAX_DEPTH: Key<i32> =
    Key::integer("maxdepth", 5, "the largest number of surfaces of a path; over 20000 counts as 20000")
        .within(Range::at_least(0.0));
const MIRROR_DEPTH: Key<i32> = Key {
    meaning: "the largest number of surfaces along mirrors and glass, including the first; 0 counts as 1, over 20000 as 20000",
    ..MAX_DEPTH
};
/// Light that loses a thousandth at each bounce is below `f32` precision after as many bounces.
pub(crate) const LARGEST_DEPTH: i32 = 20_000;
const ROULETTE: Key<f64> =
    Key::float("rrthreshold", 1.0, "the throughput below which Russian roulette may end a path");
const LIGHT_STRATEGY: Key<&[&str]> = Key::choice(
    "lightsamplestrategy",
    &["spatial", "power", "uniform"],
    "how a light is chosen: by its light at the point, by its power, or with equal probability",
);
const DIRECT_STRATEGY: Key<&[&str]> =
    Key::choice("strategy", &["all", "one"], "whether each surface samples all lights or one");
const COSINE: Key<bool> =
    Key::bool("cossample", true, "true samples directions by their cosine, false uniformly");
const NESTED: Key<i32> =
    Key::integer("nsamples", 64, "the directions at each surface; over 65536 counts as 65536")
        .within(Range::at_least(1.0));
const PIXEL_BOUNDS: Key<Integers> =
    Key::new("pixelbounds", ParamType::Integer, Integers, "the pixels to render: xmin xmax ymin ymax")
        .default_words("all pixels")
        .not_rendered();

const PATH: Keys = &[&MAX_DEPTH, &ROULETTE, &LIGHT_STRATEGY, &PIXEL_BOUNDS];

pub(crate) const KINDS: &[Kind] = &[
    Kind::new("path", "path tracing", &[PATH]).by_default(),
    Kind::new("volpath", "path tracing in participating media", &[PATH]),
    Kind::new(
        "directlighting",
        "direct light, mirrors and glass",
        &[&[&MIRROR_DEPTH, &DIRECT_STRATEGY, &PIXEL_BOUNDS]],
    ),
    Kind::new(
        "whitted",
        "direct light with one sample of each light, mirrors and glass",
        &[&[&MIRROR_DEPTH, &PIXEL_BOUNDS]],
    ),
    Kind::new(
        "ambientocclusion",
        "the fraction of the sky that is visible",
        &[&[&COSINE, &NESTED, &PIXEL_BOUNDS]],
    ),
    BDPT,
    MLT,
    SPPM,
];

/// True if all rays of this integrator, including shadow rays, ignore surfaces without a material. Such surfaces are
/// the boundaries of media.
pub(crate) fn passes_boundaries(kind: &str) -> bool {
    ["volpath", "bdpt", "mlt"].contains(&kind)
}

/// True if `path` replaces this integrator.
pub(crate) fn is_replaced(kind: &str) -> bool {
    KINDS.iter().any(|it| it.name == kind && !it.instead.is_empty())
}

pub(crate) fn integrator(params: &mut Params) -> Option<Integrator> {
    let integrator = match params.kind() {
        "directlighting" => {
            let strategy = match params.take(&DIRECT_STRATEGY) {
                "one" => DirectStrategy::One,
                _ => DirectStrategy::All,
            };
            Integrator::DirectLighting { strategy, max_depth: depth(params) }
        }
        // The expected value is the same.
        "whitted" => {
            Integrator::DirectLighting { strategy: DirectStrategy::EachOnce, max_depth: depth(params) }
        }
        // Without media, both integrators are equal.
        "path" | "volpath" => path(params),
        "ambientocclusion" => {
            let cosine = params.take(&COSINE);
            let samples = params.nested_samples(&NESTED) as u32;
            Integrator::AmbientOcclusion { cosine, samples }
        }
        kind if is_replaced(kind) => {
            let integrator = Integrator::path(depth(params));
            pixel_bounds(params);
            params.ignore_rest();
            integrator
        }
        _ => return params.reject_unknown_type(KINDS),
    };
    pixel_bounds(params);
    params.finish();
    Some(integrator)
}

fn pixel_bounds(params: &mut Params) {
    if params.given("pixelbounds") {
        params.take(&PIXEL_BOUNDS);
        params.warn(
            "pixelbounds",
            "pixelbounds is ignored",
            "to render a part of the picture, use cropwindow of Film",
        );
    }
}

fn path(params: &mut Params) -> Integrator {
    let roulette_threshold = params.take(&ROULETTE);
    let strategy = params.take(&LIGHT_STRATEGY);
    let light_choice = match strategy {
        "uniform" => LightChoice::Uniform,
        "power" => LightChoice::Power,
        _ => LightChoice::Spatial,
    };
    Integrator::Path { max_depth: depth(params), roulette_threshold, light_choice }
}

fn depth(params: &mut Params) -> u32 {
    let depth = params.take(&MAX_DEPTH);
    if depth > LARGEST_DEPTH {
        params.note(
            "maxdepth",
            &format!("maxdepth is limited to {LARGEST_DEPTH}"),
            "between perfect mirrors, a path could continue forever",
        );
    }
    depth.min(LARGEST_DEPTH) as u32
}

// `bdpt`, `mlt` and `sppm`: `path` stands in for them. The picture is the same, except for caustics of lights that no ray can
// hit.

const BDPT_IGNORED: Keys = &[
    &Key::choice("lightsamplestrategy", &["power", "spatial", "uniform"], "how a path chooses its light"),
    &Key::bool("visualizestrategies", false, "true also writes a picture of each strategy"),
    &Key::bool("visualizeweights", false, "true also writes a picture of the weights of each strategy"),
    &PIXEL_BOUNDS,
];

const MLT_IGNORED: Keys = &[
    &Key::integer("bootstrapsamples", 100_000, "the paths among which the chains choose their starts"),
    &Key::integer("chains", 1000, "the number of Markov chains"),
    &Key::integer("mutationsperpixel", 100, "the mutations of paths in each pixel, on average"),
    &Key::float("largestepprobability", 0.3, "the probability that a mutation is a new path"),
    &Key::float("sigma", 0.01, "the standard deviation of a small mutation, as a fraction of a dimension"),
];

const ITERATIONS: Key<i32> = Key::integer("numiterations", 64, "the number of photon passes");
const SAME_ITERATIONS: Key<i32> =
    Key { name: "iterations", meaning: "another name of numiterations, which it replaces", ..ITERATIONS }
        .default_words("numiterations");
const SPPM_IGNORED: Keys = &[
    &ITERATIONS,
    &SAME_ITERATIONS,
    &Key::integer("photonsperiteration", -1, "the photons of a pass; at most 0 counts as one per pixel"),
    &Key::integer("imagewritefrequency", i32::MAX, "the passes after which the picture is written")
        .default_words("only at the end"),
    &Key::float("radius", 1.0, "the first radius of the search for photons"),
];

const BDPT: Kind = Kind::new("bdpt", "bidirectional path tracing", &[&[&MAX_DEPTH]])
    .ignoring(&[BDPT_IGNORED])
    .instead("path");
const MLT: Kind =
    Kind::new("mlt", "Metropolis light transport", &[&[&MAX_DEPTH]]).ignoring(&[MLT_IGNORED]).instead("path");
const SPPM: Kind =
    Kind::new("sppm", "photon mapping", &[&[&MAX_DEPTH]]).ignoring(&[SPPM_IGNORED]).instead("path");

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{LoadOptions, load};

    /// The number of primitives left of three: one without a material, one emissive without a material, and one matte.
    fn primitives(integrator: &str) -> usize {
        let text = format!(
            "Integrator \"{integrator}\" WorldBegin LightSource \"point\" Material \"none\" Shape \"sphere\"
            AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" 2 AttributeEnd
            Material \"matte\" Shape \"sphere\" \"float radius\" 3 WorldEnd"
        );
        let read = |_: &Path| Ok(text.clone().into_bytes());
        load(Path::new("a.pbrt"), &read, &LoadOptions::default()).scene.unwrap().world.primitives.len()
    }

    #[test]
    fn integrators_that_know_media_pass_what_bounds_them() {
        assert_eq!(["path", "directlighting", "sppm"].map(primitives), [3; 3]);
        assert_eq!(["volpath", "bdpt", "mlt"].map(primitives), [2; 3]);
    }

    /// The parameters of pbrt-v3's CreateBDPTIntegrator, CreateMLTIntegrator and CreateSPPMIntegrator, with their defaults.
    #[test]
    fn parameters_of_replaced_integrators_are_those_of_pbrt() {
        let listed = [BDPT, MLT, SPPM].map(|kind| {
            let words: Vec<String> =
                kind.parameters().map(|it| format!("{} {}", it.name, it.default)).collect();
            words.join(", ")
        });
        assert_eq!(
            listed,
            [
                "maxdepth 5, lightsamplestrategy \"power\", visualizestrategies false, visualizeweights false, \
                 pixelbounds all pixels",
                "maxdepth 5, bootstrapsamples 100000, chains 1000, mutationsperpixel 100, largestepprobability 0.3, \
                 sigma 0.01",
                "maxdepth 5, numiterations 64, iterations numiterations, photonsperiteration -1, \
                 imagewritefrequency only at the end, radius 1",
            ]
        );
    }

    #[test]
    fn replaced_integrators_read_maxdepth_alone() {
        let text = |kind: &str| {
            format!(
                "Integrator \"{kind}\" \"integer maxdepth\" 3 \"string lightsamplestrategy\" \"uniform\"
                \"float rrthreshold\" .5 WorldBegin LightSource \"point\" Shape \"sphere\" WorldEnd"
            )
        };
        for kind in ["bdpt", "mlt", "sppm"] {
            let integrator = crate::load_str(&text(kind)).scene.unwrap().view.integrator;
            assert_eq!(integrator, Integrator::path(3), "{kind}");
        }
    }
}
