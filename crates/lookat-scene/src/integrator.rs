//! `Integrator`: how light is computed.

use crate::params::Params;

/// The method that computes the light along camera rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// Light that comes straight from lights, or by way of mirrors and glass.
    DirectLighting {
        /// Which lights are sampled at each point.
        strategy: DirectStrategy,
        /// How many surfaces light is followed over (`maxdepth`, default 5).
        max_depth: u32,
    },
    /// Light over any surfaces, by path tracing. pbrt-v3's default.
    Path {
        /// How many surfaces light is followed over (`maxdepth`, default 5).
        max_depth: u32,
        /// Paths that carry less than this may end early (`rrthreshold`, default 1).
        roulette_threshold: f64,
        /// How a light is chosen (`lightsamplestrategy`).
        light_choice: LightChoice,
    },
    /// How much of the sky each point sees. White is pi, as in pbrt-v3.
    AmbientOcclusion {
        /// Rays follow the cosine to the normal, else are uniform (`cossample`, default true).
        cosine: bool,
        /// Rays per camera sample (`nsamples`, default 64).
        samples: u32,
    },
}

/// Which lights direct lighting samples at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DirectStrategy {
    /// Every light, as often as its `nsamples` says (`strategy` "all", the default).
    All,
    /// Every light once: `whitted`.
    EachOnce,
    /// One of them ("one").
    One,
}

/// How a path chooses the light that it samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightChoice {
    /// All alike.
    Uniform,
    /// By emitted power.
    Power,
    /// By the light that each would bring to the point, were nothing in the way. pbrt-v3's default.
    Spatial,
}

impl Integrator {
    /// What pbrt-v3 uses where there is no Integrator.
    pub(crate) const PBRT_DEFAULT: Integrator =
        Integrator::Path { max_depth: 5, roulette_threshold: 1.0, light_choice: LightChoice::Spatial };
}

pub(crate) const NAMES: &[&str] =
    &["path", "directlighting", "whitted", "ambientocclusion", "bdpt", "mlt", "sppm", "volpath"];

/// Whether in pbrt-v3 all rays of the integrator pass surfaces without a material, shadow rays too: it knows media, which
/// they bound.
pub(crate) fn passes_boundaries(kind: &str) -> bool {
    ["volpath", "bdpt", "mlt"].contains(&kind)
}

/// Whether `path` takes the place of the integrator. The light is the same, except for caustics of lights that no ray can hit.
pub(crate) fn is_substituted(kind: &str) -> bool {
    ["bdpt", "mlt", "sppm"].contains(&kind)
}

pub(crate) fn integrator(params: &mut Params) -> Option<Integrator> {
    let integrator = match params.kind() {
        "directlighting" => {
            let strategy = match params.choice("strategy", &["all", "one"]) {
                "one" => DirectStrategy::One,
                _ => DirectStrategy::All,
            };
            Integrator::DirectLighting { strategy, max_depth: depth(params) }
        }
        // The same light on average.
        "whitted" => {
            Integrator::DirectLighting { strategy: DirectStrategy::EachOnce, max_depth: depth(params) }
        }
        // Where space is empty they are the same.
        "path" | "volpath" => path(params),
        "ambientocclusion" => {
            let cosine = params.bool("cossample", true);
            let samples = params.nested_samples("nsamples", 64);
            if samples < 1 {
                params.reject("nsamples", "nsamples must be at least 1", None);
            }
            Integrator::AmbientOcclusion { cosine, samples: samples.max(1) as u32 }
        }
        kind if is_substituted(kind) => {
            let integrator = path(params);
            pixel_bounds(params);
            params.ignore_rest();
            integrator
        }
        _ => return params.unknown_kind(NAMES),
    };
    pixel_bounds(params);
    params.finish();
    Some(integrator)
}

fn pixel_bounds(params: &mut Params) {
    if params.given("pixelbounds") {
        params.integers("pixelbounds");
        params.warn(
            "pixelbounds",
            "pixelbounds is ignored",
            "use the Film's cropwindow to render a part of the picture",
        );
    }
}

fn path(params: &mut Params) -> Integrator {
    let roulette_threshold = params.float("rrthreshold", 1.0);
    let strategy = params.choice("lightsamplestrategy", &["spatial", "power", "uniform"]);
    let light_choice = match strategy {
        "uniform" => LightChoice::Uniform,
        "power" => LightChoice::Power,
        _ => LightChoice::Spatial,
    };
    Integrator::Path { max_depth: depth(params), roulette_threshold, light_choice }
}

fn depth(params: &mut Params) -> u32 {
    let depth = params.integer("maxdepth", 5);
    if depth < 0 {
        params.reject("maxdepth", "maxdepth must be at least 0", None);
    }
    if depth > MAX_DEPTH {
        params.note(
            "maxdepth",
            &format!("maxdepth counts as {MAX_DEPTH}"),
            "where light never ends, as among perfect mirrors, one sample would go on and on",
        );
    }
    depth.clamp(0, MAX_DEPTH) as u32
}

/// Of light that loses a thousandth at each surface, less is left then than `f32` can tell from nothing beside it.
const MAX_DEPTH: i32 = 20_000;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Overrides, load};

    /// How many primitives are left of one without a material, one without that glows, and one of matte.
    fn primitives(integrator: &str) -> usize {
        let text = format!(
            "Integrator \"{integrator}\" WorldBegin LightSource \"point\" Material \"none\" Shape \"sphere\"
            AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float radius\" 2 AttributeEnd
            Material \"matte\" Shape \"sphere\" \"float radius\" 3 WorldEnd"
        );
        let read = |_: &Path| Ok(text.clone().into_bytes());
        load(Path::new("a.pbrt"), &read, &Overrides::default()).scene.unwrap().primitives.len()
    }

    #[test]
    fn integrators_that_know_media_pass_what_bounds_them() {
        assert_eq!(["path", "directlighting", "sppm"].map(primitives), [3; 3]);
        assert_eq!(["volpath", "bdpt", "mlt"].map(primitives), [2; 3]);
    }
}
