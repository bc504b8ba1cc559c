//! `Integrator`: the light transport algorithm.

use crate::params::Params;

/// The light transport algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// Direct lighting, and specular reflection and transmission.
    DirectLighting {
        /// The lights sampled at each point.
        strategy: DirectStrategy,
        /// The maximum number of bounces (`maxdepth`, default 5).
        max_depth: u32,
    },
    /// Path tracing. The default of pbrt-v3.
    Path {
        /// The maximum number of bounces (`maxdepth`, default 5).
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
        /// Rays per camera sample (`nsamples`, default 64).
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
    pub(crate) const PBRT_DEFAULT: Integrator =
        Integrator::Path { max_depth: 5, roulette_threshold: 1.0, light_choice: LightChoice::Spatial };
}

pub(crate) const NAMES: &[&str] =
    &["path", "directlighting", "whitted", "ambientocclusion", "bdpt", "mlt", "sppm", "volpath"];

/// True if all rays of this integrator, including shadow rays, ignore surfaces without a material. Such surfaces are
/// the boundaries of media.
pub(crate) fn passes_boundaries(kind: &str) -> bool {
    ["volpath", "bdpt", "mlt"].contains(&kind)
}

/// True if `path` replaces this integrator. The picture is the same, except for caustics of lights that no ray can hit.
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
        // The expected value is the same.
        "whitted" => {
            Integrator::DirectLighting { strategy: DirectStrategy::EachOnce, max_depth: depth(params) }
        }
        // Without media, both integrators are equal.
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
            "to render a part of the picture, use cropwindow of Film",
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
            &format!("maxdepth is limited to {MAX_DEPTH}"),
            "between perfect mirrors, a path could continue forever",
        );
    }
    depth.clamp(0, MAX_DEPTH) as u32
}

/// The largest depth. Light that loses a thousandth at each bounce is below `f32` precision after this many bounces.
const MAX_DEPTH: i32 = 20_000;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Overrides, load};

    /// The number of primitives left of three: one without a material, one emissive without a material, and one matte.
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
